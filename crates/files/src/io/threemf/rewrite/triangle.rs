//! The attributes of a triangle whose corners changed: what is kept of its properties and of its paint.

use std::fmt::Write as _;

use quick_xml::events::{BytesStart, Event};

use super::super::document::is_paint;

/// Which of the attributes of a triangle a new triangle takes over.
#[derive(Clone, Copy)]
pub(super) enum Take {
    /// All: it is the same.
    All,
    /// All except paint that depends on the corners. Each corner has the properties of the given corner of the old triangle.
    Turned([usize; 3]),
    /// All that does not depend on the corners: it is a part of the old triangle.
    Part,
    /// Only paint that does not depend on the corners: it is beside the old triangle.
    Paint,
}

/// Writes the start of a triangle element up to its corners.
pub(super) fn begin(out: &mut String, prefix: &str, [a, b, c]: [u32; 3]) {
    let _ = write!(out, "<{prefix}triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\"");
}

/// What a new triangle did not take over.
pub(super) struct Taken<'t> {
    /// Whether paint was left out.
    pub(super) loses_paint: bool,
    /// Whether properties were left out that differ between the corners.
    pub(super) loses_properties: bool,
    /// The rest of the element from the end of its start tag on.
    pub(super) rest: &'t str,
}

/// Writes the attributes of the triangle element `old` that a new one takes over.
pub(super) fn attributes<'t>(out: &mut String, old: &'t str, take: Take) -> Taken<'t> {
    let mut reader = quick_xml::Reader::from_str(old);
    let event = reader.read_event();
    let rest = match &event {
        Ok(Event::Start(_)) => old.get(reader.buffer_position() as usize - 1..),
        _ => None,
    };
    let (Ok(Event::Start(tag)) | Ok(Event::Empty(tag))) = &event else {
        return Taken {
            loses_paint: false,
            loses_properties: false,
            rest: "/>",
        };
    };
    let (mut loses, varies) = (false, varies(tag));
    for attribute in tag.attributes().flatten() {
        let key = attribute.key.as_ref();
        let local = attribute.key.local_name();
        let (is_paint, value) = (is_paint(local.as_ref()), &attribute.value);
        let is_kept = match (local.as_ref(), take) {
            ("v1" | "v2" | "v3", _) => false,
            (_, Take::All) => true,
            ("p1" | "p2" | "p3", Take::Turned(_)) => false,
            (_, Take::Turned(_)) => !is_paint || is_whole(value),
            ("pid" | "p1" | "p2" | "p3", Take::Part) => !varies,
            (_, Take::Part) => !is_paint || is_whole(value),
            (_, Take::Paint) => is_paint && is_whole(value),
        };
        loses |= is_paint && !is_kept;
        if is_kept {
            let value = value.replace('"', "&quot;");
            let _ = write!(out, " {key}=\"{value}\"");
        }
    }
    if let Take::Turned(corners) = take {
        properties(out, tag, corners);
    }
    Taken {
        loses_paint: loses,
        loses_properties: varies && matches!(take, Take::Part),
        rest: rest.unwrap_or("/>"),
    }
}

/// Whether the corners of a triangle have different properties.
fn varies(tag: &BytesStart<'_>) -> bool {
    let [first, others @ ..] = ["p1", "p2", "p3"].map(|name| value(tag, name));
    others.iter().any(|own| own.is_some() && *own != first)
}

/// The raw value of an attribute.
fn value(tag: &BytesStart<'_>, name: &str) -> Option<String> {
    let found = tag.try_get_attribute(name).ok().flatten()?;
    Some(found.value.to_string())
}

/// Writes the properties of the corners of a turned triangle.
fn properties(out: &mut String, tag: &BytesStart<'_>, corners: [usize; 3]) {
    let Some(first) = value(tag, "p1") else {
        return;
    };
    let others = ["p2", "p3"].map(|name| value(tag, name));
    if others.iter().all(Option::is_none) {
        let _ = write!(out, " p1=\"{first}\"");
        return;
    }
    let [second, third] = others.map(|value| value.unwrap_or_else(|| first.clone()));
    let all = [first, second, third];
    for (number, corner) in (1..).zip(corners) {
        let _ = write!(out, " p{number}=\"{}\"", all[corner % 3]);
    }
}

/// Whether paint is one state for the whole triangle. Slicers write a tree of parts as hexadecimal digits, the root last; the two lower
/// bits of a digit are the number of sides that are split.
fn is_whole(paint: &str) -> bool {
    let root = paint
        .bytes()
        .last()
        .and_then(|digit| (digit as char).to_digit(16));
    root.is_some_and(|root| root & 3 == 0) && paint.bytes().all(|b| b.is_ascii_hexdigit())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kept(old: &str, take: Take) -> (String, bool) {
        let mut out = String::new();
        let taken = attributes(&mut out, old, take);
        (out + taken.rest, taken.loses_paint)
    }

    #[test]
    fn paint_of_a_whole_triangle_stays_on_its_parts() {
        for (paint, whole) in [
            ("4", true),
            ("0C", true),
            ("3FC", true),
            ("4C3", false),
            ("", false),
            ("x4", false),
        ] {
            assert_eq!(is_whole(paint), whole, "{paint}");
        }
        let old = "<triangle v1=\"0\" v2=\"1\" v3=\"2\" pid='5' p1=\"7\" p2=\"8\" paint_color=\"8\" s:mmu_segmentation=\"4C3\" a='\"'/>";
        let (all, loses) = kept(old, Take::All);
        let rest = " paint_color=\"8\" s:mmu_segmentation=\"4C3\" a=\"&quot;\"/>";
        assert_eq!(
            (all, loses),
            (" pid=\"5\" p1=\"7\" p2=\"8\"".to_owned() + rest, false)
        );
        assert_eq!(
            kept(old, Take::Paint),
            (" paint_color=\"8\"/>".to_owned(), true)
        );
        // A part keeps the group only with an index for the whole triangle.
        let part = " paint_color=\"8\" a=\"&quot;\"/>".to_owned();
        assert_eq!(kept(old, Take::Part), (part, true));
        let same = "<triangle v1='0' v2='1' v3='2' pid='5' p1='7' p3='7' face_property='2'/>";
        let all = " pid=\"5\" p1=\"7\" p3=\"7\" face_property=\"2\"/>".to_owned();
        assert_eq!(kept(same, Take::Part), (all, false));
        let turned = " pid=\"5\" paint_color=\"8\" a=\"&quot;\" p1=\"7\" p2=\"7\" p3=\"8\"/>";
        assert_eq!(
            kept(old, Take::Turned([0, 2, 1])),
            (turned.to_owned(), true)
        );
        assert_eq!(
            kept("<k:triangle v1='0'>\n<x/></k:triangle>", Take::Paint).0,
            ">\n<x/></k:triangle>"
        );
    }
}
