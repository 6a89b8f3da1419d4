//! Tests: boundary loops, components and orientation of small meshes.

use glam::DVec3;

use super::shapes::{grid, icosphere, punch};
use super::{Hole, Mesh, Topology, find_holes};

/// A flat sheet of 10 × 10 unit squares.
fn sheet() -> Mesh {
    grid(10, 10, [false, false], |u, v| {
        DVec3::new(10.0 * u, 10.0 * v, 0.0)
    })
}

fn holes_of(mesh: &mut Mesh) -> (Topology, Vec<Hole>) {
    let mut topology = Topology::new(mesh);
    let (holes, open_chains) = find_holes(mesh, &mut topology);
    assert_eq!(open_chains, []);
    (topology, holes)
}

#[test]
fn holes_that_touch_at_a_vertex_are_two_loops() {
    let in_square = |c: DVec3, i: f64| c.x.floor() == i && c.y.floor() == i;
    let mut mesh = punch(&sheet(), |c| in_square(c, 4.0) || in_square(c, 5.0));
    let (topology, holes) = holes_of(&mut mesh);
    let edges: Vec<usize> = holes.iter().map(|h| h.edges).collect();
    assert_eq!(edges, [40, 4, 4]);
    assert_eq!(topology.defects.non_manifold_boundary_vertices, 1);
    let common: Vec<DVec3> = holes[1]
        .rim
        .iter()
        .filter(|v| holes[2].rim.contains(v))
        .map(|&v| mesh.positions[v as usize])
        .collect();
    assert_eq!(common, [DVec3::new(5.0, 5.0, 0.0)]);
}

#[test]
fn a_rim_is_opposite_to_the_half_edges_of_its_faces() {
    let mut mesh = punch(&icosphere(3), |c| c.z > 0.5);
    let (_, holes) = holes_of(&mut mesh);
    assert_eq!(holes.len(), 1);
    let rim = &holes[0].rim;
    for (i, &v) in rim.iter().enumerate() {
        let w = rim[(i + 1) % rim.len()];
        let uses = |a, b| {
            let runs = |f: &&[u32; 3]| (0..3).any(|k| (f[k], f[(k + 1) % 3]) == (a, b));
            mesh.faces.iter().filter(runs).count()
        };
        assert_eq!((uses(v, w), uses(w, v)), (0, 1));
        assert!(holes[0].conormals[i].z > 0.0);
    }
}

#[test]
fn a_hole_has_the_normal_of_its_patch_and_a_height() {
    let mut mesh = punch(&icosphere(3), |c| c.x > 0.8);
    let (_, holes) = holes_of(&mut mesh);
    // A zigzag of triangles around the plane x = 0.8.
    assert!(holes[0].normal.dot(DVec3::X) > 0.99, "{}", holes[0].normal);
    assert!((holes[0].normal.length() - 1.0).abs() < 1e-12);
    assert!(holes[0].height > 0.01 && holes[0].height < 0.2);
    let mut inside_out = mesh.clone();
    inside_out.faces.iter_mut().for_each(|f| f.swap(1, 2));
    assert!(holes_of(&mut inside_out).1[0].normal.x < -0.99);
    // A step of height 0.25 in the rim of a hole in a sheet, at any scale.
    for scale in [1.0, 1e-100, 1e100] {
        let middle = DVec3::new(5.0, 5.0, 0.0);
        let mut sheet = punch(&sheet(), |c| c.distance(middle) < 2.0);
        for p in &mut sheet.positions {
            p.z = if p.distance(middle) < 3.0 && p.x > 5.5 {
                0.25
            } else {
                0.0
            };
            *p *= scale;
        }
        let (_, holes) = holes_of(&mut sheet);
        let hole = &holes[1];
        assert!(hole.normal.z > 0.95, "{scale}: {}", hole.normal);
        assert!(
            (hole.height / scale / 0.25 - 1.0).abs() < 1.0,
            "{scale}: {}",
            hole.height
        );
    }
}

