//! Reads a mesh of a USD stage: points, faces with their orientation, and subsets of faces.

use glam::{DMat4, DVec3};

use super::super::{IoError, Location};
use super::layer::Value;
use super::layers::Layers;
use super::prim::Prim;
use super::primvar::primvars;
use super::stage::{Scene, StageMesh, Subset};

/// Most vertices, and most corners of faces, of a stage.
const MOST: usize = 1 << 28;
/// Estimated memory in bytes of a mesh, of a set of its values and of a subset of its faces, without numbers.
const MESH: usize = 256;
const PRIMVAR: usize = 256;
const SUBSET: usize = 128;

/// The name of the material that a prim is bound to.
pub(super) fn material(prim: &Prim) -> Option<String> {
    let bound = [
        "material:binding",
        "material:binding:preview",
        "material:binding:full",
    ];
    let target = bound
        .iter()
        .find_map(|name| prim.property(name)?.targets.into_iter().next())?;
    let name = target.rsplit('/').next().unwrap_or_default();
    (!name.is_empty()).then(|| name.to_owned())
}

/// The sorted numbers of the faces that are holes of a subdivision surface.
fn holes(prim: &Prim, layers: &mut Layers<'_>) -> Result<Vec<u64>, IoError> {
    let holes = prim.value("holeIndices");
    let count = holes.as_ref().map_or(0, |holes| holes.numbers().len());
    layers.budget.spend(8 * count)?;
    let mut holes: Vec<u64> = holes
        .iter()
        .flat_map(|holes| holes.numbers())
        .map(|face| *face as u64)
        .collect();
    holes.sort_unstable();
    Ok(holes)
}

impl Scene {
    /// Adds a mesh.
    pub(super) fn mesh(
        &mut self,
        prim: &Prim,
        (name, material): (String, Option<String>),
        transform: DMat4,
        layers: &mut Layers<'_>,
    ) -> Result<(), IoError> {
        let start = self.surface.positions.len();
        let (Some(points), Some(counts), Some(indices)) = (
            prim.value("points"),
            prim.value("faceVertexCounts"),
            prim.value("faceVertexIndices"),
        ) else {
            self.skip("meshes without points or faces", 1);
            return Ok(());
        };
        let points = points.numbers().as_chunks::<3>().0;
        let size = (24 * points.len()).saturating_add(32 * indices.numbers().len());
        layers.budget.spend(size)?;
        if start + points.len() > MOST || self.corners.len() + indices.numbers().len() > MOST {
            let what = format!(
                "with mesh '{name}' the stage has more than {MOST} vertices or corners of faces"
            );
            return Err(self.fault(layers, what));
        }
        self.add_points(points, transform);
        let is_left = prim.word("orientation").as_deref() == Some("leftHanded");
        let turned = is_left != (transform.determinant() < 0.0);
        let faces = Faces {
            name: &name,
            counts: counts.numbers(),
            indices: indices.numbers(),
            vertices: points.len(),
            turned,
            holes: holes(prim, layers)?,
        };
        self.add_faces(&faces, start, layers)?;
        let explicit = prim.word("subdivisionScheme");
        if explicit.is_some_and(|scheme| scheme != "none") {
            self.skip(
                "subdivision of meshes, which are read as their control meshes",
                1,
            );
        }
        if prim.property("skel:skeleton").is_some() {
            self.skip("skeletons of meshes, which are in their bind pose", 1);
        }
        let (primvars, unread) = primvars(prim);
        layers.budget.spend(MESH + PRIMVAR * primvars.len())?;
        self.skip("values of vertices or faces that cannot be read", unread);
        let subsets = self.subsets(prim, layers)?;
        let vertices = start..self.surface.positions.len();
        self.meshes.push(StageMesh {
            name,
            transform,
            vertices,
            face_count: counts.numbers().len(),
            primvars,
            material,
            subsets,
        });
        Ok(())
    }

    /// Adds the points of a mesh.
    fn add_points(&mut self, points: &[[f64; 3]], transform: DMat4) {
        let points = points.iter().copied().map(DVec3::from_array);
        match transform == DMat4::IDENTITY {
            true => self.surface.positions.extend(points),
            false => {
                let points = points.map(|point| transform.transform_point3(point));
                self.surface.positions.extend(points);
            }
        }
    }

    /// Adds the faces of a mesh whose first vertex is `start`.
    fn add_faces(
        &mut self,
        faces: &Faces<'_>,
        start: usize,
        layers: &Layers<'_>,
    ) -> Result<(), IoError> {
        let mesh = self.meshes.len() as u32;
        let (mut at, mut own) = (0usize, Vec::new());
        for (face, count) in faces.counts.iter().enumerate() {
            let end = at.saturating_add(*count as usize);
            let Some(corners) = faces.indices.get(at..end) else {
                let what = format!(
                    "the faces of mesh '{}' have more than its {} corners",
                    faces.name,
                    faces.indices.len()
                );
                return Err(self.fault(layers, what));
            };
            let range = at..end;
            at = end;
            if faces.holes.binary_search(&(face as u64)).is_ok() {
                self.skip("faces that are holes", 1);
                continue;
            }
            if corners.len() < 3 {
                self.skip("faces of one or two corners", 1);
                continue;
            }
            own.clear();
            for corner in corners {
                if !(0.0..faces.vertices as f64).contains(corner) {
                    let what = format!(
                        "face {face} of mesh '{}' has vertex {corner}, but the mesh has {} vertices",
                        faces.name, faces.vertices
                    );
                    return Err(self.fault(layers, what));
                }
                own.push((start + *corner as usize) as u32);
            }
            let first = self.corners.len();
            self.corners.extend(range.map(|corner| corner as u32));
            if faces.turned {
                own[1..].reverse();
                self.corners[first + 1..].reverse();
            }
            self.surface.push_face(&own)?;
            self.faces.push((mesh, face as u32));
        }
        Ok(())
    }

    /// The subsets of faces below a mesh.
    fn subsets(&self, prim: &Prim, layers: &mut Layers<'_>) -> Result<Vec<Subset>, IoError> {
        let mut subsets = Vec::new();
        for child in layers.children(prim)? {
            let is_of_faces = child.word("elementType").is_none_or(|kind| kind == "face");
            if child.kind() != "GeomSubset" || !is_of_faces || !child.is_there() {
                continue;
            }
            let material = material(&child);
            layers.budget.spend(SUBSET)?;
            subsets.push(Subset {
                is_material: material.is_some()
                    || child.word("familyName").as_deref() == Some("materialBind"),
                faces: child.value("indices").unwrap_or(Value::Other),
                name: material.unwrap_or(child.name),
            });
        }
        Ok(subsets)
    }

    fn fault(&self, layers: &Layers<'_>, what: String) -> IoError {
        IoError::malformed(
            layers.budget.format,
            Location::Item("mesh", self.meshes.len()),
            what,
        )
    }
}

/// The faces of a mesh.
struct Faces<'a> {
    name: &'a str,
    counts: &'a [f64],
    indices: &'a [f64],
    vertices: usize,
    /// Whether their corners are to be reversed.
    turned: bool,
    /// Sorted numbers of faces that are not part of the surface.
    holes: Vec<u64>,
}
