//! Remarks on attributes that a format cannot hold and that are left out.

use super::{Contents, Format, Written};

/// Adds the remark for a format that holds no attributes. The marks of patches are not mentioned.
pub(super) fn all(mut written: Written, model: &Contents<'_>, format: Format) -> Written {
    written
        .notes
        .extend(note(&model.attributes.listed(), format));
    written
}

/// The remark that `format` has no place for the attributes in `listed`; none if `listed` is empty.
pub(super) fn note(listed: &str, format: Format) -> Option<String> {
    (!listed.is_empty())
        .then(|| format!("left out, because {format} has no place for it: {listed}"))
}

/// Adds what a file held besides the mesh and its attributes to the remark on what is left out.
pub(super) fn note_rest(written: &mut Written, rest: &[String], format: Format) {
    let listed = rest.join(", ");
    let Some(beginning) = note(&listed, format) else {
        return;
    };
    let start = beginning.trim_end_matches(&listed[..]);
    match written
        .notes
        .iter_mut()
        .find(|note| note.starts_with(start))
    {
        Some(note) => *note += &format!(", {listed}"),
        None => written.notes.push(beginning),
    }
}
