//! Questions about a mesh: the check, the inspection, and the parameters of the commands.

use std::ffi::{CStr, CString, c_char};

use isomend_core::check::CheckParams;
use isomend_core::mend::Control;
use isomend_core::parameters::Table;
use isomend_files::job::{
    self, Drawings, JobError, Place, Source, named_params, named_unit, schema,
};
use serde::Serialize;

use crate::mesh::MeshHandle;
use crate::pointers::{check, check_optional, given_away, parameters, set, value};
use crate::run::{RunOptions, run};
use crate::status::{Failure, Status, guarded, text};

/// The name, in messages, of a mesh that was not read from a file.
pub const NO_FILE: &str = "the mesh";

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
        let (mesh, mut given) = unsafe { (value(mesh, "mesh")?, self::parameters(parameters)?) };
        let loaded = mesh.0.clone();
        let work = move |control: &Control| {
            let unit = named_unit(&mut given)?;
            let params: CheckParams = named_params(Table::CHECK, &given)?;
            let source = Source::from(Place::memory(NO_FILE));
            let drawings = Drawings::default();
            let checked = job::check(&source, &loaded, &params, unit, &drawings, control)?;
            Ok((checked.verdict.is_sound(), json_of(&checked.document())))
        };
        // SAFETY: as the caller promises.
        let (answer, document) = unsafe { run(options, work) }?;
        let document = document?;
        // SAFETY: they were checked; the caller promises the rest.
        unsafe {
            set(is_sound, answer);
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
        let (mesh, mut given) = unsafe { (value(mesh, "mesh")?, self::parameters(parameters)?) };
        let loaded = mesh.0.clone();
        let work = move |control: &Control| {
            let unit = named_unit(&mut given)?;
            if let Some(name) = given.keys().next() {
                let what = format!("inspect has no parameter '{name}'; it has unit");
                return Err(JobError::Named { what });
            }
            let source = Source::from(Place::memory(NO_FILE));
            let drawings = Drawings::default();
            let inspected = job::inspect(&source, &loaded, None, unit, &drawings, control)?;
            Ok(json_of(&inspected.document()))
        };
        // SAFETY: as the caller promises.
        let document = unsafe { run(options, work) }??;
        // SAFETY: it was checked; the caller promises the rest.
        unsafe { give(document, report) };
        Ok(())
    })
}

/// Sets `schema` to the JSON schema of the parameters of a command: `fill`, `repair` or `check`.
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
        let known = [Table::FILL, Table::REPAIR, Table::CHECK];
        let table = known
            .iter()
            .find(|t| t.command.as_bytes() == command.to_bytes());
        let table = table.ok_or_else(|| {
            let what = format!("there is no command {command:?}: take fill, repair or check");
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
