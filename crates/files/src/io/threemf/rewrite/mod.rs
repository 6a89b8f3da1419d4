//! Writes a mesh into the 3MF package that it came from.
//!
//! The text of the package stays, byte for byte, save for the vertices and triangles of objects that changed, the lists of patches, and the
//! numbers of triangles in the files of slicers. Parts without changes are copied compressed as they are. An object that is placed several
//! times is written once.

mod configs;
mod edits;
mod faces;
mod object;
mod outline;
#[cfg(test)]
mod tests;
mod triangle;

use std::collections::{BTreeMap, BTreeSet};

use super::super::{Contents, Format, IoError, Written};
use super::document::ThreeMfDocument;
use super::model::unit_word;
use super::package::{Models, Package, listed};
use super::settings::{PARTS, VOLUMES};
use super::write::{ISOMEND, MATERIAL};
use configs::{Components, Config, Recounts};
use edits::Edits;
use faces::{FacesOfParts, PlacedObject, sorted};
use isomend_core::mesh::Unit;
use isomend_core::mesh::attributes::NONE;
use object::{ModelText, NewFaces, ObjectText};
use outline::Outline;

/// Writes the package of a document with the faces of a mesh. The inner error is the reason why the mesh cannot be written into it.
pub(super) fn rewrite(
    document: &ThreeMfDocument,
    model: &Contents<'_>,
) -> Result<Result<Written, String>, IoError> {
    let mut package = Package::open(&document.bytes)?;
    let models = package.models()?;
    // What fitted into the memory allowance once fits again: the texts of changed parts are unpacked a second time.
    let mut package = Package::open(&document.bytes)?;
    let sorted = match sorted(document, model) {
        Ok(sorted) => sorted,
        Err(reason) => return Ok(Err(reason)),
    };
    let mut rewriting = Rewriting {
        document,
        model,
        models: &models,
        sorted: &sorted,
        texts: BTreeMap::new(),
        recounts: Recounts::new(),
        notes: Vec::new(),
        scratch: [0; 2].map(|_| vec![NONE; model.mesh.positions.len()]),
    };
    if let Err(reason) = rewriting.models(&mut package)? {
        return Ok(Err(reason));
    }
    rewriting.configs(&mut package);
    rewriting.note_stale(&package);
    let bytes = match rewriting.texts.is_empty() {
        true => document.bytes.to_vec(),
        false => package
            .copied(&rewriting.texts)
            .map_err(|error| IoError::NotWritable {
                format: Format::ThreeMf,
                what: error.to_string(),
                advice: "write PLY instead",
            })?,
    };
    let notes = rewriting.notes;
    Ok(Ok(Written { bytes, notes }))
}

struct Rewriting<'a> {
    document: &'a ThreeMfDocument,
    model: &'a Contents<'a>,
    models: &'a Models,
    sorted: &'a [FacesOfParts],
    /// The new texts of parts by their names.
    texts: BTreeMap<String, String>,
    recounts: Recounts,
    notes: Vec<String>,
    /// For each vertex of the mesh: its vertex in the file, and its number in the written object. `NONE` between objects.
    scratch: [Vec<u32>; 2],
}

