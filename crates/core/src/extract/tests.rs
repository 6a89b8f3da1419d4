//! Tests of marching cubes: closed manifolds for all sign patterns, slabs.

use std::collections::HashMap;

use super::*;

/// A fixed pseudo-random sequence in [0, 1).
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

fn cells(n: i32) -> Vec<[i32; 3]> {
    (0..n)
        .flat_map(|z| (0..n).flat_map(move |y| (0..n).map(move |x| [x, y, z])))
        .collect()
}

fn assert_closed_manifold(s: &IsoSurface) {
    let mut directed = HashMap::new();
    for f in &s.faces {
        assert!(f[0] != f[1] && f[1] != f[2] && f[2] != f[0]);
        for k in 0..3 {
            *directed.entry((f[k], f[(k + 1) % 3])).or_insert(0) += 1;
        }
    }
    for (&(a, b), &n) in &directed {
        assert_eq!(n, 1, "directed edge {a} {b}");
        assert!(directed.contains_key(&(b, a)), "open edge {a} {b}");
    }
    let mut link = vec![HashMap::new(); s.positions.len()];
    for f in &s.faces {
        for k in 0..3 {
            link[f[k] as usize].insert(f[(k + 1) % 3], f[(k + 2) % 3]);
        }
    }
    for l in &link {
        let start = *l.keys().next().expect("vertex without face");
        let (mut at, mut steps) = (start, 0);
        loop {
            at = l[&at];
            steps += 1;
            if at == start {
                break;
            }
        }
        assert_eq!(steps, l.len(), "vertex link is not one cycle");
    }
}

/// A field with the given values inside the box and positive values on its boundary.
fn closed_field(n: i32, mut inner: impl FnMut([i32; 3]) -> f64) -> HashMap<[i32; 3], f64> {
    let mut field = HashMap::new();
    for p in cells(n + 1) {
        let on_boundary = p.iter().any(|&c| c == 0 || c == n);
        field.insert(p, if on_boundary { 1.0 } else { inner(p) });
    }
    field
}

#[test]
fn every_sign_pattern_is_a_closed_manifold() {
    let mut noise = Noise(1);
    for case in 0..=255u8 {
        for _ in 0..16 {
            let field = closed_field(5, |p| {
                let q = [p[0] - 2, p[1] - 2, p[2] - 2];
                let size = 0.05 + noise.next();
                if q.iter().all(|&c| c == 0 || c == 1) {
                    let bit = q[0] + 2 * q[1] + 4 * q[2];
                    if case >> bit & 1 == 1 { -size } else { size }
                } else {
                    size
                }
            });
            assert_closed_manifold(&marching_cubes(&cells(5), |p| field[&p]));
        }
    }
}

#[test]
fn every_polygon_has_a_triangulation_within_its_cell() {
    for case in 1..255u8 {
        for loops in table().variants(case) {
            let corners: usize = loops.iter().map(Vec::len).sum();
            let cut = (0..12).filter(|&e| {
                let (a, axis) = (EDGE_NODE[e], EDGE_AXIS[e]);
                (case >> a & 1) != (case >> (a | 1 << axis) & 1)
            });
            assert_eq!(corners, cut.count());
            assert!(loops.iter().all(|l| (3..=12).contains(&l.len())));
        }
    }
}

#[test]
fn random_fields_are_closed_manifolds() {
    let mut noise = Noise(7);
    for round in 0..60 {
        let field = closed_field(9, |_| match round % 3 {
            0 => noise.next() - 0.5,
            // Many nodes exactly at the level.
            1 => (noise.next() * 3.0).floor() - 1.0,
            _ => noise.next() - 0.8,
        });
        let s = marching_cubes(&cells(9), |p| field[&p]);
        assert_closed_manifold(&s);
        assert_eq!(s.positions.len(), s.edges.len());
        let mut all = cells(9);
        all.reverse();
        let reversed = marching_cubes(&all, |p| field[&p]);
        assert_eq!(reversed.faces.len(), s.faces.len());
    }
}

#[test]
fn sphere_has_the_right_volume_and_orientation() {
    let (r, c) = (6.3, DVec3::new(8.1, 7.9, 8.3));
    let value = |p: [i32; 3]| (DVec3::new(p[0].into(), p[1].into(), p[2].into()) - c).length() - r;
    let s = marching_cubes(&cells(16), value);
    assert_closed_manifold(&s);
    let at = |i: u32| s.positions[i as usize] - c;
    let volume: f64 = s
        .faces
        .iter()
        .map(|f| at(f[0]).dot(at(f[1]).cross(at(f[2]))) / 6.0)
        .sum();
    let exact = 4.0 / 3.0 * std::f64::consts::PI * r.powi(3);
    assert!(
        (volume / exact - 1.0).abs() < 0.02,
        "{volume} against {exact}"
    );
    assert_eq!(s.positions.len() as i64 - s.faces.len() as i64 / 2, 2);
}

#[test]
fn visits_only_the_given_cells() {
    let value = |p: [i32; 3]| f64::from(p[2]) - 0.5;
    let s = marching_cubes(&[[0, 0, 0], [5, 5, 0], [3, 3, 3]], value);
    assert_eq!((s.positions.len(), s.faces.len()), (8, 4));
    for f in &s.faces {
        let [a, b, c] = f.map(|i| s.positions[i as usize]);
        assert!((b - a).cross(c - a).z > 0.0);
    }
}

#[test]
fn values_that_are_not_numbers_do_not_panic() {
    let s = marching_cubes(&cells(4), |p| if p == [2, 2, 2] { -1.0 } else { f64::NAN });
    assert!(s.positions.iter().all(|p| p.is_finite()));
}

#[test]
fn slabs_make_what_single_cells_make() {
    let mut noise = Noise(11);
    // Zeros, integers and plain noise; thin boxes, and boxes with more layers than a slab.
    for (dims, round) in [
        ([9, 7, 21], 0.0),
        ([6, 11, 18], 1.0),
        ([2, 5, 9], 1.0),
        ([5, 2, 2], 0.0),
    ] {
        let [nx, ny, nz] = dims;
        let values: Vec<f64> = (0..nx * ny * nz)
            .map(|_| 6.0 * noise.next() - 3.0)
            .map(|v| if round > 0.0 { v.round() } else { v })
            .collect();
        let plane = |k: usize, out: &mut [f64]| {
            out.copy_from_slice(&values[k * nx * ny..][..nx * ny]);
            true
        };
        let nodes = dense::Nodes {
            dims,
            shift: -1,
            plane: &plane,
        };
        let (positions, faces) = dense::surface(&nodes).unwrap();
        let cells: Vec<[i32; 3]> = (0..nz - 1)
            .flat_map(|k| (0..ny - 1).flat_map(move |j| (0..nx - 1).map(move |i| [i, j, k])))
            .map(|cell| cell.map(|n| n as i32 - 1))
            .collect();
        let single = marching_cubes(&cells, |n| {
            let [i, j, k] = n.map(|n| (n + 1) as usize);
            values[(k * ny + j) * nx + i]
        });
        assert!(!faces.is_empty());
        assert_eq!((positions, faces), (single.positions, single.faces));
    }
}
