//! Masks from the caller's arrays: the faces that a restoration replaces and a fairing smooths.

use isomend_files::io::Loaded;
use isomend_files::job::MaskSpec;

use crate::pointers::{array, value};
use crate::status::{Failure, Status};

/// The faces of a mesh that are marked: by their numbers, or by vertices.
#[repr(C)]
pub struct MaskArrays {
    /// Numbers of faces, from 0; may be null if there are none.
    faces: *const u32,
    /// The length of `faces`.
    face_count: usize,
    /// Numbers of vertices, from 0: a face is marked if its three vertices are among them. May be null if there are none.
    vertices: *const u32,
    /// The length of `vertices`.
    vertex_count: usize,
    /// The marked region grows by this length along the edges, in the mesh's units; 0 for none.
    grow: f64,
    /// Then it shrinks by this length.
    shrink: f64,
}

/// The mask of the caller's arrays.
///
/// # Safety
/// The pointer is null, or points to a mask whose arrays have their lengths.
pub unsafe fn marked(mask: *const MaskArrays, loaded: &Loaded) -> Result<MaskSpec, Failure> {
    // SAFETY: as the caller promises.
    let (mask, faces, vertices) = unsafe {
        let mask = value(mask, "mask")?;
        (
            mask,
            array(mask.faces, mask.face_count, "mask.faces")?,
            array(mask.vertices, mask.vertex_count, "mask.vertices")?,
        )
    };
    let mut numbers: Vec<usize> = faces.iter().map(|face| *face as usize).collect();
    if !vertices.is_empty() {
        numbers.extend(among(vertices, loaded)?);
    }
    if numbers.is_empty() {
        let what = match vertices.is_empty() {
            true => "the mask marks no face: it has neither faces nor vertices",
            false => "the mask marks no face: none has its three vertices among mask.vertices",
        };
        return Err(Failure::new(Status::Parameter, what));
    }
    Ok(MaskSpec {
        faces: numbers,
        grow: Some(mask.grow),
        shrink: Some(mask.shrink),
        ..MaskSpec::default()
    })
}

/// The faces whose vertices are all among the given ones.
fn among(vertices: &[u32], loaded: &Loaded) -> Result<impl Iterator<Item = usize>, Failure> {
    let mesh = &loaded.mesh;
    let mut is_marked = vec![false; mesh.positions.len()];
    for vertex in vertices {
        let count = is_marked.len();
        let Some(mark) = is_marked.get_mut(*vertex as usize) else {
            let what = format!(
                "the mask names vertex {vertex}, but the mesh has {count}, numbered from 0"
            );
            return Err(Failure::new(Status::Parameter, what));
        };
        *mark = true;
    }
    let faces = mesh.faces.iter().enumerate();
    Ok(faces
        .filter(move |(_, face)| face.iter().all(|v| is_marked[*v as usize]))
        .map(|(number, _)| number))
}
