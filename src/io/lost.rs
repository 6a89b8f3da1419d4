//! Remarks on attributes that a format cannot hold.

use super::{Contents, Format, Written};

/// Adds a remark when there are attributes at all, marks of patches not counted.
pub(super) fn all(mut written: Written, model: &Contents<'_>, format: Format) -> Written {
    written
        .notes
        .extend(note(&model.attributes.listed(), format));
    written
}

/// The remark that a format cannot hold what is listed, if anything is.
pub(super) fn note(listed: &str, format: Format) -> Option<String> {
    (!listed.is_empty())
        .then(|| format!("left out, because {format} has no place for it: {listed}"))
}
