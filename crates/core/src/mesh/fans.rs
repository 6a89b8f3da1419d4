//! Fans: the edge-connected faces around a vertex.

use super::topology::{NONE, Topology, end, start};
use super::{Mesh, VertexFaces};

/// The fans of faces around a vertex, each in rising order, the one with the smallest face number first. Degenerate faces are in
/// none.
///
/// A vertex of a manifold mesh has one fan. Faces are connected where the topology pairs their half-edges, so the faces of a
/// non-manifold edge are not connected across it.
pub fn fans(mesh: &Mesh, topology: &Topology, around: &VertexFaces, vertex: u32) -> Vec<Vec<u32>> {
    let all = around.of(vertex);
    let mut seen = vec![false; all.len()];
    let mut fans = Vec::new();
    for seed in 0..all.len() {
        if topology.component[all[seed] as usize] == NONE
            || std::mem::replace(&mut seen[seed], true)
        {
            continue;
        }
        let mut fan = vec![all[seed]];
        let mut next = 0;
        while let Some(&face) = fan.get(next) {
            next += 1;
            for h in 3 * face..3 * face + 3 {
                let opposite = topology.opposite[h as usize];
                if opposite == NONE || (start(mesh, h) != vertex && end(mesh, h) != vertex) {
                    continue;
                }
                if let Ok(at) = all.binary_search(&(opposite / 3))
                    && !std::mem::replace(&mut seen[at], true)
                {
                    fan.push(opposite / 3);
                }
            }
        }
        fan.sort_unstable();
        fans.push(fan);
    }
    fans
}

/// Whether a vertex has more than one fan; see [`fans`].
pub fn has_several_fans(
    mesh: &Mesh,
    topology: &Topology,
    around: &VertexFaces,
    vertex: u32,
) -> bool {
    let all = around.of(vertex);
    if all.len() > 64 {
        return fans(mesh, topology, around, vertex).len() > 1;
    }
    // One bit for each face: `in_fans` the ones in any fan, `seen` the ones reached from the first, `next` the ones to expand.
    let in_fans = all.iter().rev().fold(0u64, |bits, f| {
        bits << 1 | u64::from(topology.component[*f as usize] != NONE)
    });
    let mut seen = in_fans & in_fans.wrapping_neg();
    let mut next = seen;
    while next != 0 {
        let face = all[next.trailing_zeros() as usize];
        next &= next - 1;
        for h in 3 * face..3 * face + 3 {
            let opposite = topology.opposite[h as usize];
            if opposite == NONE || (start(mesh, h) != vertex && end(mesh, h) != vertex) {
                continue;
            }
            if let Ok(at) = all.binary_search(&(opposite / 3)) {
                next |= 1 << at & !seen;
                seen |= 1 << at;
            }
        }
    }
    in_fans & !seen != 0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::icosphere;

    #[test]
    fn spheres_that_touch_in_a_vertex_have_two_fans_there_and_one_elsewhere() {
        let ball = icosphere(1);
        let count = ball.positions.len() as u32;
        let mut mesh = ball.clone();
        let shift = 2.0 * ball.positions[0];
        mesh.positions
            .extend(ball.positions.iter().map(|p| shift - *p));
        // The second ball uses the first ball's vertex 0.
        let number = |v: u32| if v == 0 { 0 } else { v + count };
        mesh.faces
            .extend(ball.faces.iter().map(|f| [f[0], f[2], f[1]].map(number)));
        let around = VertexFaces::new(&mesh);
        let topology = Topology::new(&mut mesh);
        let at = |v: u32| fans(&mesh, &topology, &around, v);
        assert_eq!(at(0).len(), 2);
        assert_eq!(at(0)[0].len(), around.of(0).len() / 2);
        assert!((1..count).all(|v| at(v).len() == 1));
        let several = |v: u32| has_several_fans(&mesh, &topology, &around, v);
        assert!(several(0) && !(1..count).any(several));
    }
}
