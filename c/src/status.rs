//! Status codes, and the message of the last error of each thread.

use std::cell::RefCell;
use std::ffi::{CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};

use isomend_core::mend::FillError;
use isomend_files::job::{JobError, PANICKED, with_causes};

/// How a call ended.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The call did what it was asked for.
    Ok = 0,
    /// The caller stopped it.
    Cancelled = 1,
    /// A pointer is null or misaligned, or a buffer is too small.
    Argument = 2,
    /// A parameter does not exist, has a wrong value, or does not fit the mesh.
    Parameter = 3,
    /// The mesh is invalid.
    Mesh = 4,
    /// A file that a parameter names cannot be read.
    File = 5,
    /// A fault of isomend.
    Internal = 6,
}

/// Why a call failed.
#[derive(Debug)]
pub struct Failure {
    status: Status,
    message: String,
}

impl Failure {
    /// A failure with its message.
    pub fn new(status: Status, message: impl Into<String>) -> Self {
        let message = message.into();
        Self { status, message }
    }

    /// A fault of isomend.
    pub fn internal() -> Self {
        Self::new(Status::Internal, PANICKED)
    }
}

impl From<JobError> for Failure {
    fn from(error: JobError) -> Self {
        let message = with_causes(&error);
        let status = match &error {
            JobError::Fill(error)
            | JobError::Inspect { error, .. }
            | JobError::MaskMesh { error, .. } => match error {
                FillError::Cancelled => Status::Cancelled,
                FillError::Mesh(_) => Status::Mesh,
                _ => Status::Parameter,
            },
            JobError::Io(_) | JobError::IsFolder { .. } => Status::File,
            JobError::TooManyVertices { .. } => Status::Mesh,
            _ => Status::Parameter,
        };
        Self::new(status, message)
    }
}

thread_local! {
    /// The message of the last call of this thread that failed.
    static LAST: RefCell<CString> = RefCell::default();
}

/// Runs the body of a function of the interface. A panic ends here, as a status.
pub fn guarded(body: impl FnOnce() -> Result<(), Failure>) -> Status {
    let done = catch_unwind(AssertUnwindSafe(body));
    match done.unwrap_or_else(|_| Err(Failure::internal())) {
        Ok(()) => Status::Ok,
        Err(Failure { status, message }) => {
            // Destructors of a thread's own data may call when the message is destroyed already; it is then not kept.
            let _ = LAST.try_with(|last| last.replace(text(message)));
            status
        }
    }
}

/// A text for C. Bytes of value zero, which would end it, are left out.
pub fn text(mut text: String) -> CString {
    text.retain(|c| c != '\0');
    CString::new(text).unwrap_or_default()
}

/// The message of the last call of this thread that failed; empty if none did, and while the thread's own data are destroyed at its end.
/// It is valid until the next call that fails.
#[unsafe(no_mangle)]
pub extern "C" fn isomend_last_error() -> *const c_char {
    let last = LAST.try_with(|last| last.borrow().as_ptr());
    last.unwrap_or(c"".as_ptr())
}