impl<'a> Rewriting<'a> {
    /// Writes the models. The inner error is the reason why a model cannot be written.
    fn models(&mut self, package: &mut Package<'_>) -> Result<Result<(), String>, IoError> {
        let changed = self.changed();
        let unit = self.model.attributes.unit;
        let unit = unit.filter(|unit| *unit != self.document.unit);
        let is_other = |unit: Unit| unit != self.document.unit;
        if unit.is_some() && self.models.parts.values().any(|part| is_other(part.unit)) {
            return Ok(Err("its models have different units".to_owned()));
        }
        let new = NewFaces::new(self.model).filter(|_| !changed.is_empty());
        let properties = new.as_ref().and_then(NewFaces::properties);
        for name in self.models.parts.keys() {
            let objects = changed.get(&name[..]);
            if objects.is_none() && unit.is_none() {
                continue;
            }
            let Some(text) = package.exact_text(name)? else {
                return Ok(Err(format!("{name} holds bytes that are no text")));
            };
            let wanted: BTreeSet<u32> = objects.into_iter().flatten().map(|(id, _)| *id).collect();
            let outline = Outline::new(&text, &wanted);
            let group = properties.as_ref().filter(|_| objects.is_some());
            let group = group.map(|own| (own, outline.largest_id.saturating_add(1)));
            let mut edits = Edits::default();
            if let Some(unit) = unit {
                set_unit(&outline, unit, &mut edits);
            }
            let own = ModelText {
                text: &text,
                outline: &outline,
                properties: group,
            };
            let mut needs = Needs::default();
            for (id, placed) in objects.into_iter().flatten() {
                match self.object(&own, (name, *id), *placed, &mut edits) {
                    Ok(()) => {
                        let done = &self.recounts[&(name.clone(), *id)];
                        needs.marks |= done.has_marks;
                        needs.properties |= done.has_new_properties;
                        needs.none |= done.takes_none;
                    }
                    Err(reason) => return Ok(Err(reason)),
                }
            }
            declare(&own, &needs, &mut edits);
            self.texts.insert(name.clone(), edits.applied(&text));
        }
        Ok(Ok(()))
    }

    /// The objects whose meshes changed, by model and number, each in the place of which the mesh is written.
    fn changed(&mut self) -> BTreeMap<&'a str, BTreeMap<u32, PlacedObject<'a>>> {
        let mut changed: BTreeMap<&str, BTreeMap<u32, PlacedObject<'_>>> = BTreeMap::new();
        let mut same: BTreeMap<(&str, u32), bool> = BTreeMap::new();
        let mut differing = BTreeSet::new();
        let placements = self.document.placements.iter();
        for (placement, parts) in placements.zip(self.sorted) {
            let Some(part) = self.models.parts.get(&placement.model) else {
                continue;
            };
            let Some(object) = part.objects.get(&placement.object) else {
                continue;
            };
            let own = PlacedObject {
                placement,
                object,
                model: self.model,
                parts,
            };
            own.find_vertices(&mut self.scratch[0]);
            let is_same = own.is_same(&self.scratch[0]);
            own.forget_vertices(&mut self.scratch[0]);
            let key = (&placement.model[..], placement.object);
            let first = changed.get(key.0).and_then(|all| all.get(&key.1));
            let differs = match first {
                Some(first) => !first.is_like(&own),
                None => !is_same && same.get(&key) == Some(&true),
            };
            if differs {
                differing.insert(key);
            }
            if !is_same && first.is_none() {
                changed.entry(key.0).or_default().insert(key.1, own);
            }
            same.insert(key, is_same);
        }
        let names: BTreeSet<&str> = self
            .document
            .placements
            .iter()
            .filter(|p| differing.contains(&(&p.model[..], p.object)))
            .map(|p| &p.name[..])
            .collect();
        if !names.is_empty() {
            let names: Vec<&str> = names.into_iter().collect();
            self.notes.push(format!(
                "objects that share a mesh came out differently: the file has it as in the first of them that changed: {}",
                listed(&names)
            ));
        }
        changed
    }

    /// Writes a changed object.
    fn object(
        &mut self,
        own: &ModelText<'_>,
        (name, id): (&str, u32),
        placed: PlacedObject<'_>,
        edits: &mut Edits,
    ) -> Result<(), String> {
        let unusual = || format!("the markup of object {id} is unusual");
        let outline = own.outline.objects.get(&id).ok_or_else(unusual)?;
        let counts = [outline.points.len(), outline.faces.len()];
        if !outline.is_plain(own.text) {
            return Err(unusual());
        }
        if counts != [placed.object.positions.len(), placed.object.triangles.len()] {
            return Err(unusual());
        }
        if placed.faces().next().is_none() {
            return Err(format!("no triangle is left of object {id}"));
        }
        let [of_file, number_of] = &mut self.scratch;
        placed.find_vertices(of_file);
        let written = ObjectText {
            model: own,
            own: placed,
            outline,
            of_file,
        };
        let recount = written.write(edits, number_of)?;
        placed.forget_vertices(of_file);
        if !recount.lost.is_empty() {
            self.notes.push(format!(
                "left out, because they refer to vertices and triangles of object {id}, which changed: {}",
                listed(&Vec::from_iter(&recount.lost))
            ));
        }
        if outline.has_slices {
            self.notes.push(format!(
                "the slices of object {id} were made of the mesh before"
            ));
        }
        self.recounts.insert((name.to_owned(), id), recount);
        Ok(())
    }

