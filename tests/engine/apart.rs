//! Rims that are closed each by itself.

use std::collections::HashSet;

use isomend::check::CheckParams;
use isomend::glam::DVec3;
use isomend::{
    Closure, Control, CounterpartKind, FillParams, Finish, HoleOutcome, LeftReason, Mesh,
    NotSmooth, RestoreParams, fill, inspect,
};

use crate::shapes::{HALF, cut, joined, moved, sheet, slab, sphere, topology, volume};

/// A plate with a hole through it, and the whole plate; bent into a bowl.
fn plate(bend: f64) -> [Mesh; 2] {
    let mut whole = slab(16);
    for p in &mut whole.positions {
        p.z = 0.2 * p.z + bend * (p.x * p.x + p.y * p.y);
    }
    [cut(&whole, |c| c.x.hypot(c.y) < 0.5), whole]
}

/// A plate with a hole whose rims are joined by straight faces.
fn with_edge(open: &Mesh) -> Mesh {
    let key = |v: u32| {
        let p = open.positions[v as usize];
        [p.x, p.y].map(|x| (x * 1e6).round() as i64)
    };
    let sides = open
        .faces
        .iter()
        .flat_map(|f| (0..3).map(|k| (f[k], f[(k + 1) % 3])));
    let sides: HashSet<(u32, u32)> = sides.collect();
    let mut rim: Vec<(u32, u32)> = sides
        .iter()
        .filter(|(a, b)| !sides.contains(&(*b, *a)))
        .copied()
        .collect();
    rim.sort_unstable();
    let is_upper = |(a, b): &(u32, u32)| {
        rim.iter().all(|(c, d)| {
            key(*c) != key(*b) || key(*d) != key(*a) || height(open, *c) <= height(open, *b)
        })
    };
    let mut window = open.clone();
    for (a, b) in rim.iter().filter(|e| is_upper(e)) {
        let below = rim
            .iter()
            .find(|(c, d)| key(*c) == key(*b) && key(*d) == key(*a))
            .unwrap();
        window
            .faces
            .extend([[*b, *a, below.1], [*b, below.1, below.0]]);
    }
    window
}

fn height(mesh: &Mesh, v: u32) -> f64 {
    mesh.positions[v as usize].z
}

#[test]
fn each_side_of_a_wall_gets_a_patch_of_its_own() {
    for bend in [0.2, 0.5] {
        let [open, whole] = plate(bend);
        let window = with_edge(&open);
        // The edge of the window is marked: it is made again, or closed on both sides.
        let centre = |f: &[u32; 3]| {
            f.iter()
                .map(|v| window.positions[*v as usize] / 3.0)
                .sum::<DVec3>()
        };
        let marked: Vec<bool> = (window.faces.iter())
            .map(|f| centre(f).truncate().length() < 0.6)
            .collect();
        let restored = |apart: bool| {
            let mut params = RestoreParams::default();
            params.fill.apart = apart;
            let found = inspect(&window).unwrap();
            found.restore(&marked, &params, &Control::new()).unwrap()
        };
        let again = restored(false);
        assert_eq!(again.fill.regions.len(), 1, "{bend}");
        assert_eq!(again.fill.joined_walls(), [[1.into(), 2.into()]]);
        assert!(volume(&again.mesh) < 0.9 * volume(&whole));
        let closed = restored(true);
        assert_eq!(closed.fill.regions.len(), 2, "{bend}");
        assert!(closed.fill.joined_walls().is_empty());
        let verdict = inspect(&closed.mesh)
            .unwrap()
            .check(&CheckParams::default());
        assert!(verdict.is_sound(), "{bend}: {}", verdict.line());
        let relative = volume(&closed.mesh) / volume(&whole);
        assert!((relative - 1.0).abs() < 5e-3, "{bend}: {relative}");
        assert_eq!(topology(&closed.mesh), topology(&whole));
    }
}

