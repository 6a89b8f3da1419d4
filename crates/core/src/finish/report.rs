//! Report of a finish: what was found, done and refused.

use glam::DVec3;

/// A patch after its finish.
#[derive(Clone, Debug)]
pub struct Finished {
    /// The vertices, in rising order.
    pub vertices: Vec<u32>,
    /// The new positions of these vertices, in units of the mesh; the old ones bit for bit if the finish was refused.
    pub positions: Vec<DVec3>,
    /// The positions of these vertices at the minimum of the energy, in units of the mesh, for callers that reject the blend.
    /// Empty unless the result is a blend and the minimum was accepted.
    pub minimum: Vec<DVec3>,
    /// The expected error of each of these vertices, in units of the mesh: about 0.7 of a patch's vertices are within this
    /// distance of the true surface, 0.92 within twice this. NaN if unknown.
    pub expected_error: Vec<f64>,
    /// The report.
    pub found: FinishRecord,
}

impl Finished {
    /// Turns it into the result of a finish that was cancelled before the positions were computed.
    pub(super) fn set_stopped(&mut self) {
        self.minimum.clear();
        self.expected_error.fill(f64::NAN);
        let found = &self.found;
        self.found = FinishRecord {
            vertices: found.vertices,
            diameter: found.diameter,
            edge: found.edge,
            energy_before: found.energy_before,
            energy_after: found.energy_before,
            folds_before: found.folds_before,
            folds_after: found.folds_before,
            willmore_refused: Some(Refusal::Stopped),
            ..FinishRecord::default()
        };
    }
}

/// Report of a finish.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub struct FinishRecord {
    /// Number of moving vertices.
    pub vertices: usize,
    /// The largest distance between two vertices of the rim, in units of the mesh.
    pub diameter: f64,
    /// Mean length of the edges around the patch, in units of the mesh.
    pub edge: f64,
    /// Which surface the positions are.
    pub result: FinishResult,
    /// Gauss-Newton steps, over all initial shapes.
    pub steps: usize,
    /// Whether the steps converged: the last was shorter than the tolerance.
    pub converged: bool,
    /// Whether a second initial shape was used.
    #[serde(alias = "restart")]
    pub second_initialisation: SecondInitialisation,
    /// `½ ∫ h²` of the initial patch, where `h` is the sum of the principal curvatures.
    pub energy_before: f64,
    /// `½ ∫ h²` at the minimum of the energy.
    pub energy_after: f64,
    /// Folded faces of the initial patch.
    pub folds_before: usize,
    /// Folded faces of the finished patch.
    pub folds_after: usize,
    /// The candidate surfaces of the blend.
    pub candidates: Vec<CandidateRecord>,
    /// Why the minimum of the energy was refused, if it was.
    pub willmore_refused: Option<Refusal>,
    /// Why there is no blend, or why it was refused.
    pub blend_refused: Option<Refusal>,
    /// The largest displacement of a vertex, in units of the mesh.
    pub largest_move: f64,
    /// Mean of the expected errors of the vertices, in units of the mesh; `None` if unknown.
    #[serde(alias = "mean_sigma")]
    pub mean_expected_error: Option<f64>,
    /// The largest of the expected errors.
    #[serde(alias = "largest_sigma")]
    pub largest_expected_error: Option<f64>,
}

impl FinishRecord {
    /// Sets the mean and the largest of the expected errors of the vertices.
    pub(crate) fn set_expected_errors(&mut self, errors: &[f64]) {
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        let largest = errors.iter().copied().fold(0.0, f64::max);
        self.mean_expected_error = mean.is_finite().then_some(mean);
        self.largest_expected_error = self.mean_expected_error.map(|_| largest);
    }

    /// Records that the blend would intersect other faces, so the minimum is used instead.
    pub(crate) fn refuse_blend(&mut self) {
        if self.result == FinishResult::Blend {
            self.blend_refused = Some(Refusal::Intersects);
            self.result = match self.willmore_refused {
                None => FinishResult::Willmore,
                Some(_) => FinishResult::Unchanged,
            };
        }
    }

