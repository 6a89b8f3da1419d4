//! `isomend repair` removes defects added to sound meshes, and keeps all other faces bit for bit.

use std::collections::HashSet;

use crate::desk::{self, Desk, assert_code, text};
use crate::repair_union::verdict;
use crate::shapes::{cut, joined, moved, polar, sphere, torus, turned};
use glam::DVec3;
use isomend::check::DefectKind;
use isomend::io::{Format, read_path};
use isomend::{
    Cancel, Carried, Control, FillError, Mesh, RepairParams, RepairStep, Repaired, repair,
};

fn repaired(mesh: &Mesh, params: &RepairParams) -> Repaired {
    repair(mesh, params, &Carried::default(), &Control::new()).unwrap()
}

#[track_caller]
fn assert_sound(mesh: &Mesh) {
    let verdict = verdict(mesh);
    assert!(verdict.is_sound(), "{}", verdict.line());
}

/// A sound mesh: a ball with bumps, in general position.
fn good() -> Mesh {
    let mut mesh = turned(sphere(8));
    for p in &mut mesh.positions {
        *p *= 1.0 + 0.05 * (5.0 * p.x).sin() * (4.0 * p.y).cos();
    }
    mesh
}

fn centre(mesh: &Mesh, face: &[u32; 3]) -> DVec3 {
    face.iter()
        .map(|v| mesh.positions[*v as usize])
        .sum::<DVec3>()
        / 3.0
}

type Corners = [[u64; 3]; 3];

fn corners(mesh: &Mesh, face: &[u32; 3]) -> Corners {
    let bits = face.map(|v| mesh.positions[v as usize].to_array().map(f64::to_bits));
    let [a, b, c] = bits;
    [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().unwrap()
}

/// The faces for which `untouched` holds must be in the result: in order, with the same orientation, bit for bit.
#[track_caller]
fn assert_kept(before: &Mesh, after: &Mesh, untouched: impl Fn(&[u32; 3]) -> bool) {
    let mut faces = after.faces.iter().map(|f| corners(after, f));
    for face in before.faces.iter().filter(|f| untouched(f)) {
        let wanted = corners(before, face);
        assert!(
            faces.any(|f| f == wanted),
            "the face at {} is not there or not in order",
            centre(before, face)
        );
    }
}

/// Pseudo-random numbers, the same in every run.
struct Noise(u64);

impl Noise {
    fn next(&mut self, below: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (self.0 >> 33) as usize % below
    }
}

#[test]
fn a_sound_mesh_stays_unchanged() {
    for mesh in [good(), turned(torus(24, 12))] {
        let done = repaired(&mesh, &RepairParams::default());
        assert_eq!(done.mesh, mesh);
        assert_eq!(done.report.lost_faces, 0);
    }
}

#[test]
fn flipped_and_duplicate_faces_are_repaired() {
    let mesh = good();
    let mut noise = Noise(11);
    for round in 0..8 {
        let mut bad = mesh.clone();
        for _ in 0..1 + 20 * round {
            let f = noise.next(mesh.faces.len());
            bad.faces[f] = [mesh.faces[f][0], mesh.faces[f][2], mesh.faces[f][1]];
        }
        for _ in 0..10 * round {
            let f = bad.faces[noise.next(mesh.faces.len())];
            bad.faces.push([f[1], f[0], f[2]]);
        }
        let done = repaired(&bad, &RepairParams::default());
        // Which of two copies stays and which corner comes first is not specified: the sets of faces must be equal.
        let all =
            |m: &Mesh| -> HashSet<Corners> { m.faces.iter().map(|f| corners(m, f)).collect() };
        assert_eq!(all(&done.mesh), all(&mesh), "round {round}");
        assert_eq!(done.mesh.faces.len(), mesh.faces.len());
        assert_eq!(done.mesh.positions, mesh.positions);
        assert_sound(&done.mesh);
        assert_eq!(done.report.lost_faces, bad.faces.len() - mesh.faces.len());
    }
}

#[test]
fn an_inside_out_mesh_is_turned_with_or_without_a_hole() {
    let hole = cut(&good(), |p| polar(p) < 20.0);
    for mesh in [good(), hole] {
        let faces = mesh.faces.iter().map(|f| [f[0], f[2], f[1]]).collect();
        let bad = Mesh::new(mesh.positions.clone(), faces);
        let done = repaired(&bad, &RepairParams::default());
        assert_sound(&done.mesh);
        assert_kept(&mesh, &done.mesh, |_| true);
        assert_eq!(done.report.steps.reoriented_faces, mesh.faces.len());
    }
}

#[test]
fn cubes_that_share_an_edge_or_a_vertex_are_separated() {
    let cube = |at: DVec3| {
        let corner =
            |i: u32| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2));
        let faces = [
            [0, 2, 3],
            [0, 3, 1],
            [4, 5, 7],
            [4, 7, 6],
            [0, 1, 5],
            [0, 5, 4],
            [2, 6, 7],
            [2, 7, 3],
            [0, 4, 6],
            [0, 6, 2],
            [1, 3, 7],
            [1, 7, 5],
        ];
        Mesh::new((0..8).map(|i| corner(i) + at).collect(), faces.to_vec())
    };
    for at in [DVec3::new(1.0, 1.0, 0.0), DVec3::ONE] {
        let glued = joined(&cube(DVec3::ZERO), &cube(at));
        assert!(!verdict(&glued).is_sound());
        let done = repaired(&glued, &RepairParams::default());
        assert_sound(&done.mesh);
        assert_eq!((done.mesh.faces.len(), done.report.lost_faces), (24, 0));
        let farthest = |i: usize| {
            let from = done.origins.vertices[i] as usize;
            done.mesh.positions[i].distance(glued.positions[from])
        };
        assert!((0..done.mesh.positions.len()).all(|i| farthest(i) < 3e-3));
    }
}

