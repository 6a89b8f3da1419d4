//! Parameters of a finish.

/// What a finish does beyond Willmore's energy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FinishMethod {
    /// The energy's minimum, blended with what the surroundings foretell as far as that proves itself round the hole.
    #[default]
    Auto,
    /// The minimum of the energy alone.
    Willmore,
}

/// Parameters of [`finish`](super::finish).
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FinishParams {
    /// What is done.
    pub method: FinishMethod,
    /// Most steps of Gauss-Newton from each start. With up to 30 while the energy falls by 1 % a step, errors were larger by 0.3 % on 143
    /// holes of real scans and the same on 113 others: what takes that many has often no minimum near.
    pub most_steps: usize,
    /// The same for patches with more vertices than are kriged, whose systems take most of the time; they get one start.
    pub most_steps_of_large: usize,
    /// Steps end when the largest displacement is below this part of the hole's diameter.
    pub tolerance: f64,
    /// Most data of a kriging; the work grows with the cube. On 143 holes of real scans 180 or 400 instead of 250 left errors
    /// larger by 0.8 %.
    pub most_data: usize,
    /// Most of these from which the kernel is estimated. With 180 instead of 250 the time fell by a quarter and the error rose by
    /// 0.2 %; with 140 by 1.3 %.
    pub most_estimated: usize,
    /// Patches with more vertices get the minimum of the energy alone.
    pub most_blended: usize,
    /// Patches with more vertices than this are not finished.
    pub most_vertices: usize,
    /// Farthest way of a vertex, in diameters of the hole, before a result is refused.
    pub farthest: f64,
    /// Farthest way that the blend may move a vertex from the energy's minimum, in diameters of the hole.
    pub farthest_blended: f64,
}

impl Default for FinishParams {
    fn default() -> Self {
        Self {
            method: FinishMethod::Auto,
            most_steps: 8,
            most_steps_of_large: 16,
            tolerance: 3e-4,
            most_data: 250,
            most_estimated: 180,
            most_blended: 3000,
            most_vertices: 100_000,
            farthest: 0.3,
            farthest_blended: 0.03,
        }
    }
}
