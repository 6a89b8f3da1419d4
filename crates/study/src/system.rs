//! The linear system of one semi-implicit step of Willmore flow on a square grid.

use super::grid::Stencils;
use super::plane::{Linearisation, PlaneEnergy};
use isomend_core::flow::Variant;
use isomend_core::linalg::{Csr, LinearOperator};

/// `A = M + τ/2 L1 + τ K M⁻¹ K'` on the free nodes; M⁻¹ acts on all nodes.
///
/// (K, K') is (L2, L3) for variant I, (L3, L3) for variant II and (L2, L2) for Gauss-Newton. These are three approximations of the
/// energy's Hessian. They share the right-hand side `−τ g`, and therefore the steady states.
#[doc(hidden)]
pub struct StepSystem<'a> {
    at: &'a Linearisation,
    outer: &'a Stencils,
    inner: &'a Stencils,
    free: &'a [bool],
    tau: f64,
    jacobi: Vec<f64>,
}

impl<'a> StepSystem<'a> {
    /// The system at a linearisation; `tau` is the time step.
    pub fn new(energy: &'a PlaneEnergy, at: &'a Linearisation, variant: Variant, tau: f64) -> Self {
        let (outer, inner) = match variant {
            Variant::I => (&at.tangential, &at.full),
            Variant::II => (&at.full, &at.full),
            Variant::GaussNewton => (&at.tangential, &at.tangential),
        };
        let mut system = Self {
            at,
            outer,
            inner,
            free: energy.free(),
            tau,
            jacobi: Vec::new(),
        };
        system.jacobi = (0..system.free.len())
            .map(|i| {
                if system.free[i] {
                    1.0 / system.diagonal(i)
                } else {
                    0.0
                }
            })
            .collect();
        system
    }

    fn diagonal(&self, i: usize) -> f64 {
        let mut product = 0.0;
        for k in 0..9 {
            let j = i.wrapping_add_signed(self.outer.offset(k));
            product +=
                self.outer.entry(k, i) * self.at.inverse_mass[j] * self.inner.entry(8 - k, j);
        }
        let d = self.at.mass[i] + self.tau * (0.5 * self.at.weighted.entry(4, i) + product);
        if d > 0.0 { d } else { 1.0 }
    }

    /// Writes the factors `M⁻¹ K'`, `τ D⁻¹ K` and `D⁻¹ (M + τ/2 L1)` in single precision, with the system's diagonal D.
    pub(super) fn round(
        &self,
        inner: &mut Stencils<f32>,
        outer: &mut Stencils<f32>,
        near: &mut Stencils<f32>,
    ) {
        let (at, tau, scale) = (self.at, self.tau, &self.jacobi);
        self.inner
            .round_scaled(|i| at.inverse_mass[i], |_| 0.0, inner);
        self.outer.round_scaled(|i| tau * scale[i], |_| 0.0, outer);
        at.weighted
            .round_scaled(|i| 0.5 * tau * scale[i], |i| scale[i] * at.mass[i], near);
    }

    /// The assembled matrix, over all entries of a field.
    pub fn matrix(&self) -> Csr {
        let n = self.free.len();
        Csr::from_rows(n, n, |i, sink| {
            if !self.free[i] {
                return;
            }
            sink.add(i as u32, self.at.mass[i]);
            for k in 0..9 {
                let j = i.wrapping_add_signed(self.outer.offset(k));
                if self.free[j] {
                    sink.add(j as u32, 0.5 * self.tau * self.at.weighted.entry(k, i));
                }
                let c = self.tau * self.outer.entry(k, i) * self.at.inverse_mass[j];
                if c == 0.0 {
                    continue;
                }
                for l in 0..9 {
                    let m = j.wrapping_add_signed(self.inner.offset(l));
                    if self.free[m] {
                        sink.add(m as u32, c * self.inner.entry(l, j));
                    }
                }
            }
        })
    }
}

impl LinearOperator for StepSystem<'_> {
    fn apply(&self, x: &[f64], y: &mut [f64]) {
        let mut bent = vec![0.0; x.len()];
        let mut back = vec![0.0; x.len()];
        self.inner.apply(x, &mut bent);
        bent.iter_mut()
            .zip(&self.at.inverse_mass)
            .for_each(|(b, m)| *b *= m);
        self.outer.apply(&bent, &mut back);
        self.at.weighted.apply(x, y);
        for (i, y) in y.iter_mut().enumerate() {
            *y = if self.free[i] {
                self.at.mass[i] * x[i] + self.tau * (0.5 * *y + back[i])
            } else {
                0.0
            };
        }
    }

    fn jacobi(&self) -> &[f64] {
        &self.jacobi
    }
}
