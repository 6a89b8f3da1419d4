//! Dangling sheets: small open sheets attached to much larger surfaces at non-manifold edges that cannot be separated, as folds
//! of scans.
//!
//! They count as parts of the surface that carries them (the host). They are removed where they intersect it, and where it is
//! closed and they are not.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use super::RepairReport;
use super::draft::Draft;
use super::sheets::{open_components, paired};
use super::{Edge, edges};
use crate::fill::{HoleOutcome, OpenReason};
use crate::mend::{FillError, FillReport, Inspection};
use crate::mesh::topology::NONE;
use crate::mesh::{Topology, area_vector};
use crate::tuning::{Tunable, tunable};

/// Fraction of the area of the component that it is attached to. A smaller sheet is a dangling sheet.
const DANGLING: Tunable<f64> = tunable("repair.dangling", 0.01);

/// Assigns dangling sheets to the component of their host.
pub(super) fn join(draft: &mut Draft) -> Result<(), FillError> {
    let joins: Vec<(Vec<usize>, usize)> = {
        let found = draft.inspect()?;
        let hosts = hosts(&found);
        let involved: BTreeSet<u32> = hosts.iter().flat_map(|(p, q)| [*p, *q]).collect();
        let mut faces: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for f in found.topology.faces() {
            let component = found.topology.component[f as usize];
            if involved.contains(&component) {
                faces.entry(component).or_default().push(f as usize);
            }
        }
        let join = |(dangling, host): (&u32, &u32)| {
            let own = faces[dangling].clone();
            (own, most(draft, &faces[host]))
        };
        hosts.iter().map(join).collect()
    };
    for (faces, host) in joins {
        draft.join(&faces, host);
    }
    Ok(())
}

/// A face of the input component that most of the given faces belong to.
fn most(draft: &Draft, faces: &[usize]) -> usize {
    let mut count: BTreeMap<u32, (usize, usize)> = BTreeMap::new();
    for &f in faces {
        count.entry(draft.component(f)).or_insert((0, f)).0 += 1;
    }
    let most = count.values().max();
    most.map_or(faces[0], |(_, f)| *f)
}

/// The largest host of each dangling component.
fn hosts(found: &Inspection) -> BTreeMap<u32, u32> {
    let (mesh, topology) = (&found.mesh, &found.topology);
    let (_, unclear) = paired(found, &topology.non_manifold_edges(mesh));
    if unclear.is_empty() {
        return BTreeMap::new();
    }
    let mut area = vec![0.0; topology.component_faces.len()];
    for f in topology.faces() {
        let own = 0.5 * area_vector(mesh.corners(f)).length();
        area[topology.component[f as usize] as usize] += own;
    }
    let open = open_components(topology);
    let mut hosts: BTreeMap<u32, u32> = BTreeMap::new();
    for half_edges in unclear {
        let ids = half_edges
            .iter()
            .map(|h| topology.component[*h as usize / 3]);
        let ids: BTreeSet<u32> = ids.collect();
        let larger = |p: &&u32, q: &&u32| area[**p as usize].total_cmp(&area[**q as usize]);
        let Some(&largest) = ids.iter().max_by(larger) else {
            continue;
        };
        let is_dangling = |p: &&u32| {
            open[**p as usize] && area[**p as usize] < DANGLING.get() * area[largest as usize]
        };
        for &p in ids.iter().filter(is_dangling) {
            let host = hosts.entry(p).or_insert(largest);
            if area[*host as usize] < area[largest as usize] {
                *host = largest;
            }
        }
    }
    hosts
}

/// Whether each component consists of dangling sheets only, patches not considered.
pub(super) fn components(draft: &Draft, topology: &Topology) -> Vec<bool> {
    let (mut some, mut all) = (
        vec![false; topology.component_faces.len()],
        vec![true; topology.component_faces.len()],
    );
    for f in topology.faces() {
        let component = topology.component[f as usize] as usize;
        if let Some(dangling) = draft.is_dangling(f as usize) {
            some[component] = true;
            all[component] &= dangling;
        }
    }
    some.iter()
        .zip(all)
        .map(|(some, all)| *some && all)
        .collect()
}

/// The open dangling sheets whose component is closed otherwise.
fn hanging(draft: &Draft, found: &Inspection) -> Vec<bool> {
    let topology = &found.topology;
    let open = open_components(topology);
    let dangling = components(draft, topology);
    let component = |f: u32| topology.component[f as usize] as usize;
    let mut is_closed: HashMap<u32, bool> = HashMap::new();
    for f in topology.faces().filter(|f| !dangling[component(*f)]) {
        *is_closed.entry(draft.component(f as usize)).or_insert(true) &= !open[component(f)];
    }
    let mut hang: Vec<bool> = dangling.iter().zip(&open).map(|(s, o)| *s && *o).collect();
    for f in topology.faces().filter(|f| dangling[component(*f)]) {
        let of_input = draft.component(f as usize);
        hang[component(f)] &= of_input == NONE || is_closed.get(&of_input) == Some(&true);
    }
    hang
}

/// Records the left borders of dangling sheets as failures if the rest of their component is closed.
pub(super) fn close(draft: &Draft, report: &mut FillReport) -> Result<(), FillError> {
    if !draft.has_dangling() {
        return Ok(());
    }
    let found = draft.inspect()?;
    let hang = hanging(draft, &found);
    let own = found.holes.iter().filter(|h| hang[h.component as usize]);
    let rims: HashSet<Edge> = own.flat_map(|h| edges(&h.rim)).collect();
    for hole in &mut report.holes {
        let is_one = edges(&hole.hole.rim).any(|e| rims.contains(&e));
        if is_one && matches!(hole.outcome, HoleOutcome::Left(_)) {
            hole.outcome = HoleOutcome::Open(OpenReason::EveryTriangulationIntersects);
        }
    }
    Ok(())
}

/// Removes open dangling sheets if the rest of their component is closed, and the report entries of their borders. If `may_stay`,
/// sheets that intersect nothing are kept.
pub(super) fn drop(
    draft: &mut Draft,
    report: &mut RepairReport,
    may_stay: bool,
) -> Result<(), FillError> {
    if !draft.has_dangling() {
        return Ok(());
    }
    let crossing = match may_stay {
        true => draft.self_intersections()?,
        false => Vec::new(),
    };
    let (removed, rims) = {
        let found = draft.inspect()?;
        let topology = &found.topology;
        let mut goes = hanging(draft, &found);
        if may_stay {
            let mut crosses = vec![false; goes.len()];
            for f in crossing {
                crosses[topology.component[f as usize] as usize] = true;
            }
            goes.iter_mut().zip(crosses).for_each(|(g, c)| *g &= c);
        }
        let mut removed = vec![false; draft.mesh.faces.len()];
        for f in topology.faces() {
            removed[f as usize] = goes[topology.component[f as usize] as usize];
        }
        let gone = found.holes.iter().filter(|h| goes[h.component as usize]);
        let rims: HashSet<Edge> = gone.flat_map(|h| edges(&h.rim)).collect();
        (removed, rims)
    };
    report.steps.non_manifold_faces += draft.remove(&removed);
    let holes = &mut report.fill.holes;
    holes.retain(|h| {
        h.outcome.closure().is_some() || !edges(&h.hole.rim).any(|e| rims.contains(&e))
    });
    Ok(())
}
