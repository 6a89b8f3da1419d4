//! A 3MF package that was read, and where the vertices and faces of its mesh come from.

use std::sync::Arc;

use glam::{DAffine3, DVec3};
use serde::{Deserialize, Serialize};

use isomend_core::mesh::Unit;

/// Names of attributes with the paint of a triangle, without prefix, as PrusaSlicer writes them. Names of Bambu Studio and OrcaSlicer begin with
/// `paint_`.
const PAINT: [&str; 5] = [
    "custom_supports",
    "custom_seam",
    "mmu_segmentation",
    "fuzzy_skin",
    "texture_skin",
];

/// Whether an attribute of a triangle, given without its prefix, is paint.
pub(super) fn is_paint(name: &str) -> bool {
    name.starts_with("paint_") || PAINT.contains(&name)
}

/// A 3MF package, kept so that it can be written again with all that isomend does not read: paint, settings of slicers, thumbnails, UUIDs,
/// slices, parts and elements of other programs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct ThreeMfDocument {
    /// The file.
    pub(super) bytes: Arc<Vec<u8>>,
    /// The unit of the mesh.
    pub(super) unit: Unit,
    /// The meshes that make up the mesh, in its order.
    pub(super) placements: Vec<Placement>,
    /// The attributes of triangles that are not read, such as paint, in words.
    pub(super) marks: Option<String>,
    /// What else the package holds, in words, for formats that cannot hold it.
    pub(super) rest: Vec<String>,
}

impl ThreeMfDocument {
    /// The attributes of triangles that a mesh does not hold, for example paint, in words.
    pub(crate) fn marks(&self) -> Option<&str> {
        self.marks.as_deref()
    }

    /// Whether triangles have paint of a slicer.
    pub(in super::super) fn is_painted(&self) -> bool {
        let names = self.marks.iter().flat_map(|marks| marks.split([',', ' ']));
        let mut own = names.filter_map(|name| name.rsplit(':').next());
        own.any(is_paint)
    }

    /// What the package holds besides the mesh and the attributes, for example paint and settings.
    pub(in super::super) fn rest(&self) -> Vec<String> {
        self.marks.iter().chain(&self.rest).cloned().collect()
    }
}

/// The mesh of an object in the place that the build gives it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Placement {
    /// Name of the model part that contains the object, and the object's number there.
    pub(super) model: String,
    pub(super) object: u32,
    /// The transform to the build. Coordinates are first multiplied by `scale`, from the unit of the part to the unit of the main model.
    pub(super) transform: DAffine3,
    pub(super) scale: f64,
    /// First face and number of faces in the mesh that was read.
    pub(super) faces: (usize, usize),
    /// The label of its object.
    pub(super) name: String,
    /// Its parts, in the order of their faces.
    pub(super) parts: Vec<PlacedPart>,
}

/// The corners in the origin of a face that lies beside a face of the file and continues its paint. Other corners are up to 3.
pub(crate) const BESIDE: [u8; 3] = [4; 3];

/// A range of an object's faces with a label of its own: the whole object, or a volume of PrusaSlicer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct PlacedPart {
    /// First and last face, counted from the first of the object.
    pub(super) faces: [usize; 2],
    /// The label of the part; empty if its faces have none.
    pub(super) name: String,
}

impl Placement {
    /// The name of the model part that contains its object, and the object's number there.
    pub(super) fn key(&self) -> (&str, u32) {
        (&self.model, self.object)
    }

    /// The index of the part of a face, counted from the first of the object; the number of parts if it belongs to none.
    pub(super) fn part_of(&self, face: usize) -> usize {
        // The ranges of the parts are sorted and disjoint.
        let after = |part: &PlacedPart| part.faces[1] < face;
        let number = self.parts.partition_point(after);
        let part = self.parts.get(number);
        part.filter(|part| part.faces[0] <= face)
            .map_or(self.parts.len(), |_| number)
    }

    /// A point of the object in the build.
    pub(super) fn placed(&self, p: DVec3) -> DVec3 {
        match self.transform == DAffine3::IDENTITY && self.scale == 1.0 {
            true => p,
            false => self.transform.transform_point3(self.scale * p),
        }
    }

    /// A point of the build in the object. None if the transform has no inverse.
    pub(super) fn back(&self) -> Option<impl Fn(DVec3) -> DVec3> {
        let is_plain = self.transform == DAffine3::IDENTITY && self.scale == 1.0;
        let (inverse, scale) = (self.transform.inverse(), self.scale);
        inverse
            .is_finite()
            .then_some(move |p: DVec3| match is_plain {
                true => p,
                false => inverse.transform_point3(p) / scale,
            })
    }

    /// Whether the transform reverses the orientation of faces.
    pub(super) fn is_mirrored(&self) -> bool {
        self.transform.matrix3.determinant() < 0.0
    }
}
