//! The signed distance of a whole model on a lattice round it.

use std::collections::HashMap;

use glam::DVec3;
use rayon::prelude::*;
use thiserror::Error;

use super::{FillError, validate};
use crate::grid::Volume;
use crate::mesh::{Mesh, Topology, bounds, welded};
use crate::params::VoxelSize;
use crate::spatial::{Bvh, WindingTree};

/// The most nodes that a volume is given: about one gigabyte of values.
pub const MOST_NODES: usize = 1 << 27;

/// Voxels along the longest side of the model where the voxel size is left to isomend.
pub const AUTO_VOXELS: f64 = 128.0;

/// Voxels between the model's bounding box and the volume's border.
pub const MARGIN: f64 = 3.0;

/// Settings of [`signed_distance_volume`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeParams {
    /// Distance of neighbouring nodes, in the mesh's units; `Auto` is 1/128 of the longest side of the bounding box.
    pub voxel: VoxelSize,
    /// Distances beyond this are cut off at it, which is faster; in the mesh's units, at least a voxel. `None` keeps all.
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

/// Why there is no signed distance.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum VolumeError {
    /// The mesh makes no sense.
    #[error(transparent)]
    Mesh(#[from] FillError),
    /// All faces are degenerate.
    #[error("all faces are degenerate; there is no surface to measure distances from")]
    NoSurface,
    /// A parameter makes no sense.
    #[error("{what}")]
    Parameter {
        /// What is wrong and what would be right.
        what: String,
    },
    /// The volume would be too large.
    #[error(
        "a voxel of {voxel} makes {} x {} x {} nodes, more than the {MOST_NODES} there may be; the smallest voxel that \
         fits is about {fits:.4e}",
        dims[0], dims[1], dims[2]
    )]
    TooLarge {
        /// The voxel size asked for.
        voxel: f64,
        /// The number of nodes along each axis.
        dims: [u64; 3],
        /// A voxel size that fits.
        fits: f64,
    },
}

/// The signed distance of a mesh, negative inside.
///
/// Distances are those to the triangles, exact up to rounding. A node is inside where the magnitude of the generalized
/// winding number exceeds one half (Jacobson, Kavan and Sorkine-Hornung 2013), so that open meshes have an inside too.
///
/// # Errors
/// When the mesh or the parameters make no sense, or the volume would have more than [`MOST_NODES`] nodes.
pub fn signed_distance_volume(mesh: &Mesh, params: &VolumeParams) -> Result<Volume, VolumeError> {
    validate(mesh)?;
    let (mut mesh, _) = welded(mesh);
    let topology = Topology::new(&mut mesh);
    if topology.faces().next().is_none() {
        return Err(VolumeError::NoSurface);
    }
    let (low, high) = bounds(topology.faces().flat_map(|f| mesh.corners(f)));
    let (voxel, dims) = lattice(high - low, params)?;
    let origin = low - MARGIN * voxel;
    let bvh = Bvh::new(&mesh, topology.faces());
    let rims = Rims::new(&mesh, &topology);
    let field = Field {
        winding: WindingTree::new(&bvh),
        bvh,
        voxel,
        band: params.band.unwrap_or(f64::INFINITY),
        rims,
    };
    let mut values = vec![0.0; dims.iter().product()];
    values
        .par_chunks_mut(dims[0])
        .enumerate()
        .for_each(|(row, out)| {
            let (j, k) = (row % dims[1], row / dims[1]);
            let start = origin + DVec3::new(0.0, j as f64, k as f64) * voxel;
            field.row(start, out);
        });
    Ok(Volume {
        dims,
        origin,
        spacing: DVec3::splat(voxel),
        values,
    })
}

