//! Meshes from the caller's arrays.

use std::sync::Arc;

use glam::DVec3;
use isomend_core::mesh::{Attributes, Mesh, MeshError};
use isomend_files::io::Loaded;

use crate::pointers::{array, check, set};
use crate::status::{Failure, Status, guarded};

/// A mesh in memory. Calls share it and do not change it, so that several threads may use it at once.
pub struct MeshHandle(pub(crate) Arc<Loaded>);

/// Makes a mesh from arrays: `vertices` holds 3 · `vertex_count` coordinates, `faces` 3 · `face_count` indices of vertices, from 0. The
/// arrays are copied.
///
/// # Safety
/// The arrays have these lengths.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn isomend_mesh_f64(
    vertices: *const f64,
    vertex_count: usize,
    faces: *const u32,
    face_count: usize,
    mesh: *mut *mut MeshHandle,
) -> Status {
    // SAFETY: as the caller promises.
    unsafe { from_arrays(vertices, vertex_count, faces, face_count, mesh) }
}

/// As `isomend_mesh_f64`, from 32-bit coordinates.
///
/// # Safety
/// The arrays have these lengths.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn isomend_mesh_f32(
    vertices: *const f32,
    vertex_count: usize,
    faces: *const u32,
    face_count: usize,
    mesh: *mut *mut MeshHandle,
) -> Status {
    // SAFETY: as the caller promises.
    unsafe { from_arrays(vertices, vertex_count, faces, face_count, mesh) }
}

/// # Safety
/// As for `isomend_mesh_f64`.
unsafe fn from_arrays<T: Copy + Into<f64>>(
    vertices: *const T,
    vertex_count: usize,
    faces: *const u32,
    face_count: usize,
    mesh: *mut *mut MeshHandle,
) -> Status {
    guarded(|| {
        check(mesh, "mesh")?;
        // SAFETY: as the caller promises.
        let (vertices, faces) = unsafe {
            (
                array(vertices, tripled(vertex_count), "vertices")?,
                array(faces, tripled(face_count), "faces")?,
            )
        };
        let handle = made(vertices, faces)?;
        // SAFETY: it was checked; the caller promises the rest.
        unsafe { set(mesh, handle) };
        Ok(())
    })
}

/// Frees a mesh. A null pointer is left alone.
///
/// # Safety
/// The pointer is null, or a mesh that has not been freed and that no call uses.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn isomend_mesh_free(mesh: *mut MeshHandle) {
    if !mesh.is_null() {
        // SAFETY: `made` made it from a box.
        drop(unsafe { Box::from_raw(mesh) });
    }
}

/// The number of array elements of a number of rows of three; a product that is too large stays too large.
fn tripled(count: usize) -> usize {
    count.saturating_mul(3)
}

/// A mesh whose faces refer to its vertices.
fn made<T: Copy + Into<f64>>(
    coordinates: &[T],
    corners: &[u32],
) -> Result<*mut MeshHandle, Failure> {
    let position = |row: &[T]| DVec3::new(row[0].into(), row[1].into(), row[2].into());
    let positions = coordinates.chunks_exact(3).map(position);
    let faces = corners.chunks_exact(3).map(|f| [f[0], f[1], f[2]]);
    let mesh = Mesh::new(positions.collect(), faces.collect());
    // What else is wrong is said by the work, as it is of a mesh from a file.
    if let Err(error @ (MeshError::TooMany { .. } | MeshError::Index { .. })) = mesh.validate() {
        return Err(Failure::new(Status::Mesh, error.to_string()));
    }
    let loaded = Loaded::in_memory(mesh, Attributes::default());
    Ok(Box::into_raw(Box::new(MeshHandle(Arc::new(loaded)))))
}
