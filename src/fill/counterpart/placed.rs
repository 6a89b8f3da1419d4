//! The counterpart of a mesh, and the part of it that comes to lie at a region.

use std::borrow::Cow;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::align::Target;
use super::find::{mirrors, poses};
use super::motion::Motion;
use crate::cancel::Cancel;
use crate::fill::invented::CounterpartKind;
use crate::mesh::topology::{NONE, end, start};
use crate::mesh::{Hole, Mesh, Part, Topology, bounds};
use crate::spatial::Bvh;

/// Diagonals of the rims' bounding box: how far round the rims the counterpart is looked at, and how high a missing part may rise.
const REACH: f64 = 1.0;

/// The counterpart of a mesh, with the motions of the mesh onto it.
pub(crate) struct Counterpart<'a> {
    mesh: Cow<'a, Mesh>,
    bvh: Bvh,
    border: Vec<bool>,
    is_mirror: bool,
    motions: Vec<Motion>,
}

/// The part of a counterpart at a region, moved to the region.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct PlacedPart {
    pub(super) mesh: Mesh,
    /// For each vertex whether it lies on a border of the counterpart.
    pub(super) border: Vec<bool>,
    /// For each vertex whether it is one of the region's own rims, mirrored.
    pub(super) own_rim: Vec<bool>,
    pub(super) kind: CounterpartKind,
}

impl PlacedPart {
    /// Whether its lists fit each other.
    pub(crate) fn is_valid(&self) -> bool {
        let count = self.mesh.positions.len();
        let is_whole = self.mesh.faces.is_empty() || self.mesh.validate().is_ok();
        is_whole && self.border.len() == count && self.own_rim.len() == count
    }
}

impl<'a> Counterpart<'a> {
    /// The mesh itself, mirrored in a plane, a point and a unit normal, or in its planes of symmetry.
    pub(crate) fn mirror(
        mesh: &'a Mesh,
        topology: &Topology,
        plane: Option<[DVec3; 2]>,
        cancel: &Cancel,
    ) -> Self {
        let mut new = Self::new(Cow::Borrowed(mesh), topology);
        new.is_mirror = true;
        new.motions = match plane {
            Some([point, normal]) => vec![Motion::reflection(point, normal)],
            None => mirrors(mesh, &new.target(), cancel),
        };
        new
    }

    /// A template, in the poses in which it fits the mesh; scaled, if it may be.
    pub(crate) fn template(
        mesh: &Mesh,
        template: Mesh,
        topology: &Topology,
        scale: bool,
        cancel: &Cancel,
    ) -> Self {
        let mut new = Self::new(Cow::Owned(template), topology);
        new.motions = poses(mesh, &new.mesh, &new.target(), scale, cancel);
        new
    }

    fn new(mesh: Cow<'a, Mesh>, topology: &Topology) -> Self {
        let is_there = |f: &u32| topology.component[*f as usize] != NONE;
        let bvh = Bvh::new(&mesh, (0..mesh.faces.len() as u32).filter(is_there));
        let mut border = vec![false; mesh.positions.len()];
        for h in (0..topology.boundary.len() as u32).filter(|&h| topology.boundary[h as usize]) {
            border[start(&mesh, h) as usize] = true;
            border[end(&mesh, h) as usize] = true;
        }
        Self {
            mesh,
            bvh,
            border,
            is_mirror: false,
            motions: Vec::new(),
        }
    }

    fn target(&self) -> Target<'_> {
        Target {
            mesh: &self.mesh,
            bvh: &self.bvh,
            border: &self.border,
        }
    }

    /// The parts that come to lie at some holes of a mesh, one for each motion, the best first.
    pub(crate) fn parts(&self, mesh: &Mesh, holes: &[&Hole]) -> Vec<PlacedPart> {
        let rims = || holes.iter().flat_map(|h| &h.rim).copied();
        let (low, high) = bounds(rims().map(|v| mesh.positions[v as usize]));
        let margin = DVec3::splat(REACH * low.distance(high));
        let (low, high) = (low - margin, high + margin);
        let part = |motion: &Motion| self.part(motion, low, high, &|v| rims().any(|r| r == v));
        self.motions.iter().map(part).collect()
    }

    /// The part that a motion brings to a box.
    fn part(
        &self,
        motion: &Motion,
        low: DVec3,
        high: DVec3,
        is_rim: &dyn Fn(u32) -> bool,
    ) -> PlacedPart {
        let corner = |k: u32| {
            let side = DVec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2));
            motion.at(low + (high - low) * side)
        };
        let (low, high) = bounds((0..8).map(corner));
        let mut faces = Vec::new();
        self.bvh.for_each_in_box(low, high, |f| faces.push(f));
        faces.sort_unstable();
        let part = Part::new(&self.mesh, &faces, std::iter::empty());
        let vertices = part.vertices();
        let border = vertices.iter().map(|&v| self.border[v as usize]).collect();
        let is_own = |&v: &u32| self.is_mirror && self.border[v as usize] && is_rim(v);
        let back = motion.inverse();
        PlacedPart {
            mesh: back.moved(&part.mesh),
            border,
            own_rim: vertices.iter().map(is_own).collect(),
            kind: match self.is_mirror {
                true => CounterpartKind::Mirror(plane(motion, &part.mesh)),
                false => CounterpartKind::Template(back.scale()),
            },
        }
    }
}

/// The plane of a motion that mirrors: a point of it near a mesh, and its unit normal.
fn plane(motion: &Motion, near: &Mesh) -> [DVec3; 2] {
    // The matrix of a reflection is I - 2 n nᵀ: of the columns of what is left of I the longest is along n.
    let rest = [0, 1, 2].map(|k| DVec3::AXES[k] - motion.matrix.col(k));
    let longest = rest
        .into_iter()
        .reduce(|a, b| match b.length() > a.length() {
            true => b,
            false => a,
        });
    let normal = longest.unwrap_or(DVec3::X).normalize_or_zero();
    let (low, high) = bounds(near.positions.iter().copied());
    let middle = if low.x <= high.x {
        0.5 * (low + high)
    } else {
        DVec3::ZERO
    };
    let halfway = 0.5 * (middle + motion.at(middle));
    // The foot of the origin, so that the numbers do not depend on the region.
    [normal * normal.dot(halfway), normal]
}
