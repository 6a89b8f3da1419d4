//! The level surface of a dense volume.

use std::collections::HashMap;

use glam::DVec3;
use rayon::prelude::*;
use thiserror::Error;

use super::dense::{self, Nodes};
use crate::grid::Volume;
use crate::mesh::Mesh;

/// Errors of [`level_surface`].
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum VolumeSurfaceError {
    /// All values are on one side of the level.
    #[error("all values are on one side of the level {level}: they range from {low} to {high}")]
    NoSurface {
        /// The level.
        level: f64,
        /// The smallest value.
        low: f64,
        /// The largest value.
        high: f64,
    },
    /// A value is infinite or not a number.
    #[error("the value of node {node:?} is {value}; replace it by a finite number first")]
    NotFinite {
        /// The node.
        node: [usize; 3],
        /// Its value.
        value: f64,
    },
    /// The lattice has too few or too many nodes along an axis.
    #[error(
        "the volume has {0:?} nodes, where at least 2 and at most 2147483645 are needed along each axis"
    )]
    Dims([usize; 3]),
}

/// The surface where a volume has the given level, in world units, by marching cubes (Lorensen and Cline 1987). Values
/// below the level are inside.
///
/// The surface ends at the outermost nodes. With `close` it is closed there by flat caps, as if all space beyond were
/// outside.
///
/// # Errors
/// When there is no surface, a value is not finite, or an axis has fewer than two nodes or too many.
pub fn level_surface(volume: &Volume, level: f64, close: bool) -> Result<Mesh, VolumeSurfaceError> {
    let dims = volume.dims;
    if dims.iter().any(|n| *n < 2 || *n > i32::MAX as usize - 2) {
        return Err(VolumeSurfaceError::Dims(dims));
    }
    // With `close`, a layer of outside nodes surrounds the volume.
    let [low, high] = match close {
        true => volume.range(),
        false => [0.0; 2],
    };
    // Far above all values, so that the caps are at the outermost nodes.
    let beyond = ((high - level).abs().max((low - level).abs())).max(f64::MIN_POSITIVE) * 1e9;
    let margin = usize::from(close);
    let [nx, ny, nz] = dims.map(|n| n + 2 * margin);
    // Writes the nodes of one z plane as values relative to the level; false if one is not finite.
    let plane = |k: usize, out: &mut [f64]| {
        if close {
            out.fill(beyond);
        }
        if k < margin || k >= nz - margin {
            return true;
        }
        let mut sound = true;
        let inner = &volume.values[(k - margin) * dims[0] * dims[1]..][..dims[0] * dims[1]];
        let rows = out.chunks_exact_mut(nx);
        for (out, row) in rows.skip(margin).zip(inner.chunks_exact(dims[0])) {
            for (out, value) in out[margin..].iter_mut().zip(row) {
                *out = value - level;
                sound &= value.is_finite();
            }
        }
        sound
    };
    // Vertices are in lattice coordinates, with the first node of the volume as origin.
    let nodes = Nodes {
        dims: [nx, ny, nz],
        shift: -(margin as i32),
        plane: &plane,
    };
    let Some((positions, faces)) = dense::surface(&nodes) else {
        return Err(not_finite(volume));
    };
    if faces.is_empty() {
        let [low, high] = volume.range();
        return Err(VolumeSurfaceError::NoSurface { level, low, high });
    }
    // Move vertices in the added layer onto the outermost nodes, then convert lattice to world coordinates.
    let last = DVec3::from_array(dims.map(|n| (n - 1) as f64));
    let (mut positions, faces) = match close {
        true => clamped(positions, faces, last),
        false => (positions, faces),
    };
    positions
        .par_iter_mut()
        .for_each(|p| *p = volume.position(*p));
    Ok(Mesh::new(positions, faces))
}

/// Moves the vertices beyond the outermost nodes onto them. At edges and corners of the box several vertices move onto the same
/// node: they become one, and the faces between them vanish.
fn clamped(
    positions: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
    last: DVec3,
) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut at_node: HashMap<[u64; 3], u32> = HashMap::new();
    let mut moved = Vec::with_capacity(positions.len());
    let mut number = Vec::with_capacity(positions.len());
    for p in positions {
        let inside = p.clamp(DVec3::ZERO, last);
        let new = moved.len() as u32;
        let own = match inside == p {
            true => new,
            // Zero may have either sign.
            false => *at_node
                .entry((inside + 0.0).to_array().map(f64::to_bits))
                .or_insert(new),
        };
        if own == new {
            moved.push(inside);
        }
        number.push(own);
    }
    let renumbered = faces.into_iter().map(|f| f.map(|v| number[v as usize]));
    let is_proper = |[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
    (moved, renumbered.filter(is_proper).collect())
}

