//! Parameters and report of a repair.

use serde::{Deserialize, Serialize};

use super::offset_shells::ShellWall;
use super::steps::RepairSteps;
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
    /// What the steps changed; lengths are in mesh units.
    pub steps: RepairSteps,
    /// Input faces that are not in the result.
    pub lost_faces: usize,
    /// Input vertices that are not in the result.
    pub lost_vertices: usize,
    /// Input components with no face left in the result, for whatever reason.
    #[serde(default)]
    pub lost_components: LostComponents,
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
    /// The report of the fills, collected during the repair.
    #[serde(skip)]
    pub(super) fill: FillReport,
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
        // The walls of the result are measured at more places: both name the thinnest.
        for (number, shell) in &mut self.offset_shells {
            let own = verdict.components.get(*number - 1);
            let thinner = |l: &f64| shell.least_wall.is_some_and(|s| *l < s);
            if let Some(own) = own.filter(|c| c.least_wall.as_ref().is_some_and(thinner)) {
                (shell.least_wall, shell.thinnest_at) = (own.least_wall, own.thinnest_at);
            }
        }
        verdict.doubt = self.doubt;
        self.after = Some(verdict);
    }
}

/// Input components without a face in the result.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct LostComponents {
    /// Number of components.
    pub count: usize,
    /// Faces of the smallest.
    pub fewest_faces: usize,
    /// Faces of the largest.
    pub most_faces: usize,
}

impl LostComponents {
    /// The components of two bodies together.
    pub(super) fn and(self, other: Self) -> Self {
        match [self.count, other.count] {
            [0, _] => other,
            [_, 0] => self,
            _ => Self {
                count: self.count + other.count,
                fewest_faces: self.fewest_faces.min(other.fewest_faces),
                most_faces: self.most_faces.max(other.most_faces),
            },
        }
    }
}