/// The voxel size and the number of nodes.
fn lattice(size: DVec3, params: &VolumeParams) -> Result<(f64, [usize; 3]), VolumeError> {
    let voxel = match params.voxel {
        VoxelSize::Auto => size.max_element() / AUTO_VOXELS,
        VoxelSize::Length(voxel) => voxel,
    };
    let refuse = |what: String| Err(VolumeError::Parameter { what });
    if !(voxel.is_finite() && voxel > 0.0) {
        return refuse("the voxel size must be a positive length, or `auto`".to_owned());
    }
    if let Some(band) = params.band
        && !(band.is_finite() && band >= voxel)
    {
        return refuse(format!(
            "the band must be at least a voxel wide, which is {voxel}, or full"
        ));
    }
    let dims = |voxel: f64| {
        let nodes = (size / voxel).ceil() + 2.0 * MARGIN + 1.0;
        nodes.to_array().map(|n| n as u64)
    };
    let count = |voxel: f64| dims(voxel).iter().map(|n| *n as f64).product::<f64>();
    if count(voxel) <= MOST_NODES as f64 {
        return Ok((voxel, dims(voxel).map(|n| n as usize)));
    }
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

struct Field {
    bvh: Bvh,
    winding: WindingTree,
    voxel: f64,
    band: f64,
    rims: Rims,
}

impl Field {
    /// The values along a row of nodes.
    fn row(&self, start: DVec3, out: &mut [f64]) {
        let step = self.voxel * (1.0 + 1e-9);
        // Of the node before: its distance, or a lower bound of it, whether it is inside, and by how much the winding
        // number may still change before that does.
        let mut before: Option<(f64, bool, f64)> = None;
        for (i, value) in out.iter_mut().enumerate() {
            let p = start + DVec3::X * (i as f64 * self.voxel);
            // Distances of neighbours differ by a voxel at most.
            let near = before.map_or(f64::INFINITY, |(d, ..)| (d + step) * (1.0 + 1e-9));
            let limit = near.min(self.band);
            let distance = match self.bvh.closest(p, limit) {
                Some(closest) => closest.distance.min(self.band),
                None => limit,
            };
            let change = self.rims.rate(p, step) * step;
            let (inside, slack) = match before {
                // No surface lies between nodes that are together farther from it than from each other.
                Some((d, inside, slack)) if d + distance > step && slack > change => {
                    (inside, slack - change)
                }
                _ => {
                    let winding = self.winding.winding_number(&self.bvh, p).abs();
                    (winding > 0.5, (winding - 0.5).abs() - WINDING_ERROR)
                }
            };
            *value = if inside { -distance } else { distance };
            before = Some((distance, inside, slack));
        }
    }
}

/// How far the winding number may be off, since distant faces are summed up together.
const WINDING_ERROR: f64 = 0.02;

/// The rims of a mesh, in groups, to bound how fast the winding number changes off the surface.
///
/// Its gradient is that of the solid angle of the rims, at most `L / (4 π d²)` at the distance `d` from a rim of length
/// `L` (the law of Biot and Savart).
struct Rims {
    /// Bounding box and length of each group.
    groups: Vec<(DVec3, DVec3, f64)>,
    /// Whether there are edges besides at which the winding number has a source.
    unknown: bool,
}

impl Rims {
    /// The most groups that are told apart.
    const MOST: usize = 48;

    fn new(mesh: &Mesh, topology: &Topology) -> Self {
        let defects = &topology.defects;
        let mut groups: Vec<(DVec3, DVec3, f64)> = Vec::new();
        let mut of_vertex: HashMap<u32, usize> = HashMap::new();
        for h in (0..topology.boundary.len()).filter(|h| topology.boundary[*h]) {
            let face = mesh.faces[h / 3];
            let ends = [face[h % 3], face[(h + 1) % 3]];
            let [a, b] = ends.map(|v| mesh.positions[v as usize]);
            let known = ends.iter().find_map(|v| of_vertex.get(v).copied());
            let group = known.unwrap_or_else(|| {
                groups.push((a, a, 0.0));
                groups.len() - 1
            });
            ends.iter().for_each(|v| {
                of_vertex.insert(*v, group);
            });
            let (low, high, length) = &mut groups[group];
            (*low, *high) = (low.min(a).min(b), high.max(a).max(b));
            *length += a.distance(b);
        }
        Self {
            groups: merged(groups, Self::MOST),
            unknown: defects.non_manifold_edges > 0 || defects.misoriented_edges > 0,
        }
    }

    /// The most that the winding number changes with the distance, within a step of a point.
    fn rate(&self, p: DVec3, step: f64) -> f64 {
        if self.unknown {
            return f64::INFINITY;
        }
        let one = |(low, high, length): &(DVec3, DVec3, f64)| {
            let distance = p.distance(p.clamp(*low, *high)) - step;
            match distance > 0.0 {
                true => length / (4.0 * std::f64::consts::PI * distance * distance),
                false => f64::INFINITY,
            }
        };
        self.groups.iter().map(one).sum()
    }
}

/// Joins groups whose boxes meet, then all, if there are more than so many.
fn merged(groups: Vec<(DVec3, DVec3, f64)>, most: usize) -> Vec<(DVec3, DVec3, f64)> {
    let join = |a: &mut (DVec3, DVec3, f64), b: &(DVec3, DVec3, f64)| {
        *a = (a.0.min(b.0), a.1.max(b.1), a.2 + b.2);
    };
    let mut out: Vec<(DVec3, DVec3, f64)> = Vec::new();
    for group in groups {
        let meets = |o: &(DVec3, DVec3, f64)| o.0.cmple(group.1).all() && group.0.cmple(o.1).all();
        match out.iter().position(meets) {
            Some(other) => join(&mut out[other], &group),
            None if out.len() < most => out.push(group),
            None => join(&mut out[most - 1], &group),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::extract::level_surface;
    use crate::mesh::shapes;

    fn cube() -> Mesh {
        let corner = |i: u32| DVec3::new((i & 1).into(), (i >> 1 & 1).into(), (i >> 2).into());
        let sides = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        let faces = sides
            .iter()
            .flat_map(|s| [[s[0], s[1], s[2]], [s[0], s[2], s[3]]]);
        Mesh::new((0..8).map(corner).collect(), faces.collect())
    }

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
            // Faces lie inside the sphere by as much as this.
            assert!((value - exact).abs() < 0.02, "{value} {exact}");
            assert!((cut - value.clamp(-0.3, 0.3)).abs() < 1e-12);
        }
    }

    #[test]
    fn a_round_trip_moves_the_surface_by_less_than_half_a_voxel() {
        // Corners of a cube are cut off, by less than the diagonal of a voxel.
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
            if (winding - 0.5).abs() > WINDING_ERROR {
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
            assert!(matches!(error, VolumeError::Parameter { .. }), "{error}");
        }
    }
}
