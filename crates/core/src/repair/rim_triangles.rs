//! Replaces patches that intersect other faces by triangles between the rim vertices that intersect nothing. If there are none,
//! the hole stays open and the report says so.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use super::clear::Ground;
use super::draft::Draft;
use super::edges;
use crate::fill::{AttemptFailure, Closure, HoleOutcome, LeftReason, NotSmooth, OpenReason};
use crate::mend::{FillError, FillReport, Inspection};
use crate::mesh::topology::NONE;
use crate::mesh::{FaceOrigin, Hole, weld_map};

/// The result for a rim.
pub(super) enum Rim {
    /// Closed by these faces.
    Closed(Vec<[u32; 3]>),
    /// Open: every triangulation that was tried intersects something.
    Open,
    /// Left open: it is the outer border of a sheet.
    Left,
}

/// Removes patches that intersect others and closes their rims by triangles between the rim vertices that intersect nothing.
/// Patches are processed in the order of rising numbers of intersecting faces, and one that intersects nothing any more is kept.
/// `is_border` returns whether a hole is to be left open.
pub(super) fn settle(
    draft: &mut Draft,
    report: &mut FillReport,
    is_border: &dyn Fn(&Hole) -> bool,
) -> Result<(), FillError> {
    let crossing = intersecting_regions(draft)?;
    if crossing.is_empty() {
        return Ok(());
    }
    let wrong: BTreeSet<u32> = crossing.keys().copied().collect();
    let trial = without(draft, &wrong);
    let mut gone = wrong.clone();
    let mut results: Vec<(u32, Hole, Rim)> = Vec::new();
    {
        let found = trial.inspect()?;
        let mut ground = Ground::new(&found);
        let rims = rims_of(draft, &found, &wrong);
        // Put back patches that are clear now, the least intersecting first, and triangulate the rims of the others.
        let mut order: Vec<(usize, u32)> = crossing.iter().map(|(r, n)| (*n, *r)).collect();
        order.sort_unstable();
        for (_, region) in order {
            let own = draft.mesh.faces.iter().zip(&draft.region);
            let own = own.filter(|(_, r)| **r == region);
            let own: Vec<[u32; 3]> = own
                .map(|(f, _)| f.map(|v| found.weld[v as usize]))
                .collect();
            if ground.try_add(&own) {
                gone.remove(&region);
                continue;
            }
            for hole in rims.get(&region).into_iter().flatten() {
                let rim = match is_border(hole) {
                    true => Rim::Left,
                    false => ground.close(&hole.rim).map_or(Rim::Open, Rim::Closed),
                };
                results.push((region, (*hole).clone(), rim));
            }
        }
    }
    // Apply the result to the draft and to the report.
    let mut new = without(draft, &gone);
    for (region, _, rim) in &results {
        if let Rim::Closed(faces) = rim {
            faces.iter().for_each(|f| push(&mut new, *region, *f));
        }
    }
    *draft = new;
    for region in wrong {
        let own: Vec<&(u32, Hole, Rim)> = results.iter().filter(|t| t.0 == region).collect();
        record(
            report,
            region,
            &own,
            crossing[&region],
            gone.contains(&region),
        );
    }
    Ok(())
}

/// Records the results for the rims of a region.
fn record(
    report: &mut FillReport,
    region: u32,
    rims: &[&(u32, Hole, Rim)],
    crossing: usize,
    gone: bool,
) {
    let own = &mut report.regions[region as usize];
    own.set_intersecting(0);
    if !gone {
        return;
    }
    let open = rims
        .iter()
        .any(|(_, _, rim)| !matches!(rim, Rim::Closed(_)));
    own.closure = (!open).then(|| Closure::RimTriangles(intersected(crossing)));
    own.new_vertices = 0;
    own.finish = None;
    own.components = rims.len();
    for hole in report
        .holes
        .iter_mut()
        .filter(|h| h.region == region as usize + 1)
    {
        let own: BTreeSet<_> = edges(&hole.hole.rim).collect();
        let is_own = |other: &Hole| edges(&other.rim).any(|e| own.contains(&e));
        let ends = rims.iter().filter(|(_, rim, _)| is_own(rim));
        let outcome = ends.map(|(_, _, rim)| match rim {
            Rim::Closed(_) => {
                let how = Closure::RimTriangles(intersected(crossing));
                (0, HoleOutcome::Closed(how))
            }
            Rim::Left => (1, HoleOutcome::Left(LeftReason::OuterBoundary)),
            Rim::Open => (2, HoleOutcome::Open(OpenReason::Intersects(crossing))),
        });
        if let Some((_, worst)) = outcome.max_by_key(|(badness, _)| *badness) {
            hole.outcome = worst;
        }
    }
}

/// Why a hole has no smooth surface: its patch had this many intersecting faces.
fn intersected(faces: usize) -> NotSmooth {
    NotSmooth::NoSurface(AttemptFailure::Intersects(faces))
}

/// Why a hole that was open gets no smooth surface, but rim triangles or an offset shell.
pub(super) fn not_smooth(before: &HoleOutcome) -> NotSmooth {
    match before {
        HoleOutcome::Open(OpenReason::Intersects(faces)) => intersected(*faces),
        HoleOutcome::Open(OpenReason::NoTriangulation { after, .. }) => after.clone(),
        _ => NotSmooth::LastSteps,
    }
}

/// The regions whose patches intersect others, with the number of intersecting faces that they cause.
fn intersecting_regions(draft: &mut Draft) -> Result<BTreeMap<u32, usize>, FillError> {
    let mut count = BTreeMap::new();
    for (f, g) in draft.self_intersection_pairs()? {
        let [own, other] = [f, g].map(|f| draft.region[f as usize]);
        for region in BTreeSet::from([own, other]) {
            *count.entry(region).or_insert(0) += 1;
        }
    }
    count.remove(&NONE);
    Ok(count)
}

/// A copy of the draft without the patches of some regions.
fn without(draft: &Draft, regions: &BTreeSet<u32>) -> Draft {
    let mut left = draft.clone();
    let removed: Vec<bool> = draft.region.iter().map(|r| regions.contains(r)).collect();
    left.remove(&removed);
    left
}

/// Adds a face to the patch of a region.
pub(super) fn push(draft: &mut Draft, region: u32, face: [u32; 3]) {
    draft.mesh.faces.push(face);
    draft.origins.faces.push(FaceOrigin::NEW);
    draft.region.push(region);
}

/// The holes left by removing the patches of some regions.
fn rims_of<'a>(
    draft: &Draft,
    found: &'a Inspection,
    regions: &BTreeSet<u32>,
) -> BTreeMap<u32, Vec<&'a Hole>> {
    let weld = weld_map(&draft.mesh);
    let mut of_edge: HashMap<(u32, u32), u32> = HashMap::new();
    let patches = draft.mesh.faces.iter().zip(&draft.region);
    for (face, region) in patches.filter(|(_, r)| regions.contains(r)) {
        let corners = face.map(|v| weld[v as usize]);
        edges(&corners).for_each(|e| _ = of_edge.insert(e, *region));
    }
    let mut rims: BTreeMap<u32, Vec<&Hole>> = BTreeMap::new();
    for hole in &found.holes {
        if let Some(&region) = edges(&hole.rim).find_map(|e| of_edge.get(&e)) {
            rims.entry(region).or_default().push(hole);
        }
    }
    rims
}