#[test]
fn rims_that_the_caller_joins_are_joined() {
    let [open, _] = plate(0.2);
    let params = FillParams::new().with_apart(true).with_bridges([[1, 2]]);
    let filled = fill(&open, &params).unwrap();
    assert_eq!(filled.report.regions.len(), 1);
}

#[test]
fn the_border_of_an_island_stays_open() {
    let plane = cut(&sheet(24), |c| c.truncate().length() < 0.6);
    let island = moved(&sheet(8), 0.2, DVec3::ZERO);
    let mesh = joined(&plane, &island);
    let open = |apart: bool| {
        let filled = fill(&mesh, &FillParams::new().with_apart(apart)).unwrap();
        assert!(filled.report.joined_walls().is_empty());
        let outcomes = filled.report.holes.iter().map(|h| h.outcome.clone());
        let left = HoleOutcome::Left(LeftReason::OuterBoundary);
        outcomes.filter(|o| *o == left).count()
    };
    assert_eq!([open(false), open(true)], [1, 2]);
}

#[test]
fn the_edge_of_an_opening_in_a_flat_or_coarse_wall_is_straight() {
    let thin = |n: u32, bend: f64| {
        let mut whole = slab(n);
        for p in &mut whole.positions {
            p.z = 0.05 * p.z + bend * p.x * p.x;
        }
        cut(&whole, |c| c.x.abs().max(c.y.abs()) < 0.5)
    };
    for open in [thin(16, 0.0), thin(4, 0.1)] {
        let window = with_edge(&open);
        // Turned inside out it is closed in the same way.
        for is_turned in [false, true] {
            let mut given = open.clone();
            given
                .faces
                .iter_mut()
                .filter(|_| is_turned)
                .for_each(|f| f.swap(1, 2));
            let filled = fill(&given, &FillParams::new()).unwrap();
            let closure = Closure::RimTriangles(NotSmooth::StraightEdge);
            assert_eq!(filled.report.regions[0].closure, Some(closure));
            assert_eq!(topology(&filled.mesh), topology(&window));
            let relative = volume(&filled.mesh).abs() / volume(&window);
            assert!((relative - 1.0).abs() < 1e-3, "{relative}");
            assert_eq!(filled.report.regions[0].intersecting_faces, 0);
        }
    }
}

/// A wall with a hole through it: heights of its upper and lower side.
struct Wall {
    name: &'static str,
    sides: [fn(f64, f64) -> f64; 2],
    /// Upper bound of the root mean square error of a patch, in diameters of the hole.
    most_error: f64,
}

/// Plates, a bowl, a saddle whose rims lie in no plane, and a lens that thins outward.
const WALLS: [Wall; 4] = [
    Wall {
        name: "plate",
        sides: [|_, _| 0.2, |_, _| 0.0],
        most_error: 1e-6,
    },
    Wall {
        name: "bowl",
        sides: [
            |x, y| 0.2 + 0.4 * (x * x + y * y),
            |x, y| 0.4 * (x * x + y * y),
        ],
        most_error: 4e-3,
    },
    Wall {
        name: "saddle",
        sides: [
            |x, y| 0.15 + 0.4 * (x * x - y * y),
            |x, y| 0.4 * (x * x - y * y),
        ],
        most_error: 4e-3,
    },
    Wall {
        name: "lens",
        sides: [
            |x, y| (3.0 - x * x - y * y).sqrt() - 0.9,
            |x, y| 0.9 - (3.0 - x * x - y * y).sqrt(),
        ],
        most_error: 2e-3,
    },
];

/// A wall over the square from -1 to 1, with edges of `1 / n`, and a round hole of radius 0.5.
fn pierced(wall: &Wall, n: u32) -> Mesh {
    let mut whole = slab(n);
    for p in &mut whole.positions {
        let [upper, lower] = wall.sides.map(|side| side(p.x, p.y));
        p.z = lower + (p.z + HALF) * (upper - lower);
    }
    cut(&whole, |c| c.x.hypot(c.y) < 0.5)
}

