//! The trilinear hexahedral element on the unit cube: 2 × 2 × 2 Gauss points and the centre.

use std::sync::LazyLock;

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
    let s = [0.5 - 0.5 / 3f64.sqrt(), 0.5 + 0.5 / 3f64.sqrt()];
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

#[inline]
pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;

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
