//! What a repair tries first: joining cracks, closing holes with one obvious closure, uniting bodies; and a verdict that is true of the
//! shape.

use crate::repair_union::repaired;
use crate::shapes::{Noise, cube, cut, joined, moved, sphere, turned, volume};
use glam::DVec3;
use isomend::check::{CheckParams, DefectKind};
use isomend::{Carried, Control, Mesh, RepairParams, Repaired, inspect, repair};

fn repaired_with(mesh: &Mesh, params: &RepairParams) -> Repaired {
    repair(mesh, params, &Carried::default(), &Control::new()).unwrap()
}

/// Whether a mesh is sound as a check sees it.
fn is_sound(mesh: &Mesh) -> bool {
    inspect(mesh)
        .unwrap()
        .check(&CheckParams::default())
        .is_sound()
}

/// A box of size `size`, its sides divided into squares.
fn block(size: DVec3, at: DVec3, n: i32) -> Mesh {
    let mut mesh = cube(n);
    for p in &mut mesh.positions {
        *p = at + *p / f64::from(n) * size;
    }
    mesh
}

fn without(mesh: &Mesh, face: usize) -> Mesh {
    let mut faces = mesh.faces.clone();
    faces.remove(face);
    Mesh::new(mesh.positions.clone(), faces)
}

/// The mesh with all faces turned over.
pub fn reversed(mesh: &Mesh) -> Mesh {
    let mut mesh = mesh.clone();
    mesh.faces.iter_mut().for_each(|f| f.swap(1, 2));
    mesh
}

/// The mesh torn along its sharp edges: each flat side is a sheet of its own, moved by up to `width`, and some boundary edges are split
/// at a vertex that is moved too.
fn cracked(mesh: &Mesh, width: f64, random: &mut Noise) -> Mesh {
    let normal = |f: &[u32; 3]| {
        let [a, b, c] = f.map(|v| mesh.positions[v as usize]);
        (b - a).cross(c - a).normalize_or_zero()
    };
    let mut sides: Vec<(DVec3, f64, Vec<usize>)> = Vec::new();
    for (i, f) in mesh.faces.iter().enumerate() {
        let (n, p) = (normal(f), mesh.positions[f[0] as usize]);
        let is_of = |s: &&mut (DVec3, f64, Vec<usize>)| {
            s.0.dot(n) > 0.999_999 && (s.1 - n.dot(p)).abs() < 1e-6
        };
        match sides.iter_mut().find(is_of) {
            Some(side) => side.2.push(i),
            None => sides.push((n, n.dot(p), vec![i])),
        }
    }
    let mut torn = Mesh::default();
    for (_, _, faces) in &sides {
        let mut number = std::collections::HashMap::new();
        let part = Mesh::new(
            mesh.positions.clone(),
            faces.iter().map(|f| mesh.faces[*f]).collect(),
        );
        for f in &part.faces {
            let own = f.map(|v| {
                *number.entry(v).or_insert_with(|| {
                    torn.positions
                        .push(mesh.positions[v as usize] + width * 0.5 * random.vector());
                    torn.positions.len() as u32 - 1
                })
            });
            // One in four faces is split at the middle of its first edge: a T-junction for the face beyond it.
            if random.next() < -0.5 {
                let [a, b, c] = own;
                let [p, q] = [a, b].map(|v| torn.positions[v as usize]);
                torn.positions
                    .push(0.5 * (p + q) + 0.25 * width * random.vector());
                let m = torn.positions.len() as u32 - 1;
                torn.faces.extend([[a, m, c], [m, b, c]]);
            } else {
                torn.faces.push(own);
            }
        }
    }
    torn
}

/// Unions of boxes with a known volume: the sum over the cells between all their planes.
fn heap(random: &mut Noise) -> (Mesh, f64) {
    let boxes: Vec<[DVec3; 2]> = (0..4)
        .map(|_| {
            let low = 2.0 * random.vector().abs();
            [low, low + 1.0 + 2.0 * random.vector().abs()]
        })
        .collect();
    let planes = |k: usize| {
        let mut all: Vec<f64> = boxes.iter().flatten().map(|p| p[k]).collect();
        all.sort_by(f64::total_cmp);
        all
    };
    let [xs, ys, zs] = [0, 1, 2].map(planes);
    let mut truth = 0.0;
    for x in xs.windows(2) {
        for y in ys.windows(2) {
            for z in zs.windows(2) {
                let middle = 0.5 * DVec3::new(x[0] + x[1], y[0] + y[1], z[0] + z[1]);
                let is_in = |b: &[DVec3; 2]| b[0].cmplt(middle).all() && b[1].cmpgt(middle).all();
                if boxes.iter().any(is_in) {
                    truth += (x[1] - x[0]) * (y[1] - y[0]) * (z[1] - z[0]);
                }
            }
        }
    }
    let all = boxes.iter().map(|[low, high]| block(*high - *low, *low, 1));
    let all = all.reduce(|a, b| joined(&a, &b)).unwrap();
    (all, truth)
}

