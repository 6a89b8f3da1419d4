//! Attributes that a format cannot hold: converted to others that it can, or left out with a remark.

use std::borrow::Cow;

use isomend_core::mesh::Attributes;
use isomend_core::mesh::attributes::CornerAttribute;

use super::{Contents, Format, Written};

impl<'a> Contents<'a> {
    /// The attributes, in which the wanted attributes of corners become attributes of vertices where all corners at a vertex agree.
    pub(super) fn with_vertex_values(
        &self,
        wanted: impl Fn(&CornerAttribute) -> bool,
    ) -> Cow<'a, Attributes> {
        if !self.attributes.corner.iter().any(&wanted) {
            return Cow::Borrowed(self.attributes);
        }
        let mut all = self.attributes.clone();
        for corner in std::mem::take(&mut all.corner) {
            match corner.per_vertex(self.mesh).filter(|_| wanted(&corner)) {
                Some(attribute) => all.vertex.push(attribute),
                None => all.corner.push(corner),
            }
        }
        Cow::Owned(all)
    }
}

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
