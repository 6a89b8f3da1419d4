//! Reads the template of a fill (option `like`) from its file.

use std::borrow::Cow;
use std::path::Path;
use std::sync::Arc;

use super::JobError;
use crate::io::read_path;
use isomend_core::fill::{FillParams, Like};

/// The parameters of a fill, with the template read if they name a file.
pub(super) fn with_template(params: &FillParams) -> Result<Cow<'_, FillParams>, JobError> {
    let Some(file) = params.like.as_ref().and_then(Like::unread) else {
        return Ok(Cow::Borrowed(params));
    };
    let loaded = read_path(Path::new(file), None)?;
    let mut params = params.clone();
    params.like = Some(Like::template(file.clone(), Arc::new(loaded.mesh)));
    Ok(Cow::Owned(params))
}
