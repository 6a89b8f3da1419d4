//! Masks as they are written down: in numbers, colours, names and files.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::JobError;
use crate::io::{Loaded, read_path, read_text};
use crate::mend::Inspection;
use crate::mesh::mask::{Mask, Selector};
use crate::report::missed_lines;
use crate::spatial::{Bvh, WindingTree};

/// Chooses faces; what several of its fields choose adds up. See [`Mask`](crate::Mask).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MaskSpec {
    /// Boxes by their smallest and largest coordinates.
    pub boxes: Vec<[DVec3; 2]>,
    /// Balls by their centres and radii.
    pub balls: Vec<(DVec3, f64)>,
    /// Files of closed meshes: what lies inside.
    pub inside: Vec<PathBuf>,
    /// Face numbers, from 0.
    pub faces: Vec<usize>,
    /// Files of face numbers, as [`parse_face_numbers`] reads them.
    pub face_files: Vec<PathBuf>,
    /// Colours of vertices.
    pub colours: Vec<PaintedColour>,
    /// Names of materials.
    pub materials: Vec<String>,
    /// Takes in what is at most so far from the marked faces, along the edges of the mesh.
    pub grow: Option<f64>,
    /// Then leaves out what is nearer than this to faces that are not marked.
    pub shrink: Option<f64>,
}

/// A colour and how far off others may be.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PaintedColour {
    /// Red, green and blue, from 0 to 1.
    pub rgb: [f64; 3],
    /// The most that any of the three may be off.
    pub tolerance: f64,
}

/// What a mask marks of a mesh.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Marked {
    /// For each face whether it is marked.
    pub faces: Vec<bool>,
    /// Where nothing is marked, why.
    pub missed: Vec<String>,
}

impl Marked {
    /// The marks.
    ///
    /// # Errors
    /// [`JobError::NothingMarked`].
    pub fn some(self) -> Result<Vec<bool>, JobError> {
        match self.missed.is_empty() {
            true => Ok(self.faces),
            false => Err(JobError::NothingMarked { why: self.missed }),
        }
    }
}

/// A mask, and the bounds of the closed meshes among its selectors.
struct Chosen {
    mask: Mask,
    inside: Vec<[DVec3; 2]>,
}

impl MaskSpec {
    /// Whether it chooses nothing.
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

    /// Whether its files can be read and its numbers make sense.
    ///
    /// # Errors
    /// As [`MaskSpec::marked`], as far as the mesh is not asked; [`JobError::EmptyMask`].
    pub fn check(&self) -> Result<(), JobError> {
        if self.is_empty() && self.grow.or(self.shrink).is_some() {
            return Err(JobError::EmptyMask);
        }
        self.chosen().map(|_| ())
    }

    /// Which faces of a mesh are marked.
    ///
    /// # Errors
    /// When a file cannot be read or used, or the mesh has no such faces, colours or materials.
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

/// What lies inside a closed mesh, by its generalized winding number; and the bounds of the mesh.
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

/// Face numbers from a file: a JSON array, or one on each line, with `#` before remarks.
///
/// # Errors
/// When it cannot be read, or holds something else.
pub fn face_numbers(path: &Path) -> Result<Vec<usize>, JobError> {
    let text = read_text(path)?;
    parse_face_numbers(&text, &path.display().to_string())
}

/// As `face_numbers`, from the text of a file of that name.
///
/// # Errors
/// When it holds something else.
pub fn parse_face_numbers(text: &str, name: &str) -> Result<Vec<usize>, JobError> {
    let bad = |line, what: String| JobError::FaceList {
        name: name.to_owned(),
        line,
        what,
    };
    if text.trim_start().starts_with('[') {
        return serde_json::from_str(text)
            .map_err(|error| bad(None, format!("no JSON array of face numbers: {error}")));
    }
    let mut numbers = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or("").trim();
        if !line.is_empty() {
            let number = line.parse().map_err(|error| {
                bad(
                    Some(i + 1),
                    format!("'{line}' is not the number of a face: {error}"),
                )
            });
            numbers.push(number?);
        }
    }
    Ok(numbers)
}
