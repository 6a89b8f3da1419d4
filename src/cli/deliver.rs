//! Options for deliverables besides the mended mesh: patches, marks, tolerance.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum, ValueHint};
use isomend::job::{Deliverables, Mark, Output};

use super::arguments;

/// Options of commands that make patches.
#[derive(Debug, Args)]
pub struct DeliverArgs {
    /// Write the new faces alone to another file: one component for each hole.
    ///
    /// PLY, VTK and glTF files contain the number of the hole as `isomend_hole` and the expected errors as `isomend_sigma`.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    patches: Option<PathBuf>,

    /// Colour the patches in the file, so that new faces can be seen: `colour=RRGGBB`, or `hatch` for orange stripes.
    ///
    /// STL has no colours; use --patches to write the patches alone.
    #[arg(long, value_name = "colour=RRGGBB|hatch")]
    mark: Option<Mark>,

    /// Make no texels for patches that lie across seams of the texture: they get a plain material.
    ///
    /// Without it, OBJ, glTF and GLB files get a new image for these patches: NAME_isomend.png beside the output, or inside a GLB file.
    #[arg(long)]
    no_texture: bool,

    /// The paint of a slicer (colours, supports, seams, fuzzy skin) on patches, where a 3MF file is read and written.
    #[arg(long, value_enum, default_value_t, hide_default_value = true)]
    paint: PatchPaint,

    /// The largest error that is allowed, in the mesh's units: exit with 3 and list the holes where twice the expected error is larger
    /// on more than 5 % of their patches.
    #[arg(long, value_name = "LENGTH", value_parser = arguments::positive)]
    tolerance: Option<f64>,
}

/// The paint of patches.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum PatchPaint {
    /// Patches are not painted
    #[default]
    None,
    /// Patches are painted as the triangles beside them
    Continue,
}

impl DeliverArgs {
    /// The deliverables of these options.
    ///
    /// # Errors
    /// If the extension of a file names no mesh format.
    pub fn deliverables(&self) -> anyhow::Result<Deliverables> {
        Ok(Deliverables {
            patches: self.patches.as_deref().map(output).transpose()?,
            mark: self.mark,
            no_texture: self.no_texture,
            continue_paint: matches!(self.paint, PatchPaint::Continue),
            tolerance: self.tolerance,
            ..Deliverables::default()
        })
    }
}

/// The output for a path.
pub fn output(path: &Path) -> anyhow::Result<Output> {
    Output::new(path, None).map_err(super::cli_error)
}