#[test]
fn cracked_solids_are_joined_without_new_surface() {
    for seed in 0..6 {
        let mut random = Noise(0x9e37_79b9 + seed);
        let (boxes, truth) = heap(&mut random);
        let solid = repaired(&boxes).mesh;
        assert!((volume(&solid) / truth - 1.0).abs() < 1e-9);
        for width in [1e-7, 1e-5, 3e-4] {
            let torn = cracked(&turned(solid.clone()), width, &mut random);
            let done = repaired(&torn);
            let error = volume(&done.mesh) / truth - 1.0;
            assert!(error.abs() < 1e-3, "{seed} {width:e}: {error:e}");
            assert!(is_sound(&done.mesh), "{seed} {width:e}");
            let patches: usize = done.fill.regions.iter().map(|r| r.new_vertices).sum();
            assert_eq!(patches, 0, "{seed} {width:e}");
        }
    }
}

#[test]
fn bodies_with_a_missing_triangle_take_part_in_a_union() {
    let overlapping = |a: Mesh, b: Mesh| turned(joined(&a, &b));
    let large = block(DVec3::new(3.0, 2.0, 2.0), DVec3::ZERO, 1);
    let small = block(DVec3::new(1.0, 1.0, 4.0), DVec3::new(1.0, 0.5, -1.0), 1);
    for face in 0..12 {
        let done = repaired(&overlapping(without(&large, face), small.clone()));
        let truth = 12.0 + 4.0 - 2.0;
        assert!(
            (volume(&done.mesh) - truth).abs() < 1e-9,
            "face {face}: {}",
            volume(&done.mesh)
        );
        assert!(is_sound(&done.mesh) && done.report.doubt.is_none());
    }
}

#[test]
fn bodies_that_share_sides_are_one_body() {
    let at = |x: f64| block(DVec3::ONE, DVec3::new(x, 0.0, 0.0), 2);
    let knob = block(DVec3::splat(0.4), DVec3::new(0.8, 0.3, 0.8), 2);
    let row = |middle: &Mesh| joined(&joined(&at(0.0), middle), &joined(&at(2.0), &knob));
    let beam = row(&at(1.0));
    let whole = 3.0 + 0.2 * 0.4 * 0.4;
    let shared = |mesh: &Mesh| -> Vec<usize> {
        let lies = |f: &[u32; 3]| f.iter().all(|v| mesh.positions[*v as usize].x == 1.0);
        (0..mesh.faces.len())
            .filter(|f| lies(&mesh.faces[*f]))
            .collect()
    };
    // As they are; one face of a shared side missing, where no boundary shows it; one of the bodies inside out.
    let lacking = without(&beam, shared(&beam)[3]);
    let mixed = row(&reversed(&at(1.0)));
    for (name, mesh) in [("shared", beam), ("lacking", lacking), ("mixed", mixed)] {
        let done = repaired(&mesh);
        assert!(is_sound(&done.mesh), "{name}");
        assert!(
            (volume(&done.mesh) - whole).abs() < 1e-9,
            "{name}: {}",
            volume(&done.mesh)
        );
        assert_eq!(done.report.doubt, None, "{name}");
        assert_eq!(
            done.report.steps.closing_faces,
            usize::from(name == "lacking"),
            "{name}"
        );
    }
}

#[test]
fn bodies_with_wide_holes_are_united_before_these_are_filled() {
    let (a, b) = (
        sphere(8),
        moved(&sphere(8), 1.0, DVec3::new(1.2, 0.1, 0.05)),
    );
    let whole = volume(&repaired(&joined(&a, &b)).mesh);
    let far = |p: DVec3| p.x < -0.9;
    let open = joined(&cut(&a, far), &b);
    let done = repaired(&open);
    assert!(is_sound(&done.mesh));
    assert!(
        (volume(&done.mesh) / whole - 1.0).abs() < 2e-3,
        "{} for {whole}",
        volume(&done.mesh)
    );
    assert_eq!(done.report.doubt, None);
    assert!(done.report.steps.intersection_passes.is_empty());
}

