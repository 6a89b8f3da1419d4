//! The witness of a repair: the solid that the input means, which is where the magnitude of its winding number exceeds one half, and
//! how much of it a result loses.
//!
//! The generalized winding number (Jacobson, Kavan, Sorkine-Hornung, "Robust inside-outside segmentation using generalized winding
//! numbers", 2013) tells the inside of a mesh with holes, with intersecting parts and with bodies inside others. Points where it is
//! near one half decide nothing, nor points near the input's holes but for those deep inside.

use std::collections::HashSet;

use glam::DVec3;
use rayon::prelude::*;

use super::displaced::Displaced;
use super::draft::Draft;
use crate::check::ShapeDoubt;
use crate::mend::FillError;
use crate::mesh::topology::NONE;
use crate::mesh::{Mesh, area_vector, corner_key};
use crate::spatial::{Bvh, WindingTree, closest_on_triangle};
use crate::threads::CollectIndexed;
use crate::tuning::{Tunable, tunable};

/// Square roots of the face's area. Distance of the sample points from the face.
pub(super) const BEFORE: Tunable<f64> = tunable("repair.before", 1e-2);

/// Fraction of the input's area. If more is cut out, beside faces inside other bodies, the shape of the result is doubtful.
pub(super) const DOUBTFUL_LOSS: Tunable<f64> = tunable("repair.doubtful_loss", 0.02);

/// Fraction of the volume of the input's and the result's solids together. If more belongs to only one of them, the shape
/// of the result is doubtful.
pub(super) const DOUBTFUL_DIFFERENCE: Tunable<f64> = tunable("repair.doubtful_difference", 0.01);

/// Fraction of the volume of the bounding box that moved faces may pass: 0.02 of it where noise hides most of a ball, 0.15 to 0.2 where half
/// of one of two bodies was pulled into the other.
const MOST_PASSED: Tunable<f64> = tunable("repair.most_passed", 0.05);

/// Diagonals of the bounding box. A face that was cut out is not lost if the result's surface is this near to its centre.
const REPLACED: Tunable<f64> = tunable("repair.replaced", 1e-3);

/// Of `BEFORE`. A sheet that has nothing of the solid within this distance of both sides has no thickness.
const TOUCHING: Tunable<f64> = tunable("repair.touching", 1e-4);

/// Points at which the solids are compared, before those that decide nothing are left out.
const WITNESS_POINTS: Tunable<usize> = tunable("repair.witness_points", 8192);

/// Diagonals of the bounding box. The box of these points is at least this wide: a flat mesh is compared beside it too.
const LEAST_SIDE: Tunable<f64> = tunable("repair.least_side", 0.1);

/// Distance of a winding number from one half. Points nearer to it decide nothing: they lie near large holes.
pub(super) const UNDECIDED: Tunable<f64> = tunable("repair.undecided", 0.1);

/// Diameters of a hole. Points nearer to its centre decide nothing, unless they are `DEEP` inside: the patch there is
/// not the input's.
const NEAR_HOLE: Tunable<f64> = tunable("repair.near_hole", 0.75);

/// By how much a winding number exceeds one half deep inside. A half ball has 0.65 at the middle between its pole and centre.
const DEEP: Tunable<f64> = tunable("repair.deep", 0.2);

/// Fraction of the bounding box. A mesh with less than this deep inside may be a sheet or a bowl: 0.003 of a scan of an
/// excavation, 0.2 of half a ball, 0.4 to 0.7 of open housings.
const LEAST_DEEP: Tunable<f64> = tunable("repair.least_deep", 0.3);

/// The solid of a mesh.
pub(super) struct Solid {
    bvh: Bvh,
    tree: WindingTree,
    /// Whether parts that are inside out are solid too.
    turns: bool,
}

impl Solid {
    pub(super) fn new(mesh: &Mesh, faces: impl Iterator<Item = u32>, turns: bool) -> Self {
        let bvh = Bvh::new(mesh, faces);
        let tree = WindingTree::new(&bvh);
        Self { bvh, tree, turns }
    }

    /// The winding number; its magnitude if parts that are inside out are solid too.
    pub(super) fn winding(&self, p: DVec3) -> f64 {
        let winding = self.tree.winding_number(&self.bvh, p);
        if self.turns { winding.abs() } else { winding }
    }

