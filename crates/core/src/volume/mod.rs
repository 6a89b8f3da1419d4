//! The signed distance of a whole mesh on a regular lattice.

mod points;
mod signs;

use std::time::Instant;

use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::grid::Volume;
use crate::mesh::{Mesh, MeshError, Topology, at_least, bounds, length, welded};
use crate::parameters::{OutOfBounds, solve, tables};
use crate::region::VoxelSize;
use crate::spatial::Bvh;
use crate::threads::{CollectIndexed, for_each_chunk};
pub use points::signed_distances;
use signs::Signs;

/// Nodes. Largest volume; its values take about one gigabyte.
pub const MOST_NODES: usize = 1 << 27;

/// Voxels along the longest side of the model for the automatic voxel size.
pub const AUTO_VOXELS: f64 = 128.0;

/// Voxels between the model's bounding box and the outermost nodes.
pub const MARGIN: f64 = 3.0;

/// Settings of [`signed_distance_volume`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct VolumeParams {
    /// Distance of neighbouring nodes in the mesh's units; `Auto` is 1/128 of the longest side of the bounding box.
    pub voxel: VoxelSize,
    /// Distances are clamped to this, which is faster; in the mesh's units, at least one voxel. `None` does not clamp.
    pub band: Option<f64>,
}

impl Default for VolumeParams {
    fn default() -> Self {
        Self {
            voxel: VoxelSize::Auto,
            band: None,
        }
    }
}

impl VolumeParams {
    /// Checks the parameters without a mesh.
    ///
    /// # Errors
    /// If a parameter is out of bounds; names it.
    pub fn check(&self) -> Result<(), OutOfBounds> {
        solve::VOXEL.check(self.voxel.length())?;
        tables::BAND.check(self.band)
    }
}

/// Errors of [`signed_distance_volume`].
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum VolumeError {
    /// The mesh is not valid.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// All faces are degenerate.
    #[error("all faces are degenerate; there is no surface to measure distances from")]
    NoSurface,
    /// A parameter does not suit this mesh.
    #[error("{what}")]
    Parameter {
        /// What is wrong and which values are possible.
        what: String,
    },
    /// A parameter is out of bounds.
    #[error(transparent)]
    Bounds(#[from] OutOfBounds),
    /// The volume would be too large.
    #[error(
        "a voxel of {} makes {} x {} x {} nodes, but at most {MOST_NODES} are possible; the smallest voxel that fits is \
        about {}",
        length(*voxel), dims[0], dims[1], dims[2], at_least(*fits)
    )]
    TooLarge {
        /// The requested voxel size.
        voxel: f64,
        /// The number of nodes along each axis.
        dims: [u64; 3],
        /// The smallest voxel size that fits, to within 1 %.
        fits: f64,
    },
}

/// A volume, with statistics of its computation.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Measured {
    /// The signed distance at each node in the mesh's units; negative inside.
    pub volume: Volume,
    /// Number of nodes whose distance was not clamped.
    pub nodes: usize,
    /// Number of edges with one face only.
    #[doc(hidden)]
    pub open_edges: usize,
    /// The time taken, by step.
    pub seconds: MeasuredSeconds,
}

/// The time taken, by step, in seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct MeasuredSeconds {
    /// Welding vertices and finding edges and components.
    pub topology: f64,
    /// Building the bounding volume hierarchy of the faces.
    pub tree: f64,
    /// Unsigned distances.
    pub distances: f64,
    /// Signs.
    pub signs: f64,
}

/// The signed distance of a mesh on a lattice; negative inside.
///
/// Distances to the triangles are exact up to rounding. A node is inside if the magnitude of the generalized winding
/// number exceeds one half (Jacobson, Kavan and Sorkine-Hornung 2013), so that open meshes have an inside too.
///
/// # Errors
/// When the mesh or the parameters are not valid, or the volume would have more than [`MOST_NODES`] nodes.
pub fn signed_distance_volume(mesh: &Mesh, params: &VolumeParams) -> Result<Volume, VolumeError> {
    Ok(measure_volume(mesh, params)?.volume)
}

