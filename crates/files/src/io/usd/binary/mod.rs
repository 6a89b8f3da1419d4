//! Reads a USD layer from the binary crate format (`.usdc`): tables of words, fields, paths and specs, and values behind them.
//!
//! Versions 0.4 and later are read, as OpenUSD writes them (`pxr/usd/sdf/crateFile.cpp`).

mod integers;
mod lists;
mod sections;
mod values;

use std::collections::BTreeMap;
use std::rc::Rc;

use super::super::{IoError, Location};
use super::Budget;
use super::layer::{ArcKind, PrimSpec, Property, is_used};
use sections::Spec;
use values::Values;

/// The first bytes of a file.
pub(super) const MAGIC: &[u8] = b"PXR-USDC";
/// Most prims inside each other.
const DEEPEST: usize = 128;
/// Estimated memory in bytes of a prim or a property, without values.
const SPEC: usize = 512;
/// Memory in bytes of a field of a prim or a property.
const FIELD: usize = 24;

/// The error for a byte offset.
fn fault(budget: &Budget, at: usize, what: impl Into<String>) -> IoError {
    IoError::malformed(budget.format, Location::Byte(at), what)
}

/// Reads the prim without a name that holds the layer's metadata and its prims.
pub(super) fn read(bytes: &[u8], budget: &mut Budget) -> Result<PrimSpec, IoError> {
    let sections = sections::read(bytes, budget)?;
    budget.spend(sections.specs.len() * SPEC)?;
    // The children of each path, in their order, and the spec of each.
    let mut children: Vec<Vec<usize>> = vec![Vec::new(); sections.paths.len()];
    for (path, entry) in sections.paths.iter().enumerate() {
        if let Some(parent) = entry.parent {
            children[parent].push(path);
        }
    }
    let mut spec_of: Vec<Option<&Spec>> = vec![None; sections.paths.len()];
    for spec in &sections.specs {
        if let Some(place) = spec_of.get_mut(spec.path) {
            *place = Some(spec);
        }
    }
    let mut builder = Builder {
        values: Values {
            bytes,
            sections: &sections,
            budget,
        },
        children,
        spec_of,
    };
    let root = sections
        .paths
        .iter()
        .position(|path| path.parent.is_none() && path.is_there);
    match root {
        Some(root) => builder.prim(root, 0),
        None => Err(fault(builder.values.budget, 0, "the file has no prims")),
    }
}

struct Builder<'a, 'b> {
    values: Values<'a, 'b>,
    children: Vec<Vec<usize>>,
    spec_of: Vec<Option<&'a Spec>>,
}

