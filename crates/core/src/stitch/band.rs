//! Bands: rings of triangles between two rims, without new vertices.

use glam::DVec3;

use super::sector::Outline;
use super::zip::ring;
use crate::mesh::Mesh;

/// A rim on one side of a wall.
#[derive(Clone, Copy)]
pub struct OpeningRim<'a> {
    /// Its vertices, in the direction of the faces of a patch.
    pub rim: &'a [u32],
    /// For each of its edges the direction in which the side would continue.
    pub conormals: &'a [DVec3],
}

/// The triangles of the edge of an opening: a ring between the rims on the two sides of a wall, straight across. At each rim they
/// face the direction in which its side would continue.
///
/// Faces use the directed edges `rim[i] → rim[i + 1]` of both rims. None if the rims share a vertex.
pub fn band(mesh: &Mesh, sides: [OpeningRim; 2]) -> Option<Vec<[u32; 3]>> {
    let [a, b] = sides;
    if a.rim.iter().any(|v| b.rim.contains(v)) {
        return None;
    }
    let [first, second] = sides.map(|side| outline(mesh, side));
    Some(ring([a.rim, b.rim], [&first, &second]))
}

/// A rim whose normals are the means of the conormals of its edges at each vertex.
fn outline(mesh: &Mesh, side: OpeningRim) -> Outline {
    let n = side.rim.len();
    let normal = |i: usize| -> DVec3 {
        (side.conormals[i] + side.conormals[(i + n - 1) % n]).normalize_or_zero()
    };
    let vertices = side.rim.iter().enumerate();
    Outline::new(vertices.map(|(i, &v)| (mesh.positions[v as usize], normal(i))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mend::Inspection;
    use crate::mesh::area_vector;

    /// A plate between z = 0 and z = 0.1 with an opening of two quadrangles, of which the lower one is turned and has an edge more;
    /// without the edge of the opening.
    fn plate() -> Mesh {
        let ring = |radius: f64, count: u32, turn: f64, z: f64| {
            (0..count).map(move |i| {
                let angle = (f64::from(i) / f64::from(count) + turn) * std::f64::consts::TAU;
                DVec3::new(radius * angle.cos(), radius * angle.sin(), z)
            })
        };
        let mut positions: Vec<DVec3> = ring(2.0, 20, 0.0, 0.1).collect();
        positions.extend(ring(1.0, 4, 0.0, 0.1));
        positions.extend(ring(2.0, 20, 0.0, 0.0));
        positions.extend(ring(1.0, 5, 0.02, 0.0));
        let mut faces = Vec::new();
        let mut annulus = |outer: u32, inner: u32, count: u32, turned: bool| {
            let mut put = |f: [u32; 3]| faces.push(if turned { [f[0], f[2], f[1]] } else { f });
            for i in 0..20 {
                let (now, next) = (i * count / 20, ((i + 1) * count / 20) % count);
                put([outer + i, outer + (i + 1) % 20, inner + now]);
                if now != next {
                    put([outer + (i + 1) % 20, inner + next, inner + now]);
                }
            }
        };
        annulus(0, 20, 4, false);
        annulus(24, 44, 5, true);
        for i in 0..20 {
            let j = (i + 1) % 20;
            faces.push([24 + i, 24 + j, i]);
            faces.push([24 + j, j, i]);
        }
        Mesh::new(positions, faces)
    }

    #[test]
    fn a_band_closes_an_opening_and_faces_into_it() {
        let mut mesh = plate();
        let found = Inspection::new(&mesh).unwrap();
        let [a, b] = &found.holes[..] else {
            panic!("{} holes", found.holes.len());
        };
        assert!(a.is_across_wall(b));
        let sides = [a, b].map(|hole| OpeningRim {
            rim: &hole.rim,
            conormals: &hole.conormals,
        });
        let faces = band(&mesh, sides).unwrap();
        assert_eq!(faces.len(), 9);
        for f in &faces {
            let corners = f.map(|v| mesh.positions[v as usize]);
            let centre = corners.iter().sum::<DVec3>() / 3.0;
            assert!(area_vector(corners).dot(-centre.with_z(0.0)) > 0.0);
        }
        mesh.faces.extend(faces);
        let closed = Inspection::new(&mesh).unwrap();
        assert!(closed.holes.is_empty() && closed.topology.defects.misoriented_edges == 0);
    }
}