#[test]
fn an_open_box_and_the_lid_that_overlaps_it_are_one_body() {
    let open = cut(&block(DVec3::ONE * 2.0, DVec3::ZERO, 1), |p| p.z > 1.9);
    let lid = block(DVec3::new(2.4, 2.4, 0.5), DVec3::new(-0.2, -0.2, 1.8), 1);
    let done = repaired(&turned(joined(&open, &lid)));
    let truth = 8.0 + 2.4 * 2.4 * 0.5 - 2.0 * 2.0 * 0.2;
    assert!(
        (volume(&done.mesh) / truth - 1.0).abs() < 1e-9,
        "{}",
        volume(&done.mesh)
    );
    assert!(is_sound(&done.mesh));
}

#[test]
fn cavities_stay_cavities() {
    let outer = block(DVec3::ONE * 2.0, DVec3::ZERO, 3);
    let inner = reversed(&block(DVec3::ONE, DVec3::ONE * 0.4, 2));
    let hollow = joined(&outer, &inner);
    // Inside out as a whole, and with an outer triangle missing.
    for mesh in [
        hollow.clone(),
        reversed(&hollow),
        without(&hollow, 5),
        reversed(&without(&hollow, 5)),
    ] {
        let done = repaired(&turned(mesh));
        assert!(
            (volume(&done.mesh) - 7.0).abs() < 1e-9,
            "{}",
            volume(&done.mesh)
        );
        assert!(is_sound(&done.mesh));
    }
    let open = inspect(&without(&hollow, 5))
        .unwrap()
        .check(&CheckParams::default());
    assert_eq!(open.count(DefectKind::InsideOut), 0);
    // The cavity of a sound body is not removed as a component inside another; a body inside another is.
    let dropped = |mesh: &Mesh| {
        volume(&repaired_with(mesh, &RepairParams::new().with_drop_inside(true)).mesh)
    };
    assert!((dropped(&hollow) - 7.0).abs() < 1e-9);
    assert!((dropped(&joined(&outer, &reversed(&inner))) - 8.0).abs() < 1e-9);
}

#[test]
fn a_sheet_inside_a_solid_goes_and_the_solid_stays() {
    let solid = block(DVec3::new(3.0, 2.0, 2.0), DVec3::ZERO, 2);
    // A partition whose border lies on the walls, and one that floats.
    for margin in [0.0, 0.3] {
        let (low, high) = (margin, 2.0 - margin);
        let corners = [(low, low), (high, low), (high, high), (low, high)];
        let wall = Mesh::new(
            corners
                .iter()
                .map(|(y, z)| DVec3::new(1.3, *y, *z))
                .collect(),
            vec![[0, 1, 2], [0, 2, 3]],
        );
        let done = repaired(&joined(&solid, &wall));
        assert_eq!(done.mesh.faces, solid.faces, "margin {margin}");
        assert!((volume(&done.mesh) - 12.0).abs() < 1e-9);
        assert!(is_sound(&done.mesh) && done.report.doubt.is_none());
    }
}

#[test]
fn the_missing_flat_side_of_a_prism_is_flat() {
    let prism = |sides: u32| {
        let mut mesh = Mesh::default();
        for z in [0.0, 1.5] {
            for i in 0..sides {
                let t = std::f64::consts::TAU * f64::from(i) / f64::from(sides);
                mesh.positions.push(DVec3::new(t.cos(), t.sin(), z));
            }
        }
        for i in 0..sides {
            let (a, b) = (i, (i + 1) % sides);
            mesh.faces
                .extend([[a, b, b + sides], [a, b + sides, a + sides]]);
            if i > 1 {
                mesh.faces.push([0, i, i - 1]);
            }
        }
        mesh
    };
    for sides in [5, 6, 8, 24] {
        let open = turned(prism(sides));
        let t = std::f64::consts::TAU / f64::from(sides);
        let truth = 1.5 * 0.5 * f64::from(sides) * t.sin();
        let done = repaired(&open);
        assert!(
            (volume(&done.mesh) / truth - 1.0).abs() < 1e-6,
            "{sides}: {}",
            volume(&done.mesh)
        );
    }
    // A tube between two boxes: both rims of its open end are closed by one face with a hole.
    let outer = cut(&block(DVec3::new(4.0, 4.0, 2.0), DVec3::ZERO, 4), |p| {
        p.z > 1.99
    });
    let inner = cut(
        &block(DVec3::new(2.0, 2.0, 1.5), DVec3::new(1.0, 1.0, 0.5), 4),
        |p| p.z > 1.99,
    );
    let ring = joined(&outer, &reversed(&inner));
    let done = repaired(&turned(ring));
    assert!(
        (volume(&done.mesh) - (32.0 - 6.0)).abs() < 1e-9,
        "{}",
        volume(&done.mesh)
    );
    assert!(is_sound(&done.mesh));
    // A ball that was cut through its middle is round.
    let half = cut(&sphere(8), |p| p.z > 0.0);
    let done = repaired(&half);
    assert!(
        volume(&done.mesh) > 0.95 * volume(&sphere(8)),
        "{}",
        volume(&done.mesh)
    );
}

