//! Writes mended meshes and copies: rounding to the format, attributes, marks, materials of patches, and the check of written bytes.

use std::borrow::Cow;
use std::path::Path;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::bodies::checked;
use super::deliver::{Component, Mark, has_columns};
use super::hash::sha256;
use super::paint::{continue_paint, paint_note};
use super::result::{ReplacedBody, label_replaced};
use super::rounding::collapse_note;
use super::staging::{Staging, make_folder};
use super::texels::{Texels, add_material, refer_to_material};
use super::units::{holds_unit, unit_notes};
use super::{JobError, Place};
use crate::io::{
    Contents, FileDocument, Format, GltfDocument, IoError, Loaded, Precision, WriteOptions,
    Written, model_to_bytes, no_side_files, read_bytes,
};
use isomend_core::attributes::{UnwantedColour, transfer_without};
use isomend_core::cancel::Cancel;
use isomend_core::check::{CheckParams, Verdict};
use isomend_core::fill::RegionReport;
use isomend_core::mend::{Inspection, recount_intersections};
use isomend_core::mesh::{Attributes, Mesh, Model, Unit};

/// Where a mesh goes, in which format.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Output {
    /// The file, or the caller's memory.
    pub place: Place,
    /// The format.
    pub format: Format,
    /// Write text instead of binary.
    pub ascii: bool,
    /// Create the folder of the file if it does not exist.
    pub make_folder: bool,
}

/// A mesh that was written.
#[derive(Debug)]
pub(super) struct Saved {
    /// The mesh, with new vertices rounded as in the file.
    pub(super) mesh: Mesh,
    /// Its attributes.
    pub(super) attributes: Attributes,
    /// Remarks.
    pub(super) notes: Vec<String>,
    /// The bytes of the file, if the output is the caller's memory; else empty.
    pub(super) bytes: Vec<u8>,
    /// Hash of the bytes.
    pub(super) sha256: String,
    /// The verdict on the bytes, if it was requested and they can be read without other files.
    pub(super) verdict: Option<Verdict>,
}

/// The data for writing a mended mesh.
#[derive(Clone)]
pub(super) struct Saving<'a> {
    /// The kept part of the input.
    pub(super) input: &'a Loaded,
    /// Whether nothing of the input is kept.
    pub(super) whole: bool,
    /// The bodies that were replaced as a whole, each by itself.
    pub(super) replaced: &'a [ReplacedBody],
    /// The expected error of each new vertex.
    pub(super) expected_error: &'a [Option<f64>],
    /// Parameters with which the written bytes are read back and checked; `None` for no check.
    pub(super) judges: Option<CheckParams>,
    /// The components of the patches.
    pub(super) components: &'a [Component],
    /// How the patches are marked.
    pub(super) mark: Option<Mark>,
    /// The unit of the coordinates, if it was given.
    pub(super) unit: Option<Unit>,
    /// Where the input came from.
    pub(super) source: &'a Place,
    /// Colours that patches do not get from their rims.
    pub(super) unwanted: &'a [UnwantedColour],
    /// Whether patches across seams of a texture stay without texels.
    pub(super) plain_patches: bool,
    /// Whether patches are painted as their neighbours.
    pub(super) continues_paint: bool,
    /// The token that stops the writing.
    pub(super) cancel: &'a Cancel,
}

/// Bytes that were written.
pub(super) struct Stored {
    /// The bytes, if the output is the caller's memory; else empty.
    pub(super) bytes: Vec<u8>,
    /// Hash of the bytes.
    pub(super) sha256: String,
    /// Remarks.
    pub(super) notes: Vec<String>,
}

impl Output {
    /// An output in the given format; without one, in the format of the extension.
    ///
    /// # Errors
    /// [`JobError::NoFormat`] and [`JobError::BinaryUsd`].
    pub fn new(place: impl Into<Place>, format: Option<Format>) -> Result<Self, JobError> {
        let place = place.into();
        let name = place.name();
        let by_extension = || Format::from_extension(Path::new(&name));
        if let Some(path) = place.path().filter(|path| Format::is_binary_usd(path)) {
            return Err(JobError::BinaryUsd {
                path: path.to_path_buf(),
            });
        }
        match format.or_else(by_extension) {
            Some(format) => Ok(Self {
                place,
                format,
                ascii: false,
                make_folder: false,
            }),
            None => Err(JobError::NoFormat { path: name.into() }),
        }
    }

