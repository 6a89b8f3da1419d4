//! Seam relaxation: bends the patch to meet a rough mesh at the angles that the mesh itself has at the rim.

use glam::DVec3;

use super::Remesher;
use crate::elementary::atan2;
use crate::linalg::{Jacobi, LinearOperator, conjugate_gradient};
use crate::stitch::half_edge::{next, prev};
use crate::tuning::{Tunable, tunable};

/// Fraction of the mean angle across the mesh's own edges at the rim. A larger mean angle across the rim is reduced
/// towards this.
const SEAM_GOAL: Tunable<f64> = tunable("stitch.seam_goal", 0.85);

/// Fraction of the angles across the rim that curvature does not explain. With a smaller fraction the angles are left.
const SEAM_ROUGH: Tunable<f64> = tunable("stitch.seam_rough", 0.4);

/// Radians. Mean angles below this are left.
const SEAM_VISIBLE: Tunable<f64> = tunable("stitch.seam_visible", 0.01);

/// Rings of free vertices that are moved to reduce the angles across the rim.
const SEAM_RINGS: Tunable<u32> = tunable("stitch.seam_rings", 3);

/// Weight of the angles across the rim relative to the angles within the patch.
const SEAM_WEIGHT: Tunable<f64> = tunable("stitch.seam_weight", 32.0);

/// Weight of the displacements, in edge lengths, relative to the angles.
const SEAM_STAY: Tunable<f64> = tunable("stitch.seam_stay", 0.1);

/// Edge lengths. Upper bound of a displacement that reduces the angles across the rim.
const SEAM_MOST: Tunable<f64> = tunable("stitch.seam_most", 0.25);

/// An edge of the rim.
struct Seam {
    /// The patch's half-edge.
    edge: u32,
    /// Dihedral angle at the edge in radians, positive where the surface is convex.
    angle: f64,
    /// The angle minus the part that the curvature of the surface explains.
    excess: f64,
}

/// A row of the least-squares system: derivatives of an edge's angle with respect to four vertex displacements, and the wanted
/// change.
struct Row {
    change: [(u32, f64); 4],
    goal: f64,
    weight: f64,
}

impl Row {
    fn times(&self, x: &[f64]) -> f64 {
        let known = self.change.iter().filter(|c| c.0 != FIXED);
        known.map(|&(v, c)| c * x[v as usize]).sum()
    }

    fn add(&self, factor: f64, y: &mut [f64]) {
        for &(v, c) in self.change.iter().filter(|c| c.0 != FIXED) {
            y[v as usize] += self.weight * factor * c;
        }
    }
}

/// Marks a vertex that is not moved.
const FIXED: u32 = u32::MAX;

/// The normal equations, as an operator.
struct Bending {
    rows: Vec<Row>,
    /// Penalty on the displacement of each vertex.
    stay: Vec<f64>,
    jacobi: Vec<f64>,
}

impl LinearOperator for Bending {
    fn apply(&self, x: &[f64], y: &mut [f64]) {
        y.iter_mut()
            .zip(x)
            .zip(&self.stay)
            .for_each(|((y, x), s)| *y = s * x);
        for row in &self.rows {
            row.add(row.times(x), y);
        }
    }

    fn jacobi(&self) -> &[f64] {
        &self.jacobi
    }
}

