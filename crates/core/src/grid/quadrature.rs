//! Gauss quadrature on a lattice cell.

/// Abscissae of the two-point Gauss rule on [0, 1].
pub fn gauss_points() -> [f64; 2] {
    let s = 0.5 / 3f64.sqrt();
    [0.5 - s, 0.5 + s]
}