/// The error for the first value that is not finite.
fn not_finite(volume: &Volume) -> VolumeSurfaceError {
    let dims = volume.dims;
    let wrong = volume.values.iter().position(|v| !v.is_finite());
    let at = wrong.unwrap_or_default();
    let node = [at % dims[0], at / dims[0] % dims[1], at / dims[0] / dims[1]];
    let value = volume.values[at];
    VolumeSurfaceError::NotFinite { node, value }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn volume(n: usize, f: impl Fn(DVec3) -> f64) -> Volume {
        let mut out = Volume {
            dims: [n, n + 1, n + 2],
            origin: DVec3::new(-1.0, 5.0, 1000.0),
            spacing: DVec3::new(0.1, 0.2, 0.05),
            values: Vec::new(),
        };
        for k in 0..n + 2 {
            for j in 0..=n {
                for i in 0..n {
                    let p = out.position(DVec3::new(i as f64, j as f64, k as f64));
                    out.values.push(f(p));
                }
            }
        }
        out
    }

    /// Number of edges that are not shared by two faces in opposite directions.
    fn open_edges(mesh: &Mesh) -> usize {
        let mut edges = std::collections::HashMap::new();
        for f in &mesh.faces {
            for k in 0..3 {
                *edges.entry((f[k], f[(k + 1) % 3])).or_insert(0) += 1;
            }
        }
        let lone = |(&(a, b), n): (&(u32, u32), &i32)| *n != 1 || edges.get(&(b, a)) != Some(&1);
        edges.iter().filter(|e| lone(*e)).count()
    }

    fn signed_volume(mesh: &Mesh) -> f64 {
        let origin = mesh.positions[0];
        let part = |f: &[u32; 3]| {
            let [a, b, c] = f.map(|v| mesh.positions[v as usize] - origin);
            a.dot(b.cross(c)) / 6.0
        };
        mesh.faces.iter().map(part).sum()
    }

    #[test]
    fn a_plane_is_at_its_level_and_ends_at_the_outermost_nodes() {
        let field = volume(12, |p| p.x + 0.3 * p.y);
        for level in [1.5, 2.125] {
            let mesh = level_surface(&field, level, false).unwrap();
            let off = |p: &DVec3| (p.x + 0.3 * p.y - level).abs();
            assert!(mesh.positions.iter().all(|p| off(p) < 1e-5));
            assert!(open_edges(&mesh) > 0);
        }
    }

    #[test]
    fn caps_close_a_surface_exactly_at_the_outermost_nodes() {
        let field = volume(12, |p| p.x + 0.3 * p.y - 2.0);
        let mesh = level_surface(&field, 0.0, true).unwrap();
        assert_eq!(open_edges(&mesh), 0);
        // Below the plane, within the box.
        let (low, size) = (field.origin, field.spacing * DVec3::new(11.0, 12.0, 13.0));
        let steps = 2000;
        let area: f64 = (0..steps)
            .map(|i| low.y + size.y * (f64::from(i) + 0.5) / f64::from(steps))
            .map(|y| (2.0 - 0.3 * y - low.x).clamp(0.0, size.x) * size.y / f64::from(steps))
            .sum();
        let wanted = area * size.z;
        assert!((signed_volume(&mesh) / wanted - 1.0).abs() < 1e-3);
        let high = low + size;
        assert!(
            mesh.positions
                .iter()
                .all(|p| p.cmpge(low).all() && p.cmple(high).all())
        );
    }

    #[test]
    fn caps_have_no_degenerate_faces_where_the_solid_meets_edges_and_corners_of_the_box() {
        let dot = |p: DVec3, n: [f64; 3]| p.dot(DVec3::from_array(n));
        for (name, normal, level) in [
            ("an edge", [1.0, 0.3, 0.0], 2.0),
            ("corners", [1.0, 0.3, 0.01], 13.0),
            ("everything", [1.0, 0.0, 0.0], 1e3),
        ] {
            let mesh = level_surface(&volume(9, |p| dot(p, normal)), level, true).unwrap();
            assert_eq!(open_edges(&mesh), 0, "{name}");
            let area = |f: &[u32; 3]| {
                let [a, b, c] = f.map(|v| mesh.positions[v as usize]);
                (b - a).cross(c - a).length()
            };
            assert!(mesh.faces.iter().all(|f| area(f) > 0.0), "{name}");
            let used: std::collections::HashSet<u32> =
                mesh.faces.iter().flatten().copied().collect();
            assert_eq!(used.len(), mesh.positions.len(), "{name}");
        }
    }

    #[test]
    fn what_has_no_surface_is_refused() {
        let field = volume(4, |p| p.x);
        let error = level_surface(&field, 9.0, false).unwrap_err();
        assert!(error.to_string().contains("level 9"), "{error}");
        let mut hurt = field.clone();
        hurt.values[4] = f64::NAN;
        let error = level_surface(&hurt, 0.0, false).unwrap_err().to_string();
        assert!(error.contains("[0, 1, 0]"), "{error}");
        hurt.dims = [4, 30, 1];
        assert!(matches!(
            level_surface(&hurt, 0.0, true),
            Err(VolumeSurfaceError::Dims(_))
        ));
        // Everything is inside: only the caps.
        let block = level_surface(&field, 9.0, true).unwrap();
        assert_eq!(open_edges(&block), 0);
    }
}
