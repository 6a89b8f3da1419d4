//! Patches that cross others whatever was done give way to triangles between the vertices of their rims.

use std::collections::{BTreeSet, HashMap, HashSet};

use super::draft::Draft;
use super::edges;
use crate::check::crossing;
use crate::mend::{
    ClosedBy, FillError, FillReport, HoleOutcome, HoleReport, RegionReport, TriangulatedReason,
    TryFailure,
};
use crate::mesh::topology::NONE;
use crate::mesh::triangulate::triangulate_loop_beside;
use crate::mesh::{FaceOrigin, Hole, weld_map};

/// Components of at most so many faces are not closed.
const SMALL_FACES: usize = 2;

/// Closes the holes of patches that cross others with triangles between the vertices of their rims, where these cross nothing.
/// Returns the places of the regions whose patches went.
pub(super) fn flatten(draft: &mut Draft) -> Result<BTreeSet<u32>, FillError> {
    let wrong = crossing_regions(draft)?;
    if wrong.is_empty() {
        return Ok(wrong);
    }
    let mut trial = without(draft, &wrong);
    let flat = rim_triangles(draft, &trial, &wrong)?;
    for (region, face) in &flat {
        push(&mut trial, *region, *face);
    }
    let still = crossing_regions(&trial)?;
    let closed: BTreeSet<u32> = flat.iter().map(|(region, _)| *region).collect();
    let better: BTreeSet<u32> = closed.difference(&still).copied().collect();
    if better.is_empty() {
        return Ok(better);
    }
    let mut new = without(draft, &better);
    for (region, face) in flat.iter().filter(|(region, _)| better.contains(region)) {
        push(&mut new, *region, *face);
    }
    *draft = new;
    Ok(better)
}

/// Closes the holes that are no part of the old border, where they can be; returns how many.
pub(super) fn close(
    draft: &mut Draft,
    old: &HashSet<(u32, u32)>,
    report: &mut FillReport,
) -> Result<usize, FillError> {
    let mut closed = Vec::new();
    {
        let found = draft.inspect()?;
        let mut new: Vec<[u32; 3]> = Vec::new();
        let is_made = |hole: &&Hole| {
            // A face or two by themselves have no inside: what closed them would lie on them.
            let faces = found.topology.piece_faces[hole.piece as usize];
            faces > SMALL_FACES && edges(&hole.rim).any(|e| !old.contains(&e))
        };
        for hole in found.holes.iter().filter(is_made) {
            if let Ok(faces) = triangulate_loop_beside(&found.mesh, &hole.rim, &new) {
                new.extend(&faces);
                closed.push((hole.clone(), faces));
            }
        }
    }
    let count = closed.len();
    for (mut hole, faces) in closed {
        hole.id = report.holes.len() + 1;
        let region = report.regions.len();
        report.regions.push(RegionReport {
            id: region + 1,
            holes: vec![hole.id],
            diameter: hole.diameter,
            closed_by: Some(ClosedBy::RimTriangles),
            components: 1,
            ..RegionReport::default()
        });
        let why = TriangulatedReason::NoSurface(TryFailure::Crossing(faces.len()));
        report.holes.push(HoleReport {
            hole,
            outcome: HoleOutcome::Triangulated(why),
            region: region + 1,
        });
        for face in faces {
            push(draft, region as u32, face);
        }
    }
    Ok(count)
}

/// The regions whose patches cross others.
fn crossing_regions(draft: &Draft) -> Result<BTreeSet<u32>, FillError> {
    let found = draft.inspect()?;
    let pairs = crossing(&found.mesh, &found.topology);
    let regions = pairs.iter().map(|(f, _)| draft.region[*f as usize]);
    Ok(regions.filter(|r| *r != NONE).collect())
}

/// The draft without the patches of some regions.
fn without(draft: &Draft, regions: &BTreeSet<u32>) -> Draft {
    let mut left = draft.clone();
    let removed: Vec<bool> = draft.region.iter().map(|r| regions.contains(r)).collect();
    left.remove(&removed);
    left
}

fn push(draft: &mut Draft, region: u32, face: [u32; 3]) {
    draft.mesh.faces.push(face);
    draft.origins.faces.push(FaceOrigin::NEW);
    draft.region.push(region);
}

/// Triangles between the vertices of the rims that some patches leave, with their regions; none of a region one of whose rims
/// cannot be closed so.
fn rim_triangles(
    draft: &Draft,
    trial: &Draft,
    regions: &BTreeSet<u32>,
) -> Result<Vec<(u32, [u32; 3])>, FillError> {
    let weld = weld_map(&draft.mesh);
    let mut of_edge: HashMap<(u32, u32), u32> = HashMap::new();
    let patches = draft.mesh.faces.iter().zip(&draft.region);
    for (face, region) in patches.filter(|(_, r)| regions.contains(r)) {
        let corners = face.map(|v| weld[v as usize]);
        edges(&corners).for_each(|e| _ = of_edge.insert(e, *region));
    }
    let found = trial.inspect()?;
    let mut failed: HashSet<u32> = HashSet::new();
    let mut faces: Vec<(u32, [u32; 3])> = Vec::new();
    let mut all = Vec::new();
    for hole in &found.holes {
        let Some(&region) = edges(&hole.rim).find_map(|e| of_edge.get(&e)) else {
            continue;
        };
        match triangulate_loop_beside(&found.mesh, &hole.rim, &all) {
            Ok(own) => {
                all.extend(&own);
                faces.extend(own.into_iter().map(|f| (region, f)));
            }
            Err(_) => _ = failed.insert(region),
        }
    }
    faces.retain(|(region, _)| !failed.contains(region));
    Ok(faces)
}
