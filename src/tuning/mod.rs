//! The thresholds, weights and limits that were chosen, with what was measured: one struct for each room. Constants of mathematics, sizes of
//! tables and of blocks of work stand where they are used.
//!
//! [`tuning`] is a constant, so that nothing is slower than with constants at the places of use. Built with
//! `RUSTFLAGS="--cfg isomend_tuning"` the program reads the environment variable `ISOMEND_TUNING`, a JSON object such as
//! `{"fill.bent": 5.6, "flow.drift": 0.2}`, for experiments: `scripts/sweep.py` varies one value after another.

/// A struct of thresholds with the values that were chosen.
macro_rules! thresholds {
    ($(#[$meta:meta])* $name:ident { $($(#[$doc:meta])* $field:ident: $kind:ty = $value:expr,)* }) => {
        $(#[$meta])*
        #[derive(Clone, Debug)]
        pub struct $name {
            $($(#[$doc])* pub $field: $kind,)*
        }

        impl $name {
            /// The values that were chosen.
            pub(super) const CHOSEN: Self = Self { $($field: $value,)* };

            /// Changes a value; whether there is one of that name.
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
mod stitch;

pub use check::CheckTuning;
pub use deliver::DeliverTuning;
pub use fill::FillTuning;
pub use finish::FinishTuning;
pub use flow::FlowTuning;
pub use region::RegionTuning;
pub use repair::RepairTuning;
pub use stitch::StitchTuning;

/// All thresholds.
#[derive(Clone, Debug)]
pub struct Tuning {
    /// Thresholds of what nearly closes a border (`check`).
    pub check: CheckTuning,
    /// Thresholds of what is handed on beside a mended mesh (`job`).
    pub deliver: DeliverTuning,
    /// Thresholds of the search for a closure of a region (`fill`).
    pub fill: FillTuning,
    /// Thresholds of the finish of a patch on its own triangles (`finish`).
    pub finish: FinishTuning,
    /// Thresholds of the flow of a level set (`flow`): when it is steady, when it is lost, and how its steps are combined.
    pub flow: FlowTuning,
    /// Thresholds of regions: groups of holes, their grids, and the nested solve (`region`).
    pub region: RegionTuning,
    /// Thresholds of repairs (`repair`).
    pub repair: RepairTuning,
    /// Thresholds of joining a patch to its rim and of remeshing it (`stitch`).
    pub stitch: StitchTuning,
}

impl Tuning {
    /// The values that were chosen.
    pub(crate) const CHOSEN: Self = Self {
        check: CheckTuning::CHOSEN,
        deliver: DeliverTuning::CHOSEN,
        fill: FillTuning::CHOSEN,
        finish: FinishTuning::CHOSEN,
        flow: FlowTuning::CHOSEN,
        region: RegionTuning::CHOSEN,
        repair: RepairTuning::CHOSEN,
        stitch: StitchTuning::CHOSEN,
    };

    /// Changes a value by its name, such as `fill.bent`; whether there is one of that name.
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
pub(crate) const fn tuning() -> &'static Tuning {
    const CHOSEN: &Tuning = &Tuning::CHOSEN;
    CHOSEN
}

#[cfg(isomend_tuning)]
pub(crate) use read::tuning;

#[cfg(test)]
mod tests {
    use super::*;

    /// Where `scripts/sweep.py` found the error of patches to depend on a value by several per cent.
    #[test]
    fn values_that_matter_are_where_they_have_to_be() {
        let chosen = Tuning::default();
        // The first ring of vertices of a small hole, and no other.
        let ring = chosen.finish.narrow_ring_edges;
        assert!(ring > 1.0 && ring < 1.1);
        // Edges of the target length stay.
        let (short, long) = (chosen.stitch.short_edge, chosen.stitch.long_edge);
        assert!(short < 1.0 && long > 1.0);
        // Whole steps alone count.
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
