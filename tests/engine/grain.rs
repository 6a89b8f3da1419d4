//! Grain: patches as rough as their surroundings.

use glam::DVec3;
use isomend::{Control, FillParams, Inspection, Mesh, fill};

use crate::shapes::{Noise, cut, sphere};

/// A rough sphere with a hole: radial noise, and waves a few edges long; `noise` and `waves` are root mean squares in edges.
fn stone(noise: f64, waves: f64) -> Mesh {
    let mut mesh = sphere(28);
    let edge = 0.04;
    let mut random = Noise(11);
    let kinds: Vec<(DVec3, f64)> = (0..60)
        .map(|_| (random.vector() * 0.7 / edge, random.next() * 3.0))
        .collect();
    for p in &mut mesh.positions {
        let sum: f64 = kinds
            .iter()
            .map(|(k, phase)| (k.dot(*p) + phase).cos())
            .sum();
        let height = waves * sum * (2.0f64 / 60.0).sqrt() + noise * random.next() * 3.0f64.sqrt();
        *p *= 1.0 + edge * height;
    }
    cut(&mesh, |p| {
        p.normalize().distance(DVec3::new(0.6, 0.0, 0.8)) < 0.35
    })
}

/// Root mean square distance of vertices from the sphere with their mean radius.
fn roughness(points: &[DVec3]) -> f64 {
    let mean = points.iter().map(|p| p.length()).sum::<f64>() / points.len() as f64;
    let squares: f64 = points.iter().map(|p| (p.length() - mean).powi(2)).sum();
    (squares / points.len() as f64).sqrt()
}

#[test]
fn a_patch_on_stone_is_as_rough_as_the_stone() {
    for (noise, waves) in [(0.1, 0.0), (0.05, 0.1), (0.0, 0.15)] {
        let open = stone(noise, waves);
        let plain = fill(&open, &FillParams::default()).unwrap();
        let rough = fill(&open, &FillParams::new().with_grain(true)).unwrap();
        let report = rough.report.regions[0].grain.unwrap();
        assert_eq!(plain.report.regions[0].grain, None);
        assert_eq!(rough.report.regions[0].intersecting_faces, 0);
        assert!((report.patch / report.ring - 1.0).abs() < 0.1, "{report:?}");
        // Grain changes only positions of the patch; the input and the expected errors are unchanged.
        let count = open.positions.len();
        assert_eq!(rough.mesh.positions[..count], open.positions[..]);
        assert_eq!(rough.mesh.faces, plain.mesh.faces);
        assert_eq!(rough.expected_error, plain.expected_error);
        let inner = |mesh: &Mesh| -> Vec<DVec3> {
            let deep = |p: &&DVec3| p.normalize().distance(DVec3::new(0.6, 0.0, 0.8)) < 0.22;
            mesh.positions[count..]
                .iter()
                .filter(deep)
                .copied()
                .collect()
        };
        // An independent measure, against the sphere. It includes long waves, some of which the smooth patch continues.
        let own = roughness(&inner(&rough.mesh));
        let stone = roughness(&open.positions);
        assert!(own > 0.7 * stone && own < 1.3 * stone, "{own} {stone}");
        // The added height is of the order of the roughness, and no vertex moves by much more.
        let both = plain.mesh.positions.iter().zip(&rough.mesh.positions);
        let moves: Vec<f64> = both.map(|(p, q)| p.distance(*q)).collect();
        let squares: f64 = moves.iter().map(|m| m * m).sum();
        let added = (squares / (moves.len() - count) as f64).sqrt();
        assert!(
            added > 0.4 * stone && added < 1.2 * stone,
            "{added} {stone}"
        );
        assert!(moves.iter().all(|m| *m < 5.0 * stone));
    }
}

#[test]
fn grain_is_the_same_each_time_and_in_tasks() {
    let open = stone(0.1, 0.05);
    let found = Inspection::new(&open).unwrap();
    let params = FillParams::new().with_grain(true);
    let one = found.fill(&params, &Control::new().threads(1)).unwrap();
    let several = found.fill(&params, &Control::new().threads(3)).unwrap();
    assert_eq!(one.mesh, several.mesh);
    let regions = found.regions(&params).unwrap();
    let patches = regions
        .tasks()
        .map(|task| task.solve(&Control::new()).unwrap());
    let together = regions.assemble(patches.collect()).unwrap();
    assert_eq!(together.mesh, one.mesh);
}
