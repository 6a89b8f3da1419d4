//! `isomend surface`: extracts the surface at a level of a volume.

use std::path::PathBuf;

use clap::{Args, ValueHint};
use isomend::io::{Format, Precision};
use isomend::job::SurfaceSpec;

use super::console::{self, Console};
use super::input;
use super::{End, RunArgs, arguments, files, json};

const EXAMPLES: &str = "\
Examples:
  isomend surface bust.vti -o bust.ply
  isomend surface ct.vti -o bone.stl --array density --level 300 --close";

/// Extract the surface at one level of a volume (VTI, or VTK legacy structured points).
///
/// Values below the level are inside, as in a signed distance. The surface is a manifold; it ends at the sides of the volume's box unless
/// it is closed there.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct SurfaceArgs {
    /// The volume: VTI (text, base64 or raw; zlib, LZ4, LZMA or none), or VTK legacy structured points; `-` is
    /// standard input.
    #[arg(value_name = "IN.vti")]
    input: PathBuf,

    /// The mesh to write, in the format of its extension; `-` is standard output, with the format of --to.
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,

    /// The level.
    #[arg(long, value_name = "VALUE", default_value = "0", value_parser = arguments::finite, allow_negative_numbers = true)]
    level: f64,

    /// Close the surface at the sides of the volume's box by flat caps.
    #[arg(long)]
    close: bool,

    /// The name of the point data array, if there are several.
    #[arg(long, value_name = "NAME")]
    array: Option<String>,

    /// Format of the output, whatever its extension: obj, ply, stl, gltf, glb, vtk, vtp, off, 3mf, usda or usdz.
    #[arg(long, value_name = "FORMAT", value_parser = arguments::format)]
    to: Option<Format>,

    /// Write text instead of binary: PLY, STL and VTK legacy.
    #[arg(long)]
    ascii: bool,

    /// Write 64-bit coordinates: PLY, VTK legacy and VTP (OBJ has them anyway).
    #[arg(long)]
    f64: bool,

    /// Write a report as JSON to a file, or to standard output with `-`.
    #[arg(long, value_name = "FILE|-", value_hint = ValueHint::FilePath)]
    json: Option<json::Target>,

    #[command(flatten)]
    pub(super) run: RunArgs,
}

/// Reads the volume, extracts the surface and writes it.
pub fn run(args: &SurfaceArgs, console: &Console) -> anyhow::Result<End> {
    let mut output = files::output(&args.output, args.to)?;
    output.ascii = args.ascii;
    files::check(&output)?;
    let mut spec = SurfaceSpec::new(input::place(&args.input), output);
    spec.array.clone_from(&args.array);
    spec.level = args.level;
    spec.close = args.close;
    if args.f64 {
        spec.precision = Precision::F64;
    }
    spec.check().map_err(super::cli_error)?;
    if let Some(json) = &args.json {
        let [input, output] = [&spec.source.place, &spec.output.place].map(std::slice::from_ref);
        json.check(input, output)?;
    }
    input::fetch(&mut spec.source)?;
    let place = &spec.output.place;
    let done = spec.run().map_err(super::cli_error)?;
    if place.path().is_none() {
        console::write_file_out(&done.bytes)?;
    }
    for note in &done.notes {
        console.note(&format!("{}: {note}", place.name()));
    }
    let (vertices, faces) = (done.mesh.positions.len(), done.mesh.faces.len());
    console.say(&format!("{vertices} vertices, {faces} faces"));
    if let Some(json) = &args.json {
        json.write(&done.document())?;
    }
    Ok(End::Done)
}
