//! Marching cubes over all cells of a dense box, in parallel slabs.
//!
//! The result is bitwise equal to [`marching_cubes`](super::marching_cubes) over the cells in the order of the nodes.

use glam::DVec3;
use rayon::prelude::*;

use super::table::{CORNER, EDGE_AXIS, EDGE_NODE};
use super::{Builder, EdgeNumbers, IsoSurface};

/// Layers of cells in a slab. The result does not depend on it.
const LAYERS: usize = 16;

/// A dense box of nodes; x varies fastest.
pub(super) struct Nodes<'a, F> {
    /// Nodes along each axis, at least two.
    pub dims: [usize; 3],
    /// Offset from a node's index to its lattice coordinates.
    pub shift: i32,
    /// Writes the node values of a plane of constant z. If it returns false, the extraction stops.
    pub plane: &'a F,
}

/// Vertices in lattice coordinates, and faces; `None` if [`Nodes::plane`] stopped.
pub(super) fn surface<F>(nodes: &Nodes<F>) -> Option<(Vec<DVec3>, Vec<[u32; 3]>)>
where
    F: Fn(usize, &mut [f64]) -> bool + Sync,
{
    let layers = nodes.dims[2] - 1;
    let planes = || [0; 2].map(|_| Plane::new(nodes.dims[0] * nodes.dims[1]));
    let slabs: Option<Vec<Slab>> = (0..layers.div_ceil(LAYERS))
        .into_par_iter()
        .map_init(planes, |planes, s| {
            nodes.slab(planes, s * LAYERS, layers.min((s + 1) * LAYERS))
        })
        .collect();
    Some(join(&slabs?, nodes))
}

/// The surface of one slab, with its own vertex numbers.
struct Slab {
    surface: IsoSurface,
    /// Lattice z coordinate of the lowest plane.
    bottom: i32,
    /// The vertices on the x and y edges of the highest plane.
    top: [Vec<u32>; 2],
}

impl<F: Fn(usize, &mut [f64]) -> bool + Sync> Nodes<'_, F> {
    fn slab(&self, planes: &mut [Plane; 2], first: usize, end: usize) -> Option<Slab> {
        let [nx, ny, _] = self.dims;
        let mut codes = vec![0u8; nx];
        let mut builder = Builder {
            surface: IsoSurface::default(),
            numbers: Layer::new(nx, ny),
        };
        planes[1].load(first, self.plane).then_some(())?;
        for k in first..end {
            planes.swap(0, 1);
            planes[1].load(k + 1, self.plane).then_some(())?;
            builder.numbers.advance(k > first);
            for j in 0..ny - 1 {
                let row = |p: usize, j: usize| &planes[p].inside[j * nx..][..nx];
                let rows = [row(0, j), row(0, j + 1), row(1, j), row(1, j + 1)];
                for (i, code) in codes.iter_mut().enumerate() {
                    *code = rows[0][i] | rows[1][i] << 2 | rows[2][i] << 4 | rows[3][i] << 6;
                }
                for i in 0..nx - 1 {
                    let case = codes[i] | codes[i + 1] << 1;
                    if case != 0 && case != 255 {
                        let corner = CORNER.map(|[x, y, z]| {
                            planes[z as usize].values[(j + y as usize) * nx + i + x as usize]
                        });
                        builder.numbers.at(i, j);
                        let cell = [i, j, k].map(|n| n as i32 + self.shift);
                        builder.cell(cell, &corner, case);
                    }
                }
            }
        }
        Some(Slab {
            surface: builder.surface,
            bottom: first as i32 + self.shift,
            top: std::mem::take(&mut builder.numbers.planes[1]),
        })
    }
}

/// The values of a plane of nodes, and 1 for each negative value.
struct Plane {
    values: Vec<f64>,
    inside: Vec<u8>,
}

impl Plane {
    fn new(nodes: usize) -> Self {
        Self {
            values: vec![0.0; nodes],
            inside: vec![0; nodes],
        }
    }

