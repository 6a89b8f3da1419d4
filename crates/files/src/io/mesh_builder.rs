//! Collects the points and faces of a file, checks them and triangulates polygons.

use glam::DVec3;

use super::{Format, IoError, Loaded, Location};
use isomend_core::mesh::triangulate::Triangulator;
use isomend_core::mesh::{Attributes, LARGEST, Mesh, SMALLEST, bounds};

/// A surface under construction. Vertices keep the order of the file. Polygons are triangulated once all points are
/// known.
pub(super) struct MeshBuilder {
    format: Format,
    /// Points in file order.
    pub(super) positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    polygons: Vec<Polygon>,
    polygon_corners: Vec<u32>,
    /// Remarks for the user.
    pub(super) notes: Vec<String>,
    /// The lines of faces of one or two corners, which are left out.
    pub(super) omitted: Vec<usize>,
    /// The number of points and lines, which are not part of a surface.
    pub(super) skipped: usize,
}

/// For each triangle of a surface, the face and corners of the file that it comes from.
pub(super) struct CutFrom {
    /// The face of each triangle, counted in the order in which faces were added.
    pub(super) face: Vec<u32>,
    /// The three corners of each triangle, counted over the corners of all faces in that order.
    pub(super) corners: Vec<[u32; 3]>,
}

impl CutFrom {
    /// For `count` triangles that are the faces of the file.
    pub(super) fn identity(count: usize) -> Self {
        Self {
            face: (0..count as u32).collect(),
            corners: (0..count as u32)
                .map(|f| [3 * f, 3 * f + 1, 3 * f + 2])
                .collect(),
        }
    }

    /// Appends triangles that were faces of the file. The first of them is number `face` and begins at corner `corner`.
    fn add_triangles(&mut self, count: usize, face: usize, corner: usize) {
        self.face.extend((0..count).map(|i| (face + i) as u32));
        let first = |i: usize| (corner + 3 * i) as u32;
        self.corners
            .extend((0..count).map(|i| [first(i), first(i) + 1, first(i) + 2]));
    }
}

/// A face of more than three corners, not yet triangulated.
struct Polygon {
    /// The number of triangles collected before it.
    after: usize,
    /// The end of its corners in `polygon_corners`.
    end: usize,
}

impl MeshBuilder {
    pub(super) fn new(format: Format) -> Self {
        Self {
            format,
            positions: Vec::new(),
            triangles: Vec::new(),
            polygons: Vec::new(),
            polygon_corners: Vec::new(),
            notes: Vec::new(),
            omitted: Vec::new(),
            skipped: 0,
        }
    }

    /// The triangles collected so far, without polygons.
    pub(super) fn triangles_mut(&mut self) -> &mut Vec<[u32; 3]> {
        &mut self.triangles
    }

    /// Reserves memory for faces whose number is known.
    pub(super) fn reserve_faces(&mut self, count: usize) {
        self.triangles.reserve(count);
    }

    /// The number of faces collected; a polygon counts as one.
    pub(super) fn face_count(&self) -> usize {
        self.triangles.len() + self.polygons.len()
    }

    pub(super) fn push_triangle(&mut self, corners: [u32; 3]) {
        self.triangles.push(corners);
    }

    /// Adds a face of any number of corners.
    ///
    /// # Errors
    /// When there are fewer than three.
    pub(super) fn push_face(&mut self, corners: &[u32]) -> Result<(), IoError> {
        match corners {
            [] | [_] | [_, _] => {
                let place = Location::Item("face", self.face_count());
                let what = format!(
                    "a face of {} corners, where at least 3 are needed",
                    corners.len()
                );
                Err(IoError::malformed(self.format, place, what))
            }
            [a, b, c] => {
                self.triangles.push([*a, *b, *c]);
                Ok(())
            }
            _ => {
                self.polygon_corners.extend_from_slice(corners);
                self.polygons.push(Polygon {
                    after: self.triangles.len(),
                    end: self.polygon_corners.len(),
                });
                Ok(())
            }
        }
    }

