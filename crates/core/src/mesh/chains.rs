//! Open boundary chains: boundary chains that do not close, and the reason.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::topology::{NONE, Topology, end, start};
use super::{Mesh, VertexFaces};

/// Why a boundary chain does not close.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum ChainReason {
    /// An edge at one of its ends has more than two faces, for example because faces are duplicated.
    NonManifold,
    /// Faces at one of its ends have opposite orientations that cannot be made consistent: the surface is one-sided there, like a
    /// Möbius band or a Klein bottle.
    OneSided,
}

impl ChainReason {
    /// The reason in words, for reports.
    pub fn text(self) -> &'static str {
        match self {
            Self::NonManifold => "it ends where an edge has more than two faces",
            Self::OneSided => {
                "the surface is one-sided there: its faces cannot be oriented consistently"
            }
        }
    }
}

/// A part of the boundary that does not return to any of its vertices and therefore bounds no hole.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct OpenChain {
    /// Number of edges.
    pub edges: usize,
    /// Length in the mesh's units.
    pub length: f64,
    /// Positions of its two ends.
    pub ends: [DVec3; 2],
    /// Why it does not close.
    pub reason: ChainReason,
}

/// Describes chains of boundary half-edges, each in the direction opposite to the mesh's.
pub(super) fn describe_chains(
    mesh: &Mesh,
    topology: &Topology,
    chains: &[Vec<u32>],
) -> Vec<OpenChain> {
    if chains.is_empty() {
        return Vec::new();
    }
    let around = VertexFaces::new(mesh);
    let is_non_manifold = |v: u32| {
        around.of(v).iter().any(|&f| {
            let half_edges = (0..3).map(|k| 3 * f + k);
            topology.component[f as usize] != NONE
                && half_edges
                    .filter(|&h| start(mesh, h) == v || end(mesh, h) == v)
                    .any(|h| {
                        topology.opposite[h as usize] == NONE && !topology.boundary[h as usize]
                    })
        })
    };
    let describe = |chain: &Vec<u32>| {
        let at = |v: u32| mesh.positions[v as usize];
        let (first, last) = (end(mesh, *chain.first()?), start(mesh, *chain.last()?));
        Some(OpenChain {
            edges: chain.len(),
            length: chain
                .iter()
                .map(|&h| at(start(mesh, h)).distance(at(end(mesh, h))))
                .sum(),
            ends: [at(first), at(last)],
            reason: if is_non_manifold(first) || is_non_manifold(last) {
                ChainReason::NonManifold
            } else {
                ChainReason::OneSided
            },
        })
    };
    chains.iter().filter_map(describe).collect()
}
