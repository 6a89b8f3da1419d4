//! Sharp edges (creases) that end at rims: detection, numbering, continuation over holes, and pairs of ends chosen by the caller.

use glam::DVec3;
use isomend::{
    Attributes, Cancel, Carried, Closure, Control, FillError, FillParams, Finish, Inspection, Mask,
    Mesh, NotContinued, RepairParams, RestoreParams, Selector, Sharp, fill, repair, restore,
};

use crate::shapes::{blocked_cube, cube, cut, open_cube, sphere, topology, turned, volume};

fn asked(pairs: &[[usize; 2]]) -> FillParams {
    FillParams::new().with_creases(pairs.iter().copied())
}

/// The hole across an edge of the cube: its number and the numbers of the two crease ends there.
fn across_edge(found: &Inspection) -> (usize, [usize; 2]) {
    let ends = found.crease_ends(&Control::new()).unwrap();
    let of = |hole: usize| {
        let own = ends.iter().filter(move |end| end.hole.get() == hole);
        own.map(|end| end.id).collect::<Vec<usize>>()
    };
    let hole = (1..=2).find(|&hole| of(hole).len() == 2).unwrap();
    (hole, [of(hole)[0], of(hole)[1]])
}

#[test]
fn ends_of_edges_are_numbered_over_all_holes() {
    let mesh = open_cube();
    let found = Inspection::new(&mesh).unwrap();
    let ends = found.crease_ends(&Control::new()).unwrap();
    assert_eq!(ends.len(), 5);
    for (end, id) in ends.iter().zip(1..) {
        assert_eq!(end.id, id);
        assert_eq!(end.position, mesh.positions[end.vertex as usize]);
        assert!((end.angle - 90.0).abs() < 1e-6, "{}", end.angle);
        let hole = &found.holes[end.hole.get() - 1];
        assert!(hole.rim.contains(&end.vertex));
        // A point on an edge of the cube has two coordinates that are 0 or 12.
        let on_sides = end.position.to_array().map(|x| x == 0.0 || x == 12.0);
        assert_eq!(on_sides.iter().filter(|on| **on).count(), 2);
    }
    assert!(ends.windows(2).all(|w| w[0].hole <= w[1].hole));
    for threads in [1, 3] {
        assert_eq!(
            found.crease_ends(&Control::new().threads(threads)).unwrap(),
            ends
        );
    }
    let cancel = Cancel::new();
    cancel.cancel();
    let stopped = found.crease_ends(&Control::new().cancel(&cancel));
    assert!(matches!(stopped, Err(FillError::Cancelled)));
    // Smooth shapes have no crease ends.
    let ball = cut(&sphere(10), |p| p.z > 0.8 || p.distance(DVec3::X) < 0.4);
    let ball = Inspection::new(&ball).unwrap();
    assert_eq!(ball.crease_ends(&Control::new()).unwrap(), []);
}

#[test]
fn sharp_edges_that_are_not_continued_are_reported() {
    let open = fill(&turned(open_cube()), &FillParams::default()).unwrap();
    for region in &open.report.regions {
        assert_eq!(region.closure, Some(Closure::Sides));
        assert!(region.crease_ends >= 2 && region.not_continued.is_none());
        assert!(!region.balloons());
    }
    assert!(open.report.flawless());
    let mesh = blocked_cube();
    let blocked = fill(&mesh, &FillParams::default()).unwrap();
    let lost = blocked
        .report
        .regions
        .iter()
        .find(|r| r.not_continued.is_some());
    let lost = lost.unwrap();
    assert_eq!(lost.crease_ends, 2);
    assert!(lost.creases.is_empty());
    assert_eq!(lost.intersecting_faces, 0);
    assert!(matches!(lost.not_continued, Some(NotContinued::Intersects(n)) if n > 0));
    assert!(!blocked.report.flawless());
    assert!(!blocked.report.incomplete());
    // With `sharp` off, sharp edges are not searched for and not reported as missing.
    let smooth = fill(&mesh, &FillParams::new().with_sharp(Sharp::Off)).unwrap();
    let is_seen = |r: &isomend::RegionReport| r.crease_ends > 0 || r.not_continued.is_some();
    assert!(!smooth.report.regions.iter().any(is_seen));
    assert!(smooth.report.flawless());
}

#[test]
fn an_edge_is_continued_between_two_ends_given_by_number() {
    let mesh = open_cube();
    let found = Inspection::new(&mesh).unwrap();
    let (hole, pair) = across_edge(&found);
    for pair in [pair, [pair[1], pair[0]]] {
        let filled = found.fill(&asked(&[pair, pair]), &Control::new()).unwrap();
        let region = &filled.report.regions[filled.report.holes[hole - 1].region - 1];
        assert_eq!(region.closure, Some(Closure::Sides));
        assert_eq!(region.creases.len(), 1);
        assert!((region.creases[0].angle - 90.0).abs() < 1e-6);
        let own = found.fill(&FillParams::default(), &Control::new()).unwrap();
        assert_eq!(filled.mesh, own.mesh);
        assert_eq!(topology(&filled.mesh), (0, 2));
    }
    // A pair chosen by the caller is also rejected if its sides intersect other faces, and the cause is reported.
    let blocked = Inspection::new(blocked_cube()).unwrap();
    let (hole, pair) = across_edge(&blocked);
    let filled = blocked.fill(&asked(&[pair]), &Control::new()).unwrap();
    let region = &filled.report.regions[filled.report.holes[hole - 1].region - 1];
    assert!(matches!(
        region.not_continued,
        Some(NotContinued::Intersects(_))
    ));
    assert_eq!(region.intersecting_faces, 0);
}

