//! Checks for solver options that conflict.

use anyhow::bail;
use isomend::{FillParams, SurfaceKind};

use super::Usage;

/// Refuses options of a solve that conflict.
///
/// # Errors
/// Names the options.
pub fn check(params: &FillParams) -> anyhow::Result<()> {
    let metrics = params.energy.needs().metrics;
    if !metrics.contains(&params.variant) || (metrics.len() == 1 && params.time_step.is_some()) {
        bail!(
            "--variant and --time-step apply to the Willmore energy only; leave them out, or leave out --energy"
        );
    }
    // --edge-ratio has no effect on the triangles of a level set.
    if params.surface == SurfaceKind::Whole && params.edge_ratio.is_some() {
        let what = "--edge-ratio applies to patches only; the triangles of --surface whole have the size of --voxel";
        return Err(Usage(what.to_owned()).into());
    }
    Ok(())
}
