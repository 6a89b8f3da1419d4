//! A mesh of the session: as it was read, or as a step made it.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock};

use glam::DVec3;
use serde_json::Value;

use super::delta::{Delta, Numbers};
use super::errors::Errors;
use super::runs::Runs;
use super::texture::Textures;
use super::words::Command;
use crate::check::CheckParams;
use crate::io::Loaded;
use crate::job::{Drawings, JobError, Mended, Place, Source, Work, inspect};
use crate::mend::{CreaseEnd, FillReport};
use crate::mesh::{Hole, Mesh};
use crate::report::counted;

/// A mesh of the session.
pub struct State {
    /// Its number, which no other mesh of the session has or had.
    pub id: u32,
    /// The one that it was made of.
    pub parent: Option<Arc<State>>,
    /// So many steps were made from the file to it.
    pub depth: usize,
    /// What made it; none for the file as it was read.
    pub step: Option<StepDone>,
    /// The mesh, with what it carries.
    pub loaded: Arc<Loaded>,
    /// Its holes.
    pub holes: Vec<Hole>,
    /// Where sharp edges end at their rims.
    pub crease_ends: Vec<CreaseEnd>,
    /// The document of `isomend inspect`.
    pub inspected: Value,
    /// For each face from where it is.
    pub origin: Vec<Origin>,
    /// For each face the region that made it in this step, from 1; else 0.
    pub region: Vec<u16>,
    /// The expected errors of its vertices.
    pub errors: Errors,
    /// What of the parent is kept, where that is known.
    pub delta: Option<Delta>,
    textures: OnceLock<Textures>,
    /// What was looked for last, and what was found.
    pub checked: Mutex<Option<(CheckParams, Value)>>,
}

/// Where a face is from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Origin {
    /// The file that was opened.
    File = 0,
    /// The step that made this mesh.
    New = 1,
    /// An earlier step.
    Earlier = 2,
}

/// A step that was done.
pub struct StepDone {
    /// What was done; the marks of its mask are in `mask`.
    pub work: Work,
    /// The faces that were marked.
    pub mask: Option<Runs>,
    /// The same as a command.
    pub command: Command,
    /// What it made, to be written in any format.
    pub mended: Mended<'static>,
    /// The document of the command.
    pub document: Value,
    /// What was done, in a line.
    pub summary: String,
    /// Whether all that was to be filled is.
    pub complete: bool,
    /// How long it took.
    pub seconds: f64,
}

impl State {
    /// The file as it was read.
    ///
    /// # Errors
    /// When the mesh cannot be measured.
    pub fn first(source: &Source, loaded: Arc<Loaded>) -> Result<Self, JobError> {
        let faces = loaded.mesh.faces.len();
        let (holes, crease_ends, inspected) = looked_at(source, &loaded)?;
        Ok(Self {
            id: 0,
            parent: None,
            depth: 0,
            step: None,
            holes,
            crease_ends,
            inspected,
            errors: Errors::read(&loaded),
            loaded,
            origin: vec![Origin::File; faces],
            region: vec![0; faces],
            delta: None,
            textures: OnceLock::new(),
            checked: Mutex::default(),
        })
    }

    /// What a step made of a state, as it is read from the bytes of `source`.
    ///
    /// # Errors
    /// As [`State::first`].
    pub fn next(
        parent: &Arc<State>,
        step: StepDone,
        report: &FillReport,
        source: &Source,
    ) -> Result<Self, JobError> {
        let loaded = source.read()?;
        let (holes, crease_ends, inspected) = looked_at(source, &loaded)?;
        let [_, first] = step.mended.kept_size();
        let kept = step.mended.kept();
        let whole = first == 0;
        let delta = match whole {
            true => None,
            false => Delta::new(&parent.loaded.mesh, &loaded.mesh, kept),
        };
        let faces = loaded.mesh.faces.len();
        // A repair that renumbers vertices keeps faces that are not the same by their numbers: they are found by their places.
        let delta = delta.filter(|delta| delta.faces.count() == first.min(faces));
        let origin = origins(parent, &loaded.mesh, delta.as_ref(), &step.mended);
        let errors = Errors::next(&parent.errors, &step.mended, &parent.loaded, &loaded);
        let mut region = vec![0; faces];
        let mut at = first.min(faces);
        for (number, made) in (1..).zip(&report.regions) {
            let end = faces.min(at + made.new_faces);
            region[at..end].fill(u16::try_from(number).unwrap_or(u16::MAX));
            at = end;
        }
        Ok(Self {
            id: 0,
            parent: Some(parent.clone()),
            depth: parent.depth + 1,
            step: Some(step),
            loaded,
            holes,
            crease_ends,
            inspected,
            origin,
            region,
            errors,
            delta,
            textures: OnceLock::new(),
            checked: Mutex::default(),
        })
    }

