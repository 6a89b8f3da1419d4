//! Tricubic Lagrange and trilinear interpolation on a sparse lattice.

use glam::DVec3;

use super::sparse::SparseGrid;

/// Weights of the cubic Lagrange polynomial on the nodes −1, 0, 1, 2, and their derivatives.
fn lagrange(t: f64) -> ([f64; 4], [f64; 4]) {
    let (m, z, p, q) = (t + 1.0, t, t - 1.0, t - 2.0);
    (
        [
            -z * p * q / 6.0,
            m * p * q / 2.0,
            -m * z * q / 2.0,
            m * z * p / 6.0,
        ],
        [
            -(p * q + z * q + z * p) / 6.0,
            (p * q + m * q + m * p) / 2.0,
            -(z * q + m * q + m * z) / 2.0,
            (z * p + m * p + m * z) / 6.0,
        ],
    )
}

/// The 4 × 4 × 4 node values around a cell, cached for evaluation within it.
pub struct Tricubic {
    base: [i32; 3],
    values: [f64; 64],
}

impl Default for Tricubic {
    /// An empty cache.
    fn default() -> Self {
        Self {
            base: [i32::MIN; 3],
            values: [0.0; 64],
        }
    }
}

impl Tricubic {
    /// Loads the values around the cell that contains `p` (lattice coordinates), unless they are cached. False if a
    /// node is not stored.
    pub fn gather(&mut self, grid: &SparseGrid, field: &[f64], p: DVec3) -> bool {
        if !p.is_finite() {
            return false;
        }
        let mut base = [0; 3];
        for a in 0..3 {
            let top = grid.dims()[a] - 3;
            if top < 1 {
                return false;
            }
            base[a] = floor(p[a]).clamp(1, top);
        }
        base == self.base || {
            self.base = base;
            let whole = grid.gather_cube(base.map(|b| b - 1), field, &mut self.values);
            if !whole {
                *self = Self::default();
            }
            whole
        }
    }

    /// Value and gradient at `p`; both in lattice units.
    pub fn evaluate(&self, p: DVec3) -> (f64, DVec3) {
        let (wx, dx) = lagrange(p.x - f64::from(self.base[0]));
        let (wy, dy) = lagrange(p.y - f64::from(self.base[1]));
        let (wz, dz) = lagrange(p.z - f64::from(self.base[2]));
        // Sum along x, y, z in turn. The inner loops run over the nodes of a plane, then of a line.
        let (mut plane, mut slope) = ([0.0; 16], [0.0; 16]);
        for (i, layer) in self.values.chunks_exact(16).enumerate() {
            for k in 0..16 {
                plane[k] += wx[i] * layer[k];
                slope[k] += dx[i] * layer[k];
            }
        }
        let (mut f, mut fx, mut fy) = ([0.0; 4], [0.0; 4], [0.0; 4]);
        for j in 0..4 {
            for k in 0..4 {
                f[k] += wy[j] * plane[4 * j + k];
                fx[k] += wy[j] * slope[4 * j + k];
                fy[k] += dy[j] * plane[4 * j + k];
            }
        }
        let dot =
            |a: &[f64; 4], w: &[f64; 4]| a[0] * w[0] + a[1] * w[1] + a[2] * w[2] + a[3] * w[3];
        let gradient = DVec3::new(dot(&fx, &wz), dot(&fy, &wz), dot(&f, &dz));
        (dot(&f, &wz), gradient)
    }
}

/// The largest integer not above `x`, without a library call.
fn floor(x: f64) -> i32 {
    let i = x as i32;
    i - i32::from(f64::from(i) > x)
}

/// Tricubic value and gradient of a field at `p` (lattice coordinates); `None` if a node is not stored.
pub fn value_and_gradient(grid: &SparseGrid, field: &[f64], p: DVec3) -> Option<(f64, DVec3)> {
    let mut patch = Tricubic::default();
    patch.gather(grid, field, p).then(|| patch.evaluate(p))
}

/// Trilinear value of a field at `p` (lattice coordinates). Corners that are not stored are left out of the weights.
pub fn linear(grid: &SparseGrid, field: &[f64], p: DVec3) -> Option<f64> {
    let base = p.floor();
    let t = p - base;
    let (mut sum, mut weights) = (0.0, 0.0);
    for a in 0..8 {
        let o = [(a >> 2) & 1, (a >> 1) & 1, a & 1];
        let n = [
            base.x as i32 + o[0],
            base.y as i32 + o[1],
            base.z as i32 + o[2],
        ];
        let w: f64 = (0..3)
            .map(|d| if o[d] == 1 { t[d] } else { 1.0 - t[d] })
            .product();
        if let (true, Some(slot)) = (w > 0.0, grid.slot(n)) {
            sum += w * field[slot];
            weights += w;
        }
    }
    (weights > 0.0).then(|| sum / weights)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::as_point;

    #[test]
    fn cubics_are_reproduced_with_their_gradient() {
        let grid = SparseGrid::new([8, 8, 8], |_| true);
        let f = |p: DVec3| p.x * p.x * p.x - 2.0 * p.y * p.z * p.z + p.x * p.y * p.z + 1.0;
        let field: Vec<f64> = (0..grid.len()).map(|s| f(as_point(grid.node(s)))).collect();
        for p in [DVec3::new(2.3, 3.7, 4.1), DVec3::new(0.2, 6.9, 3.0)] {
            let (v, g) = value_and_gradient(&grid, &field, p).unwrap();
            let e = 1e-5;
            let d = |a: DVec3| (f(p + a * e) - f(p - a * e)) / (2.0 * e);
            assert!((v - f(p)).abs() < 1e-9);
            assert!((g - DVec3::new(d(DVec3::X), d(DVec3::Y), d(DVec3::Z))).length() < 1e-6);
        }
    }
}
