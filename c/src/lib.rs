//! The C interface of isomend: fill, repair, restore, fair, check and inspect triangle meshes in memory.
//!
//! `include/isomend.h` declares and documents the functions; `docs/c.md` is the manual. A test compares the header with this source.
//! Here stands only what C needs: pointers become meshes, parameters by name become jobs (`isomend_files::job`), and errors become codes
//! with a text. No panic leaves a function: [`status::guarded`] stops it.

#[cfg(not(panic = "unwind"))]
compile_error!("the C interface stops panics, which takes panic = \"unwind\"");

mod mask;
mod mended;
mod mesh;
mod pointers;
mod questions;
mod run;
mod status;

use std::ffi::{CStr, c_char};

/// The version of this interface: it changes when a program that was compiled with an older header would go wrong.
pub const ABI_VERSION: u32 = 1;

/// The version of the interface that the library has, to compare with `ISOMEND_ABI_VERSION` of the header.
#[unsafe(no_mangle)]
pub extern "C" fn isomend_abi_version() -> u32 {
    ABI_VERSION
}

/// The version of isomend, such as `0.1.0`.
#[unsafe(no_mangle)]
pub extern "C" fn isomend_version() -> *const c_char {
    const VERSION: &CStr =
        match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
            Ok(text) => text,
            Err(_) => c"",
        };
    VERSION.as_ptr()
}
