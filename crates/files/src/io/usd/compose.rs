//! Composes the layers of a USD stage: what each layer says of a prim, the strongest first, with variants, references and payloads followed.

use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;

use super::super::{IoError, Resolve};
use super::layer::{Arc, PrimSpec, Property, Value};
use super::package::Package;
use super::{Budget, binary, text};

/// Most references that follow each other, and most prims inside each other.
const DEEPEST: usize = 32;
/// Estimated memory in bytes of an opinion.
const OPINION: usize = 128;
/// Estimated memory in bytes of a reference or a name that is looked up, without its text.
const NAME: usize = 64;
/// Most bytes that are read of a layer beside the file.
const LARGEST: u64 = 4 << 30;
/// Bytes that tell whether a file is a layer.
const HEAD: u64 = 16;

/// A layer with its name: of the file relative to the main file, or in the package.
pub(super) struct LayerFile {
    name: String,
    pub(super) root: Rc<PrimSpec>,
}

/// What a layer says of a prim.
#[derive(Clone)]
pub(super) struct Opinion {
    pub(super) spec: Rc<PrimSpec>,
    home: Rc<LayerFile>,
}

/// A prim that a reference leads to, and its layer.
type Target = (Rc<PrimSpec>, Rc<LayerFile>);

/// A prim of the stage: what the layers say of it, the strongest first.
pub(super) struct Prim {
    pub(super) name: String,
    opinions: Vec<Opinion>,
    /// The chosen variant of each set, of the strongest layer that chooses.
    selection: BTreeMap<String, String>,
}

impl Prim {
    /// The schema.
    pub(super) fn kind(&self) -> &str {
        let kinds = self.opinions.iter().map(|opinion| &opinion.spec.kind[..]);
        kinds
            .into_iter()
            .find(|kind| !kind.is_empty())
            .unwrap_or_default()
    }

    /// Whether the prim belongs to the stage: it is active, and defined rather than a class to inherit from.
    pub(super) fn is_there(&self) -> bool {
        let mut specs = self.opinions.iter().map(|opinion| &opinion.spec);
        let active = specs.clone().find_map(|spec| spec.number("active"));
        let strongest = specs.find(|spec| ["def", "class"].contains(&&spec.specifier[..]));
        strongest.is_some_and(|spec| spec.specifier == "def") && active != Some(0.0)
    }

    /// Metadata of the strongest layer that has it.
    pub(super) fn number(&self, name: &str) -> Option<f64> {
        self.opinions
            .iter()
            .find_map(|opinion| opinion.spec.number(name))
    }

    /// Metadata of the strongest layer that has it.
    pub(super) fn text(&self, name: &str) -> Option<&str> {
        self.opinions
            .iter()
            .find_map(|opinion| opinion.spec.text(name))
    }

    /// The names of the properties, sorted.
    pub(super) fn property_names(&self) -> Vec<&str> {
        let all = self
            .opinions
            .iter()
            .flat_map(|opinion| opinion.spec.properties.keys());
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
            .filter_map(|opinion| opinion.spec.properties.get(name));
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

/// The layers of a stage, which are loaded when they are first referred to.
pub(super) struct Layers<'a> {
    package: Option<Package>,
    resolve: &'a Resolve<'a>,
    pub(super) budget: Budget,
    loaded: HashMap<String, Option<Rc<LayerFile>>>,
    /// The number of files and prims that are referred to, but cannot be read, and the first of them.
    missing: (usize, String),
    /// The number of references to a prim that is being expanded.
    circles: usize,
}

impl<'a> Layers<'a> {
    pub(super) fn new(package: Option<Package>, resolve: &'a Resolve<'a>, budget: Budget) -> Self {
        Self {
            package,
            resolve,
            budget,
            loaded: HashMap::new(),
            missing: (0, String::new()),
            circles: 0,
        }
    }

