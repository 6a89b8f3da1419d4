//! Closed test surfaces as level sets, each on its own lattice, with measurements of their shape.

use std::f64::consts::PI;

use glam::DVec3;
use rayon::prelude::*;

use super::variant_name;
use crate::observer::{Frame, Observer, StudyError};
use isomend_core::flow::Evolution;
use isomend_core::grid::{Lattice, SparseGrid, Volume, as_point};
use isomend_core::mesh::bounds;
use isomend_core::sdf::project_on_zero_set;

/// Length that `voxels` voxels cover: about the width of the torus.
pub const SIDE: f64 = 3.4;
/// Margin of the lattice round a surface's box, in voxels; it holds the band and the fixed nodes.
const MARGIN: f64 = 8.0;

/// A closed surface at time 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Closed {
    /// The unit sphere.
    Sphere,
    /// The unit sphere with a spherical harmonic of degree 2; amplitude 2.5 % of the radius.
    Wave,
    /// The torus of revolution with radii 1 and ½.
    Torus,
    /// The unit sphere with spherical harmonics of degree 2 and 3, weighted by 15 % of the radius.
    Uneven,
    /// The cube of side 1.7.
    Cube,
}

impl Closed {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Sphere => "sphere",
            Self::Wave => "sphere with a wave",
            Self::Torus => "torus",
            Self::Uneven => "uneven sphere",
            Self::Cube => "cube",
        }
    }

    /// The initial level set function: negative inside, with a gradient of length about 1.
    pub(super) fn level(self, p: DVec3) -> f64 {
        match self {
            Self::Sphere => p.length() - 1.0,
            Self::Wave => {
                let n = p.normalize_or(DVec3::X);
                p.length() - (1.0 + 0.05 * n.y * n.z)
            }
            Self::Torus => (p.x.hypot(p.y) - 1.0).hypot(p.z) - 0.5,
            Self::Uneven => {
                let n = p.normalize_or(DVec3::X);
                let waves = n.y * n.z + 0.4 * n.x * (n.x * n.x - 3.0 * n.y * n.y);
                p.length() - (1.0 + 0.15 * waves)
            }
            Self::Cube => {
                let out = p.abs() - DVec3::splat(0.85);
                out.max(DVec3::ZERO).length() + out.max_element().min(0.0)
            }
        }
    }

    /// Half the side lengths of a box that the surface never leaves.
    pub(super) fn reach(self) -> DVec3 {
        match self {
            Self::Torus => DVec3::new(1.55, 1.55, 0.75),
            _ => DVec3::splat(1.22),
        }
    }

    /// ½∫h² of the steady state: 8π for a sphere, 4π² for the Clifford torus (with H = h/2 these are ∫H² = 4π and 2π²).
    pub(super) fn steady_energy(self) -> f64 {
        match self {
            Self::Torus => 4.0 * PI * PI,
            _ => 8.0 * PI,
        }
    }
}

/// Shape measurements of the zero set.
#[derive(Clone, Copy, Debug)]
pub(super) struct Form {
    /// Mean of the largest and the smallest radius; for a torus the radius of its centre circle.
    pub(super) radius: f64,
    /// Half the difference of the largest and the smallest radius over their mean; for a torus the ratio of its two radii.
    pub(super) shape: f64,
}

/// The level set of a surface on its own lattice.
pub(super) struct Field {
    pub(super) surface: Closed,
    pub(super) lattice: Lattice,
    pub(super) grid: SparseGrid,
    /// φ, in voxels.
    pub(super) phi: Vec<f64>,
}

impl Field {
    pub(super) fn new(surface: Closed, voxels: usize) -> Self {
        let voxel = SIDE / voxels as f64;
        let half = surface.reach() + MARGIN * voxel;
        let dims = (2.0 * half / voxel).to_array().map(|n| n.ceil() as i32 + 1);
        // The shift keeps the lattice planes off the surface's planes of symmetry.
        let lattice = Lattice {
            origin: -half + voxel * DVec3::new(0.137, -0.251, 0.319),
            voxel,
        };
        let grid = SparseGrid::new(dims, |_| true);
        let position = |s: usize| lattice.to_world(as_point(grid.node(s)));
        let phi = (0..grid.len())
            .map(|s| surface.level(position(s)) / voxel)
            .collect();
        Self {
            surface,
            lattice,
            grid,
            phi,
        }
    }

    pub(super) fn form(&self) -> Form {
        form(self.surface, &self.grid, &self.phi, &self.lattice)
    }

    /// Sends progress and the current field to the observer.
    pub(super) fn report(
        &self,
        evolution: &Evolution,
        form: Form,
        observer: &dyn Observer,
    ) -> Result<(), StudyError> {
        let (name, variant) = (
            self.surface.name(),
            variant_name(evolution.settings.variant),
        );
        let (step, time) = (
            evolution.steps.len(),
            evolution.time * self.lattice.voxel.powi(4),
        );
        observer.progress(&format!(
            "{name}, {variant}: time {time:.2e}, step {step}, 1/2 int h^2 {:.4}, {:.5}",
            evolution.willmore(),
            form.shape
        ));
        observer.frame(&Frame {
            series: &format!("surfaces-{}-{variant}", name.replace(' ', "-")),
            step,
            time,
            volume: &volume(&self.grid, &self.phi, &self.lattice),
        })
    }
}

/// Measures the zero set by the projections of the nodes near it.
fn form(surface: Closed, grid: &SparseGrid, phi: &[f64], lattice: &Lattice) -> Form {
    let feet: Vec<DVec3> = (0..grid.len())
        .into_par_iter()
        .filter(|&s| phi[s].abs() < 0.9)
        .filter_map(|s| {
            let x = as_point(grid.node(s));
            project_on_zero_set(grid, phi, x, x).map(|p| lattice.to_world(p))
        })
        .collect();
    let centre = feet.iter().sum::<DVec3>() / feet.len().max(1) as f64;
    let extremes = |values: &dyn Fn(&DVec3) -> f64| {
        feet.iter()
            .map(values)
            .fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), v| {
                (low.min(v), high.max(v))
            })
    };
    if surface == Closed::Torus {
        let (low, high) = extremes(&|p| (*p - centre).truncate().length());
        return Form {
            radius: 0.5 * (low + high),
            shape: (low + high) / (high - low),
        };
    }
    // Take the middle of the bounding box: it does not depend on the distribution of the projections.
    let (low, high) = bounds(feet.iter().copied());
    let middle = 0.5 * (low + high);
    let (low, high) = extremes(&|p| p.distance(middle));
    Form {
        radius: 0.5 * (low + high),
        shape: (high - low) / (high + low),
    }
}

/// φ in units of length, as a volume.
fn volume(grid: &SparseGrid, phi: &[f64], lattice: &Lattice) -> Volume {
    let dims = grid.dims().map(|n| n as usize);
    let mut values = vec![0.0; dims.iter().product()];
    for (s, v) in phi.iter().enumerate() {
        let [i, j, k] = grid.node(s).map(|n| n as usize);
        values[(k * dims[1] + j) * dims[0] + i] = v * lattice.voxel;
    }
    Volume {
        dims,
        origin: lattice.origin,
        spacing: DVec3::splat(lattice.voxel),
        values,
    }
}
