//! The polygons of the 256 sign patterns of marching cubes (Lorensen and Cline 1987). They are traced along the
//! segments on the cell's faces, not copied from a printed table.

use std::sync::OnceLock;

/// Corners of a cell: bit 0 of the index is x, bit 1 is y, bit 2 is z.
pub(super) const CORNER: [[i32; 3]; 8] = [
    [0, 0, 0],
    [1, 0, 0],
    [0, 1, 0],
    [1, 1, 0],
    [0, 0, 1],
    [1, 0, 1],
    [0, 1, 1],
    [1, 1, 1],
];

/// The axis of each edge.
pub(super) const EDGE_AXIS: [u8; 12] = [0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2];

/// The lower corner of each edge.
pub(super) const EDGE_NODE: [u8; 12] = [0, 2, 4, 6, 0, 1, 4, 5, 0, 1, 2, 3];

/// The four corners of each face, counter-clockwise seen from outside the cell.
const FACE: [[u8; 4]; 6] = [
    [0, 4, 6, 2],
    [1, 3, 7, 5],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 2, 3, 1],
    [4, 5, 7, 6],
];

/// The faces that contain each edge, as bits.
pub(super) const EDGE_FACES: [u8; 12] = edge_faces();

const fn edge_faces() -> [u8; 12] {
    let mut bits = [0; 12];
    let mut f = 0;
    while f < 6 {
        let mut k = 0;
        while k < 4 {
            bits[edge_between(FACE[f][k], FACE[f][(k + 1) % 4])] |= 1 << f;
            k += 1;
        }
        f += 1;
    }
    bits
}

const fn edge_between(a: u8, b: u8) -> usize {
    let low = if a < b { a } else { b };
    let axis = (a ^ b).trailing_zeros() as u8;
    let mut e = 0;
    while EDGE_AXIS[e] != axis || EDGE_NODE[e] != low {
        e += 1;
    }
    e
}

/// The polygons of all sign patterns.
pub(super) struct Table {
    cases: Vec<Case>,
}

struct Case {
    /// The faces whose corners alternate in sign.
    ambiguous: Vec<u8>,
    /// The polygons for each combination of decisions; bit i: the inside corners of face `ambiguous[i]` are joined.
    variants: Vec<Vec<Vec<u8>>>,
}

impl Table {
    /// The polygons, as edge indices, of a cell with these corner values. `case` has a bit for each negative corner.
    pub(super) fn loops(&self, case: u8, corner: &[f64; 8]) -> &[Vec<u8>] {
        let case = &self.cases[case as usize];
        let mut decisions = 0;
        for (i, &f) in case.ambiguous.iter().enumerate() {
            decisions |= usize::from(joins_inside(f as usize, corner)) << i;
        }
        &case.variants[decisions]
    }

    #[cfg(test)]
    pub(super) fn variants(&self, case: u8) -> impl Iterator<Item = &[Vec<u8>]> {
        self.cases[case as usize].variants.iter().map(Vec::as_slice)
    }
}

/// The table, built on first use.
pub(super) fn table() -> &'static Table {
    static TABLE: OnceLock<Table> = OnceLock::new();
    TABLE.get_or_init(|| Table {
        cases: (0..=255).map(build_case).collect(),
    })
}

/// Whether the bilinear saddle of a face with alternating signs is negative (Nielson and Hamann 1991).
///
/// Only compares two products, which are commutative, so that both cells at the face get the same answer.
fn joins_inside(face: usize, corner: &[f64; 8]) -> bool {
    let [a, b, c, d] = FACE[face].map(|q| corner[q as usize]);
    if a < 0.0 {
        a * c > b * d
    } else {
        b * d > a * c
    }
}

fn build_case(case: u8) -> Case {
    let inside = |q: u8| case >> q & 1 == 1;
    let alternates = |f: &u8| {
        let [a, b, c, d] = FACE[*f as usize].map(inside);
        a == c && b == d && a != b
    };
    let ambiguous: Vec<u8> = (0..6).filter(alternates).collect();
    let variants = (0..1usize << ambiguous.len())
        .map(|decisions| {
            let joined = |f: u8| {
                ambiguous
                    .iter()
                    .position(|&g| g == f)
                    .is_some_and(|i| decisions >> i & 1 == 1)
            };
            trace(case, joined)
        })
        .collect();
    Case {
        ambiguous,
        variants,
    }
}

/// Follows the segments from face to face. A segment runs from the edge where the boundary of the face enters the
/// inside to the edge where it leaves it. The polygon is thus counter-clockwise seen from the positive side.
fn trace(case: u8, joined: impl Fn(u8) -> bool) -> Vec<Vec<u8>> {
    let inside = |q: u8| case >> q & 1 == 1;
    let mut next = [None; 12];
    for (f, q) in FACE.iter().enumerate() {
        let edge = |k: usize| edge_between(q[k % 4], q[(k + 1) % 4]);
        for k in 0..4 {
            let enters = !inside(q[k]) && inside(q[(k + 1) % 4]);
            if enters {
                let leaves = |m: &usize| inside(q[m % 4]) && !inside(q[(m + 1) % 4]);
                let mut exits = (k + 1..k + 4).filter(leaves);
                let first = exits.next();
                let exit = if joined(f as u8) {
                    exits.next().or(first)
                } else {
                    first
                };
                next[edge(k)] = exit.map(edge);
            }
        }
    }
    let mut loops = Vec::new();
    for start in 0..12 {
        let mut polygon = Vec::new();
        let mut at = start;
        while let Some(to) = next[at].take() {
            polygon.push(at as u8);
            at = to;
        }
        if !polygon.is_empty() {
            loops.push(polygon);
        }
    }
    loops
}
