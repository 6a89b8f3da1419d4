//! The WebAssembly module: the command line and the local page, for JavaScript.
//!
//! Strings and bytes pass through the module's memory. The caller takes a buffer with [`isomend_take`] and fills it; the function that
//! is given the buffer frees it. What a function leaves for the caller is at [`isomend_left`]. Files are WASI files
//! (`wasm32-wasip1`), which JavaScript keeps in memory.
#![cfg(target_family = "wasm")]

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use isomend::in_browser::{CommandLine, InBrowser};

/// The folder of the files.
const ROOT: &str = "/";

#[link(wasm_import_module = "isomend")]
unsafe extern "C" {
    /// Receives an event of a page: its number, and address and length of the text.
    fn event(page: usize, text: *const u8, length: usize);
    /// Receives the share of a command's work that is done, from 0 to 1.
    fn progress(share: f64);
}

/// What the last call left for the caller: text or bytes, and their media type.
static LEFT: Mutex<[Vec<u8>; 2]> = Mutex::new([Vec::new(), Vec::new()]);

/// A buffer of `length` bytes for the caller to fill.
#[unsafe(no_mangle)]
pub extern "C" fn isomend_take(length: usize) -> *mut u8 {
    Box::leak(vec![0; length].into_boxed_slice()).as_mut_ptr()
}

/// Address of what the last call left: 0 for its bytes, 1 for their media type.
#[unsafe(no_mangle)]
pub extern "C" fn isomend_left(which: usize) -> *const u8 {
    left()[which].as_ptr()
}

/// Length of what the last call left, in bytes.
#[unsafe(no_mangle)]
pub extern "C" fn isomend_left_length(which: usize) -> usize {
    left()[which].len()
}

/// Runs the command line with the arguments in the buffer, a JSON array of strings. Returns the exit code.
///
/// # Safety
/// The buffer comes from [`isomend_take`] with the same length.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn isomend_run(buffer: *mut u8, length: usize) -> u32 {
    // SAFETY: as the caller promises.
    let text = unsafe { given(buffer, length) };
    let Ok(arguments) = serde_json::from_slice::<Vec<String>>(&text) else {
        return 2;
    };
    isomend::in_browser::report_progress(|share| {
        // SAFETY: the function takes a number.
        unsafe { progress(share) }
    });
    let arguments = ["isomend".to_owned()].into_iter().chain(arguments);
    u32::from(isomend::command_line(arguments.map(OsString::from)).code())
}

/// Opens the file that the buffer names. Returns the number of its page, or -1 and leaves the error. The steps of an earlier session
/// are repeated if `resume` is not 0 and they can be read.
///
/// # Safety
/// The buffer comes from [`isomend_take`] with the same length.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn isomend_open(buffer: *mut u8, length: usize, resume: u32) -> i32 {
    // SAFETY: as the caller promises.
    let name = unsafe { given(buffer, length) };
    let name = String::from_utf8_lossy(&name).into_owned();
    let opened = pages().and_then(|pages| pages.open(&Path::new(ROOT).join(name), resume != 0));
    match opened {
        Ok(page) => page as i32,
        Err(error) => {
            leave(error.into_bytes(), "text/plain");
            -1
        }
    }
}

/// Answers a request to a page: `path` is relative to the page, as `api/state`. A request with a media type is a POST request with the
/// body. Returns the HTTP status and leaves the body.
///
/// # Safety
/// The buffers come from [`isomend_take`] with the same lengths.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn isomend_answer(
    page: usize,
    path: *mut u8,
    path_length: usize,
    media_type: *mut u8,
    media_type_length: usize,
    body: *mut u8,
    body_length: usize,
) -> u32 {
    // SAFETY: as the caller promises.
    let [path, media_type, body] = unsafe {
        [
            given(path, path_length),
            given(media_type, media_type_length),
            given(body, body_length),
        ]
    };
    let [path, media_type] = [path, media_type].map(|b| String::from_utf8_lossy(&b).into_owned());
    let body = (!media_type.is_empty()).then_some((media_type.as_str(), body));
    match pages() {
        Ok(pages) => {
            let answer = pages.answer(page, &path, body);
            leave(answer.body, &answer.media_type);
            u32::from(answer.status)
        }
        Err(error) => {
            leave(error.into_bytes(), "text/plain");
            500
        }
    }
}

/// Runs one job that a request has started; 0 if there is none.
#[unsafe(no_mangle)]
pub extern "C" fn isomend_work() -> u32 {
    u32::from(pages().is_ok_and(|pages| pages.work()))
}

/// The pages, which the first call sets up.
fn pages() -> Result<Arc<InBrowser>, String> {
    static PAGES: OnceLock<Result<Arc<InBrowser>, String>> = OnceLock::new();
    let new = || {
        let pages = InBrowser::new(PathBuf::from(ROOT), Arc::new(CommandLine), tell);
        pages.map_err(|error| error.to_string())
    };
    PAGES.get_or_init(new).clone()
}

/// Passes an event on to JavaScript.
fn tell(page: usize, text: &str) {
    // SAFETY: the text is valid while the function runs; it only reads it.
    unsafe { event(page, text.as_ptr(), text.len()) }
}

/// The bytes of a buffer, which is freed with them.
///
/// # Safety
/// The buffer comes from [`isomend_take`] with the same length.
unsafe fn given(buffer: *mut u8, length: usize) -> Vec<u8> {
    // SAFETY: it was made as a boxed slice of this length.
    unsafe { Vec::from_raw_parts(buffer, length, length) }
}

fn leave(bytes: Vec<u8>, media_type: &str) {
    *left() = [bytes, media_type.as_bytes().to_vec()];
}

fn left() -> std::sync::MutexGuard<'static, [Vec<u8>; 2]> {
    LEFT.lock().unwrap_or_else(PoisonError::into_inner)
}