#[test]
fn the_border_of_a_sheet_stays_open_where_faces_are_cut_out_at_it() {
    let n = 16;
    let mut sheet = Mesh::default();
    for i in 0..=n {
        for j in 0..=n {
            let (x, y) = (f64::from(i), f64::from(j));
            sheet
                .positions
                .push(DVec3::new(x, y, 0.3 * (0.4 * x).sin() * (0.5 * y).cos()));
        }
    }
    for i in 0..n as u32 {
        for j in 0..n as u32 {
            let a = i * (n as u32 + 1) + j;
            let b = a + n as u32 + 1;
            sheet.faces.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
        }
    }
    // A fold: one vertex near the border is pulled through the peak that another one makes.
    let at = |i: usize| i * (n as usize + 1) + 1;
    sheet.positions[at(8)] += DVec3::new(2.4, 0.1, 0.4);
    sheet.positions[at(10)] += DVec3::Z * 0.9;
    let before = inspect(&sheet).unwrap();
    assert!(
        before
            .check(&CheckParams::default())
            .count(DefectKind::SelfIntersection)
            > 0
    );
    let done = repaired(&sheet);
    let after = inspect(&done.mesh).unwrap();
    assert_eq!(
        after
            .check(&CheckParams::default())
            .count(DefectKind::SelfIntersection),
        0
    );
    assert_eq!(after.holes.len(), 1);
    assert!(after.holes[0].outer_boundary && after.holes[0].diameter > 20.0);
    assert!(done.mesh.faces.len() < 2 * sheet.faces.len());
}

#[test]
fn a_closed_result_of_another_shape_is_doubtful() {
    // Thin crossed plates, open at all their edges: what intersects is most of them.
    let plate = cut(&block(DVec3::new(4.0, 4.0, 0.2), DVec3::ZERO, 8), |p| {
        p.x > 3.99
    });
    let ball = sphere(5);
    let mut rough = ball.clone();
    let mut random = Noise(77);
    for p in &mut rough.positions {
        *p += 0.6 * random.vector();
    }
    let cut_open = cut(&rough, |p| p.z > 0.6);
    let mut doubtful = 0;
    for mesh in [
        cut_open,
        joined(&plate, &moved(&plate, 1.0, DVec3::new(1.0, 1.0, 0.1))),
    ] {
        let done = repaired(&mesh);
        let loses = done.report.lost_faces as f64 > 0.2 * mesh.faces.len() as f64;
        let intersects = inspect(&done.mesh).unwrap().check(&CheckParams::default());
        let said = done.report.doubt.is_some() || !intersects.is_sound();
        assert!(
            !loses || said,
            "{} faces lost without a word",
            done.report.lost_faces
        );
        doubtful += usize::from(done.report.doubt.is_some());
    }
    assert!(doubtful > 0);
}

#[test]
fn a_cut_by_a_plane_is_flat_and_balls_beside_each_other_are_round() {
    // A bent tube without its ends, whose two rims lie in one plane.
    let n = 24;
    let at = |i: u32, j: u32| {
        let t = std::f64::consts::PI * f64::from(i) / f64::from(n);
        let s = std::f64::consts::TAU * f64::from(j) / f64::from(n);
        let r = 2.0 + (0.6 + 0.2 * t.sin()) * s.cos();
        DVec3::new(r * t.cos(), (0.6 + 0.2 * t.sin()) * s.sin(), r * t.sin())
    };
    let mut tube = Mesh::default();
    for (i, j) in (0..=n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        tube.positions.push(at(i, j));
    }
    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let [a, b] = [i * n + j, i * n + (j + 1) % n];
        tube.faces.extend([[a, b + n, b], [a, a + n, b + n]]);
    }
    let done = repaired(&turned(tube.clone()));
    assert!(is_sound(&done.mesh));
    let below = |mesh: &Mesh| {
        mesh.positions
            .iter()
            .map(|p| p.z)
            .fold(f64::INFINITY, f64::min)
    };
    assert!(below(&repaired(&tube).mesh) > -1e-6);
    // The same gap in two balls of one height is round in both.
    let open = cut(&sphere(8), |p| p.z > 0.5);
    let pair = joined(&open, &moved(&open, 1.0, DVec3::X * 3.0));
    let truth = 2.0 * volume(&sphere(8));
    let filled = volume(&repaired(&pair).mesh);
    assert!((filled / truth - 1.0).abs() < 0.02, "{filled} {truth}");
}
