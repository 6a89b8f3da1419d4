//! Region tasks: written as JSON, solved elsewhere and assembled, they give the same patches as a fill.

#[cfg(target_os = "linux")]
use crate::cpu::{cpu, this_thread};
use crate::shapes;
use isomend::glam::DVec3;
use isomend::{
    Cancel, Control, FillError, FillParams, Mesh, RegionPatch, RegionTask, fill, inspect,
};

/// A value after a round trip through JSON.
fn sent<T: serde::Serialize + serde::de::DeserializeOwned>(value: &T) -> T {
    serde_json::from_str(&serde_json::to_string(value).unwrap()).unwrap()
}

/// The mesh filled region by region, with a round trip of each task and patch through JSON.
fn filled_in_parts(mesh: &Mesh, params: &FillParams) -> Mesh {
    let found = inspect(mesh).unwrap();
    let regions = found.regions(params).unwrap();
    let solved = |task: RegionTask| {
        let task: RegionTask = sent(&task);
        sent::<RegionPatch>(&task.solve(&Control::new().threads(2)).unwrap())
    };
    let patches: Vec<RegionPatch> = regions.tasks().map(solved).collect();
    assert_eq!(patches.len(), regions.len());
    regions.assemble(patches).unwrap().mesh
}

fn bits(mesh: &Mesh) -> Vec<[u64; 3]> {
    let bits = |p: &DVec3| p.to_array().map(f64::to_bits);
    mesh.positions.iter().map(bits).collect()
}

fn assert_same(mesh: &Mesh, params: &FillParams) {
    let (at_once, in_parts) = (
        fill(mesh, params).unwrap().mesh,
        filled_in_parts(mesh, params),
    );
    assert_eq!(bits(&in_parts), bits(&at_once));
    assert_eq!(in_parts.faces, at_once.faces);
}

fn with(mesh: &mut Mesh, other: &Mesh, by: DVec3) {
    let base = mesh.positions.len() as u32;
    mesh.positions
        .extend(other.positions.iter().map(|p| *p + by));
    mesh.faces
        .extend(other.faces.iter().map(|f| f.map(|v| v + base)));
}

/// A ball with a large round hole, a small one, and one missing triangle.
fn ball() -> Mesh {
    let sphere = shapes::sphere(10);
    let mut mesh = shapes::cut(&sphere, |p| p.z > 0.85 || p.distance(DVec3::X) < 0.25);
    let far = mesh
        .faces
        .iter()
        .position(|f| f.iter().all(|&v| mesh.positions[v as usize].z < -0.9));
    mesh.faces.remove(far.unwrap());
    mesh
}

#[test]
fn tasks_solved_elsewhere_give_the_same_bytes() {
    let mut params = FillParams::default();
    params.voxel = isomend::VoxelSize::Length(0.08);
    assert_same(&ball(), &params);
}

#[test]
fn a_task_holds_only_the_surroundings_of_its_region() {
    // A second ball reaches through the large hole of the first; a third is far away.
    let mut mesh = ball();
    with(&mut mesh, &shapes::sphere(6), DVec3::new(0.0, 0.0, 1.6));
    with(&mut mesh, &shapes::sphere(6), DVec3::new(40.0, 0.0, 0.0));
    let mut params = FillParams::default();
    params.voxel = isomend::VoxelSize::Length(0.08);
    assert_same(&mesh, &params);
    let found = inspect(&mesh).unwrap();
    let regions = found.regions(&params).unwrap();
    let sizes: Vec<usize> = regions
        .tasks()
        .map(|t| serde_json::to_string(&t).unwrap().len())
        .collect();
    let whole = serde_json::to_string(&found.mesh).unwrap().len();
    assert!(
        sizes.iter().any(|&size| size < whole),
        "{sizes:?} of {whole}"
    );
}

/// Size in bytes of the task of the only hole, with about 24 edges, in a sphere of `20 n²` faces.
fn bytes_of_task(n: u32, params: &FillParams) -> usize {
    let edge = 1.1 / f64::from(n);
    let mesh = shapes::cut(&shapes::sphere(n), |p| p.distance(DVec3::Z) < 4.0 * edge);
    let found = inspect(&mesh).unwrap();
    let regions = found.regions(params).unwrap();
    let task = regions.tasks().next().unwrap();
    serde_json::to_string(&task).unwrap().len()
}

