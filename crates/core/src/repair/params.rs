//! Parameters and report of a repair.

use serde::{Deserialize, Serialize};

use super::offset_shells::ShellWall;
use crate::check::{CheckParams, Component, Defect, DefectKind, ShapeDoubt, Verdict};
use crate::fill::FillParams;
use crate::mend::{FillError, FillReport};
use crate::parameters::tables;

/// A step of a repair that can be left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RepairStep {
    /// Coinciding vertices with equal attributes are merged, degenerate and duplicate faces removed.
    Duplicates,
    /// Faces are reoriented so that they agree within each component and closed components show their outside.
    Orientation,
    /// Surfaces that meet in an edge or a vertex are separated; faces are cut out where that is not possible.
    NonManifold,
    /// Bodies that intersect are united; other faces that intersect are moved apart, or cut out with the faces round them.
    Intersections,
    /// The holes of the input are filled. If skipped, only holes that the repair makes are filled.
    Holes,
}

/// Parameters of a repair. Start from [`RepairParams::default`] and set the fields that differ.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct RepairParams {
    /// The steps that are left out.
    pub skip: Vec<RepairStep>,
    /// Merges each boundary vertex into the nearest earlier one within this distance, in mesh units. By default, unless
    /// [`RepairStep::Duplicates`] is skipped, boundary edges that coincide within the precision of the coordinates are merged, if that closes edges and
    /// makes nothing worse.
    pub weld: Option<f64>,
    /// Drops vertices that no face of the input uses.
    pub drop_unused: bool,
    /// Removes these components before all else: their numbers from 1, in the order of their first faces.
    pub drop: Vec<usize>,
    /// Removes components with less than this fraction of the largest component's area.
    pub debris: Option<f64>,
    /// Removes components that lie entirely inside another one, but no cavities of bodies.
    pub drop_inside: bool,
    /// Removes the inner skins of double-skinned bodies, with the necks of the pinholes that lead into them, and closes the pinholes.
    pub solid: bool,
    /// Also closes the outer borders of open sheets.
    pub borders: bool,
    /// Thickness of the walls (offset shells) for borders that no flat cap closes, in mesh units. Walls are thinner where they
    /// would intersect other faces. By default the mean edge length of the component.
    pub wall: Option<f64>,
    /// Walls thinner than this, in mesh units, are defects in the verdicts before and after. By default only walls made by the
    /// repair count, if more than a quarter of a sheet has walls thinner than half a mean edge.
    pub min_wall: Option<f64>,
    /// How holes are filled. Hole numbers refer to the input.
    pub fill: FillParams,
}

impl RepairParams {
    /// Whether a step is not skipped.
    pub fn does(&self, step: RepairStep) -> bool {
        !self.skip.contains(&step)
    }

    /// Checks that the values are within their bounds and consistent.
    ///
    /// # Errors
    /// [`FillError::Bounds`] and [`FillError::Parameter`].
    pub fn check(&self) -> Result<(), FillError> {
        tables::WELD.check(self.weld)?;
        tables::DEBRIS.check(self.debris)?;
        tables::WALL.check(self.wall)?;
        tables::MIN_WALL.check(self.min_wall)?;
        if self.borders && !self.does(RepairStep::Holes) {
            return Err(FillError::Parameter {
                what: "`close_borders` closes outer borders, but `skip` leaves holes open: leave one of the two out",
            });
        }
        if self.wall.is_some() && !self.borders {
            return Err(FillError::Parameter {
                what: "`wall` is the thickness of walls at outer borders: set `close_borders` too",
            });
        }
        self.fill.check()
    }

    /// The check parameters for the input and the result.
    pub fn checked(&self) -> CheckParams {
        CheckParams {
            min_wall: self.min_wall,
            ..CheckParams::default()
        }
    }
}

