//! The fill problem of one region: its rims, the mesh around them, the parameters, and the grid of each attempt.

use glam::DVec3;

use super::FEW_EDGES;
use super::base_plane::BasePlane;
use super::closure::Closure;
use super::counterpart::placed::PlacedPart;
use super::grids::Attempt;
use super::params::FillParams;
use super::reasons::NotSmooth;
use super::reference::ReferenceSurface;
use crate::cancel::Cancel;
use crate::flow::BendingEnergy;
use crate::mesh::{Hole, Mesh, bounds, face_normal};
use crate::region::{BoxSize, Region, Sphere, Start, VoxelSize};
use crate::sdf::Sampler;
use crate::spatial::{Bounds, BoxTree};
use crate::stitch::close_seam;
use crate::tuning::{Tunable, tunable};

/// Edges. A single rim of at most this many edges is closed by its faired triangulation alone, if that converges and does
/// not intersect anything: with so few edges there is only one minimum.
const FEW_FOR_LEVEL_SET: Tunable<usize> = tunable("fill.few_for_level_set", 12);

/// Voxels. A wall is thin if its two sides are closer than this: the level set of one side then has too few nodes before the other.
const THIN: Tunable<f64> = tunable("fill.thin", 5.0);
/// Cosine between the normals of a rim and of faces on the other side of its wall, at most.
const OTHER_SIDE: Tunable<f64> = tunable("fill.other_side", -0.7);
/// Upper bound of the rim vertices at which the thickness of a wall is looked at.
const THIN_SAMPLES: usize = 64;

/// One region to fill, with everything that the candidates read.
#[derive(Clone, Copy)]
pub(crate) struct RegionProblem<'a> {
    /// The region's number, from 1.
    pub(crate) id: usize,
    /// The mesh.
    pub(crate) mesh: &'a Mesh,
    /// Its holes.
    pub(crate) holes: &'a [&'a Hole],
    /// The closure that was decided before anything is computed; none where the search finds a continued surface.
    pub(crate) decided: Option<&'a Closure>,
    /// Distances to the components of the mesh on which the rims are.
    pub(crate) known: &'a Sampler<'a>,
    /// The caller's energy, if the parameters select [`Energy::Own`](crate::flow::Energy::Own).
    pub(crate) own: Option<&'a dyn BendingEnergy>,
    /// All of the mesh: patches must not intersect it.
    pub(crate) all: &'a Sampler<'a>,
    /// The parameters.
    pub(crate) params: &'a FillParams,
    /// Pairs of vertices of its rim between which the caller wants a sharp edge.
    pub(crate) joined: &'a [[u32; 2]],
    /// The plane of its flat base, if it gets one.
    pub(crate) base: Option<BasePlane>,
    /// The parts of the counterpart at the region, the best first; none without a counterpart.
    pub(crate) counterparts: Option<&'a [PlacedPart]>,
    /// Upper bound of the factor of its box's margin: beyond it the mesh at hand ends.
    pub(crate) most_growth: f64,
    /// Upper bound of the cost of its level-set retries, in unknowns times steps.
    pub(crate) budget: u64,
    /// The surface before a cut whose shape is partly kept, if any.
    pub(crate) reference: Option<&'a ReferenceSurface<'a>>,
    /// The bounding box of the faces that were cut out there.
    pub(crate) extent: Option<(DVec3, DVec3)>,
    /// Whether the run continues.
    pub(crate) keep_going: &'a (dyn Fn() -> bool + Sync),
    /// The token that stops the run; inner loops read it.
    pub(crate) cancel: &'a Cancel,
}

impl Closure {
    /// The closure of these holes of a mesh that is decided before anything is computed; none where they get a continued surface.
    pub(crate) fn decided(mesh: &Mesh, holes: &[&Hole], params: &FillParams) -> Option<Self> {
        match holes {
            [hole] if params.is_on_base(hole) => Some(Self::Base),
            [hole] if hole.edges <= FEW_EDGES.get() => {
                Some(Self::RimTriangles(NotSmooth::FewEdges))
            }
            _ if holes.iter().all(|h| params.is_flat(h.id)) => Some(Self::Flat),
            [a, b] if close_seam(mesh, &a.rim, &b.rim).is_some() => Some(Self::Seam),
            _ => None,
        }
    }
}