#[test]
fn the_size_of_a_task_depends_on_its_region_and_not_on_the_mesh() {
    let params = FillParams::default();
    let [small, large] = [40, 160].map(|n| bytes_of_task(n, &params));
    // The finer sphere bends less over the hole's size, so that slightly more of it is within reach.
    assert!(large < 2 * small, "{small} bytes, then {large}");
    let sphere = shapes::sphere(160);
    let found = inspect(&sphere).unwrap();
    let whole = serde_json::to_string(&found.mesh).unwrap().len();
    assert!(20 * large < whole, "{large} bytes of {whole}");
}

#[test]
fn a_task_that_reaches_too_little_reports_it_and_closes_the_hole() {
    // A cap of 30 degrees: the box is widened twice for the rest of the sphere.
    let cap = shapes::cut(&shapes::sphere(20), |p| p.z < 0.86);
    let mut mesh = cap.clone();
    with(&mut mesh, &shapes::sphere(6), DVec3::new(60.0, 0.0, 0.0));
    let mut params = FillParams::default();
    params.holes = Some(vec![1.into()]);
    let found = inspect(&mesh).unwrap();
    let regions = found.regions(&params).unwrap();
    let [usual, wide] = [regions.tasks().next(), regions.wide_task(0)].map(Option::unwrap);
    let usual = usual.solve(&Control::new()).unwrap();
    assert!(usual.is_cramped());
    let wide = sent::<RegionTask>(&wide).solve(&Control::new()).unwrap();
    assert!(!wide.is_cramped());
    assert!(regions.wide_task(1).is_none());
    let at_once = fill(&mesh, &params).unwrap().mesh;
    for patch in [usual, wide] {
        let filled = regions.assemble(vec![patch]).unwrap().mesh;
        assert_eq!(bits(&filled), bits(&at_once));
        assert_eq!(filled.faces, at_once.faces);
    }
}

#[test]
fn damaged_tasks_and_missing_patches_are_refused() {
    let mesh = ball();
    let params = FillParams::default();
    let found = inspect(&mesh).unwrap();
    let regions = found.regions(&params).unwrap();
    let error = regions.assemble(Vec::new()).unwrap_err();
    assert!(
        matches!(
            error,
            FillError::Patches {
                regions: 3,
                patches: 0
            }
        ),
        "{error}"
    );
    let task = regions.tasks().last().unwrap();
    let mut written = serde_json::to_value(&task).unwrap();
    written["holes"][0]["rim"][0] = 1_000_000.into();
    let broken: RegionTask = serde_json::from_value(written).unwrap();
    assert!(matches!(
        broken.solve(&Control::new()),
        Err(FillError::Task)
    ));
    let cancel = Cancel::new();
    cancel.cancel();
    let stopped = task.solve(&Control::new().cancel(&cancel));
    assert!(matches!(stopped, Err(FillError::Cancelled)));
}

#[test]
fn one_inspection_serves_many_runs() {
    let mesh = ball();
    let found = inspect(&mesh).unwrap();
    let mut params = FillParams::default();
    params.voxel = isomend::VoxelSize::Length(0.08);
    for hole in 1..=3 {
        params = params.with_holes([hole]);
        let filled = found.fill(&params, &Control::new()).unwrap();
        assert_eq!(
            bits(&filled.mesh),
            bits(&fill(&mesh, &params).unwrap().mesh)
        );
    }
    let cancel = Cancel::new();
    let ended = std::sync::atomic::AtomicUsize::new(0);
    let progress = |step: &isomend::Step| {
        if let isomend::Event::Ended(_) = step.event {
            ended.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            cancel.cancel();
        }
    };
    let control = Control::new()
        .threads(1)
        .progress(&progress)
        .cancel(&cancel);
    params.holes = None;
    let stopped = found.fill(&params, &control);
    assert!(matches!(stopped, Err(FillError::Cancelled)));
    assert!(ended.into_inner() >= 1);
}

#[test]
fn tasks_of_a_large_mesh_give_the_same_bytes_as_a_fill() {
    let sphere = shapes::sphere(160);
    let mesh = shapes::cut(&sphere, |p| {
        p.distance(DVec3::X) < 0.02 || p.distance(DVec3::Z) < 0.015
    });
    assert!(mesh.faces.len() > 500_000);
    let found = inspect(&mesh).unwrap();
    let params = FillParams::default();
    let regions = found.regions(&params).unwrap();
    let solved = |task: RegionTask| task.solve(&Control::new()).unwrap();
    let in_parts = regions.assemble(regions.tasks().map(solved).collect());
    let (in_parts, at_once) = (
        in_parts.unwrap(),
        found.fill(&params, &Control::new()).unwrap(),
    );
    assert_eq!(at_once.report.regions.len(), 2);
    assert!(!at_once.report.incomplete());
    assert_eq!(bits(&in_parts.mesh), bits(&at_once.mesh));
    for p in &at_once.mesh.positions[mesh.positions.len()..] {
        assert!((p.length() - 1.0).abs() < 1e-5);
    }
}