    /// Whether rays from a point meet the surface in more than a fraction of the directions. Unlike the winding number, this does not
    /// rise where several sheets lie above each other.
    fn encloses(&self, p: DVec3, fraction: f64) -> bool {
        let within = (1..).map(|i| 2.0 * halton(i) - DVec3::ONE);
        let rays = within.filter(|d| d.length_squared() < 1.0).take(RAYS);
        let meets = rays.filter(|d| self.bvh.first_along(p, *d, |_| true).is_some());
        meets.count() as f64 > fraction * RAYS as f64
    }
}

/// Number of rays from a point.
const RAYS: usize = 64;
/// About how many points deep inside are tested by rays.
const CAST_FROM: usize = 128;

/// What a result says of the solid that the input means.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Shape {
    /// Fraction of the input's area that was cut out: faces inside other bodies, doubled and requested ones do not count.
    pub(super) lost: f64,
    /// The centre of the largest connected part cut out, by area.
    pub(super) lost_at: DVec3,
    /// Volume common to both solids over the volume of both together, at the points that decide; 1 if there are none.
    pub(super) agreement: f64,
    /// A point in only one of them.
    pub(super) differs_at: DVec3,
}

impl Shape {
    /// The shape of a result that is the input's.
    pub(super) fn whole() -> Self {
        Self {
            agreement: 1.0,
            ..Self::default()
        }
    }

    /// Why the shape is doubtful, if it is.
    pub(super) fn doubt(&self) -> Option<ShapeDoubt> {
        let loses = self.lost > DOUBTFUL_LOSS.get();
        let differs = 1.0 - self.agreement > DOUBTFUL_DIFFERENCE.get();
        (loses || differs).then_some(ShapeDoubt {
            lost: self.lost,
            lost_at: loses.then_some(self.lost_at),
            agreement: self.agreement,
            differs_at: differs.then_some(self.differs_at),
        })
    }
}

/// The solid that the input means, with points at which results are compared with it.
pub(super) struct Witness {
    solid: Solid,
    /// Points in the input's bounding box, wider where it is flat, that decide.
    points: Vec<DVec3>,
    /// Whether each is inside.
    inside: Vec<bool>,
    /// The corners of the input's faces in the orientation of the solid, and their areas; by input face.
    faces: Vec<[DVec3; 3]>,
    /// Distance from the result's surface within which a face counts as replaced by its like, in mesh units.
    near: f64,
}

impl Witness {
    /// The witness of a cleaned and oriented draft. Parts that are inside out are solid if `turns`.
    pub(super) fn new(draft: &Draft, input: &Mesh, turns: bool) -> Result<Self, FillError> {
        let found = draft.inspect()?;
        let solid = Solid::new(&draft.mesh, found.topology.faces(), turns);
        let (low, high) =
            crate::mesh::bounds((found.topology.faces()).flat_map(|f| draft.mesh.corners(f)));
        // Also beside a flat mesh.
        let size = (high - low).max(DVec3::splat(LEAST_SIDE.get() * low.distance(high)));
        let from = 0.5 * (low + high - size);
        let balls: Vec<(DVec3, f64)> = (found.holes.iter())
            .map(|h| (h.centre, NEAR_HOLE.get() * h.diameter))
            .collect();
        let sampled: Vec<(DVec3, f64)> = (0..WITNESS_POINTS.get() as u32)
            .into_par_iter()
            .map(|i| from + halton(i + 1) * size)
            .map(|p| (p, solid.winding(p)))
            .collect_indexed();
        let (points, inside) = deciding(&solid, &sampled, &balls);
        let mut faces: Vec<[DVec3; 3]> = (0..input.faces.len() as u32)
            .map(|f| input.corners(f))
            .collect();
        for (f, origin) in draft.origins.faces.iter().enumerate() {
            if origin.face != NONE && origin.corners == [0, 2, 1] {
                faces[draft.origins.faces[f].face as usize].swap(1, 2);
            }
        }
        Ok(Self {
            near: REPLACED.get() * low.distance(high),
            solid,
            points,
            inside,
            faces,
        })
    }

    /// What a draft says of the solid. `asked` are input faces that were removed on request.
    pub(super) fn shape(&self, draft: &Draft, asked: &HashSet<u32>) -> Result<Shape, FillError> {
        let found = draft.inspect()?;
        let result = Solid::new(&draft.mesh, found.topology.faces(), self.solid.turns);
        let (lost, lost_at) = self.lost(draft, &result.bvh, asked);
        let (agreement, differs_at) = self.agreement(&result, &draft.displaced);
        Ok(Shape {
            lost,
            lost_at,
            agreement,
            differs_at,
        })
    }

