//! Jobs of the library (`isomend::job`), from file to file or in memory: the same results as the command line.

use std::sync::Arc;

use isomend::glam::DVec3;
use isomend::io::{Format, Loaded, WriteOptions, read_path, to_bytes};
use isomend::job::{
    Batch, BatchObserver, JobError, JobResult, JobSpec, MaskSpec, OperationReport, Output, Place,
    Source, Work, WorkPlan, run,
};
use isomend::{Control, FairParams, FillParams, RestoreParams, VoxelSize};
use serde_json::Value;

use crate::desk::Desk;
use crate::shapes;

fn ball() -> isomend::Mesh {
    shapes::cut(&shapes::sphere(8), |p| p.z > 0.8)
}

fn params() -> FillParams {
    let mut params = FillParams::default();
    params.voxel = VoxelSize::Length(0.1);
    params
}

/// A document without the run times.
fn timeless(mut document: Value) -> Value {
    document["seconds"] = Value::Null;
    for region in document["regions"].as_array_mut().into_iter().flatten() {
        region["seconds"] = Value::Null;
        for level in region["levels"].as_array_mut().into_iter().flatten() {
            level["seconds"] = Value::Null;
        }
    }
    document
}

#[test]
fn a_job_writes_the_mesh_and_document_of_the_command_line() {
    let desk = Desk::new();
    desk.save("ball.ply", &ball(), Format::Ply);
    let voxel = ["--voxel", "0.1", "-q", "--json", "cli.json"];
    let args = [&["fill", "ball.ply", "-o", "cli.ply"][..], &voxel].concat();
    assert!(desk.run(&args).status.success());
    let spec = JobSpec::new(
        desk.path("ball.ply"),
        desk.path("job.ply"),
        Work::Fill(params()),
    );
    let spec = spec.unwrap();
    // Round trip through JSON, as if sent to another machine.
    let spec: JobSpec = serde_json::from_str(&serde_json::to_string(&spec).unwrap()).unwrap();
    let result = run(&spec, &Control::new()).unwrap();
    let bytes = |name| std::fs::read(desk.path(name)).unwrap();
    assert_eq!(bytes("job.ply"), bytes("cli.ply"));
    let mut wanted = timeless(desk.json("cli.json"));
    let mut own = timeless(serde_json::to_value(result.document()).unwrap());
    for document in [&mut wanted, &mut own] {
        document["input"]["path"] = Value::Null;
        document["output"]["path"] = Value::Null;
    }
    assert_eq!(own, wanted);
    assert!(result.complete() && result.report.flawless());
}

#[test]
fn jobs_read_and_write_bytes_in_memory() {
    let mesh = ball();
    let written = to_bytes(&mesh, Format::Ply, &WriteOptions::default()).unwrap();
    let mut spec = JobSpec::plan(Source::bytes("upload", written.bytes), Work::Fill(params()));
    let plan = spec.preview().unwrap();
    assert!(matches!(
        run(&spec, &Control::new()),
        Err(JobError::Places { .. })
    ));
    let document = serde_json::to_value(plan.document()).unwrap();
    assert_eq!(document["dry_run"], true);
    assert_eq!(document["holes"][0]["outcome"], "would_be_closed");
    let place = Place::memory("download");
    spec.output = Some(Output::new(place, Some(Format::Obj)).unwrap());
    let filled = run(&spec, &Control::new()).unwrap();
    assert!(filled.bytes.starts_with(b"#") || filled.bytes.starts_with(b"v"));
    let faces = filled
        .bytes
        .split(|b| *b == b'\n')
        .filter(|l| l.starts_with(b"f "))
        .count();
    assert_eq!(faces, filled.mesh.faces.len());
    spec.source = Source::bytes("upload", b"solid nothing".to_vec());
    let error = run(&spec, &Control::new()).unwrap_err();
    assert!(error.to_string().contains("upload"), "{error}");
}

