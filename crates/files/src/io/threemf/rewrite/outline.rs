//! Finds where the objects of a 3MF model stand in its text.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use quick_xml::events::{BytesStart, Event};

use super::super::model::PATCH_FACES;
use super::super::package::listed;
use super::super::values::number;
use super::edits::value_range;

/// The places of a model's elements in its text, in bytes.
#[derive(Default)]
pub(super) struct Outline {
    /// The start tag of the model.
    pub(super) model: Range<usize>,
    /// The value of its unit.
    pub(super) unit: Option<Range<usize>>,
    /// The prefix of its namespace, with a colon; empty for none.
    pub(super) prefix: String,
    /// Each namespace that its tag declares, with the prefix and a colon.
    pub(super) namespaces: BTreeMap<String, String>,
    /// The prefixes that its tag declares.
    pub(super) prefixes: BTreeSet<String>,
    /// The end of the start tag of its resources.
    pub(super) resources: usize,
    /// The largest number of a resource.
    pub(super) largest_id: u32,
    pub(super) objects: BTreeMap<u32, ObjectOutline>,
}

/// The places of an object's elements in the text of its model.
#[derive(Default)]
pub(super) struct ObjectOutline {
    pub(super) start: Range<usize>,
    /// Whether it has slices, by the attribute that names them.
    pub(super) has_slices: bool,
    /// Whether it has a default property.
    pub(super) has_default: bool,
    /// Where metadata can be added to its group: before the end tag, or the whole element if that has none.
    pub(super) metadata: Option<Range<usize>>,
    /// The list of faces of patches.
    pub(super) marks: Option<Range<usize>>,
    /// Between the tags of the list of vertices, and each vertex.
    pub(super) vertices: Range<usize>,
    pub(super) points: Vec<Range<usize>>,
    /// Between the tags of the list of triangles, and each triangle.
    pub(super) triangles: Range<usize>,
    pub(super) faces: Vec<Range<usize>>,
    /// Comments and processing instructions between these.
    pub(super) comments: Vec<Range<usize>>,
    /// Other elements of the mesh, with their names.
    pub(super) others: Vec<(String, Range<usize>)>,
}

impl ObjectOutline {
    /// The reason why its vertices must keep their numbers.
    pub(super) fn numbered_by(&self) -> String {
        let names: BTreeSet<&String> = self.others.iter().map(|(name, _)| name).collect();
        let names = listed(&Vec::from_iter(names));
        format!("elements may refer to vertices by number: {names}")
    }

    /// Whether its lists hold vertices and triangles only, with blanks and comments between them.
    pub(super) fn is_plain(&self, text: &str) -> bool {
        let is_plain = |list: &Range<usize>, elements: &[Range<usize>]| {
            let comments = self.comments.iter();
            let comments = comments.filter(|c| list.contains(&c.start));
            let mut all: Vec<&Range<usize>> = elements.iter().chain(comments).collect();
            all.sort_unstable_by_key(|range| range.start);
            let ends = all.iter().map(|range| range.end);
            let starts = all.iter().map(|range| range.start);
            let gaps = [list.start].into_iter().chain(ends);
            let mut gaps = gaps.zip(starts.chain([list.end]));
            gaps.all(|(from, to)| text.get(from..to).is_some_and(|gap| gap.trim().is_empty()))
        };
        is_plain(&self.vertices, &self.points) && is_plain(&self.triangles, &self.faces)
    }
}

impl Outline {
    /// The places in a text that was read without a fault before. Vertices and triangles are listed for the `wanted` objects.
    pub(super) fn new(text: &str, wanted: &BTreeSet<u32>) -> Self {
        let mut walk = Walk {
            text,
            wanted,
            outline: Self::default(),
            open: Vec::new(),
            object: None,
        };
        let mut reader = quick_xml::Reader::from_str(text);
        loop {
            let from = reader.buffer_position() as usize;
            let event = reader.read_event();
            let to = reader.buffer_position() as usize;
            match event {
                Err(_) | Ok(Event::Eof) => return walk.outline,
                Ok(Event::Start(tag)) => walk.start(&tag, from..to),
                Ok(Event::Empty(tag)) => {
                    walk.start(&tag, from..to);
                    walk.end(to..to);
                }
                Ok(Event::End(_)) => walk.end(from..to),
                Ok(Event::Comment(_) | Event::PI(_)) => walk.comment(from..to),
                Ok(_) => {}
            }
        }
    }
}

struct Walk<'a> {
    text: &'a str,
    wanted: &'a BTreeSet<u32>,
    outline: Outline,
    /// The open elements: name with prefix, and range of the start tag.
    open: Vec<(String, Range<usize>)>,
    /// The open object of the resources.
    object: Option<u32>,
}