    /// The fraction of the input's outer area that a draft lost.
    pub(super) fn lost_share(&self, draft: &Draft, asked: &HashSet<u32>) -> Result<f64, FillError> {
        let found = draft.inspect()?;
        let result = Bvh::new(&draft.mesh, found.topology.faces());
        Ok(self.lost(draft, &result, asked).0)
    }

    /// The fraction of the input's outer area that has no face left and is not near the result's surface, and the area-weighted centre
    /// of what is lost.
    fn lost(&self, draft: &Draft, result: &Bvh, asked: &HashSet<u32>) -> (f64, DVec3) {
        let living = draft.origins.living(self.faces.len());
        let there = living.iter().zip(&self.faces).filter(|(lives, _)| **lives);
        let there: HashSet<_> = there.map(|(_, corners)| corner_key(*corners)).collect();
        let outer = |f: u32| -> (f64, bool) {
            let corners = self.faces[f as usize];
            let area = 0.5 * area_vector(corners).length();
            let is_lost = !living[f as usize] && !asked.contains(&f) && area > 0.0 && {
                let centre = corners.iter().sum::<DVec3>() / 3.0;
                let is_near = || result.closest(centre, self.near).is_some();
                !there.contains(&corner_key(corners)) && !is_near() && !self.is_inner(corners)
            };
            (area, is_lost)
        };
        let of: Vec<(f64, bool)> = (0..self.faces.len() as u32)
            .into_par_iter()
            .map(outer)
            .collect_indexed();
        let all: f64 = of.iter().map(|(area, _)| area).sum();
        let (mut lost, mut moment) = (0.0, DVec3::ZERO);
        for (corners, (area, _)) in self.faces.iter().zip(&of).filter(|(_, (_, lost))| *lost) {
            lost += area;
            moment += *area / 3.0 * corners.iter().sum::<DVec3>();
        }
        match lost > 0.0 {
            true => (lost / all, moment / lost),
            false => (0.0, DVec3::ZERO),
        }
    }

    /// Whether a face of the input bounds nothing of the solid: the point in front of it is inside other bodies, or it is one side
    /// of a sheet without thickness.
    fn is_inner(&self, corners: [DVec3; 3]) -> bool {
        let normal = area_vector(corners);
        let step = BEFORE.get() * (0.5 * normal.length()).sqrt();
        let centre = corners.iter().sum::<DVec3>() / 3.0;
        let before = |step: f64| {
            self.solid
                .winding(centre + step * normal.normalize_or_zero())
        };
        let touching = TOUCHING.get() * step;
        before(step) > 0.5 + UNDECIDED.get()
            || [touching, -touching]
                .map(before)
                .iter()
                .all(|w| *w < 0.5 - UNDECIDED.get())
    }

    /// The common volume of both solids over the volume of both together, and a point in only one of them. Points that `moved` faces
    /// may have passed count as the input's, unless they are many.
    fn agreement(&self, result: &Solid, moved: &Displaced) -> (f64, DVec3) {
        let is_passed = |p: DVec3| {
            (moved.faces.iter()).any(|([a, b, c], by)| {
                let (nearest, _) = closest_on_triangle(p, *a, *b, *c);
                nearest.distance(p) <= *by
            })
        };
        // Whether each point is inside the result, and whether it differs since a moved face may have passed it.
        let found: Vec<(bool, bool)> = (self.points.par_iter().zip(&self.inside))
            .map(|(p, inside)| {
                let after = result.winding(*p) > 0.5;
                (after, after != *inside && is_passed(*p))
            })
            .collect_indexed();
        let passed = found.iter().filter(|(_, is_passed)| *is_passed).count();
        let excuses = passed as f64 <= MOST_PASSED.get() * WITNESS_POINTS.get() as f64;
        let after = found
            .iter()
            .map(|(b, is_passed)| *b != (excuses && *is_passed));
        let pairs = || self.inside.iter().zip(after.clone());
        let both = pairs().filter(|(a, b)| **a && *b).count();
        let either = pairs().filter(|(a, b)| **a || *b).count();
        let differs = pairs().position(|(a, b)| *a != b);
        let at = differs.map_or(DVec3::ZERO, |i| self.points[i]);
        match either {
            0 => (1.0, at),
            _ => (both as f64 / either as f64, at),
        }
    }
}

