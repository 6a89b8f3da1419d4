//! Cleaning: merges coinciding vertices and removes degenerate and duplicate faces.

use std::collections::{HashMap, HashSet};

use glam::DVec3;

use super::draft::{CLEAN_ROUNDS, Draft};
use super::{RepairParams, RepairReport, RepairStep, cracks, union};
use crate::check::{CRACK, duplicates, is_flat};
use crate::mend::FillError;
use crate::mesh::topology::{NONE, apex, end, start};
use crate::mesh::{FaceOrigin, MeshError, VertexFaces, weld_map};
use crate::tuning::{Tunable, tunable};

/// Units in the last place of 32-bit floats. Components no larger than this are points in an output of 32-bit floats: a
/// body needs several units along each axis.
const POINT: Tunable<f64> = tunable("repair.point", 4.0);

/// Returns whether two input vertices have equal attributes.
pub(super) type Alike<'a> = dyn Fn(u32, u32) -> bool + Sync + 'a;

/// Merges and welds vertices, removes degenerate and duplicate faces, and splits edges at T-junctions.
pub(super) fn clean(
    draft: &mut Draft,
    params: &RepairParams,
    alike: &Alike,
    report: &mut RepairReport,
) -> Result<(), FillError> {
    if params.does(RepairStep::Duplicates) {
        report.steps.merged_vertices += merge_coinciding(draft, alike);
        report.steps.degenerate_faces += drop_points(draft)?;
    }
    report.steps.welded_vertices += match params.weld {
        Some(length) if length > 0.0 => weld_border(draft, length)?,
        None if params.does(RepairStep::Duplicates) => cracks::weld(draft)?,
        _ => 0,
    };
    if !params.does(RepairStep::Duplicates) {
        return Ok(());
    }
    let (removed, doubled) = {
        let found = draft.inspect()?;
        let mut removed: Vec<bool> = found
            .topology
            .component
            .iter()
            .map(|p| *p == NONE)
            .collect();
        let mut twice = duplicates(&found.mesh, &found.topology);
        if params.does(RepairStep::Intersections) {
            // Keep duplicates that are walls between touching bodies; the bodies are united later.
            let walls = union::walls(&found, &twice);
            twice.retain(|f| walls.binary_search(f).is_err());
        }
        for f in &twice {
            removed[*f as usize] = true;
        }
        report.steps.duplicate_faces += twice.len();
        (removed, twice.len())
    };
    if removed.iter().all(|r| *r) {
        return Err(MeshError::Empty.into());
    }
    report.steps.degenerate_faces += draft.remove(&removed) - doubled;
    for _ in 0..CLEAN_ROUNDS.get() {
        match flip_flat(draft, false)? {
            0 => break,
            flipped => report.steps.flipped_edges += flipped,
        }
    }
    let most = match params.weld {
        Some(length) => length.max(draft.unit),
        None => CRACK.get() * diagonal(draft),
    };
    cracks::close(draft, most, report)
}

/// The diagonal of the bounding box of the used vertices, in mesh units.
fn diagonal(draft: &Draft) -> f64 {
    let mesh = &draft.mesh;
    let corners = mesh.faces.iter().flatten();
    let (low, high) = crate::mesh::bounds(corners.map(|v| mesh.positions[*v as usize]));
    low.distance(high)
}

/// Removes the duplicate faces between touching bodies that were not united.
pub(super) fn drop_duplicates(
    draft: &mut Draft,
    report: &mut RepairReport,
) -> Result<(), FillError> {
    let mut removed = vec![false; draft.mesh.faces.len()];
    {
        let found = draft.inspect()?;
        for f in duplicates(&found.mesh, &found.topology) {
            removed[f as usize] = true;
        }
    }
    report.steps.duplicate_faces += draft.remove(&removed);
    Ok(())
}

/// Flips edges of new faces without area, if the neighbour is new as well.
pub(super) fn flip_new(draft: &mut Draft) -> Result<(), FillError> {
    for _ in 0..CLEAN_ROUNDS.get() {
        if flip_flat(draft, true)? == 0 {
            break;
        }
    }
    Ok(())
}