/// As [`signed_distance_volume`], with statistics.
///
/// # Errors
/// As [`signed_distance_volume`].
pub fn measure_volume(mesh: &Mesh, params: &VolumeParams) -> Result<Measured, VolumeError> {
    let mut seconds = MeasuredSeconds::default();
    let mut clock = Instant::now();
    let mut lap = || {
        std::mem::replace(&mut clock, Instant::now())
            .elapsed()
            .as_secs_f64()
    };
    params.check()?;
    // Weld vertices and drop degenerate faces, so that the winding number sees no cracks.
    mesh.validate()?;
    let (mut mesh, _) = welded(mesh);
    let topology = Topology::new(&mut mesh);
    if topology.faces().next().is_none() {
        return Err(VolumeError::NoSurface);
    }
    // Lattice around the bounding box, and the hierarchy of the faces.
    let (low, high) = bounds(topology.faces().flat_map(|f| mesh.corners(f)));
    let (voxel, dims) = lattice(high - low, params)?;
    let origin = low - MARGIN * voxel;
    seconds.topology = lap();
    let bvh = Bvh::new(&mesh, topology.faces());
    seconds.tree = lap();
    // Unsigned distances, clamped to the band, in slabs of four layers of nodes.
    let band = params.band.unwrap_or(f64::INFINITY);
    let distances = Distances {
        blocks: Blocks::new(&bvh, origin, voxel, dims, band),
        bvh: &bvh,
        origin,
        voxel,
        dims,
        band,
    };
    let mut values = vec![0.0; dims.iter().product()];
    let nodes = values
        .par_chunks_mut(dims[0] * dims[1] * Blocks::SMALL)
        .enumerate()
        .map(|(i, out)| distances.layers(i * Blocks::SMALL, out))
        .sum();
    seconds.distances = lap();
    // Signs from the winding number, along rows of nodes.
    let signs = Signs::new(&mesh, &topology, &bvh, voxel);
    for_each_chunk(&mut values, dims[0], &|row, out| {
        let (j, k) = (row % dims[1], row / dims[1]);
        let start = origin + DVec3::new(0.0, j as f64, k as f64) * voxel;
        signs.row(start, out);
    });
    seconds.signs = lap();
    let volume = Volume {
        dims,
        origin,
        spacing: DVec3::splat(voxel),
        values,
    };
    Ok(Measured {
        volume,
        nodes,
        open_edges: topology.boundary.iter().filter(|open| **open).count(),
        seconds,
    })
}

/// The voxel size and the number of nodes along each axis.
fn lattice(size: DVec3, params: &VolumeParams) -> Result<(f64, [usize; 3]), VolumeError> {
    let voxel = match params.voxel {
        VoxelSize::Auto => size.max_element() / AUTO_VOXELS,
        VoxelSize::Length(voxel) => voxel,
    };
    let refuse = |what: String| Err(VolumeError::Parameter { what });
    // The voxel must not exceed the model, and the band must be at least a voxel.
    let longest = size.max_element();
    if voxel > longest {
        return refuse(format!(
            "a voxel of {} is larger than the model, whose longest side is {}; the automatic voxel is {}",
            length(voxel),
            length(longest),
            length(longest / AUTO_VOXELS)
        ));
    }
    if let Some(band) = params.band
        && band < voxel
    {
        return refuse(format!(
            "the band must be full, or at least the width of a voxel, which is {voxel}"
        ));
    }
    // Nodes along each axis: the box and a margin on both sides.
    let dims = |voxel: f64| {
        let nodes = (size / voxel).ceil() + 2.0 * MARGIN + 1.0;
        nodes.to_array().map(|n| n as u64)
    };
    let count = |voxel: f64| dims(voxel).iter().map(|n| *n as f64).product::<f64>();
    if count(voxel) <= MOST_NODES as f64 {
        return Ok((voxel, dims(voxel).map(|n| n as usize)));
    }
    // The smallest voxel that fits, to within 1 %.
    let mut fits = voxel;
    while count(fits) > MOST_NODES as f64 {
        fits *= 1.01;
    }
    Err(VolumeError::TooLarge {
        voxel,
        dims: dims(voxel),
        fits,
    })
}

/// Computes unsigned distances at the nodes of a lattice.
struct Distances<'a> {
    bvh: &'a Bvh,
    origin: DVec3,
    voxel: f64,
    dims: [usize; 3],
    band: f64,
    blocks: Blocks,
}