#[test]
fn a_slit_has_no_normal() {
    let mut mesh = sheet();
    // The two sides of a cut along an edge: the faces above it get their own vertices.
    let along: Vec<u32> = (0..mesh.positions.len() as u32)
        .filter(|&v| {
            let p = mesh.positions[v as usize];
            p.y == 5.0 && p.x > 2.0 && p.x < 8.0
        })
        .collect();
    assert!(along.len() > 2);
    for v in along {
        let copy = mesh.positions.len() as u32;
        let p = mesh.positions[v as usize];
        mesh.positions.push(p);
        for f in 0..mesh.faces.len() {
            let centre = mesh.corners(f as u32).iter().map(|c| c.y).sum::<f64>() / 3.0;
            if centre > 5.0 {
                for c in mesh.faces[f].iter_mut().filter(|c| **c == v) {
                    *c = copy;
                }
            }
        }
    }
    let (_, holes) = holes_of(&mut mesh);
    assert_eq!(holes.len(), 2);
    assert_eq!((holes[1].normal, holes[1].height), (DVec3::ZERO, 0.0));
}

#[test]
fn a_rim_bounds_the_component_that_most_of_its_edges_have() {
    // A loose triangle hangs between two vertices of a rim; where it is among the faces decides along which of its edges rims run.
    let mut mesh = punch(&icosphere(3), |c| c.z > 0.8);
    let [hole] = &holes_of(&mut mesh).1[..] else {
        panic!("one hole");
    };
    let [a, b] = [hole.rim[0], hole.rim[hole.rim.len() / 2]];
    let middle = mesh.positions.len() as u32;
    mesh.positions.push(hole.centre);
    let mut divided = 0;
    for at in (0..=mesh.faces.len()).step_by(mesh.faces.len() / 16) {
        for face in [[a, b, middle], [b, a, middle]] {
            let mut hung = mesh.clone();
            hung.faces.insert(at, face);
            let (topology, holes) = holes_of(&mut hung);
            let rims = holes.iter().filter(|h| h.edges > 3);
            divided += usize::from(rims.clone().count() == 2);
            assert!(rims.clone().all(|h| !topology.is_loose(h.component)));
        }
    }
    assert!(divided > 2, "{divided}");
}

#[test]
fn a_loose_triangle_is_a_small_component() {
    let mut mesh = icosphere(1);
    let first = mesh.positions.len() as u32;
    let away = 3.0 * DVec3::X;
    mesh.positions
        .extend([away, away + DVec3::Y, away + DVec3::Z]);
    mesh.faces.push([first, first + 1, first + 2]);
    let (topology, holes) = holes_of(&mut mesh);
    assert_eq!(topology.component_faces, [80, 1]);
    assert_eq!(topology.defects.small_components, 1);
    assert_eq!((holes.len(), holes[0].component), (1, 1));
}

#[test]
fn an_inconsistent_face_is_reversed() {
    let right = punch(&icosphere(2), |c| c.z > 0.5);
    let loops = |holes: &[Hole]| holes.iter().map(|h| h.rim.clone()).collect::<Vec<_>>();
    let wanted = loops(&holes_of(&mut right.clone()).1);
    for f in 0..right.faces.len() {
        let mut mesh = right.clone();
        mesh.faces[f].swap(1, 2);
        let (topology, holes) = holes_of(&mut mesh);
        assert_eq!(mesh, right);
        assert_eq!(topology.defects.reoriented_faces, 1);
        assert!(topology.turned[f]);
        assert_eq!(loops(&holes), wanted);
        for (h, &o) in topology.opposite.iter().enumerate() {
            assert!(topology.boundary[h] || topology.opposite[o as usize] == h as u32);
        }
    }
}

#[test]
fn only_the_border_of_an_open_sheet_is_its_outer_border() {
    let middle = DVec3::new(5.0, 5.0, 0.0);
    let outer = |mut mesh: Mesh| -> Vec<bool> {
        let (_, holes) = holes_of(&mut mesh);
        holes.iter().map(|h| h.outer_boundary).collect()
    };
    assert_eq!(outer(sheet()), [true]);
    assert_eq!(
        outer(punch(&sheet(), |c| c.distance(middle) < 2.0)),
        [true, false]
    );
    for height in [0.0, 0.5, 0.9] {
        assert_eq!(outer(punch(&icosphere(3), |c| c.z > height)), [false]);
    }
}
