//! Intersection count of written patches: with rounded positions, in the mesh that contains them.

use rayon::prelude::*;

use crate::mesh::{Mesh, Part, welded};
use crate::spatial::{Bounds, BoxTree, intersecting};

/// For each patch of a mesh, the number of its faces that intersect another face of the mesh.
///
/// The faces of the patches, `patches[i]` each, follow the first `kept` faces. Vertices at the same position count as one.
/// Decided exactly in the positions of the mesh; faces that share a vertex or an edge intersect if they have further common
/// points, and touching counts.
///
/// # Panics
/// If the mesh has fewer faces than that, or a face has an invalid vertex index.
pub fn count_intersecting_faces(mesh: &Mesh, kept: usize, patches: &[usize]) -> Vec<usize> {
    let new: usize = patches.iter().sum();
    let bounds = |f: &[u32; 3]| Bounds::of(f.map(|v| mesh.positions[v as usize]));
    let fresh = &mesh.faces[kept..kept + new];
    let boxes: Vec<Bounds> = fresh.iter().map(bounds).collect();
    let tree = BoxTree::new(&boxes);
    let mut faces: Vec<u32> = (kept as u32..(kept + new) as u32).collect();
    let near = |f: &u32| {
        let around = bounds(&mesh.faces[*f as usize]);
        tree.find(&around, |_| true).is_some()
    };
    faces.par_extend((0..kept as u32).into_par_iter().filter(near));
    let part = welded(&Part::new(mesh, &faces, std::iter::empty()).mesh).0;
    let mut counts = vec![0; patches.len()];
    let ends: Vec<usize> = patches
        .iter()
        .scan(0, |end, n| {
            *end += n;
            Some(*end)
        })
        .collect();
    for (face, _) in intersecting(&part.positions, &part.faces, new) {
        counts[ends.partition_point(|&end| end <= face as usize)] += 1;
    }
    counts
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn only_patches_that_intersect_are_counted_and_coincident_vertices_are_one() {
        let p = DVec3::new;
        // A face; an adjacent patch with its own vertices; a patch that intersects the first face.
        let positions = vec![
            p(0.0, 0.0, 0.0),
            p(1.0, 0.0, 0.0),
            p(0.0, 1.0, 0.0),
            p(1.0, 0.0, 0.0),
            p(1.0, 1.0, 0.0),
            p(0.0, 1.0, 0.0),
            p(0.2, 0.2, -1.0),
            p(0.3, 0.2, -1.0),
            p(0.2, 0.2, 1.0),
            p(9.0, 9.0, 9.0),
        ];
        let mesh = Mesh::new(positions, vec![[0, 1, 2], [3, 4, 5], [6, 7, 8]]);
        assert_eq!(count_intersecting_faces(&mesh, 1, &[1, 1]), [0, 1]);
        assert_eq!(count_intersecting_faces(&mesh, 1, &[1, 0, 1]), [0, 0, 1]);
        assert_eq!(count_intersecting_faces(&mesh, 3, &[]), [0; 0]);
    }

    #[test]
    fn a_patch_that_rounding_pushes_through_another_face_is_found() {
        // Two sheets 1e-9 apart at height 1: rounded to 32 bits they coincide.
        let sheet = |z: f64| [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(|[x, y]| DVec3::new(x, y, z));
        let mut mesh = Mesh::new(
            [
                sheet(1.0),
                sheet(1.0 + 1e-9).map(|q| q + DVec3::new(0.1, 0.1, 0.0)),
            ]
            .concat(),
            vec![[0, 1, 2], [3, 4, 5]],
        );
        assert_eq!(count_intersecting_faces(&mesh, 1, &[1]), [0]);
        for q in &mut mesh.positions {
            *q = q.as_vec3().as_dvec3();
        }
        assert_eq!(count_intersecting_faces(&mesh, 1, &[1]), [1]);
    }
}
