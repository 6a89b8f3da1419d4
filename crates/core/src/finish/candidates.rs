//! Candidate surfaces for a patch: the minimum of the energy, kriged surfaces, polyharmonic fills.

use glam::{DVec2, DVec3};

use super::COLLAR;
use super::biharmonic::{System, polyharmonic};
use super::chart::Chart;
use super::collar::Collar;
use super::geometry::{Stiffness, barycentric, clamped_cotangents, quantile, vertex_normals};
use super::kriging::{Kriging, Model, ORDERS};
use super::params::FinishParams;
use super::patch::Patch;
use super::report::{Candidate, CandidateRecord, ChartKind};
use crate::tuning::{Tunable, tunable};

/// Points. With fewer data nothing is kriged.
pub(super) const FEWEST_DATA: Tunable<usize> = tunable("finish.fewest_data", 15);

/// Mean edges. The mismatch of a kriged surface at the rim decays over this distance.
const RIM_DECAY: Tunable<f64> = tunable("finish.rim_decay", 1.5);

/// Cosine (37°). The biharmonic fill is a candidate where nearly all normals are within this angle of their mean: it is
/// the linear plate theory and too flat beyond. On 143 holes of scans it made more strongly bent patches worse by 2 %.
const SLIGHT_COSINE: Tunable<f64> = tunable("finish.slight_cosine", 0.8);

/// Fraction of the normals that may be steeper than `SLIGHT_COSINE`.
const STEEPER_PART: Tunable<f64> = tunable("finish.steeper_part", 0.02);

/// Diameters. Largest radius of a sphere as the chart of a kriged surface. A second sphere, fitted to a collar of 0.6
/// diameters, made 143 holes of scans worse by 0.5 %, nearly flat ones by 3 %, and took a third of the time.
pub(super) const LARGEST_SPHERE: Tunable<f64> = tunable("finish.largest_sphere", 4.0);

/// The kriged candidates: width of the collar, and the largest radius of a sphere as the chart, in diameters.
fn kriged_candidates() -> [(Candidate, f64, f64); 2] {
    [
        (Candidate::Sphere, COLLAR.get(), LARGEST_SPHERE.get()),
        (Candidate::Plane, COLLAR.get(), 0.0),
    ]
}

/// A candidate surface of the blend.
pub(super) struct Continuation {
    /// Positions of the moving vertices.
    pub(super) shape: Vec<DVec3>,
    /// Its part of the report.
    pub(super) found: CandidateRecord,
    /// The kriging that it comes from, if any.
    pub(super) kriged: Option<Kriged>,
}

/// A kriging and the chart it is a graph over.
pub(super) struct Kriged {
    pub(super) chart: Chart,
    pub(super) kriging: Kriging,
    pub(super) model: Model,
}

/// The models estimated for a hole; the ring test reuses them for the wider hole.
pub(super) type Models = Vec<(Candidate, Model)>;

/// The models of the kriged surfaces among the candidates.
pub(super) fn models(surfaces: &[Continuation]) -> Models {
    let model = |s: &Continuation| Some((s.found.candidate, s.kriged.as_ref()?.model));
    surfaces.iter().filter_map(model).collect()
}

impl Continuation {
    /// A candidate that is not kriged.
    fn new(candidate: Candidate, shape: Vec<DVec3>) -> Self {
        Self {
            shape,
            found: CandidateRecord {
                candidate,
                chart: None,
                order: 0,
                nugget: 0.0,
                ring_error: None,
                weight: 0.0,
            },
            kriged: None,
        }
    }

    /// Whether it is the kriging from the narrow collar over a plane.
    fn is_over_plane(&self) -> bool {
        let narrow = self.found.candidate == Candidate::Sphere;
        narrow && self.found.chart == Some(ChartKind::Plane)
    }

    /// The same surface as another candidate. If no sphere fits, both kriged candidates are over the plane and the surface counts
    /// twice.
    fn repeated(&self, candidate: Candidate) -> Self {
        Self {
            shape: self.shape.clone(),
            found: CandidateRecord {
                candidate,
                ..self.found.clone()
            },
            kriged: None,
        }
    }

    fn kriged(candidate: Candidate, shape: Vec<DVec3>, kriged: Kriged) -> Self {
        Self {
            shape,
            found: CandidateRecord {
                candidate,
                chart: Some(kriged.chart.kind()),
                order: kriged.model.order,
                nugget: kriged.model.nugget,
                ring_error: None,
                weight: 0.0,
            },
            kriged: Some(kriged),
        }
    }
}