    /// Records that the minimum would intersect other faces too, so the patch stays unchanged.
    pub(crate) fn refuse_all(&mut self) {
        self.refuse_blend();
        self.willmore_refused.get_or_insert(Refusal::Intersects);
        self.result = FinishResult::Unchanged;
        self.energy_after = self.energy_before;
        self.folds_after = self.folds_before;
        self.largest_move = 0.0;
        (self.mean_expected_error, self.largest_expected_error) = (None, None);
    }
}

/// Which surface the positions of a finished patch are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum FinishResult {
    /// The initial patch.
    #[default]
    Unchanged,
    /// A minimum of the Willmore energy.
    Willmore,
    /// A blend of the minimum with continuations of the surroundings.
    Blend,
}

/// Whether Gauss-Newton used a second initial shape, the biharmonic fill of the same triangles. For a large patch: whether its
/// only initial shape has a strip along the rim filled biharmonically.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum SecondInitialisation {
    /// The first initial shape converged quickly and without folds.
    #[default]
    NotNeeded,
    /// The second initial shape was used, without a better result.
    #[serde(alias = "tried")]
    Worse,
    /// The second initial shape gave fewer folds or a lower energy.
    #[serde(alias = "taken")]
    Better,
}

/// A candidate surface of the blend.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize,
)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Candidate {
    /// The minimum of the energy.
    Willmore,
    /// Kriging over a sphere, from a collar of 0.45 diameters.
    Sphere,
    /// Kriging over a plane, from a collar of 0.45 diameters.
    Plane,
    /// The biharmonic fill, only if the patch bends little.
    Biharmonic,
    /// The triharmonic fill.
    Triharmonic,
}

/// The surface over which heights are kriged.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum ChartKind {
    /// A plane.
    Plane,
    /// A sphere with this radius in diameters of the hole; negative where the surface is hollow.
    Sphere(f64),
}

/// Report of a candidate surface.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub struct CandidateRecord {
    /// Which candidate.
    pub candidate: Candidate,
    /// The chart over which it was kriged, if it was.
    pub chart: Option<ChartKind>,
    /// The order of the kernel, 2 to 5; 0 if it is not kriged.
    pub order: u8,
    /// The noise of the data as a length in mean edges: there the kernel equals the noise's variance. 0 for exact data.
    pub nugget: f64,
    /// Root mean square error along the normals on rings of known vertices that were left out (geometric mean of two rings), in
    /// units of the mesh.
    pub ring_error: Option<f64>,
    /// Its weight in the blend.
    pub weight: f64,
}

/// Why a patch, or one way of finishing it, was refused.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, thiserror::Error, serde::Serialize, serde::Deserialize,
)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Refusal {
    /// No face uses a vertex of the patch.
    #[error("no face uses a vertex of the patch")]
    NoVertices,
    /// The patch has too many vertices.
    #[error("the patch has too many vertices for this step")]
    TooLarge,
    /// There are no known vertices around the patch.
    #[error("there are no known vertices around the patch")]
    NothingKnown,
    /// Coordinates or results are not finite.
    #[error("its coordinates, or results computed from them, are not finite")]
    NotFinite,
    /// A linear system could not be solved.
    #[error("the linear system of its triangles could not be solved")]
    Singular,
    /// A vertex would move too far.
    #[error("a vertex would move too far")]
    MovedTooFar,
    /// More faces would be folded.
    #[error("more faces would be folded over")]
    Folded,
    /// Faces would intersect other faces.
    #[error("faces would intersect other faces")]
    #[serde(alias = "crossing")]
    Intersects,
    /// The energy would be higher.
    #[error("the energy would be higher")]
    EnergyRose,
    /// There is no candidate besides the minimum of the energy.
    #[error("no surface could be fitted to the surroundings")]
    NoChart,
    /// There is no ring of known vertices on which to test candidates.
    #[error("there is no ring of vertices around the hole on which to test a blend")]
    NoRing,
    /// Not requested by the parameters.
    #[error("it was not requested")]
    #[serde(alias = "not-asked")]
    NotRequested,
    /// Cancelled by the caller.
    #[error("it was cancelled")]
    Stopped,
}
