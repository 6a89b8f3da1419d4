//! The content of one USD layer, as text and binary files give it: prims with properties, before references are followed.

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
    pub(super) arcs: Vec<Arc>,
    /// The variants: set, name and what the variant says of the prim.
    pub(super) variants: Vec<(String, String, Rc<PrimSpec>)>,
    /// The chosen variant of each set.
    pub(super) selection: BTreeMap<String, String>,
}

impl PrimSpec {
    /// The child of a name.
    pub(super) fn child(&self, name: &str) -> Option<&Rc<PrimSpec>> {
        self.children.iter().find(|child| child.name == name)
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