/// The energy's minimum and, if `others` is true, the other candidates; kriged with the `given` models where there are any.
pub(super) fn candidates(
    patch: &Patch,
    minimum: &[DVec3],
    others: bool,
    given: &Models,
    params: &FinishParams,
) -> Vec<Continuation> {
    // The minimum of the energy has all of the weight until the ring test compares it with others.
    let mut all = vec![Continuation::new(Candidate::Willmore, minimum.to_vec())];
    all[0].found.weight = 1.0;
    if !others || patch.cancel.is_cancelled() {
        return all;
    }
    // Biharmonic (only for small slopes) and triharmonic fill of the same triangles (Botsch and Kobbelt 2004).
    if is_slight(patch, minimum)
        && let Some(shape) = polyharmonic(patch, minimum, 2)
    {
        all.push(Continuation::new(Candidate::Biharmonic, shape));
    }
    if let Some(shape) = polyharmonic(patch, minimum, 3) {
        all.push(Continuation::new(Candidate::Triharmonic, shape));
    }
    // Kriging over a sphere and over a plane, with one collar of known vertices for both.
    all.extend(kriged_surfaces(patch, minimum, given, params));
    all
}

/// The kriged candidates, with the `given` models where there are any.
fn kriged_surfaces(
    patch: &Patch,
    minimum: &[DVec3],
    given: &Models,
    params: &FinishParams,
) -> Vec<Continuation> {
    let normals = patch.known_normals();
    let mut collars: Vec<Collar> = Vec::new();
    let mut lifted: Vec<(Candidate, Lifted)> = Vec::new();
    let mut repeated = None;
    for (candidate, width, largest) in kriged_candidates() {
        if patch.cancel.is_cancelled() {
            break;
        }
        // If no sphere fits, the first kriging is over the plane already, and counts twice.
        let is_plane = |(c, l): &(Candidate, Lifted)| {
            *c == Candidate::Sphere && l.kriged.chart.kind() == ChartKind::Plane
        };
        if candidate == Candidate::Plane && lifted.iter().any(is_plane) {
            repeated = Some(candidate);
            continue;
        }
        if !collars.iter().any(|c| c.width == width) {
            collars.push(Collar::new(patch, width, params.most_data));
        }
        let Some(collar) = collars.iter().find(|c| c.width == width) else {
            continue;
        };
        // With a model from the hole itself, the ring test needs no estimate.
        let model = given.iter().find(|m| m.0 == candidate).map(|m| m.1);
        let surface = kriged(patch, minimum, &normals, collar, largest, model, params);
        lifted.extend(surface.map(|surface| (candidate, surface)));
    }
    if lifted.is_empty() {
        return Vec::new();
    }
    let mut all = attached(patch, lifted);
    let first = all.iter().find(|s| s.is_over_plane());
    let second = first.zip(repeated).map(|(s, c)| s.repeated(c));
    all.extend(second);
    all
}

/// Kriged surfaces attached to the rim. With noise a kriged surface misses the rim: the difference is added to it and decays into
/// the patch.
pub(super) fn attached(patch: &Patch, lifted: Vec<(Candidate, Lifted)>) -> Vec<Continuation> {
    let mismatches: Vec<&[DVec3]> = lifted.iter().map(|(_, l)| &l.mismatch[..]).collect();
    let decayed = spread(patch, &mismatches).unwrap_or_default();
    let mut all: Vec<Continuation> = Vec::new();
    for ((candidate, surface), corrections) in lifted.into_iter().zip(decayed) {
        let Some(corrections) = corrections else {
            continue;
        };
        let mut shape = surface.shape;
        shape.iter_mut().zip(corrections).for_each(|(x, c)| *x += c);
        if shape.iter().all(|p| p.is_finite()) {
            all.push(Continuation::kriged(candidate, shape, surface.kriged));
        }
    }
    all
}

/// Whether a patch bends little: nearly all normals of the patch and its rim are close to their mean.
fn is_slight(patch: &Patch, shape: &[DVec3]) -> bool {
    let closure = &patch.closure;
    let all = vertex_normals(&patch.closure_points(shape), &closure.faces);
    let acting = || closure.acting.iter().map(|&v| all[v as usize]);
    let mean = acting().sum::<DVec3>().normalize_or_zero();
    quantile(acting().map(|n| n.dot(mean)), STEEPER_PART.get()) > SLIGHT_COSINE.get()
}

