//! The scene of a mesh before and after: one set of triangles with normals, curvature, distances and expected errors, simplified to a
//! bounded size. HTML reports and pictures are drawn from it.

mod shading;
mod thin;
mod upright;

use glam::{DVec3, Vec3};

use isomend_core::mesh::{Mesh, bounds, weld_map, welded};
use isomend_core::spatial::Bvh;
use rayon::prelude::*;
use shading::Shading;
#[doc(hidden)]
pub use upright::up_axis;

/// Sum of the principal curvatures at each vertex of a mesh, averaged over its neighbourhood; positive on a sphere. Vertices at the
/// same position get the same value.
#[doc(hidden)]
pub fn curvature(mesh: &Mesh) -> Vec<f32> {
    let weld = weld_map(mesh);
    let (welded, _) = welded(mesh);
    let values = Shading::new(&welded).curvature;
    weld.iter().map(|&v| values[v as usize]).collect()
}

/// The distance of the chosen vertices of a mesh from another mesh; 0 for the other vertices.
#[doc(hidden)]
pub fn distances(mesh: &Mesh, chosen: &[bool], other: &Mesh) -> Vec<f32> {
    let bvh = Bvh::new(other, 0..other.faces.len() as u32);
    let points = mesh.positions.par_iter().zip(chosen);
    let distance = |(p, is_chosen): (&DVec3, &bool)| {
        let found = is_chosen.then(|| bvh.closest(*p, f64::INFINITY)).flatten();
        found.map_or(0.0, |c| c.distance as f32)
    };
    points.map(distance).collect()
}

/// A mesh before and after a change.
pub struct SceneChange<'a> {
    /// The mesh before.
    pub before: &'a Mesh,
    /// The mesh after.
    pub after: &'a Mesh,
    /// The first `kept` faces of `after` are also faces of `before`; the others are new.
    pub kept: usize,
    /// For each face of `before`, whether it was removed.
    pub gone: Vec<bool>,
    /// Number of new faces of each region, in the order of the faces.
    pub patches: Vec<usize>,
    /// The closed rims of the holes, in the order of the holes' numbers, from 1.
    pub rims: Vec<Vec<DVec3>>,
    /// The expected errors of the new vertices, which are the last of `after`; `None` if unknown.
    pub errors: &'a [Option<f64>],
}

/// The triangles and lines to draw, in the mesh's units.
pub struct Scene {
    /// Centre of the scene in the mesh's coordinates; all positions are relative to it.
    pub origin: DVec3,
    /// Largest distance of a vertex from the origin.
    pub radius: f64,
    /// The axis that likely points up in the mesh before.
    pub up: Vec3,
    /// Vertices.
    pub positions: Vec<Vec3>,
    /// Unit normals of the vertices.
    pub normals: Vec<Vec3>,
    /// Sum of the principal curvatures at the vertices, averaged over their neighbourhood; positive on a sphere.
    pub curvature: Vec<f32>,
    /// Distance of new and removed vertices from the other mesh; 0 for vertices of both.
    pub distance: Vec<f32>,
    /// Expected error of the vertices: 0 for vertices of the input, NaN if unknown.
    pub error: Vec<f32>,
    /// Faces: first the faces of both meshes, then the new ones, then the removed ones.
    pub faces: Vec<[u32; 3]>,
    /// Number of faces that both meshes have.
    pub kept: usize,
    /// The region of each new face, from 1; 0 for none.
    pub regions: Vec<u32>,
    /// The colour of each region, starting with region 1; empty if all new faces have the same colour.
    pub palette: Vec<LegendColour>,
    /// The closed rims of the holes, in the order of the holes' numbers, from 1.
    pub rims: Vec<Vec<Vec3>>,
    /// Marked points, numbered from 1: the crease ends of an inspected mesh.
    pub points: Vec<Vec3>,
    /// Number of faces before the simplification.
    pub all_faces: usize,
}

/// A colour with its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LegendColour {
    /// The name, for legends.
    pub name: &'static str,
    /// Red, green and blue (sRGB).
    pub rgb: [u8; 3],
}

/// One of the two meshes of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The mesh before.
    Before,
    /// The mesh after.
    After,
}

impl Scene {
    /// The scene of a change, with at most `limit` faces. If there are more, the surface far from all patches and rims is simplified, and
    /// near them only if that is not enough.
    pub fn new(change: &SceneChange, limit: usize) -> Self {
        let (before, _) = welded(change.before);
        let (after, _) = welded(change.after);
        let kept = change.kept.min(after.faces.len());
        let mut parts = Parts::new(&after, Shading::new(&after));
        parts.measure(&after.faces[kept..], &before);
        let new = parts.error.len().saturating_sub(change.errors.len());
        for (own, error) in parts.error[new..].iter_mut().zip(change.errors) {
            *own = error.map_or(f32::NAN, |e| e as f32);
        }
        parts.add_gone(&before, &change.gone, &after);
        let all_faces = parts.faces.len();
        let rims: Vec<DVec3> = change.rims.iter().flatten().copied().collect();
        let mut regions: Vec<u32> = vec![0; after.faces.len() - kept];
        let mut at = 0;
        for (region, &count) in (1..).zip(&change.patches) {
            let end = regions.len().min(at + count);
            regions[at..end].fill(region);
            at = end;
        }
        let classes = [kept, after.faces.len()];
        let vertices = (&parts.positions[..], &parts.shading.normals[..]);
        let faces = thin::thinned(vertices, &parts.faces, classes, &rims, limit);
        parts.into_scene(faces, &regions, classes, change, all_faces)
    }

    /// Sets the colours of the regions, starting with region 1.
    #[must_use]
    pub fn with_palette(mut self, palette: &[LegendColour]) -> Self {
        self.palette = palette.to_vec();
        self
    }

