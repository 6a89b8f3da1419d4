//! Bores whose walls are missing: pairs of rims in flat sides, of which one is the other moved along the common normal.

use glam::DVec3;

use super::Inspection;
use crate::fill::{FEW_EDGES, FillParams};
use crate::mesh::{Hole, Mesh};
use crate::stitch::{OpeningRim, band, count_intersecting_faces};
use crate::tuning::{Tunable, tunable};

/// Diameters. The vertices of one rim, moved to the other, are this near to its vertices.
const SAME_OUTLINE: Tunable<f64> = tunable("mend.bores.same_outline", 1e-3);

/// Rims in flat sides. With more of them, which are compared with one another, no bores are sought.
const MOST_RIMS: Tunable<usize> = tunable("mend.bores.most_rims", 2000);

/// The pairs of chosen holes, as indices, that are the two ends of a bore: of several in a row the nearest. Their vertices match, and the
/// wall between them intersects nothing.
pub(super) fn bores(found: &Inspection, params: &FillParams, chosen: &[usize]) -> Vec<Vec<usize>> {
    let is_told = params.apart || params.like.is_some() || !params.crease.is_empty();
    if is_told || !params.closes_straight() {
        return Vec::new();
    }
    let mesh = &found.mesh;
    let may_be = |h: &&usize| {
        let hole = &found.holes[**h];
        let is_asked = params.bridges(&[hole.id]) || params.is_flat(hole.id);
        hole.edges > FEW_EDGES.get() && !is_asked && hole.is_in_flat_side()
    };
    let in_flat_sides: Vec<usize> = chosen.iter().filter(may_be).copied().collect();
    if in_flat_sides.len() > MOST_RIMS.get() {
        return Vec::new();
    }
    let other_end = |h: usize| {
        let hole = &found.holes[h];
        let others = in_flat_sides.iter().copied();
        let ends = others.filter(|&other| hole.is_end_of_bore(&found.holes[other]));
        ends.min_by(|&a, &b| {
            let length = |h: usize| found.holes[h].centre.distance(hole.centre);
            length(a).total_cmp(&length(b))
        })
    };
    let pairs = in_flat_sides.iter().filter_map(|&h| {
        let other = other_end(h).filter(|&other| h < other && other_end(other) == Some(h))?;
        let [a, b] = [h, other].map(|h| &found.holes[h]);
        let wall = matches(mesh, a, b).then(|| band(mesh, [a, b].map(opening)))?;
        Some((vec![h, other], wall?))
    });
    let pairs: Vec<(Vec<usize>, Vec<[u32; 3]>)> = pairs.collect();
    if pairs.is_empty() {
        return Vec::new();
    }
    let walls = pairs.iter().flat_map(|(_, wall)| wall);
    let with_walls = Mesh::new(
        mesh.positions.clone(),
        mesh.faces.iter().chain(walls).copied().collect(),
    );
    let counts: Vec<usize> = pairs.iter().map(|(_, wall)| wall.len()).collect();
    let crossing = count_intersecting_faces(&with_walls, mesh.faces.len(), &counts);
    let free = pairs.into_iter().zip(crossing).filter(|(_, n)| *n == 0);
    free.map(|((pair, _), _)| pair).collect()
}

fn opening(hole: &Hole) -> OpeningRim<'_> {
    OpeningRim {
        rim: &hole.rim,
        conormals: &hole.conormals,
    }
}

/// Whether one rim, moved by the distance of the rims along the normal, has the same vertices as the other.
fn matches(mesh: &Mesh, a: &Hole, b: &Hole) -> bool {
    let along = (b.centre - a.centre).project_onto_normalized(a.normal);
    let at =
        |h: &Hole| -> Vec<DVec3> { h.rim.iter().map(|&v| mesh.positions[v as usize]).collect() };
    // The rims run in opposite directions.
    let (first, mut second) = (at(a), at(b));
    second.reverse();
    let count = first.len();
    let Some(&start) = first.first() else {
        return false;
    };
    let away = |i: usize| second[i].distance_squared(start + along);
    let shift = (0..second.len()).min_by(|&i, &j| away(i).total_cmp(&away(j)));
    let off = |shift: usize| {
        let pairs = (0..count).map(|i| (first[i] + along).distance(second[(i + shift) % count]));
        pairs.fold(0.0, f64::max)
    };
    count == second.len() && shift.is_some_and(|s| off(s) < SAME_OUTLINE.get() * a.diameter)
}
