//! `isomend sdf`: writes the signed distance of a model as a volume.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use isomend::Volume;
use isomend::io::Precision;
use isomend::job::{self, VolumeSeconds};
use isomend::report::{counted, length};
use isomend::volume::VolumeParams;

use super::console::Console;
use super::input::is_stream;
use super::parameters::{ParameterArgs, Sdf};
use super::{CommonArgs, End, Usage, console, input};

const EXAMPLES: &str = "\
Examples:
  isomend sdf bust.ply -o bust.vti                       128 voxels along the longest side
  isomend sdf bust.ply -o bust.vti --voxel 0.5 --band 2  measure only near the surface
  isomend surface bust.vti -o inner.ply --level -1       back to a mesh, one unit inside";

/// Write the signed distance of a whole model as a volume (VTI), negative inside.
///
/// Distances are exact distances to the triangles. A point is inside where the generalized winding number exceeds one half, so a model with
/// holes has an inside too. The values are point data named `distance`, compressed with zlib.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct SdfArgs {
    /// The mesh: OBJ, PLY, STL, glTF, GLB, VTK legacy, VTP, OFF, 3MF or USD; `-` is standard input.
    #[arg(value_name = "IN")]
    input: PathBuf,

    /// The VTI file to write; `-` is standard output.
    #[arg(short, long, value_name = "OUT.vti")]
    output: PathBuf,

    #[command(flatten)]
    parameters: ParameterArgs<Sdf>,

    /// Write 64-bit floats instead of 32-bit ones.
    #[arg(long)]
    f64: bool,

    #[command(flatten)]
    pub(super) common: CommonArgs,
}

/// Reads the mesh, measures distances and writes the volume.
pub fn run(args: &SdfArgs, console: &Console) -> anyhow::Result<End> {
    let is_vti = is_stream(&args.output)
        || args
            .output
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("vti"));
    if !is_vti {
        let name = args.output.with_extension("vti");
        let what = format!(
            "volumes are written as VTI: name the output {}",
            name.display()
        );
        return Err(Usage(what).into());
    }
    let (place, output) = (input::place(&args.input), input::place(&args.output));
    output.check_writable()?;
    if let Some(json) = &args.common.json {
        json.check(std::slice::from_ref(&place), std::slice::from_ref(&output))?;
    }
    let start = Instant::now();
    let source = input::source(&args.input, args.common.from)?;
    let loaded = input::read(&source, console)?;
    let reading = start.elapsed().as_secs_f64();
    let params: VolumeParams = args.parameters.params()?;
    let done = job::measure(&source, &loaded, &params).map_err(super::cli_error)?;
    let volume = &done.measured.volume;
    let before_writing = Instant::now();
    let precision = if args.f64 {
        Precision::F64
    } else {
        Precision::F32
    };
    let bytes = job::write_volume(volume, job::DISTANCE, precision, &output);
    let bytes = bytes.map_err(super::cli_error)?;
    if output.path().is_none() {
        console::write_file_out(&bytes)?;
    }
    let seconds = VolumeSeconds {
        reading,
        writing: before_writing.elapsed().as_secs_f64(),
        total: start.elapsed().as_secs_f64(),
    };
    if done.measured.open_edges > 0 {
        console.note(&format!(
            "the mesh is open at {}: what its winding number calls inside is negative; `isomend fill` closes holes",
            counted(done.measured.open_edges, "edge")
        ));
    }
    console.say(&summary(volume));
    if let Some(json) = &args.common.json {
        json.write(&done.document(Some((&output, seconds))))?;
    }
    Ok(End::Done)
}

/// One line on a volume: its size, spacing and range.
fn summary(volume: &Volume) -> String {
    let [x, y, z] = volume.dims;
    let [low, high] = volume.range();
    let [voxel, low, high] = [volume.spacing.x, low, high].map(length);
    format!("{x} x {y} x {z} nodes, {voxel} apart; distances from {low} to {high}")
}