    /// Sets the marked points, in the order of their numbers.
    #[must_use]
    pub fn with_points(mut self, points: impl Iterator<Item = DVec3>) -> Self {
        self.points = points.map(|p| (p - self.origin).as_vec3()).collect();
        self
    }

    /// The indices of the faces of one side.
    pub fn side(&self, side: Side) -> impl Iterator<Item = u32> + use<> {
        let new = self.kept + self.regions.len();
        let own = match side {
            Side::After => self.kept..new,
            Side::Before => new..self.faces.len(),
        };
        (0..self.kept as u32).chain(own.start as u32..own.end as u32)
    }

    /// The region of a face; `None` if the face is not new.
    pub fn region(&self, face: u32) -> Option<u32> {
        let new = (face as usize).checked_sub(self.kept)?;
        self.regions.get(new).copied()
    }

    /// Whether new faces get a different colour: there are some, and either not all faces are new or there is a palette.
    pub fn marks_new(&self) -> bool {
        (self.kept > 0 || !self.palette.is_empty()) && !self.regions.is_empty()
    }
}

/// Vertices and faces of both meshes, while a scene is built.
struct Parts {
    positions: Vec<DVec3>,
    shading: Shading,
    distance: Vec<f32>,
    error: Vec<f32>,
    faces: Vec<[u32; 3]>,
}

impl Parts {
    fn new(after: &Mesh, shading: Shading) -> Self {
        Self {
            positions: after.positions.clone(),
            shading,
            distance: vec![0.0; after.positions.len()],
            error: vec![0.0; after.positions.len()],
            faces: after.faces.clone(),
        }
    }

    /// Sets the distances of the corners of `faces` from the mesh `other`.
    fn measure(&mut self, faces: &[[u32; 3]], other: &Mesh) {
        let mut corners: Vec<u32> = faces.iter().flatten().copied().collect();
        corners.sort_unstable();
        corners.dedup();
        if corners.is_empty() {
            return;
        }
        let bvh = Bvh::new(other, 0..other.faces.len() as u32);
        let positions = &self.positions;
        let distances: Vec<f32> = corners
            .par_iter()
            .map(|&v| {
                let found = bvh.closest(positions[v as usize], f64::INFINITY);
                found.map_or(0.0, |c| c.distance as f32)
            })
            .collect();
        for (v, d) in corners.into_iter().zip(distances) {
            self.distance[v as usize] = d;
        }
    }

    /// Adds the removed faces, on new vertices.
    fn add_gone(&mut self, before: &Mesh, gone: &[bool], after: &Mesh) {
        if !gone.contains(&true) {
            return;
        }
        let shading = Shading::new(before);
        let mut number = vec![u32::MAX; before.positions.len()];
        let first = self.faces.len();
        for (face, _) in before.faces.iter().zip(gone).filter(|(_, gone)| **gone) {
            self.faces.push(face.map(|v| {
                let slot = &mut number[v as usize];
                if *slot == u32::MAX {
                    *slot = self.positions.len() as u32;
                    self.positions.push(before.positions[v as usize]);
                    self.distance.push(0.0);
                    self.error.push(0.0);
                    self.shading.push(&shading, v);
                }
                *slot
            }));
        }
        let faces = self.faces[first..].to_vec();
        self.measure(&faces, after);
    }

    /// Makes the scene of the given faces, with the vertices that they use. `faces` are index and corners; `kept` and `after` are the ends
    /// of the kept and of the new faces in the numbering before the simplification.
    fn into_scene(
        self,
        faces: Vec<(u32, [u32; 3])>,
        regions: &[u32],
        [kept, after]: [usize; 2],
        change: &SceneChange,
        all_faces: usize,
    ) -> Scene {
        let corners = faces.iter().flat_map(|(_, f)| f);
        let (low, high) = bounds(corners.map(|&v| self.positions[v as usize]));
        let origin = if faces.is_empty() {
            DVec3::ZERO
        } else {
            0.5 * (low + high)
        };
        let mut scene = Scene {
            origin,
            radius: 0.0,
            up: up_axis(change.before, &change.rims, change.before.bounds()).as_vec3(),
            positions: Vec::new(),
            normals: Vec::new(),
            curvature: Vec::new(),
            distance: Vec::new(),
            error: Vec::new(),
            faces: Vec::with_capacity(faces.len()),
            kept: faces.iter().filter(|(f, _)| (*f as usize) < kept).count(),
            regions: faces
                .iter()
                .filter(|(f, _)| (kept..after).contains(&(*f as usize)))
                .map(|(f, _)| regions[*f as usize - kept])
                .collect(),
            palette: Vec::new(),
            rims: Vec::new(),
            points: Vec::new(),
            all_faces,
        };
        let relative = |p: DVec3| (p - origin).as_vec3();
        let closed = |rim: &Vec<DVec3>| rim.iter().map(|&p| relative(p)).collect();
        scene.rims = change.rims.iter().map(closed).collect();
        let mut number = vec![u32::MAX; self.positions.len()];
        for (_, face) in faces {
            let face = face.map(|v| {
                let (slot, v) = (&mut number[v as usize], v as usize);
                if *slot == u32::MAX {
                    *slot = scene.positions.len() as u32;
                    scene.positions.push(relative(self.positions[v]));
                    scene.normals.push(self.shading.normals[v]);
                    scene.curvature.push(self.shading.curvature[v]);
                    scene.distance.push(self.distance[v]);
                    scene.error.push(self.error[v]);
                    scene.radius = scene.radius.max(self.positions[v].distance(origin));
                }
                *slot
            });
            scene.faces.push(face);
        }
        scene
    }
}
