//! Areas and expected errors of the patches of a mended mesh, compared with a tolerance.

use serde::Serialize;

use super::BEYOND_PART;
use super::components::Component;
use isomend_core::mend::FillReport;
use isomend_core::mesh::{HoleId, Mesh, area_vector};
use isomend_core::tuning::{Tunable, tunable};

/// Expected errors. This multiple of a vertex's expected error has to be within the tolerance: about 94 % of the vertices
/// of a patch are closer to the true surface than twice their expected error.
const SIGMAS: Tunable<f64> = tunable("deliver.sigmas", 2.0);

/// The invented (new) surface of a mesh: totals and one entry for each patch.
#[derive(Clone, Debug, Default, Serialize)]
pub(in crate::job) struct Invented {
    /// Area of the new faces.
    pub(in crate::job) area: f64,
    /// Area of the new faces, in per cent of the whole surface.
    pub(in crate::job) percent: f64,
    /// Expected errors.
    pub(in crate::job) expected_error: Expected,
    /// Numbers of the holes whose patches are not within the tolerance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::job) beyond_tolerance: Option<Vec<HoleId>>,
    /// The same for each patch.
    pub(in crate::job) patches: Vec<Patch>,
}

/// Area and expected error of one patch. Fields as in [`Invented`].
#[derive(Clone, Debug, Serialize)]
pub(in crate::job) struct Patch {
    /// Numbers of its holes.
    pub(in crate::job) holes: Vec<HoleId>,
    /// Number of its region.
    pub(in crate::job) region: usize,
    /// Number of its faces.
    pub(in crate::job) faces: usize,
    /// Its area.
    pub(in crate::job) area: f64,
    /// Its area, in per cent of the whole surface.
    pub(in crate::job) percent: f64,
    /// Expected errors.
    pub(in crate::job) expected_error: Expected,
    /// Whether twice the expected error is within the tolerance on at least 95 % of its area.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::job) is_within: Option<bool>,
}

/// Expected errors of a set of faces, in units of the mesh.
#[derive(Clone, Debug, Default, Serialize)]
pub(in crate::job) struct Expected {
    /// Mean, weighted by area; null if unknown.
    pub(in crate::job) mean: Option<f64>,
    /// The largest; null if unknown.
    pub(in crate::job) largest: Option<f64>,
    /// Per cent of the area without a known expected error.
    pub(in crate::job) unknown_percent: f64,
    /// Per cent of the area where twice the expected error is within the tolerance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(in crate::job) within_percent: Option<f64>,
}

/// Sums over the corners of faces; each corner counts with a third of its face's area.
#[derive(Clone, Copy, Default)]
struct Sums {
    area: f64,
    /// Area with a known expected error.
    known: f64,
    /// Integral of the expected error over the known area.
    error: f64,
    largest: f64,
    /// Area within the tolerance.
    within: f64,
}

impl Sums {
    fn add(&mut self, other: &Self) {
        self.area += other.area;
        self.known += other.known;
        self.error += other.error;
        self.largest = self.largest.max(other.largest);
        self.within += other.within;
    }

    fn expected(&self, tolerance: Option<f64>) -> Expected {
        let is_known = self.known > 0.0;
        let percent = |part: f64| 100.0 * part / self.area.max(f64::MIN_POSITIVE);
        Expected {
            mean: is_known.then(|| self.error / self.known),
            largest: is_known.then_some(self.largest),
            unknown_percent: percent(self.area - self.known),
            within_percent: tolerance.map(|_| percent(self.within)),
        }
    }
}

/// A mesh with its patches, and the data for measuring them.
pub(in crate::job) struct Measured<'a> {
    pub(in crate::job) mesh: &'a Mesh,
    /// The first `kept` vertices are the input's.
    pub(in crate::job) kept: usize,
    /// The expected errors of the new vertices, which follow the input's.
    pub(in crate::job) expected_error: &'a [Option<f64>],
    pub(in crate::job) components: &'a [Component],
    pub(in crate::job) report: &'a FillReport,
    pub(in crate::job) tolerance: Option<f64>,
}

