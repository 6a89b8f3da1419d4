//! Filling the holes of small meshes.

use std::collections::{HashMap, HashSet};

use arbitrary::{Result, Unstructured};
use isomend::Energy;
use isomend::glam::DVec3;
use isomend::io::{Format, WriteOptions, to_bytes};
use isomend::{
    Control, FillError, FillParams, FillReport, Finish, HoleId, HoleOutcome, Inspection, Mesh,
    OpenReason, VoxelSize,
};
use isomend_core::mesh::weld_map;

use crate::shapes;

/// Inspects a small mesh, plans how to fill it, and fills it.
pub fn fill(data: &[u8]) {
    let mut input = Unstructured::new(data);
    // Bytes that run out leave the rest at its first choice, so that this does not fail.
    let Ok(mesh) = shapes::mesh(&mut input) else {
        return;
    };
    let found = isomend::inspect(&mesh).expect("it has faces, and their vertices are finite");
    let Ok(params) = params(&found, &mut input) else {
        return;
    };
    let plan = match found.plan(&params) {
        // The widest hole of all may be kept open, or closed without a grid.
        Err(FillError::TooCoarse { .. }) => return,
        plan => plan.expect("what can be inspected can be planned"),
    };
    assert_eq!(plan.holes.len(), found.holes.len());
    let filled = found.fill(&params, &Control::new());
    let filled = filled.expect("what can be inspected can be filled");
    assert_eq!(filled.report.holes.len(), found.holes.len());
    check_report(&filled.report);
    assert!(
        filled.mesh.positions.iter().all(|p| p.is_finite()),
        "a position of the result is not finite"
    );
    let count = filled.mesh.positions.len();
    assert!(
        filled
            .mesh
            .faces
            .iter()
            .flatten()
            .all(|v| (*v as usize) < count)
    );
    if input.ratio(1, 4).unwrap_or_default() {
        check_threads(&mesh, &params, &filled.mesh);
    }
    check_kept(&mesh, &filled.mesh);
    check_patches(&mesh, &filled.mesh, &filled.report);
}

/// The mesh that the bytes stand for as OBJ, and in a remark what is asked for.
pub fn as_obj(data: &[u8]) -> Vec<u8> {
    let mut input = Unstructured::new(data);
    let Ok(mesh) = shapes::mesh(&mut input) else {
        return Vec::new();
    };
    let written = to_bytes(&mesh, Format::Obj, &WriteOptions::default());
    let mut bytes = written.expect("the mesh is finite").bytes;
    let asked = isomend::inspect(&mesh).map(|found| params(&found, &mut input));
    bytes.extend(format!("# {asked:?}\n").bytes());
    bytes
}

/// Parameters of small cost: few voxels across the widest hole.
fn params(found: &Inspection, input: &mut Unstructured) -> Result<FillParams> {
    let widest = found.holes.iter().map(|h| h.diameter).fold(0.0, f64::max);
    let across = f64::from(input.int_in_range(3..=12u8)?);
    let voxel = match widest / across {
        length if length > 0.0 && length.is_finite() => VoxelSize::Length(length),
        _ => VoxelSize::Auto,
    };
    let ids: Vec<HoleId> = found.holes.iter().map(|h| h.id).collect();
    let mut params = FillParams::default();
    params.voxel = voxel;
    let bits = input.arbitrary::<u8>()?;
    if bits & 1 == 1 {
        params.holes = Some(ids.clone());
    }
    if bits & 6 == 6 {
        params.energy = Energy::CurvatureVariation;
    }
    if bits & 24 == 24 {
        params.finish = Finish::None;
    }
    if bits & 32 == 32 && ids.len() > 1 {
        params.bridge = vec![ids[..2].to_vec()];
    }
    if bits & 64 == 64 && !ids.is_empty() {
        params.keep_open = vec![*input.choose(&ids)?];
    }
    // What is kept open is neither named nor bridged.
    let kept = params.keep_open.clone();
    params
        .bridge
        .retain(|ids| !ids.iter().any(|id| kept.contains(id)));
    if let Some(named) = &mut params.holes {
        named.retain(|id| !kept.contains(id));
    }
    params.edge_ratio = *input.choose(&[None, None, Some(0.5), Some(2.0), Some(10.0)])?;
    Ok(params)
}

