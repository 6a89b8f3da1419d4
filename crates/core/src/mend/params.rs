//! Parameters of fills, restorations and fairings: defaults, units and checks.

use serde::{Deserialize, Serialize};

use super::FillError;
use crate::fill::{FillParams, Finish, Sharp};
use crate::flow::Energy;
use crate::parameters::{OutOfBounds, solve, tables};
use crate::region::VoxelSize;

impl FillParams {
    /// Checks the parameters on their own.
    ///
    /// # Errors
    /// [`FillError::Bounds`] and [`FillError::Parameter`].
    pub fn check(&self) -> Result<(), FillError> {
        self.bounds()?;
        if self.energy == Energy::Own {
            return Err(FillError::Parameter {
                what: "`energy` cannot be `own`: pass your own energy to `Inspection::fill_with`",
            });
        }
        let named = self.holes.iter().flatten().chain(&self.flat);
        let named = named.chain(self.bridge.iter().flatten());
        if named.into_iter().any(|id| self.keep_open.contains(id)) {
            return Err(FillError::Parameter {
                what: "a hole of `keep_open` is named in `holes`, `flat` or `bridge` too: leave it out of one of them",
            });
        }
        let is_alone = |group: &Vec<_>| group.iter().all(|id| *id == group[0]);
        if self.bridge.iter().any(is_alone) {
            return Err(FillError::Parameter {
                what: "a group of `bridge` needs two different holes or more",
            });
        }
        if self.bridges(&self.flat) {
            return Err(FillError::Parameter {
                what: "a hole that is bridged to others cannot get a flat cap: leave it out of `bridge` or of `flat`",
            });
        }
        if !self.crease.is_empty() && (self.sharp == Sharp::Off || !self.finishes()) {
            return Err(FillError::Parameter {
                what: "`crease` asks for sharp edges, which are continued only with a finish and the Willmore energy, and not with `sharp` off; leave `crease` or the other parameter out",
            });
        }
        if self.like.is_some() && !self.finishes() {
            return Err(FillError::Parameter {
                what: "patches with the shape of a counterpart, `like`, need their finish: not with `finish` none, another energy than willmore, steps \
                       of one's own or a level set by itself; leave one of them out",
            });
        }
        if self.like.as_ref().is_some_and(|like| !like.is_valid()) {
            return Err(FillError::Parameter {
                what: "the mirror plane of `like` needs a point and a normal of finite numbers, and the normal must not be zero",
            });
        }
        if self.grain && !self.finishes() {
            return Err(FillError::Parameter {
                what: "`grain` is added to finished patches: not with `finish` none, another energy than willmore, steps of one's own or \
                       a level set by itself; leave one of them out",
            });
        }
        if self.base_offset.is_some() && !self.flat_base {
            return Err(FillError::Parameter {
                what: "`base_offset` is the distance of a flat base below its sheet: set `flat_base` too",
            });
        }
        Ok(())
    }

    /// Checks all numbers against their bounds.
    fn bounds(&self) -> Result<(), OutOfBounds> {
        solve::VOXEL.check(self.voxel.length())?;
        solve::EDGE_RATIO.check(self.edge_ratio())?;
        solve::MAX_DIAMETER.check(self.max_diameter)?;
        tables::BASE_OFFSET.check(self.base_offset)?;
        Ok(())
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
            grain: false,
            apart: false,
            finish: Finish::Auto,
            sharp: Sharp::Auto,
            energy: Energy::Willmore,
            edge_ratio: None,
        }
    }
}

/// Parameters of a restoration.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct RestoreParams {
    /// The parameters of the fill. The mask decides which holes are filled and the result is always stitched: `holes`,
    /// `keep_open`, `bridge`, `max_diameter`, `surface`, `flat_base` and `base_offset` are ignored. `crease` is ignored too,
    /// since it numbers the crease ends before the cut.
    pub fill: FillParams,
    /// From 0 to 1: fraction W of the damaged shape that is kept. Features narrower than about (1 − W) / W diameters of the
    /// region are removed; 0 keeps nothing, 1 all that the grid can resolve.
    pub keep_shape: f64,
    /// Keeps vertices that no face uses any more, so that vertices of the input keep their numbers.
    pub keep_vertices: bool,
}

/// How far a surface is faired.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum FairExtent {
    /// For this time of the Willmore flow, in length⁴.
    Time(f64),
    /// Until features narrower than this length are removed: waves of this length keep e⁻¹ of their height, waves of half this
    /// length e⁻¹⁶.
    Strength(f64),
    /// Until features narrower than eight mean edges are removed; wider ones on surfaces of over 400,000 faces, whose grid would
    /// be too large.
    #[default]
    Auto,
}

/// Parameters of a fairing: how far a surface is smoothed by Willmore flow.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct FairParams {
    /// How far the surface is faired.
    pub extent: FairExtent,
    /// Voxel size; `Auto` is an eighth of the width of the removed features.
    pub voxel: VoxelSize,
    /// Length of the new edges over the length of the mesh's edges, between 0.05 and 20: of the edges around a marked region, or
    /// the mean of all.
    pub edge_ratio: f64,
    /// Keeps vertices that no face uses any more, so that vertices of the input keep their numbers.
    pub keep_vertices: bool,
}

impl FairParams {
    /// Checks the parameters on their own.
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
            edge_ratio: 1.0,
            keep_vertices: false,
        }
    }
}
