//! Fills, repairs, restorations and fairings, and their results: the mended mesh, expected errors, origins and the report.

use std::ffi::{CString, c_char};
use std::sync::Arc;

use isomend_core::mend::Control;
use isomend_files::io::Loaded;
use isomend_files::job::{JobError, MaskSpec, Mended};
use serde_json::{Map, Value};

use crate::mask::{MaskArrays, marked};
use crate::mesh::MeshHandle;
use crate::pointers::{check, check_array, parameters, set, value};
use crate::questions::{json_of, spec};
use crate::run::{RunOptions, run};
use crate::status::{Failure, Status, guarded};

/// The origin of a new vertex or face.
const NEW: u32 = u32::MAX;

/// The result of a fill, a repair, a restoration or a fairing.
pub struct ResultHandle {
    mended: Mended<'static>,
    /// For each vertex the expected error; 0 for vertices of the input, NaN where there is no estimate.
    expected_errors: Vec<f64>,
    /// For each vertex and each face its number in the input, or [`NEW`].
    vertex_origins: Vec<u32>,
    face_origins: Vec<u32>,
    report: CString,
}

/// Fills the holes of a mesh. `result` is set if the call succeeds.
///
/// # Safety
/// The mesh has not been freed, `parameters` is null or a text, `options` is null or valid, `result` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn isomend_fill(
    mesh: *const MeshHandle,
    parameters: *const c_char,
    options: *const RunOptions,
    result: *mut *mut ResultHandle,
) -> Status {
    // SAFETY: as the caller promises.
    unsafe { mend(("fill", None), mesh, parameters, options, result) }
}

/// Repairs the defects of a mesh and fills its holes. `result` is set if the call succeeds.
///
/// # Safety
/// As for `isomend_fill`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn isomend_repair(
    mesh: *const MeshHandle,
    parameters: *const c_char,
    options: *const RunOptions,
    result: *mut *mut ResultHandle,
) -> Status {
    // SAFETY: as the caller promises.
    unsafe { mend(("repair", None), mesh, parameters, options, result) }
}

/// Cuts the marked faces out of a mesh and fills their holes. `result` is set if the call succeeds.
///
/// # Safety
/// As for `isomend_fill`; the mask is valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn isomend_restore(
    mesh: *const MeshHandle,
    mask: *const MaskArrays,
    parameters: *const c_char,
    options: *const RunOptions,
    result: *mut *mut ResultHandle,
) -> Status {
    // SAFETY: as the caller promises.
    unsafe { mend(("restore", Some(mask)), mesh, parameters, options, result) }
}

/// Smooths a mesh, or its marked faces, by Willmore flow. `result` is set if the call succeeds.
///
/// # Safety
/// As for `isomend_fill`; the mask is null or valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn isomend_fair(
    mesh: *const MeshHandle,
    mask: *const MaskArrays,
    parameters: *const c_char,
    options: *const RunOptions,
    result: *mut *mut ResultHandle,
) -> Status {
    let mask = (!mask.is_null()).then_some(mask);
    // SAFETY: as the caller promises.
    unsafe { mend(("fair", mask), mesh, parameters, options, result) }
}

/// # Safety
/// As for `isomend_fill`; the mask, if there is one, is null or valid.
unsafe fn mend(
    (command, mask): (&'static str, Option<*const MaskArrays>),
    mesh: *const MeshHandle,
    given: *const c_char,
    options: *const RunOptions,
    result: *mut *mut ResultHandle,
) -> Status {
    guarded(|| {
        check(result, "result")?;
        // SAFETY: as the caller promises.
        let (mesh, given) = unsafe { (value(mesh, "mesh")?, parameters(given)?) };
        let loaded = mesh.0.clone();
        // SAFETY: as the caller promises.
        let mask = mask.map(|mask| unsafe { marked(mask, &loaded) });
        let mask = mask.transpose()?;
        // SAFETY: as the caller promises.
        let made = unsafe {
            run(options, move |control| {
                made(command, mask, given, loaded, control)
            })
        }?;
        let handle = Box::into_raw(Box::new(ResultHandle::new(made)?));
        // SAFETY: it was checked; the caller promises the rest.
        unsafe { set(result, handle) };
        Ok(())
    })
}

/// Does the work.
fn made(
    command: &str,
    mask: Option<MaskSpec>,
    given: Map<String, Value>,
    loaded: Arc<Loaded>,
    control: &Control,
) -> Result<Mended<'static>, JobError> {
    let spec = spec(command, mask, given)?;
    let mended = spec.with(loaded).mend(control)?;
    mended.into_owned().judged()
}

impl ResultHandle {
    fn new(mended: Mended<'static>) -> Result<Self, Failure> {
        let vertices = mended.positions().len();
        let face_origins = mended.face_origins().into_iter();
        let mut vertex_origins = vec![NEW; vertices];
        let kept = vertex_origins.iter_mut().take(mended.kept_size()[0]);
        match mended.kept() {
            Some(marks) => {
                let numbers = (0..).zip(&marks.vertices);
                let old = numbers.filter_map(|(number, is_kept)| is_kept.then_some(number));
                kept.zip(old).for_each(|(origin, old)| *origin = old);
            }
            None => kept.zip(0..).for_each(|(origin, old)| *origin = old),
        }
        let report = json_of(&mended.document())?;
        Ok(Self {
            expected_errors: mended.expected_errors(vertices),
            vertex_origins,
            face_origins: face_origins.map(|old| old.unwrap_or(NEW)).collect(),
            report,
            mended,
        })
    }
}

