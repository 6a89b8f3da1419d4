//! Shape functions of the bilinear finite element on the unit square, at the 2 × 2 Gauss points and at the centre.

use std::sync::LazyLock;

use isomend_core::grid::gauss_points;

/// Values and gradients of the four shape functions at one point; corner `a` is at (a & 1, a >> 1).
#[derive(Clone, Copy)]
pub struct Shape {
    /// Values.
    pub value: [f64; 4],
    /// Derivatives along x and y on the unit square.
    pub gradient: [[f64; 4]; 2],
    /// Products of the gradients, `∇ψa·∇ψb`: the upper triangle row by row.
    pub products: [f64; 10],
}

impl Shape {
    fn at(x: f64, y: f64) -> Self {
        let gradient @ [gx, gy] = [[y - 1.0, 1.0 - y, -y, y], [x - 1.0, -x, 1.0 - x, x]];
        let mut products = [0.0; 10];
        let pairs = (0..4).flat_map(|a| (a..4).map(move |b| (a, b)));
        for (product, (a, b)) in products.iter_mut().zip(pairs) {
            *product = gx[a] * gx[b] + gy[a] * gy[b];
        }
        Self {
            value: [(1.0 - x) * (1.0 - y), x * (1.0 - y), (1.0 - x) * y, x * y],
            gradient,
            products,
        }
    }

    /// Gradient of the interpolant with corner values `v`.
    #[inline]
    pub fn gradient_of(&self, v: &[f64; 4]) -> [f64; 2] {
        let [gx, gy] = &self.gradient;
        [
            gx[0] * v[0] + gx[1] * v[1] + gx[2] * v[2] + gx[3] * v[3],
            gy[0] * v[0] + gy[1] * v[1] + gy[2] * v[2] + gy[3] * v[3],
        ]
    }

    /// Value of the interpolant with corner values `v`.
    #[inline]
    pub fn value_of(&self, v: &[f64; 4]) -> f64 {
        let n = &self.value;
        n[0] * v[0] + n[1] * v[1] + n[2] * v[2] + n[3] * v[3]
    }
}

/// The element's quadrature points.
pub struct SquareElement {
    /// The four Gauss points, each of weight 1/4.
    pub gauss: [Shape; 4],
    /// The centre.
    pub centre: Shape,
}

/// The shape functions at the quadrature points, computed once.
pub static ELEMENT: LazyLock<SquareElement> = LazyLock::new(|| {
    let g = gauss_points();
    SquareElement {
        gauss: std::array::from_fn(|q| Shape::at(g[q & 1], g[q >> 1])),
        centre: Shape::at(0.5, 0.5),
    }
});
