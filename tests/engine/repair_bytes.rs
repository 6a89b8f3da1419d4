//! The verdict of a repair is the verdict on the written bytes in every format, and the mesh is sound after rounding too.

use std::sync::Arc;

use crate::repair_union::verdict;
use crate::shapes::{cut, joined, moved, polar, sheet, sphere, turned};
use glam::DVec3;
use isomend::io::{Format, no_side_files, read_bytes, to_bytes};
use isomend::job::{JobSpec, OperationReport, Output, Place, Source, Work, run};
use isomend::{Control, Mesh, RepairParams};

/// A format, and whether it is written as text.
type Form = (Format, bool);

/// Formats that hold 32-bit floats.
const SINGLE: [Form; 3] = [
    (Format::Stl, false),
    (Format::Glb, false),
    (Format::Gltf, false),
];
/// Formats that hold 64-bit floats if the mesh needs them.
const DOUBLE: [Form; 7] = [
    (Format::Obj, false),
    (Format::Stl, true),
    (Format::Ply, false),
    (Format::Ply, true),
    (Format::Vtk, false),
    (Format::Vtk, true),
    (Format::Vtp, false),
];

/// A mesh as bytes of PLY in the smallest precision that holds it.
fn source(mesh: &Mesh) -> Source {
    let options = isomend::io::WriteOptions {
        precision: isomend::io::Precision::of(mesh),
        ascii: false,
    };
    let written = to_bytes(mesh, Format::Ply, &options).unwrap();
    Source::bytes("in memory", written.bytes)
}

fn output((format, ascii): Form) -> Output {
    let mut output = Output::new(Place::memory("out"), Some(format)).unwrap();
    output.ascii = ascii;
    output
}

/// Repairs a mesh for the first of some formats and writes it in all of them: the reported verdict must be the verdict on the
/// written bytes, and the mesh must be sound.
#[track_caller]
fn assert_sound_in(name: &str, source: &Source, formats: &[Form]) {
    let mut params = RepairParams::default();
    params.borders = true;
    let mut spec = JobSpec::plan(source.clone(), Work::Repair(params));
    spec.output = Some(output(formats[0]));
    let mended = spec.read().unwrap().mend(&Control::new()).unwrap();
    for form in formats {
        let done = mended.clone().to(output(*form)).write().unwrap();
        let OperationReport::Repaired(report) = &done.extent else {
            panic!("{:?}", done.extent)
        };
        let after = report.after.as_ref().unwrap();
        assert_eq!(done.complete(), after.is_sound());
        let loaded = read_bytes(&done.bytes, form.0, &no_side_files).unwrap();
        let own = verdict(&loaded.mesh);
        assert_eq!(after.line(), own.line(), "{name}, {form:?}");
        assert!(own.is_sound(), "{name}, {form:?}: {}", own.line());
    }
}

fn ball(n: u32) -> Mesh {
    turned(sphere(n))
}

/// Meshes with one kind of defect each.
fn breakages() -> Vec<(&'static str, Mesh)> {
    let good = ball(4);
    let flips = {
        let mut mesh = good.clone();
        mesh.faces.iter_mut().step_by(7).for_each(|f| f.swap(0, 1));
        mesh.faces.extend_from_within(..9);
        mesh
    };
    let bowl = cut(&ball(6), |p| polar(p) < 70.0);
    let needle = {
        let mut mesh = ball(3);
        for p in &mut mesh.positions {
            *p = DVec3::new(0.05 * p.x, 0.05 * p.y, 0.4 + 1.2 * p.z);
        }
        mesh
    };
    // Closed bodies at a distance below the spacing of 32-bit floats far from the origin.
    let touching = {
        let top = good.positions.iter().map(|p| p.x).fold(0.0, f64::max);
        joined(&good, &moved(&good, 1.0, DVec3::X * (2.0 * top + 1e-7)))
    };
    let tiny = joined(&good, &moved(&good, 1e-5, DVec3::splat(2.0)));
    let twice = joined(&good, &moved(&good, 1.0, DVec3::splat(1e-7)));
    vec![
        ("a hole", cut(&ball(6), |p| polar(p) < 25.0)),
        ("flipped and double faces", flips),
        ("pierced", joined(&good, &moved(&good, 0.4, DVec3::X))),
        ("a needle in a bowl", joined(&bowl, &needle)),
        ("an open sheet", turned(sheet(4))),
        ("balls that touch but for rounding", touching),
        ("a component of the size of a rounding", tiny),
        ("a ball twice but for rounding", twice),
    ]
}

#[test]
fn a_repaired_mesh_is_sound_in_the_bytes_of_every_format() {
    let far = DVec3::new(1000.1, 2000.2, -500.3);
    for (name, mesh) in breakages() {
        for by in [DVec3::ZERO, far] {
            let source = source(&moved(&mesh, 1.0, by));
            assert_sound_in(name, &source, &SINGLE);
            assert_sound_in(name, &source, &DOUBLE);
        }
    }
}

#[test]
fn the_verdict_on_32_bit_meshes_is_on_the_written_positions() {
    for (name, mesh) in breakages() {
        let mut mesh = moved(&mesh, 1.0, DVec3::new(1000.1, 2000.2, -500.3));
        for p in &mut mesh.positions {
            *p = p.as_vec3().as_dvec3();
        }
        assert_sound_in(name, &source(&mesh), &[SINGLE[0], DOUBLE[2]]);
    }
}

#[test]
fn vertices_that_differ_by_one_decimal_are_welded_for_every_format() {
    let round = |x: f64| (x * 1e6).round() / 1e6;
    let good = moved(&ball(4), 2.5, DVec3::ZERO);
    let mut soup = Mesh::default();
    for (f, face) in good.faces.iter().enumerate() {
        let first = soup.positions.len() as u32;
        // Copies of a vertex differ by one unit of the last decimal, in another direction for each face.
        let last = [1, 2, 4].map(|bit| if f & bit == 0 { 0.0 } else { 1e-6 });
        for v in face {
            let p = good.positions[*v as usize].to_array().map(round);
            soup.positions
                .push(DVec3::from_array(p) + DVec3::from_array(last));
        }
        soup.faces.push([first, first + 1, first + 2]);
    }
    for p in &mut soup.positions {
        *p = DVec3::from_array(p.to_array().map(round));
    }
    assert_sound_in("digits", &source(&soup), &SINGLE);
    assert_sound_in("digits", &source(&soup), &DOUBLE);
}

#[test]
fn input_positions_exact_in_32_bit_floats_stay_and_rounding_is_noted() {
    let good = ball(4);
    let spec = |mesh: &Mesh| {
        let mut spec = JobSpec::plan(source(mesh), Work::Repair(RepairParams::default()));
        spec.output = Some(Output::new(Place::memory("out"), Some(Format::Stl)).unwrap());
        let done = run(&spec, &Control::new()).unwrap();
        (Arc::new(done.mesh.clone()), done.notes.clone())
    };
    let (_, notes) = spec(&good);
    let is_rounding = |n: &&String| n.contains("rounded to 32-bit floats");
    assert_eq!(notes.iter().filter(is_rounding).count(), 1, "{notes:?}");
    let mut single = good.clone();
    for p in &mut single.positions {
        *p = p.as_vec3().as_dvec3();
    }
    let (mesh, notes) = spec(&single);
    assert_eq!(*mesh, single);
    assert!(!notes.iter().any(|n| n.contains("rounded")), "{notes:?}");
}
