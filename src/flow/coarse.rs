//! Coarse levels for the step's system: functions that are constant along the normal.
//!
//! Smooth movements of the surface are nearly constant along the normal through the band. So the first coarse level
//! interpolates trilinearly at each node's closest point on the surface, on the lattice of twice the voxel; coarser levels
//! follow by plain trilinear interpolation, all matrices by Galerkin products.

use super::band::Band;
use super::system::System;
use crate::grid::{NodeIndex, SparseGrid};
use crate::linalg::{Csr, Multigrid};

/// Levels are added until so few unknowns are left.
const FEW: usize = 400;
/// A W-cycle from so many unknowns on.
const MANY: usize = 100_000;

/// Nodes of one coarse lattice, sorted.
struct Lattice {
    nodes: Vec<NodeIndex>,
}

impl Lattice {
    fn number(&self, n: NodeIndex) -> Option<u32> {
        self.nodes.binary_search(&n).ok().map(|i| i as u32)
    }
}

/// The eight trilinear weights of a point.
fn trilinear(p: [f64; 3]) -> [(NodeIndex, f64); 8] {
    let base = p.map(|x| x.floor());
    std::array::from_fn(|a| {
        let o = [(a >> 2) & 1, (a >> 1) & 1, a & 1];
        let n = std::array::from_fn(|d| base[d] as i32 + o[d] as i32);
        let w = (0..3)
            .map(|d| {
                let t = p[d] - base[d];
                if o[d] == 1 { t } else { 1.0 - t }
            })
            .product();
        (n, w)
    })
}

/// Interpolation of points on a lattice of nodes that `exists` allows; nodes that no point touches do not exist.
fn interpolation(
    points: &[Option<[f64; 3]>],
    exists: impl Fn(NodeIndex) -> bool,
) -> (Csr, Lattice) {
    let mut nodes: Vec<NodeIndex> = points
        .iter()
        .flatten()
        .flat_map(|&p| trilinear(p))
        .filter(|&(_, w)| w > 1e-12)
        .map(|(n, _)| n)
        .collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes.retain(|&n| exists(n));
    let lattice = Lattice { nodes };
    let matrix = Csr::from_rows(points.len(), lattice.nodes.len(), |i, sink| {
        if let Some(p) = points[i] {
            for (n, w) in trilinear(p) {
                if let (true, Some(c)) = (w > 1e-12, lattice.number(n)) {
                    sink(c, w);
                }
            }
        }
    });
    (matrix, lattice)
}

/// The nodes' closest points on the zero set, by central differences; unknowns only.
fn feet(band: &Band, phi: &[f64]) -> Vec<Option<[f64; 3]>> {
    let value = |j: u32, own: f64| phi.get(j as usize).copied().unwrap_or(own);
    (0..phi.len())
        .map(|i| {
            if !band.unknown[i] {
                return None;
            }
            let near = &band.neighbours[i];
            let g: [f64; 3] = std::array::from_fn(|d| {
                let step = [9, 3, 1][d];
                0.5 * (value(near[13 + step], phi[i]) - value(near[13 - step], phi[i]))
            });
            let gg = (g[0] * g[0] + g[1] * g[1] + g[2] * g[2]).max(0.25);
            let x = band.nodes[i];
            Some(std::array::from_fn(|d| {
                f64::from(x[d]) - phi[i] / gg * g[d]
            }))
        })
        .collect()
}

/// The hierarchy for a system; none where it cannot be made (then the diagonal has to do).
pub fn hierarchy(
    grid: &SparseGrid,
    mask: &[bool],
    band: &Band,
    phi: &[f64],
    system: &System,
) -> Option<Multigrid> {
    let points: Vec<Option<[f64; 3]>> = feet(band, phi)
        .into_iter()
        .map(|p| p.map(|p| p.map(|x| 0.5 * x)))
        .collect();
    let free = |n: NodeIndex| grid.slot(n.map(|i| 2 * i)).is_none_or(|s| mask[s]);
    let (first, mut lattice) = interpolation(&points, free);
    if lattice.nodes.is_empty() {
        return None;
    }
    let matrix = system.galerkin(&first);
    let mut coarser = Vec::new();
    let mut scale = 2;
    while lattice.nodes.len() > FEW && coarser.len() < 12 {
        scale *= 2;
        let points: Vec<Option<[f64; 3]>> = lattice
            .nodes
            .iter()
            .map(|n| Some(n.map(|i| 0.5 * f64::from(i))))
            .collect();
        let free = |n: NodeIndex| grid.slot(n.map(|i| scale * i)).is_none_or(|s| mask[s]);
        let (p, next) = interpolation(&points, free);
        if next.nodes.is_empty() || next.nodes.len() >= lattice.nodes.len() {
            break;
        }
        coarser.push(p);
        lattice = next;
    }
    let gamma = if band.unknowns > MANY { 2 } else { 1 };
    Multigrid::new(system, first, matrix, coarser, gamma)
}