    /// Adds the triangles of a strip; every second one is reversed so that all have the same orientation. Triangles
    /// that repeat a corner only connect the parts of a strip and are omitted.
    pub(super) fn push_strip(&mut self, corners: &[u32]) {
        for (i, window) in corners.windows(3).enumerate() {
            let (a, b, c) = (window[0], window[1], window[2]);
            if a != b && b != c && a != c {
                self.triangles
                    .push(if i % 2 == 0 { [a, b, c] } else { [b, a, c] });
            }
        }
    }

    /// Adds the triangles of a fan around its first corner.
    pub(super) fn push_fan(&mut self, corners: &[u32]) {
        for pair in corners.get(1..).unwrap_or(&[]).windows(2) {
            self.triangles.push([corners[0], pair[0], pair[1]]);
        }
    }

    /// Checks points and faces, triangulates polygons and counts degenerate triangles.
    ///
    /// # Errors
    /// When a coordinate is not finite, a face names a point that does not exist, there are no faces, or all are
    /// degenerate.
    pub(super) fn finish(self) -> Result<Loaded, IoError> {
        self.finish_with(&mut None)
    }

    /// As [`MeshBuilder::finish`]. If `cut` holds a value, it is replaced by the origins of the triangles.
    pub(super) fn finish_with(mut self, cut: &mut Option<CutFrom>) -> Result<Loaded, IoError> {
        self.check_positions()?;
        self.check_indices()?;
        if self.face_count() == 0 {
            return Err(IoError::NoFaces {
                format: self.format,
                points: self.positions.len(),
                omitted: self.omitted.len(),
            });
        }
        let faces = self.cut_polygons(cut);
        let degenerate = faces
            .iter()
            .filter(|face| is_degenerate(&self.positions, face))
            .count();
        if degenerate == faces.len() {
            return Err(IoError::AllDegenerate {
                format: self.format,
                faces: degenerate,
            });
        }
        if degenerate > 0 {
            let all = faces.len();
            self.notes.push(format!(
                "degenerate triangles (they repeat a corner or have no area): {degenerate} of {all}"
            ));
        }
        if let Some(first) = self.omitted.first() {
            let count = self.omitted.len();
            let which = if count == 1 { "" } else { "the first " };
            let note =
                format!("faces of one or two corners, left out: {count}, {which}in line {first}");
            self.notes.push(note);
        }
        if self.skipped > 0 {
            let note = format!("points and lines, skipped: {}", self.skipped);
            self.notes.push(note);
        }
        let f32_exact = self.positions.iter().all(|p| p.as_vec3().as_dvec3() == *p);
        Ok(Loaded {
            mesh: Mesh::new(self.positions, faces),
            format: self.format,
            f32_exact,
            attributes: Attributes::default(),
            document: None,
            notes: self.notes,
        })
    }

    fn check_positions(&self) -> Result<(), IoError> {
        if u32::try_from(self.positions.len()).is_err() {
            let what = format!(
                "{} points are more than 32-bit indices can name",
                self.positions.len()
            );
            return Err(IoError::malformed(self.format, Location::File, what)
                .advise("split the mesh into smaller files"));
        }
        match self.positions.iter().position(|p| !p.is_finite()) {
            Some(index) => Err(not_finite(
                self.format,
                Location::Item("vertex", index),
                self.positions[index],
            )),
            None => self.check_sizes(),
        }
    }

    /// Refuses coordinates above `LARGEST` and extents below `SMALLEST`: fourth powers of lengths would overflow or
    /// underflow.
    fn check_sizes(&self) -> Result<(), IoError> {
        let large = |p: &DVec3| p.abs().max_element() > LARGEST;
        if let Some(index) = self.positions.iter().position(large) {
            let what = format!(
                "the coordinates {:?} are too large to measure; the largest possible coordinate is {LARGEST:e}",
                self.positions[index].to_array()
            );
            return Err(
                IoError::malformed(self.format, Location::Item("vertex", index), what)
                    .advise("scale the mesh down, or remove this vertex if it is a mistake"),
            );
        }
        let (low, high) = bounds(self.positions.iter().copied());
        let extent = (high - low).max_element();
        if 0.0 < extent && extent < SMALLEST {
            let what = format!(
                "the points are within {extent:e} of each other, which is too small to measure; the smallest possible \
                 extent is {SMALLEST:e}"
            );
            return Err(
                IoError::malformed(self.format, Location::File, what).advise("scale the mesh up")
            );
        }
        Ok(())
    }

