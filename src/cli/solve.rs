//! What the parameters of a solve ask for together.

use anyhow::bail;
use isomend::{FillParams, SurfaceKind};

use super::Usage;

/// Whether the parameters of a solve go together.
///
/// # Errors
/// With the options that do not.
pub fn check(params: &FillParams) -> anyhow::Result<()> {
    let metrics = params.energy.needs().metrics;
    if !metrics.contains(&params.variant) || (metrics.len() == 1 && params.time_step.is_some()) {
        bail!("--variant and --time-step are for the Willmore energy; leave them out, or --energy");
    }
    // It has no effect on a level set's own triangles.
    if params.surface == SurfaceKind::Whole && params.edge_ratio.is_some() {
        let what = "--edge-ratio is for patches; --surface whole has the triangles of the grid, whose size is --voxel";
        return Err(Usage(what.to_owned()).into());
    }
    Ok(())
}
