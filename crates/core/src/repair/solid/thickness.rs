//! The thickness of a skin at each face: a ray from the face's centre, against its normal, to the other side.

use glam::DVec3;
use rayon::prelude::*;

use crate::mesh::topology::NONE;
use crate::mesh::{Mesh, area_vector};
use crate::spatial::Bvh;
use crate::threads::CollectIndexed;
use crate::tuning::{Tunable, tunable};

/// Cosine. A face is the other side of another if their normals are opposite within this angle (60°).
const PARALLEL: Tunable<f64> = tunable("solid.parallel", 0.5);

/// The geometry of a face and of the face on the other side of the material behind it.
#[derive(Clone, Copy)]
pub(super) struct SkinSide {
    /// The face's centroid.
    pub(super) centre: DVec3,
    /// The face's unit normal; zero for a face without area.
    pub(super) normal: DVec3,
    /// The face's area, in squared mesh units.
    pub(super) area: f64,
    /// The face on the other side; `u32::MAX` if the ray leaves, or meets a face that is not roughly parallel.
    pub(super) opposite: u32,
    /// The distance to it along the ray, in mesh units.
    pub(super) distance: f64,
    /// Whether a ray along the normal meets a face.
    pub(super) is_faced: bool,
}

/// The sides of some faces of a mesh. `bvh` holds the faces that rays may meet.
pub(super) fn sides(mesh: &Mesh, bvh: &Bvh, faces: &[u32]) -> Vec<SkinSide> {
    let geometry = |f: u32| {
        let corners = mesh.corners(f);
        let vector = area_vector(corners);
        let centre = corners.iter().sum::<DVec3>() / 3.0;
        (centre, vector.normalize_or_zero(), 0.5 * vector.length())
    };
    let side = |f: &u32| {
        let (centre, normal, area) = geometry(*f);
        let hit = match normal == DVec3::ZERO {
            true => None,
            false => bvh.first_along(centre, -normal, |other| other != *f),
        };
        let is_parallel = |(g, _): &(u32, f64)| normal.dot(geometry(*g).1) < -PARALLEL.get();
        let (opposite, distance) = hit.filter(is_parallel).unwrap_or((NONE, f64::INFINITY));
        let is_faced =
            normal != DVec3::ZERO && bvh.first_along(centre, normal, |g| g != *f).is_some();
        SkinSide {
            centre,
            normal,
            area,
            opposite,
            distance,
            is_faced,
        }
    };
    faces.par_iter().map(side).collect_indexed()
}

/// The area-weighted median of the distances of some faces to their other sides, and the fraction of their area that has one; none
/// if no face has one.
pub(super) fn median(sides: &[SkinSide], faces: &[u32]) -> Option<(f64, f64)> {
    let own = || faces.iter().map(|f| &sides[*f as usize]);
    let mut known: Vec<(f64, f64)> = own()
        .filter(|s| s.opposite != NONE)
        .map(|s| (s.distance, s.area))
        .collect();
    known.sort_by(|a, b| a.0.total_cmp(&b.0));
    let all: f64 = own().map(|s| s.area).sum();
    let area: f64 = known.iter().map(|(_, area)| area).sum();
    let mut sum = 0.0;
    for (distance, own) in known {
        sum += own;
        if sum >= 0.5 * area && area > 0.0 {
            return Some((distance, area / all));
        }
    }
    None
}

/// The median distance of some faces to their other sides; none unless the distances of more than `part` of their area vary by less
/// than `tolerance` times the median.
pub(super) fn even_distance(
    sides: &[SkinSide],
    faces: &[u32],
    [tolerance, part]: [f64; 2],
) -> Option<f64> {
    let (distance, _) = median(sides, faces)?;
    let (mut all, mut even) = (0.0, 0.0);
    for side in faces.iter().map(|f| &sides[*f as usize]) {
        all += side.area;
        if (side.distance - distance).abs() < tolerance * distance {
            even += side.area;
        }
    }
    (even > part * all).then_some(distance)
}
