//! The layers of a USD stage: files beside the main file and in packages, which are loaded when they are first referred to, with their
//! sublayers.

use std::collections::HashMap;
use std::rc::Rc;

use super::super::{IoError, Resolve};
use super::layer::PrimSpec;
use super::package::{Package, is_package};
use super::places::{LayerFile, Place, Stack};
use super::prim::Node;
use super::{Budget, binary, text};

/// Most references that follow each other, and most sublayers inside each other.
pub(super) const DEEPEST: usize = 32;
/// Estimated memory in bytes of what a layer says of a prim.
pub(super) const OPINION: usize = 128;
/// Estimated memory in bytes of a reference or a name that is looked up, without its text.
pub(super) const NAME: usize = 64;
/// Most bytes that are read of a layer beside the file.
const LARGEST: u64 = 4 << 30;
/// Bytes that tell whether a file is a layer.
const HEAD: u64 = 16;

/// The layers of a stage, which are loaded when they are first referred to.
pub(super) struct Layers<'a> {
    resolve: &'a Resolve<'a>,
    pub(super) budget: Budget,
    packages: HashMap<String, Option<Package>>,
    loaded: HashMap<Place, Option<Rc<LayerFile>>>,
    stacks: HashMap<Place, Rc<Stack>>,
    /// The number of files and prims that are referred to, but cannot be read, and the first of them.
    missing: (usize, String),
    /// The number of layers and packages that are damaged, and the first of them with its fault.
    damaged: (usize, String),
    /// The number of references to a prim that is being expanded, and of those that follow too many others.
    pub(super) circles: usize,
    pub(super) too_deep: usize,
    /// The number of circles and of too deep references so far, also of those that are not counted.
    pub(super) ends: usize,
    /// The prims that contain targets of references, by the stack of layers and the path, with all their arcs.
    pub(super) parents: HashMap<(*const Stack, String), Rc<Node>>,
    /// Whether references are followed for another prim's sake: what is missing is not counted then.
    pub(super) is_aside: bool,
    /// The references that are being followed: their stack of layers and the path of their prim.
    pub(super) followed: Vec<(Rc<Stack>, String)>,
    /// The main layer and its sublayers.
    pub(super) main: Option<Rc<Stack>>,
}

impl<'a> Layers<'a> {
    pub(super) fn new(package: Option<Package>, resolve: &'a Resolve<'a>, budget: Budget) -> Self {
        let packages = package.map(|package| (String::new(), Some(package)));
        Self {
            resolve,
            budget,
            packages: packages.into_iter().collect(),
            loaded: HashMap::new(),
            stacks: HashMap::new(),
            missing: (0, String::new()),
            damaged: (0, String::new()),
            circles: 0,
            too_deep: 0,
            ends: 0,
            parents: HashMap::new(),
            is_aside: false,
            followed: Vec::new(),
            main: None,
        }
    }

    /// The main layer and its sublayers.
    pub(super) fn main_stack(&mut self, bytes: &[u8]) -> Result<Rc<Stack>, IoError> {
        let mut place = Place::default();
        let root = match self.packages.get("") {
            Some(Some(package)) => {
                place = Place {
                    package: Some(String::new()),
                    name: package.first.clone(),
                };
                let layer = package.layers.get(&package.first);
                parsed(layer.map_or(&[][..], Vec::as_slice), &mut self.budget)?
            }
            _ => parsed(bytes, &mut self.budget)?,
        };
        let file = Rc::new(LayerFile {
            root: Rc::new(root),
            place: place.clone(),
        });
        self.loaded.insert(place, Some(Rc::clone(&file)));
        let stack = self.stack(&file)?;
        self.main = Some(Rc::clone(&stack));
        Ok(stack)
    }

    /// A layer and its sublayers.
    pub(super) fn stack(&mut self, file: &Rc<LayerFile>) -> Result<Rc<Stack>, IoError> {
        if let Some(known) = self.stacks.get(&file.place) {
            return Ok(Rc::clone(known));
        }
        let mut layers = Vec::new();
        self.sublayers(file, &mut Vec::new(), &mut layers)?;
        let stack = Rc::new(Stack { layers });
        self.stacks.insert(file.place.clone(), Rc::clone(&stack));
        Ok(stack)
    }

