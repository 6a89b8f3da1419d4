//! Plans and runs a fairing: strength, time and voxel size from the parameters, and the flow of a whole mesh or of a part.

use std::f64::consts::TAU;
use std::time::Instant;

use glam::DVec3;

use super::super::Inspection;
use super::super::control::{Control, Watch};
use super::super::cut::{CutResult, count};
use super::super::params::{FairExtent, FairParams};
use super::super::report::{FairReport, FillReport};
use super::{FairError, Faired};
use crate::elementary::{log2, powf};
use crate::fill::{Closure, FillParams, HoleOutcome, OpenReason, RegionReport};
use crate::flow::{FlowSettings, Pace};
use crate::grid::Lattice;
use crate::mesh::mask::shrunk_from_borders;
use crate::mesh::topology::NONE;
use crate::mesh::{Mesh, bounds};
use crate::region::{
    CappedRims, KeptShape, Level, MeshData, NestedSettings, Solved, Start, TimeSpan, VoxelSize,
    solve_nested,
};
use crate::sdf::{Sampler, Surface};
use crate::stitch::{Patch, remesh_closed};
use crate::tuning::{Tunable, tunable};

/// Mean edges. The default strength.
const STRENGTH_EDGES: Tunable<f64> = tunable("mend.fair.strength_edges", 8.0);
/// Voxels across the width of the features that are removed.
const PER_FEATURE: Tunable<f64> = tunable("mend.fair.per_feature", 8.0);
/// Mean edges. Lower bound of the automatic voxel.
const LEAST_PER_EDGE: Tunable<f64> = tunable("mend.fair.least_per_edge", 1.0 / 3.0);
/// Upper bound of area / voxel² for the automatic voxel: 44,000 took 60 s of one core on a scan.
const USUAL_SQUARES: Tunable<f64> = tunable("mend.fair.usual_squares", 5e4);
/// Upper bound of area / voxel² for a given voxel: it needs about 2.5 GB.
const MOST_SQUARES: Tunable<f64> = tunable("mend.fair.most_squares", 1e6);
/// Voxels of the finest automatic grid. Lower bound of the strength: the grid does not resolve narrower features.
const LEAST_VOXELS: Tunable<f64> = tunable("mend.fair.least_voxels", 4.0);
/// Diagonals of the faired surface. Upper bound of the strength for a given voxel: by then the flow has reached its steady state.
const MOST_STRENGTH: Tunable<f64> = tunable("mend.fair.most_strength", 1e3);
/// Voxels along the longest side on the coarsest lattice, at most.
const COARSEST: Tunable<f64> = tunable("mend.fair.coarsest", 40.0);
/// Voxels of the coarsest lattice. Free space around the model.
const MARGIN: Tunable<f64> = tunable("mend.fair.margin", 6.0);
/// Voxels. Width of the strip along borders and open holes that stays unchanged.
const STRIP: Tunable<f64> = tunable("mend.fair.strip", 4.0);

/// The parameters of a fairing, resolved for a mesh.
pub(super) struct Plan {
    /// Width below which features are removed.
    pub(super) strength: f64,
    /// Time of the flow.
    pub(super) span: TimeSpan,
    /// Voxel size.
    pub(super) voxel: f64,
    /// Mean edge length.
    edge: f64,
}

impl Plan {
    pub(super) fn new(
        found: &Inspection,
        marked: Option<&[bool]>,
        params: &FairParams,
    ) -> Result<Self, FairError> {
        let sizes = Sizes::new(found, marked).ok_or(FairError::NoSurface)?;
        let Sizes { edge, area, .. } = sizes;
        let finest = (LEAST_PER_EDGE.get() * edge).max((area / USUAL_SQUARES.get()).sqrt());
        let fits = LEAST_VOXELS.get() * finest;
        let strength = match params.extent {
            FairExtent::Time(time) => TAU * powf(time, 0.25),
            FairExtent::Strength(strength) => strength,
            FairExtent::Auto => fits.max(STRENGTH_EDGES.get() * edge),
        };
        let span = match params.extent {
            FairExtent::Time(time) => TimeSpan {
                time,
                pace: Pace::Exact,
            },
            _ => TimeSpan {
                time: (strength / TAU).powi(4),
                pace: Pace::Coarse,
            },
        };
        let voxel = match params.voxel {
            VoxelSize::Auto => (strength / PER_FEATURE.get()).max(finest),
            VoxelSize::Length(voxel) => voxel,
        };
        sizes.check(strength, voxel, params.voxel)?;
        // The error message rounds the strength.
        if params.voxel == VoxelSize::Auto && strength < (1.0 - 1e-3) * fits {
            return Err(FairError::TooWeak { strength, fits });
        }
        Ok(Self {
            strength,
            span,
            voxel,
            edge,
        })
    }