    /// Checks the output before the mesh is known.
    ///
    /// # Errors
    /// [`JobError::NoTextForm`] and [`JobError::Unwritable`].
    pub fn check(&self) -> Result<(), JobError> {
        let other = match self.format {
            Format::Glb => Some("gltf"),
            Format::Vtp => Some("vtk"),
            Format::ThreeMf => Some("off"),
            Format::Usdz => Some("usda"),
            _ => None,
        };
        if let Some(other) = other.filter(|_| self.ascii) {
            return Err(JobError::NoTextForm {
                name: self.place.name(),
                format: self.format,
                other,
            });
        }
        let folder = self.place.path().and_then(Path::parent);
        if self.make_folder && !folder.is_some_and(Path::is_dir) {
            return Ok(());
        }
        self.place.check_writable()
    }

    /// Whether the file is text.
    pub fn is_text(&self) -> bool {
        let text = [
            Format::Obj,
            Format::Gltf,
            Format::Vtp,
            Format::Off,
            Format::Usda,
        ];
        let text = text.contains(&self.format);
        text || (self.ascii && !matches!(self.format, Format::Glb | Format::ThreeMf | Format::Usdz))
    }

    /// Whether the format is glTF, where the input's document is passed through unchanged.
    pub(super) fn is_gltf(&self) -> bool {
        matches!(self.format, Format::Gltf | Format::Glb)
    }

    /// Transfers attributes to the patches of a mended mesh and writes it.
    ///
    /// If all coordinates of the input are 32-bit floats, the output's are too; then only new vertices are rounded. Rounding can change
    /// which faces of patches intersect others, so these are counted again in the rounded mesh.
    pub(super) fn write_mended(
        &self,
        mut mesh: Mesh,
        saving: &Saving,
        regions: &mut [RegionReport],
        staging: &mut Staging,
    ) -> Result<Saved, JobError> {
        let (input, whole) = (saving.input, saving.whole);
        let [kept, kept_faces] = match whole {
            true => [0, 0],
            false => [input.mesh.positions.len(), input.mesh.faces.len()],
        };
        let rounds = self.format.is_single();
        let rounded = |p: &DVec3| p.as_vec3().as_dvec3();
        let is_exact = matches!(self.format, Format::Obj | Format::Off | Format::ThreeMf);
        let mut collapsed = None;
        if input.f32_exact && !is_exact {
            let full = mesh.positions[kept..].to_vec();
            for position in &mut mesh.positions[kept..] {
                *position = rounded(position);
            }
            recount_intersections(&mesh, kept_faces, regions);
            let full = |v: u32| match (v as usize).checked_sub(kept) {
                Some(new) => full[new],
                None => mesh.positions[v as usize],
            };
            collapsed = collapse_note(full, &mesh, kept_faces);
        } else if rounds {
            let positions = mesh.positions.iter().map(rounded).collect();
            let written = Mesh::new(positions, mesh.faces.clone());
            recount_intersections(&written, kept_faces, regions);
            let full = |v: u32| mesh.positions[v as usize];
            collapsed = collapse_note(full, &written, kept_faces);
        }
        if whole {
            return self.write_whole(mesh, saving, staging);
        }
        let mut side_files = Staging::default();
        let mut done = self.with_attributes(mesh, kept, saving, &mut side_files)?;
        let in_file = self.format == Format::Obj && self.place.folder().is_some();
        let material = in_file && refer_to_material(&mut done.attributes);
        let document = input.document.as_ref();
        let mut saved = self.write_model(done.mesh, done.attributes, document, saving, staging)?;
        saved.notes = [done.notes, saved.notes].concat();
        if saving.continues_paint {
            saved
                .notes
                .extend(paint_note(self.format, &saved.attributes));
        }
        saved.notes.extend(collapsed);
        if material {
            add_material(&self.place, self.make_folder, &mut side_files)?;
        }
        staging.append(side_files);
        let own = input.attributes.unit;
        saved
            .notes
            .extend(unit_notes(own, saving.unit, self.format));
        saved.notes.extend(self.side_files(input));
        Ok(saved)
    }

