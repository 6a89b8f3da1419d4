//! Zipping: a ring of triangles between two adjacent closed polylines.

use glam::DVec3;

use super::sector::{Outline, nearest_pair};
use crate::tuning::{Tunable, tunable};

/// Cells. Of a larger table only a strip is searched.
const FULL_TABLE: Tunable<usize> = tunable("stitch.full_table", 8_000_000);

/// Inner vertices. Least half-width of the strip.
const STRIP: Tunable<usize> = tunable("stitch.strip", 256);

/// Triangles whose cosine to the surface normal is below this are penalised.
const TILT_COSINE: Tunable<f64> = tunable("stitch.tilt_cosine", 0.5);

/// Weight of the difference between their cosine and `TILT_COSINE`.
const TILT_WEIGHT: Tunable<f64> = tunable("stitch.tilt_weight", 40.0);

/// Weight of an edge that leaves the gap.
const ASTRAY_WEIGHT: Tunable<f64> = tunable("stitch.astray_weight", 20.0);

/// One triangle of the ring.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// Rim vertices `i`, `i + 1` and inner vertex `j`.
    Rim(usize, usize),
    /// Rim vertex `i` and inner vertices `j`, `j - 1`.
    Inner(usize, usize),
}

const ADVANCE_RIM: u8 = 1;
const ADVANCE_INNER: u8 = 2;

/// The triangles of the ring between two loops of vertices, whose outlines are `rim` and `inner`; see [`zip`].
pub(super) fn ring(loops: [&[u32]; 2], [rim, inner]: [&Outline; 2]) -> Vec<[u32; 3]> {
    let [a, b] = loops;
    let (n, m) = (a.len(), b.len());
    let face = |step| match step {
        Step::Rim(i, j) => [a[i], a[(i + 1) % n], b[j]],
        Step::Inner(i, j) => [a[i], b[(j + m - 1) % m], b[j]],
    };
    zip(rim, inner).into_iter().map(face).collect()
}

/// The ring of triangles between `rim` and `inner`, which both have the ring on their left and so run in opposite directions.
///
/// Dynamic programming over all pairs of vertices: minimises the sum of the squared lengths of the edges across, with penalties
/// for triangles tilted away from the surface normal and for edges outside the gap. Starts at the closest pair whose edge is in
/// the gap.
pub(super) fn zip(rim: &Outline, inner: &Outline) -> Vec<Step> {
    let (n, m) = (rim.len(), inner.len());
    let (_, i0, j0) = nearest_pair(rim, inner, f64::INFINITY).unwrap_or((0.0, 0, 0));
    let table = Table {
        rim,
        inner,
        n,
        m,
        i0,
        j0,
        half: half_width(n, m),
    };
    let mut steps = table.trace(&table.fill());
    steps.reverse();
    steps
}

/// Half the width of the strip of the table that is computed, in columns; the whole table if it is small.
fn half_width(n: usize, m: usize) -> usize {
    if n * m <= FULL_TABLE.get() {
        m
    } else {
        STRIP.get().max(m / 10).max(2 * m / n)
    }
}

/// The table of the dynamic programme: rim vertices by rows, inner vertices by columns, from the start pair on.
struct Table<'a> {
    rim: &'a Outline,
    inner: &'a Outline,
    n: usize,
    m: usize,
    i0: usize,
    j0: usize,
    half: usize,
}

