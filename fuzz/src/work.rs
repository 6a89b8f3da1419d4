//! Restoring, fairing, measuring and comparing small meshes, and filling them after a counterpart or with grain.

use std::collections::HashSet;

use arbitrary::{Result, Unstructured};
use isomend::compare::compare;
use isomend::glam::DVec3;
use isomend::volume::{VolumeParams, signed_distance_volume};
use isomend::{
    Control, FairExtent, FairParams, FillParams, Inspection, Like, Mesh, RestoreParams, VoxelSize,
};
use isomend_core::mesh::weld_map;

use crate::shapes;

/// Points compared in each direction.
const SAMPLES: usize = 200;

/// One kind of work on a small mesh.
pub fn work(data: &[u8]) {
    let mut input = Unstructured::new(data);
    let Ok(mesh) = shapes::mesh(&mut input) else {
        return;
    };
    // Bytes that run out leave the rest at its first choice.
    let _ = one(&mesh, &mut input);
}

fn one(mesh: &Mesh, input: &mut Unstructured) -> Result<()> {
    let found = isomend::inspect(mesh).expect("it has faces, and their vertices are finite");
    match input.int_in_range(0..=4u8)? {
        0 => restore(&found, input),
        1 => fair(&found, input),
        2 => measure(mesh, input),
        3 => {
            let other = shapes::mesh(input)?;
            if let Ok(result) = compare(mesh, &other, SAMPLES) {
                let text = format!("{result:?}");
                assert!(!text.contains("NaN"), "{text}");
            }
            Ok(())
        }
        _ => fill(&found, input),
    }
}

/// Marks of some faces: those around a vertex, or any.
fn marks(mesh: &Mesh, input: &mut Unstructured) -> Result<Vec<bool>> {
    let vertex = input.choose_index(mesh.positions.len())? as u32;
    let bits = input.arbitrary::<u64>()?;
    let is_marked = |(i, face): (usize, &[u32; 3])| match bits % 3 {
        0 => bits >> (i % 64) & 1 == 1,
        _ => face.contains(&vertex),
    };
    Ok(mesh.faces.iter().enumerate().map(is_marked).collect())
}

/// The longest side of the bounding box.
fn longest(mesh: &Mesh) -> f64 {
    let low = mesh.positions.iter().copied().reduce(DVec3::min);
    let high = mesh.positions.iter().copied().reduce(DVec3::max);
    let size = high.unwrap_or_default() - low.unwrap_or_default();
    size.max_element()
}

/// A voxel of which few fit along the mesh.
fn voxel(mesh: &Mesh, input: &mut Unstructured) -> Result<VoxelSize> {
    let across = f64::from(input.int_in_range(3..=12u8)?);
    Ok(match longest(mesh) / across {
        length if length > 0.0 && length.is_finite() => VoxelSize::Length(length),
        _ => VoxelSize::Auto,
    })
}

fn restore(found: &Inspection, input: &mut Unstructured) -> Result<()> {
    let marked = marks(&found.input, input)?;
    let mut params = RestoreParams::default();
    params.fill.voxel = voxel(&found.input, input)?;
    params.keep_shape = *input.choose(&[0.0, 0.0, 0.5])?;
    if let Ok(done) = found.restore(&marked, &params, &Control::new()) {
        let is_whole = !done.fill.incomplete();
        assert!(!is_whole || torn(&found.input, &done.mesh) == 0);
        check_numbers(&done.mesh);
    }
    Ok(())
}

fn fair(found: &Inspection, input: &mut Unstructured) -> Result<()> {
    let some = input.arbitrary::<bool>()?;
    let marked = some.then(|| marks(&found.input, input)).transpose()?;
    let mut params = FairParams::default();
    params.voxel = voxel(&found.input, input)?;
    let part = *input.choose(&[0.0, 0.1, 0.5, 2.0])?;
    if part > 0.0 {
        params.extent = FairExtent::Strength(part * longest(&found.input).max(1e-9));
    }
    if let Ok(done) = found.fair(marked.as_deref(), &params, &Control::new()) {
        assert_eq!(torn(&found.input, &done.mesh), 0);
        check_numbers(&done.mesh);
        assert!(done.report.moved_max.is_finite());
    }
    Ok(())
}

fn measure(mesh: &Mesh, input: &mut Unstructured) -> Result<()> {
    let mut params = VolumeParams::default();
    params.voxel = voxel(mesh, input)?;
    if params.voxel == VoxelSize::Auto {
        return Ok(());
    }
    if let Ok(volume) = signed_distance_volume(mesh, &params) {
        assert!(volume.values.iter().all(|v| v.is_finite()));
    }
    Ok(())
}

fn fill(found: &Inspection, input: &mut Unstructured) -> Result<()> {
    let mut params = FillParams::default();
    params.voxel = voxel(&found.input, input)?;
    params.grain = input.arbitrary()?;
    params.like = match input.int_in_range(0..=2u8)? {
        0 => None,
        1 => Some(Like::Mirror(None)),
        _ => Some(Like::template("template", shapes::mesh(input)?)),
    };
    // A template may have no use for the holes, or a voxel may be too coarse: reasons are errors.
    if let Ok(filled) = found.fill(&params, &Control::new()) {
        check_numbers(&filled.mesh);
    }
    Ok(())
}

fn check_numbers(mesh: &Mesh) {
    assert!(mesh.positions.iter().all(|p| p.is_finite()));
    let count = mesh.positions.len();
    let mut corners = mesh.faces.iter().flatten();
    assert!(corners.all(|v| (*v as usize) < count));
}

/// The ends of an edge, by their exact positions, in ascending order.
type Edge = [[u64; 3]; 2];

/// The edges with a single face.
fn open_edges(mesh: &Mesh) -> HashSet<Edge> {
    let weld = weld_map(mesh);
    let bits = |v: u32| {
        let p = mesh.positions[weld[v as usize] as usize] + 0.0;
        p.to_array().map(f64::to_bits)
    };
    let mut count = std::collections::HashMap::new();
    for face in &mesh.faces {
        let corners = face.map(bits);
        if corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0] {
            continue;
        }
        for k in 0..3 {
            let mut edge = [corners[k], corners[(k + 1) % 3]];
            edge.sort_unstable();
            *count.entry(edge).or_insert(0) += 1;
        }
    }
    let open = count.into_iter().filter(|(_, faces)| *faces == 1);
    open.map(|(edge, _)| edge).collect()
}

/// The number of open edges that the mesh did not have before.
fn torn(before: &Mesh, after: &Mesh) -> usize {
    open_edges(after).difference(&open_edges(before)).count()
}
