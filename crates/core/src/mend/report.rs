//! Reports of fills, restorations and fairings. Plans are in `plan.rs`.

use std::collections::HashMap;

use serde::{Deserialize, Serialize};

use super::inspection::Inspection;
use crate::fill::{Closure, FEW_EDGES, HoleOutcome, LeftReason, NotSmooth, RegionReport, Tally};
use crate::mesh::{Defects, Hole, HoleId, Mesh, OpenChain};

/// A hole and its outcome.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[non_exhaustive]
pub struct HoleReport {
    /// The hole.
    pub hole: Hole,
    /// The outcome.
    pub outcome: HoleOutcome,
    /// Number of its region, from 1; 0 where there is none.
    pub region: usize,
}

impl HoleReport {
    /// A hole that is only listed.
    pub fn listed(hole: &Hole) -> Self {
        Self {
            hole: hole.clone(),
            outcome: HoleOutcome::Left(LeftReason::NotChosen),
            region: 0,
        }
    }
}

/// Size and defects of the input.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct InputReport {
    /// Number of vertices of the input.
    pub vertices: usize,
    /// Number of faces of the input.
    pub faces: usize,
    /// Number of components of the input.
    pub components: usize,
    /// Numbers of defects of the input.
    pub defects: Defects,
    /// Boundary chains that do not close.
    pub open_chains: Vec<OpenChain>,
}

impl InputReport {
    /// The report on an inspected mesh.
    pub(crate) fn of(found: &Inspection) -> Self {
        Self {
            vertices: found.input.positions.len(),
            faces: found.input.faces.len(),
            components: found.topology.component_faces.len(),
            defects: found.topology.defects,
            open_chains: found.open_chains.clone(),
        }
    }

    /// Describes the mesh before a cut, but for the boundary chains, which are found after it.
    pub(super) fn describe(&mut self, before: &Inspection) {
        let open_chains = std::mem::take(&mut self.open_chains);
        *self = Self {
            open_chains,
            ..Self::of(before)
        };
    }
}

/// Report of a fill.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct FillReport {
    /// Size and defects of the input.
    pub input: InputReport,
    /// Whether all holes were to be filled; then a boundary chain that does not close counts as still open.
    pub all_holes: bool,
    /// The holes.
    pub holes: Vec<HoleReport>,
    /// The regions.
    pub regions: Vec<RegionReport>,
    /// Computing time in seconds.
    pub seconds: f64,
}

impl FillReport {
    /// The report of a run that changes nothing.
    pub fn unchanged(mesh: &Mesh) -> Self {
        Self {
            input: InputReport {
                vertices: mesh.positions.len(),
                faces: mesh.faces.len(),
                ..InputReport::default()
            },
            ..Self::default()
        }
    }

    /// The report of a mesh before anything is done.
    pub fn of(found: &Inspection) -> Self {
        Self {
            input: InputReport::of(found),
            ..Self::default()
        }
    }

    /// Pairs of holes that are the two sides of a wall and were joined by the edge of an opening, although the caller did not ask for it.
    pub fn joined_walls(&self) -> Vec<[HoleId; 2]> {
        let mut pairs = Vec::new();
        let is_joined = |r: &&RegionReport| r.closure.is_some() && !r.bridge && r.holes.len() > 1;
        for region in self.regions.iter().filter(is_joined) {
            let own = |h: &&HoleReport| h.region == region.id;
            let holes: Vec<&Hole> = self.holes.iter().filter(own).map(|h| &h.hole).collect();
            for (i, a) in holes.iter().enumerate() {
                let across = holes[i + 1..].iter().filter(|b| a.is_across_wall(b));
                pairs.extend(across.map(|b| [a.id, b.id]));
            }
        }
        pairs
    }

    /// Whether a patch joins several rims, although the caller did not ask for it; flat caps with holes do not count.
    pub(crate) fn joins_rims(&self) -> bool {
        let joins = |r: &RegionReport| r.holes.len() > 1 && !r.bridge;
        let is_flat = |r: &RegionReport| r.closure == Some(Closure::Flat);
        self.regions.iter().any(|r| joins(r) && !is_flat(r))
    }

    /// Whether something that was to be filled is still open: a hole, or a boundary chain that does not close.
    pub fn incomplete(&self) -> bool {
        self.tally().open > 0 || (self.all_holes && !self.input.open_chains.is_empty())
    }

    /// Whether everything that was to be filled is closed well; see [`Self::flawed`].
    pub fn flawless(&self) -> bool {
        !self.incomplete() && self.flawed().is_empty()
    }

