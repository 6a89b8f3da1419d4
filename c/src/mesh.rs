//! Meshes from the caller's arrays.

use std::sync::Arc;

use glam::DVec3;
use isomend_core::mesh::{Attributes, Mesh};
use isomend_files::io::{Format, Loaded, Precision};

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
    guarded(|| {
        check(mesh, "mesh")?;
        // SAFETY: as the caller promises.
        let (vertices, faces) = unsafe {
            (
                array(vertices, tripled(vertex_count), "vertices")?,
                array(faces, tripled(face_count), "faces")?,
            )
        };
        let handle = made(vertices.iter().copied(), faces)?;
        // SAFETY: it was checked; the caller promises the rest.
        unsafe { set(mesh, handle) };
        Ok(())
    })
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
    guarded(|| {
        check(mesh, "mesh")?;
        // SAFETY: as the caller promises.
        let (vertices, faces) = unsafe {
            (
                array(vertices, tripled(vertex_count), "vertices")?,
                array(faces, tripled(face_count), "faces")?,
            )
        };
        let handle = made(vertices.iter().map(|x| f64::from(*x)), faces)?;
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
fn made(
    coordinates: impl Iterator<Item = f64>,
    corners: &[u32],
) -> Result<*mut MeshHandle, Failure> {
    let coordinates: Vec<f64> = coordinates.collect();
    let positions: Vec<DVec3> = coordinates.chunks_exact(3).map(DVec3::from_slice).collect();
    let count = positions.len();
    if count >= (u32::MAX / 4) as usize {
        let what = "the mesh has too many vertices; at most 1073741822 are supported";
        return Err(Failure::new(Status::Mesh, what));
    }
    if let Some(at) = corners.iter().position(|v| *v as usize >= count) {
        let what = format!(
            "face {} refers to vertex {}, but there are only {count} vertices, numbered from 0",
            at / 3,
            corners[at]
        );
        return Err(Failure::new(Status::Mesh, what));
    }
    let faces = corners.chunks_exact(3).map(|f| [f[0], f[1], f[2]]);
    let mesh = Mesh::new(positions, faces.collect());
    let loaded = Loaded {
        f32_exact: Precision::of(&mesh) == Precision::F32,
        mesh,
        format: Format::Ply,
        attributes: Attributes::default(),
        document: None,
        notes: Vec::new(),
    };
    Ok(Box::into_raw(Box::new(MeshHandle(Arc::new(loaded)))))
}
