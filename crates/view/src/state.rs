//! A mesh of the session: the input or the result of a step, with its holes, the origin of its faces, and its expected errors.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock};

use glam::DVec3;
use serde_json::Value;

use super::delta::{Delta, KeptNumbers};
use super::errors::Errors;
use super::runs::Runs;
use super::texture::Textures;
use super::walls::Thickness;
use super::words::Command;
use isomend_core::check::CheckParams;
use isomend_core::fill::{HoleOutcome, LeftReason};
use isomend_core::mend::{Control, CreaseEnd, FillPlan, FillReport, PlannedHole};
use isomend_core::mesh::{Hole, HoleId, Mesh, area_vector};
use isomend_files::io::Loaded;
use isomend_files::job::{
    Drawings, INTERMEDIATE, JobError, Mended, Place, Source, Work, default_plan, inspect,
};
use isomend_files::report::scene::up_axis;
use isomend_files::report::{Standing, counted};

/// A mesh of the session.
pub struct State {
    /// Its number, which is never reused in the session.
    pub id: u32,
    /// The mesh that it was made from.
    pub parent: Option<Arc<State>>,
    /// Number of steps from the input to it.
    pub depth: usize,
    /// The step that made it; none for the input.
    pub step: Option<StepDone>,
    /// The mesh with its attributes.
    pub loaded: Arc<Loaded>,
    /// The lowest and the highest coordinates of its faces.
    pub bounds: [DVec3; 2],
    /// Its holes.
    pub holes: Vec<Hole>,
    /// What a fill with default parameters would do.
    pub plan: FillPlan,
    /// The ends of sharp edges at its rims.
    pub crease_ends: Vec<CreaseEnd>,
    /// The document of `isomend inspect`.
    pub inspected: Value,
    /// The origin of each face.
    pub origin: Vec<Origin>,
    /// For each face the region that made it in this step, counted from 1; 0 for other faces.
    pub region: Vec<u16>,
    /// The expected errors of its vertices.
    pub errors: Errors,
    /// The vertices and faces of the parent that it keeps in order, if known.
    pub delta: Option<Delta>,
    /// Pairs of an old and a new face that replaces it, if the step faired marked faces; see [`Delta::replaced`].
    pub replaced: Vec<[u32; 2]>,
    textures: OnceLock<Textures>,
    up: OnceLock<DVec3>,
    mean_normal: OnceLock<DVec3>,
    /// Parameters and result of the last check for defects.
    pub checked: Mutex<Option<(CheckParams, Value)>>,
    /// The wall thickness at its faces, as far as it was asked for.
    pub thickness: Mutex<Thickness>,
    /// Once the missing piece was requested: why there is none, or `None` if it can be made.
    pub piece: Mutex<Option<Option<String>>>,
}

/// The origin of a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Origin {
    /// The input file.
    File = 0,
    /// The step that made this mesh.
    New = 1,
    /// An earlier step.
    Earlier = 2,
}

/// A completed step.
pub struct StepDone {
    /// The work, without the marked faces.
    pub work: Work,
    /// The marked faces.
    pub mask: Option<Runs>,
    /// Whether the mesh kept its own marked faces, because the step marked faces only for itself.
    pub keep_marks: bool,
    /// Whether patches across seams of a texture get no texels of their own.
    pub no_texture: bool,
    /// The step as a command.
    pub command: Command,
    /// The result, which can be written in any format.
    pub mended: Mended<'static>,
    /// The JSON document of the command.
    pub document: Value,
    /// A summary in one line.
    pub summary: String,
    /// How good the result is.
    pub standing: Standing,
    /// Whether all requested holes were filled.
    pub complete: bool,
    /// Run time in seconds.
    pub seconds: f64,
}

