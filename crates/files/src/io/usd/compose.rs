//! Composes the layers of a USD stage by the strength of their arcs: what a layer says itself, then inherited classes, variants,
//! references, payloads and specialised classes.
//!
//! Each prim has a tree of arcs. The tree of a child is the tree of its parent, one name further, with the arcs of the child added.

use std::collections::{BTreeMap, HashSet};
use std::rc::Rc;

use super::super::IoError;
use super::layer::{ArcKind, ArcList, ListOp};
use super::layers::{DEEPEST, Layers, NAME, OPINION};
use super::places::{LayerFile, Place, Stack};
use super::prim::{Node, Prim, Trail};

/// An arc of a prim, the layer that has it, and the place of the layer that it leads to.
struct Lead {
    asset: String,
    path: String,
    home: Rc<LayerFile>,
    place: Place,
}

impl Layers<'_> {
    /// The prim without a name of the stage: the main layer and its sublayers.
    pub(super) fn root(&mut self, bytes: &[u8]) -> Result<Prim, IoError> {
        let stack = self.main_stack(bytes)?;
        Ok(Prim::new(String::new(), top(&stack, ArcKind::Root)))
    }

    /// The children of a prim, in the order of the layers.
    pub(super) fn children(&mut self, prim: &Prim) -> Result<Vec<Prim>, IoError> {
        let mut children = Vec::new();
        for name in prim.child_names() {
            let Some(mut node) = prim.node.child(&name) else {
                continue;
            };
            self.complete(&mut node, &mut Vec::new())?;
            children.push(Prim::new(name, node));
        }
        Ok(children)
    }
}

/// The node of the prim without a name of a stack of layers.
fn top(stack: &Rc<Stack>, kind: ArcKind) -> Node {
    let specs = stack.layers.iter();
    let specs = specs.map(|file| (Rc::clone(&file.root), Rc::clone(file)));
    Node::new(kind, stack, specs.collect(), None)
}

/// An arc of one kind, in the order of strength, as the lists of the layers from the weakest to the strongest make them.
fn leads(node: &Node, kind: ArcKind) -> Vec<Lead> {
    let mut all: Vec<Lead> = Vec::new();
    for (spec, home) in node.specs.iter().rev() {
        for list in spec.arcs.iter().filter(|list| list.kind == kind) {
            apply(list, home, &mut all);
        }
    }
    all
}

/// Applies a list of a layer to the arcs of the weaker layers.
fn apply(list: &ArcList, home: &Rc<LayerFile>, all: &mut Vec<Lead>) {
    let mut seen: HashSet<(Place, &str)> = HashSet::new();
    let mut own = Vec::new();
    for arc in &list.items {
        let place = match arc.asset.is_empty() {
            true => Place::default(),
            false => home.place.joined(&arc.asset),
        };
        if seen.insert((place.clone(), &arc.path)) {
            own.push(Lead {
                asset: arc.asset.clone(),
                path: arc.path.clone(),
                home: Rc::clone(home),
                place,
            });
        }
    }
    all.retain(|lead| !seen.contains(&(lead.place.clone(), &lead.path)));
    match list.op {
        ListOp::Explicit => *all = own,
        ListOp::Prepend => _ = all.splice(0..0, own),
        ListOp::Append => all.extend(own),
        ListOp::Delete => {}
    }
}

