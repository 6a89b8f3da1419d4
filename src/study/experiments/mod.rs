//! The experiments.

mod cap;
mod circle;
mod graph;
mod merge;
mod orthogonal;
mod patches;
mod table1;

pub use cap::{CapSettings, cap};
pub use circle::{CircleSettings, circle};
pub use graph::{GraphSettings, graph};
pub use merge::{MergeSettings, merge};
pub use orthogonal::{OrthogonalSettings, orthogonal};
pub use patches::{PatchError, PatchesSettings, fill_shape, patch_error, patches};
pub use table1::{Table1Settings, table1};

use rayon::prelude::*;

use super::observer::StudyError;
use crate::flow::Variant;

/// The name of a scheme.
fn variant_name(variant: Variant) -> &'static str {
    match variant {
        Variant::I => "I",
        Variant::II => "II",
        Variant::GaussNewton => "gauss-newton",
    }
}

/// Runs at the same time, as many as there are threads; the results are in order.
fn in_parallel<S: Sync, R: Send>(
    settings: &[S],
    run: impl Fn(&S) -> Result<R, StudyError> + Sync + Send,
) -> Result<Vec<R>, StudyError> {
    settings.par_iter().with_max_len(1).map(run).collect()
}