/// The points that decide, among points with winding numbers, and whether they are inside. `balls` are centres and radii round holes.
fn deciding(
    solid: &Solid,
    sampled: &[(DVec3, f64)],
    balls: &[(DVec3, f64)],
) -> (Vec<DVec3>, Vec<bool>) {
    let is_near_hole = |p: &DVec3| balls.iter().any(|(c, r)| p.distance_squared(*c) < r * r);
    let is_deep = |winding: f64| winding > 0.5 + DEEP.get();
    let deep = sampled.iter().filter(|(_, w)| is_deep(*w));
    let deep: Vec<DVec3> = deep.map(|(p, _)| *p).collect();
    // However wide a hole of a body is: no patch of it passes deep inside. A sheet has no inside.
    let is_body = deep.len() as f64 > LEAST_DEEP.get() * sampled.len() as f64 && {
        let step = 1 + deep.len() / CAST_FROM;
        let cast: Vec<DVec3> = deep.iter().copied().step_by(step).collect();
        let enclosed = |p: &&DVec3| solid.encloses(**p, 0.5 + DEEP.get());
        2 * cast.par_iter().filter(enclosed).count() > cast.len()
    };
    let decides = |(p, winding): &(DVec3, f64)| match is_near_hole(p) {
        true => is_body && is_deep(*winding),
        false => (winding - 0.5).abs() > UNDECIDED.get(),
    };
    let decided = sampled.iter().filter(|of| decides(of));
    decided.map(|(p, winding)| (*p, *winding > 0.5)).unzip()
}

/// A point of the Halton sequence with the bases 2, 3 and 5 in the unit cube (J. H. Halton, "On the efficiency of certain
/// quasi-random sequences of points in evaluating multi-dimensional integrals", 1960).
fn halton(index: u32) -> DVec3 {
    let radical = |base: u32| {
        let (mut rest, mut part, mut sum) = (index, 1.0, 0.0);
        while rest > 0 {
            part /= f64::from(base);
            sum += part * f64::from(rest % base);
            rest /= base;
        }
        sum
    };
    DVec3::new(radical(2), radical(3), radical(5))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mend::Inspection;
    use crate::mesh::shapes::{icosphere, punch};
    use crate::repair::filling::CAP;
    use crate::repair::rim_triangles::push;

    fn draft(mesh: &Mesh) -> Draft {
        let found = Inspection::new(mesh).unwrap();
        Draft::new(mesh, found.topology.component.clone())
    }

    /// The agreement of a mesh with a copy of it that is hollow: it has an inner skin, a tenth smaller and reversed.
    fn agreement_of_hollow(mesh: &Mesh) -> f64 {
        let witness = Witness::new(&draft(mesh), mesh, true).unwrap();
        let mut hollow = draft(mesh);
        let (low, high) = crate::mesh::bounds(mesh.positions.iter().copied());
        let centre = 0.5 * (low + high);
        let known = mesh.positions.len() as u32;
        for p in &mesh.positions {
            hollow.mesh.positions.push(centre + 0.9 * (*p - centre));
            hollow.origins.vertices.push(NONE);
            hollow.expected_error.push(None);
        }
        for f in &mesh.faces {
            let [a, b, c] = f.map(|v| v + known);
            push(&mut hollow, CAP, [a, c, b]);
        }
        let shape = witness.shape(&hollow, &HashSet::new()).unwrap();
        shape.agreement
    }

    #[test]
    fn a_housing_with_a_wide_opening_is_solid_deep_inside() {
        let housing = punch(&icosphere(3), |p| p.z > 0.6);
        assert!(agreement_of_hollow(&housing) < 0.5);
    }

    #[test]
    fn a_bowl_and_a_sheet_may_have_walls() {
        let bowl = punch(&icosphere(3), |p| p.z > -0.05);
        let mut sheet = bowl.clone();
        sheet.positions.iter_mut().for_each(|p| p.z *= 0.2);
        let above = {
            let mut above = sheet.clone();
            let known = sheet.positions.len() as u32;
            let raised = sheet.positions.iter().map(|p| *p + 0.01 * DVec3::Z);
            above.positions.extend(raised);
            above
                .faces
                .extend(sheet.faces.iter().map(|f| f.map(|v| v + known)));
            above
        };
        for mesh in [bowl, sheet, above] {
            assert_eq!(agreement_of_hollow(&mesh), 1.0);
        }
    }
}