#[test]
fn invalid_pairs_of_ends_are_refused_before_the_fill() {
    let mesh = open_cube();
    let found = Inspection::new(&mesh).unwrap();
    let (hole, pair) = across_edge(&found);
    let other = if pair[0] == 1 { 5 } else { 1 };
    let refused = |params: FillParams| found.plan(&params).unwrap_err().to_string();
    assert!(refused(asked(&[[1, 6]])).contains("no crease end 6; 5 sharp edges"));
    assert!(refused(asked(&[[0, 1]])).contains("no crease end 0"));
    assert!(refused(asked(&[[2, 2]])).contains("the same end"));
    assert!(refused(asked(&[[pair[0], other]])).contains("two ends of one hole"));
    let one = || asked(&[pair]);
    assert!(refused(one().with_holes([3 - hole])).contains("not to be filled"));
    assert!(refused(one().with_keep_open([hole])).contains("not to be filled"));
    assert!(refused(one().with_flat([hole])).contains("flat cap"));
    assert!(refused(one().with_bridges([[1, 2]])).contains("together with others"));
    assert!(refused(one().with_sharp(Sharp::Off)).contains("`sharp` off"));
    assert!(refused(one().with_finish(Finish::None)).contains("only with a finish"));
    found.plan(&one()).unwrap();
}

#[test]
fn tasks_and_repairs_continue_the_given_pairs() {
    let mesh = open_cube();
    let found = Inspection::new(&mesh).unwrap();
    let (hole, pair) = across_edge(&found);
    let params = asked(&[pair]).with_holes([hole]);
    let whole = found.fill(&params, &Control::new()).unwrap();
    let regions = found.regions(&params).unwrap();
    let patches = regions.tasks().map(|task| task.solve(&Control::new()));
    let patches = patches.collect::<Result<_, _>>().unwrap();
    assert_eq!(regions.assemble(patches).unwrap().mesh, whole.mesh);
    // The repair removes the first face and its vertices, which changes the numbers of vertices, holes and ends.
    let mut dirty = Mesh::new(vec![DVec3::splat(3.0); 3], vec![[0, 1, 2]]);
    dirty.positions.extend(&mesh.positions);
    dirty
        .faces
        .extend(mesh.faces.iter().map(|f| f.map(|v| v + 3)));
    let before = Inspection::new(&dirty).unwrap();
    let (hole, pair) = across_edge(&before);
    let params = RepairParams::new().with_fill(asked(&[pair]).with_holes([hole]));
    let repaired = repair(&dirty, &params, &Carried::default(), &Control::new()).unwrap();
    let region = &repaired.fill.regions[0];
    assert_eq!(region.closure, Some(Closure::Sides));
    assert_eq!((region.crease_ends, region.creases.len()), (2, 1));
}

#[test]
fn a_hole_in_a_flat_side_has_no_crease_ends() {
    let mesh = cut(&cube(12), |p| p.distance(DVec3::new(6.0, 6.0, 12.0)) < 2.5);
    let filled = fill(&mesh, &FillParams::default()).unwrap();
    let region = &filled.report.regions[0];
    assert_eq!((region.crease_ends, &region.not_continued), (0, &None));
}

/// A cube with a dent at the middle of an edge.
fn dented_cube(centre: DVec3) -> Mesh {
    let mut mesh = cube(12);
    for p in &mut mesh.positions {
        let reach = 1.0 - p.distance(centre) / 2.5;
        if reach > 0.0 {
            *p += reach * DVec3::new(0.2, 1.0, -1.0);
        }
    }
    mesh
}

#[test]
fn restoring_a_dent_restores_the_sharp_edge() {
    let (centre, radius) = (DVec3::new(6.0, 0.0, 12.0), 3.2);
    let mesh = dented_cube(centre);
    let mask = Mask {
        selectors: vec![Selector::Ball { centre, radius }],
        ..Mask::default()
    };
    let marked = mask.faces(&mesh, &Attributes::default()).unwrap();
    let restored = restore(&mesh, &marked, &RestoreParams::default()).unwrap();
    assert!((volume(&mesh) - 1728.0).abs() > 1.0);
    assert!((volume(&restored.mesh) - 1728.0).abs() < 1e-6);
    assert_eq!(restored.fill.regions[0].creases.len(), 1);
}

#[test]
fn repairs_continue_sharp_edges_after_removing_faces() {
    let mut mesh = open_cube();
    // Two duplicates of a face, one of them turned.
    let [a, b, c] = mesh.faces[40];
    mesh.faces.extend([[a, b, c], [b, a, c]]);
    let whole = repair(
        &mesh,
        &RepairParams::new(),
        &Carried::default(),
        &Control::new(),
    )
    .unwrap();
    assert_eq!(whole.report.steps.duplicate_faces, 2);
    assert!((volume(&whole.mesh) - 1728.0).abs() < 1e-6);
    assert_eq!(topology(&whole.mesh), (0, 2));
}
