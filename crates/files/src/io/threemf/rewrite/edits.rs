//! Replaces parts of a text, and finds the values of attributes in the text of an XML tag.

use std::ops::Range;

use quick_xml::events::BytesStart;

/// Replacements of ranges of a text. They must not overlap.
#[derive(Default)]
pub(super) struct Edits(Vec<(Range<usize>, String)>);

impl Edits {
    /// Replaces a range of bytes.
    pub(super) fn replace(&mut self, range: Range<usize>, text: impl Into<String>) {
        self.0.push((range, text.into()));
    }

    /// Inserts a text. Of several at one place, the first comes first.
    pub(super) fn insert(&mut self, place: usize, text: impl Into<String>) {
        self.replace(place..place, text);
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The text with all replacements.
    pub(super) fn applied(mut self, text: &str) -> String {
        self.0.sort_by_key(|(range, _)| (range.start, range.end));
        let mut out = String::with_capacity(text.len());
        let mut done = 0;
        for (range, new) in &self.0 {
            out.push_str(text.get(done..range.start).unwrap_or_default());
            out.push_str(new);
            done = done.max(range.end);
        }
        out.push_str(text.get(done..).unwrap_or_default());
        out
    }
}

/// The range in `text` of an attribute's raw value. The tag must have been read from the text.
pub(super) fn value_range(text: &str, tag: &BytesStart<'_>, name: &str) -> Option<Range<usize>> {
    let found = tag.try_get_attribute(name).ok().flatten()?;
    // A value that the reader borrows lies in the text.
    let start = (found.value.as_ptr() as usize).checked_sub(text.as_ptr() as usize)?;
    let range = start..start + found.value.len();
    (text.get(range.clone())? == &found.value[..]).then_some(range)
}

#[cfg(test)]
mod tests {
    use super::*;
    use quick_xml::events::Event;

    #[test]
    fn values_are_found_and_replaced_in_place() {
        let text = "<a>\n<b k:x = '1' x=\"22\"/></a>";
        let mut reader = quick_xml::Reader::from_str(text);
        let mut edits = Edits::default();
        loop {
            match reader.read_event().unwrap() {
                Event::Eof => break,
                Event::Empty(tag) => {
                    let range = value_range(text, &tag, "x").unwrap();
                    edits.replace(range, "333");
                    assert!(value_range(text, &tag, "y").is_none());
                }
                _ => {}
            }
        }
        edits.insert(3, "!");
        assert_eq!(edits.applied(text), "<a>!\n<b k:x = '1' x=\"333\"/></a>");
    }
}
