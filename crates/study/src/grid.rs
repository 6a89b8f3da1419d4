//! A square grid of square cells, and sparse matrices on its nodes, stored as nine-point stencils.

use glam::DVec3;

use isomend_core::grid::Volume;
use isomend_core::grid::gauss_points;
use isomend_core::linalg::Real;

/// A square domain cut into `cells × cells` squares.
///
/// Nodal fields have a halo one node wide with value zero, so that stencils need no special case at the boundary.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub struct SquareGrid {
    cells: usize,
    h: f64,
    origin: [f64; 2],
}

impl SquareGrid {
    /// The square of the given side with its lower left corner at `origin`.
    pub fn new(cells: usize, origin: [f64; 2], side: f64) -> Self {
        Self {
            cells,
            h: side / cells as f64,
            origin,
        }
    }

    /// The unit square centred at the origin.
    pub fn centred(cells: usize) -> Self {
        Self::new(cells, [-0.5; 2], 1.0)
    }

    /// Number of cells along a side.
    pub fn cells(&self) -> usize {
        self.cells
    }

    /// Side length of a cell.
    pub fn h(&self) -> f64 {
        self.h
    }

    /// Lower left corner.
    pub fn origin(&self) -> [f64; 2] {
        self.origin
    }

    /// Offset in a field from a node to its upper neighbour.
    pub fn stride(&self) -> usize {
        self.cells + 3
    }

    /// Number of entries of a nodal field, with the halo.
    pub fn field_len(&self) -> usize {
        self.stride() * self.stride()
    }

    /// Index in a field of node (i, j), both from 0 to `cells`.
    #[inline]
    pub fn index(&self, i: usize, j: usize) -> usize {
        (j + 1) * self.stride() + i + 1
    }

    /// Position of node (i, j).
    pub fn position(&self, i: usize, j: usize) -> [f64; 2] {
        [
            self.origin[0] + self.h * i as f64,
            self.origin[1] + self.h * j as f64,
        ]
    }

    /// All nodes, row by row.
    pub fn nodes(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let n = self.cells;
        (0..=n).flat_map(move |j| (0..=n).map(move |i| (i, j)))
    }

    /// Indices in a field of the four corners of cell (i, j).
    #[inline]
    pub fn corners(&self, i: usize, j: usize) -> [usize; 4] {
        let (a, s) = (self.index(i, j), self.stride());
        [a, a + 1, a + s, a + s + 1]
    }

    /// Samples a function of the position at the nodes.
    pub fn field(&self, f: impl Fn([f64; 2]) -> f64) -> Vec<f64> {
        let mut out = vec![0.0; self.field_len()];
        for (i, j) in self.nodes() {
            out[self.index(i, j)] = f(self.position(i, j));
        }
        out
    }

    /// Values at the nodes, row by row, without the halo.
    pub fn strip(&self, field: &[f64]) -> Vec<f64> {
        self.nodes().map(|(i, j)| field[self.index(i, j)]).collect()
    }

    /// A field as a volume of one layer.
    pub fn volume(&self, field: &[f64]) -> Volume {
        let [x, y] = self.origin;
        Volume {
            dims: [self.cells + 1, self.cells + 1, 1],
            origin: DVec3::new(x, y, 0.0),
            spacing: DVec3::splat(self.h),
            values: self.strip(field),
        }
    }

    /// True at all nodes, or only at the inner ones if `boundary` is false; false in the halo.
    pub fn node_mask(&self, boundary: bool) -> Vec<bool> {
        let n = self.cells;
        let mut mask = vec![false; self.field_len()];
        for (i, j) in self.nodes() {
            let inner = i > 0 && j > 0 && i < n && j < n;
            mask[self.index(i, j)] = boundary || inner;
        }
        mask
    }

    /// `∫_∂Ω γ ψ_i` by two Gauss points on each boundary edge; γ takes a position and the outer normal. Equations (12), (13).
    pub fn boundary_load(&self, gamma: impl Fn([f64; 2], [f64; 2]) -> f64) -> Vec<f64> {
        let n = self.cells;
        let mut load = vec![0.0; self.field_len()];
        let mut edge = |a: (usize, usize), b: (usize, usize), normal: [f64; 2]| {
            let (p, q) = (self.position(a.0, a.1), self.position(b.0, b.1));
            for t in gauss_points() {
                let x = [p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])];
                let g = 0.5 * self.h * gamma(x, normal);
                load[self.index(a.0, a.1)] += g * (1.0 - t);
                load[self.index(b.0, b.1)] += g * t;
            }
        };
        for k in 0..n {
            edge((k, 0), (k + 1, 0), [0.0, -1.0]);
            edge((k, n), (k + 1, n), [0.0, 1.0]);
            edge((0, k), (0, k + 1), [-1.0, 0.0]);
            edge((n, k), (n, k + 1), [1.0, 0.0]);
        }
        load
    }

    /// L2 norm of the bilinear interpolant, by Gauss points.
    pub fn l2_norm(&self, field: &[f64]) -> f64 {
        let mut sum = 0.0;
        for j in 0..self.cells {
            for i in 0..self.cells {
                let v = self.corners(i, j).map(|k| field[k]);
                for shape in &super::element::ELEMENT.gauss {
                    sum += shape.value_of(&v).powi(2);
                }
            }
        }
        (0.25 * sum).sqrt() * self.h
    }
}

