//! Writing.

use std::borrow::Cow;
use std::path::Path;

use glam::{DMat4, DVec3};
use serde::{Deserialize, Serialize};

use super::deliver::{Component, Mark};
use super::hash::sha256;
use super::staging::{Staging, make_folder};
use super::texels::{Texels, add_material, refer_to_material};
use super::units::unit_notes;
use super::{JobError, Place};
use crate::attributes::transfer;
use crate::cancel::Cancel;
use crate::check::{CheckParams, Verdict};
use crate::fill::RegionReport;
use crate::io::{
    Contents, Document, Format, IoError, Loaded, Precision, WriteOptions, Written, model_to_bytes,
    no_side_files, read_bytes, replace_file,
};
use crate::mend::Inspection;
use crate::mesh::{Attributes, Mesh, Model, Unit};
use crate::stitch::count_crossing;

/// Where a mesh goes, in which format.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Output {
    /// The file, or bytes for the caller.
    pub place: Place,
    /// The format.
    pub format: Format,
    /// Text instead of binary.
    pub ascii: bool,
    /// Make its folder where it is not there.
    pub make_folder: bool,
}

/// What was written.
#[derive(Debug)]
pub(super) struct Saved {
    /// The mesh, its new vertices as they were rounded.
    pub(super) mesh: Mesh,
    /// What it carries.
    pub(super) attributes: Attributes,
    /// Remarks.
    pub(super) notes: Vec<String>,
    /// The bytes, where they are the caller's.
    pub(super) bytes: Vec<u8>,
    /// Their hash.
    pub(super) sha256: String,
    /// The verdict on the bytes, where it was asked for and they can be read without other files.
    pub(super) verdict: Option<Verdict>,
}

/// What is written, and how.
#[derive(Clone)]
pub(super) struct Saving<'a> {
    /// What was read, as far as it is kept.
    pub(super) input: &'a Loaded,
    /// Whether nothing of the input is kept.
    pub(super) whole: bool,
    /// For each vertex of a patch its expected error.
    pub(super) expected_error: &'a [Option<f64>],
    /// How the bytes are to be judged once they are read again, if they are.
    pub(super) judges: Option<CheckParams>,
    /// The components of the patches, and how they are marked.
    pub(super) components: &'a [Component],
    pub(super) mark: Option<Mark>,
    /// The unit of the coordinates, where it was given.
    pub(super) unit: Option<Unit>,
    /// Where the input came from.
    pub(super) source: &'a Place,
    /// Whether patches across seams of a texture get no texels of their own.
    pub(super) plain_patches: bool,
    /// The token that stops the writing.
    pub(super) cancel: &'a Cancel,
}

/// Bytes that were written.
pub(super) struct Stored {
    /// They, where they are the caller's.
    pub(super) bytes: Vec<u8>,
    /// Their hash.
    pub(super) sha256: String,
    /// Remarks.
    pub(super) notes: Vec<String>,
}

impl Output {
    /// An output in the format that is given, else in that of the extension.
    ///
    /// # Errors
    /// [`JobError::NoFormat`].
    pub fn new(place: impl Into<Place>, format: Option<Format>) -> Result<Self, JobError> {
        let place = place.into();
        let told = || Format::from_extension(place.path()?);
        match format.or_else(told) {
            Some(format) => Ok(Self {
                place,
                format,
                ascii: false,
                make_folder: false,
            }),
            None => Err(JobError::NoFormat {
                path: place.path().unwrap_or(Path::new("")).to_path_buf(),
            }),
        }
    }

