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

#[derive(Serialize)]
pub(super) struct FiledRow {
    #[serde(skip_serializing_if = "Option::is_none")]
    unit: Option<Unit>,
    #[serde(skip_serializing_if = "Option::is_none")]
    tolerance: Option<f64>,
    /// The work with its parameters, the mark, the unit, the tolerance and the clearance. Long lists of face numbers are null.
    options: Value,
    /// SHA-256 of the complete options, as JSON without blanks.
    options_sha256: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    patches: Option<FileInfo>,
    #[serde(skip_serializing_if = "Option::is_none")]
    piece: Option<PieceRow>,
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