#[test]
fn a_face_on_a_non_manifold_edge_is_removed_and_the_rest_stays() {
    let mesh = good();
    let mut fin = mesh.clone();
    let [a, b, _] = mesh.faces[40];
    let top = 1.2 * (mesh.positions[a as usize] + mesh.positions[b as usize]) / 2.0;
    fin.positions.push(top);
    fin.faces.push([a, b, mesh.positions.len() as u32]);
    let done = repaired(&fin, &RepairParams::default());
    assert_eq!(done.mesh, mesh);
    assert!(done.report.steps.non_manifold_faces > 0);
}

#[test]
fn a_fin_is_removed_from_a_surface_with_a_hole_too() {
    let mesh = cut(&good(), |p| p.z > 0.75);
    let mut fin = mesh.clone();
    for f in [40, 200] {
        let [a, b, _] = mesh.faces[f];
        let top = 1.2 * (mesh.positions[a as usize] + mesh.positions[b as usize]) / 2.0;
        fin.faces.push([a, b, fin.positions.len() as u32]);
        fin.positions.push(top);
    }
    let done = repaired(&fin, &RepairParams::default());
    assert_sound(&done.mesh);
    assert_eq!(verdict(&done.mesh).components.len(), 1);
    assert_eq!(done.mesh.faces[..mesh.faces.len()], mesh.faces);
    assert_eq!(done.report.steps.non_manifold_faces, 2);
}

