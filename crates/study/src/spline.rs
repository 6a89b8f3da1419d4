//! The interpolating bicubic spline through nodal values, with its first and second derivatives.

use super::grid::SquareGrid;

/// A bicubic C² spline in B-spline coefficients, with not-a-knot ends.
#[doc(hidden)]
pub struct Spline {
    cells: usize,
    h: f64,
    origin: [f64; 2],
    /// Coefficients −1 to cells + 1 along both axes.
    coefficients: Vec<f64>,
}

/// Value, gradient and second derivatives (xx, xy, yy).
#[derive(Clone, Copy, Debug)]
#[doc(hidden)]
pub struct CurveJet {
    /// Value.
    pub value: f64,
    /// Gradient.
    pub gradient: [f64; 2],
    /// Second derivatives: xx, xy, yy.
    pub second: [f64; 3],
}

impl Spline {
    /// The spline through a nodal field; the grid needs at least four cells a side.
    pub fn new(grid: &SquareGrid, field: &[f64]) -> Self {
        let cells = grid.cells();
        let (nodes, side) = (cells + 1, cells + 3);
        let mut rows = vec![0.0; nodes * side];
        for j in 0..nodes {
            let values: Vec<f64> = (0..nodes).map(|i| field[grid.index(i, j)]).collect();
            rows[j * side..(j + 1) * side].copy_from_slice(&interpolate(&values));
        }
        let mut coefficients = vec![0.0; side * side];
        for i in 0..side {
            let values: Vec<f64> = (0..nodes).map(|j| rows[j * side + i]).collect();
            for (j, c) in interpolate(&values).into_iter().enumerate() {
                coefficients[j * side + i] = c;
            }
        }
        Self {
            cells,
            h: grid.h(),
            origin: grid.origin(),
            coefficients,
        }
    }

    /// Value and derivatives at a position; outside the square the polynomial of the outermost cell is continued.
    pub fn jet(&self, x: [f64; 2]) -> CurveJet {
        let (i, u) = self.cell((x[0] - self.origin[0]) / self.h);
        let (j, v) = self.cell((x[1] - self.origin[1]) / self.h);
        let (bx, by) = (basis(u), basis(v));
        let side = self.cells + 3;
        let mut sums = [[0.0; 3]; 3];
        for b in 0..4 {
            let row = &self.coefficients[(j + b) * side + i..][..4];
            let across = by.map(|weights| weights[b]);
            for (d, along) in bx.iter().enumerate() {
                let s: f64 = row.iter().zip(along).map(|(c, w)| c * w).sum();
                for (sum, w) in sums[d].iter_mut().zip(across).take(3 - d) {
                    *sum += s * w;
                }
            }
        }
        let (h, hh) = (self.h, self.h * self.h);
        CurveJet {
            value: sums[0][0],
            gradient: [sums[1][0] / h, sums[0][1] / h],
            second: [sums[2][0] / hh, sums[1][1] / hh, sums[0][2] / hh],
        }
    }

    fn cell(&self, t: f64) -> (usize, f64) {
        let i = t.floor().clamp(0.0, (self.cells - 1) as f64);
        (i as usize, t - i)
    }
}

/// The four cubic B-splines on a knot interval: values, first and second derivatives.
fn basis(t: f64) -> [[f64; 4]; 3] {
    let s = 1.0 - t;
    [
        [
            s * s * s / 6.0,
            (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0,
            (3.0 * s * s * s - 6.0 * s * s + 4.0) / 6.0,
            t * t * t / 6.0,
        ],
        [
            -0.5 * s * s,
            0.5 * t * (3.0 * t - 4.0),
            -0.5 * s * (3.0 * s - 4.0),
            0.5 * t * t,
        ],
        [s, 3.0 * t - 2.0, 3.0 * s - 2.0, t],
    ]
}

/// B-spline coefficients −1 to n of the cubic spline through n values, with not-a-knot ends.
fn interpolate(f: &[f64]) -> Vec<f64> {
    let n = f.len();
    let mut c = vec![0.0; n + 2];
    // Interpolation: (c₋ + 4c + c₊)/6 = f at every node. The not-a-knot conditions give the coefficients at the second and the
    // last but one node explicitly.
    c[2] = (8.0 * f[1] - f[0] - f[2]) / 6.0;
    c[n - 1] = (8.0 * f[n - 2] - f[n - 1] - f[n - 3]) / 6.0;
    // Forward elimination of the tridiagonal system for the inner coefficients.
    let inner = n - 4;
    let (mut slope, mut rest) = (vec![0.0; inner], vec![0.0; inner]);
    for k in 0..inner {
        let mut r = 6.0 * f[k + 2];
        if k == 0 {
            r -= c[2];
        }
        if k + 1 == inner {
            r -= c[n - 1];
        }
        let (above, before) = if k > 0 {
            (slope[k - 1], rest[k - 1])
        } else {
            (0.0, 0.0)
        };
        slope[k] = 1.0 / (4.0 - above);
        rest[k] = (r - before) * slope[k];
    }
    // Back substitution, then the end coefficients from the interpolation conditions.
    for k in (0..inner).rev() {
        let after = if k + 1 < inner { c[k + 4] } else { 0.0 };
        c[k + 3] = rest[k] - slope[k] * after;
    }
    c[1] = 6.0 * f[1] - 4.0 * c[2] - c[3];
    c[0] = 6.0 * f[0] - 4.0 * c[1] - c[2];
    c[n] = 6.0 * f[n - 2] - 4.0 * c[n - 1] - c[n - 2];
    c[n + 1] = 6.0 * f[n - 1] - 4.0 * c[n] - c[n - 1];
    c
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubics_are_reproduced_with_their_derivatives() {
        let grid = SquareGrid::new(7, [-1.0, 0.5], 2.0);
        let f = |[x, y]: [f64; 2]| x * x * x - 2.0 * x * y * y + y * y * y + 3.0 * x - y + 0.5;
        let spline = Spline::new(&grid, &grid.field(f));
        for p in [[-0.93, 0.51], [0.2, 1.7], [0.99, 2.49], [-0.3, 0.9]] {
            let jet = spline.jet(p);
            let [x, y] = p;
            let wanted = [
                f(p),
                3.0 * x * x - 2.0 * y * y + 3.0,
                -4.0 * x * y + 3.0 * y * y - 1.0,
                6.0 * x,
                -4.0 * y,
                -4.0 * x + 6.0 * y,
            ];
            let [gx, gy] = jet.gradient;
            let [xx, xy, yy] = jet.second;
            for (a, b) in [jet.value, gx, gy, xx, xy, yy].into_iter().zip(wanted) {
                assert!((a - b).abs() < 1e-10, "{p:?}: {a} {b}");
            }
        }
    }

    #[test]
    fn smooth_functions_are_approximated_to_fourth_order() {
        let error = |cells: usize| {
            let grid = SquareGrid::centred(cells);
            let f = |[x, y]: [f64; 2]| (5.0 * x + 1.0).sin() * (3.0 * y).exp();
            let spline = Spline::new(&grid, &grid.field(f));
            (0..400)
                .map(|k| {
                    [
                        0.4 * (0.1 * f64::from(k)).sin(),
                        0.4 * (0.37 * f64::from(k)).cos(),
                    ]
                })
                .map(|p| (spline.jet(p).value - f(p)).abs())
                .fold(0.0, f64::max)
        };
        let order = (error(16) / error(32)).log2();
        assert!(order > 3.5, "{order}");
    }
}
