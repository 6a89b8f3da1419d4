//! The signed distance to the mesh as the data of a region, and the solved level set as the surface of its patch.

use glam::DVec3;

use super::cap::CappedRims;
use super::distance::{DistanceData, NodeData, Wanted};
use super::level::Level;
use super::sphere::Sphere;
use crate::cancel::Cancel;
use crate::mesh::{Hole, Mesh};
use crate::sdf::{DistanceSample, Sampler, Surface};
use crate::tuning::{Tunable, tunable};

/// Rim radii, and half widths of the hole. Deep nodes are free within this distance of the rim's centre and, in half
/// widths, of the rim.
const DEEP_REACH: Tunable<f64> = tunable("region.deep_reach", 1.3);

/// The signed distance to the mesh, unknown where a rim of the region is nearest.
pub struct MeshData<'a> {
    sampler: &'a Sampler<'a>,
    rims: CappedRims,
    neighbourhoods: Vec<Neighbourhood>,
    sphere: Option<Sphere>,
    kept: Option<KeptShape<'a>>,
    cancel: Option<&'a Cancel>,
}

/// A reference surface whose shape is kept, or which evolves.
#[derive(Clone, Copy)]
pub struct KeptShape<'a> {
    /// Its signed distances.
    pub sampler: &'a Sampler<'a>,
    /// All its holes; where their rims are nearest it has no shape.
    pub rims: &'a CappedRims,
    /// Weight of the pull towards it, in 1 / length⁴.
    pub weight: f64,
    /// The faces of it that evolve: nodes nearest to one of them are free. None where the new surface may be far from it; then
    /// nodes nearest to a rim are free.
    pub evolving: Option<&'a [bool]>,
}

/// Where deep nodes are free: near the rim's centre, and near the rim. The distances are the rim's radius and half the hole's
/// width, both times `DEEP_REACH.get()`.
struct Neighbourhood {
    centre: DVec3,
    radius: f64,
    rim: Vec<DVec3>,
    half_width: f64,
}

impl Neighbourhood {
    fn new(mesh: &Mesh, hole: &Hole) -> Self {
        let stride = hole.rim.len().div_ceil(256);
        let rim: Vec<DVec3> = hole
            .rim
            .iter()
            .step_by(stride)
            .map(|&v| mesh.positions[v as usize])
            .collect();
        let reach = |m: f64, p: &DVec3| m.max(p.distance(hole.centre));
        Self {
            centre: hole.centre,
            radius: DEEP_REACH.get() * rim.iter().fold(0.0, reach),
            rim,
            half_width: 0.5 * DEEP_REACH.get() * hole.width,
        }
    }

    fn holds(&self, x: DVec3) -> bool {
        let near = |p: &DVec3| p.distance_squared(x) < self.half_width.powi(2);
        x.distance_squared(self.centre) < self.radius.powi(2) && self.rim.iter().any(near)
    }
}

impl<'a> MeshData<'a> {
    /// The data of a region with these holes.
    pub fn new(sampler: &'a Sampler<'a>, mesh: &Mesh, holes: &[&Hole]) -> Self {
        let neighbourhoods = holes
            .iter()
            .map(|hole| Neighbourhood::new(mesh, hole))
            .collect();
        Self {
            sampler,
            rims: CappedRims::new(holes, |hole| !sampler.is_small(hole.component)),
            neighbourhoods,
            sphere: Sphere::new(mesh, holes),
            kept: None,
            cancel: None,
        }
    }

    /// Initialises the flow from a reference surface and pulls it towards that surface.
    pub fn keeping(self, kept: Option<KeptShape<'a>>) -> Self {
        Self { kept, ..self }
    }

    /// Stops the sampling once a token is set.
    pub fn stopped_by(self, cancel: &'a Cancel) -> Self {
        let cancel = Some(cancel);
        Self { cancel, ..self }
    }
}

