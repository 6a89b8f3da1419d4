//! Components that another one repeats up to rounding: a part that is twice in a file.

use std::collections::{HashMap, HashSet};

use glam::DVec3;

use super::RepairReport;
use super::draft::Draft;
use super::intersection_cache::sorted;
use crate::check::WELD_UNITS;
use crate::mend::{FillError, Inspection};
use crate::mesh::topology::NONE;

/// Removes each component that has the faces of an earlier one, with vertices that differ by rounding only.
pub(super) fn drop(draft: &mut Draft, report: &mut RepairReport) -> Result<(), FillError> {
    let removed: Vec<bool> = {
        let found = draft.inspect()?;
        let twins = twins(&found, precision(draft));
        if twins.is_empty() {
            return Ok(());
        }
        let component = found.topology.component.iter();
        component.map(|p| *p != NONE && twins.contains(p)).collect()
    };
    report.steps.duplicate_faces += draft.remove(&removed);
    Ok(())
}

/// The distance up to which positions of the draft, or of its output, are rounded, in mesh units.
fn precision(draft: &Draft) -> f64 {
    let largest = draft.mesh.positions.iter().map(|p| p.abs().max_element());
    let largest = largest.fold(0.0, f64::max);
    let is_single = draft.rounding.is_single()
        || draft
            .mesh
            .positions
            .iter()
            .all(|p| super::rounding::is_single(*p));
    match is_single {
        true => draft
            .unit
            .max(WELD_UNITS.get() * f64::from(f32::EPSILON) * largest),
        false => draft.unit,
    }
}

fn twins(found: &Inspection, reach: f64) -> HashSet<u32> {
    let (mesh, topology) = (&found.mesh, &found.topology);
    let boxes = topology.component_bounds(mesh);
    let cell = |p: DVec3| {
        (p / (2.0 * reach).max(f64::MIN_POSITIVE))
            .round()
            .to_array()
            .map(|x| x as i64)
    };
    // Only components with the same number of faces and the same box can be twins.
    let mut alike: HashMap<(usize, [i64; 3]), Vec<u32>> = HashMap::new();
    let mut pairs: Vec<(u32, u32)> = Vec::new();
    for (c, (low, _)) in boxes.iter().enumerate() {
        let (count, at) = (topology.component_faces[c], cell(*low));
        for i in 0..27 {
            let near = [at[0] + i % 3 - 1, at[1] + i / 3 % 3 - 1, at[2] + i / 9 - 1];
            let earlier = alike.get(&(count, near)).into_iter().flatten();
            pairs.extend(earlier.map(|e| (*e, c as u32)));
        }
        alike.entry((count, at)).or_default().push(c as u32);
    }
    if pairs.is_empty() {
        return HashSet::new();
    }
    let involved: HashSet<u32> = pairs.iter().flat_map(|(a, b)| [*a, *b]).collect();
    let mut faces: HashMap<u32, Vec<[u32; 3]>> = HashMap::new();
    for f in topology.faces() {
        let component = topology.component[f as usize];
        if involved.contains(&component) {
            // In the orientation of the draft.
            let welded = found.input.faces[f as usize].map(|v| found.weld[v as usize]);
            faces.entry(component).or_default().push(welded);
        }
    }
    let mut twins = HashSet::new();
    for (first, second) in pairs {
        let is_known = twins.contains(&first) || twins.contains(&second);
        if !is_known && are_twins(&mesh.positions, [&faces[&first], &faces[&second]], reach) {
            twins.insert(second);
        }
    }
    twins
}

/// The corners of a face in their order, beginning with the lowest.
fn first_lowest([a, b, c]: [u32; 3]) -> [u32; 3] {
    match a.min(b).min(c) {
        low if low == a => [a, b, c],
        low if low == b => [b, c, a],
        _ => [c, a, b],
    }
}

/// Whether each vertex of the second faces lies within `reach` of one of the first, and the faces are the same then.
fn are_twins(positions: &[DVec3], [first, second]: [&[[u32; 3]]; 2], reach: f64) -> bool {
    let cell = |p: DVec3| {
        (p / (2.0 * reach).max(f64::MIN_POSITIVE))
            .floor()
            .to_array()
            .map(|x| x as i64)
    };
    let mut at: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    for &v in first.iter().flatten() {
        let own = at.entry(cell(positions[v as usize])).or_default();
        if !own.contains(&v) {
            own.push(v);
        }
    }
    let mut to: HashMap<u32, u32> = HashMap::new();
    for &v in second.iter().flatten() {
        if to.contains_key(&v) {
            continue;
        }
        let p = positions[v as usize];
        let [x, y, z] = cell(p);
        let near = (0..27).flat_map(|i| {
            let near = [x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1];
            at.get(&near).into_iter().flatten().copied()
        });
        let distance = |w: u32| p.distance(positions[w as usize]);
        let nearest = near.min_by(|a, b| distance(*a).total_cmp(&distance(*b)).then(a.cmp(b)));
        match nearest.filter(|w| distance(*w) <= 2.0 * reach) {
            Some(w) => to.insert(v, w),
            None => return false,
        };
    }
    let known: HashSet<[u32; 3]> = first.iter().map(|f| sorted(*f)).collect();
    let same: HashSet<[u32; 3]> = second.iter().map(|f| sorted(f.map(|v| to[&v]))).collect();
    // The same faces the other way round are the wall between two bodies that touch.
    let turned: HashSet<[u32; 3]> = first
        .iter()
        .map(|[a, b, c]| first_lowest([*a, *c, *b]))
        .collect();
    let is_wall = second.iter().all(|f| turned.contains(&first_lowest(*f)));
    known == same && !is_wall
}
