//! Components and handles of a mesh, which a union of a noisy surface with itself adds to.

use crate::mend::Inspection;
use crate::mesh::topology::NONE;

/// The number of components and of their handles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Genus {
    components: usize,
    handles: usize,
}

impl Genus {
    /// Counts handles by Euler's formula, with holes closed. Exact on manifolds; vertices at which surfaces meet count as handles.
    pub(super) fn of(found: &Inspection) -> Self {
        let topology = &found.topology;
        let mut is_used = vec![false; found.mesh.positions.len()];
        let (mut faces, mut halves) = (0, 0);
        for f in topology.faces() {
            faces += 1;
            for v in found.mesh.faces[f as usize] {
                is_used[v as usize] = true;
            }
            let single = (3 * f..3 * f + 3).filter(|h| topology.opposite[*h as usize] == NONE);
            halves += 3 + single.count();
        }
        let components = topology.component_faces.len();
        let vertices = is_used.iter().filter(|used| **used).count();
        let loops = found.holes.len() + found.open_chains.len();
        let handles = (2 * components + halves / 2).saturating_sub(vertices + faces + loops) / 2;
        Self {
            components,
            handles,
        }
    }

    /// How many components and handles there are beyond an earlier state's.
    pub(super) fn beyond(self, before: Self) -> usize {
        self.components.saturating_sub(before.components)
            + self.handles.saturating_sub(before.handles)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;
    use crate::mesh::shapes::icosphere;
    use glam::DVec3;

    fn of(mesh: &Mesh) -> Genus {
        Genus::of(&Inspection::new(mesh).expect("sound"))
    }

    /// A ring of `n` by `n` squares, each two triangles.
    fn ring(n: u32) -> Mesh {
        let angle = |i: u32| std::f64::consts::TAU * f64::from(i) / f64::from(n);
        let at = |i: u32| {
            let (u, v) = (angle(i / n), angle(i % n));
            let across = 1.0 + 0.3 * v.cos();
            DVec3::new(across * u.cos(), across * u.sin(), 0.3 * v.sin())
        };
        let faces = (0..n * n).flat_map(|i| {
            let (u, v) = (i / n, i % n);
            let corner = |u: u32, v: u32| u % n * n + v % n;
            let [a, b, c, d] = [
                corner(u, v),
                corner(u + 1, v),
                corner(u + 1, v + 1),
                corner(u, v + 1),
            ];
            [[a, b, c], [a, c, d]]
        });
        Mesh::new((0..n * n).map(at).collect(), faces.collect())
    }

    #[test]
    fn handles_are_counted_with_holes_closed() {
        let sphere = of(&icosphere(2));
        assert_eq!(
            sphere,
            Genus {
                components: 1,
                handles: 0
            }
        );
        let mut ring = ring(12);
        let whole = of(&ring);
        assert_eq!(
            whole,
            Genus {
                components: 1,
                handles: 1
            }
        );
        assert_eq!([whole.beyond(sphere), sphere.beyond(whole)], [1, 0]);
        ring.faces.drain(..2);
        assert_eq!(of(&ring), whole);
    }
}
