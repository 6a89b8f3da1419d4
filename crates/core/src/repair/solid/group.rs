//! One double-skinned body, or what may be one: outer and inner faces, and the cut between them.

use super::flow::{Network, SINK, SOURCE};
use super::reach::reached;
use super::thickness::{SkinSide, median};
use crate::mend::Inspection;
use crate::mesh::topology::{NONE, end, start};
use crate::spatial::Bvh;
use crate::tuning::{Tunable, tunable};

/// Fraction of a body's area that must have another side.
const PAIRED: Tunable<f64> = tunable("solid.paired", 0.5);

/// Thicknesses. Radius of the ball that finds outer faces: it enters no opening narrower than about three thicknesses.
const BALL: Tunable<f64> = tunable("solid.ball", 1.5);

/// Fraction of a body's area in front of which there must be another part of the body: in front of an inner skin there is
/// always one. Bounds the time for bodies without inner skins.
const FACED: Tunable<f64> = tunable("solid.faced", 0.25);

/// Thicknesses. Smallest distance between two sides of a skin.
const SKIN_LEAST: Tunable<f64> = tunable("solid.skin_least", 0.4);

/// Thicknesses. Largest distance between two sides of a skin.
const SKIN_MOST: Tunable<f64> = tunable("solid.skin_most", 1.6);

/// Diagonals of the bounding box. With pinholes: the same. Double skins had up to 0.065.
const THIN_PIERCED: Tunable<f64> = tunable("solid.thin_pierced", 0.12);

/// Components that are each other's skins.
pub(super) struct SkinGroup<'a> {
    pub(super) found: &'a Inspection<'a>,
    pub(super) sides: &'a [SkinSide],
    /// The faces, ascending.
    pub(super) faces: Vec<u32>,
    /// The median distance to the other side of the material, in mesh units.
    pub(super) thickness: f64,
    /// The diagonal of the bounding box, in mesh units.
    pub(super) diagonal: f64,
    /// For each face of the mesh whether a ball from outside touches it.
    outer: Vec<bool>,
}

impl<'a> SkinGroup<'a> {
    /// None if few faces have another side, or the skin is too thin for the lattice.
    pub(super) fn new(
        found: &'a Inspection,
        sides: &'a [SkinSide],
        faces: Vec<u32>,
        bvh: &Bvh,
    ) -> Option<Self> {
        let (thickness, part) = median(sides, &faces)?;
        let own = || faces.iter().map(|f| &sides[*f as usize]);
        let all: f64 = own().map(|s| s.area).sum();
        let faced: f64 = own().filter(|s| s.is_faced).map(|s| s.area).sum();
        let corners = faces.iter().flat_map(|f| found.mesh.corners(*f));
        let (low, high) = crate::mesh::bounds(corners);
        let is_thin = thickness < THIN_PIERCED.get() * low.distance(high);
        if part < PAIRED.get() || faced < FACED.get() * all || thickness <= 0.0 || !is_thin {
            return None;
        }
        let points: Vec<_> = faces.iter().map(|f| sides[*f as usize].centre).collect();
        let touched = reached(bvh, [low, high], &points, BALL.get() * thickness)?;
        let mut outer = vec![false; sides.len()];
        for (f, touched) in faces.iter().zip(touched) {
            outer[*f as usize] = touched;
        }
        Some(Self {
            found,
            sides,
            faces,
            thickness,
            diagonal: low.distance(high),
            outer,
        })
    }

    /// Whether the other side of a face is at about the thickness.
    pub(super) fn is_skin(&self, f: u32) -> bool {
        let (least, most) = (SKIN_LEAST.get(), SKIN_MOST.get());
        let (side, t) = (&self.sides[f as usize], self.thickness);
        side.opposite != NONE && side.distance > least * t && side.distance < most * t
    }

    /// The neighbours of a face, each with the half-edge of the face.
    pub(super) fn neighbours(&self, f: u32) -> impl Iterator<Item = (u32, u32)> {
        let opposite = &self.found.topology.opposite;
        let sides = 3 * f..3 * f + 3;
        sides.filter_map(|h| match opposite[h as usize] {
            NONE => None,
            other => Some((h, other / 3)),
        })
    }

    /// The faces on the inner side of the smallest cut between outer and inner faces; a mark for each face of the mesh.
    pub(super) fn separated(&self) -> Vec<bool> {
        let is_outer = |f: u32| self.outer[f as usize];
        let is_inner =
            |f: u32| !is_outer(f) && self.is_skin(f) && is_outer(self.sides[f as usize].opposite);
        // Outer faces are the source and inner ones the sink; each undecided face is a node.
        let mut node = vec![NONE; self.sides.len()];
        let mut nodes = 2;
        for &f in &self.faces {
            node[f as usize] = match (is_outer(f), is_inner(f)) {
                (true, _) => SOURCE,
                (_, true) => SINK,
                _ => nodes,
            };
            nodes += u32::from(node[f as usize] == nodes);
        }
        let mesh = &self.found.mesh;
        let at = |v: u32| mesh.positions[v as usize];
        // Capacities are lengths in thousandths of the thickness, at least one.
        let unit = 1e-3 * self.thickness;
        let mut edges = Vec::new();
        for &f in &self.faces {
            for (h, g) in self.neighbours(f).filter(|(_, g)| *g > f) {
                let (a, b) = (node[f as usize], node[g as usize]);
                if a != b {
                    let length = at(start(mesh, h)).distance(at(end(mesh, h)));
                    edges.push((a, b, (length / unit).min(1e9) as u64 + 1));
                }
            }
        }
        let side = Network::new(nodes as usize, &edges).sink_side();
        let of = |n: &u32| *n != NONE && side[*n as usize];
        node.iter().map(of).collect()
    }
}
