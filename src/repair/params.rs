//! What a repair is to do, and what it did.

use serde::{Deserialize, Serialize};

use super::offset_shells::ShellWall;
use crate::check::{CheckParams, Component, Defect, DefectKind, Verdict};
use crate::fill::FillParams;
use crate::mend::{FillError, FillReport};
use crate::parameters::tables;

/// Parameters of a repair. Make one by [`RepairParams::default`] and set what is to differ.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct RepairParams {
    /// Merges coinciding vertices that carry the same, and takes out degenerate and duplicate faces.
    pub clean: bool,
    /// Merges vertices of the border that are no farther from each other than this, in the mesh's units, into the first of them. By
    /// default, with [`Self::clean`], those of edges that coincide but for the precision of the coordinates, where that closes edges
    /// and leaves nothing worse.
    pub weld: Option<f64>,
    /// Drops vertices that no face of the input uses.
    pub drop_unused: bool,
    /// Turns faces so that they agree within each component and closed ones show their outside.
    pub orient: bool,
    /// Separates surfaces that meet in an edge or a vertex, and cuts out what cannot be separated.
    pub split: bool,
    /// Takes out components with less than this part of the area of the largest one.
    pub debris: Option<f64>,
    /// Takes out components that lie wholly inside another one.
    pub drop_inside: bool,
    /// Cuts faces that cross others out, with what is round them.
    pub crossings: bool,
    /// Fills the holes of the mesh; else only those that the repair makes.
    pub holes: bool,
    /// Fills the outer borders of open sheets too.
    pub borders: bool,
    /// The thickness of the walls that borders get which no flat cap closes, in the mesh's units; they are thinner where they would
    /// intersect something. By default a mean edge of the component.
    pub wall: Option<f64>,
    /// Walls that are thinner than this, in the mesh's units, are defects in the verdicts before and after. By default only those are that
    /// the repair made itself, where more than a quarter of a sheet is thinner than half a mean edge.
    pub min_wall: Option<f64>,
    /// How holes are filled. Numbers of holes are those of the input.
    pub fill: FillParams,
}

impl Default for RepairParams {
    fn default() -> Self {
        Self {
            clean: true,
            weld: None,
            drop_unused: false,
            orient: true,
            split: true,
            debris: None,
            drop_inside: false,
            crossings: true,
            holes: true,
            borders: false,
            wall: None,
            min_wall: None,
            fill: FillParams::default(),
        }
    }
}

impl RepairParams {
    /// Whether they make sense by themselves.
    ///
    /// # Errors
    /// [`FillError::Bounds`] and [`FillError::Parameter`].
    pub fn check(&self) -> Result<(), FillError> {
        let bad = |what| Err(FillError::Parameter { what });
        tables::WELD.check(self.weld)?;
        tables::DEBRIS.check(self.debris)?;
        tables::WALL.check(self.wall)?;
        tables::MIN_WALL.check(self.min_wall)?;
        if self.fill.surface == crate::fill::SurfaceKind::Whole {
            return bad(
                "a repair is stitched into the mesh; whole level sets come from a fill alone",
            );
        }
        self.fill.check()
    }

    /// How the input and the result are judged.
    pub(crate) fn checked(&self) -> CheckParams {
        CheckParams {
            min_wall: self.min_wall,
            ..CheckParams::default()
        }
    }
}

/// What a repair found and did.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct RepairReport {
    /// Coinciding vertices that were merged into another.
    pub merged_vertices: usize,
    /// Vertices of the border that were merged into one nearby.
    pub welded_vertices: usize,
    /// Border vertices at which an edge on which they lay was split (T-junctions).
    #[serde(default)]
    pub stitched_junctions: usize,
    /// Degenerate faces that were taken out.
    pub degenerate_faces: usize,
    /// Faces without area that were taken into a neighbour by turning the edge between the two.
    pub flipped_edges: usize,
    /// Duplicate faces that were taken out.
    pub duplicate_faces: usize,
    /// Faces that were turned over.
    pub turned_faces: usize,
    /// Copies of vertices that were made so that surfaces meet there no more.
    pub split_vertices: usize,
    /// Faces at edges with more than two that were cut out.
    pub non_manifold_faces: usize,
    /// Components that were taken out as debris, and their faces.
    pub debris: [usize; 2],
    /// Components that were taken out because they lay inside another, and their faces.
    pub inside: [usize; 2],
    /// Components of the input none of whose faces are in the result, for whatever reason: how many, and the fewest and the most faces
    /// of one.
    #[serde(default)]
    pub gone_components: [usize; 3],
    /// Closed bodies that touched or intersected, or one that intersected itself, and were united.
    pub united_bodies: usize,
    /// Vertices of faces in which bodies touch that were moved for their union, since these faces lie on each other but for rounding.
    #[serde(default)]
    pub moved_vertices: usize,
    /// The longest way of one of these, in the mesh's units.
    #[serde(default)]
    pub largest_move: f64,
    /// Faces that were split where they intersected another body, and of which a part is left.
    pub split_faces: usize,
    /// Faces of united bodies of which nothing is left, since they lay inside others or on each other.
    pub inner_faces: usize,
    /// The passes in which crossing faces were cut out.
    pub passes: Vec<CrossingPass>,
    /// Faces of the input that came to lie under another layer where the two crossed, and were taken out.
    pub covered_faces: usize,
    /// Components whose crossings were left, since nothing of them would have stayed.
    pub left_crossing: usize,
    /// Faces of the input that are not in the result.
    pub lost_faces: usize,
    /// Vertices of the input that are not in the result.
    pub lost_vertices: usize,
    /// Components of the result that were lined in part or as a whole, each with its number from 1 in the order of their first faces. The
    /// walls are those that the lining makes.
    #[serde(default)]
    pub offset_shells: Vec<(usize, Component)>,
    /// The numbers of those whose walls are too thin, each with the thickness that most of its wall should have: a no in the verdict.
    #[serde(default)]
    pub thin_offset_shells: Vec<(usize, f64)>,
    /// What is known of the walls of linings in the course of a repair.
    #[serde(skip)]
    pub(super) walls: Vec<ShellWall>,
    /// The verdict on the input.
    pub before: Option<Verdict>,
    /// The verdict on the result; on the file as it is written, where one is.
    pub after: Option<Verdict>,
    /// The fills. Holes are numbered as they were when they were filled.
    pub fill: FillReport,
}

impl RepairReport {
    /// Takes over the verdict on the result, in which walls of linings that are too thin are a defect.
    pub(crate) fn judge(&mut self, mut verdict: Verdict) {
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
        self.after = Some(verdict);
    }
}

/// One pass in which crossing faces were cut out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct CrossingPass {
    /// Faces that crossed others.
    pub crossing_faces: usize,
    /// Faces that were cut out.
    pub cut_faces: usize,
    /// Rings of faces round the crossing ones that went with them.
    pub rings: usize,
}
