//! Continues the paint of a slicer on patches: each new face is painted as the face of the file that is nearest over shared edges.

use std::collections::VecDeque;

use crate::io::{BESIDE, Format};
use isomend_core::mesh::attributes::NONE;
use isomend_core::mesh::{Attributes, Bodies, FaceOrigin, Model, weld_map, weld_map_of_bodies};

/// Names for each new face the face of the file whose paint it gets, and notes how many have none. The first `kept` faces are not new.
pub(super) fn continue_paint(model: &mut Model, kept: usize) {
    if model.attributes.file_faces.is_none() {
        return;
    }
    // Faces are beside each other also where the file has the vertices of an edge several times.
    let weld = match Bodies::new(&model.mesh, &model.attributes) {
        None => weld_map(&model.mesh),
        Some(bodies) => weld_map_of_bodies(&model.mesh, &bodies),
    };
    let faces = model.mesh.faces.iter();
    let faces: Vec<[u32; 3]> = faces.map(|face| face.map(|v| weld[v as usize])).collect();
    let Some(origins) = &mut model.attributes.file_faces else {
        return;
    };
    // The edges of new faces: lower vertex, higher vertex, and the face as counted from the first new one.
    let mut edges: Vec<([u32; 2], usize)> = Vec::new();
    for (new, face) in faces.iter().skip(kept).enumerate() {
        edges.extend(edges_of(face).map(|edge| (edge, new)));
    }
    edges.sort_unstable();
    let beside = |edge: [u32; 2]| {
        let first = edges.partition_point(|(other, _)| *other < edge);
        let same = edges[first..].iter();
        same.take_while(move |(other, _)| *other == edge)
            .map(|(_, new)| *new)
    };
    // Faces of the file first, in their order; then over the patch, one ring of faces after the other.
    let mut source = vec![NONE; faces.len().saturating_sub(kept)];
    let mut queue = VecDeque::new();
    for (old, face) in faces.iter().take(kept).enumerate() {
        let of_file = origins[old].face;
        for new in edges_of(face).into_iter().flat_map(beside) {
            if source[new] == NONE && of_file != NONE {
                source[new] = of_file;
                queue.push_back(new);
            }
        }
    }
    while let Some(new) = queue.pop_front() {
        for next in edges_of(&faces[kept + new]).into_iter().flat_map(beside) {
            if source[next] == NONE {
                source[next] = source[new];
                queue.push_back(next);
            }
        }
    }
    let without = source.iter().filter(|face| **face == NONE).count();
    if without > 0 {
        model.notes.push(format!(
            "faces of patches without paint, since no face of the file is beside them: {without}"
        ));
    }
    for (origin, face) in origins[kept..].iter_mut().zip(source) {
        *origin = FaceOrigin {
            face,
            corners: BESIDE,
        };
    }
}

/// A remark if paint is not continued, since the format has none or the mesh comes from another.
pub(super) fn paint_note(format: Format, attributes: &Attributes) -> Option<String> {
    let has_none = format != Format::ThreeMf || attributes.file_faces.is_none();
    let what = "paint is continued on patches only where a 3MF file is read and written";
    has_none.then(|| what.to_owned())
}

fn edges_of([a, b, c]: &[u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]].map(|[p, q]| [*p.min(q), *p.max(q)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use isomend_core::mesh::Mesh;

    #[test]
    fn new_faces_are_painted_as_the_nearest_face_over_edges() {
        // A strip of two old faces and three new ones between them, and a new one by itself. The last two vertices are copies.
        let faces = vec![
            [0, 1, 2],
            [4, 5, 6],
            [11, 10, 3],
            [2, 3, 4],
            [4, 3, 5],
            [7, 8, 9],
        ];
        let places = (0..10).chain([1, 2]);
        let positions = places.map(|v| DVec3::splat(f64::from(v))).collect();
        let mut origins = vec![FaceOrigin::NEW; 6];
        origins[0] = FaceOrigin::same(7);
        origins[1] = FaceOrigin::same(9);
        let mut model = Model {
            mesh: Mesh::new(positions, faces),
            attributes: Attributes {
                file_faces: Some(origins),
                ..Attributes::default()
            },
            notes: Vec::new(),
        };
        continue_paint(&mut model, 2);
        let origins = model.attributes.file_faces.unwrap();
        let of: Vec<u32> = origins.iter().map(|origin| origin.face).collect();
        assert_eq!(of, [7, 9, 7, 7, 9, NONE]);
        assert_eq!(origins[2].corners, BESIDE);
        assert_eq!(model.notes.len(), 1);
    }
}
