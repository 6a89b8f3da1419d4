//! Holes filled with a counterpart: the mirrored mesh, or a template.

use std::sync::Arc;

use glam::{DMat3, DVec3};
use isomend::{
    Closure, Control, CounterpartKind, CounterpartReport, FillError, FillParams, Filled, Finish,
    Inspection, Like, Mesh, NotLike, RestoreParams, fill, restore,
};

use crate::shapes::{Noise, cut, sphere, turn};

/// A bump of a body: direction, width, height.
type Bump = (DVec3, f64, f64);

/// Direction of the bump that is cut out.
fn place() -> DVec3 {
    DVec3::new(0.7, 0.4, 0.6).normalize()
}

/// An ellipsoid with bumps, and radial noise; `noise` is its root mean square in edges.
fn body(bumps: &[Bump], noise: f64) -> Mesh {
    let mut mesh = sphere(22);
    let edge = 0.057;
    let mut random = Noise(5);
    for p in &mut mesh.positions {
        let height: f64 = bumps
            .iter()
            .map(|(at, width, height)| height * (-(p.distance(*at) / width).powi(2)).exp())
            .sum();
        let rough = noise * edge * random.next() * 3.0_f64.sqrt();
        *p = *p * DVec3::new(1.0, 1.3, 0.9) + *p * (height + rough);
    }
    mesh
}

fn mirrored(bumps: &[Bump]) -> Vec<Bump> {
    let other = |&(at, width, height): &Bump| (at * DVec3::new(-1.0, 1.0, 1.0), width, height);
    let others: Vec<Bump> = bumps.iter().map(other).collect();
    [bumps, &others].concat()
}

/// Bumps on both sides and on the plane of symmetry, and one on one side only.
fn symmetric() -> Vec<Bump> {
    let eye = DVec3::new(0.4, -0.5, 0.8).normalize();
    let mut bumps = mirrored(&[(place(), 0.14, 0.15), (eye, 0.12, 0.08)]);
    bumps.push((DVec3::new(0.0, 0.1, 1.0).normalize(), 0.15, 0.1));
    bumps.push((DVec3::new(-0.8, -0.6, -0.2).normalize(), 0.25, 0.25));
    bumps
}

/// A mesh without the faces near a direction of the unit sphere, from which the body was scaled.
fn opened(mesh: &Mesh, at: DVec3) -> Mesh {
    cut(mesh, |p| {
        (p / DVec3::new(1.0, 1.3, 0.9)).normalize().distance(at) < 0.3
    })
}

/// Root mean square distance of the new vertices from another mesh: from its vertices and the planes of nearby faces.
fn error(filled: &Filled, open: &Mesh, truth: &Mesh) -> f64 {
    let new = &filled.mesh.positions[open.positions.len()..];
    // Of each face a corner, the middle and the normal.
    let plane = |f: &[u32; 3]| {
        let [a, b, c] = f.map(|v| truth.positions[v as usize]);
        [a, (a + b + c) / 3.0, (b - a).cross(c - a).normalize()]
    };
    let planes: Vec<[DVec3; 3]> = truth.faces.iter().map(plane).collect();
    let nearest = |p: &DVec3| {
        // The distance from the planes of nearby faces.
        let nearby = planes.iter().filter(|f| p.distance_squared(f[1]) < 0.0016);
        let all = nearby.map(|[a, _, normal]| (*p - *a).dot(*normal).abs());
        let near = all.fold(f64::INFINITY, f64::min);
        let corners = truth.positions.iter().map(|q| p.distance(*q));
        corners.fold(near, f64::min)
    };
    let squares: f64 = new.iter().map(|p| nearest(p).powi(2)).sum();
    (squares / new.len() as f64).sqrt()
}

fn found(filled: &Filled) -> &CounterpartReport {
    filled.report.regions[0].counterpart.as_ref().unwrap()
}

fn mirror() -> FillParams {
    FillParams::new().with_like(Like::Mirror(None))
}

#[test]
fn what_was_cut_out_of_a_symmetric_body_comes_back() {
    let truth = body(&symmetric(), 0.0);
    for noise in [0.0, 0.15] {
        let open = opened(&body(&symmetric(), noise), place());
        let smooth = fill(&open, &FillParams::default()).unwrap();
        let like = fill(&open, &mirror()).unwrap();
        let region = &like.report.regions[0];
        assert_eq!(region.closure, Some(Closure::Counterpart), "{noise}");
        assert_eq!(region.intersecting_faces, 0);
        let errors = [&smooth, &like].map(|filled| error(filled, &open, &truth));
        assert!(errors[1] < errors[0] / 3.0, "{noise}: {errors:?}");
        let report = found(&like);
        let Some(CounterpartKind::Mirror([_, normal])) = report.kind else {
            panic!("{:?}", report.kind);
        };
        assert!(normal.x.abs() > 0.999, "{normal}");
        assert_eq!(report.refused, None);
        assert!(report.misfit < report.feature, "{report:?}");
        // The input is unchanged, and every new vertex has an expected error.
        assert_eq!(
            like.mesh.positions[..open.positions.len()],
            open.positions[..]
        );
        let expected: Vec<f64> = like.expected_error.iter().flatten().copied().collect();
        assert_eq!(expected.len(), like.expected_error.len());
    }
}

