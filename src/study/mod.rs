//! The experiments of the paper: level lines in the plane, and graphs.
//!
//! Droske and Rumpf, "A level set formulation for Willmore flow", 2004, by bilinear elements on squares. The schemes are
//! those of `flow` ([`Variant`](crate::Variant)), the solvers those of `linalg`. The energy is
//! that of the paper, without the localisation that the fill of a hole needs.
//!
//! Each experiment of [`experiments`] hands back a [`StudyReport`]: tables, what was stated beside what was got, and what
//! to draw.

mod contour;
mod element;
mod evolution;
pub mod experiments;
mod grid;
mod mirror;
mod multigrid;
mod observer;
mod parametric;
mod plane;
mod plot;
mod redistance;
mod refined;
mod report;
pub mod shapes;
mod spline;
mod start;
mod step;
mod system;

pub use crate::flow::FlowSettings;
pub use observer::{Frame, Observer, Silent, StudyError};
pub use plot::to_svg;
pub use report::{Cell, Chart, Claim, Curve, Levels, Panel, StudyReport, Table};

#[cfg(feature = "internals")]
#[doc(hidden)]
pub use {
    contour::{Segment, level_line, pieces_inside},
    evolution::PlaneRun,
    grid::{SquareGrid, Stencils},
    multigrid::coarse_levels,
    parametric::{ParametricFlow, ParametricStep},
    plane::{Linearisation, PlaneEnergy, Quadrature},
    redistance::{keeps_rule, redistance, redistance_interval, zero_points},
    spline::{Jet, Spline},
    start::harmonic_fill,
    step::{PlaneFlow, PlaneStep, Tolerance},
    system::StepSystem,
};
