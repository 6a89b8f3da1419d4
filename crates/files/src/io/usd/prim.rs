//! A prim of a composed USD stage: what the layers say of it, in a tree of composition arcs.

use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

use super::layer::{ArcKind, PrimSpec, Property, Value};
use super::places::{LayerFile, Stack};

/// The prims of one stack of layers that contain a prim, from the inside out, and the prim itself.
pub(super) struct Trail {
    first: Rc<PrimSpec>,
    parent: Option<Rc<Trail>>,
}

/// What one stack of layers says of a prim, and the arcs that lead on from there.
pub(super) struct Node {
    /// The arc that leads here.
    pub(super) kind: ArcKind,
    /// The level of the prim whose arc leads here; the arc of a prim is stronger than the arcs of prims that contain it.
    pub(super) from_level: usize,
    /// The number of prims of the stack of layers that contain this one.
    level: usize,
    pub(super) stack: Rc<Stack>,
    /// What the layers say, the strongest first; none if only arcs of the prims round this one lead on.
    pub(super) specs: Vec<(Rc<PrimSpec>, Rc<LayerFile>)>,
    /// The nodes to which the arcs lead, the strongest first.
    pub(super) below: Vec<Node>,
    /// The sets of variants of which the chosen one is among `below`.
    pub(super) chosen: BTreeSet<String>,
    pub(super) trail: Option<Rc<Trail>>,
}

impl Trail {
    /// Whether a spec is of the prim or of one that contains it.
    pub(super) fn has(&self, spec: &Rc<PrimSpec>) -> bool {
        let mut at = Some(self);
        while let Some(trail) = at {
            if Rc::ptr_eq(&trail.first, spec) {
                return true;
            }
            at = trail.parent.as_deref();
        }
        false
    }
}

impl Node {
    pub(super) fn new(
        kind: ArcKind,
        stack: &Rc<Stack>,
        specs: Vec<(Rc<PrimSpec>, Rc<LayerFile>)>,
        parent: Option<&Rc<Trail>>,
    ) -> Self {
        let first = specs.first().map(|(first, _)| Rc::clone(first));
        let trail = first.map(|first| {
            let parent = parent.map(Rc::clone);
            Rc::new(Trail { first, parent })
        });
        Self {
            kind,
            from_level: 0,
            level: 0,
            stack: Rc::clone(stack),
            specs,
            below: Vec::new(),
            chosen: BTreeSet::new(),
            trail: trail.or_else(|| parent.map(Rc::clone)),
        }
    }

    /// Adds a node to which an arc of this one leads.
    pub(super) fn push(&mut self, kind: ArcKind, mut node: Self) {
        node.kind = kind;
        node.from_level = self.level;
        self.below.push(node);
    }

    /// The node of the chosen variant of a set.
    pub(super) fn variant(&self, specs: Vec<(Rc<PrimSpec>, Rc<LayerFile>)>) -> Self {
        let trail = self.trail.as_ref();
        let mut variant = Self::new(ArcKind::Variant, &self.stack, specs, trail);
        variant.level = self.level;
        variant
    }

    /// The tree of the child of a name, before the child's own arcs are followed; `None` if no layer has it.
    pub(super) fn child(&self, name: &str) -> Option<Self> {
        let specs = self.specs.iter();
        let specs =
            specs.filter_map(|(spec, file)| Some((Rc::clone(spec.child(name)?), Rc::clone(file))));
        let below: Vec<Self> = self.below.iter().filter_map(|b| b.child(name)).collect();
        let trail = self.trail.as_ref();
        let mut child = Self::new(self.kind, &self.stack, specs.collect(), trail);
        (child.below, child.level, child.from_level) = (below, self.level + 1, self.from_level);
        (!child.specs.is_empty() || !child.below.is_empty()).then_some(child)
    }

    /// The number of nodes of the tree.
    pub(super) fn size(&self) -> usize {
        1 + self.below.iter().map(Self::size).sum::<usize>()
    }

    /// Sorts the arcs of this node by strength: by their kinds, then by their levels, deeper ones first.
    pub(super) fn sort(&mut self) {
        self.below
            .sort_by_key(|node| (node.kind, std::cmp::Reverse(node.from_level)));
    }

    /// Collects the chosen variant of each set, of the strongest layer that chooses.
    pub(super) fn selections(&self, out: &mut BTreeMap<String, String>) {
        for spec in self.opinions() {
            for (set, name) in &spec.selection {
                if !out.contains_key(set) {
                    out.insert(set.clone(), name.clone());
                }
            }
        }
    }