    /// Appends a layer and its sublayers; `open` are the layers that it is a sublayer of.
    fn sublayers(
        &mut self,
        file: &Rc<LayerFile>,
        open: &mut Vec<Rc<LayerFile>>,
        out: &mut Vec<Rc<LayerFile>>,
    ) -> Result<(), IoError> {
        self.budget.spend(OPINION)?;
        out.push(Rc::clone(file));
        let names = match file.root.metadata.get("subLayers") {
            Some(names) => names.texts(),
            None => return Ok(()),
        };
        if open.len() >= DEEPEST {
            self.too_deep += names.len();
            return Ok(());
        }
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
    pub(super) fn miss(&mut self, asset: &str, path: &str) {
        if self.is_aside {
            return;
        }
        if self.missing.0 == 0 {
            self.missing.1 = [asset, path].concat();
        }
        self.missing.0 += 1;
    }

    /// The layer that another one refers to by a name; `None` if it cannot be read.
    pub(super) fn layer(
        &mut self,
        from: &LayerFile,
        asset: &str,
    ) -> Result<Option<Rc<LayerFile>>, IoError> {
        let mut place = from.place.joined(asset);
        if let Some(package) = place.package.clone()
            && place.name.is_empty()
        {
            self.open(&package)?;
            let package = self.packages.get(&package).and_then(Option::as_ref);
            place.name = package.map_or(String::new(), |package| package.first.clone());
        }
        if let Some(known) = self.loaded.get(&place) {
            return Ok(known.clone());
        }
        let root = match &place.package {
            None => match self.beside(&place.name, &super::is_layer) {
                Some(bytes) => {
                    self.budget.allow(super::TIMES, bytes.len());
                    Some(parsed(&bytes, &mut self.budget))
                }
                None => None,
            },
            Some(package) => {
                self.open(package)?;
                let package = self.packages.get(package).and_then(Option::as_ref);
                let bytes = package.and_then(|package| package.layers.get(&place.name));
                let bytes = bytes.filter(|bytes| super::is_layer(bytes));
                bytes.map(|bytes| parsed(bytes, &mut self.budget))
            }
        };
        let root = root.map(|root| self.survived(&place.name, root));
        let file = root.transpose()?.flatten().map(|root| {
            let (place, root) = (place.clone(), Rc::new(root));
            Rc::new(LayerFile { place, root })
        });
        self.loaded.insert(place, file.clone());
        Ok(file)
    }

    /// Opens a package beside the main file, unless that was tried before.
    fn open(&mut self, name: &str) -> Result<(), IoError> {
        if self.packages.contains_key(name) {
            return Ok(());
        }
        let package = match self.beside(name, &|bytes| bytes.starts_with(b"PK\x03\x04")) {
            Some(bytes) if is_package(&bytes) => {
                self.budget.allow(super::TIMES, bytes.len());
                let package = Package::open(&bytes, &mut self.budget);
                self.survived(name, package)?
            }
            _ => None,
        };
        self.packages.insert(name.to_owned(), package);
        Ok(())
    }

    /// What was read of a file; `None`, and a remark, if the file is damaged. An error only if the memory is used up.
    fn survived<T>(&mut self, name: &str, read: Result<T, IoError>) -> Result<Option<T>, IoError> {
        match read {
            Ok(read) => Ok(Some(read)),
            Err(error) if self.budget.is_exhausted() => Err(error),
            Err(error) => {
                if self.damaged.0 == 0 {
                    self.damaged.1 = format!("'{name}': {error}");
                }
                self.damaged.0 += 1;
                Ok(None)
            }
        }
    }

    /// A file beside the main file, which is read whole only if it begins as it must; `None` if it does not, or is too large.
    fn beside(&self, name: &str, begins: &dyn Fn(&[u8]) -> bool) -> Option<Vec<u8>> {
        let head = (self.resolve)(name, HEAD).ok()?;
        if !begins(&head) {
            return None;
        }
        let bytes = (self.resolve)(name, LARGEST).ok()?;
        ((bytes.len() as u64) < LARGEST).then_some(bytes)
    }

    /// The number of files of the package that are not layers.
    pub(super) fn other_files(&self) -> usize {
        let package = self.packages.get("").and_then(Option::as_ref);
        package.map_or(0, |package| package.others)
    }

    /// Remarks on references that are not followed.
    pub(super) fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if let (count @ 1.., first) = &self.missing {
            notes.push(format!(
                "references that cannot be followed: {count}, the first to '{first}'"
            ));
        }
        if let (count @ 1.., first) = &self.damaged {
            notes.push(format!(
                "layers that are damaged: {count}, the first {first}"
            ));
        }
        for (count, what) in [
            (self.circles, "references in a circle"),
            (self.too_deep, "references behind too many others"),
        ] {
            if count > 0 {
                notes.push(format!("{what}, which are not followed: {count}"));
            }
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