impl MeshData<'_> {
    /// The sample at a point if a reference surface evolves; else none.
    fn evolving(&self, x: DVec3, limit: f64) -> Option<(NodeData, Option<DVec3>)> {
        let kept = self.kept.as_ref()?;
        let evolving = kept.evolving?;
        let sample = |limit| kept.sampler.sample(&kept.rims.rims, x, limit);
        let s = sample(limit).or_else(|| sample(f64::INFINITY))?;
        let data = NodeData {
            signed: s.signed,
            distance: s.distance,
            free: evolving[s.closest.face as usize],
        };
        Some((data, Some(s.closest.point)))
    }

    /// The signed distance at a point far from the known surface, and whether the point is free.
    fn deep(&self, x: DVec3, s: &DistanceSample) -> (f64, bool) {
        if self.kept.is_none()
            && let Some(to_cap) = self.rims.distance_to_cap(self.sampler, x, s.distance)
        {
            // The known surface is the back of far faces, seen through the hole: the cap is nearer and gives the sign.
            return (to_cap, true);
        }
        let free = self.neighbourhoods.iter().any(|n| n.holds(x))
            // Near another hole, which stays open, no surface is missing.
            && !self.sampler.on_other_border(&self.rims.rims, &s.closest);
        (s.signed, free)
    }

    /// Whether the nearest face of the reference surface evolves; none where no reference surface evolves.
    fn evolves(&self, x: DVec3) -> Option<bool> {
        let kept = self.kept.as_ref()?;
        let evolving = kept.evolving?;
        let closest = kept.sampler.bvh().closest(x, f64::INFINITY)?;
        Some(evolving[closest.face as usize])
    }
}

impl DistanceData for MeshData<'_> {
    fn sample(&self, x: DVec3, limit: f64) -> NodeData {
        self.sample_for(x, limit, &Wanted::exact()).0
    }

    fn sample_for(&self, x: DVec3, limit: f64, wanted: &Wanted) -> (NodeData, Option<DVec3>) {
        if let Some(known) = self.evolving(x, limit) {
            return known;
        }
        let sample = |limit| self.rims.sample(self.sampler, x, limit, wanted);
        let Some(s) = sample(limit).or_else(|| sample(f64::INFINITY)) else {
            let data = NodeData {
                signed: f64::MAX,
                distance: f64::MAX,
                free: false,
            };
            return (data, None);
        };
        let (signed, free) = if s.on_rim || s.distance <= wanted.deep {
            (s.signed, s.on_rim)
        } else {
            self.deep(x, &s)
        };
        let data = NodeData {
            signed,
            distance: s.distance,
            free,
        };
        (data, Some(s.closest.point))
    }

    fn sphere(&self) -> Option<Sphere> {
        self.sphere
    }

    fn cancel(&self) -> Option<&Cancel> {
        self.cancel
    }

    fn rims(&self) -> Vec<DVec3> {
        match self.kept {
            Some(_) => Vec::new(),
            None => self.rims.positions(self.sampler.mesh()).collect(),
        }
    }

    fn pull(&self) -> f64 {
        self.kept.map_or(0.0, |kept| kept.weight)
    }

    fn kept_shape(&self, x: DVec3) -> Option<f64> {
        let kept = self.kept.as_ref()?;
        let sample = kept.sampler.sample(&kept.rims.rims, x, f64::INFINITY)?;
        (!sample.on_rim).then_some(sample.signed)
    }

    fn guess(&self, x: DVec3) -> Option<f64> {
        if let Some(kept) = &self.kept {
            let limit = f64::INFINITY;
            let sample = kept.rims.sample(kept.sampler, x, limit, &Wanted::exact())?;
            return Some(sample.signed);
        }
        self.rims.signed_distance(self.sampler, x)
    }
}

/// The zero set of a solved level, and its relation to the region's holes.
pub struct LevelSurface<'a> {
    /// The solved level.
    pub level: &'a Level,
    /// The mesh and its rims.
    pub data: &'a MeshData<'a>,
}

impl Surface for LevelSurface<'_> {
    fn is_cancelled(&self) -> bool {
        self.level.grid.is_cancelled()
    }

    fn project(&self, p: DVec3) -> Option<(DVec3, DVec3)> {
        self.level.project(p)
    }

    fn depth(&self, p: DVec3) -> f64 {
        if self.is_cancelled() {
            return -f64::MAX;
        }
        let Some((closest, on_rim)) = self.data.sampler.closest_of_all(&self.data.rims.rims, p)
        else {
            return -f64::MAX;
        };
        // In thin parts evolving faces may be nearer to the opposite wall than to their rim.
        let inside = self.data.evolves(p).unwrap_or(on_rim);
        if inside {
            closest.distance
        } else {
            -closest.distance
        }
    }
}