    pub(super) fn fill_params(&self, params: &FairParams) -> FillParams {
        FillParams {
            voxel: VoxelSize::Length(self.voxel),
            edge_ratio: Some(params.edge_ratio),
            ..FillParams::default()
        }
    }

    /// Cuts the marked faces out and lets them evolve.
    pub(super) fn part(
        &self,
        found: &Inspection,
        marked: &[bool],
        params: &FairParams,
        control: &Control,
    ) -> Result<Faired, FairError> {
        let cut = CutResult::new(found, marked, params.keep_vertices, false)?;
        let closed = cut.closed();
        let reference = cut.evolving(&closed, self.span);
        let fill = self.fill_params(params);
        let filled = cut.fill(&fill, Some(&reference), control)?;
        for hole in &filled.report.holes {
            if let HoleOutcome::Open(OpenReason::NoTriangulation { after: why, .. })
            | HoleOutcome::Closed(Closure::RimTriangles(why)) = &hole.outcome
            {
                let [x, y, z] = hole.hole.centre.to_array();
                let why = Box::new(why.clone());
                return Err(FairError::NotJoined { x, y, z, why });
            }
        }
        drop(reference);
        let [removed_faces, removed_vertices] = cut.removed_counts();
        Ok(Faired {
            mesh: filled.mesh,
            report: FairReport {
                marked_faces: count(marked),
                removed_faces,
                removed_vertices,
                ..FairReport::default()
            },
            fill: filled.report,
            kept: Some(cut.into_kept()),
        })
    }

    /// Lets a whole closed surface evolve, and remeshes it.
    pub(super) fn whole(
        &self,
        found: &Inspection,
        params: &FairParams,
        control: &Control,
    ) -> Result<Faired, FairError> {
        let clock = Instant::now();
        let sampler = Sampler::new(&found.mesh, &found.topology);
        let kept = KeptShape {
            sampler: &sampler,
            rims: &CappedRims::none(),
            weight: 0.0,
            evolving: Some(&vec![true; found.mesh.faces.len()]),
        };
        let watch = Watch::new(*control, vec![1.0]);
        let data = MeshData::new(&sampler, &found.mesh, &[])
            .keeping(Some(kept))
            .stopped_by(watch.token());
        let settings = self.nested(found);
        watch.begin(&[]);
        let solved = solve_nested(&data, &settings, &|| watch.keep_going());
        watch.finish()?;
        if !solved.converged() {
            return Err(self.stuck(&solved));
        }
        let extracted = solved.level.zero_set();
        watch.finish()?;
        if extracted.faces.is_empty() {
            return Err(FairError::Vanished);
        }
        let edge = params.edge_ratio * self.edge;
        let surface = LevelSet(&solved.level);
        let patch = remesh_closed(&extracted, &surface, solved.level.lattice.voxel, edge);
        watch.finish()?;
        let patch = patch?;
        let region = RegionReport {
            id: 1,
            closure: Some(Closure::LevelSet),
            converged: true,
            seconds: clock.elapsed().as_secs_f64(),
            ..extracted_report(&solved, &patch)
        };
        watch.end(0, &region);
        let mut report = FairReport::default();
        report.take_all(found);
        Ok(Faired {
            mesh: Mesh::new(patch.positions, patch.faces),
            kept: None,
            report,
            fill: FillReport {
                regions: vec![region],
                ..FillReport::of(found)
            },
        })
    }

    fn stuck(&self, solved: &Solved) -> FairError {
        FairError::Stuck {
            reached: solved.time,
            wanted: self.span.time,
        }
    }

