//! What a USD stage says besides its meshes, kept for the file that is written.

use serde::{Deserialize, Serialize};

use super::layers::Layers;
use super::prim::Prim;
use super::stage::Scene;
use isomend_core::mesh::{Unit, significant};

/// Relative difference of a unit of length to a known one.
const NEAR: f64 = 1e-4;

/// The axis and the unit of a stage, and what is left out when it is written.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct UsdDocument {
    /// Whether the y axis points upwards, as it does if the file does not say; else the z axis.
    pub(super) is_y_up: bool,
    /// Metres of a unit of the coordinates, if the file says.
    pub(super) metres: Option<f64>,
    /// What the file holds besides meshes.
    rest: Vec<String>,
}

impl UsdDocument {
    pub(super) fn new(root: &Prim, scene: &Scene, layers: &Layers<'_>) -> Self {
        let mut rest = scene.rest();
        if layers.other_files() > 0 {
            rest.push(format!(
                "textures and other files of the package: {}",
                layers.other_files()
            ));
        }
        Self {
            is_y_up: root.text("upAxis") != Some("Z"),
            metres: root
                .number("metersPerUnit")
                .filter(|m| *m > 0.0 && m.is_finite()),
            rest,
        }
    }

    /// The unit of the coordinates, if the file names a known one.
    pub(super) fn unit(&self) -> Option<Unit> {
        let own = self.metres?;
        Unit::ALL
            .into_iter()
            .find(|unit| (own / unit.metres() - 1.0).abs() < NEAR)
    }

    /// A remark on a unit that has no name here.
    pub(super) fn unit_note(&self) -> Option<String> {
        let own = self.metres.filter(|_| self.unit().is_none())?;
        Some(format!(
            "the unit of the coordinates, {} m, has no name here; they are kept as they are",
            significant(own, 4)
        ))
    }

    /// What is left out when the mesh is written, in any format.
    pub(crate) fn rest(&self) -> Vec<String> {
        self.rest.clone()
    }
}