/// Every number of a report must be one, and every hole must have its end.
fn check_report(report: &FillReport) {
    for hole in &report.holes {
        let what = format!("hole {}: {:?}", hole.hole.id, hole.outcome);
        let h = &hole.hole;
        for value in [h.length, h.diameter, h.width, h.planarity] {
            assert!(value.is_finite(), "{what}: {value}");
        }
        let reached = hole.outcome != HoleOutcome::Open(OpenReason::NotReached);
        assert!(reached, "{what}");
        assert!(
            hole.outcome.closure().is_none() || hole.region > 0,
            "{what}"
        );
        if hole.region > 0 {
            let region = &report.regions[hole.region - 1];
            assert!(region.holes.contains(&h.id), "{what}");
        }
    }
    for region in &report.regions {
        let values = [
            region.diameter,
            region.voxel.unwrap_or(0.0),
            region.seam_angle_mean.unwrap_or(0.0),
            region.seam_angle_max.unwrap_or(0.0),
            region.quality_mean,
        ];
        for value in values {
            assert!(value.is_finite(), "region {}: {values:?}", region.id);
        }
    }
}

fn bits(positions: &[DVec3]) -> Vec<[u64; 3]> {
    let arrays = positions.iter().map(|p| p.to_array());
    arrays.map(|p| p.map(f64::to_bits)).collect()
}

/// Another number of threads gives the same, to the bit.
fn check_threads(mesh: &Mesh, params: &FillParams, filled: &Mesh) {
    let threads = if rayon::current_num_threads() == 3 {
        2
    } else {
        3
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let again = pool
        .expect("a few threads")
        .install(|| isomend::fill(mesh, params));
    let again = again.expect("it was filled before").mesh;
    let (old, new) = (bits(&filled.positions), bits(&again.positions));
    assert_eq!(new, old, "with {threads} threads");
    assert_eq!(again.faces, filled.faces, "with {threads} threads");
}

/// Vertices and faces of the input are kept bit for bit and in order.
fn check_kept(mesh: &Mesh, filled: &Mesh) {
    let kept = &filled.positions[..mesh.positions.len()];
    assert_eq!(bits(kept), bits(&mesh.positions), "vertices are not kept");
    assert_eq!(filled.faces[..mesh.faces.len()], mesh.faces);
}

/// Together the patches close the rims of the holes that are said to be closed, each edge once, and have no other border.
fn check_patches(mesh: &Mesh, filled: &Mesh, report: &FillReport) {
    let new = &filled.faces[mesh.faces.len()..];
    let made: usize = report.regions.iter().map(|r| r.new_faces).sum();
    assert_eq!(new.len(), made, "the report counts other faces");
    let weld = weld_map(mesh);
    let welded = |v: u32| weld.get(v as usize).copied().unwrap_or(v);
    let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
    for face in new {
        let [a, b, c] = face.map(welded);
        assert!(a != b && b != c && c != a, "a new face repeats a vertex");
        for edge in [(a, b), (b, c), (c, a)] {
            *edges.entry(edge).or_default() += 1;
        }
    }
    let mut rims: HashSet<(u32, u32)> = HashSet::new();
    for hole in &report.holes {
        if hole.outcome.closure().is_none() {
            continue;
        }
        let rim = &hole.hole.rim;
        for (i, &a) in rim.iter().enumerate() {
            let edge = (welded(a), welded(rim[(i + 1) % rim.len()]));
            let id = hole.hole.id;
            assert_eq!(edges.get(&edge), Some(&1), "hole {id} at edge {edge:?}");
            rims.insert(edge);
        }
    }
    for (&(a, b), &count) in &edges {
        assert_eq!(count, 1, "the edge {a}–{b} of the patches is not simple");
        if !rims.contains(&(a, b)) {
            let inner = edges.contains_key(&(b, a)) && !rims.contains(&(b, a));
            assert!(inner, "the patches end at {a}–{b}");
        }
    }
}