/// The report of a repair: what it found and did.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct RepairReport {
    /// Coinciding vertices merged into another one.
    pub merged_vertices: usize,
    /// Boundary vertices merged into a nearby one.
    pub welded_vertices: usize,
    /// Boundary vertices at which the edge they lay on was split (T-junctions).
    #[serde(default)]
    pub stitched_junctions: usize,
    /// The width of the widest cracks that were closed beyond the precision of the coordinates, in mesh units; 0 if there were none.
    #[serde(default)]
    pub crack_width: f64,
    /// Faces added along loops of edges at which bodies that share edges lacked one.
    #[serde(default)]
    pub closing_faces: usize,
    /// Degenerate faces removed.
    pub degenerate_faces: usize,
    /// Faces without area that were merged into a neighbour by flipping the common edge.
    pub flipped_edges: usize,
    /// Duplicate faces removed.
    pub duplicate_faces: usize,
    /// Faces whose orientation was reversed.
    pub reoriented_faces: usize,
    /// Vertex copies made to separate surfaces that met there.
    pub split_vertices: usize,
    /// Faces cut out at edges with more than two faces.
    pub non_manifold_faces: usize,
    /// Components removed by their numbers, and their faces.
    #[serde(default)]
    pub dropped: [usize; 2],
    /// Components removed as debris, and their faces.
    pub debris: [usize; 2],
    /// Components removed because they lay inside another one, and their faces.
    pub inside: [usize; 2],
    /// Inner skins of double-skinned bodies that were removed, and the faces removed with the necks of their pinholes.
    #[serde(default)]
    pub inner_skins: [usize; 2],
    /// The pinholes that led into these, each closed by a patch.
    #[serde(default)]
    pub pinholes: usize,
    /// The largest distance between an outer skin and its inner one, in mesh units.
    #[serde(default)]
    pub skin_thickness: f64,
    /// Input components with no face left in the result, for whatever reason: their number, and the smallest and largest number
    /// of faces of one.
    #[serde(default)]
    pub lost_components: [usize; 3],
    /// Closed bodies that touched or intersected another, or themselves, and were united.
    pub united_bodies: usize,
    /// Vertices moved before a union, because faces of two bodies coincided there except for rounding.
    #[serde(default)]
    pub moved_vertices: usize,
    /// The largest displacement of one of these, in mesh units.
    #[serde(default)]
    pub largest_move: f64,
    /// Vertices moved where faces of a fold or of noise intersected, so that none had to be cut out there.
    #[serde(default)]
    pub relaxed_vertices: usize,
    /// The largest displacement of one of these, in mesh units.
    #[serde(default)]
    pub largest_relaxation: f64,
    /// Faces split where they intersected another body, with a part kept.
    pub split_faces: usize,
    /// Faces of united bodies removed entirely, because they lay inside other bodies or on their faces.
    pub inner_faces: usize,
    /// The passes in which intersecting faces were cut out.
    pub passes: Vec<SelfIntersectionPass>,
    /// Input faces removed because they lay inside a surface that intersected theirs, or were covered by it.
    pub covered_faces: usize,
    /// Components left with self-intersections, because cutting would have removed them entirely.
    pub left_self_intersecting: usize,
    /// Input faces that are not in the result.
    pub lost_faces: usize,
    /// Input vertices that are not in the result.
    pub lost_vertices: usize,
    /// Components of the result with an offset shell, partial or whole: the component's number, from 1 in the order of first
    /// faces, and its data. The wall fields describe the walls between the surface and the shell.
    #[serde(default, alias = "linings")]
    pub offset_shells: Vec<(usize, Component)>,
    /// Numbers of those components whose walls are too thin, with the thickness that most of the wall should have. The verdict on
    /// the result is then negative.
    #[serde(default, alias = "thin_linings")]
    pub thin_offset_shells: Vec<(usize, f64)>,
    /// The walls of the offset shells, collected during the repair.
    #[serde(skip)]
    pub(super) walls: Vec<ShellWall>,
    /// Why the shape of the result is doubtful, if it is.
    #[serde(default)]
    pub doubt: Option<ShapeDoubt>,
    /// The verdict on the input.
    pub before: Option<Verdict>,
    /// The verdict on the result, or on the written file if there is one.
    pub after: Option<Verdict>,
    /// The report on each object of a 3MF file, with its name, if the file has several: each is repaired by itself. Else empty.
    #[serde(default)]
    pub objects: Vec<(String, RepairReport)>,
    /// The report of the fills. Holes are numbered as they were when they were filled.
    pub fill: FillReport,
}

impl RepairReport {
    /// Stores the verdict on the result and adds a defect for offset shells with too thin walls.
    pub fn judge(&mut self, mut verdict: Verdict) {
        if !self.objects.is_empty() && !verdict.objects.is_empty() {
            self.judge_bodies(verdict);
            return;
        }
        let mut faces = 0;
        for (number, limit) in &self.thin_offset_shells {
            let shell = self.offset_shells.iter().find(|(n, _)| n == number);
            let own = verdict.components.get_mut(number - 1);
            let (Some((_, shell)), Some(own)) = (shell, own) else {
                continue;
            };
            let thinner = |l: f64| own.least_wall.is_none_or(|o| l < o);
            if shell.least_wall.is_some_and(thinner) {
                (own.least_wall, own.thinnest_at) = (shell.least_wall, shell.thinnest_at);
            }
            let known = verdict.params.min_wall.unwrap_or(0.0);
            verdict.params.min_wall = Some(known.max(*limit));
            faces += own.faces;
            verdict.foils.push(*number);
        }
        if faces > 0 && verdict.count(DefectKind::ThinWall) == 0 {
            let defect = Defect::named(DefectKind::ThinWall, faces);
            verdict.defects.push(defect);
        }
        verdict.doubt = self.doubt;
        self.after = Some(verdict);
    }
}

/// One pass in which intersecting faces were cut out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct SelfIntersectionPass {
    /// Faces that intersected others.
    pub intersecting_faces: usize,
    /// Faces cut out.
    pub cut_faces: usize,
    /// Rings of faces round the intersecting ones that were cut out too.
    pub rings: usize,
}
