//! The options of the solve, which the commands that solve share.

use anyhow::bail;
use clap::{Args, ValueEnum};
use isomend::{Energy, Variant};
use isomend::{FillParams, Finish, VoxelSize};

use super::{Usage, arguments};

/// Options of the solve and of what is written.
#[derive(Debug, Args)]
pub struct SolveArgs {
    #[command(flatten)]
    voxel: VoxelArg,

    #[command(flatten)]
    energy: EnergyArg,

    /// How patches are finished on their own triangles, once the level set has found them.
    #[arg(
        long,
        value_enum,
        value_name = "auto|willmore|none",
        default_value = "auto"
    )]
    finish: FinishName,

    #[command(flatten)]
    scheme: SchemeArg,

    /// Time step of the flow, in units of the voxel size to the fourth power.
    ///
    /// Without it each step aims at the steady state.
    #[arg(long, value_name = "T", value_parser = arguments::positive)]
    time_step: Option<f64>,

    /// Most steps of the flow on each grid [default: 20, with I and II 200].
    #[arg(long, value_name = "N", value_parser = arguments::steps)]
    steps: Option<usize>,

    /// Length of the patch's edges over that of the edges round the hole [default: 0.7, with --finish none 0.8, with
    /// curvature-variation 0.45].
    #[arg(long, value_name = "RATIO", value_parser = arguments::edge_ratio)]
    edge_ratio: Option<f64>,

    /// Exit with 3 unless every hole of more than four edges that was to be filled got a steady surface of the level set,
    /// joined to its rim, that crosses no face.
    #[arg(long)]
    pub(super) strict: bool,
}

/// A voxel size. Commands whose `auto` means something else say so with `mut_arg`.
#[derive(Clone, Copy, Debug, Args)]
pub struct VoxelArg {
    /// Voxel size in the mesh's units.
    ///
    /// `auto` takes 32 voxels across the hole, up to 64 where its rim is finer or it is a slot, up to 96 in a region with a
    /// small loop; with curvature-variation 2.5 times as many, at most 128. A length may be 1/1024 of the hole or more.
    #[arg(long, value_name = "LENGTH|auto", default_value = "auto", value_parser = arguments::voxel)]
    pub(super) voxel: VoxelSize,
}

/// The scheme of the flow's steps.
#[derive(Clone, Copy, Debug, Args)]
pub struct SchemeArg {
    /// Scheme of the flow's steps: I and II are the paper's, for the Willmore energy; all have the same steady surface.
    #[arg(
        long,
        value_enum,
        value_name = "I|II|gauss-newton",
        default_value = "gauss-newton",
        ignore_case = true
    )]
    variant: Scheme,
}

impl SchemeArg {
    /// The scheme.
    pub fn variant(self) -> Variant {
        match self.variant {
            Scheme::I => Variant::I,
            Scheme::II => Variant::II,
            Scheme::GaussNewton => Variant::GaussNewton,
        }
    }
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Scheme {
    #[value(name = "I")]
    I,
    #[value(name = "II")]
    II,
    #[value(name = "gauss-newton")]
    GaussNewton,
}

/// The energy of a solve.
#[derive(Clone, Copy, Debug, Args)]
pub struct EnergyArg {
    /// What a patch makes small.
    ///
    /// The default continues spheres, minimal surfaces and tori and is the most robust, on rough scans above all. Take the
    /// other where the surroundings are smooth and like a cylinder, a cone or an ellipsoid, which the Willmore energy cannot
    /// continue exactly; it takes a few times as long, on voxels 0.4 times as large and with finer triangles unless told otherwise.
    #[arg(
        long,
        value_enum,
        value_name = "willmore|curvature-variation",
        default_value = "willmore"
    )]
    energy: EnergyName,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum FinishName {
    /// By Newton steps of the Willmore energy, and by what the surroundings foretell as far as that proves itself at the rim.
    Auto,
    /// By Newton steps of the Willmore energy.
    Willmore,
    /// Not at all: the level set's surface as it is, on finer grids.
    None,
}

impl From<FinishName> for Finish {
    fn from(name: FinishName) -> Self {
        match name {
            FinishName::Auto => Self::Auto,
            FinishName::Willmore => Self::Willmore,
            FinishName::None => Self::None,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum EnergyName {
    /// The integral of the squared mean curvature.
    Willmore,
    /// The integral of the squared slope of the mean curvature along the surface.
    CurvatureVariation,
}

impl EnergyArg {
    /// The energy.
    pub fn energy(self) -> Energy {
        match self.energy {
            EnergyName::Willmore => Energy::Willmore,
            EnergyName::CurvatureVariation => Energy::CurvatureVariation,
        }
    }
}

impl SolveArgs {
    /// The parameters of the solve; the others are the usual ones.
    pub fn params(&self) -> FillParams {
        FillParams {
            voxel: self.voxel.voxel,
            finish: self.finish.into(),
            energy: self.energy.energy(),
            variant: self.scheme.variant(),
            steps: self.steps,
            time_step: self.time_step,
            edge_ratio: self.edge_ratio,
            ..FillParams::default()
        }
    }

    /// Refuses what has no effect on a level set's own triangles.
    pub fn check_whole(&self) -> anyhow::Result<()> {
        if self.edge_ratio.is_some() {
            let what = "--edge-ratio is for patches; --surface whole has the triangles of the grid, whose size is --voxel";
            return Err(Usage(what.to_owned()).into());
        }
        Ok(())
    }

    /// Whether the options go together.
    pub fn check(&self) -> anyhow::Result<()> {
        let metrics = self.energy.energy().needs().metrics;
        if !metrics.contains(&self.scheme.variant())
            || (metrics.len() == 1 && self.time_step.is_some())
        {
            bail!(
                "--variant and --time-step are for the Willmore energy; leave them out, or --energy"
            );
        }
        Ok(())
    }
}
