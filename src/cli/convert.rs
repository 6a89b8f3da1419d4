//! `isomend convert`: writes a mesh in another format.

use clap::Args;
use isomend::job::{Deliverables, Work};

use super::console::Console;
use super::files::{FilesArgs, Task};
use super::{CommonArgs, End};

const EXAMPLES: &str = "\
Examples:
  isomend convert scan.ply -o scan.glb              another format
  isomend convert scan.stl -o scan.stl --ascii      the same as text
  isomend convert a.ply b.obj c.stl -o all/ --to vtp    several, into a folder
  isomend convert - -o - --to stl < a.ply > a.stl";

/// Write a mesh in another format, or in the same format again.
///
/// Vertices and faces keep their order and numbers, and holes stay open. Coordinates are rounded only if the format has 32-bit floats. A
/// note lists the attributes that the format cannot store.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct ConvertArgs {
    #[command(flatten)]
    files: FilesArgs,

    #[command(flatten)]
    pub(super) common: CommonArgs,
}

/// Reads and writes each mesh.
pub fn run(args: &ConvertArgs, console: &Console) -> anyhow::Result<End> {
    let task = Task {
        work: Work::Copy,
        common: &args.common,
        strict: false,
        deliverables: Deliverables::default(),
    };
    args.files.each(&task, console)
}