#[test]
fn faces_far_from_a_piercing_ball_stay_unchanged() {
    let mesh = good();
    for (at, size) in [
        (DVec3::new(0.95, 0.2, 0.1), 0.35),
        (DVec3::new(-0.3, 0.9, 0.4), 0.3),
        (DVec3::new(0.1, -0.2, 1.0), 0.4),
    ] {
        let bad = joined(&mesh, &moved(&turned(sphere(4)), size, at));
        assert!(!verdict(&bad).is_sound());
        let done = repaired(&bad, &RepairParams::default());
        assert_sound(&done.mesh);
        let reach = size + 0.45;
        let far = |f: &[u32; 3]| {
            let own = f.iter().all(|v| (*v as usize) < mesh.positions.len());
            own && centre(&bad, f).distance(at) > reach
        };
        assert_kept(&bad, &done.mesh, far);
        // The part of the piercing ball that is outside still exists.
        let tip = at + size * at.normalize();
        let nearest = |m: &Mesh| {
            m.positions
                .iter()
                .map(|p| p.distance(tip))
                .fold(9.0, f64::min)
        };
        assert!(nearest(&done.mesh) < 0.25 * size, "{}", nearest(&done.mesh));
        assert_eq!(verdict(&done.mesh).components.len(), 1);
    }
}

#[test]
fn holes_and_intersecting_faces_can_be_kept() {
    let mesh = cut(&good(), |p| polar(p) < 25.0);
    let params = RepairParams::new().with_skip([RepairStep::Holes]);
    let done = repaired(&mesh, &params);
    assert_eq!(done.mesh, mesh);
    let pierced = joined(&good(), &moved(&sphere(4), 0.3, DVec3::new(0.95, 0.2, 0.1)));
    let params = RepairParams::new().with_skip([RepairStep::Intersections]);
    let done = repaired(&pierced, &params);
    assert_eq!(done.mesh, pierced);
    assert!(done.report.steps.intersection_passes.is_empty());
}

#[test]
fn each_repair_step_can_be_switched_off() {
    let mut bad = good();
    bad.faces[3].swap(1, 2);
    bad.faces.push(bad.faces[9]);
    let [a, b, _] = bad.faces[20];
    bad.faces.push([a, b, a]);
    let steps = [
        RepairStep::Duplicates,
        RepairStep::Orientation,
        RepairStep::NonManifold,
        RepairStep::Intersections,
        RepairStep::Holes,
    ];
    let from = |first: usize| RepairParams::new().with_skip(steps[first..].iter().copied());
    assert_eq!(repaired(&bad, &from(0)).mesh, bad);
    let clean = from(1);
    let done = repaired(&bad, &clean);
    let r = &done.report;
    assert_eq!(
        (
            r.steps.duplicate_faces,
            r.steps.degenerate_faces,
            r.steps.reoriented_faces
        ),
        (1, 1, 0)
    );
    assert_eq!(done.mesh.faces, bad.faces[..bad.faces.len() - 2]);
    let orient = from(2);
    assert_eq!(repaired(&bad, &orient).mesh.faces.len(), good().faces.len());
    assert_eq!(repaired(&bad, &orient).report.steps.reoriented_faces, 1);
}

#[test]
fn small_and_inner_components_are_removed_on_request() {
    let ball = good();
    let inner = moved(&turned(sphere(4)), 0.3, DVec3::ZERO);
    let small = moved(&turned(sphere(2)), 0.02, 2.0 * DVec3::X);
    let bad = joined(&joined(&ball, &inner), &small);
    assert_eq!(repaired(&bad, &RepairParams::default()).mesh, bad);
    let mut params = RepairParams::default();
    params.debris = Some(0.01);
    let done = repaired(&bad, &params);
    assert_eq!(done.mesh, joined(&ball, &inner));
    let steps = &done.report.steps;
    assert_eq!(
        [steps.debris_components, steps.debris_faces],
        [1, small.faces.len()]
    );
    params.drop_inside = true;
    let done = repaired(&bad, &params);
    assert_eq!(done.mesh, ball);
    let steps = &done.report.steps;
    assert_eq!(
        [steps.inside_components, steps.inside_faces],
        [1, inner.faces.len()]
    );
}