impl Remesher<'_> {
    /// If the angles across the rim are on average larger than the mesh's own next to it, moves the vertices near the rim along
    /// their normals to reduce them, with the least change of the angles within the patch.
    ///
    /// The surface is smoother than a rough mesh, and matches its position and normal at the rim only with the accuracy of
    /// voxels. The part of an angle that the curvature of the surface explains is kept, so a smooth mesh is not affected.
    pub(super) fn relax_seam(&mut self) {
        let Some(around) = self.rims.angle_around else {
            return;
        };
        // Angles across the rim in radians, and their excess over the curvature of the surface.
        let seam: Vec<Seam> = self.seam().collect();
        let mean =
            |of: fn(&Seam) -> f64| seam.iter().map(of).sum::<f64>() / seam.len().max(1) as f64;
        let angle = mean(|s| s.angle.abs());
        let excess = mean(|s| s.excess.abs());
        if angle <= around.max(SEAM_VISIBLE.get()) || excess <= SEAM_ROUGH.get() * angle {
            return;
        }
        // The fraction of the excess to remove, so that the mean angle becomes a fraction of the mesh's.
        let part = 1.0 - SEAM_GOAL.get() * around / angle;
        // The unknowns: displacements of free vertices near the rim along their normals, in units of the mesh.
        let ring = self.rings(SEAM_RINGS.get());
        let (mut number, mut moved) = (vec![FIXED; ring.len()], Vec::new());
        for v in self.free_vertices() {
            if ring[v as usize] <= SEAM_RINGS.get() {
                number[v as usize] = moved.len() as u32;
                moved.push(v);
            }
        }
        // Least squares: wanted changes of the angles across the rim, no changes within the patch, short displacements.
        let mut rows: Vec<Row> = seam
            .iter()
            .map(|s| Row {
                change: self.change([Some(s.edge), None], &number),
                goal: -part * s.excess,
                weight: SEAM_WEIGHT.get(),
            })
            .collect();
        let inner = self.mesh.interior_edges().filter_map(|h| {
            let change = self.change([Some(h), self.mesh.twin(h)], &number);
            change.iter().any(|c| c.0 != FIXED).then_some(Row {
                change,
                goal: 0.0,
                weight: 1.0,
            })
        });
        rows.extend(inner);
        let lengths: Vec<f64> = moved.iter().map(|&v| self.mesh.mean_length(v)).collect();
        let stay = |l: &f64| (SEAM_STAY.get() / l).powi(2);
        let stay: Vec<f64> = lengths.iter().map(stay).collect();
        // Right-hand side and diagonal of the normal equations, which are solved matrix-free.
        let (mut rhs, mut diagonal) = (vec![0.0; moved.len()], stay.clone());
        for row in &rows {
            row.add(row.goal, &mut rhs);
            for &(v, c) in row.change.iter().filter(|c| c.0 != FIXED) {
                diagonal[v as usize] += row.weight * c * c;
            }
        }
        let bending = Bending {
            rows,
            stay,
            jacobi: diagonal.iter().map(|d| d.recip()).collect(),
        };
        let mut by = vec![0.0; moved.len()];
        let scaling = Jacobi(bending.jacobi());
        conjugate_gradient(&bending, &scaling, &rhs, &mut by, 1e-3, 200);
        for ((v, by), length) in moved.into_iter().zip(by).zip(lengths) {
            self.displace(v, by, SEAM_MOST.get() * length);
        }
    }

    /// The rim edges with a known face on the other side.
    fn seam(&self) -> impl Iterator<Item = Seam> + '_ {
        let mesh = &*self.mesh;
        (0..mesh.rim_len() as u32).filter_map(move |v| {
            let edge = mesh.rim_edge(v)?;
            let ends = [v, mesh.to(edge)];
            let beyond = self
                .rims
                .beyond
                .get(&ends.map(|v| mesh.origin[v as usize]).into())?;
            let corners =
                [ends[0], ends[1], mesh.from(prev(edge))].map(|v| mesh.position[v as usize]);
            let own = mesh
                .area_vector(mesh.faces[edge as usize / 3])
                .normalize_or_zero();
            let along = (corners[1] - corners[0]).normalize_or_zero();
            let angle = atan2(along.dot(own.cross(beyond.normal)), own.dot(beyond.normal));
            let smooth = self.smooth_angle(corners, beyond.apex - self.centre)?;
            Some(Seam {
                edge,
                angle,
                excess: angle - smooth,
            })
        })
    }

    /// The angle between the triangles a, b, c and b, a, d if all corners were on a surface with the curvature that ours has one
    /// to two triangle heights from the edge, on the side of c.
    fn smooth_angle(&self, [a, b, c]: [DVec3; 3], d: DVec3) -> Option<f64> {
        let middle = 0.5 * (a + b);
        let along = (b - a).normalize_or_zero();
        let inward = (b - a).cross(c - a).cross(along).normalize_or_zero();
        let step = (c - middle).dot(inward);
        let at = |u: f64, w: f64| self.project(middle + step * (u * inward + w * along), step);
        let rate = |from: (DVec3, DVec3), to: (DVec3, DVec3)| {
            let way = to.0 - from.0;
            (to.1 - from.1) / way.length()
        };
        // Shape operator from the change of normals between four points.
        let [near, far, left, right] =
            [at(1.0, 0.0)?, at(2.0, 0.0)?, at(1.5, -0.5)?, at(1.5, 0.5)?];
        let (by_u, by_w) = (rate(near, far), rate(left, right));
        let shape = [
            by_u.dot(inward),
            0.5 * (by_u.dot(along) + by_w.dot(inward)),
            by_w.dot(along),
        ];
        let length = a.distance(b);
        let height = |x: DVec3| {
            let (u, w) = ((x - middle).dot(inward), (x - middle).dot(along));
            -0.5 * (shape[0] * u * u + 2.0 * shape[1] * u * w + shape[2] * w * w)
        };
        let bend = |apex: DVec3| {
            let foot = (apex - a).dot(along) / length;
            let up = (1.0 - foot) * height(a) + foot * height(b) - height(apex);
            up / (apex - a).reject_from(along).length()
        };
        Some(bend(c) + bend(d)).filter(|angle| angle.is_finite())
    }

    /// Derivatives of the angle at an edge, given by its half-edges, with respect to displacements of the vertices of its faces
    /// along their normals. The two ends get contributions from both faces.
    fn change(&self, sides: [Option<u32>; 2], number: &[u32]) -> [(u32, f64); 4] {
        let mesh = &*self.mesh;
        let mut out = [(FIXED, 0.0); 4];
        for (side, h) in sides.into_iter().enumerate() {
            let Some(h) = h else { continue };
            let (a, b, c) = (mesh.from(h), mesh.to(h), mesh.from(prev(h)));
            debug_assert_eq!(c, mesh.to(next(h)));
            let [pa, pb, pc] = [a, b, c].map(|v| mesh.position[v as usize]);
            let normal = mesh.area_vector(mesh.faces[h as usize / 3]);
            let length = pa.distance(pb);
            let height = normal.length() / length;
            let normal = normal.normalize_or_zero();
            let foot = (pc - pa).dot(pb - pa) / (length * length);
            let of = |v: u32| normal.dot(mesh.normal[v as usize]) / height;
            // The second half-edge has the ends in reverse order.
            let ends = [(a, 1.0 - foot), (b, foot)];
            for (end, (v, part)) in ends.into_iter().enumerate() {
                let slot = &mut out[end ^ side];
                *slot = (number[v as usize], slot.1 + part * of(v));
            }
            out[2 + side] = (number[c as usize], -of(c));
        }
        out
    }
}