#[test]
fn normals_of_planes_need_no_unit_length_but_must_not_be_zero() {
    let open = opened(&body(&symmetric(), 0.1), place());
    let by = |normal: DVec3| {
        let plane = Like::Mirror(Some([DVec3::ZERO, normal]));
        fill(&open, &FillParams::new().with_like(plane))
    };
    assert_eq!(by(DVec3::X).unwrap().mesh, by(DVec3::X * 8.0).unwrap().mesh);
    for wrong in [DVec3::ZERO, DVec3::X * f64::NAN] {
        assert!(matches!(by(wrong), Err(FillError::Parameter { .. })));
    }
}

/// A mesh with a cavity below it, nearer than the middle of the hole is to its rim.
fn hollow(mut mesh: Mesh) -> Mesh {
    let (inner, first) = (body(&[], 0.0), mesh.positions.len() as u32);
    mesh.positions
        .extend(inner.positions.iter().map(|p| *p * 0.88));
    let turned = inner.faces.iter().map(|&[a, b, c]| [a, c, b]);
    mesh.faces.extend(turned.map(|f| f.map(|v| first + v)));
    mesh
}

#[test]
fn thin_walls_are_filled_after_their_counterpart_too() {
    let truth = body(&symmetric(), 0.0);
    for noise in [0.0, 0.05] {
        let open = hollow(opened(&body(&symmetric(), noise), place()));
        let smooth = fill(&open, &FillParams::default()).unwrap();
        let like = fill(&open, &mirror()).unwrap();
        let region = &like.report.regions[0];
        let used = region.closure == Some(Closure::Counterpart);
        assert!(used, "{noise}: {:?}", region.counterpart);
        let errors = [&smooth, &like].map(|filled| error(filled, &open, &truth));
        assert!(errors[1] < errors[0] / 3.0, "{noise}: {errors:?}");
    }
}

#[test]
fn bytes_do_not_depend_on_threads_or_tasks() {
    let open = opened(&body(&symmetric(), 0.1), place());
    let found = Inspection::new(&open).unwrap();
    let one = found.fill(&mirror(), &Control::new().threads(1)).unwrap();
    let several = found.fill(&mirror(), &Control::new().threads(3)).unwrap();
    assert_eq!(one.mesh, several.mesh);
    let (params, control) = (mirror(), Control::new());
    let regions = found.regions(&params).unwrap();
    let tasks = regions.tasks().map(|task| {
        let text = serde_json::to_string(&task).unwrap();
        let read: isomend::RegionTask = serde_json::from_str(&text).unwrap();
        read.solve(&control).unwrap()
    });
    let together = regions.assemble(tasks.collect()).unwrap();
    assert_eq!(together.mesh, one.mesh);
}

#[test]
fn without_symmetry_nothing_changes() {
    let mut random = Noise(9);
    for round in [0, 2] {
        let bump = |k: u32| {
            let width = 0.3 + 0.03 * f64::from(k);
            (
                random.vector().normalize(),
                width,
                if k.is_multiple_of(2) { 0.2 } else { -0.2 },
            )
        };
        let bumps: Vec<Bump> = (0..12).map(bump).collect();
        let open = opened(&body(&bumps, 0.05 * f64::from(round)), place());
        let (smooth, like) = (
            fill(&open, &FillParams::default()).unwrap(),
            fill(&open, &mirror()).unwrap(),
        );
        assert!(found(&like).refused.is_some());
        assert_eq!(like.mesh, smooth.mesh);
        assert_eq!(like.expected_error, smooth.expected_error);
    }
}

#[test]
fn what_lies_on_the_plane_or_is_open_on_both_sides_is_refused() {
    let middle = DVec3::new(0.0, 0.1, 1.0).normalize();
    let plane = Like::Mirror(Some([DVec3::ZERO, DVec3::X]));
    let with_plane = FillParams::new().with_like(plane);
    let body = body(&symmetric(), 0.05);
    let own = fill(&opened(&body, middle), &with_plane).unwrap();
    assert_eq!(found(&own).refused, Some(NotLike::Own));
    assert_ne!(own.report.regions[0].closure, Some(Closure::Counterpart));
    let both = opened(
        &opened(&body, place()),
        place() * DVec3::new(-1.0, 1.0, 1.0),
    );
    let open = fill(&both, &with_plane).unwrap();
    assert_eq!(open.report.regions.len(), 2);
    for region in &open.report.regions {
        let report = region.counterpart.as_ref().unwrap();
        assert_eq!(report.refused, Some(NotLike::Open));
    }
}

