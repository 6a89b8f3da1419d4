//! Text on the parts of a patch that its surroundings do not predict: its counterpart and its grain.

use crate::fill::{ClosedBy, CounterpartKind, CounterpartReport, RegionReport};
use crate::mesh::Unit;

/// The counterpart after which a region was filled or was to be filled: what it is and how well it fits, or why it was not used; none where
/// there was none.
pub(crate) fn counterpart_text(r: &RegionReport, unit: Option<Unit>) -> Option<String> {
    let found = r.counterpart.as_ref()?;
    let what = found.kind.map_or("the counterpart".to_owned(), kind_text);
    Some(match &found.refused {
        Some(why) => format!("not filled after {what}: {why}{}", fit(found, unit)),
        None => format!("after {what}{}", fit(found, unit)),
    })
}

/// What closed a region that was filled after a counterpart.
pub(super) fn like(r: &RegionReport, unit: Option<Unit>) -> String {
    let text = counterpart_text(r, unit);
    text.map_or("closed".to_owned(), |text| format!("closed {text}"))
}

/// A counterpart that was not used, for a region that was closed in another way.
pub(super) fn refused(r: &RegionReport, unit: Option<Unit>) -> Option<String> {
    match r.closed_by {
        Some(ClosedBy::Counterpart) => None,
        _ => counterpart_text(r, unit),
    }
}

/// The roughness that was invented for a patch, if it has any.
pub(crate) fn grain_text(r: &RegionReport, unit: Option<Unit>) -> Option<String> {
    let grain = r.grain?;
    let ring = Unit::text(unit, grain.ring);
    Some(match grain.part {
        0.0 => format!(
            "no grain: the patch would have intersected faces (its surroundings are rough by {ring})"
        ),
        _ => format!(
            "with invented grain of {}, its surroundings being rough by {ring}; expected errors do not count it",
            Unit::text(unit, grain.patch)
        ),
    })
}

fn kind_text(kind: CounterpartKind) -> String {
    match kind {
        CounterpartKind::Mirror([point, n]) => {
            let number = |x: f64| {
                let text = format!("{x:.3}");
                text.trim_end_matches('0').trim_end_matches('.').to_owned()
            };
            let [x, y, z] = n.to_array().map(number);
            format!(
                "its mirror image in the plane {x} x + {y} y + {z} z = {}",
                number(n.dot(point))
            )
        }
        CounterpartKind::Template(scale) if (scale - 1.0).abs() < 1e-9 => "the template".to_owned(),
        CounterpartKind::Template(scale) => format!("the template, scaled by {scale:.4}"),
    }
}

fn fit(found: &CounterpartReport, unit: Option<Unit>) -> String {
    let Some(misfit) = found.misfit else {
        return String::new();
    };
    let mut text = format!(" (off by {} beside the hole", Unit::text(unit, misfit));
    if let (Some(own), Some(smooth)) = (found.ring_error, found.smooth_ring_error) {
        text += &format!(
            "; rings taken out predicted to {}, by a smooth patch to {}",
            Unit::text(unit, own),
            Unit::text(unit, smooth)
        );
    }
    text + ")"
}
