//! Tests of rim triangulations without self-intersections.

use super::*;

/// The corners of a square, two of them raised, and small triangles at the given heights above the intersection of the diagonals.
fn square(heights: &[f64]) -> Mesh {
    let p = DVec3::new;
    let mut positions = vec![
        p(-1.0, -1.0, 0.0),
        p(1.0, -1.0, 1.0),
        p(1.0, 1.0, 0.0),
        p(-1.0, 1.0, 1.0),
    ];
    let mut faces = Vec::new();
    for z in heights {
        let first = positions.len() as u32;
        positions.extend([
            p(-0.1, 0.02, z - 0.1),
            p(0.1, 0.03, z - 0.1),
            p(0.0, 0.01, z + 0.1),
        ]);
        faces.push([first, first + 1, first + 2]);
    }
    Mesh::new(positions, faces)
}

#[test]
fn a_triangulation_goes_round_what_is_in_the_way() {
    let rim = [0, 1, 2, 3];
    let closed = |heights: &[f64]| {
        let mesh = square(heights);
        let found = Inspection::new(&mesh).unwrap();
        Ground::new(&found).close(&rim)
    };
    let has = |faces: &[[u32; 3]], a, b| faces.iter().all(|f| f.contains(&a) && f.contains(&b));
    assert!(has(&closed(&[0.0]).unwrap(), 1, 3));
    assert!(has(&closed(&[1.0]).unwrap(), 0, 2));
    assert_eq!(closed(&[0.0, 1.0]), None);
}

#[test]
fn long_rims_are_closed_and_new_faces_cross_no_earlier_ones() {
    let n = 700;
    let at = |i: u32, z: f64| {
        let angle = f64::from(i) / f64::from(n) * std::f64::consts::TAU;
        DVec3::new(angle.cos(), angle.sin(), z + 0.2 * (3.0 * angle).cos())
    };
    let needle = [at(0, 9.0), at(1, 9.0), at(2, 9.0)];
    let rims = (0..n)
        .map(|i| at(i, 0.0))
        .chain((0..n).map(|i| at(i, 0.01)));
    let positions: Vec<DVec3> = rims.chain(needle).collect();
    let mesh = Mesh::new(positions.clone(), vec![[2 * n, 2 * n + 1, 2 * n + 2]]);
    let found = Inspection::new(&mesh).unwrap();
    let mut ground = Ground::new(&found);
    let mut all = Vec::new();
    for rim in [0..n, n..2 * n] {
        let rim: Vec<u32> = rim.collect();
        let faces = ground.close(&rim).expect("a triangulation");
        assert_eq!(faces.len(), n as usize - 2);
        all.extend(faces);
    }
    assert_eq!(intersecting(&positions, &all, all.len()), []);
    let unlike = Mesh::new(positions, all);
    assert_eq!(
        Inspection::new(&unlike)
            .unwrap()
            .topology
            .non_manifold_edges(&unlike)
            .len(),
        0
    );
}

#[test]
fn a_triangulation_after_some_were_ruled_out_is_the_one_found_anew() {
    let n = 24;
    let at = |i: u32| {
        let angle = f64::from(i) / f64::from(n) * std::f64::consts::TAU;
        DVec3::new(angle.cos(), 1.3 * angle.sin(), (5.0 * angle).sin())
    };
    let positions = (0..n).map(at).collect();
    let mesh = Mesh::new(positions, vec![[0, 1, 2]]);
    let found = Inspection::new(&mesh).unwrap();
    let ground = Ground::new(&found);
    let ring: Vec<u32> = (0..n).collect();
    let mut table = RimTable::new(&ground, &ring);
    let mut ruled_out = Vec::new();
    for round in 0.. {
        let triangles = table.solve();
        let mut anew = RimTable::new(&ground, &ring);
        ruled_out.iter().for_each(|t| anew.set_crossing(*t));
        assert_eq!(anew.solve(), triangles);
        let Some(triangles) = triangles else {
            assert!(round > 5, "{round}");
            break;
        };
        for t in triangles.iter().step_by(3 + round % 5) {
            table.set_crossing(*t);
            ruled_out.push(*t);
        }
    }
}