    /// The prim without a name of the stage: the main layer and its sublayers.
    pub(super) fn root(&mut self, bytes: &[u8]) -> Result<Prim, IoError> {
        let (name, bytes) = match &self.package {
            None => ("", bytes),
            Some(package) => {
                let layer = package.layers.get(&package.first);
                (&package.first[..], layer.map_or(&[][..], Vec::as_slice))
            }
        };
        let name = name.to_owned();
        let file = Rc::new(LayerFile {
            root: Rc::new(parsed(bytes, &mut self.budget)?),
            name: name.clone(),
        });
        self.loaded.insert(name, Some(Rc::clone(&file)));
        let mut opinions = Vec::new();
        self.sublayers(&file, &mut Vec::new(), &mut opinions)?;
        Ok(Prim {
            name: String::new(),
            opinions,
            selection: BTreeMap::new(),
        })
    }

    /// Appends a layer and its sublayers; `open` are the layers that it is a sublayer of.
    fn sublayers(
        &mut self,
        file: &Rc<LayerFile>,
        open: &mut Vec<Rc<LayerFile>>,
        out: &mut Vec<Opinion>,
    ) -> Result<(), IoError> {
        self.budget.spend(OPINION)?;
        out.push(Opinion {
            spec: Rc::clone(&file.root),
            home: Rc::clone(file),
        });
        let names = match file.root.metadata.get("subLayers") {
            Some(names) if open.len() < DEEPEST => names.texts(),
            _ => return Ok(()),
        };
        open.push(Rc::clone(file));
        for name in names {
            self.budget.spend(NAME + name.len())?;
            match self.layer(file, name)? {
                Some(layer) if open.iter().any(|open| Rc::ptr_eq(open, &layer)) => {
                    self.circles += 1;
                }
                Some(layer) => self.sublayers(&layer, open, out)?,
                None => self.miss(name, ""),
            }
        }
        open.pop();
        Ok(())
    }

    /// Counts a file or a prim that cannot be read.
    fn miss(&mut self, asset: &str, path: &str) {
        if self.missing.0 == 0 {
            self.missing.1 = [asset, path].concat();
        }
        self.missing.0 += 1;
    }

    /// The layer that another one refers to by a name; `None` if it cannot be read.
    fn layer(&mut self, from: &LayerFile, asset: &str) -> Result<Option<Rc<LayerFile>>, IoError> {
        let name = joined(&from.name, asset);
        if let Some(known) = self.loaded.get(&name) {
            return Ok(known.clone());
        }
        let bytes = match &self.package {
            Some(package) => package.layers.get(&name).map(|l| Cow::Borrowed(&l[..])),
            None => self.beside(&name).map(Cow::Owned),
        };
        let bytes = bytes.filter(|bytes| super::is_layer(bytes));
        let file = match bytes {
            None => None,
            Some(bytes) => {
                if self.package.is_none() {
                    self.budget.allow(super::TIMES, bytes.len());
                }
                let root = Rc::new(parsed(&bytes, &mut self.budget)?);
                Some(Rc::new(LayerFile {
                    name: name.clone(),
                    root,
                }))
            }
        };
        self.loaded.insert(name, file.clone());
        Ok(file)
    }

    /// A file beside the main file, which is read whole only if it begins as a layer does; `None` if it does not, or is too large.
    fn beside(&self, name: &str) -> Option<Vec<u8>> {
        let head = (self.resolve)(name, HEAD).ok()?;
        if !super::is_layer(&head) {
            return None;
        }
        let bytes = (self.resolve)(name, LARGEST).ok()?;
        ((bytes.len() as u64) < LARGEST).then_some(bytes)
    }