/// Merges vertices at bitwise equal positions with equal attributes into the first of them; returns how many.
fn merge_coinciding(draft: &mut Draft, alike: &Alike) -> usize {
    let positions = &draft.mesh.positions;
    let bits = |v: u32| positions[v as usize].to_array().map(f64::to_bits);
    let weld = weld_map(&draft.mesh);
    let mut different: HashMap<u32, Vec<u32>> = HashMap::new();
    let mut to: Vec<u32> = (0..positions.len() as u32).collect();
    let mut merged = 0;
    let mut used = vec![false; positions.len()];
    let corners = draft.mesh.faces.iter().flatten();
    corners.for_each(|&v| used[v as usize] = true);
    for v in (0..positions.len() as u32).filter(|v| used[*v as usize]) {
        let known = different.entry(weld[v as usize]).or_default();
        match known.iter().find(|w| bits(**w) == bits(v) && alike(**w, v)) {
            Some(first) => {
                to[v as usize] = *first;
                merged += 1;
            }
            None => known.push(v),
        }
    }
    for corner in draft.mesh.faces.iter_mut().flatten() {
        *corner = to[*corner as usize];
    }
    merged
}

/// Removes components that shrink to a point in the precision of the output, unless nothing would be left; they cannot be
/// represented as bodies. Returns the number of faces removed.
fn drop_points(draft: &mut Draft) -> Result<usize, FillError> {
    if !draft.rounding.is_single() {
        return Ok(0);
    }
    let removed: Vec<bool> = {
        let found = draft.inspect()?;
        let (mesh, topology) = (&found.mesh, &found.topology);
        let is_point = |(low, high): &(DVec3, DVec3)| {
            let unit = f64::from(f32::EPSILON) * low.abs().max(high.abs()).max_element();
            (*high - *low).max_element() <= POINT.get() * unit
        };
        let boxes = topology.component_bounds(mesh);
        let point: Vec<bool> = boxes.iter().map(is_point).collect();
        let components = topology.component.iter();
        components
            .map(|p| *p != NONE && point[*p as usize])
            .collect()
    };
    if removed.iter().all(|r| *r) || !removed.contains(&true) {
        return Ok(0);
    }
    Ok(draft.remove(&removed))
}

/// Merges each boundary vertex into the nearest kept one within `length`, unless they share a face.
fn weld_border(draft: &mut Draft, length: f64) -> Result<usize, FillError> {
    let (to, merged) = {
        let found = draft.inspect()?;
        let (mesh, topology) = (&found.mesh, &found.topology);
        let mut border: Vec<u32> = (0..topology.boundary.len() as u32)
            .filter(|&h| topology.boundary[h as usize])
            .flat_map(|h| [start(mesh, h), end(mesh, h)])
            .collect();
        border.sort_unstable();
        border.dedup();
        let around = VertexFaces::new(mesh);
        let neighbours = |v: u32, w: u32| {
            let mut faces = around.of(v).iter();
            faces.any(|f| mesh.faces[*f as usize].contains(&w))
        };
        // Search kept vertices in a grid of cells of the welding distance.
        let cell = |p: DVec3| (p / length).floor().to_array().map(|x| x as i64);
        let mut kept: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
        let mut to: HashMap<u32, u32> = HashMap::new();
        for &v in &border {
            let p = mesh.positions[v as usize];
            let [x, y, z] = cell(p);
            let mut best: Option<(f64, u32)> = None;
            for i in 0..27i64 {
                let near = [x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1];
                for &w in kept.get(&near).into_iter().flatten() {
                    let d = p.distance(mesh.positions[w as usize]);
                    if d <= length && !neighbours(v, w) && best.is_none_or(|b| (d, w) < b) {
                        best = Some((d, w));
                    }
                }
            }
            match best {
                Some((_, w)) => _ = to.insert(v, w),
                None => kept.entry([x, y, z]).or_default().push(v),
            }
        }
        // Apply the merge of welded vertices to the vertices of the draft.
        let of = |v: usize| to.get(&found.weld[v]).copied();
        let all: Vec<Option<u32>> = (0..found.weld.len()).map(of).collect();
        (all, to.len())
    };
    for corner in draft.mesh.faces.iter_mut().flatten() {
        *corner = to[*corner as usize].unwrap_or(*corner);
    }
    Ok(merged)
}

