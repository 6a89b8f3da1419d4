//! Chosen thresholds, weights and limits. Each is a constant beside its use, with its unit, what it bounds and what was measured.
//! Mathematical constants, table sizes and block sizes are plain constants.
//!
//! A [`Tunable`] costs no more than a constant. Built with `RUSTFLAGS="--cfg isomend_tuning"` the program reads the environment
//! variable `ISOMEND_TUNING`, a JSON object such as `{"fill.bent": 5.6, "flow.drift": 0.2}`, for experiments: `scripts/sweep.py`
//! varies one value after another.

#[cfg(isomend_tuning)]
mod read;

/// A chosen value, and the name by which an experiment changes it.
#[derive(Clone, Copy, Debug)]
pub struct Tunable<T> {
    #[cfg_attr(not(isomend_tuning), allow(dead_code))]
    name: &'static str,
    chosen: T,
}

/// A threshold with the name of its room and its own, such as `fill.bent`, and its value.
pub const fn tunable<T>(name: &'static str, chosen: T) -> Tunable<T> {
    Tunable { name, chosen }
}

impl<T: Copy> Tunable<T> {
    /// The chosen value, whatever an experiment asks for.
    pub const fn chosen(self) -> T {
        self.chosen
    }

    /// The value of this build.
    #[cfg(not(isomend_tuning))]
    #[inline(always)]
    pub const fn get(self) -> T {
        self.chosen
    }
}