#[test]
fn a_mask_specification_marks_a_region() {
    let desk = Desk::new();
    desk.save("ball.ply", &shapes::sphere(8), Format::Ply);
    let mut mask = MaskSpec {
        balls: vec![(DVec3::Z, 0.5)],
        ..MaskSpec::default()
    };
    let mut restore = RestoreParams::default();
    restore.fill = params();
    let work = Work::Restore(mask.clone(), restore.clone());
    let spec = JobSpec::new(desk.path("ball.ply"), desk.path("out.ply"), work).unwrap();
    let result = run(&spec, &Control::new()).unwrap();
    let OperationReport::Region(cut) = &result.extent else {
        panic!("{:?}", result.extent);
    };
    assert!(cut.removed_faces >= cut.marked_faces && cut.marked_faces > 0);
    let written = read_path(&desk.path("out.ply"), None);
    assert_eq!(result.mesh.faces, written.unwrap().mesh.faces);
    mask.balls = vec![(9.0 * DVec3::Z, 0.5)];
    let spec = JobSpec::plan(desk.path("ball.ply"), Work::Restore(mask, restore));
    let missed = spec.preview().unwrap_err();
    assert!(matches!(missed, JobError::NothingMarked { .. }), "{missed}");
    let nothing = Work::Restore(MaskSpec::default(), RestoreParams::default());
    let spec = JobSpec::plan(desk.path("ball.ply"), nothing);
    assert!(matches!(run(&spec, &Control::new()), Err(JobError::NoMask)));
    let spec = JobSpec::plan(
        desk.path("ball.ply"),
        Work::Fair(None, FairParams::default()),
    );
    let plan = spec.preview().unwrap();
    assert!(matches!(&plan.plan, WorkPlan::Fair(plan) if plan.whole));
}

#[test]
fn invalid_output_paths_are_refused_before_the_fill() {
    let desk = Desk::new();
    desk.save("ball.ply", &ball(), Format::Ply);
    let work = Work::Fill(params());
    let mut spec = JobSpec::new(desk.path("ball.ply"), desk.path("out.ply"), work.clone()).unwrap();
    spec.drawings.page = Some(desk.path("out.ply"));
    assert!(matches!(
        run(&spec, &Control::new()),
        Err(JobError::Drawing { .. })
    ));
    spec.drawings.page = None;
    spec.drawings.picture = Some(desk.path("no/folder.png"));
    assert!(matches!(
        run(&spec, &Control::new()),
        Err(JobError::Unwritable { .. })
    ));
    let nameless = JobSpec::new(desk.path("ball.ply"), desk.path("out.xyz"), work);
    assert!(matches!(nameless, Err(JobError::NoFormat { .. })));
    assert!(!desk.path("out.ply").exists());
}

#[test]
fn a_result_can_be_written_several_times() {
    let desk = Desk::new();
    desk.save("ball.ply", &ball(), Format::Ply);
    let written = |name: &str| {
        let spec = JobSpec::new(desk.path("ball.ply"), desk.path(name), Work::Fill(params()));
        run(&spec.unwrap(), &Control::new()).unwrap();
        std::fs::read(desk.path(name)).unwrap()
    };
    let nowhere = JobSpec::plan(desk.path("ball.ply"), Work::Fill(params()));
    let loaded = read_path(&desk.path("ball.ply"), None).unwrap();
    let found = isomend::Inspection::new(&loaded.mesh).unwrap();
    // The mesh is already read and inspected.
    let read = nowhere.with(loaded.clone());
    let mended = read.mend_found(&found, &Control::new()).unwrap();
    let mended = mended.into_owned();
    for format in [Format::Ply, Format::Obj, Format::Glb] {
        let place = Place::memory("bytes");
        let output = Output::new(place, Some(format)).unwrap();
        let result = mended.clone().to(output).write().unwrap();
        let name = format!("file.{}", format.extension());
        assert!(result.bytes == written(&name), "{format}");
    }
    // The document of a result that was not written has the path "-" and the sizes of the mesh.
    let document = serde_json::to_value(mended.document()).unwrap();
    assert_eq!(document["output"]["path"], "-");
    assert_eq!(
        document["output"]["vertices"],
        mended.model().mesh.positions.len()
    );
    assert_eq!(document["outcomes"]["closed"], 1);
    assert_eq!(
        mended.kept_size(),
        [loaded.mesh.positions.len(), loaded.mesh.faces.len()]
    );
    assert_eq!(mended.new_vertices(), mended.expected_error().len());
    assert!(mended.kept().is_none());
}

