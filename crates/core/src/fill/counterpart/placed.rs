//! The counterpart of a mesh: the motions of the mesh onto it, and the part of it at a region.

use std::borrow::Cow;

use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

use super::align::Target;
use super::find::{Search, mirrors, poses};
use super::motion::Motion;
use crate::cancel::Cancel;
use crate::fill::invented::CounterpartKind;
use crate::mesh::topology::{NONE, end, start};
use crate::mesh::{Hole, Mesh, Part, Topology, bounds};
use crate::spatial::Bvh;
use crate::tuning::{Tunable, tunable};

/// See [`Counterpart::reach`]. It bounds the height of a missing part.
const REACH: f64 = 1.0;
/// The same for a mirror image that is weighed with a smooth patch: more than the width of the collar that is aligned with it.
const REACH_WEIGHED: Tunable<f64> = tunable("fill.placed.reach_weighed", 0.5);

/// The counterpart of a mesh, and the motions that map the mesh onto it.
pub(crate) struct Counterpart<'a> {
    mesh: Cow<'a, Mesh>,
    bvh: Bvh,
    /// Whether each vertex is on a boundary edge.
    border: Vec<bool>,
    is_mirror: bool,
    /// Diagonals of the rims' bounding box: margin round that box within which it is used.
    reach: f64,
    /// The best first.
    motions: Vec<Motion>,
}

/// The part of a counterpart at a region, moved to the region.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct PlacedPart {
    pub(super) mesh: Mesh,
    /// Whether each vertex is on a boundary edge of the counterpart.
    pub(super) border: Vec<bool>,
    /// Whether each vertex is the mirror image of a vertex on the region's rims.
    pub(super) own_rim: Vec<bool>,
    /// Four points at the region that are not in one plane, and their images under the motion that placed the part.
    images: [[DVec3; 2]; 4],
    pub(super) kind: CounterpartKind,
}

impl PlacedPart {
    /// Whether a deserialised part is consistent: a valid mesh, and one flag for each vertex in each list.
    pub(crate) fn is_valid(&self) -> bool {
        let count = self.mesh.positions.len();
        let is_whole = self.mesh.faces.is_empty() || self.mesh.validate().is_ok();
        let is_finite = self.images.iter().flatten().all(|p| p.is_finite());
        is_whole && is_finite && self.border.len() == count && self.own_rim.len() == count
    }

    /// The part with other coordinates; `turned` where these have the other handedness.
    pub(crate) fn moved(&self, to: impl Fn(DVec3) -> DVec3, turned: bool) -> Self {
        let mut new = self.clone();
        let images = new.images.iter_mut().flatten();
        for p in new.mesh.positions.iter_mut().chain(images) {
            *p = to(*p);
        }
        for face in new.mesh.faces.iter_mut().filter(|_| turned) {
            face.swap(1, 2);
        }
        new
    }

    /// The motion that placed the part.
    pub(super) fn placing(&self) -> Motion {
        let axes = |side: usize| {
            let [x, y, z] = [1, 2, 3].map(|k| self.images[k][side] - self.images[0][side]);
            DMat3::from_cols(x, y, z)
        };
        let [from, to] = self.images[0];
        Motion::about(axes(1) * axes(0).inverse(), from, to)
    }
}

impl<'a> Counterpart<'a> {
    /// The mesh itself, mirrored in the given plane (a point and a unit normal), or in its planes of symmetry, searched with less
    /// effort if `is_quick`.
    pub(crate) fn mirror(
        mesh: &'a Mesh,
        topology: &Topology,
        plane: Option<[DVec3; 2]>,
        is_quick: bool,
        cancel: &Cancel,
    ) -> Self {
        let search = match is_quick {
            true => Search::quick(),
            false => Search::full(false),
        };
        let mut new = Self::new(Cow::Borrowed(mesh), topology);
        new.is_mirror = true;
        if is_quick {
            new.reach = REACH_WEIGHED.get();
        }
        new.motions = match plane {
            Some([point, normal]) => vec![Motion::reflection(point, normal)],
            None => mirrors(mesh, &new.target(), &search, cancel),
        };
        new
    }

    /// A template in the poses in which it fits the mesh, scaled if it fits better by far then.
    pub fn template(mesh: &Mesh, template: Mesh, topology: &Topology, cancel: &Cancel) -> Self {
        let mut new = Self::new(Cow::Owned(template), topology);
        new.motions = poses(mesh, &new.mesh, &new.target(), cancel);
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
            reach: REACH,
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

    /// The parts at some holes of a mesh, one for each motion, the best first.
    pub(crate) fn parts(&self, mesh: &Mesh, holes: &[&Hole]) -> Vec<PlacedPart> {
        let rims = || holes.iter().flat_map(|h| &h.rim).copied();
        let (low, high) = bounds(rims().map(|v| mesh.positions[v as usize]));
        let margin = DVec3::splat(self.reach * low.distance(high));
        let (low, high) = (low - margin, high + margin);
        let part = |motion: &Motion| self.part(motion, low, high, &|v| rims().any(|r| r == v));
        self.motions.iter().map(part).collect()
    }

    /// The part whose faces reach the image of a box under a motion, moved back to the box.
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
        let back = motion.inverse();
        let [x, y, z] = DVec3::AXES.map(|axis| low + axis * (high - low));
        let images = [low, x, y, z].map(|p| [p, back.at(p)]);
        let (low, high) = bounds((0..8).map(corner));
        let mut faces = Vec::new();
        self.bvh.for_each_in_box(low, high, |f| faces.push(f));
        faces.sort_unstable();
        let part = Part::new(&self.mesh, &faces, std::iter::empty());
        let vertices = part.vertices();
        let border = vertices.iter().map(|&v| self.border[v as usize]).collect();
        let is_own = |&v: &u32| self.is_mirror && self.border[v as usize] && is_rim(v);
        PlacedPart {
            mesh: back.moved(&part.mesh),
            border,
            own_rim: vertices.iter().map(is_own).collect(),
            images,
            kind: match self.is_mirror {
                true => CounterpartKind::Mirror(plane(motion, &part.mesh)),
                false => CounterpartKind::Template(back.scale()),
            },
        }
    }
}

/// The plane of a reflection: the foot of the perpendicular from the origin, and its unit normal. A motion that is found numerically is a
/// reflection only approximately; the plane is then the best one at the middle of `near`.
fn plane(motion: &Motion, near: &Mesh) -> [DVec3; 2] {
    // The matrix A of a reflection is I − 2 n nᵀ: the longest column of I − A is along n.
    let columns = [0, 1, 2].map(|k| DVec3::AXES[k] - motion.matrix.col(k));
    let longest = columns
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
    // The foot of the perpendicular does not depend on the region.
    [normal * normal.dot(halfway), normal]
}
