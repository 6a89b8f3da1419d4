//! The experiments of the paper on Willmore flow of level lines in the plane and of graphs; also closed surfaces in time, and fills of
//! exact surfaces.
//!
//! The paper is Droske and Rumpf, "A level set formulation for Willmore flow", 2004. The plane is discretised by bilinear elements
//! on a square grid. The schemes come from `flow` ([`Variant`](isomend_core::flow::Variant)), the solvers from `linalg`. The energy in the plane is
//! the paper's, without the localisation that filling a hole needs.
//!
//! Each experiment of [`experiments`] returns a [`StudyReport`]: tables, the stated values beside the measured ones, and charts.
#![warn(missing_docs)]

mod axis;
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

pub use isomend_core::flow::FlowSettings;
pub use observer::{Frame, Observer, Silent, StudyError};
pub use plot::to_svg;
pub use report::{Chart, Claim, Curve, Levels, Panel, ResultTable, StudyReport, TableCell};

pub use {
    contour::{Segment, components_inside, level_line},
    evolution::PlaneRun,
    grid::{SquareGrid, Stencils},
    multigrid::coarse_levels,
    parametric::{ParametricFlow, ParametricStep},
    plane::{Linearisation, PlaneEnergy, Quadrature},
    redistance::{keeps_rule, redistance, redistance_interval, zero_points},
    spline::{CurveJet, Spline},
    start::harmonic_fill,
    step::{PlaneFlow, PlaneStep, Tolerance},
    system::StepSystem,
};