    fn load(&mut self, k: usize, plane: &impl Fn(usize, &mut [f64]) -> bool) -> bool {
        let sound = plane(k, &mut self.values);
        for (inside, value) in self.inside.iter_mut().zip(&self.values) {
            *inside = u8::from(*value < 0.0);
        }
        sound
    }
}

/// The vertex numbers on the edges of one layer of cells, visited in order.
///
/// Old numbers are not cleared: the visited neighbours of a cell tell which of its edges already have a vertex.
#[derive(Default)]
struct Layer {
    nx: usize,
    /// Vertices on x and y edges, in the lower and the upper plane.
    planes: [[Vec<u32>; 2]; 2],
    /// Vertices on z edges.
    upright: Vec<u32>,
    /// Slot of the cell's lowest corner, and a bit for each axis along which the preceding cell exists.
    slot: usize,
    behind: u8,
    later: bool,
}

impl Layer {
    fn new(nx: usize, ny: usize) -> Self {
        let none = || vec![0; nx * ny];
        Self {
            nx,
            planes: [[none(), none()], [none(), none()]],
            upright: none(),
            ..Self::default()
        }
    }

    /// Moves up to the next layer. `later` is false for the first layer.
    fn advance(&mut self, later: bool) {
        self.planes.swap(0, 1);
        self.later = later;
    }

    fn at(&mut self, i: usize, j: usize) {
        self.slot = j * self.nx + i;
        self.behind = u8::from(i > 0) | u8::from(j > 0) << 1 | u8::from(self.later) << 2;
    }
}

impl EdgeNumbers for Layer {
    #[inline]
    fn number(&mut self, _cell: [i32; 3], edge: usize, fresh: u32) -> u32 {
        let (axis, low) = (EDGE_AXIS[edge], EDGE_NODE[edge]);
        let slot = self.slot + usize::from(low & 1) + usize::from(low >> 1 & 1) * self.nx;
        let number = match axis {
            2 => &mut self.upright[slot],
            _ => &mut self.planes[usize::from(low >> 2)][usize::from(axis)][slot],
        };
        if self.behind & !low & !(1 << axis) == 0 {
            *number = fresh;
        }
        *number
    }
}

/// Joins slabs. A vertex in the lowest plane of a slab is the one in the highest plane of the slab below.
fn join<F>(slabs: &[Slab], nodes: &Nodes<F>) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut positions = Vec::with_capacity(slabs.iter().map(|s| s.surface.positions.len()).sum());
    let mut numbers: Vec<Vec<u32>> = Vec::with_capacity(slabs.len());
    for (s, slab) in slabs.iter().enumerate() {
        // Number all vertices; those in the lowest plane exist already.
        let IsoSurface {
            positions: own,
            edges,
            ..
        } = &slab.surface;
        let number = |(p, (node, axis)): (&DVec3, &([i32; 3], u8))| {
            if s > 0 && node[2] == slab.bottom && *axis < 2 {
                let [i, j] = [0, 1].map(|a| (node[a] - nodes.shift) as usize);
                let below = slabs[s - 1].top[usize::from(*axis)][j * nodes.dims[0] + i];
                return numbers[s - 1][below as usize];
            }
            positions.push(*p);
            positions.len() as u32 - 1
        };
        let all = own.iter().zip(edges).map(number).collect();
        numbers.push(all);
    }
    // Renumber the faces of all slabs in parallel.
    let mut faces = vec![[0; 3]; slabs.iter().map(|s| s.surface.faces.len()).sum()];
    let mut rest = faces.as_mut_slice();
    let mut work = Vec::new();
    for (slab, numbers) in slabs.iter().zip(&numbers) {
        let (mine, others) = rest.split_at_mut(slab.surface.faces.len());
        work.push((mine, &slab.surface.faces, numbers));
        rest = others;
    }
    work.into_par_iter().for_each(|(out, faces, numbers)| {
        for (out, face) in out.iter_mut().zip(faces) {
            *out = face.map(|v| numbers[v as usize]);
        }
    });
    (positions, faces)
}