#[test]
fn components_are_removed_by_their_numbers() {
    let [a, b, c] = [0.0, 3.0, 6.0].map(|x| moved(&good(), 1.0, x * DVec3::X));
    let mesh = joined(&joined(&a, &b), &c);
    let done = repaired(&mesh, &RepairParams::new().with_drop([2]));
    assert_eq!(done.mesh, joined(&a, &c));
    let steps = &done.report.steps;
    assert_eq!(
        [steps.dropped_components, steps.dropped_faces],
        [1, b.faces.len()]
    );
    assert_eq!(done.report.lost_faces, b.faces.len());
    assert_sound(&done.mesh);
    // What is left is repaired: a body that intersects one that goes is not cut.
    let crossing = joined(&joined(&a, &b), &moved(&good(), 1.0, 3.9 * DVec3::X));
    let done = repaired(&crossing, &RepairParams::new().with_drop([3, 1]));
    assert_eq!(done.mesh, b);
    let refused = |numbers: &[usize]| {
        let params = RepairParams::new().with_drop(numbers.iter().copied());
        let done = repair(&mesh, &params, &Carried::default(), &Control::new());
        done.unwrap_err().to_string()
    };
    assert_eq!(refused(&[1, 4]), "there is no component 4; the mesh has 3");
    assert_eq!(refused(&[0]), "there is no component 0; the mesh has 3");
    assert!(refused(&[3, 2, 1]).contains("nothing would be left"));
}

#[test]
fn cracks_narrower_than_the_weld_length_are_welded() {
    let mesh = good();
    // The upper half gets its own vertices, moved by 1e-6.
    let mut bad = mesh.clone();
    let upper = |f: &[u32; 3]| centre(&mesh, f).z > 0.0;
    let mut copy = std::collections::HashMap::new();
    for face in bad.faces.iter_mut().filter(|f| upper(f)) {
        *face = face.map(|v| {
            *copy.entry(v).or_insert_with(|| {
                let p = mesh.positions[v as usize];
                bad.positions.push(p + 1e-6 * DVec3::Y);
                bad.positions.len() as u32 - 1
            })
        });
    }
    let mut params = RepairParams::default();
    params.weld = Some(1e-5);
    let done = repaired(&bad, &params);
    assert_sound(&done.mesh);
    assert_eq!(
        (done.mesh.faces.len(), done.report.lost_faces),
        (mesh.faces.len(), 0)
    );
    assert!(done.report.steps.welded_vertices > 20);
}

#[test]
fn a_face_without_area_is_removed_by_flipping_an_edge() {
    let p = DVec3::new;
    // A tetrahedron whose edge from 0 to 1 has a vertex at its middle that only the faces on one side use.
    let mesh = Mesh::new(
        vec![
            p(0.0, 0.0, 0.0),
            p(2.0, 0.0, 0.0),
            p(0.0, 2.0, 0.0),
            p(0.0, 0.0, 2.0),
            p(1.0, 0.0, 0.0),
        ],
        vec![
            [0, 2, 1],
            [0, 4, 3],
            [4, 1, 3],
            [0, 3, 2],
            [1, 2, 3],
            [0, 1, 4],
        ],
    );
    // Vertex 4 also touches the face [0, 2, 1]; the face [0, 1, 4] has no area.
    assert_eq!(verdict(&mesh).count(DefectKind::Degenerate), 1);
    let done = repaired(&mesh, &RepairParams::default());
    assert_sound(&done.mesh);
    assert_eq!(done.report.steps.flipped_edges, 1);
    assert_eq!(done.mesh.positions, mesh.positions);
}

#[test]
fn the_result_is_the_same_for_any_number_of_threads_and_a_run_can_be_stopped() {
    let mesh = good();
    let bad = joined(
        &mesh,
        &moved(&turned(sphere(4)), 0.35, DVec3::new(0.95, 0.2, 0.1)),
    );
    let run = |threads| {
        let control = Control::new().threads(threads);
        repair(
            &bad,
            &RepairParams::default(),
            &Carried::default(),
            &control,
        )
        .unwrap()
        .mesh
    };
    assert_eq!(run(1), run(2));
    let cancel = Cancel::new();
    cancel.cancel();
    let control = Control::new().cancel(&cancel);
    let stopped = repair(
        &bad,
        &RepairParams::default(),
        &Carried::default(),
        &control,
    );
    assert!(matches!(stopped, Err(FillError::Cancelled)));
}

