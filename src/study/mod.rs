//! The experiments of the paper: level lines in the plane, and graphs.
//!
//! Droske and Rumpf, "A level set formulation for Willmore flow", 2004, by bilinear elements on squares. The schemes are
//! those of [`crate::flow`] ([`Variant`](crate::flow::Variant)), the solvers those of [`crate::linalg`]. The energy is
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

pub use contour::{Segment, level_line, pieces_inside};
pub use evolution::PlaneRun;
pub use grid::{SquareGrid, Stencils};
pub use multigrid::coarse_levels;
pub use observer::{Frame, Observer, Silent, StudyError};
pub use parametric::{ParametricFlow, ParametricStep};
pub use plane::{Linearisation, PlaneEnergy, Quadrature};
pub use plot::to_svg;
pub use redistance::{keeps_rule, redistance, redistance_interval, zero_points};
pub use report::{Cell, Chart, Claim, Curve, Levels, Panel, StudyReport, Table};
pub use spline::{Jet, Spline};
pub use start::harmonic_fill;
pub use step::{PlaneFlow, PlaneStep, Tolerance};
pub use system::StepSystem;