#[test]
fn a_template_is_turned_shifted_and_scaled() {
    let truth = body(&symmetric(), 0.0);
    let open = opened(&body(&symmetric(), 0.1), place());
    let smooth = fill(&open, &FillParams::default()).unwrap();
    let smooth = error(&smooth, &open, &truth);
    let moved = |matrix: DMat3| {
        let at = |p: &DVec3| matrix * *p + DVec3::new(5.0, -3.0, 40.0);
        let positions = truth.positions.iter().map(at).collect();
        Like::template("cast.ply", Mesh::new(positions, truth.faces.clone()))
    };
    for (matrix, scale) in [(turn(), false), (turn() * 25.4, true)] {
        let like = FillParams::new().with_like(moved(matrix));
        let filled = fill(&open, &like).unwrap();
        let region = &filled.report.regions[0];
        assert_eq!(region.closure, Some(Closure::Counterpart), "{scale}");
        let Some(CounterpartKind::Template(by)) = found(&filled).kind else {
            panic!("no template");
        };
        let wanted = if scale { 1.0 / 25.4 } else { 1.0 };
        assert!((by / wanted - 1.0).abs() < 1e-3, "{by}");
        let own = error(&filled, &open, &truth);
        assert!(own < smooth / 3.0, "{own} {smooth}");
    }
    // A template of another shape is refused.
    let other = FillParams::new().with_like(Like::template("cube", crate::shapes::cube(4)));
    let filled = fill(&open, &other).unwrap();
    assert!(found(&filled).refused.is_some());
}

#[test]
fn worn_parts_are_restored_from_the_other_side() {
    let mut worn = symmetric();
    worn.remove(0);
    let (truth, worn) = (body(&symmetric(), 0.0), body(&worn, 0.1));
    let at = place() * DVec3::new(1.0, 1.3, 0.9);
    let is_marked = |f: &[u32; 3]| {
        let middle = f.iter().map(|&v| worn.positions[v as usize]).sum::<DVec3>() / 3.0;
        middle.distance(at) < 0.35
    };
    let marked: Vec<bool> = worn.faces.iter().map(is_marked).collect();
    let mut params = RestoreParams::default();
    params.fill = mirror();
    let done = restore(&worn, &marked, &params).unwrap();
    let region = &done.fill.regions[0];
    assert_eq!(region.closure, Some(Closure::Counterpart));
    let top = at + place() * 0.15;
    let near = |mesh: &Mesh| {
        let all = mesh.positions.iter().map(|p| p.distance(top));
        all.fold(f64::INFINITY, f64::min)
    };
    assert!(near(&done.mesh) < 2.0 * near(&truth) + 0.03 && near(&worn) > 0.1);
}

#[test]
fn parameters_that_do_not_go_together_are_refused() {
    let mesh = cut(&sphere(6), |p| p.z > 0.8);
    let unread: Like = "cast.ply".parse().unwrap();
    let nan = Arc::new(Mesh::new(vec![DVec3::NAN; 3], vec![[0, 1, 2]]));
    for params in [
        mirror().with_finish(Finish::None),
        FillParams::new().with_like(unread),
        FillParams::new().with_grain(true).with_finish(Finish::None),
    ] {
        let error = fill(&mesh, &params).unwrap_err();
        assert!(matches!(error, FillError::Parameter { .. }), "{error}");
    }
    let broken = FillParams::new().with_like(Like::template("broken", nan));
    assert!(fill(&mesh, &broken).is_err());
    let empty = Like::template("empty", Mesh::default());
    if let Ok(filled) = fill(&mesh, &FillParams::new().with_like(empty)) {
        assert!(found(&filled).refused.is_some());
    }
}

#[test]
fn sizes_beyond_fast_distances_are_refused_with_the_reason() {
    let whole = sphere(6);
    let open = cut(&whole, |p| p.distance(DVec3::Z) < 0.5);
    let scaled = |factor: f64| {
        let positions = open.positions.iter().map(|p| factor * *p).collect();
        Mesh::new(positions, open.faces.clone())
    };
    let refused = |mesh: &Mesh, like: Like| match fill(mesh, &FillParams::default().with_like(like))
    {
        Err(error @ FillError::Parameter { .. }) => error.to_string().contains("1e18"),
        _ => false,
    };
    for far in [1e30, 1e65, 1e-30] {
        assert!(refused(&scaled(far), Like::Mirror(None)), "{far}");
        let template = Like::template("template", scaled(far));
        assert!(refused(&open, template), "{far}");
    }
    assert!(!refused(&open, Like::Mirror(None)));
}
