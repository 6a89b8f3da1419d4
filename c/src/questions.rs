//! Questions about a mesh: the check, the inspection, and the parameters of the commands.

use std::ffi::{CStr, CString, c_char};

use isomend_core::mend::Control;
use isomend_core::parameters::Table;
use isomend_files::job::{JobError, JobSpec, MaskSpec, Place, named_work, schema};
use serde::Serialize;
use serde_json::{Map, Value};

use crate::mesh::MeshHandle;
use crate::pointers::{check, check_optional, given_away, parameters, set, value};
use crate::run::{RunOptions, run};
use crate::status::{Failure, Status, guarded, text};

/// The name, in messages, of a mesh that was not read from a file.
const NO_FILE: &str = "the mesh";

/// Checks a mesh for defects. `is_sound` is set to the answer, `report` to the report as JSON; each may be null.
///
/// # Safety
/// The mesh has not been freed, `parameters` is null or a text, `options` is null or valid, `is_sound` and `report` are null or can be
/// written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn isomend_check(
    mesh: *const MeshHandle,
    parameters: *const c_char,
    options: *const RunOptions,
    is_sound: *mut bool,
    report: *mut *mut c_char,
) -> Status {
    guarded(|| {
        check_optional(is_sound, "is_sound")?;
        check_optional(report, "report")?;
        // SAFETY: as the caller promises.
        let (is_good, document) = unsafe { look("check", mesh, parameters, options) }?;
        // SAFETY: they were checked; the caller promises the rest.
        unsafe {
            set(is_sound, is_good);
            give(document, report);
        }
        Ok(())
    })
}

/// Lists the components, the holes and the defects of a mesh. `report` is set to the report as JSON.
///
/// # Safety
/// The mesh has not been freed, `parameters` is null or a text, `options` is null or valid, `report` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn isomend_inspect(
    mesh: *const MeshHandle,
    parameters: *const c_char,
    options: *const RunOptions,
    report: *mut *mut c_char,
) -> Status {
    guarded(|| {
        check(report, "report")?;
        // SAFETY: as the caller promises.
        let (_, document) = unsafe { look("inspect", mesh, parameters, options) }?;
        // SAFETY: it was checked; the caller promises the rest.
        unsafe { give(document, report) };
        Ok(())
    })
}

/// The answer of a command that only looks at a mesh, and its report.
///
/// # Safety
/// As for `isomend_inspect`.
unsafe fn look(
    command: &'static str,
    mesh: *const MeshHandle,
    given: *const c_char,
    options: *const RunOptions,
) -> Result<(bool, CString), Failure> {
    // SAFETY: as the caller promises.
    let (mesh, given) = unsafe { (value(mesh, "mesh")?, parameters(given)?) };
    let loaded = mesh.0.clone();
    let work = move |control: &Control| {
        let spec = spec(command, None, given)?;
        let read = spec.with(loaded);
        let looked = read.look(control)?;
        Ok((looked.is_good(), json_of(&looked.document())))
    };
    // SAFETY: as the caller promises.
    let (is_good, document) = unsafe { run(options, work) }?;
    Ok((is_good, document?))
}

/// The job of a command on a mesh in memory.
pub fn spec(
    command: &str,
    mask: Option<MaskSpec>,
    given: Map<String, Value>,
) -> Result<JobSpec, JobError> {
    let (work, deliverables) = named_work(command, mask, given)?;
    let mut spec = JobSpec::plan(Place::memory(NO_FILE), work);
    spec.deliverables = deliverables;
    Ok(spec)
}

/// Sets `schema` to the JSON schema of the parameters of a command: `fill`, `repair`, `restore`, `fair` or `check`.
///
/// # Safety
/// `command` is null or a text, `schema` can be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn isomend_parameters(
    command: *const c_char,
    schema: *mut *mut c_char,
) -> Status {
    guarded(|| {
        check(command, "command")?;
        check(schema, "schema")?;
        // SAFETY: it is not null; the caller promises the rest.
        let command = unsafe { CStr::from_ptr(command) };
        let known = [
            Table::FILL,
            Table::REPAIR,
            Table::RESTORE,
            Table::FAIR,
            Table::CHECK,
        ];
        let table = known
            .iter()
            .find(|t| t.command.as_bytes() == command.to_bytes());
        let table = table.ok_or_else(|| {
            let what = format!(
                "there is no command {command:?}: take fill, repair, restore, fair or check"
            );
            Failure::new(Status::Parameter, what)
        })?;
        let document = json_of(&self::schema(table))?;
        // SAFETY: it was checked; the caller promises the rest.
        unsafe { give(document, schema) };
        Ok(())
    })
}

/// A document as JSON.
pub fn json_of(document: &impl Serialize) -> Result<CString, Failure> {
    let json = serde_json::to_string(document);
    Ok(text(json.map_err(|_| Failure::internal())?))
}

/// Gives a text to the caller; nothing is done for a null pointer.
///
/// # Safety
/// As for [`set`].
unsafe fn give(text: CString, to: *mut *mut c_char) {
    if !to.is_null() {
        // SAFETY: as the caller promises.
        unsafe { set(to, given_away(text)) };
    }
}
