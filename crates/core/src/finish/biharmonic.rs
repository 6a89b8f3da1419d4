//! Harmonic, biharmonic and minimal-surface fills of a patch: linear solves that use only its triangles.

use glam::DVec3;
use sprs::CsMat;

use super::geometry::{Stiffness, barycentric, clamped_cotangents};
use super::patch::{Neighbourhood, Patch};
use crate::linalg::LdlPattern;
use crate::tuning::{Tunable, tunable};

/// Harmonic fills towards a minimal surface, at most.
const MINIMAL_STEPS: Tunable<usize> = tunable("finish.minimal_steps", 20);

/// Diameters. Harmonic fills have converged when no vertex moves farther than this.
const MINIMAL_TOLERANCE: Tunable<f64> = tunable("finish.minimal_tolerance", 1e-5);

/// Two harmonic fills, then the biharmonic one, `min xᵀ S M⁻¹ S x` with all other vertices fixed; each uses the cotangents of the
/// surface before. The result depends on the patch's triangulation but not on its shape, and keeps the slope at the rim. `None`
/// if a system cannot be solved. (M. Botsch, L. Kobbelt, "An intuitive framework for real-time freeform modeling", 2004.)
pub(super) fn biharmonic(patch: &Patch, shape: &[DVec3]) -> Option<Vec<DVec3>> {
    let mut shape = shape.to_vec();
    for order in [1, 1, 2] {
        shape = polyharmonic(patch, &shape, order)?;
    }
    Some(shape)
}

/// The surface of least area with the patch's rim and triangulation, by repeated harmonic fills, each with the cotangents of the
/// surface before (U. Pinkall, K. Polthier, "Computing discrete minimal surfaces and their conjugates", 1993). It ignores the
/// slope at the rim. `None` if a system cannot be solved.
pub(super) fn minimal(patch: &Patch, shape: &[DVec3]) -> Option<Vec<DVec3>> {
    let go_on = || (!patch.cancel.is_cancelled()).then_some(());
    go_on()?;
    let mut shape = shape.to_vec();
    let Neighbourhood {
        mut points,
        faces,
        moving,
    } = patch.neighbourhood(1, &shape);
    // Only the values of the matrix change from step to step; the pattern is analysed once.
    let mut stiffness = Stiffness::new(points.len(), &faces);
    let rows = moving.iter().copied();
    let system = System::new(patch, 1, &stiffness.matrix, rows, &moving)?;
    for _ in 0..MINIMAL_STEPS.get() {
        go_on()?;
        stiffness.set(&faces, &clamped_cotangents(&points, &faces).0);
        let next = only(system.solve(&stiffness.matrix, &[&points]))?;
        let ways = shape.iter().zip(&next).map(|(a, b)| a.distance(*b));
        let farthest = ways.fold(0.0, f64::max);
        for (&v, p) in moving.iter().zip(&next) {
            points[v as usize] = *p;
        }
        shape = next;
        if farthest < MINIMAL_TOLERANCE.get() * patch.diameter {
            break;
        }
    }
    Some(shape)
}

/// The polyharmonic fill of an order, `L (M⁻¹ L)ᵏ⁻¹ x = 0`, with the cotangents of a shape: harmonic (1), biharmonic (2) or
/// triharmonic (3), which also continues the curvature at the rim. `None` if the system cannot be solved or the token is set.
pub(super) fn polyharmonic(patch: &Patch, shape: &[DVec3], order: usize) -> Option<Vec<DVec3>> {
    let go_on = || (!patch.cancel.is_cancelled()).then_some(());
    go_on()?;
    let near = patch.neighbourhood(order, shape);
    let (points, faces) = (near.points, near.faces);
    let (weights, twice) = clamped_cotangents(&points, &faces);
    let mut stiffness = Stiffness::new(points.len(), &faces);
    stiffness.set(&faces, &weights);
    // Only the equations of moving vertices: in a small patch these are few compared to all vertices within `order` rings.
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
    let rows = 0..near.moving.len() as u32;
    let system = System::new(patch, order, &matrix, rows, &near.moving)?;
    only(system.solve(&matrix, &[&points]))
}

/// The given rows of a matrix, in the given order.
fn rows_of(matrix: &CsMat<f64>, rows: &[u32]) -> CsMat<f64> {
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

/// The structure of a linear system for some vertices with all others fixed, without the values of its matrix.
pub(super) struct System<'a> {
    /// The unknowns' rows and columns: the start of each row, and for each entry its column and its index in the matrix.
    starts: Vec<usize>,
    columns: Vec<usize>,
    places: Vec<usize>,
    /// The entries of fixed vertices in these rows: the row, the vertex, and the index in the matrix.
    given: Vec<[usize; 3]>,
    pattern: &'a LdlPattern,
}

impl<'a> System<'a> {
    /// The system for the moving vertices of a patch, by their numbers in the matrix (in rising order) and the rows of their equations,
    /// which reach `rings` rings of vertices; `None` if the token is set.
    pub(super) fn new(
        patch: &'a Patch,
        rings: usize,
        matrix: &CsMat<f64>,
        rows: impl Iterator<Item = u32>,
        unknowns: &[u32],
    ) -> Option<Self> {
        let n = unknowns.len();
        // The column of each unknown vertex.
        let mut number = vec![usize::MAX; matrix.cols()];
        for (column, &v) in unknowns.iter().enumerate() {
            number[v as usize] = column;
        }
        // Splits the entries of each row into unknown and fixed vertices.
        let (mut starts, mut columns, mut places) = (vec![0], Vec::new(), Vec::new());
        let mut given = Vec::new();
        for (row, i) in rows.enumerate() {
            for place in matrix.indptr().outer_inds_sz(i as usize) {
                let vertex = matrix.indices()[place];
                match number[vertex] {
                    usize::MAX => given.push([row, vertex, place]),
                    column => {
                        columns.push(column);
                        places.push(place);
                    }
                }
            }
            starts.push(columns.len());
        }
        if patch.cancel.is_cancelled() {
            return None;
        }
        // Symbolic analysis of the matrix of the unknowns.
        let zeros = vec![0.0; columns.len()];
        let inner = CsMat::new((n, n), starts.clone(), columns.clone(), zeros);
        Some(Self {
            pattern: patch.pattern(rings, &inner),
            starts,
            columns,
            places,
            given,
        })
    }

    /// Solves `A x = 0` with a matrix of the same pattern; all other vertices are fixed at their points. Returns one solution for each
    /// set of points, `None` where it is not finite; `None` altogether if the matrix cannot be factorised or the token is set.
    pub(super) fn solve(
        &self,
        matrix: &CsMat<f64>,
        sets: &[&[DVec3]],
    ) -> Option<Vec<Option<Vec<DVec3>>>> {
        let n = self.starts.len() - 1;
        let data = matrix.data();
        let values = self.places.iter().map(|place| data[*place]).collect();
        let inner = CsMat::new((n, n), self.starts.clone(), self.columns.clone(), values);
        let factor = self.pattern.factorise(&inner, 0.0)?;
        let solved = sets.iter().map(|points| {
            let mut rhs = vec![DVec3::ZERO; n];
            for &[row, vertex, place] in &self.given {
                rhs[row] -= data[place] * points[vertex];
            }
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
}

/// The single solution.
fn only(solved: Option<Vec<Option<Vec<DVec3>>>>) -> Option<Vec<DVec3>> {
    solved?.pop()?
}
