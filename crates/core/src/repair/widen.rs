//! Widens holes that cannot be closed without self-intersections, by cutting rings of faces, until they can be closed.

use std::collections::{BTreeSet, HashMap, HashSet};

use super::clear::Ground;
use super::draft::Draft;
use super::edges;
use super::rim_triangles::{not_smooth, push};
use crate::fill::{Closure, HoleOutcome, OpenReason, RegionReport};
use crate::mend::{FillError, FillReport, HoleReport, Inspection};
use crate::mesh::cut::settled;
use crate::mesh::topology::NONE;
use crate::mesh::{DisjointSets, Hole, HoleId, VertexFaces};

/// A hole to close and the faces to cut out round it.
struct Zone {
    /// Index of the hole in the report.
    report_index: usize,
    /// Rim edges of the hole.
    edges: Vec<(u32, u32)>,
    /// Faces to cut out.
    faces: Vec<u32>,
}

/// Cuts `rings` rings of faces round holes that could not be closed, and closes the result with rim triangles that intersect
/// nothing; holes where this fails are unchanged. At most `most` input faces are removed; returns how many were.
pub(super) fn widen(
    draft: &mut Draft,
    report: &mut FillReport,
    rings: usize,
    most: usize,
) -> Result<usize, FillError> {
    let zones = zones(draft, report, rings, most)?;
    if zones.is_empty() {
        return Ok(0);
    }
    let all = Trial::new(draft, &zones)?;
    if all.good.is_empty() {
        return Ok(0);
    }
    if all.good.len() == zones.len() {
        return apply(draft, report, &zones, all);
    }
    // Try again with the good zones alone, since the cuts of the others changed the ground.
    let zones: Vec<Zone> = zones
        .into_iter()
        .zip(0..)
        .filter_map(|(zone, i)| all.good.contains(&i).then_some(zone))
        .collect();
    let trial = Trial::new(draft, &zones)?;
    if trial.good.len() < zones.len() {
        return Ok(0);
    }
    apply(draft, report, &zones, trial)
}

/// Takes over a trial in which all zones can be closed, if that reduces the faults. Returns the number of input faces removed.
fn apply(
    draft: &mut Draft,
    report: &mut FillReport,
    zones: &[Zone],
    trial: Trial,
) -> Result<usize, FillError> {
    let before = draft.faults()?;
    let (mut new, mut report_index) = (trial.draft, report.clone());
    for (zone, i) in zones.iter().zip(0..) {
        let rims = trial.closed.iter().filter(|(of, _, _)| *of == i);
        record(
            &mut new,
            &mut report_index,
            zone.report_index,
            rims.map(|(_, h, f)| (h, f)),
        );
    }
    if new.faults()? >= before {
        return Ok(0);
    }
    (*draft, *report) = (new, report_index);
    Ok(trial.own)
}

/// The faces to cut out round each open hole that was to be filled, narrowest hole first, as long as at most `most` input faces
/// are removed.
fn zones(
    draft: &Draft,
    report: &FillReport,
    rings: usize,
    most: usize,
) -> Result<Vec<Zone>, FillError> {
    let mut of_edge: HashMap<(u32, u32), usize> = HashMap::new();
    for (report_index, hole) in report.holes.iter().enumerate() {
        let failed =
            matches!(&hole.outcome, HoleOutcome::Open(why) if *why != OpenReason::NotReached);
        if failed {
            edges(&hole.hole.rim).for_each(|e| _ = of_edge.insert(e, report_index));
        }
    }
    if of_edge.is_empty() {
        return Ok(Vec::new());
    }
    let found = draft.inspect()?;
    let vertex_faces = VertexFaces::new(&found.mesh);
    let mut taken = vec![false; found.mesh.faces.len()];
    let mut left = most;
    let mut zones: Vec<Zone> = Vec::new();
    let mut of_report_index: HashMap<usize, usize> = HashMap::new();
    for hole in found.holes.iter().rev() {
        let Some(&report_index) = edges(&hole.rim).find_map(|e| of_edge.get(&e)) else {
            continue;
        };
        let faces: Vec<u32> = around(&found, &vertex_faces, hole, rings)
            .into_iter()
            .filter(|f| !taken[*f as usize])
            .collect();
        let is_old = |f: &&u32| draft.region[**f as usize] == NONE;
        let own = faces.iter().filter(is_old).count();
        if own > left {
            continue;
        }
        left -= own;
        faces.iter().for_each(|f| taken[*f as usize] = true);
        let place = *of_report_index.entry(report_index).or_insert_with(|| {
            zones.push(Zone {
                report_index,
                edges: Vec::new(),
                faces: Vec::new(),
            });
            zones.len() - 1
        });
        zones[place].faces.extend(faces);
        zones[place].edges.extend(edges(&hole.rim));
    }
    Ok(zones)
}