/// The result, or the answer for a null pointer.
///
/// # Safety
/// The pointer is null, or a result that has not been freed.
unsafe fn of<T>(
    result: *const ResultHandle,
    none: T,
    read: impl FnOnce(&'static ResultHandle) -> T,
) -> T {
    // SAFETY: as the caller promises. What is read is a number, or a pointer that is valid until the result is freed.
    unsafe { result.as_ref() }.map_or(none, read)
}

/// The number of vertices.
///
/// # Safety
/// The pointer is null, or a result that has not been freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn isomend_result_vertex_count(result: *const ResultHandle) -> usize {
    // SAFETY: as the caller promises.
    unsafe { of(result, 0, |r| r.vertex_origins.len()) }
}

/// The number of faces.
///
/// # Safety
/// The pointer is null, or a result that has not been freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn isomend_result_face_count(result: *const ResultHandle) -> usize {
    // SAFETY: as the caller promises.
    unsafe { of(result, 0, |r| r.face_origins.len()) }
}

/// The coordinates of the vertices, three for each, valid until the result is freed.
///
/// # Safety
/// The pointer is null, or a result that has not been freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn isomend_result_vertices(result: *const ResultHandle) -> *const f64 {
    // SAFETY: as the caller promises. A vertex is three numbers in a row, by `repr(C)`.
    unsafe {
        of(result, std::ptr::null(), |r| {
            r.mended.positions().as_ptr().cast()
        })
    }
}

/// Writes the coordinates of the vertices, three for each, rounded to 32 bits, into an array of `capacity` elements.
///
/// # Safety
/// The result has not been freed, and the array has this length.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn isomend_result_vertices_f32(
    result: *const ResultHandle,
    vertices: *mut f32,
    capacity: usize,
) -> Status {
    guarded(|| {
        // SAFETY: as the caller promises.
        let result = unsafe { value(result, "result") }?;
        let positions = result.mended.positions();
        if capacity < 3 * positions.len() {
            let what = format!(
                "vertices has {capacity} elements, but {} are needed",
                3 * positions.len()
            );
            return Err(Failure::new(Status::Argument, what));
        }
        if capacity > 0 {
            check_array(vertices, capacity, "vertices")?;
        }
        for (at, position) in positions.iter().enumerate() {
            let row = position.as_vec3().to_array();
            // SAFETY: the array is long enough. It may be uninitialised, so that it is written by pointer.
            unsafe { vertices.add(3 * at).cast::<[f32; 3]>().write(row) };
        }
        Ok(())
    })
}

/// The vertices of the faces, three for each, valid until the result is freed.
///
/// # Safety
/// The pointer is null, or a result that has not been freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn isomend_result_faces(result: *const ResultHandle) -> *const u32 {
    // SAFETY: as the caller promises.
    unsafe {
        of(result, std::ptr::null(), |r| {
            r.mended.mesh().faces.as_ptr().cast()
        })
    }
}

/// For each vertex its expected error in the mesh's units: 0 for vertices of the input, NaN where there is no estimate. Valid until
/// the result is freed.
///
/// # Safety
/// The pointer is null, or a result that has not been freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn isomend_result_expected_errors(result: *const ResultHandle) -> *const f64 {
    // SAFETY: as the caller promises.
    unsafe { of(result, std::ptr::null(), |r| r.expected_errors.as_ptr()) }
}

/// For each vertex its number in the input, `ISOMEND_NEW` for a new vertex. Valid until the result is freed.
///
/// # Safety
/// The pointer is null, or a result that has not been freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn isomend_result_vertex_origins(result: *const ResultHandle) -> *const u32 {
    // SAFETY: as the caller promises.
    unsafe { of(result, std::ptr::null(), |r| r.vertex_origins.as_ptr()) }
}

/// For each face the face of the input that it is or was made from, `ISOMEND_NEW` for a new face. Valid until the result is freed.
///
/// # Safety
/// The pointer is null, or a result that has not been freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn isomend_result_face_origins(result: *const ResultHandle) -> *const u32 {
    // SAFETY: as the caller promises.
    unsafe { of(result, std::ptr::null(), |r| r.face_origins.as_ptr()) }
}

/// Whether the work is complete: every hole that was to be filled is closed, and a repaired mesh is sound.
///
/// # Safety
/// The pointer is null, or a result that has not been freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn isomend_result_is_complete(result: *const ResultHandle) -> bool {
    // SAFETY: as the caller promises.
    unsafe { of(result, false, |r| r.mended.complete()) }
}

/// Whether it is complete without reservation, as `--strict` of the command line demands it.
///
/// # Safety
/// The pointer is null, or a result that has not been freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn isomend_result_is_flawless(result: *const ResultHandle) -> bool {
    // SAFETY: as the caller promises.
    unsafe {
        of(result, false, |r| {
            r.mended.complete() && r.mended.report.flawless()
        })
    }
}

/// The report as JSON, valid until the result is freed.
///
/// # Safety
/// The pointer is null, or a result that has not been freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn isomend_result_report(result: *const ResultHandle) -> *const c_char {
    // SAFETY: as the caller promises.
    unsafe { of(result, std::ptr::null(), |r| r.report.as_ptr()) }
}

/// Frees a result. A null pointer is left alone.
///
/// # Safety
/// The pointer is null, or a result that has not been freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn isomend_result_free(result: *mut ResultHandle) {
    if !result.is_null() {
        // SAFETY: `mend` made it from a box.
        drop(unsafe { Box::from_raw(result) });
    }
}