#[test]
fn a_mesh_in_memory_is_shared_and_not_copied() {
    let loaded = Arc::new(Loaded {
        mesh: ball(),
        format: Format::Ply,
        f32_exact: false,
        attributes: isomend::Attributes::default(),
        document: None,
        notes: Vec::new(),
    });
    let source = Source::mesh(Place::memory("a mesh"), loaded.clone());
    for work in [Work::Fill(params()), Work::Copy] {
        let spec = JobSpec::plan(source.clone(), work);
        let mended = spec.read().unwrap().mend(&Control::new()).unwrap();
        assert!(Arc::ptr_eq(mended.first(), &loaded));
    }
}

/// Records the calls of a batch.
#[derive(Default)]
struct Noted(Vec<String>);

impl BatchObserver for Noted {
    fn begins(&mut self, job: &JobSpec) {
        self.0.push(format!("begins {}", job.source.place.name()));
    }

    fn done(&mut self, result: &JobResult) -> std::io::Result<()> {
        self.0.push(format!("{} holes", result.report.holes.len()));
        Ok(())
    }

    fn failed(&mut self, _job: &JobSpec, words: &str) {
        self.0.push(words.to_owned());
    }
}

#[test]
fn a_batch_goes_on_after_a_failure_and_has_one_document() {
    let desk = Desk::new();
    desk.save("a.ply", &ball(), Format::Ply);
    std::fs::write(desk.path("b.ply"), "ply nothing").unwrap();
    let mut batch = Batch::new(
        ["a.ply", "b.ply"].map(|n| desk.path(n)),
        Work::Fill(params()),
    );
    let run = |batch: &Batch, noted: &mut Noted| batch.run(noted, &Control::new());
    let mut noted = Noted::default();
    let error = run(&batch, &mut noted).unwrap_err();
    assert!(error.is_usage(), "without an output: {error}");
    batch.output = Some(desk.path("one.ply").into());
    let error = run(&batch, &mut noted).unwrap_err();
    assert!(error.to_string().contains("need a folder"), "{error}");
    batch.output = Some(desk.path("all/").into());
    batch.document = Some(desk.path("a.ply").into());
    let error = run(&batch, &mut noted).unwrap_err();
    assert!(
        matches!(error, JobError::DocumentOverMesh { .. }),
        "{error}"
    );
    batch.document = Some(Place::memory("the report"));
    assert!(noted.0.is_empty(), "nothing was read before");
    let ended = run(&batch, &mut noted).unwrap();
    assert_eq!([ended.done, ended.in_part, ended.failed], [1, 0, 1]);
    let documents: serde_json::Value = serde_json::from_str(&ended.document.unwrap()).unwrap();
    assert_eq!(documents[0]["complete"], true);
    assert_eq!(documents[1]["error"], noted.0[3].as_str());
    assert_eq!(noted.0[1], "1 holes");
    assert!(desk.path("all/a.ply").exists() && !desk.path("all/b.ply").exists());
    // A plan of the first file: its document has no run times and no output.
    batch.plan = true;
    batch.sources.remove(1);
    let planned = batch.run(&mut (), &Control::new()).unwrap();
    let document: serde_json::Value = serde_json::from_str(&planned.document.unwrap()).unwrap();
    assert_eq!(document["dry_run"], true);
    assert!(document.get("seconds").is_none() && document.get("output").is_none());
}

#[test]
fn the_plan_of_a_repair_has_no_results_and_its_report_no_plans() {
    let desk = Desk::new();
    desk.save("ball.ply", &ball(), Format::Ply);
    let work = Work::Repair(isomend::RepairParams::default());
    let spec = JobSpec::new(desk.path("ball.ply"), desk.path("out.ply"), work).unwrap();
    let plan = serde_json::to_value(spec.preview().unwrap().document()).unwrap();
    for key in ["steps", "after", "complete", "seconds", "lost_faces"] {
        assert!(plan.get(key).is_none(), "{key}");
    }
    assert_eq!(plan["before"]["sound"], false);
    assert_eq!(plan["regions"].as_array().unwrap().len(), 1);
    let report = run(&spec, &Control::new()).unwrap().report;
    assert_eq!(report.regions.len(), 1);
    assert!(report.regions[0].new_faces > 0);
    assert_eq!((report.regions[0].id, report.holes[0].region), (1, 1));
}