/// The faces of the hole's component within `rings` rings of its rim.
fn around(
    found: &Inspection,
    vertex_faces: &VertexFaces,
    hole: &Hole,
    rings: usize,
) -> BTreeSet<u32> {
    let mut faces = BTreeSet::new();
    let mut border: BTreeSet<u32> = hole.rim.iter().copied().collect();
    for _ in 0..rings {
        let of_border = border.iter().flat_map(|v| vertex_faces.of(*v));
        let own = of_border.filter(|f| found.topology.component[**f as usize] == hole.component);
        let ring: Vec<u32> = own.copied().filter(|f| faces.insert(*f)).collect();
        border = ring
            .iter()
            .flat_map(|f| found.mesh.faces[*f as usize])
            .collect();
    }
    faces
}

/// The result of cutting zones out and closing their rims.
struct Trial {
    draft: Draft,
    /// Indices of zones with all rims closed.
    good: HashSet<usize>,
    /// The rims that can be closed: zone, rim, and closing faces.
    closed: Vec<(usize, Hole, Vec<[u32; 3]>)>,
    /// Input faces removed.
    own: usize,
}

impl Trial {
    fn new(draft: &Draft, zones: &[Zone]) -> Result<Self, FillError> {
        let mut zone_of = vec![NONE; draft.mesh.faces.len()];
        for (zone, i) in zones.iter().zip(0..) {
            zone.faces.iter().for_each(|f| zone_of[*f as usize] = i);
        }
        let mut sets = DisjointSets::new(zones.len());
        let (removed, of_edge) = {
            let found = draft.inspect()?;
            let marks: Vec<bool> = zone_of.iter().map(|z| *z != NONE).collect();
            let mut removed = settled(&found.mesh, &found.topology, &marks, true);
            draft.protect_components(&mut removed);
            let of_edge = zone_edges(&found, zones, &removed, &mut zone_of, &mut sets);
            (removed, of_edge)
        };
        // Cut a copy of the draft.
        let gone = removed.iter().zip(&draft.region);
        let own = gone.filter(|(r, region)| **r && **region == NONE).count();
        let mut left = draft.clone();
        let is_cut = left.remove(&removed) > 0;
        if !is_cut && zones.iter().any(|z| !z.faces.is_empty()) {
            // Nothing can be cut here, so the rims are the same as with 0 rings, which could not be closed.
            return Ok(Self {
                draft: left,
                good: HashSet::new(),
                closed: Vec::new(),
                own,
            });
        }
        // Close all rims; zones that share a rim succeed or fail together.
        let (mut closed, mut bad) = (Vec::new(), HashSet::new());
        {
            let found = left.inspect()?;
            let mut ground = Ground::new(&found);
            for hole in &found.holes {
                let own: BTreeSet<u32> = edges(&hole.rim)
                    .filter_map(|e| of_edge.get(&e).copied())
                    .collect();
                let Some(&first) = own.first() else { continue };
                own.iter().for_each(|z| _ = sets.join(first, *z));
                match ground.close(&hole.rim) {
                    Some(faces) => closed.push((first as usize, hole.clone(), faces)),
                    None => _ = bad.insert(first),
                }
            }
        }
        let bad: HashSet<u32> = bad.into_iter().map(|z| sets.find(z)).collect();
        let good = (0..zones.len())
            .filter(|z| !bad.contains(&sets.find(*z as u32)))
            .collect();
        Ok(Self {
            draft: left,
            good,
            closed,
            own,
        })
    }
}

/// The zone of each edge of a rim or of a removed face. Removed faces next to a zone join it.
fn zone_edges(
    found: &Inspection,
    zones: &[Zone],
    removed: &[bool],
    zone_of: &mut [u32],
    sets: &mut DisjointSets,
) -> HashMap<(u32, u32), u32> {
    let mut of_edge: HashMap<(u32, u32), u32> = HashMap::new();
    for (zone, i) in zones.iter().zip(0..) {
        zone.edges.iter().for_each(|e| _ = of_edge.insert(*e, i));
    }
    let mut rest: Vec<usize> = (0..removed.len()).filter(|f| removed[*f]).collect();
    loop {
        let before = rest.len();
        rest.retain(|&f| {
            let face = found.mesh.faces[f];
            if zone_of[f] == NONE {
                let beside = edges(&face).find_map(|e| of_edge.get(&e));
                zone_of[f] = beside.copied().unwrap_or(NONE);
            }
            let zone = zone_of[f];
            if zone == NONE {
                return true;
            }
            for e in edges(&face) {
                let other = *of_edge.entry(e).or_insert(zone);
                sets.join(other, zone);
            }
            false
        });
        if rest.len() == before {
            return of_edge;
        }
    }
}

