//! Pointers of the caller: checked as far as they can be, then references, slices and texts.

use std::ffi::{CStr, CString, c_char};

use serde_json::{Map, Value};

use crate::status::{Failure, Status};

/// The value behind a pointer of the caller.
///
/// # Safety
/// The pointer is null, or points to a value that lives and is not changed while the reference is used.
pub unsafe fn value<'a, T>(at: *const T, name: &str) -> Result<&'a T, Failure> {
    check(at, name)?;
    // SAFETY: it is neither null nor misaligned; the caller promises the rest.
    Ok(unsafe { &*at })
}

/// The value behind a pointer of the caller; none for a null pointer.
///
/// # Safety
/// As for [`value`].
pub unsafe fn optional<'a, T>(at: *const T, name: &str) -> Result<Option<&'a T>, Failure> {
    match at.is_null() {
        true => Ok(None),
        // SAFETY: as the caller promises.
        false => unsafe { value(at, name) }.map(Some),
    }
}

/// Refuses the pointer to a result that is misaligned; a null pointer means that the result is not wanted. It is called before the work, so
/// that no result is set if one of the pointers is wrong.
pub fn check_optional<T>(at: *mut T, name: &str) -> Result<(), Failure> {
    match at.is_null() {
        true => Ok(()),
        false => check(at, name),
    }
}

/// Sets a result; nothing is done for a null pointer. The memory may be uninitialised, so that no reference to it is made.
///
/// # Safety
/// The pointer is null, or is aligned and points to memory that may be written.
pub unsafe fn set<T>(at: *mut T, result: T) {
    if !at.is_null() {
        // SAFETY: as the caller promises.
        unsafe { at.write(result) };
    }
}

/// An array of the caller.
///
/// # Safety
/// The pointer is null, or points to `count` values that live and are not changed while the slice is used.
pub unsafe fn array<'a, T>(at: *const T, count: usize, name: &str) -> Result<&'a [T], Failure> {
    if count == 0 {
        return Ok(&[]);
    }
    check_array(at, count, name)?;
    // SAFETY: it is neither null nor misaligned, and not longer than an object can be; the caller promises the rest.
    Ok(unsafe { std::slice::from_raw_parts(at, count) })
}

/// The parameters by name: a JSON object as text; a null pointer or an empty text for no parameters.
///
/// # Safety
/// The pointer is null, or points to a text that ends in a zero byte.
pub unsafe fn parameters(at: *const c_char) -> Result<Map<String, Value>, Failure> {
    if at.is_null() {
        return Ok(Map::new());
    }
    // SAFETY: as the caller promises.
    let text = unsafe { CStr::from_ptr(at) }.to_bytes();
    if text.trim_ascii().is_empty() {
        return Ok(Map::new());
    }
    serde_json::from_slice(text).map_err(|error| {
        let what = format!("the parameters are no JSON object such as {{\"holes\": [1]}}: {error}");
        Failure::new(Status::Parameter, what)
    })
}

/// A text that the caller frees with `isomend_text_free`.
pub fn given_away(text: CString) -> *mut c_char {
    text.into_raw()
}

/// Frees a text that a function of the interface gave to the caller. A null pointer is left alone.
///
/// # Safety
/// The pointer is null, or came from the interface and has not been freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn isomend_text_free(text: *mut c_char) {
    if !text.is_null() {
        // SAFETY: `given_away` made it.
        drop(unsafe { CString::from_raw(text) });
    }
}

/// Refuses null and misaligned pointers, and arrays that are longer than an object can be.
pub fn check_array<T>(at: *const T, count: usize, name: &str) -> Result<(), Failure> {
    check(at, name)?;
    if count > isize::MAX as usize / size_of::<T>().max(1) {
        let what = format!("{name}: {count} elements are more than memory can hold");
        return Err(Failure::new(Status::Argument, what));
    }
    Ok(())
}

/// Refuses null and misaligned pointers.
pub fn check<T>(at: *const T, name: &str) -> Result<(), Failure> {
    let what = match () {
        () if at.is_null() => format!("{name} is a null pointer"),
        () if !at.is_aligned() => format!("{name} is not aligned to {} bytes", align_of::<T>()),
        () => return Ok(()),
    };
    Err(Failure::new(Status::Argument, what))
}
