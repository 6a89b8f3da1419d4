//! Reads a mesh, fills the holes up to a diameter, and writes it with its colours, materials and texture coordinates, which are
//! continued on patches: `cargo run --release --example choose_holes -- data/scan.ply mended.ply 25`.

use std::error::Error;
use std::path::Path;

use isomend::io::{Contents, Precision, WriteOptions, read_path, write_model};
use isomend::report::summary_lines;
use isomend::transfer;
use isomend::{Control, FillParams, FillReport, inspect};

/// Fills the holes of `input` with a diameter of at most `widest`, in the mesh's units, and writes `output` in the format of
/// its extension.
pub fn run(input: &Path, output: &Path, widest: f64) -> Result<FillReport, Box<dyn Error>> {
    let loaded = read_path(input, None)?;
    let found = inspect(&loaded.mesh)?;
    let chosen = found
        .holes
        .iter()
        .filter(|hole| !hole.outer_boundary && hole.diameter <= widest);
    let params = FillParams::new().with_holes(chosen.map(|hole| hole.id));
    let filled = found.fill(&params, &Control::new())?;
    let done = transfer(&loaded.mesh, &loaded.attributes, filled.mesh);
    let model = Contents {
        mesh: &done.mesh,
        attributes: &done.attributes,
        document: loaded.document.as_ref(),
    };
    let options = WriteOptions {
        precision: Precision::of(&loaded.mesh),
        ascii: false,
    };
    let remarks = write_model(output, &model, None, &options)?;
    for remark in loaded.notes.iter().chain(&done.notes).chain(&remarks) {
        println!("note: {remark}");
    }
    Ok(filled.report)
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [input, output, widest] = &arguments[..] else {
        return Err("usage: choose_holes IN OUT DIAMETER".into());
    };
    let report = run(Path::new(input), Path::new(output), widest.parse()?)?;
    for line in summary_lines(&report, true) {
        println!("{line}");
    }
    Ok(())
}