    /// The holes of more than four edges that were to be filled and are not closed well: they are open, or closed by a level set that did
    /// not converge, by a triangulation because the level set found no surface, by triangles between the vertices of the rim or by an
    /// offset shell; or the patch intersects other faces, or sharp edges that end at the rim were not continued.
    pub fn flawed(&self) -> Vec<HoleId> {
        let regions: HashMap<usize, &RegionReport> =
            self.regions.iter().map(|r| (r.id, r)).collect();
        let is_well = |hole: &&HoleReport| {
            let region = regions.get(&hole.region);
            let is_clean =
                region.is_some_and(|r| r.intersecting_faces == 0 && r.not_continued.is_none());
            match &hole.outcome {
                HoleOutcome::Left(_) => true,
                _ if hole.hole.edges <= FEW_EDGES.get() => true,
                HoleOutcome::Closed(Closure::RimTriangles(NotSmooth::StraightEdge)) => is_clean,
                HoleOutcome::Open(_)
                | HoleOutcome::Closed(
                    Closure::RimTriangles(_) | Closure::OffsetShell(_) | Closure::Faired(Some(_)),
                ) => false,
                HoleOutcome::Closed(Closure::LevelSet) => {
                    is_clean && region.is_some_and(|r| r.converged)
                }
                HoleOutcome::Closed(_) => is_clean,
            }
        };
        let flawed = self.holes.iter().filter(|hole| !is_well(hole));
        flawed.map(|hole| hole.hole.id).collect()
    }

    /// Number of holes with each outcome.
    pub fn tally(&self) -> Tally {
        let mut tally = Tally {
            open_chains: self.input.open_chains.len(),
            ..Tally::default()
        };
        for hole in &self.holes {
            tally.count(&hole.outcome);
        }
        for region in self.regions.iter().filter(|r| r.intersecting_faces > 0) {
            tally.intersecting_patches += 1;
            tally.intersecting_faces += region.intersecting_faces;
        }
        tally
    }
}

/// Report of a restoration: the faces and vertices that were cut out, in a plan those that would be.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct RestoreReport {
    /// Number of marked faces.
    pub marked_faces: usize,
    /// Number of removed faces.
    ///
    /// These are the marked faces, and those without which there would be no clean rim.
    pub removed_faces: usize,
    /// Number of vertices removed with them.
    pub removed_vertices: usize,
    /// Holes that the removed faces touch.
    ///
    /// Numbered as in the input; the patch closes them with the region.
    #[serde(default)]
    pub joined_holes: Vec<HoleId>,
    /// Fraction of the shape kept.
    pub keep_shape: f64,
}

/// Report of a fairing. Of several objects in a 3MF file, strength, time and voxel are the largest of an object.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct FairReport {
    /// Width below which features are removed.
    ///
    /// In the mesh's units.
    pub strength: f64,
    /// Time of the flow, in length⁴.
    pub time: f64,
    /// Voxel size.
    ///
    /// In the mesh's units.
    pub voxel: f64,
    /// Whether the whole surface was replaced.
    ///
    /// Nothing of the input is in the output then.
    pub whole: bool,
    /// Number of faces that were to be faired.
    pub marked_faces: usize,
    /// Number of removed faces.
    pub removed_faces: usize,
    /// Closed components that stayed unchanged. Of an open mesh only the open components are faired.
    pub components_left: usize,
    /// Number of vertices removed with them.
    pub removed_vertices: usize,
    /// Volume of the input. None if it is open.
    pub volume_before: Option<f64>,
    /// Volume of the result. None if it is open.
    pub volume_after: Option<f64>,
    /// Largest distance between the surfaces before and after.
    ///
    /// Of a new vertex from the input surface, or of a removed vertex from the result.
    pub moved_max: f64,
    /// Root mean square of these distances.
    pub moved_rms: f64,
    /// Number of these distances.
    #[serde(skip)]
    pub(crate) moved_points: usize,
    /// The same for each of several objects of a 3MF file.
    ///
    /// Each is faired by itself.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub objects: Vec<FairObject>,
    /// Objects of a 3MF file that could not be faired and stayed unchanged.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub kept_objects: Vec<KeptObject>,
}

/// An object of a 3MF file that could not be faired.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct KeptObject {
    /// Name of the object.
    pub name: String,
    /// Why it could not be faired.
    pub reason: String,
}

/// An object of a 3MF file that was faired by itself.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[non_exhaustive]
pub struct FairObject {
    /// Name of the object.
    pub name: String,
    /// Report on the object.
    #[serde(flatten)]
    pub report: FairReport,
}

impl FairReport {
    /// Relative change of the volume.
    pub fn volume_drift(&self) -> Option<f64> {
        Some(self.volume_after? / self.volume_before? - 1.0)
    }
}
