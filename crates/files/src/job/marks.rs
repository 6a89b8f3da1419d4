//! Masks as users specify them: by boxes, balls, closed meshes, face numbers, colours and materials. Applies them to a mesh.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::JobError;
use crate::io::{Loaded, read_path, read_text};
use crate::report::missed_lines;
use isomend_core::mend::Inspection;
use isomend_core::mesh::mask::{Mask, Selector};
use isomend_core::spatial::{Bvh, WindingTree};

/// Specifies a set of faces: the union of the faces that its fields select. See [`Mask`](isomend_core::mesh::mask::Mask).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MaskSpec {
    /// Boxes by their smallest and largest coordinates.
    pub boxes: Vec<[DVec3; 2]>,
    /// Balls by their centres and radii.
    pub balls: Vec<(DVec3, f64)>,
    /// Files of closed meshes; selects the faces inside them.
    pub inside: Vec<PathBuf>,
    /// Face numbers, from 0.
    pub faces: Vec<usize>,
    /// Files of face numbers, as [`parse_face_numbers`] reads them.
    pub face_files: Vec<PathBuf>,
    /// Colours of vertices.
    pub colours: Vec<PaintedColour>,
    /// Names of materials.
    pub materials: Vec<String>,
    /// Adds the faces within this distance of the selected ones, measured along the edges of the mesh.
    pub grow: Option<f64>,
    /// After growing, removes the faces that are nearer than this to faces outside the selection.
    pub shrink: Option<f64>,
}

/// A vertex colour with a tolerance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PaintedColour {
    /// Red, green and blue, from 0 to 1.
    pub rgb: [f64; 3],
    /// Largest difference allowed in each of the three channels.
    pub tolerance: f64,
}

/// The faces of a mesh that a mask marks.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Marked {
    /// For each face, whether it is marked.
    pub faces: Vec<bool>,
    /// If no face is marked: the reasons, one line per part of the mask.
    pub missed: Vec<String>,
}

impl Marked {
    /// The marks, if any face is marked.
    ///
    /// # Errors
    /// [`JobError::NothingMarked`] with the reasons.
    pub fn some(self) -> Result<Vec<bool>, JobError> {
        match self.missed.is_empty() {
            true => Ok(self.faces),
            false => Err(JobError::NothingMarked { why: self.missed }),
        }
    }
}

/// A mask with its files read, and the bounding boxes of the closed meshes among its selectors.
struct Chosen {
    mask: Mask,
    inside: Vec<[DVec3; 2]>,
}

impl MaskSpec {
    /// Whether it has no selectors.
    pub fn is_empty(&self) -> bool {
        let Self {
            boxes,
            balls,
            inside,
            faces,
            face_files,
            colours,
            materials,
            ..
        } = self;
        boxes.is_empty()
            && balls.is_empty()
            && inside.is_empty()
            && faces.is_empty()
            && face_files.is_empty()
            && colours.is_empty()
            && materials.is_empty()
    }

    /// Checks the mask without a mesh: that its files can be read and used.
    ///
    /// # Errors
    /// [`JobError::EmptyMask`], and the errors of [`MaskSpec::marked`] that do not depend on the mesh.
    pub fn check(&self) -> Result<(), JobError> {
        if self.is_empty() && self.grow.or(self.shrink).is_some() {
            return Err(JobError::EmptyMask);
        }
        self.chosen().map(|_| ())
    }

    /// Applies the mask to a mesh.
    ///
    /// # Errors
    /// If a file cannot be read or used, or if the mesh does not have the faces, colours or materials that the mask names.
    pub fn marked(&self, loaded: &Loaded) -> Result<Marked, JobError> {
        let Chosen { mask, inside } = self.chosen()?;
        let (mesh, attributes) = (&loaded.mesh, &loaded.attributes);
        let faces = mask.faces(mesh, attributes)?;
        let missed = match faces.contains(&true) {
            true => Vec::new(),
            false => missed_lines(&mask, &inside, mesh, attributes),
        };
        Ok(Marked { faces, missed })
    }

    /// Reads the files and makes the mask.
    fn chosen(&self) -> Result<Chosen, JobError> {
        let box_of = |&[low, high]: &[DVec3; 2]| Selector::Box { low, high };
        let ball_of = |&(centre, radius): &(DVec3, f64)| Selector::Ball { centre, radius };
        let mut selectors: Vec<Selector> = self.boxes.iter().map(box_of).collect();
        selectors.extend(self.balls.iter().map(ball_of));
        let mut inside = Vec::new();
        for path in &self.inside {
            let (selector, bounds) = within(path)?;
            selectors.push(selector);
            inside.push(bounds);
        }
        if !self.faces.is_empty() {
            selectors.push(Selector::Faces(self.faces.clone()));
        }
        for path in &self.face_files {
            selectors.push(Selector::Faces(face_numbers(path)?));
        }
        selectors.extend(self.colours.iter().map(|colour| Selector::Colour {
            rgb: colour.rgb,
            tolerance: colour.tolerance,
        }));
        let materials = self.materials.iter().cloned();
        selectors.extend(materials.map(Selector::Material));
        let mask = Mask {
            selectors,
            grow: self.grow.unwrap_or(0.0),
            shrink: self.shrink.unwrap_or(0.0),
        };
        Ok(Chosen { mask, inside })
    }
}

/// A selector for points inside a closed mesh (generalized winding number above 1/2 in absolute value), and the bounds of the mesh.
fn within(path: &Path) -> Result<(Selector, [DVec3; 2]), JobError> {
    let loaded = read_path(path, None)?;
    let bounds = loaded.mesh.bounds();
    let found = Inspection::new(loaded.mesh).map_err(|error| JobError::MaskMesh {
        path: path.to_path_buf(),
        error,
    })?;
    if found.topology.boundary.contains(&true) {
        let path = path.to_path_buf();
        return Err(JobError::OpenMask { path });
    }
    let bvh = Bvh::new(&found.mesh, 0..found.mesh.faces.len() as u32);
    let tree = WindingTree::new(&bvh);
    let selector = Selector::Inside(Arc::new(move |p| tree.winding_number(&bvh, p).abs() > 0.5));
    Ok((selector, bounds))
}

/// Reads face numbers from a file: a JSON array, or one number per line with comments after `#`.
///
/// # Errors
/// If the file cannot be read or contains anything else.
pub fn face_numbers(path: &Path) -> Result<Vec<usize>, JobError> {
    let text = read_text(path)?;
    parse_face_numbers(&text, &path.display().to_string())
}

/// Parses face numbers: a JSON array, or one number per line with comments after `#`. `name` is the file's name in errors.
///
/// # Errors
/// If the text contains anything else.
pub fn parse_face_numbers(text: &str, name: &str) -> Result<Vec<usize>, JobError> {
    let bad = |line, what: String| JobError::FaceList {
        name: name.to_owned(),
        line,
        what,
    };
    if text.trim_start().starts_with('[') {
        return serde_json::from_str(text)
            .map_err(|error| bad(None, format!("not a JSON array of face numbers: {error}")));
    }
    let mut numbers = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or("").trim();
        if !line.is_empty() {
            let number = line.parse().map_err(|error| {
                bad(
                    Some(i + 1),
                    format!("'{line}' is not a face number: {error}"),
                )
            });
            numbers.push(number?);
        }
    }
    Ok(numbers)
}
