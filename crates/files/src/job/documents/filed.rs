//! JSON rows for archived reports: the options and their hash, the unit, the tolerance, and the invented surface.

use serde::Serialize;
use serde_json::{Value, json};

use super::FileInfo;
use crate::job::JobSpec;
use crate::job::deliver::{Delivered, Invented, PieceRow};
use crate::job::hash::sha256;
use isomend_core::mesh::Unit;

/// Most face numbers of a mask that the options list; a longer list becomes null.
const MOST_FACES: usize = 100;

/// Options and deliverables of work that changes a mesh.
#[derive(Serialize)]
pub(super) struct FiledRow {
    /// As of `--unit`.
    #[serde(skip_serializing_if = "Option::is_none")]
    unit: Option<Unit>,
    /// As of `--tolerance`.
    #[serde(skip_serializing_if = "Option::is_none")]
    tolerance: Option<f64>,
    /// The work with its parameters. Also the mark, unit, tolerance and clearance. Lists of more than 100 face numbers are null.
    options: Value,
    /// Hash of all options. As JSON without blanks, keys in order, with all face numbers.
    options_sha256: String,
    /// The file of the patches.
    #[serde(skip_serializing_if = "Option::is_none")]
    patches: Option<FileInfo>,
    /// The file of the piece, or a `reason`.
    #[serde(skip_serializing_if = "Option::is_none")]
    piece: Option<PieceRow>,
    /// The new surface. Left out for whole level sets.
    #[serde(skip_serializing_if = "Option::is_none")]
    invented: Option<Invented>,
}

impl FiledRow {
    pub(super) fn new(spec: &JobSpec, delivered: Delivered) -> Self {
        let wanted = &spec.deliverables;
        let mut options = json!({
            "work": spec.work, "mark": wanted.mark, "unit": wanted.unit, "tolerance": wanted.tolerance,
            "no_texture": wanted.no_texture,
        });
        if wanted.continue_paint {
            options["continue_paint"] = Value::Bool(true);
        }
        if let Some(clearance) = wanted.clearance {
            options["clearance"] = json!(clearance);
        }
        let options_sha256 = sha256(options.to_string().as_bytes());
        for command in ["restore", "fair"] {
            let faces = options.pointer_mut(&format!("/work/{command}/0/faces"));
            if let Some(faces) =
                faces.filter(|f| f.as_array().is_some_and(|f| f.len() > MOST_FACES))
            {
                *faces = Value::Null;
            }
        }
        Self {
            unit: wanted.unit,
            tolerance: wanted.tolerance,
            options_sha256,
            options,
            patches: delivered.patches,
            piece: delivered.piece,
            invented: delivered.invented,
        }
    }
}