    /// Corrects the files of slicers.
    fn configs(&mut self, package: &mut Package<'_>) {
        if self.recounts.is_empty() {
            return;
        }
        let main = &self.models.parts[&self.models.main];
        let own = |used: &super::model::Use| {
            let part = used.part.as_ref().unwrap_or(&self.models.main);
            (part.clone(), used.object)
        };
        let objects = main.objects.iter();
        let components: Components = objects
            .map(|(id, object)| (*id, object.components.iter().map(own).collect()))
            .collect();
        for name in VOLUMES.into_iter().chain([PARTS]) {
            if !package.has(name) {
                continue;
            }
            let Ok(Some(text)) = package.exact_text(name) else {
                self.notes.push(format!(
                    "numbers of triangles were not corrected in {name}, which is too large or no text"
                ));
                continue;
            };
            let config = Config {
                text: &text,
                main: &self.models.main,
                recounts: &self.recounts,
                components: &components,
            };
            let done = config.corrected();
            for (count, what) in [
                (done.emptied, "volumes without triangles, left out of"),
                (
                    done.unknown,
                    "volumes that name other triangles than the mesh has, not corrected in",
                ),
            ] {
                if count > 0 {
                    self.notes.push(format!("{what} {name}: {count}"));
                }
            }
            if !done.edits.is_empty() {
                let key = super::model::part_name(name);
                self.texts.insert(key, done.edits.applied(&text));
            }
        }
    }

    /// Remarks on paint that was lost, and on G-code that was made of the mesh before.
    fn note_stale(&mut self, package: &Package<'_>) {
        let unpainted: usize = self
            .recounts
            .values()
            .map(|recount| recount.unpainted)
            .sum();
        if unpainted > 0 {
            self.notes.push(format!(
                "triangles that were divided or turned and lost paint or properties, since these depend on their corners: {unpainted}"
            ));
        }
        let is_code = |name: &&str| name.to_ascii_lowercase().ends_with(".gcode");
        if !self.recounts.is_empty() && package.names().any(|name| is_code(&name)) {
            let note = "the package has G-code of the mesh before: slice it again";
            self.notes.push(note.to_owned());
        }
    }
}

fn set_unit(outline: &Outline, unit: Unit, edits: &mut Edits) {
    let word = unit_word(unit);
    match &outline.unit {
        Some(range) => edits.replace(range.clone(), word),
        None => edits.insert(outline.model.end - 1, format!(" unit=\"{word}\"")),
    }
}

/// What the objects of a model need: the namespace of marks, groups of new properties, the group of no material.
#[derive(Default)]
struct Needs {
    marks: bool,
    properties: bool,
    none: bool,
}

/// Adds the groups of properties of new faces, and declares the namespaces that the model needs.
fn declare(own: &ModelText<'_>, needs: &Needs, edits: &mut Edits) {
    let end = own.outline.model.end - 1;
    let prefixes = &own.outline.prefixes;
    if needs.marks && !prefixes.contains("isomend") {
        edits.insert(end, format!(" xmlns:isomend=\"{ISOMEND}\""));
    }
    let Some((properties, number)) = own.properties.filter(|_| needs.properties) else {
        return;
    };
    let known = own.outline.namespaces.get(MATERIAL).cloned();
    let known = known.or_else(|| (!properties.has_colours()).then(String::new));
    let prefix = known.unwrap_or_else(|| {
        let free = ["m", "m3", "material"]
            .into_iter()
            .find(|prefix| !prefixes.contains(*prefix));
        let prefix = free.unwrap_or("isomendm");
        edits.insert(end, format!(" xmlns:{prefix}=\"{MATERIAL}\""));
        format!("{prefix}:")
    });
    let groups = properties.markup(number, [&own.outline.prefix, &prefix], needs.none);
    edits.insert(own.outline.resources, groups);
}