impl<'a> Builder<'a, '_> {
    /// The fields of a spec: names and representations.
    fn fields(&mut self, path: usize) -> Result<Vec<(&'a str, u64)>, IoError> {
        let Some(spec) = self.spec_of[path] else {
            return Ok(Vec::new());
        };
        let sections = self.values.sections;
        let set = sections.field_sets.get(spec.fields..).unwrap_or_default();
        let end = set.iter().position(|field| *field == u32::MAX);
        let set = &set[..end.unwrap_or(set.len())];
        self.values.budget.spend(FIELD * set.len())?;
        let fields = set
            .iter()
            .filter_map(|field| sections.fields.get(*field as usize));
        Ok(fields
            .map(|(name, value)| (sections.word(*name), *value))
            .collect())
    }

    fn prim(&mut self, path: usize, depth: usize) -> Result<PrimSpec, IoError> {
        if depth > DEEPEST {
            let what = format!("prims are more than {DEEPEST} deep inside each other");
            return Err(fault(self.values.budget, 0, what));
        }
        let sections = self.values.sections;
        let mut prim = PrimSpec {
            name: sections.paths[path]
                .name
                .map(|word| sections.word(word).to_owned())
                .unwrap_or_default(),
            ..PrimSpec::default()
        };
        let mut order: BTreeMap<String, usize> = BTreeMap::new();
        for (name, value) in self.fields(path)? {
            match name {
                "specifier" => prim.specifier = self.values.specifier(value).to_owned(),
                "typeName" => prim.kind = self.values.text(value)?.unwrap_or_default(),
                "primChildren" => {
                    let names = self.values.texts(value)?;
                    order = names
                        .into_iter()
                        .enumerate()
                        .map(|(at, name)| (name, at))
                        .collect();
                }
                "references" | "payload" | "inheritPaths" | "specializes" => {
                    if let Some(kind) = ArcKind::of_field(name) {
                        prim.arcs.extend(self.values.arcs(value, kind)?);
                    }
                }
                "variantSelection" => prim.selection = self.values.selection(value)?,
                "metersPerUnit" | "upAxis" | "defaultPrim" | "subLayers" | "active"
                | "instanceable" => {
                    let value = self.values.value(value)?;
                    prim.metadata.insert(name.to_owned(), value);
                }
                _ => {}
            }
        }
        self.below(path, depth, &mut prim)?;
        prim.children
            .sort_by_key(|child| order.get(&child.name).copied().unwrap_or(usize::MAX));
        Ok(prim)
    }

    /// Adds the properties, variants and children of a prim, in the order of the paths.
    fn below(&mut self, path: usize, depth: usize, prim: &mut PrimSpec) -> Result<(), IoError> {
        let sections = self.values.sections;
        for child in std::mem::take(&mut self.children[path]) {
            let entry = &sections.paths[child];
            let name = entry
                .name
                .map(|word| sections.word(word))
                .unwrap_or_default();
            if entry.is_property {
                if let Some(property) = self.property(child, name)? {
                    prim.properties.insert(name.to_owned(), property);
                }
            } else if let Some(variant) = name.strip_prefix('{').and_then(|n| n.strip_suffix('}')) {
                if let Some((set, variant)) = variant.split_once('=').filter(|(_, v)| !v.is_empty())
                {
                    let (set, variant) = (set.to_owned(), variant.to_owned());
                    prim.variants
                        .push((set, variant, Rc::new(self.prim(child, depth + 1)?)));
                }
            } else if self.spec_of[child].is_some() {
                prim.children.push(Rc::new(self.prim(child, depth + 1)?));
            }
        }
        Ok(())
    }

    /// The first number of a value.
    fn number(&mut self, value: u64) -> Result<Option<f64>, IoError> {
        Ok(self.values.value(value)?.numbers().first().copied())
    }

    fn property(&mut self, path: usize, name: &str) -> Result<Option<Property>, IoError> {
        let mut property = Property::default();
        if self.spec_of[path].is_none() || !is_used(name) {
            return Ok(None);
        }
        for (field, value) in self.fields(path)? {
            match field {
                "typeName" => property.kind = self.values.text(value)?.unwrap_or_default(),
                "default" => property.value = Some(self.values.value(value)?),
                "timeSamples" => property.sample = self.values.first_sample(value)?,
                "interpolation" => property.interpolation = self.values.text(value)?,
                "elementSize" => property.element_size = self.number(value)?,
                "unauthoredValuesIndex" => property.unauthored = self.number(value)?,
                "targetPaths" => property.targets = self.values.paths(value)?,
                _ => {}
            }
        }
        Ok(Some(property))
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::Format;
    use super::*;

    #[test]
    fn fields_of_specs_are_charged() {
        let sections = sections::Sections {
            words: vec!["default".to_owned()],
            fields: vec![(0, 7)],
            field_sets: vec![0, 0, u32::MAX, 0],
            ..sections::Sections::default()
        };
        let spec = Spec { path: 0, fields: 0 };
        let mut budget = Budget::new(Format::Usda, ("stage", ""), 3 * FIELD, [0, 0]);
        let mut builder = Builder {
            values: Values {
                bytes: &[],
                sections: &sections,
                budget: &mut budget,
            },
            children: Vec::new(),
            spec_of: vec![Some(&spec)],
        };
        let both = vec![("default", 7), ("default", 7)];
        assert_eq!(builder.fields(0).unwrap(), both);
        let error = builder.fields(0).unwrap_err().to_string();
        assert!(error.contains("limit"), "{error}");
    }
}
