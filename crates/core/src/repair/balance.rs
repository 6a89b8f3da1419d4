//! The balance of edges: along each edge of a closed surface as many faces run one way as the other, also where more than two meet.

use std::collections::BTreeMap;

use crate::mesh::topology::{NONE, end, start};
use crate::mesh::{Mesh, Topology};

/// For each set of components whether more of its faces run one way along some edge than the other. `set` is the set of a component,
/// `runs_up` whether a half-edge runs from the smaller to the larger vertex number, `crowded` the edges with more than two faces.
pub(super) fn open_sets(
    topology: &Topology,
    crowded: &[Vec<u32>],
    mut set: impl FnMut(u32) -> u32,
    runs_up: impl Fn(u32) -> bool,
) -> Vec<bool> {
    let mut open = vec![false; topology.component_faces.len()];
    let component = |h: u32| topology.component[h as usize / 3];
    for h in (0..topology.opposite.len() as u32).filter(|h| component(*h) != NONE) {
        let o = topology.opposite[h as usize];
        if topology.boundary[h as usize] || (o != NONE && runs_up(h) == runs_up(o)) {
            open[set(component(h)) as usize] = true;
        }
    }
    for edge in crowded {
        let mut sums: BTreeMap<u32, i32> = BTreeMap::new();
        for &h in edge {
            *sums.entry(set(component(h))).or_default() += if runs_up(h) { 1 } else { -1 };
        }
        (sums.iter().filter(|(_, sum)| **sum != 0)).for_each(|(set, _)| open[*set as usize] = true);
    }
    open
}

/// Whether a half-edge, in the orientation that the inspection gave the faces, runs from the smaller to the larger vertex number.
pub(super) fn runs_up(mesh: &Mesh, h: u32) -> bool {
    start(mesh, h) < end(mesh, h)
}

/// The same in the orientation of the input.
pub(super) fn ran_up(mesh: &Mesh, topology: &Topology, h: u32) -> bool {
    runs_up(mesh, h) != topology.turned[h as usize / 3]
}
