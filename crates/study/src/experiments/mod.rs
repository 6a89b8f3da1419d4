//! The experiments: the figures and Table 1 of the paper, closed surfaces, and fills of exact surfaces.

mod cap;
mod circle;
mod closed;
mod graph;
mod merge;
mod orthogonal;
mod patches;
mod surfaces;
mod table1;

pub use cap::{CapSettings, cap};
pub use circle::{CircleSettings, circle};
pub use closed::Closed;
pub use graph::{GraphSettings, graph};
pub use merge::{MergeSettings, merge};
pub use orthogonal::{OrthogonalSettings, orthogonal};
pub use patches::{PatchError, fill_shape, patch_error};
pub use patches::{PatchesSettings, patches};
pub use surfaces::{SurfacesSettings, surfaces};
pub use table1::{Table1Settings, table1};

use rayon::prelude::*;

use super::evolution::PlaneRun;
use super::observer::StudyError;
use super::report::{Chart, Curve, Panel, StatedBy, StudyReport};
use isomend_core::flow::Variant;

/// The name of a scheme.
fn variant_name(variant: Variant) -> &'static str {
    match variant {
        Variant::I => "I",
        Variant::II => "II",
        Variant::GaussNewton => "gauss-newton",
    }
}

/// Runs all settings in parallel, one per thread; the results are in the order of the settings.
fn in_parallel<S: Sync, R: Send>(
    settings: &[S],
    run: impl Fn(&S) -> Result<R, StudyError> + Sync + Send,
) -> Result<Vec<R>, StudyError> {
    settings.par_iter().with_max_len(1).map(run).collect()
}

/// Adds the claim that the energy falls in every step.
fn claim_fall(report: &mut StudyReport, evolution: &PlaneRun) {
    let (rises, steps) = (evolution.rises(), evolution.energies.len());
    report.claim(
        StatedBy::Theory,
        "energy",
        "falls in every step".to_owned(),
        format!("{rises} rises in {steps} steps"),
        rises == 0,
    );
}

/// A chart with linear axes.
fn chart(title: &str, axes: [&'static str; 2], curves: Vec<Curve>) -> Panel {
    Panel::Chart(Chart {
        title: title.to_owned(),
        axes,
        logarithmic: [false, false],
        order: None,
        curves,
    })
}

/// A curve that is drawn as a line.
fn line(name: &str, points: Vec<(f64, f64)>) -> Curve {
    Curve {
        name: name.to_owned(),
        points,
        dots: false,
    }
}