    /// The nested lattices around a whole model.
    fn nested(&self, found: &Inspection) -> NestedSettings<'static> {
        let corners = found.topology.faces().flat_map(|f| found.mesh.corners(f));
        let (low, high) = bounds(corners);
        let longest = (high - low).max_element();
        let refinements = log2(longest / (self.voxel * COARSEST.get()))
            .ceil()
            .max(0.0) as usize;
        let coarse = self.voxel * f64::from(1u32 << refinements.min(16));
        let margin = DVec3::splat(MARGIN.get() * coarse);
        let (lattice, dims) = Lattice::around(low, high, margin, coarse);
        NestedSettings {
            own: None,
            lattice,
            dims,
            refinements,
            stop_if_unconverged: false,
            from: None,
            start: Start::Triangulation,
            flow: FlowSettings::default().across(self.strength / self.voxel),
            time: Some(self.span),
        }
    }

    /// Marks the faces of open components that are not too near a border, and counts the closed components.
    pub(super) fn between_borders(
        &self,
        found: &Inspection,
    ) -> Result<(Vec<bool>, usize), FairError> {
        let strip = STRIP.get() * self.voxel;
        let mut open = vec![false; found.topology.component_faces.len()];
        for h in (0..found.topology.boundary.len()).filter(|h| found.topology.boundary[*h]) {
            let component = found.topology.component[h / 3];
            if component != NONE {
                open[component as usize] = true;
            }
        }
        let of_open = |f: usize| {
            let component = found.topology.component[f];
            component != NONE && open[component as usize]
        };
        let inner = shrunk_from_borders(&found.mesh, &found.topology, strip);
        let marked: Vec<bool> = (0..inner.len()).map(|f| inner[f] && of_open(f)).collect();
        if !marked.contains(&true) {
            return Err(FairError::OnlyBorder { strip });
        }
        Ok((marked, open.iter().filter(|o| !**o).count()))
    }
}

/// The zero set of a level, as a surface without rims.
struct LevelSet<'a>(&'a Level);

impl Surface for LevelSet<'_> {
    fn is_cancelled(&self) -> bool {
        self.0.grid.is_cancelled()
    }

    fn project(&self, p: DVec3) -> Option<(DVec3, DVec3)> {
        self.0.project(p)
    }

    fn depth(&self, _: DVec3) -> f64 {
        f64::MAX
    }
}

/// Size of the surface that is faired.
struct Sizes {
    /// Mean edge length.
    edge: f64,
    /// Area.
    area: f64,
    /// Diagonal of the bounding box.
    diagonal: f64,
}

impl Sizes {
    /// None if the area is zero.
    fn new(found: &Inspection, marked: Option<&[bool]>) -> Option<Self> {
        let (mut edges, mut count, mut area) = (0.0, 0.0, 0.0);
        let wanted = |f: &u32| marked.is_none_or(|m| m[*f as usize]);
        for f in found.topology.faces().filter(wanted) {
            let [a, b, c] = found.mesh.corners(f);
            edges += a.distance(b) + b.distance(c) + c.distance(a);
            count += 3.0;
            area += 0.5 * (b - a).cross(c - a).length();
        }
        let faces = found.topology.faces().filter(wanted);
        let (low, high) = bounds(faces.flat_map(|f| found.mesh.corners(f)));
        (count > 0.0 && area > 0.0).then(|| Self {
            edge: edges / count,
            area,
            diagonal: low.distance(high),
        })
    }

    /// Refuses lengths beyond which nothing of a surface of this size would be left, or which need too many voxels.
    fn check(&self, strength: f64, voxel: f64, asked: VoxelSize) -> Result<(), FairError> {
        let widest = match asked {
            VoxelSize::Auto => PER_FEATURE.get(),
            VoxelSize::Length(_) => MOST_STRENGTH.get(),
        };
        let lengths = [
            ("a strength", strength, widest * self.diagonal),
            ("a voxel", voxel, self.diagonal),
        ];
        if let Some((what, given, fits)) = lengths.into_iter().find(|(_, x, most)| x > most) {
            return Err(FairError::TooCoarse {
                what,
                given,
                diagonal: self.diagonal,
                fits,
            });
        }
        if self.area / (voxel * voxel) > MOST_SQUARES.get() {
            let fits = (self.area / MOST_SQUARES.get()).sqrt();
            return Err(FairError::TooFine { voxel, fits });
        }
        Ok(())
    }
}

/// The report of the solve of a closed surface and of the patch made from it.
fn extracted_report(solved: &Solved, patch: &Patch) -> RegionReport {
    RegionReport {
        voxel: Some(solved.level.lattice.voxel),
        levels: solved.reports.clone(),
        new_vertices: patch.positions.len(),
        new_faces: patch.faces.len(),
        quality_mean: patch.report.quality_mean,
        intersecting_faces: patch.report.intersecting_faces,
        components: patch.report.components,
        ..RegionReport::default()
    }
}