impl Distances<'_> {
    /// Computes the distances on the layers of nodes from `first` on. Returns the number of nodes whose distance is not
    /// clamped.
    ///
    /// Proceeds in blocks, because neighbouring nodes search the same part of the mesh.
    fn layers(&self, first: usize, out: &mut [f64]) -> usize {
        // The value of nodes in blocks beyond the band.
        out.fill(self.band);
        let [nx, ny, _] = self.dims;
        let steps = |n: usize| (0..n).step_by(Blocks::SMALL);
        let mut measured = 0;
        for (j, i) in steps(ny).flat_map(|j| steps(nx).map(move |i| (j, i))) {
            let middle = self.blocks.middle([i, j, first]);
            if middle.is_finite() {
                measured += self.block([i, j, first], middle, out);
            }
        }
        measured
    }

    /// Computes the distances in a block. `middle` is the distance of the block's centre from the surface.
    fn block(&self, [i, j, first]: [usize; 3], middle: f64, out: &mut [f64]) -> usize {
        let [nx, ny, _] = self.dims;
        let half = 0.5 * (Blocks::SMALL - 1) as f64;
        let centre = self.origin
            + DVec3::new(i as f64 + half, j as f64 + half, first as f64 + half) * self.voxel;
        // Nodes closer to the centre than this are beyond the band (triangle inequality).
        let free = middle - self.band - 1e-6 * self.voxel;
        let mut measured = 0;
        let mut previous: Option<DVec3> = None;
        for (k, layer) in out.chunks_mut(nx * ny).enumerate() {
            for j in j..(j + Blocks::SMALL).min(ny) {
                let start =
                    self.origin + DVec3::new(0.0, j as f64, (first + k) as f64) * self.voxel;
                for i in i..(i + Blocks::SMALL).min(nx) {
                    let p = node(start, i, self.voxel);
                    if free > 0.0 && p.distance_squared(centre) < free * free {
                        continue;
                    }
                    // The closest point of the previous node gives an upper bound, up to rounding.
                    let near = previous.map_or(f64::INFINITY, |c| {
                        c.distance(p) * (1.0 + 1e-9) + 1e-6 * self.voxel
                    });
                    let mut closest = self.bvh.closest(p, near.min(self.band));
                    if closest.is_none() && near < self.band {
                        closest = self.bvh.closest(p, self.band);
                    }
                    if let Some(closest) = &closest {
                        layer[j * nx + i] = closest.distance.min(self.band);
                        measured += 1;
                        previous = Some(closest.point);
                    }
                }
            }
        }
        measured
    }
}

fn node(start: DVec3, i: usize, voxel: f64) -> DVec3 {
    start + DVec3::X * (i as f64 * voxel)
}

/// Distances of blocks of nodes from the surface, used to skip blocks beyond the band.
struct Blocks {
    /// Nodes along the edge of a block.
    side: usize,
    dims: [usize; 3],
    /// Distance of each block's centre from the surface; infinite if the whole block is beyond the band. Empty without
    /// a band.
    middles: Vec<f64>,
}

impl Blocks {
    /// Nodes along the edge of a small block.
    const SMALL: usize = 4;

    /// Measures large blocks first, then the small blocks within the large ones that are not beyond the band.
    fn new(bvh: &Bvh, origin: DVec3, voxel: f64, nodes: [usize; 3], band: f64) -> Self {
        let mut blocks = Self {
            side: 1,
            dims: nodes,
            middles: Vec::new(),
        };
        if band.is_infinite() {
            return blocks;
        }
        for side in [4 * Self::SMALL, Self::SMALL] {
            let half = 0.5 * (side - 1) as f64 * voxel;
            // Distance from a block's centre to its corners plus the band, with a tolerance for rounding.
            let reach = band + half * 3f64.sqrt() * (1.0 + 1e-9) + 1e-6 * voxel;
            let dims = nodes.map(|n| n.div_ceil(side));
            let distance = |block: usize| {
                let (i, jk) = (block % dims[0], block / dims[0]);
                let first = [i, jk % dims[1], jk / dims[1]].map(|b| b * side);
                let corner = origin + DVec3::from_array(first.map(|n| n as f64)) * voxel;
                if blocks.middle(first).is_infinite() {
                    return f64::INFINITY;
                }
                let closest = bvh.closest(corner + half, reach);
                closest.map_or(f64::INFINITY, |c| c.distance)
            };
            let count = dims.iter().product::<usize>();
            let middles = (0..count).into_par_iter().map(distance).collect_indexed();
            blocks = Self {
                side,
                dims,
                middles,
            };
        }
        blocks
    }