impl State {
    /// The state of the input file.
    ///
    /// # Errors
    /// When the mesh cannot be inspected.
    pub fn first(source: &Source, loaded: Arc<Loaded>) -> Result<Self, JobError> {
        let faces = loaded.mesh.faces.len();
        let Seen {
            holes,
            plan,
            crease_ends,
            inspected,
        } = Seen::new(source, &loaded)?;
        Ok(Self {
            id: 0,
            parent: None,
            depth: 0,
            step: None,
            bounds: loaded.mesh.bounds(),
            holes,
            plan,
            crease_ends,
            inspected,
            errors: Errors::read(&loaded),
            loaded,
            origin: vec![Origin::File; faces],
            region: vec![0; faces],
            delta: None,
            replaced: Vec::new(),
            textures: OnceLock::new(),
            up: OnceLock::new(),
            mean_normal: OnceLock::new(),
            checked: Mutex::default(),
            thickness: Mutex::default(),
            piece: Mutex::default(),
        })
    }

    /// The plan for a hole. Holes are numbered in order, from 1.
    fn planned(&self, id: HoleId) -> Option<&PlannedHole> {
        let planned = self.plan.holes.get(id.get().checked_sub(1)?)?;
        (planned.hole.id == id).then_some(planned)
    }

    /// Whether a fill with default parameters leaves a hole open, as the outer border of a sheet that faces no other rim.
    pub fn stays_open(&self, id: HoleId) -> bool {
        let left = Some(HoleOutcome::Left(LeftReason::OuterBoundary));
        self.planned(id).is_some_and(|hole| hole.outcome == left)
    }

    /// The other holes that a fill with default parameters fills together with this one.
    pub fn joined(&self, id: HoleId) -> Vec<HoleId> {
        let number = self.planned(id).map(|hole| hole.region);
        let own = number.and_then(|number| self.plan.regions.get(number.checked_sub(1)?));
        let others = own.into_iter().flat_map(|region| &region.holes);
        others.filter(|other| **other != id).copied().collect()
    }

    /// The state after a step. The mesh is read back from the bytes of `source`, as the next command would read it.
    ///
    /// # Errors
    /// When `source` cannot be read, or the mesh cannot be inspected.
    pub fn next(
        parent: &Arc<State>,
        step: StepDone,
        report: &FillReport,
        source: &Source,
    ) -> Result<Self, JobError> {
        let found = Self::first(source, source.read()?)?;
        let loaded = &found.loaded;
        // Find the vertices and faces that the step kept in order.
        let [_, first] = step.mended.kept_size();
        let kept = step.mended.kept();
        let whole = first == 0;
        let delta = match whole {
            true => None,
            false => Delta::new(&parent.loaded.mesh, &loaded.mesh, kept),
        };
        let faces = loaded.mesh.faces.len();
        // If a repair renumbered vertices, the kept faces do not match by number. They are then found by position.
        let delta = delta.filter(|delta| delta.faces.count() == first.min(faces));
        let origin = origins(parent, &loaded.mesh, delta.as_ref(), &step.mended);
        let errors = Errors::next(&parent.errors, &step.mended, &parent.loaded, loaded);
        // The new faces follow the kept ones, region by region.
        let mut region = vec![0; faces];
        let mut at = first.min(faces);
        for (number, made) in (1..).zip(&report.regions) {
            let end = faces.min(at + made.new_faces);
            region[at..end].fill(u16::try_from(number).unwrap_or(u16::MAX));
            at = end;
        }
        let replaced = match (&step.work, &delta) {
            (Work::Fair(Some(_), _), Some(delta)) => {
                delta.replaced(&parent.loaded.mesh, &loaded.mesh)
            }
            _ => Vec::new(),
        };
        Ok(Self {
            parent: Some(parent.clone()),
            depth: parent.depth + 1,
            step: Some(step),
            origin,
            region,
            errors,
            delta,
            replaced,
            ..found
        })
    }

    /// Its location: the input file, or a file in memory after a step.
    pub fn place(&self, input: &Path) -> Place {
        match self.depth {
            0 => input.into(),
            depth => place_after(input, depth),
        }
    }

