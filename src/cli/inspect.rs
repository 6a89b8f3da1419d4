//! `isomend inspect`: lists the components, holes, crease ends and defects of a mesh, and the faces that a mask marks.

use std::fmt::Write;

use clap::Args;
use isomend::io::Loaded;
use isomend::job::{Inspected, Looked, Work};
use isomend::report::{
    chain_lines, component_rows, counted, crease_end_line, crease_end_table, defect_lines,
    hole_table, length, lengths_in, point,
};
use isomend::{Selection, Unit};

use super::console::{self, Console};
use super::look::{Look, LookArgs, Shown};
use super::mask::MaskArgs;
use super::{CommonArgs, End, Usage, table};

const EXAMPLES: &str = "\
Examples:
  isomend inspect scan.ply                  a table of the holes, with their numbers
  isomend inspect scan.ply --json - | jq '.holes[].diameter'
  isomend inspect scan.ply --report scan.html           the holes in a 3D view, with their numbers
  isomend inspect scans/*.ply               a table with a row for each mesh
  isomend inspect scan.ply --ball 10,4,2,3.5 --grow 1   the faces that a mask marks";

/// List the components, holes and defects of a mesh.
///
/// Lengths are in the mesh's units. The normal is the normal of the plane that fits the rim best, pointing out of the surface; the height
/// is the rim's extent along it. Planarity is the root mean square distance of the rim from that plane, divided by the hole's diameter: 0
/// is planar.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct InspectArgs {
    #[command(flatten)]
    files: LookArgs,

    #[command(flatten)]
    mask: MaskArgs,

    #[command(flatten)]
    pub(super) common: CommonArgs,
}

/// Reads and inspects each mesh.
pub fn run(args: &InspectArgs, console: &Console) -> anyhow::Result<End> {
    let look = Look {
        work: Work::Inspect(args.mask.mask().map_err(Usage)?),
        common: &args.common,
        headings: &[
            "format",
            "vertices",
            "faces",
            "components",
            "holes",
            "widest hole",
            "defects",
        ],
        prints: true,
        show: &|_, looked| match looked {
            Looked::Inspected(inspected) => shown(inspected, console),
            Looked::Checked(_) => Shown::default(),
        },
    };
    args.files.each(&look, console)
}

/// The inspection of a file as text, and its row.
fn shown(inspected: &Inspected, console: &Console) -> Shown {
    let mut text = summary(inspected.loaded, inspected);
    if console.is_verbose() {
        text += &components(inspected);
    }
    text += &creases(inspected, console.is_verbose());
    if let Some((mask, marked)) = &inspected.marked {
        text += &mask_line(mask, &marked.missed, inspected.unit);
    }
    Shown {
        text,
        cells: cells(inspected.loaded, inspected),
    }
}

/// The row of a file in the table for several files.
fn cells(loaded: &Loaded, inspected: &Inspected) -> Vec<String> {
    let found = &inspected.found;
    let widest = found.holes.iter().map(|h| h.diameter).fold(0.0, f64::max);
    let defects = [
        defect_lines(&found.topology.defects),
        chain_lines(&found.open_chains),
    ]
    .concat();
    vec![
        loaded.format.to_string(),
        loaded.mesh.positions.len().to_string(),
        loaded.mesh.faces.len().to_string(),
        found.topology.component_faces.len().to_string(),
        found.holes.len().to_string(),
        match found.holes.is_empty() {
            true => "-".to_owned(),
            false => Unit::text(inspected.unit, widest),
        },
        match defects.is_empty() {
            true => "none".to_owned(),
            false => defects.join("; "),
        },
    ]
}

fn mask_line(mask: &Selection, missed: &[String], unit: Option<Unit>) -> String {
    let Some([low, high]) = mask.bounds else {
        return format!("\nmask: no faces: {}\n", missed.join("; "));
    };
    format!(
        "\nmask: {} in {}, area {}{}, from {} to {}\n",
        counted(mask.faces, "face"),
        counted(mask.components, "component"),
        length(mask.area),
        unit.map_or(String::new(), |unit| format!(" {unit}²")),
        point(low, low.distance(high)),
        point(high, low.distance(high)),
    )
}

/// A table of the components.
fn components(inspected: &Inspected) -> String {
    let headings = ["component", "faces", "area", "size"].map(str::to_owned);
    let rows = component_rows(&inspected.found);
    let more = match inspected.found.topology.component_faces.len() - rows.len() {
        0 => String::new(),
        more => format!("and {more} more\n"),
    };
    let table = table::table(&headings, &rows, console::width());
    format!("\n{table}{more}")
}

/// The number of sharp edges that end at rims, with `-v` also a table of them.
fn creases(inspected: &Inspected, is_verbose: bool) -> String {
    let ends = &inspected.crease_ends;
    let Some(line) = crease_end_line(ends) else {
        return String::new();
    };
    if !is_verbose {
        return format!("\n{line} (-v lists them)\n");
    }
    let [low, high] = inspected.loaded.mesh.bounds();
    let mut rows = crease_end_table(ends, low.distance(high)).into_iter();
    let head = rows.next().map(|head| console::heading(&head));
    let rows: Vec<String> = head.into_iter().chain(rows).collect();
    format!("\n{line}:\n{}\n", rows.join("\n"))
}

/// The inspection of a single file as text.
fn summary(loaded: &Loaded, inspected: &Inspected) -> String {
    let found = &inspected.found;
    let components = found.topology.component_faces.len();
    let [low, high] = loaded.mesh.bounds();
    let size = high - low;
    let of_unit = inspected
        .unit
        .map_or(String::new(), |unit| format!(" {unit}"));
    let mut text = String::new();
    let mut line = |line: String| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{line}");
    };
    line(format!(
        "{}: {}, {}, {}, {}",
        loaded.format,
        counted(loaded.mesh.positions.len(), "vertex"),
        counted(loaded.mesh.faces.len(), "face"),
        counted(components, "component"),
        counted(found.holes.len(), "hole"),
    ));
    line(format!(
        "size: {}{of_unit}",
        size.to_array().map(length).join(" x ")
    ));
    line(format!(
        "bounds: from {} to {}{of_unit}",
        point(low, size.length()),
        point(high, size.length())
    ));
    let defects = defect_lines(&found.topology.defects).into_iter();
    for remark in defects.chain(chain_lines(&found.open_chains)) {
        line(console::noted(&remark));
    }
    if !found.holes.is_empty() {
        line(String::new());
        line(lengths_in(inspected.unit));
        let mut rows =
            hole_table(&found.holes, &inspected.crease_ends, console::width()).into_iter();
        rows.next()
            .into_iter()
            .for_each(|head| line(console::heading(&head)));
        rows.for_each(line);
    }
    text
}