impl RegionProblem<'_> {
    /// The largest diameter of its holes, in the mesh's units.
    pub(super) fn diameter(&self) -> f64 {
        self.holes.iter().map(|h| h.diameter).fold(0.0, f64::max)
    }

    /// The lattice of an attempt.
    pub(super) fn region(&self, next: &Attempt) -> Region {
        let (holes, extent) = (self.holes, self.extent);
        let coarse = self.is_finished();
        region(self.mesh, holes, self.params, next, extent, coarse)
    }

    /// Whether the mesh has another side along most of the only rim, too close for a level set to tell the two sides apart. Then a rim of
    /// many edges is triangulated first: on walls of a skull, of which each side was closed by itself, no level set had a patch.
    pub(super) fn is_on_thin_wall(&self) -> bool {
        let [hole] = self.holes else {
            return false;
        };
        let reach = THIN.get() * self.region(&Attempt::first(self.params.energy)).voxel;
        let at = |v: u32| self.mesh.positions[v as usize];
        let samples: Vec<u32> = {
            let step = hole.rim.len().div_ceil(THIN_SAMPLES);
            hole.rim.iter().step_by(step).copied().collect()
        };
        let normals: Vec<DVec3> = samples.iter().map(|&v| self.known.normal(v)).collect();
        let is_other_side = |f: u32, sample: usize| {
            let mut corners = self.mesh.corners(f).into_iter();
            corners.any(|c| c.distance(at(samples[sample])) < reach)
                && face_normal(self.mesh, f).dot(normals[sample]) < OTHER_SIDE.get()
        };
        let around: Vec<Bounds> = samples
            .iter()
            .map(|&v| Bounds::of_ball(at(v), reach))
            .collect();
        let tree = BoxTree::new(&around);
        let (low, high) = bounds(samples.iter().map(|&v| at(v)));
        let all = Bounds { low, high }.widened(reach);
        let mut found = vec![false; samples.len()];
        self.known.for_each_in_box(&all, |f| {
            tree.for_each(&Bounds::of(self.mesh.corners(f)), |sample| {
                let sample = sample as usize;
                found[sample] = found[sample] || is_other_side(f, sample);
            });
        });
        2 * found.iter().filter(|found| **found).count() > samples.len()
    }
}

/// The lattice of the first attempt.
pub(crate) fn first_region(mesh: &Mesh, holes: &[&Hole], params: &FillParams) -> Region {
    let coarse = params.finishes();
    region(
        mesh,
        holes,
        params,
        &Attempt::first(params.energy),
        None,
        coarse,
    )
}

/// The lattice of an attempt. `extent` bounds the surface that initialises it, if any. It may be `coarse` where patches are
/// finished on their own triangles.
fn region(
    mesh: &Mesh,
    holes: &[&Hole],
    params: &FillParams,
    next: &Attempt,
    extent: Option<(DVec3, DVec3)>,
    coarse: bool,
) -> Region {
    let sphere = || Some(Sphere::new(mesh, holes)?.bounds());
    let part = extent.or_else(|| (next.start == Start::Sphere).then(sphere).flatten());
    let size = |voxel| BoxSize {
        voxel,
        coarse,
        growth: next.growth,
        refine: next.refine,
    };
    let of = |voxel| Region::new(mesh, holes, &size(voxel), part);
    let region = of(params.voxel);
    let (part, most_across) = next.energy.needs().voxel;
    if part == 1.0 || params.voxel != VoxelSize::Auto {
        return region;
    }
    let finer = (part * region.voxel).max(region.diameter / most_across);
    of(VoxelSize::Length(finer.min(region.voxel)))
}

/// Whether a region is a single rim of few edges for which a faired triangulation is made before any level set; only with an
/// automatic voxel.
pub(crate) fn has_few_edges(holes: &[&Hole], params: &FillParams) -> bool {
    matches!(holes, [hole] if hole.edges <= FEW_FOR_LEVEL_SET.get())
        && params.finishes()
        && params.voxel == VoxelSize::Auto
}

/// Whether a finer attempt is worthwhile. The first grid of a region with a small loop is already the finest; another
/// initialisation on it is worthwhile only where no triangulation of the rims is finished instead.
pub(super) fn refines(mesh: &Mesh, holes: &[&Hole], params: &FillParams) -> bool {
    let first = Attempt::first(params.energy);
    let voxel = |t: &Attempt| region(mesh, holes, params, t, None, true).voxel;
    let is_finer = |finer: &Attempt| voxel(finer) < voxel(&first);
    let has_finer = || first.finer().as_ref().is_some_and(is_finer);
    params.voxel == VoxelSize::Auto && (!params.finishes() || has_finer())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fill::Finish;
    use crate::mesh::shapes::{grid, punch};
    use crate::mesh::{Topology, find_holes};

    #[test]
    fn a_region_with_a_small_loop_has_no_finer_grid() {
        let sheet = grid(80, 80, [false, false], |u, v| DVec3::new(u, v, 0.0));
        let square = |c: DVec3, x: f64, half: f64| (c.x - x).abs().max((c.y - 0.5).abs()) < half;
        let mut mesh = punch(&sheet, |c| square(c, 0.3, 0.2) || square(c, 0.6, 0.026));
        let mut topology = Topology::new(&mut mesh);
        let (holes, _) = find_holes(&mesh, &mut topology);
        let inner: Vec<&Hole> = holes.iter().filter(|h| !h.outer_boundary).collect();
        let params = FillParams::default();
        assert_eq!(inner.len(), 2);
        assert!(refines(&mesh, &inner[..1], &params));
        assert!(!refines(&mesh, &inner, &params));
        let unfinished = FillParams {
            finish: Finish::None,
            ..params
        };
        assert!(refines(&mesh, &inner, &unfinished));
    }
}
