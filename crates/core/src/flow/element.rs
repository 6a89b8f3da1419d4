//! The trilinear hexahedral element on the unit cube: 2 × 2 × 2 Gauss points and the centre.

use std::sync::LazyLock;

use crate::grid::gauss_points;

/// Gradients of the 8 shape functions at one point; corner `a` is at (a >> 2, (a >> 1) & 1, a & 1).
pub type Gradients = [[f64; 8]; 3];

/// `∇N_a · ∇N_b` at one point, entry `8 a + b`.
pub type Products = [f32; 64];

/// Shape-function gradients at the quadrature points.
pub struct Element {
    /// At the eight Gauss points, each of weight 1/8.
    pub gauss: [Gradients; 8],
    /// At the centre.
    pub centre: Gradients,
    /// Products of the gradients at the Gauss points.
    pub gauss_products: [Products; 8],
    /// Products of the gradients at the centre.
    pub centre_products: Products,
}

/// The element's constant tables.
pub static ELEMENT: LazyLock<Element> = LazyLock::new(|| {
    let s = gauss_points();
    let gauss: [Gradients; 8] =
        std::array::from_fn(|q| gradients([s[(q >> 2) & 1], s[(q >> 1) & 1], s[q & 1]]));
    let centre = gradients([0.5; 3]);
    Element {
        gauss_products: gauss.each_ref().map(products),
        centre_products: products(&centre),
        gauss,
        centre,
    }
});

fn products(shape: &Gradients) -> Products {
    std::array::from_fn(|i| {
        let (a, b) = (i / 8, i % 8);
        (0..3).map(|d| shape[d][a] * shape[d][b]).sum::<f64>() as f32
    })
}

fn gradients(p: [f64; 3]) -> Gradients {
    let factor = |a: usize, along: usize, d: usize| match ((a >> (2 - d)) & 1 == 1, d == along) {
        (true, true) => 1.0,
        (false, true) => -1.0,
        (true, false) => p[d],
        (false, false) => 1.0 - p[d],
    };
    std::array::from_fn(|along| {
        std::array::from_fn(|a| (0..3).map(|d| factor(a, along, d)).product())
    })
}

/// The gradient of the interpolant with corner values `v`.
#[inline]
pub fn gradient(shape: &Gradients, v: &[f64; 8]) -> [f64; 3] {
    std::array::from_fn(|d| {
        let s = &shape[d];
        (s[0] * v[0] + s[1] * v[1] + s[2] * v[2] + s[3] * v[3])
            + (s[4] * v[4] + s[5] * v[5] + s[6] * v[6] + s[7] * v[7])
    })
}

/// [`gauss_points`] as constants for the innermost loop: the two positions along an edge. Each is also the other's interpolation
/// weight.
const NEAR: f64 = 0.211_324_865_405_187_13;
const FAR: f64 = 1.0 - NEAR;

/// Bilinear interpolation from the corners of a square to its 2 × 2 Gauss points. The matrix is its own transpose.
#[inline]
fn at_gauss([a, b, c, d]: [f64; 4]) -> [f64; 4] {
    let (first, second) = (FAR * a + NEAR * c, FAR * b + NEAR * d);
    let (third, fourth) = (NEAR * a + FAR * c, NEAR * b + FAR * d);
    [
        FAR * first + NEAR * second,
        NEAR * first + FAR * second,
        FAR * third + NEAR * fourth,
        NEAR * third + FAR * fourth,
    ]
}

/// For each axis, the first corners of the four edges along it; also the Gauss points in the first half of the cell along it.
const EDGES: [[usize; 4]; 3] = [[0, 1, 2, 3], [0, 1, 4, 5], [0, 2, 4, 6]];
/// For each axis, the index difference between the two corners of an edge.
const STEPS: [usize; 3] = [4, 2, 1];

/// The gradients at the eight Gauss points of the interpolant with corner values `v`. The derivative along an axis is constant
/// along that axis, and bilinear in the differences along the four edges.
#[inline]
pub fn gauss_gradients(v: &[f64; 8]) -> [[f64; 3]; 8] {
    let mut out = [[0.0; 3]; 8];
    for (d, (edges, step)) in EDGES.iter().zip(STEPS).enumerate() {
        let slopes = at_gauss(edges.map(|a| v[a + step] - v[a]));
        for (&q, slope) in edges.iter().zip(slopes) {
            out[q][d] = slope;
            out[q + step][d] = slope;
        }
    }
    out
}

/// Tests vectors at the eight Gauss points with the gradients of the shape functions: `Σ_q p_q · ∇N_a(q)`.
#[inline]
pub fn against_gradients(p: &[[f64; 3]; 8]) -> [f64; 8] {
    let mut out = [0.0; 8];
    for (d, (edges, step)) in EDGES.iter().zip(STEPS).enumerate() {
        let sums = at_gauss(edges.map(|q| p[q][d] + p[q + step][d]));
        for (&a, sum) in edges.iter().zip(sums) {
            out[a + step] += sum;
            out[a] -= sum;
        }
    }
    out
}

#[inline]
pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gradients_at_the_gauss_points_and_sums_against_them_are_those_of_the_shape_functions() {
        let v: [f64; 8] = std::array::from_fn(|a| (1.7 * a as f64).sin());
        let gradients = gauss_gradients(&v);
        for (shape, found) in ELEMENT.gauss.iter().zip(gradients) {
            let wanted = gradient(shape, &v);
            assert!((0..3).all(|d| (found[d] - wanted[d]).abs() < 1e-14));
        }
        for (a, found) in against_gradients(&gradients).into_iter().enumerate() {
            let terms = ELEMENT.gauss.iter().zip(gradients);
            let wanted: f64 = terms
                .map(|(shape, g)| (0..3).map(|d| g[d] * shape[d][a]).sum::<f64>())
                .sum();
            assert!((found - wanted).abs() < 1e-14);
        }
    }

    #[test]
    fn a_linear_function_has_its_gradient_everywhere() {
        let v: [f64; 8] = std::array::from_fn(|a| {
            2.0 * ((a >> 2) & 1) as f64 - 3.0 * ((a >> 1) & 1) as f64 + 0.5 * (a & 1) as f64
        });
        for shape in ELEMENT.gauss.iter().chain([&ELEMENT.centre]) {
            let g = gradient(shape, &v);
            for (x, y) in g.iter().zip([2.0, -3.0, 0.5]) {
                assert!((x - y).abs() < 1e-14);
            }
        }
    }
}
