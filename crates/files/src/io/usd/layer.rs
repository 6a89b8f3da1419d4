//! The content of one USD layer, as text and binary files give it: prims with properties, before references are followed.

use std::cell::OnceCell;
use std::collections::BTreeMap;
use std::rc::Rc;

/// A value of a property or of metadata.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    /// Numbers, truth values and times; vectors, quaternions and matrices are flattened. Quaternions have their real part first.
    Numbers(Rc<Vec<f64>>),
    /// Strings, tokens and names of files.
    Texts(Rc<Vec<String>>),
    /// Anything that is not needed.
    Other,
}

impl Value {
    /// The numbers; none for other values.
    pub(super) fn numbers(&self) -> &[f64] {
        match self {
            Self::Numbers(numbers) => numbers,
            _ => &[],
        }
    }

    /// The strings; none for other values.
    pub(super) fn texts(&self) -> &[String] {
        match self {
            Self::Texts(texts) => texts,
            _ => &[],
        }
    }
}

/// An attribute or a relationship.
#[derive(Clone, Debug, Default)]
pub(super) struct Property {
    /// The type of its values, for example `point3f[]`; empty for a relationship, or if this layer does not say.
    pub(super) kind: String,
    /// The default value.
    pub(super) value: Option<Value>,
    /// The first value in time.
    pub(super) sample: Option<Value>,
    pub(super) interpolation: Option<String>,
    /// The number of elements for each item.
    pub(super) element_size: Option<f64>,
    /// The place of a value that stands for none (`unauthoredValuesIndex`).
    pub(super) unauthored: Option<f64>,
    /// The paths that a relationship refers to.
    pub(super) targets: Vec<String>,
}

/// A reference to a prim of this layer or of another one, whose content is used here.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Arc {
    /// The file; empty for this layer.
    pub(super) asset: String,
    /// The prim; empty for the default prim.
    pub(super) path: String,
}

/// Kinds of composition arcs, the strongest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum ArcKind {
    /// The layers of the stage themselves.
    Root,
    Inherit,
    Variant,
    Reference,
    Payload,
    Specialize,
}

impl ArcKind {
    /// The kinds that lead to another prim.
    pub(super) const REFERENCES: [Self; 4] = [
        Self::Inherit,
        Self::Reference,
        Self::Payload,
        Self::Specialize,
    ];

    /// The kind of a field of a text or binary layer.
    pub(super) fn of_field(name: &str) -> Option<Self> {
        match name {
            "inherits" | "inheritPaths" => Some(Self::Inherit),
            "references" => Some(Self::Reference),
            "payload" => Some(Self::Payload),
            "specializes" => Some(Self::Specialize),
            _ => None,
        }
    }
}

/// What a list of a layer does to the lists of weaker layers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ListOp {
    /// It takes its place.
    Explicit,
    Prepend,
    Append,
    Delete,
}

/// A list of references of one kind.
#[derive(Clone, Debug)]
pub(super) struct ArcList {
    pub(super) kind: ArcKind,
    pub(super) op: ListOp,
    pub(super) items: Vec<Arc>,
}

/// What a layer says of a prim. The prim without a name is the layer itself.
#[derive(Clone, Debug, Default)]
pub(super) struct PrimSpec {
    pub(super) name: String,
    /// The schema, for example `Mesh`; empty if this layer does not say.
    pub(super) kind: String,
    /// `def`, `over` or `class`.
    pub(super) specifier: String,
    /// Metadata in parentheses, by name.
    pub(super) metadata: BTreeMap<String, Value>,
    pub(super) properties: BTreeMap<String, Property>,
    pub(super) children: Vec<Rc<PrimSpec>>,
    pub(super) arcs: Vec<ArcList>,
    /// The variants: set, name and what the variant says of the prim.
    pub(super) variants: Vec<(String, String, Rc<PrimSpec>)>,
    /// The chosen variant of each set.
    pub(super) selection: BTreeMap<String, String>,
    /// The places of the children, sorted by name when a child is first looked up.
    pub(super) by_name: OnceCell<Vec<u32>>,
}

impl PrimSpec {
    /// The first child of a name. The children may not change after the first call.
    pub(super) fn child(&self, name: &str) -> Option<&Rc<PrimSpec>> {
        let by_name = self.by_name.get_or_init(|| {
            let mut places: Vec<u32> = (0..self.children.len() as u32).collect();
            places.sort_by_key(|place| &self.children[*place as usize].name);
            places
        });
        let at = by_name.partition_point(|place| *self.children[*place as usize].name < *name);
        let found = self.children.get(*by_name.get(at)? as usize)?;
        (found.name == name).then_some(found)
    }

    /// The first text of metadata.
    pub(super) fn text(&self, name: &str) -> Option<&str> {
        self.metadata.get(name)?.texts().first().map(String::as_str)
    }

    /// The first number of metadata.
    pub(super) fn number(&self, name: &str) -> Option<f64> {
        self.metadata.get(name)?.numbers().first().copied()
    }
}

/// Whether the values of a property are needed.
pub(super) fn is_used(name: &str) -> bool {
    const NAMES: [&str; 15] = [
        "points",
        "faceVertexCounts",
        "faceVertexIndices",
        "holeIndices",
        "normals",
        "orientation",
        "indices",
        "elementType",
        "familyName",
        "visibility",
        "purpose",
        "subdivisionScheme",
        "xformOpOrder",
        "material:binding",
        "skel:skeleton",
    ];
    NAMES.contains(&name)
        || ["primvars:", "xformOp:", "material:binding:", "inputs:"]
            .iter()
            .any(|start| name.starts_with(start))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_child_of_a_name_is_found() {
        let mut parent = PrimSpec::default();
        for (name, kind) in [("b", "1"), ("a", "2"), ("b", "3"), ("c", "4")] {
            parent.children.push(Rc::new(PrimSpec {
                name: name.to_owned(),
                kind: kind.to_owned(),
                ..PrimSpec::default()
            }));
        }
        let kind = |name| parent.child(name).map(|child| &child.kind[..]);
        assert_eq!(
            ["a", "b", "c", "d", ""].map(kind),
            [Some("2"), Some("1"), Some("4"), None, None]
        );
    }
}