    /// Where it is: the file that was opened, or what a step made of it, in memory.
    pub fn place(&self, input: &Path) -> Place {
        match self.depth {
            0 => input.into(),
            depth => place_after(input, depth),
        }
    }

    /// The images on it.
    pub fn textures(&self) -> &Textures {
        self.textures.get_or_init(|| Textures::new(&self.loaded))
    }

    /// The step, and those before it, from the first on.
    pub fn steps(&self) -> Vec<&StepDone> {
        let mut steps: Vec<&StepDone> = Vec::new();
        let mut at = Some(self);
        while let Some(state) = at {
            steps.extend(&state.step);
            at = state.parent.as_deref();
        }
        steps.reverse();
        steps
    }
}

impl Origin {
    /// The same after another step.
    fn aged(self) -> Self {
        match self {
            Self::File => Self::File,
            Self::New | Self::Earlier => Self::Earlier,
        }
    }
}

/// For each face of a mesh, as it was read again, from where it is: as in the mesh that it was made of, where that has the face.
fn origins(parent: &State, mesh: &Mesh, delta: Option<&Delta>, mended: &Mended) -> Vec<Origin> {
    let faces = mesh.faces.len();
    let before: Vec<Option<u32>> = match delta {
        Some(delta) => delta.faces.numbers().map(|old| Some(old as u32)).collect(),
        None if is_in_order(mesh, mended) => mended.face_origins(),
        None => Numbers::by_position(mesh, &parent.loaded.mesh).faces,
    };
    let mut origin = vec![Origin::New; faces];
    for (new, old) in origin.iter_mut().zip(before) {
        if let Some(old) = old {
            *new = parent.origin[old as usize].aged();
        }
    }
    origin
}

/// Whether the faces of a mesh, as it was read again, are those that were written, in the same order and where they were but for what a
/// format rounds.
fn is_in_order(mesh: &Mesh, mended: &Mended) -> bool {
    const ROUNDED: f64 = 1e-5;
    let [low, high] = mesh.bounds();
    let near = ROUNDED * low.distance(high);
    let is_same = |face: u32| {
        let corners = mended.face_corners(face as usize);
        let both = |written| mesh.corners(face).into_iter().zip(written);
        corners.is_some_and(|written: [DVec3; 3]| both(written).all(|(p, q)| p.distance(q) <= near))
    };
    let faces = mesh.faces.len();
    mended.face_corners(faces).is_none() && (0..faces as u32).all(is_same)
}

/// The holes of a mesh, the crease ends at their rims, and all that `isomend inspect` tells of it.
fn looked_at(
    source: &Source,
    loaded: &Loaded,
) -> Result<(Vec<Hole>, Vec<CreaseEnd>, Value), JobError> {
    let inspected = inspect(source, loaded, None, None, &Drawings::default())?;
    let document = serde_json::to_value(inspected.document()).unwrap_or_default();
    Ok((inspected.found.holes, inspected.crease_ends, document))
}

/// The place of a mesh after so many steps: in memory, with what it refers to beside the file that was opened.
pub fn place_after(input: &Path, depth: usize) -> Place {
    let name = input.file_name().unwrap_or_default().to_string_lossy();
    Place::Memory {
        name: format!("{name}, step {depth}"),
        folder: input.parent().map(Path::to_path_buf),
    }
}

/// The file of the mesh between two steps in a recipe, which writes it.
pub fn between(input: &Path, depth: usize, extension: &str) -> PathBuf {
    let stem = input.file_stem().unwrap_or_default().to_string_lossy();
    input.with_file_name(format!("{stem}.isomend-step{depth}.{extension}"))
}

impl StepDone {
    /// What was done, in a word or two.
    pub fn label(&self) -> String {
        let marked = self.mask.as_ref().map(Runs::count);
        match (&self.work, marked) {
            (Work::Fill(params), _) => match &params.holes {
                Some(holes) if holes.len() == 1 => format!("fill hole {}", holes[0]),
                Some(holes) => format!("fill {}", counted(holes.len(), "hole")),
                None => "fill all holes".to_owned(),
            },
            (work, Some(faces)) => format!("{} {}", work.name(), counted(faces, "face")),
            (work, None) => work.name().to_owned(),
        }
    }
}
