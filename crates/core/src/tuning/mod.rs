//! All chosen thresholds, weights and limits, with what was measured: one struct per module. Mathematical constants, table sizes
//! and block sizes are defined where they are used.
//!
//! [`tuning`] is a constant, so it costs no more than constants at the places of use. Built with `RUSTFLAGS="--cfg
//! isomend_tuning"` the program reads the environment variable `ISOMEND_TUNING`, a JSON object such as `{"fill.bent": 5.6,
//! "flow.drift": 0.2}`, for experiments: `scripts/sweep.py` varies one value after another.

/// Defines a struct of thresholds with their chosen values.
macro_rules! thresholds {
    ($(#[$meta:meta])* $name:ident { $($(#[$doc:meta])* $field:ident: $kind:ty = $value:expr,)* }) => {
        $(#[$meta])*
        #[derive(Clone, Debug)]
        pub struct $name {
            $($(#[$doc])* pub $field: $kind,)*
        }

        impl $name {
            /// The chosen values.
            pub(super) const CHOSEN: Self = Self { $($field: $value,)* };

            /// Sets a value by name. Returns false if there is no such threshold.
            #[cfg(isomend_tuning)]
            #[allow(trivial_numeric_casts, clippy::unnecessary_cast, clippy::too_many_lines)]
            pub(super) fn set(&mut self, name: &str, value: f64) -> bool {
                match name {
                    $(stringify!($field) => self.$field = value as $kind,)*
                    _ => return false,
                }
                true
            }
        }

        impl Default for $name {
            fn default() -> Self {
                Self::CHOSEN
            }
        }
    };
}

mod check;
mod deliver;
mod fill;
mod finish;
mod flow;
#[cfg(isomend_tuning)]
mod read;
mod region;
mod repair;
mod solid;
mod stitch;

pub use check::CheckTuning;
pub use deliver::DeliverTuning;
pub use fill::FillTuning;
pub use finish::FinishTuning;
pub use flow::FlowTuning;
pub use region::RegionTuning;
pub use repair::RepairTuning;
pub use solid::SolidTuning;
pub use stitch::StitchTuning;

/// All thresholds.
#[derive(Clone, Debug)]
pub struct Tuning {
    /// Thresholds for nearly closed boundaries, wall thickness and the precision of coordinates (`check`).
    pub check: CheckTuning,
    /// Thresholds for outputs beside the mended mesh (`job`).
    pub deliver: DeliverTuning,
    /// Thresholds for choosing the patch of a region (`fill`).
    pub fill: FillTuning,
    /// Thresholds for the finish of a patch on its own triangles (`finish`).
    pub finish: FinishTuning,
    /// Thresholds for the flow of a level set (`flow`).
    pub flow: FlowTuning,
    /// Thresholds for regions (`region`): grouping of holes, grids, the nested solve.
    pub region: RegionTuning,
    /// Thresholds for repairs (`repair`).
    pub repair: RepairTuning,
    /// Thresholds for inner skins (`repair/solid`).
    pub solid: SolidTuning,
    /// Thresholds for joining a patch to its rim and for remeshing it (`stitch`).
    pub stitch: StitchTuning,
}

impl Tuning {
    /// The chosen values.
    pub(crate) const CHOSEN: Self = Self {
        check: CheckTuning::CHOSEN,
        deliver: DeliverTuning::CHOSEN,
        fill: FillTuning::CHOSEN,
        finish: FinishTuning::CHOSEN,
        flow: FlowTuning::CHOSEN,
        region: RegionTuning::CHOSEN,
        repair: RepairTuning::CHOSEN,
        solid: SolidTuning::CHOSEN,
        stitch: StitchTuning::CHOSEN,
    };

    /// Sets a value by its full name, such as `fill.bent`. Returns false if there is no such threshold.
    #[cfg(isomend_tuning)]
    fn set(&mut self, name: &str, value: f64) -> bool {
        match name.split_once('.') {
            Some(("check", name)) => self.check.set(name, value),
            Some(("deliver", name)) => self.deliver.set(name, value),
            Some(("fill", name)) => self.fill.set(name, value),
            Some(("finish", name)) => self.finish.set(name, value),
            Some(("flow", name)) => self.flow.set(name, value),
            Some(("region", name)) => self.region.set(name, value),
            Some(("repair", name)) => self.repair.set(name, value),
            Some(("solid", name)) => self.solid.set(name, value),
            Some(("stitch", name)) => self.stitch.set(name, value),
            _ => false,
        }
    }
}

impl Default for Tuning {
    fn default() -> Self {
        Self::CHOSEN
    }
}

/// The thresholds of this build.
#[cfg(not(isomend_tuning))]
#[inline(always)]
pub const fn tuning() -> &'static Tuning {
    const CHOSEN: &Tuning = &Tuning::CHOSEN;
    CHOSEN
}

#[cfg(isomend_tuning)]
pub use read::tuning;

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks the values on which `scripts/sweep.py` found the error of patches to depend by several per cent.
    #[test]
    fn values_that_matter_are_where_they_have_to_be() {
        let chosen = Tuning::default();
        // The narrow ring holds the first ring of vertices of a small hole and no other.
        let ring = chosen.finish.narrow_ring_edges;
        assert!(ring > 1.0 && ring < 1.1);
        // Edges of the target length are neither split nor collapsed.
        let (short, long) = (chosen.stitch.short_edge, chosen.stitch.long_edge);
        assert!(short < 1.0 && long > 1.0);
        // Only whole steps count as converged.
        let whole = chosen.flow.whole_step;
        assert!(whole > 0.5 && whole < 1.0);
    }

    #[test]
    fn the_build_has_the_chosen_values_or_those_of_the_environment() {
        let chosen = Tuning::default();
        if std::env::var_os("ISOMEND_TUNING").is_none() {
            assert_eq!(format!("{chosen:?}"), format!("{:?}", tuning()));
        }
    }
}