#[test]
fn threads_steps_and_diameters_out_of_bounds_are_refused() {
    let many = Control::new().threads(Control::MOST_THREADS + 1);
    let mesh = ball();
    let found = inspect(&mesh).unwrap();
    let stopped = found.fill(&FillParams::default(), &many);
    assert!(matches!(stopped, Err(FillError::Threads { .. })));
    let mut params = FillParams::default();
    params.max_diameter = Some(0.0);
    assert!(matches!(params.check(), Err(FillError::Bounds(_))));
}

/// Upper bound of the CPU time that a run takes after it is cancelled, in seconds.
#[cfg(target_os = "linux")]
const MOST_AFTER: f64 = 0.05;
/// Cancellations of each run. The parts of a run that they divide are 30 to 60 ms long, so that one of them falls into a stretch of
/// twice the bound.
#[cfg(target_os = "linux")]
const MOMENTS: usize = 16;

/// Runs `work` on one thread to its end, then cancels further runs, each at a pseudo-random moment of another of `moments` equal
/// parts of that time; returns the longest CPU time from a cancellation to the end. A time above the bound is measured again, at
/// most seven times, because a busy machine slows single runs.
#[cfg(target_os = "linux")]
fn longest_after_cancel(moments: usize, work: &(dyn Fn(&Control) -> bool + Sync)) -> f64 {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let pool = pool.unwrap();
    let own = pool.install(this_thread);
    let begun = cpu(&own);
    assert!(pool.install(|| work(&Control::new())), "the whole run");
    let all = cpu(&own) - begun;
    let at = |i: usize| {
        let chance = (12.9898 * (i + 1) as f64).sin() * 43_758.545_3;
        let moment = all * (i as f64 + chance - chance.floor()) / moments as f64;
        let mut shortest = f64::INFINITY;
        for _ in 0..8 {
            shortest = shortest.min(after_cancel(&pool, &own, moment, work));
            if shortest < MOST_AFTER {
                break;
            }
        }
        shortest
    };
    (0..moments).map(at).fold(0.0, f64::max)
}

/// CPU time from the cancellation, `moment` CPU seconds after the start, to the end of the run; 0 if the run ended earlier.
#[cfg(target_os = "linux")]
fn after_cancel(
    pool: &rayon::ThreadPool,
    own: &std::path::Path,
    moment: f64,
    work: &(dyn Fn(&Control) -> bool + Sync),
) -> f64 {
    use std::sync::Mutex;
    use std::sync::atomic::{AtomicBool, Ordering};
    let until = cpu(own) + moment;
    let (cancel, at, has_ended) = (Cancel::new(), Mutex::new(None), AtomicBool::new(false));
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while cpu(own) < until && !has_ended.load(Ordering::Relaxed) {
                std::thread::sleep(std::time::Duration::from_micros(500));
            }
            *at.lock().unwrap() = Some(cpu(own));
            cancel.cancel();
        });
        let control = Control::new().cancel(&cancel);
        let (done, end) = pool.install(|| (work(&control), cpu(own)));
        has_ended.store(true, Ordering::Relaxed);
        let at = *at.lock().unwrap();
        // A run that was faster this time may have ended before its cancellation.
        at.filter(|_| !done).map_or(0.0, |at| end - at)
    })
}

#[test]
#[cfg(target_os = "linux")]
fn fills_and_fairings_end_soon_after_they_are_cancelled() {
    let sphere = shapes::sphere(24);
    let holed = shapes::cut(&shapes::sphere(28), |p| p.distance(DVec3::Z) < 0.7);
    let mut finer = isomend::FairParams::default();
    finer.voxel = isomend::VoxelSize::Length(0.14);
    let mut fills = FillParams::default();
    fills.voxel = isomend::VoxelSize::Length(0.13);
    let (whole, open) = (inspect(&sphere).unwrap(), inspect(&holed).unwrap());
    let fair = |control: &Control| whole.fair(None, &finer, control).is_ok();
    let fill = |control: &Control| open.fill(&fills, control).is_ok();
    let after = longest_after_cancel(MOMENTS, &fair);
    assert!(after < MOST_AFTER, "fair: {after} s");
    let after = longest_after_cancel(MOMENTS, &fill);
    assert!(after < MOST_AFTER, "fill: {after} s");
}
