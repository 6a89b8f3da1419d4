//! The patch with creases: its parts triangulated and joined.

use glam::DVec3;
use rustc_hash::{FxBuildHasher, FxHashSet};

use super::network::{CreaseLine, Network, ends, simple_loops};
use super::rim_sides::RimSides;
use super::{Continued, Crease, CreaseRefusal, Determined, parts};
use crate::tuning::{Tunable, tunable};

/// Distances from the rim at which creases start inside the hole, in edges: attempted in this order.
const LEADS: [f64; 4] = [0.3, 0.6, 1.0, 1.5];
/// Maximum number of combinations of shifted ends.
const MOST_SHIFTS: Tunable<usize> = tunable("creases.patch.most_shifts", 60);

impl RimSides {
    /// Continues the creases that end at the rim, or fills a rim that runs along creases with its one side. The mesh has `count`
    /// vertices.
    ///
    /// The result is the first valid patch, with the ends of creases shifted along the rim as little as possible: on bevelled
    /// meshes the vertex at which a crease ends is uncertain.
    pub(crate) fn continued(&self, count: usize) -> Result<Continued, CreaseRefusal> {
        self.first_valid(&self.labels, count)
    }

    /// The first valid patch for given sides of the rim's edges, with their changes shifted.
    pub(super) fn first_valid(
        &self,
        labels: &[usize],
        count: usize,
    ) -> Result<Continued, CreaseRefusal> {
        let ends = ends(labels);
        let mut first = None;
        for (at, shifts) in shifts(ends.len()).iter().enumerate() {
            let Some(labels) = shifted(labels, &ends, shifts) else {
                continue;
            };
            for lead in LEADS {
                match self.patch(&labels, lead, count) {
                    Ok(patch) => return Ok(patch),
                    Err(why) => {
                        first.get_or_insert(why);
                        if !why.may_shift() {
                            if at == 0 {
                                return Err(why);
                            }
                            break;
                        }
                    }
                }
            }
        }
        Err(first.unwrap_or(CreaseRefusal::NoSide))
    }

    fn patch(&self, labels: &[usize], lead: f64, count: usize) -> Result<Continued, CreaseRefusal> {
        self.check(labels)?;
        let network = Network::new(&self.collar, &self.sides, labels, lead)?;
        let rim = self.collar.rim.len();
        // Triangulates each part; numbers are the network's points, then inner points.
        let mut points = network.points.clone();
        let mut parts = Vec::new();
        let mut faces = Vec::new();
        let loops = network.parts.iter().flat_map(|part| {
            let loops = simple_loops(&part.outline).into_iter();
            loops.map(|outline| (part.side, outline))
        });
        for (side, numbers) in loops {
            let outline: Vec<DVec3> = numbers.iter().map(|&i| network.points[i]).collect();
            let sheet = &self.sides.list[side].sheet;
            let done = parts::triangulate(&self.collar, sheet, &outline)?;
            let first = points.len();
            let number = |i: usize| match numbers.get(i) {
                Some(point) => *point,
                None => first + i - numbers.len(),
            };
            faces.extend(done.faces.iter().map(|f| f.map(number)));
            points.extend(done.inner);
            let new = numbers.iter().copied().chain(first..points.len());
            parts.push((side, new.filter_map(|i| i.checked_sub(rim)).collect()));
        }
        // Converts to vertex numbers: the rim's in the mesh, and new vertices after the mesh's.
        let number = |i: usize| match self.collar.rim.get(i) {
            Some(v) => *v,
            None => (count + i - rim) as u32,
        };
        let faces: Vec<[u32; 3]> = faces.iter().map(|f| f.map(number)).collect();
        // Checks the patch, and measures residuals and creases.
        self.check_joined(&faces)?;
        let residuals = network.parts.iter().map(|p| &self.sides.list[p.side].sheet);
        let residuals = residuals.map(|sheet| sheet.residual / self.collar.edge);
        let of_line = |line: &CreaseLine| {
            let at = line.points.iter().map(|&i| points[i]);
            let at: Vec<DVec3> = at.collect();
            let angle = |p: &DVec3| self.angle(*p, line.sides);
            Crease {
                length: at.windows(2).map(|w| w[0].distance(w[1])).sum(),
                angle: at.iter().map(angle).sum::<f64>() / at.len() as f64,
            }
        };
        Ok(Continued {
            positions: points[rim..]
                .iter()
                .map(|p| *p + self.collar.origin)
                .collect(),
            faces,
            is_flat: network.lines.is_empty() && self.sides.list[labels[0]].sheet.is_plane(),
            creases: network.lines.iter().map(of_line).collect(),
            residual: residuals.fold(0.0, f64::max),
            parts,
        })
    }