#[test]
fn patches_of_wide_walls_are_near_the_known_sides() {
    for (wall, n) in WALLS.iter().zip([28, 28, 40, 75]) {
        let open = pierced(wall, n);
        let filled = fill(&open, &FillParams::new().with_apart(true)).unwrap();
        assert_eq!(filled.report.regions.len(), 2, "{}", wall.name);
        for hole in &filled.report.holes {
            assert!(
                (100..=330).contains(&hole.hole.edges),
                "{}",
                hole.hole.edges
            );
        }
        let verdict = inspect(&filled.mesh)
            .unwrap()
            .check(&CheckParams::default());
        assert!(verdict.is_sound(), "{}: {}", wall.name, verdict.line());
        let first = open.positions.len();
        let new = filled.mesh.positions[first..].iter();
        let errors: Vec<f64> = new
            .map(|p| {
                let off = wall.sides.map(|side| (p.z - side(p.x, p.y)).abs());
                off[0].min(off[1])
            })
            .collect();
        let mean = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
        assert!(mean < wall.most_error, "{}: {mean}", wall.name);
        for (error, expected) in errors.iter().zip(&filled.expected_error) {
            let expected = expected.unwrap();
            assert!(
                *error <= 5.0 * expected + 1e-6,
                "{}: {error}, {expected}",
                wall.name
            );
        }
    }
}

#[test]
fn the_edge_of_a_wide_window_is_made_again() {
    let wall = &WALLS[1];
    let open = pierced(wall, 28);
    let window = with_edge(&open);
    let before = volume(&window);
    let centre = |f: &[u32; 3]| {
        let corners = f.iter().map(|v| window.positions[*v as usize] / 3.0);
        corners.sum::<DVec3>()
    };
    // One half of the edge is marked.
    let is_marked = |f: &[u32; 3]| {
        let c = centre(f);
        c.x > 0.0 && c.truncate().length() < 0.6
    };
    let marked: Vec<bool> = window.faces.iter().map(is_marked).collect();
    let found = inspect(&window).unwrap();
    let restored = found
        .restore(&marked, &RestoreParams::default(), &Control::new())
        .unwrap();
    let verdict = inspect(&restored.mesh)
        .unwrap()
        .check(&CheckParams::default());
    assert!(verdict.is_sound(), "{}", verdict.line());
    assert_eq!(topology(&restored.mesh), topology(&window));
    let relative = volume(&restored.mesh) / before;
    assert!((relative - 1.0).abs() < 0.05, "{relative}");
}

/// A point of a head-like surface in a direction: an egg with ridges and hollows, the same on both sides of x = 0.
fn on_head(direction: DVec3) -> DVec3 {
    let d = direction.normalize();
    let relief = 0.05 * (5.0 * d.y + 1.0).sin() * (6.0 * d.x.abs()).cos()
        + 0.03 * (7.0 * d.z).sin() * (4.0 * d.x * d.x + 3.0 * d.y).cos();
    d * DVec3::new(0.8, 1.0, 0.9) * (1.0 + 0.15 * d.y * d.z + relief)
}

