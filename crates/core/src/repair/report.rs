//! Hole and patch entries of a repair's report: open holes, self-intersections of patches, hole numbers.

use std::collections::{BTreeMap, HashMap, HashSet};

use super::draft::Draft;
use super::{Edge, LostComponents, edges};
use crate::fill::{HoleOutcome, LeftReason, OpenReason};
use crate::mend::{FillError, FillReport, HoleReport};
use crate::mesh::topology::NONE;
use crate::mesh::{Hole, HoleId};

/// Adds open holes that the report does not list yet, as holes made by the last cuts. Their outcome is a failure, except for
/// single faces and for outer borders that may stay open, which count as left. A listed hole that was left because its component
/// is small becomes a failure if it has more than three edges and may not stay open. `was_border` returns whether a rim is an
/// outer border of the input that may stay open.
pub(super) fn open(
    draft: &Draft,
    report: &mut FillReport,
    was_border: &dyn Fn(&Hole) -> bool,
) -> Result<(), FillError> {
    let found = draft.inspect()?;
    let holes = &mut report.holes;
    let mut known: HashSet<Edge> = HashSet::new();
    for hole in holes.iter_mut() {
        let is_made = |hole: &Hole| hole.edges > 3 && !was_border(hole);
        match hole.outcome {
            HoleOutcome::Left(LeftReason::SmallComponent) if is_made(&hole.hole) => {
                hole.outcome = HoleOutcome::Open(OpenReason::EveryTriangulationIntersects);
            }
            HoleOutcome::Left(_) | HoleOutcome::Open(_) => {}
            _ => continue,
        }
        known.extend(edges(&hole.hole.rim));
    }
    let mut last = holes.iter().map(|h| h.hole.id.get()).max().unwrap_or(0);
    for hole in &found.holes {
        if edges(&hole.rim).any(|e| known.contains(&e)) {
            continue;
        }
        let faces = found.topology.component_faces[hole.component as usize];
        let outcome = match (faces, was_border(hole)) {
            (1, _) => HoleOutcome::Left(LeftReason::SmallComponent),
            (2, true) => HoleOutcome::Left(LeftReason::SmallComponent),
            (_, true) if hole.outer_boundary => HoleOutcome::Left(LeftReason::OuterBoundary),
            _ => HoleOutcome::Open(OpenReason::EveryTriangulationIntersects),
        };
        last += 1;
        let mut hole = hole.clone();
        hole.id = HoleId(last);
        holes.push(HoleReport {
            hole,
            outcome,
            region: 0,
        });
    }
    Ok(())
}

/// Counts the intersecting faces of each patch.
pub(super) fn count_intersecting_faces(
    draft: &mut Draft,
    report: &mut FillReport,
) -> Result<(), FillError> {
    for region in &mut report.regions {
        region.set_intersecting(0);
    }
    for f in draft.self_intersections()? {
        match draft.region[f as usize] {
            NONE => {}
            region => {
                let region = &mut report.regions[region as usize];
                region.set_intersecting(region.intersecting_faces + 1);
            }
        }
    }
    Ok(())
}

/// The input components with no face left.
pub(super) fn lost_components(component: &[u32], living: &[bool]) -> LostComponents {
    let mut faces: BTreeMap<u32, (usize, bool)> = BTreeMap::new();
    for (component, lives) in component.iter().zip(living).filter(|(c, _)| **c != NONE) {
        let (count, any) = faces.entry(*component).or_default();
        *count += 1;
        *any |= lives;
    }
    let gone = faces.values().filter(|(_, any)| !any);
    let sizes: Vec<usize> = gone.map(|(count, _)| *count).collect();
    LostComponents {
        count: sizes.len(),
        fewest_faces: sizes.iter().min().copied().unwrap_or(0),
        most_faces: sizes.iter().max().copied().unwrap_or(0),
    }
}

/// Renumbers the holes of a report.
pub(super) fn renumber(report: &mut FillReport, numbers: &HashMap<HoleId, HoleId>) {
    let number = |id: &mut HoleId| *id = numbers.get(id).copied().unwrap_or(*id);
    for hole in &mut report.holes {
        number(&mut hole.hole.id);
    }
    for region in &mut report.regions {
        region.holes.iter_mut().for_each(number);
    }
}

/// Adds a number to the numbers of all holes of a report.
pub(super) fn raise_numbers(report: &mut FillReport, by: usize) {
    let regions = report.regions.iter_mut().flat_map(|r| &mut r.holes);
    let holes = report.holes.iter_mut().map(|h| &mut h.hole.id);
    regions.chain(holes).for_each(|id| id.0 += by);
}

/// The largest hole number in a report.
pub(super) fn last_number(report: &FillReport) -> usize {
    let numbers = report.holes.iter().map(|h| h.hole.id.get());
    numbers.max().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mend::Inspection;
    use crate::mesh::shapes::{icosphere, punch};

    #[test]
    fn a_hole_for_which_no_patch_was_made_has_no_number_in_its_reason() {
        let mesh = punch(&icosphere(3), |p| p.z > 0.7);
        let found = Inspection::new(&mesh).unwrap();
        let draft = Draft::new(&mesh, found.topology.component.clone());
        let mut report = FillReport::default();
        open(&draft, &mut report, &|_| false).unwrap();
        let outcomes: Vec<&HoleOutcome> = report.holes.iter().map(|h| &h.outcome).collect();
        assert_eq!(
            outcomes,
            [&HoleOutcome::Open(OpenReason::EveryTriangulationIntersects)]
        );
        let said = OpenReason::EveryTriangulationIntersects.to_string();
        assert!(!said.contains(|c: char| c.is_ascii_digit()), "{said}");
    }
}
