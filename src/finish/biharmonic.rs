//! Linear fills of a patch from its triangles alone.

use glam::DVec3;
use sprs::CsMat;

use super::geometry::{Stiffness, barycentric, half_cotangents};
use super::patch::Patch;
use crate::cancel::Cancel;
use crate::linalg::LdlPattern;
use crate::tuning::tuning;

/// Two harmonic fills, then the biharmonic one, `min xᵀ S M⁻¹ S x` with all other vertices given, each with the cotangents of
/// the surface before: forgets the shape of the patch but for its triangles, keeps the slope at the rim. None where a system
/// cannot be solved. (M. Botsch, L. Kobbelt, "An intuitive framework for real-time freeform modeling", 2004.)
pub(super) fn biharmonic(patch: &Patch, shape: &[DVec3]) -> Option<Vec<DVec3>> {
    let mut shape = shape.to_vec();
    for order in [1, 1, 2] {
        shape = polyharmonic(patch, &shape, order)?;
    }
    Some(shape)
}

/// The surface of least area with the patch's rim and triangles, by harmonic fills with the cotangents of the one before
/// (U. Pinkall, K. Polthier, "Computing discrete minimal surfaces and their conjugates", 1993). The slope at the rim does not
/// matter. None where a system cannot be solved.
pub(super) fn minimal(patch: &Patch, shape: &[DVec3]) -> Option<Vec<DVec3>> {
    let mut shape = shape.to_vec();
    for _ in 0..tuning().finish.minimal_steps {
        let next = polyharmonic(patch, &shape, 1)?;
        let ways = shape.iter().zip(&next).map(|(a, b)| a.distance(*b));
        let farthest = ways.fold(0.0, f64::max);
        shape = next;
        if farthest < tuning().finish.minimal_tolerance * patch.diameter {
            break;
        }
    }
    Some(shape)
}

/// The polyharmonic fill of an order, `L (M⁻¹ L)ᵏ⁻¹ x = 0` with the cotangents of a shape: harmonic (1), biharmonic (2) or
/// triharmonic (3), which continues the curvature of the rim too. None where the system cannot be solved, or the token is set.
pub(super) fn polyharmonic(patch: &Patch, shape: &[DVec3], order: usize) -> Option<Vec<DVec3>> {
    let go_on = || (!patch.cancel.is_cancelled()).then_some(());
    go_on()?;
    let near = patch.neighbourhood(order, shape);
    let (points, faces) = (near.points, near.faces);
    let (weights, twice) = half_cotangents(&points, &faces);
    let mut stiffness = Stiffness::new(points.len(), &faces);
    stiffness.set(&faces, &weights);
    // The equations of the vertices that move alone: of a small patch these are few beside all within `order` rings.
    let mut matrix = rows_of(&stiffness.matrix, &near.moving);
    if order > 1 {
        let areas = barycentric(points.len(), &faces, &twice);
        let mut scaled = stiffness.matrix;
        for (mut row, area) in scaled.outer_iterator_mut().zip(&areas) {
            row.iter_mut().for_each(|(_, v)| *v /= area);
        }
        for _ in 1..order {
            go_on()?;
            matrix = &matrix * &scaled;
        }
    }
    go_on()?;
    let solved = solve_for(&matrix, &near.moving, &[&points], &patch.cancel);
    solved.into_iter().flatten().next().flatten()
}

/// Some rows of a matrix, in the given order.
pub(super) fn rows_of(matrix: &CsMat<f64>, rows: &[u32]) -> CsMat<f64> {
    let mut starts = vec![0];
    let (mut columns, mut values) = (Vec::new(), Vec::new());
    for &i in rows {
        for row in matrix.outer_view(i as usize).iter() {
            columns.extend_from_slice(row.indices());
            values.extend_from_slice(row.data());
        }
        starts.push(columns.len());
    }
    CsMat::new((rows.len(), matrix.cols()), starts, columns, values)
}

/// Solves `A x = 0` for the unknown vertices (rising), to each of which a row of the matrix belongs, in their order; all other vertices are
/// where the points are. One solution for each set of points, none where it is not finite. None at all where the matrix cannot be
/// factorised, or the token is set.
pub(super) fn solve_for(
    matrix: &CsMat<f64>,
    unknowns: &[u32],
    sets: &[&[DVec3]],
    cancel: &Cancel,
) -> Option<Vec<Option<Vec<DVec3>>>> {
    let n = unknowns.len();
    let mut number = vec![usize::MAX; matrix.cols()];
    (0..n).for_each(|k| number[unknowns[k] as usize] = k);
    let mut starts = vec![0];
    let (mut columns, mut values) = (Vec::new(), Vec::new());
    let mut sides = vec![vec![DVec3::ZERO; n]; sets.len()];
    for (row, entries) in matrix.outer_iterator().enumerate() {
        for (j, &v) in entries.iter() {
            match number[j] {
                usize::MAX => {
                    for (rhs, points) in sides.iter_mut().zip(sets) {
                        rhs[row] -= v * points[j];
                    }
                }
                u => {
                    columns.push(u);
                    values.push(v);
                }
            }
        }
        starts.push(columns.len());
    }
    let inner = CsMat::new((n, n), starts, columns, values);
    if cancel.is_cancelled() {
        return None;
    }
    let pattern = LdlPattern::new(&inner, cancel);
    let factor = pattern.factorise(&inner, 0.0)?;
    let solved = sides.into_iter().map(|rhs| {
        let mut solution = vec![DVec3::ZERO; n];
        for axis in 0..3 {
            let mut b: Vec<f64> = rhs.iter().map(|r| r[axis]).collect();
            factor.solve(&mut b);
            solution.iter_mut().zip(b).for_each(|(s, b)| s[axis] = b);
        }
        solution.iter().all(|p| p.is_finite()).then_some(solution)
    });
    Some(solved.collect())
}