    /// A mended mesh with its attributes: continued on patches, with texels, marks and expected errors. The first `kept` vertices are the
    /// input's.
    fn with_attributes(
        &self,
        mesh: Mesh,
        kept: usize,
        saving: &Saving,
        staging: &mut Staging,
    ) -> Result<Model, JobError> {
        let input = saving.input;
        let mut done = transfer_without(&input.mesh, &input.attributes, mesh, saving.unwanted);
        let faces = done.mesh.faces.len();
        let (replaced, before) = (saving.replaced, &input.attributes);
        label_replaced(replaced, before, &mut done.attributes, faces);
        if saving.continues_paint && self.format == Format::ThreeMf {
            continue_paint(&mut done, input.mesh.faces.len());
        }
        if !saving.plain_patches {
            let texels = Texels {
                place: &self.place,
                format: self.format,
                make_folder: self.make_folder,
                input,
                source: saving.source,
                components: saving.components,
                cancel: saving.cancel,
            };
            texels.add(&mut done, staging)?;
        }
        if saving.unit.is_some() {
            done.attributes.unit = saving.unit;
        }
        if let Some(mark) = saving.mark {
            let kept = input.mesh.faces.len();
            let document = input.document.as_ref().and_then(FileDocument::gltf);
            let file = (self.format, document);
            let notes = mark.apply(&mut done, kept, saving.components, file);
            done.notes.extend(notes);
        }
        if has_columns(self.format) {
            done.set_expected_errors(kept, saving.expected_error);
        }
        Ok(done)
    }

    /// Writes a mesh unchanged, with the unit if one is given.
    pub(super) fn write_copy(
        &self,
        input: &Loaded,
        unit: Option<Unit>,
        staging: &mut Staging,
    ) -> Result<Stored, JobError> {
        let mut attributes = Cow::Borrowed(&input.attributes);
        if unit.is_some() && holds_unit(self.format) {
            attributes.to_mut().unit = unit;
        }
        let model = Contents {
            mesh: &input.mesh,
            attributes: &attributes,
            document: input.document.as_ref(),
        };
        let mut stored = self.write_contents(&model, precision_of(input), staging)?;
        let own = input.attributes.unit;
        stored.notes.extend(unit_notes(own, unit, self.format));
        stored.notes.extend(self.side_files(input));
        Ok(stored)
    }

    /// Writes level sets by themselves.
    fn write_whole(
        &self,
        mesh: Mesh,
        saving: &Saving,
        staging: &mut Staging,
    ) -> Result<Saved, JobError> {
        let mut attributes = Attributes {
            unit: saving.unit.or(saving.input.attributes.unit),
            ..Attributes::default()
        };
        let (before, faces) = (&saving.input.attributes, mesh.faces.len());
        label_replaced(saving.replaced, before, &mut attributes, faces);
        let is_lost = |kind| attributes.labels_of(kind).is_none();
        let listed = before.listed_where(|_| true, is_lost);
        // A 3MF package keeps its settings, also if all faces are new; a glTF document needs its vertices.
        let document = saving.input.document.as_ref();
        let document = document.filter(|document| document.three_mf().is_some());
        let marks = document.and_then(|document| document.three_mf()?.marks());
        let lost: Vec<&str> = (marks.into_iter().chain([&listed[..]]))
            .filter(|what| !what.is_empty())
            .collect();
        let mut saved = self.write_model(mesh, attributes, document, saving, staging)?;
        let own = saving.input.attributes.unit;
        saved
            .notes
            .extend(unit_notes(own, saving.unit, self.format));
        if !lost.is_empty() {
            let lost = lost.join(", ");
            let what = format!("left out, because a whole level set has no attributes: {lost}");
            saved.notes.push(what);
        }
        Ok(saved)
    }

    fn write_model(
        &self,
        mesh: Mesh,
        attributes: Attributes,
        document: Option<&FileDocument>,
        saving: &Saving,
        staging: &mut Staging,
    ) -> Result<Saved, JobError> {
        let model = Contents {
            mesh: &mesh,
            attributes: &attributes,
            document,
        };
        let Written { bytes, mut notes } = self.encode(&model, precision_of(saving.input))?;
        let judged = |params| judged(&bytes, self.format, params);
        let verdict = match saving.judges.as_ref().map(judged).transpose() {
            Ok(verdict) => verdict,
            // A damaged file is never written. One that has buffers of its own beside it is not damaged.
            Err(JobError::Bytes { error, .. }) if matches!(error, IoError::Malformed { .. }) => {
                let name = "the written mesh cannot be read back; please report this".to_owned();
                return Err(JobError::Bytes { name, error });
            }
            Err(error) => {
                notes.push(format!(
                    "the verdict is on the mesh in memory, not on the written file, since the file cannot be read back alone: {error}"
                ));
                None
            }
        };
        let sha256 = sha256(&bytes);
        let bytes = self.store(bytes, staging)?;
        Ok(Saved {
            mesh,
            attributes,
            notes,
            bytes,
            sha256,
            verdict,
        })
    }

