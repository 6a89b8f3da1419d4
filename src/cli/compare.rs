//! `isomend compare`: distances, angles of normals and bending energies of two meshes, and the elements of the first that the second keeps.

use std::path::PathBuf;

use clap::Args;
use isomend::Unit;
use isomend::compare::{Comparison, Distances, SurfaceFacts};
use isomend::job;
use isomend::report::{counted, length, length_beside, lengths_in, number, point};
use serde::Deserialize;

use super::console::{self, Console};
use super::input::{self, is_stream};
use super::json::Target;
use super::parameters::{Compare, ParameterArgs};
use super::{CommonArgs, End, Usage};
use isomend_files::job::contradiction;

const EXAMPLES: &str = "\
Examples:
  isomend compare scan.ply mended.ply               how much of the scan is kept, and the distances of the new faces
  isomend compare truth.ply mended.ply --json -";

/// Compare two meshes: distances in both directions, normals, bending energy, and how much of A is kept in B.
///
/// Distances are in the meshes' units, from samples spread evenly over the area; for the largest distance all vertices are tested too.
/// The bending energy is half the integral of h squared, h the sum of the principal curvatures: 8 pi for a sphere.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct CompareArgs {
    /// The first mesh; one of the two may be `-`, standard input.
    #[arg(value_name = "A")]
    a: PathBuf,

    /// The second mesh.
    #[arg(value_name = "B")]
    b: PathBuf,

    /// The unit of the coordinates of both meshes: mm, cm, m, in, um or ft. It is printed with lengths, also in --json.
    #[arg(long, value_name = "UNIT")]
    unit: Option<Unit>,

    #[command(flatten)]
    parameters: ParameterArgs<Compare>,

    #[command(flatten)]
    pub(super) common: CommonArgs,
}

/// The number of samples on each mesh.
#[derive(Deserialize)]
struct Samples {
    samples: usize,
}

/// Reads both and compares.
pub fn run(args: &CompareArgs, console: &Console) -> anyhow::Result<End> {
    if let Some(json) = &args.common.json {
        json.check(&[&args.a, &args.b].map(|path| input::place(path)), &[])?;
    }
    if is_stream(&args.a) && is_stream(&args.b) {
        return Err(Usage("only one of the two meshes can be standard input".to_owned()).into());
    }
    let first = input::source(&args.a, args.common.from)?;
    let a = input::read(&first, console)?;
    let second = input::source(&args.b, args.common.from)?;
    let b = input::read(&second, console)?;
    for (source, loaded) in [(&first, &a), (&second, &b)] {
        if let Some(note) = contradiction(loaded.attributes.unit, args.unit) {
            console.note(&format!("{}: {note}", source.place.name()));
        }
    }
    let Samples { samples } = args.parameters.params()?;
    let compared = job::compare([(&first, &a), (&second, &b)], samples, args.unit)
        .map_err(super::cli_error)?;
    if let Some(json) = &args.common.json {
        json.write(&compared.document())?;
    }
    if !matches!(args.common.json, Some(Target::Stdout)) {
        console::print_out(&table(&compared.comparison, args.unit))?;
    }
    Ok(End::Done)
}

/// A line of the table, of 60 columns.
fn cells_line(name: &str, cells: &[String; 5]) -> String {
    let [max, rms, mean, angle_mean, angle_max] = cells;
    format!("{name:>6} {max:>9} {rms:>9} {mean:>9} {angle_mean:>10} {angle_max:>10}")
}

fn table(c: &Comparison, unit: Option<Unit>) -> String {
    let square = unit.map_or(String::new(), |unit| format!(" {unit}²"));
    let facts = |name: &str, s: &SurfaceFacts| {
        let inner = match s.boundary_vertices {
            0 => String::new(),
            n => format!(" (without its {})", counted(n, "boundary vertex")),
        };
        format!(
            "{name}: {}, {}, area {}{square}, bending energy {}{inner}\n",
            counted(s.vertices, "vertex"),
            counted(s.faces, "face"),
            length(s.area),
            number(s.willmore_energy),
        )
    };
    // Of the order of the model's size, by which `point` rounds: much smaller coordinates are rounding errors.
    let size = c.a.area.sqrt();
    let row = |name: &str, d: &Distances| {
        let lengths = [d.max, d.rms, d.mean].map(|x| length_beside(x, size));
        let angles = [d.normal_mean, d.normal_max].map(|x| length_beside(x, 180.0) + "°");
        let ([max, rms, mean], [angle, angle_max]) = (lengths, angles);
        cells_line(name, &[max, rms, mean, angle, angle_max])
    };
    let at = |d: &Distances| point(d.max_at, size);
    facts("A", &c.a)
        + &facts("B", &c.b)
        + "\n"
        + &lengths_in(unit)
        + "\n"
        + &console::heading(&cells_line(
            "",
            &["max", "rms", "mean", "angle mean", "angle max"].map(str::to_owned),
        ))
        + "\n"
        + &row("A to B", &c.a_to_b)
        + "\n"
        + &row("B to A", &c.b_to_a)
        + "\n"
        + &format!("largest from A to B at {}\n", at(&c.a_to_b))
        + &format!("largest from B to A at {}\n", at(&c.b_to_a))
        + "\n"
        + &kept_line(c)
}

/// How many vertices and faces of A are in B with the same bits, and how many of the first ones keep their numbers.
fn kept_line(c: &Comparison) -> String {
    let k = &c.kept;
    let of = |kept: usize, in_order: usize, all: usize, noun: &str| {
        let part = match kept == all {
            true => format!("all {}", counted(all, noun)),
            false => format!("{kept} of {}", counted(all, noun)),
        };
        match in_order == all {
            true => part,
            false => format!("{part} (the first {in_order} with the same numbers)"),
        }
    };
    let vertices = of(k.vertices, k.vertices_in_order, c.a.vertices, "vertex");
    let faces = of(k.faces, k.faces_in_order, c.a.faces, "face");
    let are_all = [k.vertices_in_order, k.faces_in_order] == [c.a.vertices, c.a.faces];
    let order = if are_all { ", in the same order" } else { "" };
    format!("kept in B bit for bit: {vertices} and {faces} of A{order}\n")
}