/// Flips the longest edge of faces with collinear corners, which splits the neighbour there in two. A neighbour with collinear corners
/// is split too, if the new edge is shorter. Returns the number of flips.
/// With `only_new` faces from the input are kept.
fn flip_flat(draft: &mut Draft, only_new: bool) -> Result<usize, FillError> {
    let flips = {
        let found = draft.inspect()?;
        let (mesh, topology) = (&found.mesh, &found.topology);
        let flat: Vec<u32> = topology
            .faces()
            .filter(|&f| is_flat(mesh.corners(f)))
            .filter(|&f| !only_new || draft.region[f as usize] != NONE)
            .collect();
        if flat.is_empty() {
            return Ok(0);
        }
        let around = VertexFaces::new(mesh);
        let mut touched: HashSet<u32> = HashSet::new();
        let mut flips = Vec::new();
        for f in flat {
            let p = mesh.corners(f);
            // The longest edge and its opposite half-edge.
            let long = |k: &usize| p[*k].distance(p[(k + 1) % 3]);
            let k = (0..3)
                .max_by(|a, b| long(a).total_cmp(&long(b)))
                .unwrap_or(0);
            let h = 3 * f + k as u32;
            let o = topology.opposite[h as usize];
            // Faces that the inspection reoriented do not match the draft; skip them until the draft is reoriented.
            let turned = |f: u32| topology.turned[f as usize];
            if o == NONE || turned(f) || turned(o / 3) || start(mesh, h) == start(mesh, o) {
                continue;
            }
            let g = o / 3;
            if only_new && draft.region[g as usize] == NONE {
                continue;
            }
            // The flipped edge must be new, and flips of one round must not touch each other.
            let (b, d) = (apex(mesh, h), apex(mesh, o));
            let mut joined = around.of(b).iter();
            let has_edge = joined.any(|f| mesh.faces[*f as usize].contains(&d));
            let own = mesh.faces[f as usize].iter().chain(&mesh.faces[g as usize]);
            // In a chain of collinear faces the edges between these get shorter with each flip, until one has a neighbour with area.
            let apart = mesh.positions[b as usize].distance(mesh.positions[d as usize]);
            let is_chain = is_flat(mesh.corners(g));
            if b == d
                || has_edge
                || (is_chain && apart >= long(&k))
                || own.clone().any(|v| touched.contains(v))
            {
                continue;
            }
            touched.extend(own);
            flips.push((h, o));
        }
        flips
    };
    for &(h, o) in &flips {
        flip(draft, h, o);
    }
    Ok(flips.len())
}

/// Flips the edge between a flat face and its neighbour; the two new faces are parts of the neighbour.
fn flip(draft: &mut Draft, h: u32, o: u32) {
    let (f, g) = (h as usize / 3, o as usize / 3);
    let middle = draft.mesh.faces[f][(h as usize % 3 + 2) % 3];
    let k = o as usize % 3;
    let (face, origin) = (draft.mesh.faces[g], draft.origins.faces[g]);
    // The neighbour runs from `face[k]` to `face[k + 1]` along the edge.
    let [from, to, apex] = [k, (k + 1) % 3, (k + 2) % 3];
    let part = |corners: [Option<usize>; 3]| {
        let vertex = |c: Option<usize>| c.map_or(middle, |c| face[c]);
        let corner = |c: Option<usize>| c.map_or(3, |c| origin.corners[c]);
        let origin = FaceOrigin {
            face: origin.face,
            corners: corners.map(corner),
        };
        (corners.map(vertex), origin)
    };
    let halves = [
        part([Some(from), None, Some(apex)]),
        part([None, Some(to), Some(apex)]),
    ];
    for (place, (face, origin)) in [f, g].into_iter().zip(halves) {
        draft.mesh.faces[place] = face;
        draft.origins.faces[place] = origin;
        draft.region[place] = draft.region[g];
    }
}