    /// Writes a mesh and its attributes unchanged. Returns remarks, and the bytes if the output is the caller's memory.
    ///
    /// # Errors
    /// If the format cannot hold the mesh, or the file cannot be written.
    pub fn write(
        &self,
        model: &Contents<'_>,
        precision: Precision,
    ) -> Result<(Vec<String>, Vec<u8>), JobError> {
        let mut staging = Staging::default();
        let stored = self.write_contents(model, precision, &mut staging)?;
        staging.finish(&Cancel::new())?;
        Ok((stored.notes, stored.bytes))
    }

    /// Writes a deliverable besides the mesh.
    pub(super) fn write_beside(
        &self,
        model: &Model,
        precision: Precision,
        staging: &mut Staging,
    ) -> Result<Stored, JobError> {
        let contents = Contents {
            mesh: &model.mesh,
            attributes: &model.attributes,
            document: None,
        };
        self.write_contents(&contents, precision, staging)
    }

    fn write_contents(
        &self,
        model: &Contents<'_>,
        precision: Precision,
        staging: &mut Staging,
    ) -> Result<Stored, JobError> {
        let written = self.encode(model, precision)?;
        Ok(Stored {
            sha256: sha256(&written.bytes),
            notes: written.notes,
            bytes: self.store(written.bytes, staging)?,
        })
    }

    /// Encodes a mesh and its attributes as the bytes of a file.
    fn encode(&self, model: &Contents<'_>, precision: Precision) -> Result<Written, JobError> {
        let options = WriteOptions {
            precision,
            ascii: self.ascii,
        };
        let written = model_to_bytes(model, self.format, &options);
        written.map_err(|error| match &self.place {
            Place::File(path) => JobError::Io(error.in_file(path)),
            Place::Memory { name, .. } => JobError::Bytes {
                name: name.clone(),
                error,
            },
        })
    }

    /// Stages the bytes of the file, or returns them if the output is the caller's memory.
    fn store(&self, bytes: Vec<u8>, staging: &mut Staging) -> Result<Vec<u8>, JobError> {
        let Place::File(path) = &self.place else {
            return Ok(bytes);
        };
        make_folder(path, self.make_folder)?;
        staging.add(path, &bytes)?;
        Ok(Vec::new())
    }

    /// A remark on material and texture files that the output refers to but that are not in its folder.
    fn side_files(&self, input: &Loaded) -> Option<String> {
        let names = match (input.format, self.format) {
            (Format::Obj, Format::Obj) => input.attributes.libraries.clone(),
            (Format::Obj, Format::Gltf | Format::Glb) => {
                let materials = input.attributes.materials.iter();
                let mut textures: Vec<_> = materials.filter_map(|m| m.texture.clone()).collect();
                textures.sort_unstable();
                textures.dedup();
                textures
            }
            (Format::Ply, Format::Ply) => input.attributes.textures.clone(),
            (Format::Gltf | Format::Glb, Format::Gltf | Format::Glb) => {
                let document = input.document.as_ref().and_then(FileDocument::gltf);
                document.map(GltfDocument::side_files)?
            }
            _ => return None,
        };
        let folder = self.place.folder().unwrap_or(Path::new(""));
        let gone: Vec<String> = names
            .into_iter()
            .filter(|name| !folder.join(name).exists())
            .collect();
        let listed = gone.join(", ");
        (!gone.is_empty()).then(|| {
            format!("the written file refers to files that are not in its folder; copy them there: {listed}")
        })
    }
}

/// Reads the bytes of a file back and checks the mesh.
fn judged(bytes: &[u8], format: Format, params: &CheckParams) -> Result<Verdict, JobError> {
    let bad = |error: IoError| JobError::Bytes {
        name: "the written mesh".to_owned(),
        error,
    };
    let loaded = read_bytes(bytes, format, &no_side_files).map_err(bad)?;
    let bodies = loaded.bodies();
    let found = Inspection::of_bodies(&loaded.mesh, bodies.as_ref())?;
    Ok(checked(&found, bodies.as_ref(), params)?)
}

/// The smallest float type that holds the coordinates of the input exactly.
fn precision_of(input: &Loaded) -> Precision {
    match input.f32_exact {
        true => Precision::F32,
        false => Precision::F64,
    }
}