    /// How far the data of its sheets determine a patch.
    pub(crate) fn determined(&self, patch: &Continued) -> Determined {
        let mut determined = Determined {
            noise: 0.0,
            deviations: vec![0.0; patch.positions.len()],
        };
        for (side, new) in &patch.parts {
            let sheet = &self.sides.list[*side].sheet;
            let at = new.iter().map(|&i| patch.positions[i] - self.collar.origin);
            let own = sheet.deviations(&at.collect::<Vec<_>>(), self.collar.edge);
            for (&i, own) in new.iter().zip(own) {
                determined.deviations[i] = own.max(determined.deviations[i]);
            }
            determined.noise = (sheet.noise() / self.collar.edge).max(determined.noise);
        }
        determined
    }

    /// Checks that the faces use each edge of the rim once, and no directed edge twice.
    fn check_joined(&self, faces: &[[u32; 3]]) -> Result<(), CreaseRefusal> {
        let mut edges = FxHashSet::with_capacity_and_hasher(3 * faces.len(), FxBuildHasher);
        for f in faces {
            for (a, b) in [(f[0], f[1]), (f[1], f[2]), (f[2], f[0])] {
                if !edges.insert((a, b)) || self.taken.contains(&(a, b)) {
                    return Err(CreaseRefusal::NotManifold);
                }
            }
        }
        let rim = &self.collar.rim;
        let on_rim: FxHashSet<(u32, u32)> = (0..rim.len())
            .map(|i| (rim[i], rim[(i + 1) % rim.len()]))
            .collect();
        let is_right = |&(a, b): &(u32, u32)| match on_rim.contains(&(a, b)) {
            true => !edges.contains(&(b, a)),
            // The opposite of an inner edge belongs to the patch too, and the mesh does not have such an edge.
            false => edges.contains(&(b, a)) && !self.taken.contains(&(b, a)),
        };
        let has_all = on_rim.iter().all(|edge| edges.contains(edge));
        match has_all && edges.iter().all(is_right) {
            true => Ok(()),
            false => Err(CreaseRefusal::NotManifold),
        }
    }
}

/// The combinations of shifts of `ends` crease ends along the rim, each by up to two vertices (fewer with more ends), smallest
/// shifts first.
fn shifts(ends: usize) -> Vec<Vec<i32>> {
    let most = match ends {
        0..=3 => 2,
        4..=6 => 1,
        _ => 0,
    };
    let mut all: Vec<Vec<i32>> = vec![Vec::new()];
    for _ in 0..ends {
        let longer = |d: &Vec<i32>| {
            (-most..=most)
                .map(|x| [&d[..], &[x]].concat())
                .collect::<Vec<_>>()
        };
        all = all.iter().flat_map(longer).collect();
    }
    all.sort_by_key(|d| (d.iter().map(|x| x.abs()).sum::<i32>(), d.clone()));
    all.truncate(MOST_SHIFTS.get());
    all
}

/// Labels with their changes shifted; `None` if that removes or adds a change.
fn shifted(labels: &[usize], at: &[usize], shifts: &[i32]) -> Option<Vec<usize>> {
    let count = labels.len();
    let mut all = labels.to_vec();
    for (&i, &shift) in at.iter().zip(shifts) {
        let (before, own) = (labels[(i + count - 1) % count], labels[i]);
        let distance = shift.unsigned_abs() as usize;
        for k in 0..distance.min(count) {
            match shift > 0 {
                true => all[(i + k) % count] = before,
                false => all[(i + count - 1 - k) % count] = own,
            }
        }
    }
    (ends(&all).len() == at.len()).then_some(all)
}