impl Measured<'_> {
    /// Measures the patches.
    pub(in crate::job) fn invented(&self) -> Invented {
        let area = |f: u32| area_vector(self.mesh.corners(f)).length() / 2.0;
        let whole: f64 = (0..self.mesh.faces.len() as u32).map(area).sum();
        let percent = |part: f64| 100.0 * part / whole.max(f64::MIN_POSITIVE);
        let mut all = Sums::default();
        let mut patches = Vec::new();
        for component in self.components {
            let sums = self.sums(component);
            all.add(&sums);
            let within = |_| {
                // `<=`: a patch of zero area is within any tolerance.
                sums.area - sums.within <= BEYOND_PART.get() * sums.area
            };
            patches.push(Patch {
                holes: component.holes.clone(),
                region: component.region,
                faces: component.faces.len(),
                area: sums.area,
                percent: percent(sums.area),
                expected_error: sums.expected(self.tolerance),
                is_within: self.tolerance.map(within),
            });
        }
        let beyond = |_| {
            let beyond = patches.iter().filter(|p| p.is_within == Some(false));
            let mut holes: Vec<HoleId> = beyond.flat_map(|p| p.holes.clone()).collect();
            holes.sort_unstable();
            holes.dedup();
            holes
        };
        Invented {
            area: all.area,
            percent: percent(all.area),
            expected_error: all.expected(self.tolerance),
            beyond_tolerance: self.tolerance.map(beyond),
            patches,
        }
    }

    /// The sums of a component. The input's vertices have error 0. If no new vertex of the component has a known error, the error of the
    /// whole component is unknown.
    fn sums(&self, component: &Component) -> Sums {
        let own = |v: u32| {
            let own = (v as usize).checked_sub(self.kept)?;
            Some(self.expected_error.get(own).copied().flatten())
        };
        let corners = component.faces.iter();
        let mut corners = corners.flat_map(|f| self.mesh.faces[*f as usize]);
        let is_known = corners.any(|v| own(v).flatten().is_some());
        // Unknown error: over a hole the true surface is hardly farther from the patch's triangles than the hole is wide, so a hole
        // smaller than the tolerance is within it.
        let spans_little = self
            .tolerance
            .is_some_and(|t| self.diameter(component) <= t);
        let mut sums = Sums::default();
        for &f in &component.faces {
            let part = area_vector(self.mesh.corners(f)).length() / 6.0;
            for v in self.mesh.faces[f as usize] {
                let error = match own(v) {
                    _ if !is_known => None,
                    None => Some(0.0),
                    Some(error) => error,
                };
                sums.area += part;
                if let Some(error) = error {
                    sums.known += part;
                    sums.error += part * error;
                    sums.largest = sums.largest.max(error);
                }
                let bound = error.map(|e| SIGMAS.get() * e);
                let is_within = |t: f64| bound.map_or(spans_little, |b| b <= t);
                if self.tolerance.is_some_and(is_within) {
                    sums.within += part;
                }
            }
        }
        sums
    }

    /// The diameter of the component's region; infinite if the report does not list the region.
    fn diameter(&self, component: &Component) -> f64 {
        let region = self
            .report
            .regions
            .iter()
            .find(|r| r.id == component.region);
        region.map_or(f64::INFINITY, |r| r.diameter)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::deliver::components::components;
    use isomend_core::fill::FillParams;
    use isomend_core::mend::{Control, Inspection};
    use isomend_core::mesh::shapes::{icosphere, punch};

    #[test]
    fn areas_and_errors_of_caps_of_a_sphere() {
        let sphere = icosphere(4);
        let open = punch(&sphere, |c| c.z > 0.9 || c.z < -0.95);
        let found = Inspection::new(&open).unwrap();
        let filled = found.fill(&FillParams::default(), &Control::new()).unwrap();
        let all = components(&filled.mesh, open.faces.len(), &filled.report);
        let measured = |tolerance| {
            let measured = Measured {
                mesh: &filled.mesh,
                kept: open.positions.len(),
                expected_error: &filled.expected_error,
                components: &all,
                report: &filled.report,
                tolerance,
            };
            measured.invented()
        };
        let plain = measured(None);
        assert_eq!(plain.patches.len(), 2);
        // A cap of the unit sphere above height z has area 2 π (1 - z) of 4 π.
        assert!((plain.percent - 7.5).abs() < 1.0, "{}", plain.percent);
        assert!(plain.beyond_tolerance.is_none());
        let largest = plain.expected_error.largest.unwrap();
        assert!(plain.expected_error.mean.unwrap() < largest);
        let wide = measured(Some(3.0 * largest));
        assert_eq!(wide.beyond_tolerance, Some(Vec::new()));
        assert!((wide.expected_error.within_percent.unwrap() - 100.0).abs() < 1e-9);
        // Patches continue a sphere exactly, so its expected errors are only rounding errors.
        let narrow = measured(Some(largest / 4.0));
        assert!(!narrow.beyond_tolerance.unwrap().is_empty());
    }
}