    fn check_indices(&self) -> Result<(), IoError> {
        let count = self.positions.len();
        let outside = |i: &u32| *i as usize >= count;
        let face_and_index = match self.triangles.iter().position(|t| t.iter().any(outside)) {
            Some(t) => {
                let index = self.triangles[t].iter().copied().find(|i| outside(i));
                let polygons_before = self.polygons.iter().take_while(|p| p.after <= t).count();
                index.map(|index| (t + polygons_before, index))
            }
            None => self.polygon_corners.iter().position(outside).map(|corner| {
                let polygon = self.polygons.partition_point(|p| p.end <= corner);
                (
                    self.polygons[polygon].after + polygon,
                    self.polygon_corners[corner],
                )
            }),
        };
        match face_and_index {
            Some((face, index)) => Err(IoError::malformed(
                self.format,
                Location::Item("face", face),
                format!("it uses vertex {index} (counted from 0), but the file has only {count}"),
            )),
            None => Ok(()),
        }
    }

    fn cut_polygons(&mut self, cut: &mut Option<CutFrom>) -> Vec<[u32; 3]> {
        let triangles = std::mem::take(&mut self.triangles);
        if self.polygons.is_empty() {
            if let Some(cut) = cut {
                *cut = CutFrom::identity(triangles.len());
            }
            return triangles;
        }
        let new = self.polygon_corners.len() - 2 * self.polygons.len();
        let mut faces = Vec::with_capacity(triangles.len() + new);
        let mut triangulator = Triangulator::default();
        let (mut copied, mut start, mut unclean) = (0, 0, 0);
        let mut points = Vec::new();
        for (p, polygon) in self.polygons.iter().enumerate() {
            faces.extend_from_slice(&triangles[copied..polygon.after]);
            if let Some(cut) = cut {
                cut.add_triangles(polygon.after - copied, copied + p, 3 * copied + start);
            }
            copied = polygon.after;
            let corners = &self.polygon_corners[start..polygon.end];
            let first = (3 * copied + start) as u32;
            start = polygon.end;
            points.clear();
            points.extend(corners.iter().map(|i| self.positions[*i as usize]));
            let clean = triangulator.cut(&points, &mut |t| {
                faces.push(t.map(|i| corners[i]));
                if let Some(cut) = cut {
                    cut.face.push((copied + p) as u32);
                    cut.corners.push(t.map(|i| first + i as u32));
                }
            });
            unclean += usize::from(!clean);
        }
        faces.extend_from_slice(&triangles[copied..]);
        if let Some(cut) = cut {
            let face = copied + self.polygons.len();
            cut.add_triangles(triangles.len() - copied, face, 3 * copied + start);
        }
        let polygons = self.polygons.len();
        self.notes.push(format!(
            "faces of more than three corners cut into triangles: {polygons} into {new}"
        ));
        if unclean > 0 {
            self.notes.push(format!(
                "of these, faces with self-intersections or without area, cut arbitrarily: {unclean}"
            ));
        }
        faces
    }
}

/// The error for a coordinate that is infinite or not a number.
pub(super) fn not_finite(format: Format, place: Location, point: DVec3) -> IoError {
    IoError::malformed(
        format,
        place,
        format!("the coordinates {point} are not all finite numbers"),
    )
    .advise("remove or mend these vertices in the program that wrote the file")
}