impl Layers<'_> {
    /// Follows all arcs of a prim, whose node has the arcs of the prims that contain it.
    fn complete(&mut self, node: &mut Node, open: &mut Vec<Rc<Trail>>) -> Result<(), IoError> {
        self.follow(node, open)?;
        // The variant of one set may choose the variant of another one.
        for _ in 0..DEEPEST {
            let mut selection = BTreeMap::new();
            node.selections(&mut selection);
            self.budget.spend(NAME * selection.len())?;
            if selection.is_empty() || !self.choose(node, &selection, open)? {
                break;
            }
        }
        Ok(())
    }

    /// Follows the arcs of a tree, other than variants. `open` are the prims that refer to this one.
    fn follow(&mut self, node: &mut Node, open: &mut Vec<Rc<Trail>>) -> Result<(), IoError> {
        let count = node.specs.len().max(1);
        self.budget.spend(OPINION * count)?;
        let before = open.len();
        open.extend(node.trail.clone());
        for below in &mut node.below {
            self.follow(below, open)?;
        }
        for kind in ArcKind::REFERENCES {
            for lead in leads(node, kind) {
                let size = NAME + lead.asset.len() + lead.path.len();
                self.budget.spend(size)?;
                self.lead(node, kind, &lead, open)?;
            }
        }
        open.truncate(before);
        node.sort();
        Ok(())
    }

    /// Follows one arc.
    fn lead(
        &mut self,
        node: &mut Node,
        kind: ArcKind,
        lead: &Lead,
        open: &mut Vec<Rc<Trail>>,
    ) -> Result<(), IoError> {
        let mut stacks = vec![];
        let is_class = matches!(kind, ArcKind::Inherit | ArcKind::Specialize);
        if lead.asset.is_empty() {
            stacks.push(Rc::clone(&node.stack));
        } else if let Some(file) = self.layer(&lead.home, &lead.asset)? {
            stacks.push(self.stack(&file)?);
        }
        // The main layers may add to a class beside the prim that they refer to.
        let is_beside = lead.path.trim_start_matches('/').split('/').count() == 1;
        let main = self.main.clone().filter(|_| is_class && is_beside);
        if let Some(main) = main.filter(|main| !Rc::ptr_eq(main, &node.stack)) {
            stacks.insert(0, main);
        }
        let mut is_found = false;
        for stack in stacks {
            match self.target(&stack, &lead.path, open)? {
                Target::Node(target) => {
                    node.push(kind, *target);
                    is_found = true;
                }
                Target::Circle => {
                    self.circles += usize::from(!self.is_aside);
                    (self.ends, is_found) = (self.ends + 1, true);
                }
                Target::TooDeep => {
                    self.too_deep += usize::from(!self.is_aside);
                    (self.ends, is_found) = (self.ends + 1, true);
                }
                Target::Missing => {}
            }
        }
        if !is_found {
            self.miss(&lead.asset, &lead.path);
        }
        Ok(())
    }

    /// The prim that an arc leads to, with the arcs of the prims that contain it.
    fn target(
        &mut self,
        stack: &Rc<Stack>,
        path: &str,
        open: &mut Vec<Rc<Trail>>,
    ) -> Result<Target, IoError> {
        let default = stack.layers[0].root.text("defaultPrim");
        let path = match path.is_empty() {
            true => default.unwrap_or_default(),
            false => path,
        };
        let followed = &self.followed;
        let is_followed =
            |(of, known): &(Rc<Stack>, String)| Rc::ptr_eq(of, stack) && known == path;
        if followed.iter().any(is_followed) {
            return Ok(Target::Circle);
        }
        if followed.len() >= DEEPEST || open.len() >= DEEPEST * DEEPEST {
            return Ok(Target::TooDeep);
        }
        self.followed.push((Rc::clone(stack), path.to_owned()));
        let found = self.walk(stack, path, open);
        self.followed.pop();
        found
    }

    /// The prim at a path of a stack of layers.
    fn walk(
        &mut self,
        stack: &Rc<Stack>,
        path: &str,
        open: &mut Vec<Rc<Trail>>,
    ) -> Result<Target, IoError> {
        let mut node = Rc::new(top(stack, ArcKind::Reference));
        let mut names = path.split('/').filter(|name| !name.is_empty()).peekable();
        let mut key = (Rc::as_ptr(stack), String::new());
        while let Some(name) = names.next() {
            let is_last = names.peek().is_none();
            key.1 = [&key.1, "/", name].concat();
            if let Some(known) = self.parents.get(&key).filter(|_| !is_last) {
                node = Rc::clone(known);
                continue;
            }
            let Some(mut child) = node.child(name) else {
                return Ok(Target::Missing);
            };
            self.budget.spend(OPINION * child.size() + key.1.len())?;
            if is_last {
                let first = child.specs.first();
                let is_open = |spec| open.iter().any(|trail| trail.has(spec));
                if first.is_some_and(|(spec, _)| is_open(spec)) {
                    return Ok(Target::Circle);
                }
                self.follow(&mut child, open)?;
                return Ok(Target::Node(Box::new(child)));
            }
            // The prims that contain the target are read for their arcs only. Where a circle ends depends on where it began.
            let (was_aside, ends) = (self.is_aside, self.ends);
            self.is_aside = true;
            self.complete(&mut child, &mut Vec::new())?;
            self.is_aside = was_aside;
            node = Rc::new(child);
            if ends == self.ends {
                self.parents.insert(key.clone(), Rc::clone(&node));
            }
        }
        Ok(Target::Missing)
    }

    /// Adds the chosen variants of a tree that are not added yet; whether there was one.
    fn choose(
        &mut self,
        node: &mut Node,
        selection: &BTreeMap<String, String>,
        open: &mut Vec<Rc<Trail>>,
    ) -> Result<bool, IoError> {
        let mut found: Vec<(&String, Vec<_>)> = Vec::new();
        let mut places: BTreeMap<&String, usize> = BTreeMap::new();
        for (spec, file) in &node.specs {
            self.budget.spend(spec.variants.len())?;
            for (set, name, variant) in &spec.variants {
                if selection.get(set) == Some(name) && !node.chosen.contains(set) {
                    let place = *places.entry(set).or_insert(found.len());
                    if place == found.len() {
                        found.push((set, Vec::new()));
                    }
                    found[place].1.push((Rc::clone(variant), Rc::clone(file)));
                }
            }
        }
        let mut is_new = !found.is_empty();
        let sets: Vec<String> = found.iter().map(|(set, _)| (*set).clone()).collect();
        let variants: Vec<Node> = found
            .into_iter()
            .map(|(_, specs)| node.variant(specs))
            .collect();
        node.chosen.extend(sets);
        let before = open.len();
        open.extend(node.trail.clone());
        for mut variant in variants {
            self.follow(&mut variant, open)?;
            node.push(ArcKind::Variant, variant);
        }
        node.sort();
        for below in &mut node.below {
            is_new |= self.choose(below, selection, open)?;
        }
        open.truncate(before);
        Ok(is_new)
    }
}

/// What an arc leads to.
enum Target {
    Node(Box<Node>),
    /// A prim that leads here itself.
    Circle,
    /// A prim behind too many other arcs.
    TooDeep,
    Missing,
}