impl Table<'_> {
    /// The first and last column computed in a row.
    fn row(&self, i: usize) -> (usize, usize) {
        let middle = i * self.m / self.n;
        (
            middle.saturating_sub(self.half),
            (middle + self.half).min(self.m),
        )
    }

    /// For each pair of vertices, the step that leads to it at the lowest cost.
    fn fill(&self) -> Vec<Vec<u8>> {
        let mut rows = Vec::with_capacity(self.n + 1);
        let mut above = vec![f64::INFINITY; self.m + 1];
        let mut cost = vec![f64::INFINITY; self.m + 1];
        for i in 0..=self.n {
            let (low, high) = self.row(i);
            let mut steps = vec![0; high - low + 1];
            cost.fill(f64::INFINITY);
            for j in low..=high {
                let forbidden = (i == 0 && j == self.m) || (i == self.n && j == 0);
                if i == 0 && j == 0 {
                    cost[0] = 0.0;
                } else if !forbidden {
                    let across = self.across(i, j);
                    let by_rim = if i > 0 {
                        above[j] + self.tilt_rim(i - 1, j)
                    } else {
                        f64::INFINITY
                    };
                    let by_inner = if j > low {
                        cost[j - 1] + self.tilt_inner(i, j - 1)
                    } else {
                        f64::INFINITY
                    };
                    cost[j] = by_rim.min(by_inner) + across;
                    steps[j - low] = if by_rim <= by_inner {
                        ADVANCE_RIM
                    } else {
                        ADVANCE_INNER
                    };
                }
            }
            std::mem::swap(&mut above, &mut cost);
            rows.push(steps);
        }
        rows
    }

    /// The steps from the last pair back to the first.
    fn trace(&self, rows: &[Vec<u8>]) -> Vec<Step> {
        let mut steps = Vec::with_capacity(self.n + self.m);
        let (mut i, mut j) = (self.n, self.m);
        while i > 0 || j > 0 {
            let (low, _) = self.row(i);
            let step = if i == 0 {
                ADVANCE_INNER
            } else if j <= low {
                ADVANCE_RIM
            } else {
                rows[i][j - low]
            };
            if step == ADVANCE_RIM {
                i -= 1;
                steps.push(Step::Rim(self.rim_index(i), self.inner_index(j)));
            } else {
                j -= 1;
                steps.push(Step::Inner(self.rim_index(i), self.inner_index(j)));
            }
        }
        steps
    }

    /// Index in the rim loop of the `i`th vertex of the walk.
    fn rim_index(&self, i: usize) -> usize {
        (self.i0 + i) % self.n
    }

    /// Index in the inner loop of the `j`th vertex of the walk, which goes backwards.
    fn inner_index(&self, j: usize) -> usize {
        (self.j0 + 2 * self.m - j) % self.m
    }

    /// Position and normal of the `i`th rim vertex of the walk.
    fn r(&self, i: usize) -> (DVec3, DVec3) {
        let k = self.rim_index(i);
        (self.rim.position[k], self.rim.normal[k])
    }

    /// Position and normal of the `j`th inner vertex of the walk.
    fn k(&self, j: usize) -> (DVec3, DVec3) {
        let k = self.inner_index(j);
        (self.inner.position[k], self.inner.normal[k])
    }

    /// The cost of an edge across.
    fn across(&self, i: usize, j: usize) -> f64 {
        let (p, q) = (self.r(i).0, self.k(j).0);
        let from_rim = self.rim.opens_towards(self.rim_index(i), q);
        let from_inner = self.inner.opens_towards(self.inner_index(j), p);
        let outside = f64::from(u8::from(!from_rim)) + f64::from(u8::from(!from_inner));
        p.distance_squared(q) * (1.0 + ASTRAY_WEIGHT.get() * outside)
    }

    fn tilt_rim(&self, i: usize, j: usize) -> f64 {
        tilt(self.r(i), self.r(i + 1), self.k(j))
    }

    fn tilt_inner(&self, i: usize, j: usize) -> f64 {
        tilt(self.r(i), self.k(j + 1), self.k(j))
    }
}

/// The penalty of a triangle whose normal is far from the mean of its corner normals.
fn tilt(a: (DVec3, DVec3), b: (DVec3, DVec3), c: (DVec3, DVec3)) -> f64 {
    let (u, v) = (b.0 - a.0, c.0 - a.0);
    let cross = u.cross(v);
    let normal = (a.1 + b.1 + c.1).normalize_or_zero();
    let longest = u
        .length_squared()
        .max(v.length_squared())
        .max((c.0 - b.0).length_squared());
    let cosine = cross.normalize_or_zero().dot(normal);
    if cosine >= TILT_COSINE.get() {
        0.0
    } else {
        TILT_WEIGHT.get() * (TILT_COSINE.get() - cosine) * longest
    }
}
