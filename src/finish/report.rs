//! What a finish found and did.

use glam::DVec3;

/// A patch after its finish.
#[derive(Clone, Debug)]
pub struct Finished {
    /// The vertices, rising.
    pub vertices: Vec<u32>,
    /// Their new positions, in their order, in units of the mesh; those that they had, to the bit, where the finish was refused.
    pub positions: Vec<DVec3>,
    /// Where they are at the minimum of the energy, in their order, in units of the mesh: the step before, for callers that find
    /// fault with a blend. Empty where the positions are not those of a blend, or the minimum was refused.
    pub minimum: Vec<DVec3>,
    /// The expected error of each, in their order, in units of the mesh: about 0.7 of a patch's vertices are nearer to the true
    /// surface than this, 0.92 nearer than twice this. NaN where nothing can be said.
    pub expected_error: Vec<f64>,
    /// What was found.
    pub found: FinishFound,
}

impl Finished {
    /// Makes it one that was stopped before the positions were taken.
    pub(super) fn set_stopped(&mut self) {
        self.minimum.clear();
        self.expected_error.fill(f64::NAN);
        let found = &self.found;
        self.found = FinishFound {
            vertices: found.vertices,
            diameter: found.diameter,
            edge: found.edge,
            energy_before: found.energy_before,
            energy_after: found.energy_before,
            folds_before: found.folds_before,
            folds_after: found.folds_before,
            willmore_refused: Some(Refusal::Stopped),
            ..FinishFound::default()
        };
    }
}

/// What a finish found and did.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub struct FinishFound {
    /// Number of vertices that could move.
    pub vertices: usize,
    /// The largest distance of two vertices of the rim, in units of the mesh.
    pub diameter: f64,
    /// Mean length of edges round the patch, in units of the mesh.
    pub edge: f64,
    /// What the positions are.
    pub result: FinishResult,
    /// Steps of Gauss-Newton, of all starts that were taken.
    pub steps: usize,
    /// Whether they ended at a minimum: the last was shorter than the tolerance.
    pub converged: bool,
    /// Whether a second start was tried.
    pub restart: Restart,
    /// `½ ∫ h²` of the patch before, `h` being the sum of the principal curvatures.
    pub energy_before: f64,
    /// The same at the minimum of the energy.
    pub energy_after: f64,
    /// Folded faces of the patch before.
    pub folds_before: usize,
    /// Folded faces of the patch after.
    pub folds_after: usize,
    /// The surfaces that were blended.
    pub candidates: Vec<CandidateFound>,
    /// Why the minimum of the energy was not taken.
    pub willmore_refused: Option<Refusal>,
    /// Why the blend was not made, or not taken.
    pub blend_refused: Option<Refusal>,
    /// The farthest way of a vertex, in units of the mesh.
    pub largest_move: f64,
    /// Mean of the expected errors of the vertices, in units of the mesh; none where nothing can be said.
    #[serde(alias = "mean_sigma")]
    pub mean_expected_error: Option<f64>,
    /// The largest of them.
    #[serde(alias = "largest_sigma")]
    pub largest_expected_error: Option<f64>,
}

impl FinishFound {
    /// The blend met other faces: the minimum is taken instead.
    pub(crate) fn refuse_blend(&mut self) {
        if self.result == FinishResult::Blend {
            self.blend_refused = Some(Refusal::Crossing);
            self.result = match self.willmore_refused {
                None => FinishResult::Willmore,
                Some(_) => FinishResult::Unchanged,
            };
        }
    }

    /// The minimum met other faces too: the patch stays as it was.
    pub(crate) fn refuse_all(&mut self) {
        self.refuse_blend();
        self.willmore_refused.get_or_insert(Refusal::Crossing);
        self.result = FinishResult::Unchanged;
        self.energy_after = self.energy_before;
        self.folds_after = self.folds_before;
        self.largest_move = 0.0;
        (self.mean_expected_error, self.largest_expected_error) = (None, None);
    }
}

/// What the positions of a finished patch are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum FinishResult {
    /// Those that they were.
    #[default]
    Unchanged,
    /// A minimum of Willmore's energy.
    Willmore,
    /// Its blend with what the surroundings foretell.
    Blend,
}

/// Whether Gauss-Newton was started a second time, from the biharmonic fill of the same triangles; of a large patch, whether its one
/// start is with a strip along the rim filled so.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Restart {
    /// The first start was quick and did not fold.
    #[default]
    NotNeeded,
    /// It was, to no better end.
    Tried,
    /// It was, and has fewer folds or the lower energy.
    Taken,
}

/// A surface that a blend may be made of.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize,
)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Candidate {
    /// The minimum of the energy.
    Willmore,
    /// Kriging over a sphere, from a collar of 0.45 diameters.
    Sphere,
    /// Kriging over a plane, from a collar of 0.45 diameters.
    Plane,
    /// The biharmonic fill, where the patch bends little.
    Biharmonic,
    /// The triharmonic fill.
    Triharmonic,
}

/// The surface over which heights were kriged.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum ChartKind {
    /// A plane.
    Plane,
    /// A sphere of so many diameters of the hole in radius; negative where the surface is hollow.
    Sphere(f64),
}

/// What is known of a surface that a blend may be made of.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub struct CandidateFound {
    /// Which.
    pub candidate: Candidate,
    /// Over what it was kriged, if it was.
    pub chart: Option<ChartKind>,
    /// The order of the kernel, 2 to 5; 0 for what is not kriged.
    pub order: u8,
    /// The kernel's length for the noise of the data, in mean edges; 0 where they are exact.
    pub nugget: f64,
    /// Root mean square of its error, along the normal, on rings of known vertices that were left out (the geometric mean of two
    /// rings), in units of the mesh.
    pub ring_error: Option<f64>,
    /// Its weight in the blend.
    pub weight: f64,
}

/// Why a patch, or a way of finishing it, was left.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, thiserror::Error, serde::Serialize, serde::Deserialize,
)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Refusal {
    /// No vertex of the patch is used by a face.
    #[error("the patch has no vertex of its own that a face uses")]
    NoVertices,
    /// Too many vertices.
    #[error("the patch has more vertices than are finished")]
    TooLarge,
    /// Nothing is round the patch that stays.
    #[error("nothing known is round the patch")]
    NothingKnown,
    /// Coordinates, or what was computed of them, are not numbers.
    #[error("its shape gives no finite numbers")]
    NotFinite,
    /// A system could not be solved.
    #[error("its triangles give no system that can be solved")]
    Singular,
    /// A vertex would move too far.
    #[error("a vertex would move too far")]
    MovedTooFar,
    /// More faces would be folded.
    #[error("more faces would be folded over")]
    Folded,
    /// Faces would intersect others.
    #[error("faces would intersect others")]
    Crossing,
    /// The energy would be higher.
    #[error("the energy would be higher")]
    EnergyRose,
    /// Nothing but the minimum of the energy could be made of the surroundings.
    #[error("the surroundings foretell nothing")]
    NoChart,
    /// No ring of known vertices on which continuations could be tried.
    #[error("no ring of vertices round the hole on which to try a continuation")]
    NoRing,
    /// The parameters do not ask for it.
    #[error("it was not asked for")]
    NotAsked,
    /// Stopped by the caller.
    #[error("it was stopped")]
    Stopped,
}
