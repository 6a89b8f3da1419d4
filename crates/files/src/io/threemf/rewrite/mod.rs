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
mod project_tests;
#[cfg(test)]
mod tests;
mod triangle;
mod vertices;

use std::collections::{BTreeMap, BTreeSet};

use super::super::{Contents, Format, IoError, Written};
use super::document::ThreeMfDocument;
use super::model::unit_word;
use super::package::{Models, Package, listed};
use super::settings::{PARTS, VOLUMES};
use super::write::{ISOMEND, MATERIAL};
use configs::{Components, Config, Recounts, counted_parts};
use edits::Edits;
use faces::{FacesOfParts, PlacedObject, sorted, uses_all};
use isomend_core::mesh::Unit;
use isomend_core::mesh::attributes::NONE;
use object::{ModelText, NewFaces, ObjectText, Recount};
use outline::Outline;

/// The files with the heights of layers along each object: of PrusaSlicer and SuperSlicer; of Bambu Studio and OrcaSlicer.
const LAYER_HEIGHTS: [&str; 2] = [
    "Metadata/Slic3r_PE_layer_heights_profile.txt",
    "Metadata/layer_heights_profile.txt",
];
/// Millimetres. Slicers drop the heights of layers of an object whose height differs from theirs by more than this.
const MOST_OTHER_HEIGHT: f64 = 1e-3;

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
        drops_unused: uses_all(model.mesh.positions.len(), model.mesh.faces.iter().copied()),
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
    /// Whether unused vertices of the file are left out: the mesh has none.
    drops_unused: bool,
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
                let mut own = objects.into_iter().flatten();
                if unit.is_none() && own.all(|(_, placed)| placed.only_unused) {
                    self.notes
                        .push(format!("unused vertices stay in {name}, which is no text"));
                    continue;
                }
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
                match self.object(&own, *id, *placed, &mut edits) {
                    Ok(None) => {}
                    Ok(Some(done)) => {
                        needs.marks |= done.has_marks;
                        needs.properties |= done.has_new_properties;
                        needs.none |= done.takes_none;
                        self.recounts.insert((name.clone(), *id), done);
                    }
                    Err(reason) => return Ok(Err(reason)),
                }
            }
            declare(&own, &needs, &mut edits);
            if !edits.is_empty() {
                self.texts.insert(name.clone(), edits.applied(&text));
            }
        }
        Ok(Ok(()))
    }

    /// The placed meshes of the document whose objects are known.
    fn placed(&self) -> impl Iterator<Item = PlacedObject<'a>> + use<'a> {
        let (models, model, drops_unused) = (self.models, self.model, self.drops_unused);
        let placements = self.document.placements.iter().zip(self.sorted);
        placements.filter_map(move |(placement, parts)| {
            let part = models.parts.get(&placement.model)?;
            Some(PlacedObject {
                placement,
                object: part.objects.get(&placement.object)?,
                model,
                parts,
                drops_unused,
                only_unused: false,
            })
        })
    }

    /// The objects whose meshes changed, by model and number, each in the place of which the mesh is written; with those that only lose
    /// unused vertices.
    fn changed(&mut self) -> BTreeMap<&'a str, BTreeMap<u32, PlacedObject<'a>>> {
        let mut changed: BTreeMap<&str, BTreeMap<u32, PlacedObject<'_>>> = BTreeMap::new();
        let mut same: BTreeMap<(&str, u32), bool> = BTreeMap::new();
        let mut differing = BTreeSet::new();
        for own in self.placed() {
            own.find_vertices(&mut self.scratch[0]);
            let is_same = own.is_same(&self.scratch[0]);
            own.forget_vertices(&mut self.scratch[0]);
            let key = own.placement.key();
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
            .filter(|p| differing.contains(&p.key()))
            .map(|p| &p.name[..])
            .collect();
        if !names.is_empty() {
            let names: Vec<&str> = names.into_iter().collect();
            self.notes.push(format!(
                "objects that share a mesh came out differently: the file has it as in the first of them that changed: {}",
                listed(&names)
            ));
        }
        for own in self.placed().filter(|own| own.drops_unused) {
            let (model, id) = own.placement.key();
            let is_changed = changed.get(model).is_some_and(|all| all.contains_key(&id));
            if !is_changed && own.has_unused() {
                let own = PlacedObject {
                    only_unused: true,
                    ..own
                };
                changed.entry(model).or_default().insert(id, own);
            }
        }
        changed
    }

    /// Writes a changed object. Returns what became of it; nothing if it stays.
    fn object(
        &mut self,
        own: &ModelText<'_>,
        id: u32,
        placed: PlacedObject<'_>,
        edits: &mut Edits,
    ) -> Result<Option<Recount>, String> {
        placed.find_vertices(&mut self.scratch[0]);
        let written = self.lists(own, id, placed, edits);
        placed.forget_vertices(&mut self.scratch[0]);
        let recount = match written {
            Err(reason) if placed.only_unused => {
                self.notes
                    .push(format!("unused vertices of object {id} stay: {reason}"));
                return Ok(None);
            }
            written => written?,
        };
        let outline = &own.outline.objects[&id];
        if !recount.lost.is_empty() {
            self.notes.push(format!(
                "left out, because they refer to vertices and triangles of object {id}, which changed: {}",
                listed(&Vec::from_iter(&recount.lost))
            ));
        }
        if !outline.comments.is_empty() {
            self.notes.push(format!(
                "comments between the vertices and triangles of object {id}, left out: {}",
                outline.comments.len()
            ));
        }
        if recount.keeps_unused {
            self.notes.push(format!(
                "unused vertices of object {id} stay: {}",
                outline.numbered_by()
            ));
        }
        if outline.has_slices && !placed.only_unused {
            self.notes.push(format!(
                "the slices of object {id} were made of the mesh before"
            ));
        }
        Ok((!placed.only_unused).then_some(recount))
    }

    /// Writes the lists of vertices and triangles of an object whose vertices were found.
    fn lists(
        &mut self,
        own: &ModelText<'_>,
        id: u32,
        placed: PlacedObject<'_>,
        edits: &mut Edits,
    ) -> Result<Recount, String> {
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
        if placed.only_unused && !outline.others.is_empty() {
            return Err(outline.numbered_by());
        }
        let [of_file, number_of] = &mut self.scratch;
        let written = ObjectText {
            model: own,
            own: placed,
            outline,
            of_file,
        };
        written.write(edits, number_of)
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
                counted: counted_parts(&text),
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
        let mut files = LAYER_HEIGHTS.into_iter();
        if let Some(file) = files.find(|name| package.has(name)) {
            let names = self.of_other_height();
            if !names.is_empty() {
                self.notes.push(format!(
                    "slicers drop the variable layer heights in {file} of objects whose height changed: {}",
                    listed(&names)
                ));
            }
        }
    }

    /// The names of the objects whose height in the build changed by more than slicers allow.
    fn of_other_height(&self) -> Vec<&'a str> {
        if self.recounts.is_empty() {
            return Vec::new();
        }
        let mut heights: BTreeMap<&str, [[f64; 2]; 2]> = BTreeMap::new();
        for own in self.placed() {
            let none = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
            own.add_heights(heights.entry(&own.placement.name).or_insert(none));
        }
        let millimetres = 1000.0 * self.document.unit.metres();
        let is_other = |[before, after]: &[[f64; 2]; 2]| {
            let [before, after] = [before, after].map(|[low, high]| high - low);
            ((after - before) * millimetres).abs() > MOST_OTHER_HEIGHT
        };
        let other = heights.iter().filter(|(_, own)| is_other(own));
        other.map(|(name, _)| *name).collect()
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
