//! Tests that segments which cross, touch and overlap all become edges.

use glam::DVec3;

use super::super::exact::{Plane, Unit};
use super::*;

const SIZE: f64 = 40.0;

/// A large triangle, points of an integer grid in it, and segments between these.
fn segments() -> (Vec<DVec3>, Vec<[u32; 2]>) {
    let mut at = vec![
        DVec3::new(-SIZE, -SIZE, 0.0),
        DVec3::new(3.0 * SIZE, -SIZE, 0.0),
        DVec3::new(-SIZE, 3.0 * SIZE, 0.0),
    ];
    let mut state = 9u64;
    let mut number = |most: u64| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        ((state >> 33) % most) as f64
    };
    let mut lines: Vec<[u32; 2]> = Vec::new();
    while lines.len() < 60 {
        let ends = [0; 2].map(|_| DVec3::new(number(13), number(13), 0.0));
        if ends[0] == ends[1] {
            continue;
        }
        lines.push(ends.map(|p| {
            let known = at.iter().position(|q| *q == p);
            known.unwrap_or_else(|| {
                at.push(p);
                at.len() - 1
            }) as u32
        }));
    }
    (at, lines)
}

#[test]
fn edges_that_cross_in_many_points_are_all_there() {
    let (at, lines) = segments();
    let unit = Unit::of(at.iter().copied()).unwrap();
    let points = at.iter().map(|p| Point::vertex(unit, *p)).collect();
    let mut planar = Planar::new(2, points);
    for v in 3..at.len() as u32 {
        planar.insert(v).unwrap();
    }
    let floor = Plane::of(unit, [at[0], at[1], at[2]]);
    let plane = |l: u32| Plane::along(unit, lines[l as usize].map(|v| at[v as usize]), 2);
    let mut meet = |l, m| Point::of_planes(unit, [&floor, &plane(l), &plane(m)]);
    for (i, ends) in (0..).zip(&lines) {
        planar.enforce(*ends, i, &mut meet).unwrap();
    }
    planar.relax();
    let (mut area, mut count) = (0.0, 0);
    for t in planar.triangles() {
        assert_eq!(planar.turn(t[0], t[1], t[2]), 1);
        let [a, b, c] = t.map(|v| planar.points[v as usize].nearest);
        area += 0.5 * (b - a).cross(c - a).z;
        count += 1;
    }
    assert!((area - 8.0 * SIZE * SIZE).abs() < 1e-9 * area, "{area}");
    // By Euler's formula, with three rim vertices.
    assert_eq!(count, 2 * planar.points.len() - 5);
    // The ends of each constrained edge are on its line.
    for (h, &line) in (0..).zip(&planar.line) {
        if line != NONE {
            let ends = lines[line as usize];
            let on = |v: u32| planar.turn(ends[0], ends[1], v) == 0;
            assert!(on(planar.start(h)) && on(planar.to(h)));
        }
    }
    for [a, b] in lines {
        let mut v = a;
        while v != b {
            let Some(Way::Along(h)) = planar.way(v, b) else {
                panic!("no edge along a line");
            };
            assert_ne!(planar.line[h as usize], NONE);
            v = if planar.start(h) == v {
                planar.to(h)
            } else {
                planar.start(h)
            };
        }
    }
}
