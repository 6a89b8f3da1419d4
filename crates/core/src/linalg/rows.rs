//! Inner loops over rows of dense matrices: scalar product and axpy.

/// `a · b`, in eight independent sums (for instruction-level parallelism).
#[inline]
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().min(b.len());
    let (x, last_x) = a[..n].as_chunks::<8>();
    let (y, last_y) = b[..n].as_chunks::<8>();
    let mut sums = [0.0; 8];
    for (x, y) in x.iter().zip(y) {
        for d in 0..8 {
            sums[d] += x[d] * y[d];
        }
    }
    let rest: f64 = last_x.iter().zip(last_y).map(|(x, y)| x * y).sum();
    let half = [0, 1, 2, 3].map(|d| sums[d] + sums[d + 4]);
    (half[0] + half[2]) + (half[1] + half[3]) + rest
}

/// `y ← y + s x`.
#[inline]
pub(super) fn axpy(s: f64, x: &[f64], y: &mut [f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += s * x;
    }
}
