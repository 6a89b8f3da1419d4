//! Bodies of a mesh: the objects of a file and their parts. Each is a mesh of its own, and may touch or intersect the others.

use std::collections::BTreeMap;

use super::attributes::{LabelKind, NONE};
use super::{Attributes, Mesh};

/// The bodies of a mesh, in the order of their first faces. Every vertex and face belongs to one.
#[derive(Clone, Debug)]
pub struct Bodies {
    /// The name of each body: of its object, and of the part if the object has several.
    pub names: Vec<String>,
    /// The vertices of each body, ascending. Vertices that no face uses belong to the body of the vertex before them.
    pub vertices: Vec<Vec<u32>>,
    /// The faces of each body, ascending.
    pub faces: Vec<Vec<u32>>,
}

impl Bodies {
    /// The bodies that the labels of objects and parts describe. None if these are no bodies of their own, if there is only
    /// one, or if two share a vertex.
    pub fn new(mesh: &Mesh, attributes: &Attributes) -> Option<Self> {
        if !attributes.separate {
            return None;
        }
        let labels = [LabelKind::Object, LabelKind::Part].map(|kind| attributes.labels_of(kind));
        let mut numbers: BTreeMap<[u32; 2], usize> = BTreeMap::new();
        let (mut names, mut faces): (Vec<String>, Vec<Vec<u32>>) = (Vec::new(), Vec::new());
        let mut of_vertex = vec![usize::MAX; mesh.positions.len()];
        for (f, corners) in mesh.faces.iter().enumerate() {
            let key = labels.map(|l| l.map_or(NONE, |l| l.of_face[f]));
            let body = *numbers.entry(key).or_insert_with(|| {
                let own = labels.iter().filter_map(|l| l.as_ref()?.get(f));
                names.push(own.collect::<Vec<_>>().join("/"));
                faces.push(Vec::new());
                faces.len() - 1
            });
            faces[body].push(f as u32);
            for &v in corners {
                let own = &mut of_vertex[v as usize];
                if *own != usize::MAX && *own != body {
                    return None;
                }
                *own = body;
            }
        }
        let mut vertices = vec![Vec::new(); faces.len()];
        let mut last = 0;
        for (v, body) in (0u32..).zip(of_vertex) {
            if body != usize::MAX {
                last = body;
            }
            vertices.get_mut(last)?.push(v);
        }
        let several = faces.len() > 1;
        several.then_some(Self {
            names,
            vertices,
            faces,
        })
    }

    /// Number of bodies.
    pub fn count(&self) -> usize {
        self.names.len()
    }

    /// A body as a mesh of its own, in which vertices and faces keep their order.
    pub fn mesh(&self, whole: &Mesh, body: usize) -> Mesh {
        let vertices = &self.vertices[body];
        let local = |v: u32| vertices.partition_point(|&w| w < v) as u32;
        let corners = |f: &u32| whole.faces[*f as usize].map(local);
        Mesh::new(
            vertices
                .iter()
                .map(|v| whole.positions[*v as usize])
                .collect(),
            self.faces[body].iter().map(corners).collect(),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::attributes::Labels;
    use crate::mesh::shapes::icosphere;

    fn labelled(of_face: Vec<u32>) -> Attributes {
        let mut labels = Labels::new(LabelKind::Object);
        labels.names = vec!["left".to_owned(), "right".to_owned()];
        labels.of_face = of_face;
        let labels = vec![labels];
        Attributes {
            labels,
            separate: true,
            ..Attributes::default()
        }
    }

    #[test]
    fn objects_are_bodies_unless_they_share_vertices() {
        let one = icosphere(1);
        let (vertices, faces) = (one.positions.len() as u32, one.faces.len());
        let mut mesh = one.clone();
        mesh.positions.extend(&one.positions);
        let moved = one.faces.iter().map(|f| f.map(|v| v + vertices));
        mesh.faces.extend(moved);
        let labels = (0..2 * faces).map(|f| u32::from(f < faces)).collect();
        let bodies = Bodies::new(&mesh, &labelled(labels)).unwrap();
        assert_eq!(bodies.names, ["right", "left"]);
        assert_eq!(
            [bodies.mesh(&mesh, 0), bodies.mesh(&mesh, 1)],
            [one.clone(), one.clone()]
        );
        assert!(Bodies::new(&mesh, &labelled(vec![0; 2 * faces])).is_none());
        let alternating = (0..faces as u32).map(|f| f % 2).collect();
        assert!(Bodies::new(&one, &labelled(alternating)).is_none());
    }
}