#[test]
fn a_wide_patch_is_weighed_with_the_mirror_image() {
    let mut whole = sphere(40);
    for p in &mut whole.positions {
        *p = on_head(*p);
    }
    let open = cut(&whole, |c| c.distance(DVec3::new(0.75, 0.1, 0.2)) < 0.5);
    // Root mean square distance of the new vertices from the head, along the rays from its middle.
    let filled = |open: &Mesh, params: &FillParams| {
        let filled = fill(open, params).unwrap();
        let new = &filled.mesh.positions[open.positions.len()..];
        let off = new.iter().map(|p| p.distance_squared(on_head_at(*p)));
        let rms = (off.sum::<f64>() / new.len() as f64).sqrt();
        (rms, filled.report)
    };
    let (smooth, report) = filled(&open, &FillParams::new());
    assert!(
        report.holes[0].hole.edges >= 100,
        "{}",
        report.holes[0].hole.edges
    );
    assert_eq!(report.regions[0].counterpart, None);
    let (rms, report) = filled(&open, &FillParams::new().with_apart(true));
    let image = report.regions[0].counterpart.clone().unwrap();
    let Some(CounterpartKind::Mirror([_, normal])) = image.kind else {
        panic!("{image:?}");
    };
    assert!(normal.x.abs() > 0.999, "{normal}");
    assert!(image.weight.is_some_and(|w| w > 0.5), "{image:?}");
    assert!(rms < 0.5 * smooth, "{rms} {smooth}");
    // Expected errors are the combined ones, not far from the real ones.
    let largest = report.regions[0].largest_expected_error.unwrap();
    assert!(
        largest > 0.5 * rms && largest < 20.0 * rms,
        "{largest} {rms}"
    );
    // A hole that reaches over the plane of symmetry: its own patch is a part of its mirror image.
    let open = cut(&whole, |c| c.distance(DVec3::new(0.15, 0.9, 0.3)) < 0.5);
    let (smooth, _) = filled(&open, &FillParams::new());
    let (rms, report) = filled(&open, &FillParams::new().with_apart(true));
    let image = report.regions[0].counterpart.clone().unwrap();
    assert!(
        image.weight.is_some_and(|w| w > 0.2 && w < 0.6),
        "{image:?}"
    );
    assert!(rms < 0.9 * smooth, "{rms} {smooth}");
    // Without the blend with what the surroundings predict there is no image either.
    let alone = FillParams::new()
        .with_apart(true)
        .with_finish(Finish::Willmore);
    assert_eq!(filled(&open, &alone).1.regions[0].counterpart, None);
}

/// The point of the head on the ray through a point.
fn on_head_at(p: DVec3) -> DVec3 {
    // The direction whose point lies on the ray: the stretch of the axes is undone by fixed-point steps.
    let mut direction = p;
    for _ in 0..60 {
        direction += p.normalize() - on_head(direction).normalize();
    }
    on_head(direction)
}

#[test]
fn a_bore_of_any_depth_gets_its_wall() {
    let mut whole = slab(16);
    whole.positions.iter_mut().for_each(|p| p.z *= 1.5);
    let open = cut(&whole, |c| c.truncate().length() < 0.5);
    let bored = fill(&open, &FillParams::default()).unwrap();
    assert_eq!(bored.report.joined_walls(), [[1.into(), 2.into()]]);
    let straight = Closure::RimTriangles(NotSmooth::StraightEdge);
    for hole in &bored.report.holes {
        assert_eq!(hole.outcome, HoleOutcome::Closed(straight.clone()));
    }
    // A closed surface with one handle.
    assert_eq!(topology(&bored.mesh), topology(&with_edge(&open)));
    assert!((volume(&bored.mesh) - volume(&with_edge(&open))).abs() < 1e-9);
    // Each end by itself, where the caller says so, or a body is in the way.
    let ends = fill(&open, &FillParams::new().with_apart(true)).unwrap();
    assert!((volume(&ends.mesh) - volume(&whole)).abs() < 1e-9);
    let with_ball = joined(&open, &moved(&sphere(3), 0.7, DVec3::ZERO));
    let ends = fill(&with_ball, &FillParams::default()).unwrap();
    assert_eq!(ends.report.regions.len(), 2);
    assert!(ends.report.joined_walls().is_empty());
}

#[test]
fn rims_that_differ_are_no_bore() {
    let mut whole = slab(16);
    whole.positions.iter_mut().for_each(|p| p.z *= 1.5);
    let radius = |z: f64| if z > 0.0 { 0.5 } else { 0.4 };
    let open = cut(&whole, |c| c.truncate().length() < radius(c.z));
    let filled = fill(&open, &FillParams::default()).unwrap();
    assert!((volume(&filled.mesh) - volume(&whole)).abs() < 1e-9);
}
