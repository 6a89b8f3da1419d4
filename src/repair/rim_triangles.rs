//! Patches that cross others give way to triangles between the vertices of their rims that cross nothing; where there are no such
//! triangles, the hole stays open and the report says so.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use super::clear::Ground;
use super::draft::Draft;
use super::edges;
use crate::fill::{
    ClosedBy, FailedReason, HoleOutcome, LeftReason, TriangulatedReason, TryFailure,
};
use crate::mend::{FillError, FillReport, Inspection};
use crate::mesh::topology::NONE;
use crate::mesh::{FaceOrigin, Hole, weld_map};

/// What became of a rim.
pub(super) enum Rim {
    /// It was closed by these faces.
    Closed(Vec<[u32; 3]>),
    /// Nothing closes it that crosses nothing.
    Open,
    /// It is no hole, but the border of an open sheet.
    Left,
}

/// Takes patches that cross others out, those that cross the most at last put back, and closes their rims by triangles between their
/// vertices, where that crosses nothing. `is_border` says which holes are to be left then.
pub(super) fn settle(
    draft: &mut Draft,
    report: &mut FillReport,
    is_border: &dyn Fn(&Hole) -> bool,
) -> Result<(), FillError> {
    let crossing = crossing_regions(draft)?;
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
        let mut order: Vec<(usize, u32)> = crossing.iter().map(|(r, n)| (*n, *r)).collect();
        order.sort_unstable();
        for (_, region) in order {
            let own = draft.mesh.faces.iter().zip(&draft.region);
            let own = own.filter(|(_, r)| **r == region);
            let own: Vec<[u32; 3]> = own
                .map(|(f, _)| f.map(|v| found.weld[v as usize]))
                .collect();
            if ground.takes(&own) {
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

/// Writes into a report what became of the rims of a region.
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
    own.closed_by = Some(match open {
        true => ClosedBy::Nothing,
        false => ClosedBy::RimTriangles,
    });
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
            Rim::Closed(_) => (0, triangulated(crossing)),
            Rim::Left => (1, HoleOutcome::Left(LeftReason::OuterBorder)),
            Rim::Open => (2, HoleOutcome::Failed(FailedReason::Crossing(crossing))),
        });
        if let Some((_, worst)) = outcome.max_by_key(|(badness, _)| *badness) {
            hole.outcome = worst;
        }
    }
}

/// The outcome of a hole that is closed by triangles after its patch crossed others with so many faces.
fn triangulated(crossing: usize) -> HoleOutcome {
    HoleOutcome::Triangulated(TriangulatedReason::NoSurface(TryFailure::Crossing(
        crossing,
    )))
}

/// The outcome of a hole that was open and is closed by triangles, or by an offset shell.
pub(super) fn closed_after(before: &HoleOutcome) -> HoleOutcome {
    match before {
        HoleOutcome::Failed(FailedReason::Crossing(n)) => triangulated(*n),
        HoleOutcome::Failed(FailedReason::NoTriangulation { after, .. }) => {
            HoleOutcome::Triangulated(after.clone())
        }
        _ => HoleOutcome::Triangulated(TriangulatedReason::LastSteps),
    }
}

/// The regions whose patches cross others, with how many faces cross because of them.
fn crossing_regions(draft: &mut Draft) -> Result<BTreeMap<u32, usize>, FillError> {
    let mut count = BTreeMap::new();
    for (f, g) in draft.crossing_pairs()? {
        let [own, other] = [f, g].map(|f| draft.region[f as usize]);
        for region in BTreeSet::from([own, other]) {
            *count.entry(region).or_insert(0) += 1;
        }
    }
    count.remove(&NONE);
    Ok(count)
}

/// The draft without the patches of some regions.
fn without(draft: &Draft, regions: &BTreeSet<u32>) -> Draft {
    let mut left = draft.clone();
    let removed: Vec<bool> = draft.region.iter().map(|r| regions.contains(r)).collect();
    left.remove(&removed);
    left
}

/// Adds a face of a region's patch.
pub(super) fn push(draft: &mut Draft, region: u32, face: [u32; 3]) {
    draft.mesh.faces.push(face);
    draft.origins.faces.push(FaceOrigin::NEW);
    draft.region.push(region);
}

/// The rims that are left where the patches of some regions were.
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