impl Walk<'_> {
    fn start(&mut self, tag: &BytesStart<'_>, range: Range<usize>) {
        let name = tag.name().as_ref().to_owned();
        match self.open.len() {
            0 => self.model(tag, range.clone()),
            1 if self.is_core(&name, "resources") => self.outline.resources = range.end,
            2 => {
                if let Some(id) = number(tag, "id") {
                    self.outline.largest_id = self.outline.largest_id.max(id);
                }
                if let Some(id) = number(tag, "id").filter(|_| self.is_core(&name, "object")) {
                    let has = |wanted: &str| {
                        let mut names = tag.attributes().flatten().map(|a| a.key.local_name());
                        names.any(|name| name.as_ref() == wanted)
                    };
                    let own = ObjectOutline {
                        start: range.clone(),
                        has_slices: has("slicestackid"),
                        has_default: has("pid"),
                        ..ObjectOutline::default()
                    };
                    self.outline.objects.insert(id, own);
                    self.object = Some(id);
                }
            }
            _ => {}
        }
        let is_mark = self.is_core(&name, "metadata") && {
            let name = tag.try_get_attribute("name").ok().flatten();
            name.is_some_and(|name| name.value == PATCH_FACES)
        };
        let name = if is_mark {
            PATCH_FACES.to_owned()
        } else {
            name
        };
        self.open.push((name, range));
    }

    fn model(&mut self, tag: &BytesStart<'_>, range: Range<usize>) {
        let prefix = tag.name().prefix().map(|prefix| prefix.as_ref().to_owned());
        let outline = &mut self.outline;
        outline.prefix = prefix.map_or_else(String::new, |prefix| prefix + ":");
        outline.model = range;
        outline.unit = value_range(self.text, tag, "unit");
        for attribute in tag.attributes().flatten() {
            if let Some(prefix) = attribute.key.as_ref().strip_prefix("xmlns:") {
                let namespace = attribute.value.to_string();
                outline.prefixes.insert(prefix.to_owned());
                (outline.namespaces).insert(namespace, format!("{prefix}:"));
            }
        }
    }

    /// Lists a comment or a processing instruction between the elements of a list of a wanted object.
    fn comment(&mut self, range: Range<usize>) {
        let Some(id) = self.object.filter(|id| self.wanted.contains(id)) else {
            return;
        };
        let core = |depth: usize| {
            let open: Option<&(String, _)> = self.open.get(depth);
            open.map_or("", |(name, _)| core_name(name, &self.outline.prefix))
        };
        let is_in_list = self.open.len() == 5 && core(3) == "mesh";
        let is_in_list = is_in_list && ["vertices", "triangles"].contains(&core(4));
        let own = self.outline.objects.get_mut(&id);
        if let Some(own) = own.filter(|_| is_in_list) {
            own.comments.push(range);
        }
    }

    /// Ends the last open element; `end` is the range of its end tag.
    fn end(&mut self, end: Range<usize>) {
        let Some((name, start)) = self.open.pop() else {
            return;
        };
        let depth = self.open.len();
        if depth == 2 {
            self.object = None;
        }
        // Model, resources, object, mesh, list: nothing is looked for further inside.
        if !(3..=5).contains(&depth) {
            return;
        }
        let Outline {
            prefix, objects, ..
        } = &mut self.outline;
        let parent = |depth: usize| {
            let open = self.open.get(depth);
            open.map_or("", |(name, _)| core_name(name, prefix))
        };
        let is_wanted = self.object.is_some_and(|id| self.wanted.contains(&id));
        let whole = start.start..end.end;
        let inner = start.end..end.start.max(start.end);
        let Some(own) = self.object.and_then(|id| objects.get_mut(&id)) else {
            return;
        };
        match (depth, parent(3), parent(4), core_name(&name, prefix)) {
            (3, ..) | (4, "metadatagroup", ..) if name == PATCH_FACES => own.marks = Some(whole),
            (3, .., "metadatagroup") if end.is_empty() => own.metadata = Some(whole),
            (3, .., "metadatagroup") => own.metadata = Some(end.start..end.start),
            (4, "mesh", _, "vertices") => own.vertices = inner,
            (4, "mesh", _, "triangles") => own.triangles = inner,
            (4, "mesh", ..) => own.others.push((name, whole)),
            (5, "mesh", "vertices", "vertex") if is_wanted => own.points.push(whole),
            (5, "mesh", "triangles", "triangle") if is_wanted => own.faces.push(whole),
            _ => {}
        }
    }

    fn is_core(&self, name: &str, core: &str) -> bool {
        name.strip_prefix(&self.outline.prefix[..]) == Some(core)
    }
}

/// A name without the prefix of the core namespace; empty for a name with another.
fn core_name<'n>(name: &'n str, prefix: &str) -> &'n str {
    name.strip_prefix(prefix).unwrap_or_default()
}
