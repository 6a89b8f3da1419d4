//! Parameters of a finish.

/// Steps of a finish after the minimum of the Willmore energy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FinishMethod {
    /// The energy's minimum, blended with continuations of the surroundings according to their errors on rings around the hole.
    #[default]
    Auto,
    /// Only the minimum of the energy.
    Willmore,
}

/// Parameters of [`finish`](super::finish).
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FinishParams {
    /// Which steps are done.
    pub method: FinishMethod,
    /// Maximum number of Gauss-Newton steps from each initial shape. With up to 30 as long as the energy fell by 1 % per step,
    /// errors were larger by 0.3 % on 143 holes of real scans and the same on 113 others: a shape that needs more steps often has
    /// no minimum nearby.
    pub most_steps: usize,
    /// The same for patches with more than `most_blended` vertices, whose systems take most of the time; they have only one
    /// initial shape.
    pub most_steps_of_large: usize,
    /// Steps end when the largest displacement is below this fraction of the hole's diameter.
    pub tolerance: f64,
    /// Maximum number of data of a kriging; the work grows with its cube. On 143 holes of real scans 180 or 400 instead of 250
    /// left errors larger by 0.8 %.
    pub most_data: usize,
    /// Maximum number of these data used to estimate the kernel. With 180 instead of 250 the time fell by a quarter and the error
    /// rose by 0.2 %; with 140 by 1.3 %.
    pub most_estimated: usize,
    /// Patches with more vertices get the minimum of the energy and one kriged continuation, with fixed weights.
    pub most_blended: usize,
    /// Patches with more vertices than this are not finished.
    pub most_vertices: usize,
    /// A result that moves a vertex farther than this, in diameters of the hole, is refused.
    pub farthest: f64,
    /// Maximum displacement by the blend of a vertex from the energy's minimum, in diameters of the hole.
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
