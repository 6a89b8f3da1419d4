//! The public parameters, with their defaults and units.

use serde::{Deserialize, Serialize};

use super::FillError;
use crate::fill::{FillParams, Finish, Like, Sharp, SurfaceKind};
use crate::flow::{Energy, Variant};
use crate::parameters::{OutOfBounds, solve, tables};
use crate::region::VoxelSize;

impl FillParams {
    /// Whether they make sense by themselves.
    ///
    /// # Errors
    /// [`FillError::Bounds`] and [`FillError::Parameter`].
    pub fn check(&self) -> Result<(), FillError> {
        self.bounds()?;
        if self.energy == Energy::Own {
            return Err(FillError::Parameter {
                what: "an energy of one's own is given to `Inspection::fill_with`, not in the parameters",
            });
        }
        if self.bridges(&self.flat) {
            return Err(FillError::Parameter {
                what: "a hole that is bridged to others gets no flat cap",
            });
        }
        if !self.crease.is_empty() && (self.sharp == Sharp::Off || !self.finishes()) {
            return Err(FillError::Parameter {
                what: "sharp edges are asked for by `crease`, but none are continued with `sharp` off, without a finish, with another \
                       energy than willmore, with steps of one's own or in a level set by itself; leave one of them out",
            });
        }
        if self.like.is_some() && !self.finishes() {
            return Err(FillError::Parameter {
                what: "patches after a counterpart, `like`, need their finish: not with `finish` none, another energy than willmore, steps \
                       of one's own or a level set by itself; leave one of them out",
            });
        }
        if self.grain && !self.finishes() {
            return Err(FillError::Parameter {
                what: "`grain` is added to finished patches: not with `finish` none, another energy than willmore, steps of one's own or \
                       a level set by itself; leave one of them out",
            });
        }
        if self.like_scale && !matches!(self.like, Some(Like::Template { .. })) {
            return Err(FillError::Parameter {
                what: "`like_scale` scales a template: give its file by `like` too",
            });
        }
        if self.base_offset.is_some() && !self.flat_base {
            return Err(FillError::Parameter {
                what: "`base_offset` says how far below a sheet its base lies: give `flat_base` too",
            });
        }
        if self.surface == SurfaceKind::Whole && (self.flat_base || !self.flat.is_empty()) {
            return Err(FillError::Parameter {
                what: "flat caps and bases come without a level set: they can only be stitched in",
            });
        }
        Ok(())
    }

    /// Whether all numbers keep their bounds.
    fn bounds(&self) -> Result<(), OutOfBounds> {
        solve::VOXEL.check(self.voxel.length())?;
        solve::EDGE_RATIO.check(self.edge_ratio())?;
        solve::MAX_DIAMETER.check(self.max_diameter)?;
        tables::BASE_OFFSET.check(self.base_offset)?;
        solve::STEPS.check(self.steps.map(|n| n as f64))?;
        solve::TIME_STEP.check(self.time_step)
    }
}

impl Default for FillParams {
    fn default() -> Self {
        Self {
            voxel: VoxelSize::Auto,
            holes: None,
            max_diameter: None,
            keep_open: Vec::new(),
            bridge: Vec::new(),
            flat: Vec::new(),
            crease: Vec::new(),
            flat_base: false,
            base_offset: None,
            like: None,
            like_scale: false,
            grain: false,
            surface: SurfaceKind::Stitched,
            finish: Finish::Auto,
            sharp: Sharp::Auto,
            energy: Energy::Willmore,
            variant: Variant::GaussNewton,
            steps: None,
            time_step: None,
            edge_ratio: None,
        }
    }
}

/// Parameters of a restoration.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct RestoreParams {
    /// The parameters of the fill. The mask decides which holes are filled and the result is always stitched, so the fields
    /// on these do not matter; nor do pairs of crease ends, whose numbers are those before the cut.
    pub fill: FillParams,
    /// From 0 to 1: how much of the damaged shape is kept. Features narrower than about (1 − W) / W times the diameter of
    /// the region go; 0 keeps nothing, 1 all that the grid can hold.
    pub keep_shape: f64,
    /// Keeps vertices that no face uses any more, so that those of the input keep their numbers.
    pub keep_vertices: bool,
}

/// How far a surface is faired.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum FairExtent {
    /// For a time of the Willmore flow, in length⁴.
    Time(f64),
    /// Until features narrower than this length are gone: waves of that length lose all but e⁻¹ of their height, those of
    /// half of it all but e⁻¹⁶.
    Strength(f64),
    /// Features narrower than eight mean edges go; more on surfaces of over 400,000 faces, whose grid would be too large.
    #[default]
    Auto,
}

/// Parameters of a fairing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct FairParams {
    /// How far.
    pub extent: FairExtent,
    /// Voxel size; `Auto` is an eighth of the features that go.
    pub voxel: VoxelSize,
    /// The scheme of the flow's steps.
    pub variant: Variant,
    /// Length of the new edges over that of the mesh's edges, between 0.05 and 20: those round a marked region, or the mean
    /// of all.
    pub edge_ratio: f64,
    /// Keeps vertices that no face uses any more, so that those of the input keep their numbers.
    pub keep_vertices: bool,
}

impl FairParams {
    /// Whether they make sense by themselves.
    ///
    /// # Errors
    /// [`FillError::Bounds`].
    pub fn check(&self) -> Result<(), FillError> {
        match self.extent {
            FairExtent::Time(time) => tables::TIME.check(time)?,
            FairExtent::Strength(strength) => tables::STRENGTH.check(strength)?,
            FairExtent::Auto => {}
        }
        solve::VOXEL.check(self.voxel.length())?;
        Ok(tables::FAIR_EDGE_RATIO.check(self.edge_ratio)?)
    }
}

impl Default for FairParams {
    fn default() -> Self {
        Self {
            extent: FairExtent::Auto,
            voxel: VoxelSize::Auto,
            variant: Variant::GaussNewton,
            edge_ratio: 1.0,
            keep_vertices: false,
        }
    }
}
