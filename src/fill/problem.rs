//! What a region is: its rims, the mesh round them, and what is asked.

use glam::DVec3;

use super::base_plane::BasePlane;
use super::counterpart::PlacedPart;
use super::grids::Try;
use super::params::{FillParams, SurfaceKind};
use super::reference::ReferenceSurface;
use crate::cancel::Cancel;
use crate::flow::BendingEnergy;
use crate::mesh::{Hole, Mesh};
use crate::region::{BoxSize, Region, Sphere, Start, VoxelSize};
use crate::sdf::Sampler;
use crate::stitch::close_seam;
use crate::tuning::tuning;

/// What a region calls for, before anything is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RegionPlan {
    /// One rim of so few edges that its triangulation needs no new vertices.
    Trivial,
    /// A nearly flat cap, because the caller asked for it.
    Planar,
    /// A flat base with walls under the outer border of a sheet, because the caller asked for it.
    Base,
    /// Two rims that lie on each other.
    Seam,
    /// A surface.
    Solve,
}

/// The work on one region.
#[derive(Clone, Copy)]
pub(crate) struct RegionProblem<'a> {
    /// Its number, from 1.
    pub(crate) id: usize,
    /// The mesh.
    pub(crate) mesh: &'a Mesh,
    /// Its holes.
    pub(crate) holes: &'a [&'a Hole],
    /// What they call for.
    pub(crate) plan: RegionPlan,
    /// What of the mesh it knows: the pieces that its rims lie on.
    pub(crate) known: &'a Sampler<'a>,
    /// The caller's energy, where the parameters' is [`Energy::Own`](crate::flow::Energy::Own).
    pub(crate) own: Option<&'a dyn BendingEnergy>,
    /// All of the mesh, which patches must not cross.
    pub(crate) all: &'a Sampler<'a>,
    /// The parameters.
    pub(crate) params: &'a FillParams,
    /// Pairs of vertices of its rim between which a sharp edge is to be continued.
    pub(crate) joined: &'a [[u32; 2]],
    /// The plane of its base, if it gets one.
    pub(crate) base: Option<BasePlane>,
    /// The parts of a counterpart that lie at the region, the best first; none where it is filled after none.
    pub(crate) counterparts: Option<&'a [PlacedPart]>,
    /// What its box may grow by: as far as its part of the mesh reaches.
    pub(crate) most_growth: f64,
    /// The surface whose shape is kept, if any.
    pub(crate) reference: Option<&'a ReferenceSurface<'a>>,
    /// The bounding box of what was cut out there.
    pub(crate) extent: Option<(DVec3, DVec3)>,
    /// Whether the run is to go on.
    pub(crate) keep_going: &'a (dyn Fn() -> bool + Sync),
    /// The token that stops it, which inner loops read.
    pub(crate) cancel: &'a Cancel,
}

impl RegionPlan {
    /// What some holes of a mesh call for.
    pub(crate) fn new(mesh: &Mesh, holes: &[&Hole], params: &FillParams) -> Self {
        let is_stitched = params.surface == SurfaceKind::Stitched;
        match holes {
            [hole] if params.is_on_base(hole) => Self::Base,
            [hole] if is_stitched && hole.edges <= tuning().fill.few_edges => Self::Trivial,
            _ if holes.iter().all(|h| params.is_flat(h.id)) => Self::Planar,
            [a, b] if is_stitched && close_seam(mesh, &a.rim, &b.rim).is_some() => Self::Seam,
            _ => Self::Solve,
        }
    }
}

impl RegionProblem<'_> {
    /// The largest diameter of its holes, in the mesh's units.
    pub(super) fn diameter(&self) -> f64 {
        self.holes.iter().map(|h| h.diameter).fold(0.0, f64::max)
    }

    /// The lattice of a level set.
    pub(super) fn region(&self, next: &Try) -> Region {
        let (holes, extent) = (self.holes, self.extent);
        let coarse = self.is_finished();
        region(self.mesh, holes, self.params, next, extent, coarse)
    }
}

/// The region of the first try.
pub(crate) fn first_region(mesh: &Mesh, holes: &[&Hole], params: &FillParams) -> Region {
    let coarse = params.finishes();
    region(
        mesh,
        holes,
        params,
        &Try::first(params.energy),
        None,
        coarse,
    )
}

/// The lattice of a try; `extent` bounds the surface that it starts from, if any. It may be `coarse` where patches are finished
/// on their own triangles.
fn region(
    mesh: &Mesh,
    holes: &[&Hole],
    params: &FillParams,
    next: &Try,
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

/// Whether a region is a single rim of so few edges that a faired triangulation is made of it before any level set, on a grid of isomend's
/// choice.
pub(crate) fn has_few_edges(holes: &[&Hole], params: &FillParams) -> bool {
    matches!(holes, [hole] if hole.edges <= tuning().fill.few_for_level_set)
        && params.finishes()
        && params.voxel == VoxelSize::Auto
}

/// Whether a finer try is worth its time. The grid of a region with a small loop is as fine as it gets from the first; then another
/// start on it is only worth it where no triangulation of the rims is finished instead.
pub(super) fn refines(mesh: &Mesh, holes: &[&Hole], params: &FillParams) -> bool {
    let first = Try::first(params.energy);
    let voxel = |t: &Try| region(mesh, holes, params, t, None, true).voxel;
    let is_finer = |finer: &Try| voxel(finer) < voxel(&first);
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
        let inner: Vec<&Hole> = holes.iter().filter(|h| !h.outer_border).collect();
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
