//! Flat bases under open sheets (`flat_base`), with walls from the outer border down to the base.

use glam::DVec3;
use isomend::{
    Carried, Closure, Control, FillParams, HoleOutcome, Inspection, Mesh, RegionTask, RepairParams,
    fill, repair,
};

use crate::shapes::{bits, topology, volume};

const SIZE: u32 = 24;

/// Height of a hilly terrain.
fn height(x: f64, y: f64) -> f64 {
    1.5 * (0.4 * x).sin() * (0.3 * y).cos() + 0.05 * x
}

/// The terrain over a square, with or without a hole; `up` turns it into another direction.
fn terrain(up: fn(DVec3) -> DVec3, hole: bool) -> Mesh {
    let count = SIZE + 1;
    let at = |i: u32, j: u32| {
        let (x, y) = (f64::from(i), f64::from(j));
        up(DVec3::new(x, y, height(x, y)))
    };
    let positions = (0..count).flat_map(|i| (0..count).map(move |j| at(i, j)));
    let cells = (0..SIZE).flat_map(|i| (0..SIZE).map(move |j| (i, j)));
    let is_hole = |i, j| hole && (8..12).contains(&i) && (10..14).contains(&j);
    let faces = cells.filter(|&(i, j)| !is_hole(i, j)).flat_map(|(i, j)| {
        let [a, b] = [i * count + j, (i + 1) * count + j];
        [[a, b, b + 1], [a, b + 1, a + 1]]
    });
    Mesh::new(positions.collect(), faces.collect())
}

/// Volume between the triangles of the terrain and a plane below it.
fn between(mesh: &Mesh, level: f64) -> f64 {
    let prism = |f: &[u32; 3]| {
        let [a, b, c] = f.map(|v| mesh.positions[v as usize]);
        let area = 0.5 * (b - a).truncate().perp_dot((c - a).truncate());
        area * ((a.z + b.z + c.z) / 3.0 - level)
    };
    mesh.faces.iter().map(prism).sum()
}

#[test]
fn a_terrain_is_closed_by_a_base_at_the_given_offset() {
    let mesh = terrain(|p| p, false);
    let lowest = mesh
        .positions
        .iter()
        .map(|p| p.z)
        .fold(f64::INFINITY, f64::min);
    let params = FillParams::new().with_flat_base(true);
    for offset in [Some(3.0), None] {
        let params = match offset {
            Some(length) => params.clone().with_base_offset(length),
            None => params.clone(),
        };
        let filled = fill(&mesh, &params).unwrap();
        assert_eq!(topology(&filled.mesh), (0, 2));
        assert_eq!(
            filled.report.holes[0].outcome,
            HoleOutcome::Closed(Closure::Base)
        );
        let region = &filled.report.regions[0];
        assert_eq!(region.closure, Some(Closure::Base));
        assert_eq!((region.intersecting_faces, region.balloons()), (0, false));
        let count = mesh.positions.len();
        assert_eq!(bits(&filled.mesh.positions[..count]), bits(&mesh.positions));
        let level = filled.mesh.positions[count].z;
        assert!(filled.mesh.positions[count..].iter().all(|p| p.z == level));
        match offset {
            Some(length) => assert!((level - (lowest - length)).abs() < 1e-12),
            // The mean edge length of the border: above 1, because the border rises and falls.
            None => assert!((1.0..1.2).contains(&(lowest - level)), "{level}"),
        }
        let expected = between(&mesh, level);
        assert!((volume(&filled.mesh) - expected).abs() < 1e-9 * expected);
    }
}

#[test]
fn a_base_along_any_axis_encloses_the_same_volume() {
    let turns: [fn(DVec3) -> DVec3; 3] = [
        |p| p,
        |p| DVec3::new(p.z, p.x, p.y),
        |p| DVec3::new(p.x, -p.y, -p.z),
    ];
    let params = FillParams::new().with_flat_base(true).with_base_offset(2.0);
    let volumes = turns.map(|up| {
        let filled = fill(&terrain(up, true), &params).unwrap();
        // The inner hole is filled as usual.
        assert_eq!(topology(&filled.mesh), (0, 2));
        assert_eq!(filled.report.tally().base, 1);
        assert_eq!(filled.report.tally().level_set, 1);
        volume(&filled.mesh)
    });
    assert!(
        volumes.iter().all(|v| (v / volumes[0] - 1.0).abs() < 1e-3),
        "{volumes:?}"
    );
}

#[test]
fn tasks_plans_and_repairs_make_the_same_base() {
    let mesh = terrain(|p| p, true);
    let params = FillParams::new().with_flat_base(true);
    let whole = fill(&mesh, &params).unwrap().mesh;
    let found = Inspection::new(&mesh).unwrap();
    let regions = found.regions(&params).unwrap();
    let plan = found.plan(&params).unwrap();
    let mut plans: Vec<_> = plan.holes.iter().map(|h| &h.outcome).collect();
    plans.sort_by_key(|p| p.is_some());
    assert_eq!(plans, [&None, &Some(HoleOutcome::Closed(Closure::Base))]);
    let patches = regions.tasks().map(|task| {
        let written = serde_json::to_string(&task).unwrap();
        let read: RegionTask = serde_json::from_str(&written).unwrap();
        read.solve(&Control::new())
    });
    let patches = patches.collect::<Result<_, _>>().unwrap();
    assert_eq!(regions.assemble(patches).unwrap().mesh, whole);
    let asked = RepairParams::new().with_fill(params);
    let repaired = repair(&mesh, &asked, &Carried::default(), &Control::new()).unwrap();
    assert_eq!(topology(&repaired.mesh), (0, 2));
    assert_eq!(repaired.report.lost_faces, 0);
}

#[test]
fn the_border_stays_open_if_no_base_fits() {
    // With the offset 0, the base touches the terrain at its lowest vertex, which is not on the border.
    let params = FillParams::new().with_flat_base(true).with_base_offset(0.0);
    let mesh = terrain(|p| p, false);
    let touching = fill(&mesh, &params).unwrap();
    let text = touching.report.holes[0].outcome.clone();
    assert!(matches!(text, HoleOutcome::Open(_)), "{text:?}");
    assert!(format!("{text:?}").contains("base_offset"));
    assert_eq!(touching.mesh, mesh);
    // A border that intersects itself in the view from above.
    let overhang = terrain(
        |p| DVec3::new(p.x + 2.5 * p.z * (p.y - 12.0), p.y, p.z),
        false,
    );
    let left = fill(&overhang, &FillParams::new().with_flat_base(true)).unwrap();
    assert!(matches!(left.report.holes[0].outcome, HoleOutcome::Open(_)));
    // An offset without a base and a negative offset are refused.
    let alone = FillParams::new().with_base_offset(1.0);
    assert!(alone.check().unwrap_err().to_string().contains("flat_base"));
    let negative = FillParams::new()
        .with_flat_base(true)
        .with_base_offset(-1.0);
    assert!(
        negative
            .check()
            .unwrap_err()
            .to_string()
            .contains("base_offset")
    );
}