    /// Checks what can be known before the mesh is.
    ///
    /// # Errors
    /// [`JobError::NoTextForm`] and [`JobError::Unwritable`].
    pub fn check(&self) -> Result<(), JobError> {
        let other = match self.format {
            Format::Glb => Some("gltf"),
            Format::Vtp => Some("vtk"),
            Format::ThreeMf => Some("off"),
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

    /// Whether what is written is text.
    pub fn is_text(&self) -> bool {
        let text = [Format::Obj, Format::Gltf, Format::Vtp, Format::Off].contains(&self.format);
        text || (self.ascii && !matches!(self.format, Format::Glb | Format::ThreeMf))
    }

    /// Whether it is glTF, whose documents go through as they are.
    pub(super) fn is_gltf(&self) -> bool {
        matches!(self.format, Format::Gltf | Format::Glb)
    }

    /// The transform to the coordinates of the mesh from those that the file holds as 32-bit floats, if that is what it holds.
    pub(super) fn stored(&self, input: &Loaded) -> Option<DMat4> {
        match self.format {
            Format::Gltf | Format::Glb => Some(match &input.document {
                Some(document) => document.largest_transform(),
                None => DMat4::IDENTITY,
            }),
            Format::Stl if !self.ascii => Some(DMat4::IDENTITY),
            Format::Obj | Format::Off | Format::ThreeMf => None,
            _ => input.f32_exact.then_some(DMat4::IDENTITY),
        }
    }

    /// Gives the patches of a mended mesh their attributes and writes it.
    ///
    /// Where the input's coordinates are all 32-bit floats the output's are too: only new vertices are rounded. The faces of
    /// patches that intersect others are counted again in what is written.
    pub(super) fn write_mended(
        &self,
        mut mesh: Mesh,
        saving: &Saving,
        regions: &mut [RegionReport],
        staging: &mut Staging,
    ) -> Result<Saved, JobError> {
        let (input, whole) = (saving.input, saving.whole);
        let kept = if whole { 0 } else { input.mesh.positions.len() };
        let rounds = matches!(self.format, Format::Gltf | Format::Glb | Format::Stl);
        let rounded = |p: &DVec3| p.as_vec3().as_dvec3();
        let is_exact = matches!(self.format, Format::Obj | Format::Off | Format::ThreeMf);
        if input.f32_exact && !is_exact {
            for position in &mut mesh.positions[kept..] {
                *position = rounded(position);
            }
            count_crossing_again(&mesh, input, whole, regions);
        } else if rounds {
            let positions = mesh.positions.iter().map(rounded).collect();
            let written = Mesh::new(positions, mesh.faces.clone());
            count_crossing_again(&written, input, whole, regions);
        }
        if whole {
            return self.write_whole(mesh, saving, staging);
        }
        let mut side_files = Staging::default();
        let mut done = self.dressed(mesh, kept, saving, &mut side_files)?;
        let in_file = self.format == Format::Obj && self.place.folder().is_some();
        let material = in_file && refer_to_material(&mut done.attributes);
        let document = input.document.as_ref();
        let mut saved = self.write_model(done.mesh, done.attributes, document, saving, staging)?;
        saved.notes = [done.notes, saved.notes].concat();
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

    /// A mended mesh with what it carries: attributes continued on patches, texels, marks, expected errors of vertices, of which the first
    /// `kept` are the input's.
    fn dressed(
        &self,
        mesh: Mesh,
        kept: usize,
        saving: &Saving,
        staging: &mut Staging,
    ) -> Result<Model, JobError> {
        let input = saving.input;
        let mut done = transfer(&input.mesh, &input.attributes, mesh);
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
            let file = (self.format, input.document.as_ref());
            let notes = mark.apply(&mut done, kept, saving.components, file);
            done.notes.extend(notes);
        }
        if matches!(self.format, Format::Ply | Format::Vtk | Format::Vtp) {
            done.tell_errors(kept, saving.expected_error);
        }
        Ok(done)
    }

    /// Writes a mesh as it was read: remarks, and the bytes where they are the caller's.
    pub(super) fn write_copy(
        &self,
        input: &Loaded,
        unit: Option<Unit>,
        staging: &mut Staging,
    ) -> Result<Stored, JobError> {
        let mut attributes = Cow::Borrowed(&input.attributes);
        if unit.is_some() && self.format == Format::ThreeMf {
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
        let attributes = Attributes {
            unit: saving.unit.or(saving.input.attributes.unit),
            ..Attributes::default()
        };
        let mut saved = self.write_model(mesh, attributes, None, saving, staging)?;
        let own = saving.input.attributes.unit;
        saved
            .notes
            .extend(unit_notes(own, saving.unit, self.format));
        let listed = saving.input.attributes.listed();
        if !listed.is_empty() {
            let what = format!("left out, because a whole level set has none: {listed}");
            saved.notes.push(what);
        }
        Ok(saved)
    }

    fn write_model(
        &self,
        mesh: Mesh,
        attributes: Attributes,
        document: Option<&Document>,
        saving: &Saving,
        staging: &mut Staging,
    ) -> Result<Saved, JobError> {
        let model = Contents {
            mesh: &mesh,
            attributes: &attributes,
            document,
        };
        let Written { bytes, mut notes } = self.encode(&model, precision_of(saving.input))?;
        let verdict = match (saving.judges.as_ref())
            .map(|params| judged(&bytes, self.format, params))
        {
            None => None,
            Some(Ok(verdict)) => Some(verdict),
            Some(Err(error)) => {
                notes.push(format!(
                    "the verdict is of the mesh in memory, since the bytes cannot be read alone: {error}"
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

    /// Writes a mesh and what it carries as it is: remarks, and the bytes where they are the caller's.
    ///
    /// # Errors
    /// When the format cannot hold it, or the file cannot be written.
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

    /// Writes a model that is handed on beside the mesh.
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

    /// A mesh and what it carries as the bytes of a file.
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

    /// Stages the bytes of the file, or returns them where they are the caller's.
    fn store(&self, bytes: Vec<u8>, staging: &mut Staging) -> Result<Vec<u8>, JobError> {
        let Place::File(path) = &self.place else {
            return Ok(bytes);
        };
        make_folder(path, self.make_folder)?;
        staging.add(path, &bytes)?;
        Ok(Vec::new())
    }

    /// A remark on material and texture files that the output refers to and that are not beside it.
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
                input.document.as_ref().map(Document::side_files)?
            }
            _ => return None,
        };
        let folder = self.place.folder().unwrap_or(Path::new(""));
        let gone: Vec<String> = names
            .into_iter()
            .filter(|name| !folder.join(name).exists())
            .collect();
        let listed = gone.join(", ");
        (!gone.is_empty()).then(|| format!("put beside it, since it refers to them: {listed}"))
    }
}

/// The verdict on the bytes of a file.
fn judged(bytes: &[u8], format: Format, params: &CheckParams) -> Result<Verdict, JobError> {
    let bad = |error: IoError| JobError::Bytes {
        name: "what was written".to_owned(),
        error,
    };
    let loaded = read_bytes(bytes, format, &no_side_files).map_err(bad)?;
    Ok(Inspection::new(&loaded.mesh)?.check(params))
}

/// The floats that hold the coordinates of what was read.
fn precision_of(input: &Loaded) -> Precision {
    match input.f32_exact {
        true => Precision::F32,
        false => Precision::F64,
    }
}

/// Writes text beside its target and moves it over it.
///
/// # Errors
/// [`IoError::Write`].
pub fn write_text(path: &Path, text: &str) -> Result<(), JobError> {
    write_bytes(path, text.as_bytes())
}

/// Writes bytes beside their target and moves them over it.
pub(super) fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), JobError> {
    let path = path.to_path_buf();
    replace_file(&path, bytes).map_err(|cause| JobError::Io(IoError::Write { path, cause }))
}

/// Counts the faces of patches that intersect others in the positions that are written.
fn count_crossing_again(mesh: &Mesh, input: &Loaded, whole: bool, regions: &mut [RegionReport]) {
    if whole && regions.iter().any(|r| !r.holes.is_empty()) {
        // Zero sets by themselves may pass through each other.
        return;
    }
    let kept = if whole { 0 } else { input.mesh.faces.len() };
    let patches: Vec<usize> = regions.iter().map(|r| r.new_faces).collect();
    let counts = count_crossing(mesh, kept, &patches);
    for (region, count) in regions.iter_mut().zip(counts) {
        region.set_intersecting(count);
    }
}
