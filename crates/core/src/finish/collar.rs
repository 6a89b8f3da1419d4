//! The collar: known vertices around a patch that are the data of kriging.

use glam::DVec3;

use super::patch::Patch;
use crate::cancel::Cancel;

/// The known vertices around a patch within some width, and the ones used as data, most important first.
pub(super) struct Collar {
    pub(super) width: f64,
    pub(super) vertices: Vec<u32>,
    rim: Vec<u32>,
    others: Vec<u32>,
}

impl Collar {
    /// Selects at most `most` data by farthest-point sampling: up to half from the rim, the others with a density that falls with
    /// the distance from the patch (a vertex's distance to the chosen ones is weighted by 1 / (its distance to the patch + half
    /// an edge)). (Y. Eldar et al., "The farthest point strategy for progressive image sampling", 1997. On 143 holes of real
    /// scans random draws of the same density left errors larger by 0.3 to 1.3 %.)
    pub(super) fn new(patch: &Patch, width: f64, most: usize) -> Self {
        Self::of(patch, width, most, |_| true)
    }

    /// The same of the known vertices for which `is_used` is true.
    pub(super) fn of(
        patch: &Patch,
        width: f64,
        most: usize,
        is_used: impl Fn(u32) -> bool,
    ) -> Self {
        let near = |&v: &u32| {
            let i = v as usize;
            patch.known[i] && patch.distance[i] < width * patch.diameter && is_used(v)
        };
        let vertices: Vec<u32> = (0..patch.points.len() as u32).filter(near).collect();
        let (mut rim, mut others): (Vec<u32>, Vec<u32>) = vertices
            .iter()
            .partition(|v| patch.rim.binary_search(v).is_ok());
        if vertices.len() > most {
            let weight = |v: u32| 1.0 / (patch.distance[v as usize] + 0.5 * patch.edge);
            rim = farthest(patch, &rim, &[], |_| 1.0, most / 2);
            others = farthest(patch, &others, &rim, weight, most - rim.len());
        }
        Self {
            width,
            vertices,
            rim,
            others,
        }
    }

    /// At most `most` data; if there are more, up to half of them from the rim.
    pub(super) fn data(&self, most: usize) -> Vec<u32> {
        let all = self.rim.len() + self.others.len();
        let rim = if all > most {
            self.rim.len().min(most / 2)
        } else {
            self.rim.len()
        };
        let others = self.others.len().min(most - rim);
        let mut data = [&self.rim[..rim], &self.others[..others]].concat();
        data.sort_unstable();
        data
    }
}

/// Farthest-point sampling: at most `most` of the items, each the farthest (weighted) from `before` and from those already
/// chosen.
fn farthest(
    patch: &Patch,
    items: &[u32],
    before: &[u32],
    weight: impl Fn(u32) -> f64,
    most: usize,
) -> Vec<u32> {
    let at = |v: u32| patch.points[v as usize];
    let near = |v: u32| before.iter().map(move |&c| at(v).distance_squared(at(c)));
    let points: Vec<DVec3> = items.iter().map(|&v| at(v)).collect();
    let weights: Vec<f64> = items.iter().map(|&v| weight(v)).collect();
    let distances = items.iter().map(|&v| near(v).fold(f64::INFINITY, f64::min));
    let score = |k: usize, squared: f64| weights[k] * squared;
    let chosen = farthest_points(&points, distances.collect(), score, most, &patch.cancel);
    chosen.into_iter().map(|k| items[k]).collect()
}

/// Farthest-point sampling: the indices of at most `most` points, in the order of choice. Each has the largest positive score of its
/// index and its squared distance from the points chosen before, of which `squared` are the first; among equals it is the first.
pub(super) fn farthest_points(
    points: &[DVec3],
    mut squared: Vec<f64>,
    score: impl Fn(usize, f64) -> f64,
    most: usize,
    cancel: &Cancel,
) -> Vec<usize> {
    let mut chosen = Vec::new();
    while chosen.len() < most && !cancel.is_cancelled() {
        let (mut best, mut highest) = (None, 0.0);
        for (k, &distance) in squared.iter().enumerate() {
            let own = score(k, distance);
            if own > highest {
                (best, highest) = (Some(k), own);
            }
        }
        let Some(best) = best else { break };
        chosen.push(best);
        for (distance, p) in squared.iter_mut().zip(points) {
            *distance = distance.min(points[best].distance_squared(*p));
        }
    }
    chosen
}