/// Adds the faces that close a zone and records them in the report.
fn record<'a>(
    draft: &mut Draft,
    report: &mut FillReport,
    report_index: usize,
    rims: impl Iterator<Item = (&'a Hole, &'a Vec<[u32; 3]>)>,
) {
    let region = report.regions.len();
    let mut holes = vec![report.holes[report_index].hole.id];
    let how = Closure::RimTriangles(not_smooth(&report.holes[report_index].outcome));
    let outcome = HoleOutcome::Closed(how.clone());
    report.holes[report_index].outcome = outcome.clone();
    report.holes[report_index].region = region + 1;
    let mut diameter = report.holes[report_index].hole.diameter;
    let mut components = 0;
    for (i, (rim, faces)) in rims.enumerate() {
        faces.iter().for_each(|f| push(draft, region as u32, *f));
        components += 1;
        diameter = rim.diameter.max(diameter);
        if i > 0 {
            let mut hole = rim.clone();
            let last = report.holes.iter().map(|h| h.hole.id.get()).max();
            hole.id = HoleId(last.unwrap_or(0) + 1);
            holes.push(hole.id);
            report.holes.push(HoleReport {
                hole,
                outcome: outcome.clone(),
                region: region + 1,
            });
        }
    }
    report.regions.push(RegionReport {
        id: region + 1,
        holes,
        diameter,
        closure: Some(how),
        components,
        ..RegionReport::default()
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::{CheckParams, DefectKind};
    use crate::fill::{AttemptFailure, NotSmooth};
    use crate::mesh::Mesh;
    use crate::mesh::shapes::icosphere;

    /// The lower half of a sphere, and a small sphere at the level of its rim.
    fn bowl() -> Mesh {
        let ball = icosphere(3);
        let middle = |f: &[u32; 3]| f.map(|v| ball.positions[v as usize].z).iter().sum::<f64>();
        let lower = ball.faces.iter().filter(|f| middle(f) < 0.0);
        let mut mesh = Mesh::new(ball.positions.clone(), lower.copied().collect());
        let first = ball.positions.len() as u32;
        let small = ball.positions.iter().map(|p| 0.2 * *p);
        mesh.positions
            .extend(small.map(|p| p + 0.05 * glam::DVec3::Z));
        mesh.faces
            .extend(ball.faces.iter().map(|f| f.map(|v| v + first)));
        mesh
    }

    #[test]
    fn a_hole_is_widened_until_something_closes_it() {
        let mesh = bowl();
        let found = Inspection::new(&mesh).unwrap();
        assert_eq!(found.holes.len(), 1);
        let report_index = HoleReport {
            hole: found.holes[0].clone(),
            outcome: HoleOutcome::Open(OpenReason::Intersects(7)),
            region: 0,
        };
        let mut report = FillReport {
            holes: vec![report_index],
            ..FillReport::default()
        };
        let mut draft = Draft::new(&mesh, found.topology.component.clone());
        let mut lost = 0;
        for rings in 0..3 {
            lost += widen(&mut draft, &mut report, rings, 10).unwrap();
        }
        assert_eq!((lost, &draft.mesh), (0, &mesh), "more than may go");
        for rings in 0..3 {
            lost += widen(&mut draft, &mut report, rings, 1000).unwrap();
        }
        assert!((20..400).contains(&lost), "{lost}");
        let after = draft.inspect().unwrap().check(&CheckParams::default());
        assert!(after.is_closed() && after.count(DefectKind::SelfIntersection) == 0);
        let why = NotSmooth::NoSurface(AttemptFailure::Intersects(7));
        assert_eq!(
            report.holes[0].outcome,
            HoleOutcome::Closed(Closure::RimTriangles(why))
        );
        assert_eq!(report.holes[0].region, 1);
        let old = draft.region.iter().filter(|r| **r == NONE).count();
        assert_eq!(old + lost, mesh.faces.len());
    }
}