    /// Distance of the centre of a node's block from the surface; infinite beyond the band, 0 if not measured.
    fn middle(&self, node: [usize; 3]) -> f64 {
        let [i, j, k] = node.map(|n| n / self.side);
        let block = (k * self.dims[1] + j) * self.dims[0] + i;
        self.middles.get(block).copied().unwrap_or(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::signs::WINDING_ERROR;
    use super::*;
    use crate::extract::level_surface;
    use crate::mesh::shapes::{self, cube};
    use crate::spatial::WindingTree;

    fn length(voxel: f64, band: Option<f64>) -> VolumeParams {
        VolumeParams {
            voxel: VoxelSize::Length(voxel),
            band,
        }
    }

    #[test]
    fn distances_are_those_to_the_mesh_and_negative_inside() {
        let mut mesh = shapes::icosphere(3);
        let centre = DVec3::new(1000.0, -3.0, 0.25);
        mesh.positions.iter_mut().for_each(|p| *p += centre);
        let full = signed_distance_volume(&mesh, &length(0.11, None)).unwrap();
        let banded = signed_distance_volume(&mesh, &length(0.11, Some(0.3))).unwrap();
        assert_eq!(full.dims, banded.dims);
        let [nx, ny, _] = full.dims;
        for (i, (value, cut)) in full.values.iter().zip(&banded.values).enumerate() {
            let node = DVec3::new((i % nx) as f64, (i / nx % ny) as f64, (i / nx / ny) as f64);
            let exact = full.position(node).distance(centre) - 1.0;
            // The faces are inside the sphere by up to this distance.
            assert!((value - exact).abs() < 0.02, "{value} {exact}");
            assert!((cut - value.clamp(-0.3, 0.3)).abs() < 1e-12);
        }
    }

    #[test]
    fn a_round_trip_moves_the_surface_by_less_than_half_a_voxel() {
        // The edges of a cube are cut off by less than the diagonal of a voxel.
        for (mesh, voxel, cut) in [
            (shapes::icosphere(3), 0.05, 0.5),
            (cube(), 0.07, 3f64.sqrt()),
        ] {
            let volume = signed_distance_volume(&mesh, &length(voxel, Some(0.3))).unwrap();
            let back = level_surface(&volume, 0.0, false).unwrap();
            for (from, to, most) in [(&back, &mesh, 0.5), (&mesh, &back, cut)] {
                let bvh = Bvh::new(to, 0..to.faces.len() as u32);
                for p in &from.positions {
                    let distance = bvh.closest(*p, f64::INFINITY).unwrap().distance;
                    assert!(distance < most * voxel, "{distance} of {voxel}");
                }
            }
        }
    }

    #[test]
    fn open_and_inverted_meshes_have_an_inside() {
        let mut mesh = shapes::icosphere(3);
        mesh.faces.iter_mut().for_each(|f| f.swap(1, 2));
        let value = |mesh: &Mesh| {
            let volume = signed_distance_volume(mesh, &length(0.2, None)).unwrap();
            let middle = volume.dims.map(|n| n / 2);
            volume.at(middle)
        };
        assert!(value(&mesh) < -0.7);
        let top = |f: &[u32; 3]| f.iter().all(|v| mesh.positions[*v as usize].z > 0.8);
        let mut open = mesh.clone();
        open.faces.retain(|f| !top(f));
        assert!(open.faces.len() < mesh.faces.len() && value(&open) < -0.7);
    }

    #[test]
    fn signs_carried_along_rows_are_those_of_the_winding_number() {
        let mesh = shapes::punch(&shapes::icosphere(3), |p| p.z > 0.7 || p.x > 0.9);
        let volume = signed_distance_volume(&mesh, &length(0.1, None)).unwrap();
        let bvh = Bvh::new(&mesh, 0..mesh.faces.len() as u32);
        let tree = WindingTree::new(&bvh);
        let [nx, ny, _] = volume.dims;
        for (i, value) in volume.values.iter().enumerate() {
            let node = DVec3::new((i % nx) as f64, (i / nx % ny) as f64, (i / nx / ny) as f64);
            let winding = tree.winding_number(&bvh, volume.position(node));
            // The winding number jumps on the surface.
            if (winding - 0.5).abs() > WINDING_ERROR && value.abs() > 1e-9 {
                assert_eq!(*value < 0.0, winding > 0.5, "{node} {winding} {value}");
            }
        }
    }

    #[test]
    fn absurd_sizes_are_refused_with_one_that_fits() {
        let mesh = shapes::icosphere(1);
        let error = signed_distance_volume(&mesh, &length(1e-6, None)).unwrap_err();
        let VolumeError::TooLarge { fits, .. } = error else {
            panic!("{error}")
        };
        let (_, dims) = lattice(DVec3::splat(2.0), &length(fits, None)).unwrap();
        let count: usize = dims.iter().product();
        assert!(count <= MOST_NODES && count > MOST_NODES / 2);
        for wrong in [
            length(0.0, None),
            length(f64::NAN, None),
            length(0.1, Some(0.05)),
        ] {
            let error = signed_distance_volume(&mesh, &wrong).unwrap_err();
            assert!(
                matches!(
                    error,
                    VolumeError::Bounds(_) | VolumeError::Parameter { .. }
                ),
                "{error}"
            );
        }
    }
}
