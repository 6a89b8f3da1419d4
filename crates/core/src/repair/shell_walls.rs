//! Wall thickness of offset shells, for each component of the result.

use std::collections::{BTreeMap, HashMap};

use super::draft::Draft;
use super::offset_shell::WallFace;
use super::offset_shells::ShellWall;
use super::params::{RepairParams, RepairReport};
use crate::check::{CheckParams, Component, components};
use crate::mend::{FillError, Inspection};
use crate::mesh::Mesh;
use crate::mesh::topology::NONE;
use crate::tuning::{Tunable, tunable};

/// Mean edges, or requested thicknesses. Thinner walls made by a repair count as foil where they exceed
/// `THIN_PART`.
pub(super) const LEAST_WALL: Tunable<f64> = tunable("repair.least_wall", 0.5);

/// Fraction of a component's surface with walls below `LEAST_WALL`. A shell has an inner and an outer side: the
/// fraction is a quarter of the sheet.
const THIN_PART: Tunable<f64> = tunable("repair.thin_part", 0.125);

/// A draft vertex of each offset shell that still exists, by region.
pub(super) fn places(draft: &Draft, walls: &[ShellWall]) -> HashMap<u32, u32> {
    let mut places = HashMap::new();
    if !walls.is_empty() {
        let faces = draft.mesh.faces.iter().zip(&draft.region);
        for (face, region) in faces.filter(|(_, region)| **region != NONE) {
            places.entry(*region).or_insert(face[0]);
        }
    }
    places
}

/// Records the components of the result with offset shells, and which of them have too thin walls. `places` holds a vertex of the
/// result for the region of each shell.
pub(super) fn record(
    result: &Mesh,
    places: &HashMap<u32, u32>,
    params: &RepairParams,
    report: &mut RepairReport,
) -> Result<(), FillError> {
    let walls = std::mem::take(&mut report.walls);
    let known = walls
        .iter()
        .filter_map(|w| Some((w, *places.get(&w.region)?)));
    let known: Vec<(&ShellWall, u32)> = known.collect();
    if known.is_empty() {
        return Ok(());
    }
    let found = Inspection::new(result)?;
    let mut component_of: HashMap<u32, u32> = HashMap::new();
    for f in found.topology.faces() {
        for v in result.faces[f as usize] {
            component_of.insert(v, found.topology.component[f as usize]);
        }
    }
    let mut by_component: BTreeMap<u32, Vec<&ShellWall>> = BTreeMap::new();
    for (wall, vertex) in known {
        if let Some(index) = component_of.get(&vertex) {
            by_component.entry(*index).or_default().push(wall);
        }
    }
    let debris = CheckParams::default().debris;
    let all = components(&found.mesh, &found.topology, debris);
    for (index, walls) in by_component {
        let number = index as usize + 1;
        let component = measured(all[index as usize], &walls);
        let limit = limit(&walls, params);
        let thin: f64 = faces(&walls)
            .filter(|f| f.thickness < limit)
            .map(|f| f.area)
            .sum();
        // With a caller's limit the verdict judges all walls. Debris never makes the verdict negative.
        let is_foil = thin > THIN_PART.get() * component.area && !component.debris;
        if is_foil && params.min_wall.is_none() {
            report.thin_offset_shells.push((number, limit));
        }
        report.offset_shells.push((number, component));
    }
    Ok(())
}

fn faces<'a>(walls: &'a [&ShellWall]) -> impl Iterator<Item = &'a WallFace> {
    walls.iter().flat_map(|w| &w.faces)
}

/// The thickness below which walls count as foil, in mesh units.
fn limit(walls: &[&ShellWall], params: &RepairParams) -> f64 {
    let edge = walls.iter().map(|w| w.edge).fold(f64::INFINITY, f64::min);
    let wanted = params.wall.unwrap_or(f64::INFINITY);
    LEAST_WALL.get() * edge.min(wanted)
}

/// A component with the wall thickness of its offset shells.
fn measured(mut component: Component, walls: &[&ShellWall]) -> Component {
    let area: f64 = faces(walls).map(|f| f.area).sum();
    let sum: f64 = faces(walls).map(|f| f.area * f.thickness).sum();
    let thinnest = faces(walls).min_by(|a, b| a.thickness.total_cmp(&b.thickness));
    component.least_wall = thinnest.map(|f| f.thickness);
    component.thinnest_at = thinnest.map(|f| f.at);
    component.mean_wall = (area > 0.0).then(|| sum / area);
    component
}
