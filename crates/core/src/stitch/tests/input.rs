//! Tests: wrong and degenerate inputs, and single loops.

use glam::DVec3;

use super::cases::{Case, assert_joined, euler, ragged_cap, sphere};
use super::shapes::*;
use crate::mesh::Mesh;
use crate::mesh::triangulate::triangulate_loop;
use crate::sdf::Surface;
use crate::stitch::{Patch, StitchError, StitchInput, StitchParams, count_intersecting, stitch};

struct Nowhere;

impl Surface for Nowhere {
    fn project(&self, _: DVec3) -> Option<(DVec3, DVec3)> {
        None
    }

    fn depth(&self, _: DVec3) -> f64 {
        f64::NAN
    }
}

fn input<'a>(
    mesh: &'a Mesh,
    loops: &'a [Vec<u32>],
    surface: &'a dyn Surface,
    extracted: &'a Mesh,
) -> StitchInput<'a> {
    StitchInput {
        mesh,
        loops,
        surface,
        extracted,
        voxel: 0.05,
        params: StitchParams::default(),
    }
}

fn cap() -> (Mesh, Vec<Vec<u32>>) {
    let mesh = punch(&icosphere(3), |c| c.z > 0.5);
    let loops = boundary_loops(&mesh);
    (mesh, loops)
}

#[test]
fn wrong_indices_and_numbers_are_errors() {
    let (mesh, loops) = cap();
    let surface = sphere().with_mesh(&mesh, &loops);
    let empty = Mesh::default();
    let run = |loops: &[Vec<u32>], voxel: f64| {
        stitch(&StitchInput {
            voxel,
            ..input(&mesh, loops, &surface, &empty)
        })
    };
    assert!(matches!(
        run(&[vec![0, 1, 999_999]], 0.05),
        Err(StitchError::Index { .. })
    ));
    assert!(matches!(
        run(&loops, f64::NAN),
        Err(StitchError::Number { .. })
    ));
    assert!(matches!(run(&loops, 0.0), Err(StitchError::Number { .. })));
    assert_eq!(run(&[], 0.05), Err(StitchError::NoLoops));
    assert_eq!(run(&[vec![]], 0.05), Err(StitchError::NoLoops));
    let mut reversed = loops.clone();
    reversed[0].reverse();
    assert!(matches!(
        run(&reversed, 0.05),
        Err(StitchError::NotOnBoundary { rim: 0, .. })
    ));
    assert_eq!(
        run(&loops, 0.05),
        Err(StitchError::RimNotReached { rim: 0 })
    );
}

#[test]
fn a_surface_turned_over_is_an_error() {
    let (mesh, loops) = cap();
    let surface = sphere().with_mesh(&mesh, &loops);
    let mut extracted = extract(&surface, DVec3::splat(-1.3), DVec3::splat(1.3), 0.05);
    extracted.faces.iter_mut().for_each(|f| f.swap(1, 2));
    assert!(stitch(&input(&mesh, &loops, &surface, &extracted)).is_err());
}

#[test]
fn a_surface_that_projects_nothing_is_no_panic() {
    let (mesh, loops) = cap();
    let extracted = extract(&sphere(), DVec3::splat(-1.3), DVec3::splat(1.3), 0.05);
    assert!(stitch(&input(&mesh, &loops, &Nowhere, &extracted)).is_err());
}

#[test]
fn degenerate_rims_do_not_panic() {
    for kind in 0..4 {
        let (mut mesh, loops) = cap();
        let (a, b, c) = (
            loops[0][0] as usize,
            loops[0][1] as usize,
            loops[0][2] as usize,
        );
        match kind {
            0 => mesh.positions[b] = mesh.positions[a],
            1 => {
                mesh.positions[b] = mesh.positions[a].lerp(mesh.positions[c], 0.5) + 0.5 * DVec3::Z
            }
            2 => mesh.positions[b] = (mesh.positions[a] + mesh.positions[c]) / 2.0,
            _ => loops[0]
                .iter()
                .step_by(2)
                .for_each(|&v| mesh.positions[v as usize] *= 1.05),
        }
        let surface = sphere().with_mesh(&mesh, &loops);
        let extracted = extract(&surface, DVec3::splat(-1.3), DVec3::splat(1.3), 0.05);
        if let Ok(patch) = stitch(&input(&mesh, &loops, &surface, &extracted)) {
            assert_eq!(euler(&assert_joined(&mesh, &patch, 0)), 2);
        }
    }
}

#[test]
fn small_holes_are_filled_without_an_extracted_surface() {
    let mut count = 0;
    let mesh = punch(&icosphere(3), |_| {
        count += 1;
        count % 97 == 0
    });
    let loops = boundary_loops(&mesh);
    let surface = sphere().with_mesh(&mesh, &loops);
    let patch = stitch(&input(&mesh, &loops, &surface, &Mesh::default())).expect("a patch");
    assert_eq!(patch.report.filled_directly, loops.len());
    assert_eq!(euler(&assert_joined(&mesh, &patch, 0)), 2);
}

#[test]
fn compensation_brings_the_faces_nearer_to_the_surface() {
    let case = ragged_cap(2, 0.1, 32.0);
    let (still, moved) = (
        case.stitch_on_surface(),
        case.stitch(StitchParams {
            facet_compensation: 1.0,
            ..StitchParams::default()
        }),
    );
    // The displacement fades in from the rim, which is below 0.6.
    for (above, mean, rms) in [(0.0, 0.3, 0.6), (0.8, 0.01, 0.2)] {
        let still = facet_offsets(&case, &still, above);
        let moved = facet_offsets(&case, &moved, above);
        assert!(moved.mean.abs() < mean * still.mean.abs());
        assert!(moved.rms < rms * still.rms);
    }
}

struct Offsets {
    mean: f64,
    rms: f64,
}

/// Signed distances from the unit sphere of a patch's faces above a height, at the midpoints of their edges (exact for quadratic
/// functions), weighted by area.
fn facet_offsets(case: &Case, patch: &Patch, above: f64) -> Offsets {
    let mut points = case.mesh.positions.clone();
    points.extend(&patch.positions);
    let (mut area, mut sum, mut squares) = (0.0, 0.0, 0.0);
    for f in &patch.faces {
        let [a, b, c] = f.map(|v| points[v as usize]);
        let weight = (b - a).cross(c - a).length() / 3.0;
        if a.z.min(b.z).min(c.z) < above {
            continue;
        }
        for middle in [a.midpoint(b), b.midpoint(c), c.midpoint(a)] {
            let off = middle.length() - 1.0;
            area += weight;
            sum += weight * off;
            squares += weight * off * off;
        }
    }
    Offsets {
        mean: sum / area,
        rms: (squares / area).sqrt(),
    }
}

#[test]
fn one_loop_is_triangulated_without_new_vertices() {
    for (level, top) in [(2, 0.5), (3, 0.5), (5, 0.2)] {
        let mesh = punch(&icosphere(level), |c| c.z > top);
        let rim = &boundary_loops(&mesh)[0];
        let faces = triangulate_loop(&mesh, rim).expect("a triangulation");
        assert_eq!(faces.len(), rim.len() - 2);
        assert_eq!(count_intersecting(&mesh, &[], &faces), 0);
        let patch = Patch {
            faces,
            ..Default::default()
        };
        assert_eq!(euler(&assert_joined(&mesh, &patch, 0)), 2);
    }
    assert!(triangulate_loop(&Mesh::default(), &[0, 1, 2]).is_err());
    assert!(triangulate_loop(&icosphere(1), &[]).is_err());
}
