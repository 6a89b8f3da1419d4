//! `isomend surface`: the surface at one level of a volume.

use std::path::PathBuf;

use anyhow::Context;
use clap::{Args, ValueHint};
use isomend::Attributes;
use isomend::io::{Contents, Format, Precision, read_volume_bytes, read_volume_path};
use isomend::job::{Document, FileInfo};
use isomend::level_surface;
use serde::Serialize;

use super::console::{self, Console};
use super::input::{self, is_stream};
use super::{End, RunArgs, Usage, arguments, files, json};

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
struct Body<'a> {
    input: String,
    dims: [usize; 3],
    range: [f64; 2],
    level: f64,
    output: FileInfo,
    notes: &'a [String],
}

/// Reads, extracts, writes.
pub fn run(args: &SurfaceArgs, console: &Console) -> anyhow::Result<End> {
    let mut output = files::output(&args.output, args.to)?;
    output.ascii = args.ascii;
    files::check(&output)?;
    if args.f64 && matches!(output.format, Format::Stl | Format::Gltf | Format::Glb) {
        let format = output.format;
        let what = format!(
            "--f64: {format} has 32-bit coordinates only; ply, obj, vtk and vtp have others"
        );
        return Err(Usage(what).into());
    }
    if let Some(json) = &args.json {
        json.check(
            &[input::place(&args.input)],
            std::slice::from_ref(&output.place),
        )?;
    }
    let array = args.array.as_deref();
    let volume = if is_stream(&args.input) {
        read_volume_bytes(&input::standard_input()?, array).context("standard input")?
    } else {
        read_volume_path(&args.input, array)?
    };
    let mesh = level_surface(&volume, args.level, args.close)
        .with_context(|| format!("{} has no such surface", input::place(&args.input).name()))?;
    let precision = match args.f64 {
        true => Precision::F64,
        false => Precision::F32,
    };
    let model = Contents {
        mesh: &mesh,
        attributes: &Attributes::default(),
        document: None,
    };
    let (mut notes, bytes) = output.write(&model, precision).map_err(super::told)?;
    if output.place.path().is_none() {
        console::write_file_out(&bytes)?;
    }
    // Positions between nodes have no exact value that rounding could lose.
    notes.retain(|note| !note.starts_with("positions were rounded"));
    notes
        .iter()
        .for_each(|note| console.note(&format!("{}: {note}", output.place.name())));
    let (vertices, faces) = (mesh.positions.len(), mesh.faces.len());
    console.say(&format!("{vertices} vertices, {faces} faces"));
    if let Some(json) = &args.json {
        let body = Body {
            input: args.input.display().to_string(),
            dims: volume.dims,
            range: volume.range(),
            level: args.level,
            output: FileInfo::new(&output.place, output.format, &mesh),
            notes: &notes,
        };
        json.write(&Document::new("surface", body))?;
    }
    Ok(End::Done)
}