fn is_degenerate(positions: &[DVec3], face: &[u32; 3]) -> bool {
    let [a, b, c] = face.map(|i| positions[i as usize]);
    (b - a).cross(c - a) == DVec3::ZERO
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> MeshBuilder {
        let mut surface = MeshBuilder::new(Format::Ply);
        surface.positions = vec![DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        surface
    }

    #[test]
    fn polygons_keep_their_place_among_the_triangles() {
        let mut surface = square();
        surface.push_triangle([0, 1, 3]);
        surface.push_face(&[0, 1, 2, 3]).unwrap();
        surface.push_triangle([1, 2, 3]);
        let mut cut = Some(CutFrom::identity(0));
        let loaded = surface.finish_with(&mut cut).unwrap();
        assert_eq!(
            loaded.mesh.faces,
            [[0, 1, 3], [0, 1, 2], [0, 2, 3], [1, 2, 3]]
        );
        assert_eq!(loaded.notes.len(), 1);
        let cut = cut.unwrap();
        assert_eq!(cut.face, [0, 1, 1, 2]);
        assert_eq!(cut.corners, [[0, 1, 2], [3, 4, 5], [3, 5, 6], [7, 8, 9]]);
    }

    #[test]
    fn strips_alternate_and_fans_turn_round_their_first_corner() {
        let mut surface = square();
        surface.push_strip(&[0, 1, 3, 2, 2]);
        surface.push_fan(&[0, 1, 2, 3]);
        assert_eq!(
            surface.finish().unwrap().mesh.faces,
            [[0, 1, 3], [3, 1, 2], [0, 1, 2], [0, 2, 3]]
        );
        let mut surface = square();
        surface.push_fan(&[]);
        surface.push_strip(&[0, 1]);
        assert_eq!(surface.face_count(), 0);
    }

    #[test]
    fn faults_are_named() {
        let finish = |f: &dyn Fn(&mut MeshBuilder)| {
            let mut surface = square();
            f(&mut surface);
            surface.finish().unwrap_err().to_string()
        };
        assert!(finish(&|_| ()).contains("no faces"));
        assert!(finish(&|s| s.push_triangle([0, 0, 1])).contains("all 1 faces are degenerate"));
        let message = finish(&|s| {
            s.push_face(&[0, 1, 2, 3]).unwrap();
            s.push_triangle([0, 1, 9]);
        });
        assert!(
            message.contains("face 1") && message.contains("vertex 9"),
            "{message}"
        );
        let message = finish(&|s| {
            s.push_triangle([0, 1, 2]);
            s.push_face(&[0, 1, 2, 7]).unwrap();
        });
        assert!(
            message.contains("face 1") && message.contains("vertex 7"),
            "{message}"
        );
        let message = finish(&|s| s.positions[2].y = f64::NAN);
        assert!(message.contains("vertex 2"), "{message}");
        assert!(
            square()
                .push_face(&[0, 1])
                .unwrap_err()
                .to_string()
                .contains("2 corners")
        );
    }

    #[test]
    fn sizes_that_cannot_be_measured_are_refused() {
        let scaled = |factor: f64| {
            let mut surface = square();
            surface.positions.iter_mut().for_each(|p| *p *= factor);
            surface.push_face(&[0, 1, 2, 3]).unwrap();
            surface.finish().map_err(|error| error.to_string())
        };
        for factor in [1e160, 1e76] {
            let message = scaled(factor).unwrap_err();
            let is_named = message.contains("vertex 1") && message.contains("too large to measure");
            assert!(
                is_named && message.contains("scale the mesh down"),
                "{message}"
            );
        }
        for factor in [1e-160, 1e-76] {
            let message = scaled(factor).unwrap_err();
            assert!(message.contains("too small to measure"), "{message}");
        }
        for factor in [1e74, 1e-69, 1.0] {
            let loaded = scaled(factor).unwrap();
            assert_eq!(loaded.notes.len(), 1, "{:?}", loaded.notes);
            let [a, b, c] = loaded.mesh.corners(0);
            let area = (b - a).cross(c - a).length();
            assert!((area / factor / factor - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn degenerate_faces_are_kept_and_counted() {
        let mut surface = square();
        surface.push_triangle([0, 1, 2]);
        surface.push_triangle([0, 1, 1]);
        let loaded = surface.finish().unwrap();
        assert_eq!(loaded.mesh.faces.len(), 2);
        assert!(loaded.notes[0].contains("1 of 2"));
    }
}