/// A kriged surface before it is attached to the rim.
pub(super) struct Lifted {
    /// Positions of the moving vertices.
    shape: Vec<DVec3>,
    /// For each vertex of the rim, the vector to it from the kriged surface.
    mismatch: Vec<DVec3>,
    kriged: Kriged,
}

/// The surface kriged from a collar: foot points from the energy's minimum, kriged heights.
fn kriged(
    patch: &Patch,
    minimum: &[DVec3],
    normals: &[DVec3],
    collar: &Collar,
    largest: f64,
    model: Option<Model>,
    params: &FinishParams,
) -> Option<Lifted> {
    if collar.vertices.len() < FEWEST_DATA.get() {
        return None;
    }
    let chart = Chart::new(patch, minimum, &collar.vertices, normals, largest)?;
    let model = model.map_or(ModelChoice::Orders(&ORDERS), ModelChoice::Given);
    kriged_over(chart, patch, minimum, collar, model, params)
}

/// The model of a kriging.
#[derive(Clone, Copy)]
pub(super) enum ModelChoice {
    /// This model.
    Given(Model),
    /// The most likely model of these orders.
    Orders(&'static [u8]),
}

/// The same over a given chart.
pub(super) fn kriged_over(
    chart: Chart,
    patch: &Patch,
    minimum: &[DVec3],
    collar: &Collar,
    model: ModelChoice,
    params: &FinishParams,
) -> Option<Lifted> {
    // Data: chart coordinates and heights, in diameters of the hole, of at most `most` known vertices.
    let coordinates = |most: usize| -> (Vec<DVec2>, Vec<f64>) {
        let data = collar.data(most);
        let at = data.iter().map(|&v| patch.points[v as usize]);
        at.map(|p| chart.coordinates(p)).unzip()
    };
    let edge = patch.edge / patch.diameter;
    // Order and noise by restricted likelihood, from fewer data than the kriging itself, unless given.
    let model = match model {
        ModelChoice::Given(model) => model,
        ModelChoice::Orders(orders) => {
            let (points, heights) = coordinates(params.most_estimated.min(params.most_data));
            Model::estimate(&points, &heights, edge, orders, &patch.cancel)?
        }
    };
    let (points, heights) = coordinates(params.most_data);
    let kriging = Kriging::new(points, &heights, edge, model)?;
    if patch.cancel.is_cancelled() {
        return None;
    }
    // Each vertex keeps its foot point on the chart and gets the kriged height.
    let lift = |p: &DVec3| chart.lifted(*p, kriging.at(chart.coordinates(*p).0));
    let shape = minimum.iter().map(lift).collect();
    let mismatch = patch.rim_points().iter().map(|p| *p - lift(p)).collect();
    Some(Lifted {
        shape,
        mismatch,
        kriged: Kriged {
            chart,
            kriging,
            model,
        },
    })
}

/// Extends mismatches from the rim into the patch: solves `(S + M / δ²) c = 0` with cotangent weights S, areas M and a decay
/// length δ. For each mismatch one correction of every moving vertex, in diameters.
fn spread(patch: &Patch, mismatches: &[&[DVec3]]) -> Option<Vec<Option<Vec<DVec3>>>> {
    let closure = &patch.closure;
    let points = patch.closure_points(&patch.shape());
    let (weights, twice) = clamped_cotangents(&points, &closure.patch_faces);
    let mut stiffness = Stiffness::new(points.len(), &closure.patch_faces);
    stiffness.set(&closure.patch_faces, &weights);
    let areas = barycentric(points.len(), &closure.patch_faces, &twice);
    let decay = (RIM_DECAY.get() * patch.edge).powi(-2);
    let mut matrix = stiffness.matrix;
    for &v in &closure.moving {
        let i = v as usize;
        if let Some(entry) = matrix.get_mut(i, i) {
            *entry += areas[i] * decay;
        }
    }
    let at_rim = |mismatch: &&[DVec3]| {
        let mut values = vec![DVec3::ZERO; points.len()];
        for (&v, m) in closure.rim.iter().zip(*mismatch) {
            values[v as usize] = *m;
        }
        values
    };
    let sets: Vec<Vec<DVec3>> = mismatches.iter().map(at_rim).collect();
    let sets: Vec<&[DVec3]> = sets.iter().map(|set| &set[..]).collect();
    let rows = closure.moving.iter().copied();
    System::new(patch, 1, &matrix, rows, &closure.moving)?.solve(&matrix, &sets)
}