/// A matrix with an entry for each pair of nodes that share a cell, stored as nine planes of coefficients.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub struct Stencils<T = f64> {
    stride: usize,
    planes: [Vec<T>; 9],
}

impl<T: Real> Stencils<T> {
    /// The zero matrix.
    pub fn zero(grid: &SquareGrid) -> Self {
        Self {
            stride: grid.stride(),
            planes: std::array::from_fn(|_| vec![T::ZERO; grid.field_len()]),
        }
    }

    /// Offset in a field of the neighbour that plane `k` belongs to.
    #[inline]
    pub fn offset(&self, k: usize) -> isize {
        (k as isize / 3 - 1) * self.stride as isize + k as isize % 3 - 1
    }

    /// Coefficient of the neighbour `k` of node `i`.
    #[inline]
    pub fn entry(&self, k: usize, i: usize) -> T {
        self.planes[k][i]
    }

    /// `y = A x`.
    pub fn apply(&self, x: &[T], y: &mut [T]) {
        let s = self.stride;
        y[..s].fill(T::ZERO);
        let end = y.len() - s;
        y[end..].fill(T::ZERO);
        for row in 1..s - 1 {
            (y[row * s], y[row * s + s - 1]) = (T::ZERO, T::ZERO);
        }
        self.multiply(x, y, |y, product| *y = product);
    }

    /// `y += A x`.
    pub fn apply_add(&self, x: &[T], y: &mut [T]) {
        self.multiply(x, y, |y, product| *y += product);
    }

    #[inline(always)]
    fn multiply(&self, x: &[T], y: &mut [T], put: impl Fn(&mut T, T)) {
        let s = self.stride;
        let width = s - 2;
        for row in 1..s - 1 {
            let at = row * s + 1;
            let a: [&[T]; 9] = std::array::from_fn(|k| &self.planes[k][at..at + width]);
            let v: [&[T]; 9] = std::array::from_fn(|k| {
                let first = at.wrapping_add_signed(self.offset(k));
                &x[first..first + width]
            });
            let out = &mut y[at..at + width];
            for i in 0..width {
                let product = (a[0][i] * v[0][i] + a[1][i] * v[1][i] + a[2][i] * v[2][i])
                    + (a[3][i] * v[3][i] + a[4][i] * v[4][i] + a[5][i] * v[5][i])
                    + (a[6][i] * v[6][i] + a[7][i] * v[7][i] + a[8][i] * v[8][i]);
                put(&mut out[i], product);
            }
        }
    }
}

impl Stencils {
    /// Adds a symmetric element matrix; `element` is its upper triangle row by row.
    #[inline]
    pub fn add(&mut self, corners: &[usize; 4], element: &[f64; 10]) {
        let mut e = 0;
        for a in 0..4 {
            for b in a..4 {
                let k = plane(a, b);
                self.planes[k][corners[a]] += element[e];
                if a != b {
                    self.planes[8 - k][corners[b]] += element[e];
                }
                e += 1;
            }
        }
    }

    /// Writes the matrix in single precision to `to`, with its rows multiplied by `scale` and `diagonal` added to its diagonal.
    pub fn round_scaled(
        &self,
        scale: impl Fn(usize) -> f64,
        diagonal: impl Fn(usize) -> f64,
        to: &mut Stencils<f32>,
    ) {
        for (k, (plane, rounded)) in self.planes.iter().zip(&mut to.planes).enumerate() {
            for (i, (value, rounded)) in plane.iter().zip(rounded).enumerate() {
                let more = if k == 4 { diagonal(i) } else { 0.0 };
                *rounded = (scale(i) * value + more) as f32;
            }
        }
    }
}

/// Plane of the coefficient that couples corner `a` of a cell to corner `b`.
const fn plane(a: usize, b: usize) -> usize {
    3 * (1 + (b >> 1) - (a >> 1)) + 1 + (b & 1) - (a & 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_boundary_load_of_one_is_the_perimeter() {
        let grid = SquareGrid::new(6, [1.0, 2.0], 3.0);
        let load = grid.boundary_load(|_, _| 1.0);
        assert!((load.iter().sum::<f64>() - 12.0).abs() < 1e-12);
    }

    #[test]
    fn the_norm_of_a_bilinear_function_is_exact() {
        let grid = SquareGrid::new(5, [0.0, 0.0], 2.0);
        let norm = grid.l2_norm(&grid.field(|[x, y]| 1.0 + x * y));
        // ∫ (1 + xy)² over (0, 2)².
        let exact = 4.0 + 2.0 * 4.0 + 64.0 / 9.0;
        assert!((norm * norm - exact).abs() < 1e-12);
    }
}
