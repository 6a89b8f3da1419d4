//! Doubts about the shape of a repaired mesh, which may be closed and clean and yet another body.

use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Why the shape of a repaired mesh is doubtful: too much of the input was cut out, or the solids differ.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ShapeDoubt {
    /// Fraction of the input's area that was cut out. Faces inside other bodies, doubled faces, and components removed on request
    /// do not count.
    pub lost: f64,
    /// Where it was lost; none if it is too little to matter.
    pub lost_at: Option<DVec3>,
    /// The volume common to the solids that input and result mean, over the volume of both together. The input's solid is where
    /// its winding number exceeds one half; points near holes do not count.
    pub agreement: f64,
    /// A point in only one of the solids; none if they agree.
    pub differs_at: Option<DVec3>,
}

impl ShapeDoubt {
    /// The doubt in words.
    pub fn text(&self) -> String {
        let percent = |x: f64| format!("{:.1} %", 100.0 * x);
        let place = |p: DVec3| format!("({:.4}, {:.4}, {:.4})", p.x, p.y, p.z);
        let mut parts = Vec::new();
        if let Some(at) = self.lost_at {
            let lost = percent(self.lost);
            parts.push(format!(
                "{lost} of the input's area was cut out, around {}",
                place(at)
            ));
        }
        if let Some(at) = self.differs_at {
            let differs = percent(1.0 - self.agreement);
            parts.push(format!(
                "{differs} of the volume differs from the solid that the input means, as at {}",
                place(at)
            ));
        }
        parts.join(", and ")
    }
}
