//! Guesses which axis of a mesh points up, from what it could stand on.

use glam::DVec3;

use isomend_core::mesh::{Mesh, area_vector};

/// Fraction of the extent: faces and rims this near to the lowest point are what the mesh stands on.
const FOOT: f64 = 0.03;
/// Cosine: faces of a foot look down within 20 degrees.
const LEVEL: f64 = 0.94;
/// Least foot that decides, as a fraction of the footprint. 11 of 12 scans and models from several programs have one for one axis at most.
const DECIDES: f64 = 0.3;
/// A foot that is larger than the other one by this factor decides.
const CLEARLY: f64 = 2.0;
/// Fraction of the footprint from which on a foot is the flat side of a part, which lies on its largest side.
const FLAT: f64 = 0.5;

/// Factor by which the y side must be larger than the z side: slicers and most parts have z up.
const LARGER: f64 = 1.2;

/// What a mesh stands on, if an axis points up.
struct Foot {
    /// Area of faces that lie on the ground.
    area: f64,
    /// Area of the bounding box, seen from above.
    print: f64,
    /// Length of rims that lie on the ground, over the perimeter of the bounding box seen from above.
    rim: f64,
}

impl Foot {
    fn new(axis: usize, mesh: &Mesh, rims: &[Vec<DVec3>], [low, high]: [DVec3; 2]) -> Self {
        let size = high - low;
        let [across, along] = [size[(axis + 1) % 3], size[(axis + 2) % 3]];
        let most = low[axis] + FOOT * size[axis];
        let faces = 0..mesh.faces.len() as u32;
        let area = faces.map(|f| {
            let corners = mesh.corners(f);
            let lies = corners.iter().all(|p| p[axis] <= most);
            let twice = if lies {
                area_vector(corners)
            } else {
                DVec3::ZERO
            };
            match -twice[axis] > LEVEL * twice.length() {
                true => 0.5 * twice.length(),
                false => 0.0,
            }
        });
        let rim = rims.iter().flat_map(|rim| {
            let next = rim.iter().cycle().skip(1);
            rim.iter().zip(next).map(|(a, b)| {
                let lies = a[axis].max(b[axis]) <= most;
                if lies { a.distance(*b) } else { 0.0 }
            })
        });
        Self {
            area: area.sum(),
            print: (across * along).max(f64::MIN_POSITIVE),
            rim: rim.sum::<f64>() / (2.0 * (across + along)).max(f64::MIN_POSITIVE),
        }
    }

    /// The foot as a fraction of the footprint.
    fn part(&self) -> f64 {
        self.area / self.print + self.rim
    }

    /// Whether it is a flat side.
    fn is_flat(&self) -> bool {
        self.area / self.print > FLAT
    }
}

/// The axis that likely points up, y or z: the one with a foot (a flat base, or an open rim at the bottom), so that statues and vases
/// stand; of two flat sides the larger one; else the longer axis. `rims` are the closed rims of the holes.
pub fn up_axis(mesh: &Mesh, rims: &[Vec<DVec3>], bounds: [DVec3; 2]) -> DVec3 {
    let size = bounds[1] - bounds[0];
    let longer = size.y > size.z;
    let [y, z] = [1, 2].map(|axis| Foot::new(axis, mesh, rims, bounds));
    let is_y = match (y.part(), z.part()) {
        _ if y.is_flat() && z.is_flat() => y.area > LARGER * z.area,
        (y, z) if y.max(z) < DECIDES => longer,
        (y, z) if y > CLEARLY * z => true,
        (y, z) if z > CLEARLY * y => false,
        _ => longer,
    };
    if is_y { DVec3::Y } else { DVec3::Z }
}

#[cfg(test)]
mod tests {
    use super::*;
    use isomend_core::mend::Inspection;

    /// A box of these sides with a point on top of its y or z side, as a statue on a flat foot; without the foot if `open`.
    fn statue(sides: DVec3, axis: usize, open: bool) -> Mesh {
        let mut mesh = Mesh::new(Vec::new(), Vec::new());
        let (a, b) = ((axis + 1) % 3, (axis + 2) % 3);
        for [x, y] in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
            let mut p = DVec3::ZERO;
            (p[a], p[b]) = (x, y);
            mesh.positions.push(p * sides);
        }
        let mut top = DVec3::splat(0.5) * sides;
        top[axis] = sides[axis];
        mesh.positions.push(top);
        mesh.faces = vec![[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]];
        if !open {
            mesh.faces.extend([[0, 2, 1], [0, 3, 2]]);
        }
        mesh
    }

    fn guessed(mesh: &Mesh) -> DVec3 {
        let holes = Inspection::new(mesh).unwrap().holes;
        let rims: Vec<Vec<DVec3>> = holes
            .iter()
            .map(|hole| {
                hole.rim
                    .iter()
                    .map(|&v| mesh.positions[v as usize])
                    .collect()
            })
            .collect();
        up_axis(mesh, &rims, mesh.bounds())
    }

    #[test]
    fn what_has_a_foot_stands_on_it() {
        let wide = DVec3::new(3.0, 2.0, 2.5);
        for (axis, up) in [(1, DVec3::Y), (2, DVec3::Z)] {
            for open in [true, false] {
                assert_eq!(guessed(&statue(wide, axis, open)), up, "{axis} {open}");
            }
        }
    }

    #[test]
    fn a_plate_lies_and_a_body_without_a_foot_stands_along_its_longer_axis() {
        let mut plate = isomend_core::mesh::shapes::cube();
        plate
            .positions
            .iter_mut()
            .for_each(|p| *p *= DVec3::new(4.0, 3.0, 0.5));
        assert_eq!(guessed(&plate), DVec3::Z);
        let mut ball = isomend_core::mesh::shapes::icosphere(3);
        ball.positions.iter_mut().for_each(|p| p.y *= 1.5);
        assert_eq!(guessed(&ball), DVec3::Y);
        ball.positions.iter_mut().for_each(|p| p.z *= 2.0);
        assert_eq!(guessed(&ball), DVec3::Z);
    }
}