#[test]
fn the_command_repairs_reports_and_exits_by_the_verdict() {
    let desk = Desk::new();
    let open = cut(&good(), |p| p.z < -0.9);
    let bad = joined(&open, &moved(&sphere(4), 0.3, DVec3::new(0.95, 0.2, 0.1)));
    desk.save("bad.ply", &bad, Format::Ply);
    let done = desk.run(&["repair", "bad.ply", "-o", "out.ply", "--json", "out.json"]);
    assert_code(&done, 0);
    let said = text(&done.stderr);
    assert!(
        said.contains("intersecting bodies united") && said.contains("printable: yes"),
        "{said}"
    );
    let document = desk.json("out.json");
    assert_eq!(document["command"], "repair");
    assert_eq!(document["complete"], true);
    assert_eq!(document["before"]["sound"], false);
    assert_eq!(document["after"]["sound"], true);
    assert_eq!(document["steps"]["united_bodies"], 2);
    assert_eq!(document["after"]["doubt"], serde_json::Value::Null);
    assert_sound(&read_path(&desk.path("out.ply"), None).unwrap().mesh);
    assert_code(&desk.run(&["check", "out.ply", "-q"]), 0);
    let done = desk.run(&[
        "repair",
        "bad.ply",
        "-o",
        "no.ply",
        "--skip",
        "intersections",
        "-q",
    ]);
    assert_code(&done, 3);
}

#[test]
fn a_repair_fills_the_holes_of_the_given_numbers() {
    let desk = Desk::new();
    let mut bad = desk::ball();
    bad.faces[10].swap(1, 2);
    bad.faces.push(bad.faces[30]);
    desk.save("bad.ply", &bad, Format::Ply);
    assert_code(&desk.run(&["repair", "bad.ply", "-o", "out.ply", "-q"]), 0);
    assert_sound(&read_path(&desk.path("out.ply"), None).unwrap().mesh);
    // Holes are chosen by their numbers in the input, before the repair.
    let done = desk.run(&["repair", "bad.ply", "-o", "one.ply", "--holes", "2", "-q"]);
    assert_code(&done, 3);
    let one = verdict(&read_path(&desk.path("one.ply"), None).unwrap().mesh);
    assert_eq!(one.holes, 1);
    assert!(polar(one.defects[0].places[0]) < 20.0);
}

#[test]
fn a_repair_keeps_attributes_of_vertices_and_faces() {
    let desk = Desk::new();
    // Two tetrahedra share a vertex, one face is turned, every vertex has a colour, and every face has a material.
    let text_of = "\
v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nv 0 0 1 1 1 0\nv -1 0 0 0 1 1\nv 0 -1 0 1 0 1\nv 0 0 -1 0.5 0.5 0.5\n\
usemtl a\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\nusemtl b\nf 1 5 6\nf 1 7 5\nf 1 6 7\nf 5 6 7\n";
    desk.text("two.obj", text_of);
    assert_code(&desk.run(&["repair", "two.obj", "-o", "out.obj", "-q"]), 0);
    let out = read_path(&desk.path("out.obj"), None).unwrap();
    assert_sound(&out.mesh);
    let colours = out.attributes.vertex_role(isomend::Role::Colour).unwrap();
    let at_origin: Vec<_> = (0..out.mesh.positions.len())
        .filter(|v| out.mesh.positions[*v].length() < 0.01)
        .collect();
    assert_eq!(at_origin.len(), 2);
    assert!(
        at_origin
            .iter()
            .all(|v| colours.get(*v).unwrap()[..3] == [1.0, 0.0, 0.0])
    );
    let materials = out
        .attributes
        .labels_of(isomend::LabelKind::Material)
        .unwrap();
    let names: Vec<_> = (0..8).map(|f| materials.get(f).unwrap()).collect();
    assert_eq!(names, ["a", "a", "a", "a", "b", "b", "b", "b"]);
}