    /// The mean of the unit normal over its area: long if it is a sheet that faces one way, zero if it is closed.
    pub fn mean_normal(&self) -> DVec3 {
        *self.mean_normal.get_or_init(|| {
            let mesh = &self.loaded.mesh;
            let (mut sum, mut area) = (DVec3::ZERO, 0.0);
            for f in 0..mesh.faces.len() as u32 {
                let own = area_vector(mesh.corners(f));
                sum += own;
                area += own.length();
            }
            sum / f64::max(area, f64::MIN_POSITIVE)
        })
    }

    /// The axis that likely points up.
    pub fn up(&self) -> DVec3 {
        *self.up.get_or_init(|| {
            let mesh = &self.loaded.mesh;
            let point = |v: &u32| mesh.positions[*v as usize];
            let rims: Vec<Vec<DVec3>> = self
                .holes
                .iter()
                .map(|h| h.rim.iter().map(point).collect())
                .collect();
            up_axis(mesh, &rims, self.bounds)
        })
    }

    /// Its texture images.
    pub fn textures(&self) -> &Textures {
        self.textures.get_or_init(|| Textures::new(&self.loaded))
    }

    /// All steps from the input to this mesh, the first one first.
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
    /// The origin of the same face after another step.
    fn after_step(self) -> Self {
        match self {
            Self::File => Self::File,
            Self::New | Self::Earlier => Self::Earlier,
        }
    }
}

/// The origins of the faces after a step: kept faces inherit them from the parent, the others are new.
fn origins(parent: &State, mesh: &Mesh, delta: Option<&Delta>, mended: &Mended) -> Vec<Origin> {
    let faces = mesh.faces.len();
    let before: Vec<Option<u32>> = match delta {
        Some(delta) => delta.faces.numbers().map(|old| Some(old as u32)).collect(),
        None if is_in_order(mesh, mended) => mended.face_origins(),
        None => KeptNumbers::by_position(mesh, &parent.loaded.mesh).faces,
    };
    let mut origin = vec![Origin::New; faces];
    for (new, old) in origin.iter_mut().zip(before) {
        if let Some(old) = old {
            *new = parent.origin[old as usize].after_step();
        }
    }
    origin
}

/// Whether a mesh that was read back has the written faces in the same order, at the same positions up to the format's rounding.
fn is_in_order(mesh: &Mesh, mended: &Mended) -> bool {
    /// Tolerance of positions, relative to the diagonal of the bounding box.
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

/// What is found in a mesh.
struct Seen {
    holes: Vec<Hole>,
    plan: FillPlan,
    crease_ends: Vec<CreaseEnd>,
    /// The document of `isomend inspect`.
    inspected: Value,
}

impl Seen {
    fn new(source: &Source, loaded: &Arc<Loaded>) -> Result<Self, JobError> {
        let (drawings, control) = (Drawings::default(), Control::new());
        let inspected = inspect(source, loaded, None, None, &drawings, &control)?;
        Ok(Self {
            plan: default_plan(loaded, &inspected.found)?,
            inspected: serde_json::to_value(inspected.document()).unwrap_or_default(),
            holes: inspected.found.holes,
            crease_ends: inspected.crease_ends,
        })
    }
}

/// The location of the mesh after `depth` steps: in memory; files that it refers to are found in the folder of the input.
pub fn place_after(input: &Path, depth: usize) -> Place {
    let name = input.file_name().unwrap_or_default().to_string_lossy();
    Place::Memory {
        name: format!("{name}, step {depth}"),
        folder: input.parent().map(Path::to_path_buf),
    }
}

/// The intermediate file after `depth` steps, as a recipe writes it.
pub fn between(input: &Path, depth: usize, extension: &str) -> PathBuf {
    let stem = input.file_stem().unwrap_or_default().to_string_lossy();
    input.with_file_name(format!("{stem}{INTERMEDIATE}{depth}.{extension}"))
}

impl StepDone {
    /// A label of a few words for the history.
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