    /// Appends what a layer says of a prim, then what its variants and references say. `open` are the prims that refer to this one.
    fn expand(
        &mut self,
        spec: &Rc<PrimSpec>,
        home: &Rc<LayerFile>,
        open: &mut Vec<Rc<PrimSpec>>,
        prim: &mut Prim,
    ) -> Result<(), IoError> {
        let variants = NAME * (spec.selection.len() + spec.variants.len());
        self.budget.spend(OPINION + variants)?;
        prim.opinions.push(Opinion {
            spec: Rc::clone(spec),
            home: Rc::clone(home),
        });
        for (set, name) in &spec.selection {
            if !prim.selection.contains_key(set) {
                self.budget.spend(set.len() + name.len())?;
                prim.selection.insert(set.clone(), name.clone());
            }
        }
        if open.len() >= DEEPEST {
            return Ok(());
        }
        open.push(Rc::clone(spec));
        for (set, name, variant) in &spec.variants {
            if prim.selection.get(set) == Some(name) {
                self.expand(variant, home, open, prim)?;
            }
        }
        for arc in &spec.arcs {
            self.budget.spend(NAME + arc.asset.len() + arc.path.len())?;
            match self.target(home, arc)? {
                Some((target, _)) if open.iter().any(|open| Rc::ptr_eq(open, &target)) => {
                    self.circles += 1;
                }
                Some((target, file)) => self.expand(&target, &file, open, prim)?,
                None => self.miss(&arc.asset, &arc.path),
            }
        }
        open.pop();
        Ok(())
    }

    /// The prim that a reference leads to; `None` if it is not there.
    fn target(&mut self, home: &Rc<LayerFile>, arc: &Arc) -> Result<Option<Target>, IoError> {
        let file = match arc.asset.is_empty() {
            true => Rc::clone(home),
            false => match self.layer(home, &arc.asset)? {
                Some(file) => file,
                None => return Ok(None),
            },
        };
        let first = file.root.children.first().map(|child| &child.name[..]);
        let path = match arc.path.is_empty() {
            true => file.root.text("defaultPrim").or(first).unwrap_or_default(),
            false => &arc.path,
        };
        let mut prim = Rc::clone(&file.root);
        for name in path.split('/').filter(|name| !name.is_empty()) {
            let child = prim.child(name).map(Rc::clone);
            match child {
                Some(child) => prim = child,
                None => return Ok(None),
            }
        }
        Ok(Some((prim, file)))
    }

    /// The children of a prim, in the order of the layers.
    pub(super) fn children(&mut self, prim: &Prim) -> Result<Vec<Prim>, IoError> {
        let mut children: Vec<Prim> = Vec::new();
        let mut places: BTreeMap<&str, usize> = BTreeMap::new();
        for opinion in &prim.opinions {
            for spec in &opinion.spec.children {
                let place = *places.entry(&spec.name).or_insert(children.len());
                if place == children.len() {
                    children.push(Prim {
                        name: spec.name.clone(),
                        opinions: Vec::new(),
                        selection: BTreeMap::new(),
                    });
                }
                let child = &mut children[place];
                self.expand(spec, &opinion.home, &mut Vec::new(), child)?;
            }
        }
        Ok(children)
    }

    /// The number of files of the package that are not layers.
    pub(super) fn other_files(&self) -> usize {
        self.package.as_ref().map_or(0, |package| package.others)
    }

    /// Remarks on references that are not followed.
    pub(super) fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if let (count @ 1.., first) = &self.missing {
            notes.push(format!(
                "references that cannot be followed: {count}, the first to '{first}'"
            ));
        }
        if self.circles > 0 {
            notes.push(format!(
                "references in a circle, which are not followed: {}",
                self.circles
            ));
        }
        notes
    }
}

fn parsed(bytes: &[u8], budget: &mut Budget) -> Result<PrimSpec, IoError> {
    match bytes.starts_with(binary::MAGIC) {
        true => binary::read(bytes, budget),
        false => text::read(super::super::text::strip_bom(bytes), budget),
    }
}

/// The name of a file that a layer refers to, relative to the main file.
fn joined(from: &str, asset: &str) -> String {
    let folder = from.rsplit_once('/').map_or("", |(folder, _)| folder);
    let mut parts: Vec<&str> = folder.split('/').filter(|part| !part.is_empty()).collect();
    if asset.starts_with('/') {
        return asset.to_owned();
    }
    for part in asset.split('/') {
        match part {
            "" | "." => {}
            ".." if parts.last().is_some_and(|part| *part != "..") => _ = parts.pop(),
            part => parts.push(part),
        }
    }
    parts.join("/")
}
