//! `isomend surface`: the surface at one level of a volume.

use std::path::PathBuf;

use anyhow::Context;
use clap::{Args, ValueHint};
use isomend::extract::level_surface;
use isomend::io::{Format, Model, Precision, WriteOptions, read_volume_bytes, read_volume_path};
use isomend::mesh::Attributes;
use serde::Serialize;

use super::console::Console;
use super::input::{self, is_stream};
use super::output::Output;
use super::{End, RunArgs, Usage, arguments, json};

const EXAMPLES: &str = "\
Examples:
  isomend surface bust.vti -o bust.ply
  isomend surface ct.vti -o bone.stl --array density --level 300 --close";

/// Extract the surface at one level of a volume (VTI, or VTK legacy structured points).
///
/// Inside is where the values are below the level, as in a signed distance. The surface is a manifold; it ends at the
/// volume's border unless it is closed there.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct SurfaceArgs {
    /// The volume: VTI (text, base64 or raw; zlib, LZ4, LZMA or none), or VTK legacy structured points; `-` is
    /// standard input.
    #[arg(value_name = "IN.vti")]
    input: PathBuf,

    /// The mesh to write, in the format of its extension; `-` is standard output, whose format --to tells.
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,

    /// The level.
    #[arg(long, value_name = "VALUE", default_value = "0", value_parser = arguments::finite, allow_negative_numbers = true)]
    level: f64,

    /// Close the surface at the volume's border by flat caps.
    #[arg(long)]
    close: bool,

    /// The point data to take, where there are several arrays.
    #[arg(long, value_name = "NAME")]
    array: Option<String>,

    /// Format of the output, whatever its extension: obj, ply, stl, gltf, glb, vtk or vtp.
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

#[derive(Serialize)]
struct Document<'a> {
    command: &'static str,
    version: &'static str,
    input: String,
    dims: [usize; 3],
    range: [f64; 2],
    level: f64,
    output: json::FileInfo,
    notes: &'a [String],
}

/// Reads, extracts, writes.
pub fn run(args: &SurfaceArgs, console: &Console) -> anyhow::Result<End> {
    let output = Output::new(&args.output, args.to, args.ascii)?;
    if args.f64 && matches!(output.format, Format::Stl | Format::Gltf | Format::Glb) {
        let format = output.format;
        let what = format!(
            "--f64: {format} has 32-bit coordinates only; ply, obj, vtk and vtp have others"
        );
        return Err(Usage(what).into());
    }
    if let Some(json) = &args.json {
        json.check(&[&args.input], &[&args.output])?;
    }
    let array = args.array.as_deref();
    let volume = if is_stream(&args.input) {
        read_volume_bytes(&input::standard_input()?, array).context("standard input")?
    } else {
        read_volume_path(&args.input, array)?
    };
    let mesh = level_surface(&volume, args.level, args.close)
        .with_context(|| format!("{} has no such surface", input::shown(&args.input)))?;
    let options = WriteOptions {
        precision: if args.f64 {
            Precision::F64
        } else {
            Precision::F32
        },
        ascii: args.ascii,
    };
    let model = Model {
        mesh: &mesh,
        attributes: &Attributes::default(),
        document: None,
    };
    let mut notes = output.write_as_is(&model, &options)?;
    // Positions between nodes have no exact value that rounding could lose.
    notes.retain(|note| !note.starts_with("positions were rounded"));
    notes
        .iter()
        .for_each(|note| console.note(&format!("{}: {note}", output.name())));
    let (vertices, faces) = (mesh.positions.len(), mesh.faces.len());
    console.say(&format!("{vertices} vertices, {faces} faces"));
    if let Some(json) = &args.json {
        json.write(&Document {
            command: "surface",
            version: env!("CARGO_PKG_VERSION"),
            input: args.input.display().to_string(),
            dims: volume.dims,
            range: volume.range(),
            level: args.level,
            output: json::FileInfo::new(&output.path, output.format, &mesh),
            notes: &notes,
        })?;
    }
    Ok(End::Done)
}