    /// The number of sets of variants without a chosen one.
    pub(super) fn unchosen(&self) -> usize {
        let variants = self.specs.iter().flat_map(|(spec, _)| &spec.variants);
        let sets: BTreeSet<&String> = variants.map(|(set, ..)| set).collect();
        let own = sets.iter().filter(|set| !self.chosen.contains(**set));
        own.count() + self.below.iter().map(Self::unchosen).sum::<usize>()
    }

    /// What the layers say, the strongest first. What a specialisation leads to is weaker than all else.
    pub(super) fn opinions(&self) -> Vec<Rc<PrimSpec>> {
        let (mut all, mut weakest) = (Vec::new(), vec![self]);
        let mut at = 0;
        while let Some(node) = weakest.get(at) {
            node.gather(&mut all, &mut weakest);
            at += 1;
        }
        all
    }

    fn gather<'a>(&'a self, out: &mut Vec<Rc<PrimSpec>>, weakest: &mut Vec<&'a Self>) {
        out.extend(self.specs.iter().map(|(spec, _)| Rc::clone(spec)));
        for node in &self.below {
            match node.kind {
                ArcKind::Specialize => weakest.push(node),
                _ => node.gather(out, weakest),
            }
        }
    }
}

/// A prim of the stage.
pub(super) struct Prim {
    pub(super) name: String,
    pub(super) node: Node,
    /// What the layers say of it, the strongest first.
    opinions: Vec<Rc<PrimSpec>>,
}

impl Prim {
    pub(super) fn new(name: String, node: Node) -> Self {
        let opinions = node.opinions();
        Self {
            name,
            node,
            opinions,
        }
    }

    /// The names of the children, in the order of the layers.
    pub(super) fn child_names(&self) -> Vec<String> {
        let mut seen = BTreeSet::new();
        let all = self.opinions.iter().flat_map(|spec| &spec.children);
        let names = all.filter(|child| seen.insert(&child.name[..]));
        names.map(|child| child.name.clone()).collect()
    }

    /// The schema.
    pub(super) fn kind(&self) -> &str {
        let mut kinds = self.opinions.iter().map(|spec| &spec.kind[..]);
        kinds.find(|kind| !kind.is_empty()).unwrap_or_default()
    }

    /// Whether the prim belongs to the stage: it is active, and defined rather than a class to inherit from.
    pub(super) fn is_there(&self) -> bool {
        let mut specs = self.opinions.iter();
        let active = specs.clone().find_map(|spec| spec.number("active"));
        let strongest = specs.find(|spec| ["def", "class"].contains(&&spec.specifier[..]));
        strongest.is_some_and(|spec| spec.specifier == "def") && active != Some(0.0)
    }

    /// Metadata of the strongest layer that has it.
    pub(super) fn number(&self, name: &str) -> Option<f64> {
        self.opinions.iter().find_map(|spec| spec.number(name))
    }

    /// Metadata of the strongest layer that has it.
    pub(super) fn text(&self, name: &str) -> Option<&str> {
        self.opinions.iter().find_map(|spec| spec.text(name))
    }

    /// The names of the properties, sorted.
    pub(super) fn property_names(&self) -> Vec<&str> {
        let all = self.opinions.iter().flat_map(|spec| spec.properties.keys());
        let mut names: Vec<&str> = all.map(String::as_str).collect();
        names.sort_unstable();
        names.dedup();
        names
    }

    /// A property, from what all layers say of it.
    pub(super) fn property(&self, name: &str) -> Option<Property> {
        let mut all = self
            .opinions
            .iter()
            .filter_map(|spec| spec.properties.get(name));
        let mut found = all.next()?.clone();
        for weaker in all {
            if found.kind.is_empty() {
                found.kind.clone_from(&weaker.kind);
            }
            if found.value.is_none() && found.sample.is_none() {
                (found.value, found.sample) = (weaker.value.clone(), weaker.sample.clone());
            }
            if found.targets.is_empty() {
                found.targets.clone_from(&weaker.targets);
            }
            found.interpolation = found.interpolation.or_else(|| weaker.interpolation.clone());
            found.element_size = found.element_size.or(weaker.element_size);
            found.unauthored = found.unauthored.or(weaker.unauthored);
        }
        Some(found)
    }

    /// The value of a property: the default, or else the first in time.
    pub(super) fn value(&self, name: &str) -> Option<Value> {
        let property = self.property(name)?;
        property.value.or(property.sample)
    }

    /// The first text of a property.
    pub(super) fn word(&self, name: &str) -> Option<String> {
        self.value(name)?.texts().first().cloned()
    }
}
