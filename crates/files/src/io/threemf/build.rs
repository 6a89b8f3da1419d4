//! Assembles the build of a 3MF package into one mesh: transformed objects with colours, materials and patch marks.

use std::collections::{BTreeMap, BTreeSet};

use glam::DAffine3;

use super::super::mesh_builder::MeshBuilder;
use super::super::{Format, IoError, Loaded};
use super::document::{PlacedPart, Placement};
use super::fault;
use super::model::{Group, NO_MATERIAL, Object, Part, Use};
use super::names::{Names, UniqueNames};
use super::package::Models;
use super::settings::{ObjectSettings, Volume};
use isomend_core::mesh::Unit;
use isomend_core::mesh::attributes::{
    Attribute, CornerAttribute, LabelKind, Material, NONE, PATCH_NAME, Role, Scalar,
};

/// Memory limit for the placed objects of a build: the larger of the first number in bytes and the second times the
/// file size. The first serves small files whose object fills a whole plate. A mesh placed once takes about 10 times
/// its file, so that 64 leaves room for six copies of each object.
const ALLOWANCE: [usize; 2] = [256 << 20, 64];
/// Bytes per vertex (three 8-byte floats) and per face (corners, colour indices, labels, and their copies during
/// assembly). Estimated, not measured.
const BYTES: [usize; 2] = [24, 72];
/// Bytes per part of a placed object besides its name. Estimated, not measured.
const PART_BYTES: usize = 256;
/// Copies of each name: of its label, of the names taken so far, of their index, of the placement.
const COPIES: usize = 4;
/// Deepest nesting of objects within objects.
const MOST_DEPTH: usize = 32;
/// Most objects placed, counting each use.
const MOST_USES: usize = 100_000;

/// Places all build items of the main model. Returns the mesh and the origins of its vertices and faces.
pub(super) fn build(models: &Models, file: usize) -> Result<(Loaded, Vec<Placement>), IoError> {
    let main = &models.parts[&models.main];
    let [least, times] = ALLOWANCE;
    let mut build = Build {
        models,
        unit: main.unit,
        surface: MeshBuilder::new(Format::ThreeMf),
        left: least.max(times.saturating_mul(file)),
        uses: 0,
        colours: Colours::default(),
        objects: Names::new(LabelKind::Object),
        parts: Names::new(LabelKind::Part),
        part_names: UniqueNames::default(),
        has_names: false,
        names: UniqueNames::default(),
        materials: Names::new(LabelKind::Material),
        appearances: BTreeMap::new(),
        patches: Vec::new(),
        unread_properties: 0,
        supports: 0,
        shapeless: 0,
        placements: Vec::new(),
        item: None,
    };
    let all: Vec<Use> = match main.items.is_empty() {
        false => main.items.clone(),
        // A model without a build places all objects that are not components of others.
        true => top_objects(main),
    };
    for item in &all {
        let own = || models.settings.objects.get(&item.object);
        build.item = own().filter(|_| item.part.is_none());
        build.has_names |= build.given_name(item).is_some();
        let name = build.name_of(item);
        let name = build.names.own(name);
        let first = build.surface.face_count();
        build.charge(COPIES * name.len())?;
        build.place(&models.main, item, DAffine3::IDENTITY, &name, 0)?;
        build.end_item(first);
    }
    build.finish()
}

/// The objects that are not components of other objects in this part.
fn top_objects(part: &Part) -> Vec<Use> {
    let components = part.objects.values().flat_map(|o| &o.components);
    let own = components.filter(|c| c.part.is_none());
    let inner: BTreeSet<u32> = own.map(|c| c.object).collect();
    let top = part.objects.keys().filter(|id| !inner.contains(id));
    let used = |id: &u32| Use {
        object: *id,
        part: None,
        transform: DAffine3::IDENTITY,
    };
    top.map(used).collect()
}

struct Build<'a> {
    models: &'a Models,
    unit: Unit,
    surface: MeshBuilder,
    /// Bytes left for placed objects, of [`ALLOWANCE`].
    left: usize,
    uses: usize,
    colours: Colours,
    objects: Names,
    /// The meshes of items that consist of several.
    parts: Names,
    /// The names of the present item's meshes so far.
    part_names: UniqueNames,
    /// Whether an item has a name in the file.
    has_names: bool,
    /// The names of the items so far.
    names: UniqueNames,
    materials: Names,
    appearances: BTreeMap<String, [u8; 4]>,
    patches: Vec<bool>,
    /// Number of triangles with properties that are not read, for example textures.
    unread_properties: usize,
    /// Number of placed support objects, which are not read.
    supports: usize,
    /// Number of placed objects of other extensions: they have neither a mesh nor components.
    shapeless: usize,
    /// The meshes placed so far.
    placements: Vec<Placement>,
    /// What a slicer notes about the present item.
    item: Option<&'a ObjectSettings>,
}

/// The corner colours of the mesh.
#[derive(Default)]
struct Colours {
    pool: Vec<[u8; 4]>,
    /// The index in the pool of the first colour of each group, by the group's address.
    first: BTreeMap<*const Group, u32>,
    corners: Vec<[u32; 3]>,
}

impl<'a> Build<'a> {
    fn object(&self, part: &str, id: u32) -> Result<(&'a Part, &'a Object), IoError> {
        let models: &'a Models = self.models;
        let missing = || fault(format!("there is no object {id}, which the build uses"));
        let part = models.parts.get(part).ok_or_else(missing)?;
        Ok((part, part.objects.get(&id).ok_or_else(missing)?))
    }

    /// The name of an item's object in the model or in the notes of a slicer, if it has one.
    fn given_name(&self, item: &Use) -> Option<String> {
        let part = item.part.as_ref().unwrap_or(&self.models.main);
        let object = self.object(part, item.object).ok();
        let own = object.map(|(_, o)| o.name.trim());
        let noted = self.item.map(|noted| &noted.name[..]);
        let mut names = own.into_iter().chain(noted);
        names.find(|name| !name.is_empty()).map(str::to_owned)
    }

    /// The name of a mesh of the present item.
    fn part_name(&self, object: &Object, id: u32) -> String {
        let noted = self.item.and_then(|noted| noted.parts.get(&id));
        let names = [object.name.trim(), noted.map_or("", |name| name)];
        let name = names.into_iter().find(|name| !name.is_empty());
        name.map_or_else(|| format!("object_{id}"), str::to_owned)
    }

    /// The name of an item's object, or else a name with the object's number.
    fn name_of(&self, item: &Use) -> String {
        let name = self.given_name(item);
        name.unwrap_or_else(|| format!("object_{}", item.object))
    }

    /// Ends an item, whose faces start at `first`: a single mesh is no part.
    fn end_item(&mut self, first: usize) {
        if self.part_names.taken.len() < 2 {
            self.parts.labels.of_face[first..].fill(NONE);
            let own = self.placements.iter_mut().rev();
            let own = own.take_while(|placement| placement.faces.0 >= first);
            let parts = own.flat_map(|placement| &mut placement.parts);
            parts.for_each(|part| part.name.clear());
        }
        self.part_names = UniqueNames::default();
    }

    /// Places an object that `part` refers to, and its components, under the transform `outer`.
    fn place(
        &mut self,
        part: &str,
        used: &Use,
        outer: DAffine3,
        name: &str,
        depth: usize,
    ) -> Result<(), IoError> {
        self.uses += 1;
        if depth > MOST_DEPTH {
            let what = format!("objects are nested more than {MOST_DEPTH} times");
            return Err(fault(what));
        }
        if self.uses > MOST_USES {
            return Err(fault(format!(
                "it uses objects more than {MOST_USES} times"
            )));
        }
        let own = used.part.as_deref().unwrap_or(part);
        let (_, object) = self.object(own, used.object)?;
        if object.is_support {
            self.supports += 1;
            return Ok(());
        }
        // A translation is in the unit of the model that contains it.
        let outside = self.models.parts.get(part).map_or(self.unit, |p| p.unit);
        let mut transform = used.transform;
        transform.translation *= ratio(outside, self.unit);
        let transform = outer * transform;
        let is_shapeless = object.components.is_empty() && object.positions.is_empty();
        self.shapeless += usize::from(is_shapeless);
        for component in &object.components {
            self.place(own, component, transform, name, depth + 1)?;
        }
        self.add((own, used.object), transform, name)
    }

    /// Adds the mesh of an object of the model `own`.
    fn add(
        &mut self,
        (own, id): (&str, u32),
        transform: DAffine3,
        name: &str,
    ) -> Result<(), IoError> {
        let (model, object) = self.object(own, id)?;
        if object.triangles.is_empty() {
            return Ok(());
        }
        let scale = ratio(model.unit, self.unit);
        // Charge the memory before anything is allocated.
        let bytes = BYTES[0].saturating_mul(object.positions.len())
            + BYTES[1].saturating_mul(object.triangles.len());
        self.charge(bytes.saturating_add(own.len() + name.len()))?;
        let after = self.surface.positions.len() + object.positions.len();
        if u32::try_from(after).is_err() {
            return Err(fault("it has more vertices than 32-bit indices can name"));
        }
        let base = (after - object.positions.len()) as u32;
        let first = self.surface.face_count();
        let mut placement = Placement {
            model: own.to_owned(),
            object: id,
            transform,
            scale,
            faces: (first, object.triangles.len()),
            name: name.to_owned(),
            parts: Vec::new(),
        };
        // Append the vertices, transformed and in the unit of the main model.
        let placed = object.positions.iter().map(|p| placement.placed(*p));
        self.surface.positions.extend(placed);
        let is_mirrored = placement.is_mirrored();
        let (label, _) = self.objects.place(name);
        self.add_parts(object, &mut placement)?;
        // Append the triangles; a mirroring transform reverses their orientation.
        for triangle in &object.triangles {
            let count = object.positions.len();
            if let Some(v) = triangle.corners.iter().find(|v| **v as usize >= count) {
                let what = format!("a triangle uses vertex {v}, but its object has only {count}");
                return Err(fault(what));
            }
            let [a, b, c] = triangle.corners.map(|v| v + base);
            let turned = |[p, q, r]: [u32; 3]| if is_mirrored { [p, r, q] } else { [p, q, r] };
            self.surface.push_triangle(turned([a, b, c]));
            self.objects.labels.of_face.push(label);
            let turned_places = turned(triangle.places);
            let group = model.groups.get(&triangle.group);
            self.unread_properties += usize::from(group.is_none() && triangle.group != NONE);
            self.add_property(group, turned_places, triangle.places[0]);
        }
        self.mark(object, first);
        self.placements.push(placement);
        Ok(())
    }

    /// Labels the faces of a mesh with the part that they belong to: the mesh, or one of the volumes that a slicer notes.
    fn add_parts(&mut self, object: &Object, placement: &mut Placement) -> Result<(), IoError> {
        let (id, count) = (placement.object, object.triangles.len());
        let is_main = placement.model == self.models.main;
        let of_main = is_main.then_some(id);
        let settings = &self.models.settings;
        let volumes = settings.volumes(of_main, &object.volumes, count);
        let whole = [Volume {
            faces: [0, count - 1],
            name: self.part_name(object, id),
        }];
        let volumes = match volumes {
            [] => &whole[..],
            volumes => volumes,
        };
        let of_face = &mut self.parts.labels.of_face;
        let first = of_face.len();
        of_face.resize(first + count, NONE);
        for (number, volume) in volumes.iter().enumerate() {
            let name = match &volume.name[..] {
                "" => format!("volume_{}", number + 1),
                name => name.to_owned(),
            };
            self.charge(PART_BYTES + COPIES * name.len())?;
            let name = self.part_names.own(name);
            let (label, _) = self.parts.place(&name);
            let [from, to] = volume.faces;
            self.parts.labels.of_face[first + from..=first + to].fill(label);
            placement.parts.push(PlacedPart {
                faces: volume.faces,
                name,
            });
        }
        Ok(())
    }

    /// Charges memory for placed objects, before it is allocated.
    fn charge(&mut self, bytes: usize) -> Result<(), IoError> {
        self.left = self.left.checked_sub(bytes).ok_or_else(|| {
            fault("its objects are placed so often that they do not fit into memory")
        })?;
        Ok(())
    }

    /// Adds the property of the last triangle. `places` are the indices in the group of its corners; `first_place` is
    /// the index of the first corner in file order.
    fn add_property(&mut self, group: Option<&Group>, places: [u32; 3], first_place: u32) {
        let (mut colours, mut material) = ([NONE; 3], NONE);
        match group {
            Some(group @ Group::Colours(all)) => {
                let first = self.colours.first_of(group, all);
                let known = |k: u32| (k as usize) < all.len();
                colours = places.map(|k| if known(k) { first + k } else { NONE });
            }
            Some(Group::Materials(all)) => {
                let found = all.get(first_place as usize);
                if let Some((name, colour)) = found.filter(|(name, _)| name != NO_MATERIAL) {
                    let (place, is_new) = self.materials.place(name);
                    material = place;
                    if is_new {
                        self.appearances.insert(name.clone(), *colour);
                    }
                }
            }
            None => {}
        }
        self.colours.corners.push(colours);
        self.materials.labels.of_face.push(material);
    }

    /// Marks the faces of an object that belong to patches.
    fn mark(&mut self, object: &Object, first: usize) {
        self.patches.resize(self.surface.face_count(), false);
        let own = &mut self.patches[first..];
        for [from, to] in &object.patches {
            own[*from..=*to].fill(true);
        }
    }

    /// Remarks on what is numbered or not read.
    fn notes(&self) -> Vec<String> {
        let parts = self.models.parts.values();
        let [beams, unmatched_marks] = [
            parts.clone().map(|part| part.beams).sum(),
            parts.map(|part| part.unmatched_marks).sum::<usize>(),
        ];
        let counts = [
            (beams, "beams of lattices, which are not read"),
            (
                self.names.numbered,
                "objects that were numbered, since others have the same name",
            ),
            (
                self.unread_properties,
                "triangles with properties that are not read, such as textures",
            ),
            (self.supports, "support objects, which are not read"),
            (
                self.shapeless,
                "objects that are no triangle meshes, such as boolean shapes, which are not read",
            ),
            (
                unmatched_marks,
                "objects whose patch marks do not match their faces, so that the marks are ignored",
            ),
        ];
        let counts = counts.into_iter().filter(|(count, _)| *count > 0);
        counts
            .map(|(count, what)| format!("{what}: {count}"))
            .collect()
    }

    fn finish(self) -> Result<(Loaded, Vec<Placement>), IoError> {
        let beams: usize = self.models.parts.values().map(|part| part.beams).sum();
        if beams > 0 && self.surface.face_count() == 0 {
            return Err(IoError::Unsupported {
                format: Format::ThreeMf,
                what: format!(
                    "it has no triangles, only {beams} beams of lattices, which are not read"
                ),
                advice: "save it with its beams as triangles",
            });
        }
        let notes = self.notes();
        let mut loaded = self.surface.finish()?;
        let all = &mut loaded.attributes;
        all.unit = Some(self.unit);
        all.separate = true;
        if self.has_names || self.objects.labels.names.len() > 1 {
            all.labels.push(self.objects.labels);
        }
        if self.parts.labels.of_face.iter().any(|part| *part != NONE) {
            all.labels.push(self.parts.labels);
        }
        if !self.materials.labels.names.is_empty() {
            let material = |(name, [r, g, b, a]): (String, [u8; 4])| Material {
                name,
                colour: Some([r, g, b].map(|x| f32::from(x) / 255.0)),
                opacity: Some(f32::from(a) / 255.0),
                ..Material::default()
            };
            all.materials = self.appearances.into_iter().map(material).collect();
            all.labels.push(self.materials.labels);
        }
        if !self.colours.pool.is_empty() {
            let mut pool = Attribute::new("colour", Role::Colour, Scalar::U8, 4);
            for colour in &self.colours.pool {
                pool.push(Some(&colour.map(f64::from)));
            }
            let corners = self.colours.corners;
            all.corner.push(CornerAttribute { pool, corners });
        }
        if self.patches.contains(&true) {
            let mut marks = Attribute::new(PATCH_NAME, Role::Other, Scalar::U8, 1);
            let marked = self.patches.iter().map(|patch| f64::from(u8::from(*patch)));
            marked.for_each(|mark| marks.push(Some(&[mark])));
            all.face.push(marks);
        }
        loaded.notes.extend(notes);
        Ok((loaded, self.placements))
    }
}

impl Colours {
    /// The index in the pool of a group's first colour. The group is added to the pool when first used.
    fn first_of(&mut self, group: &Group, colours: &[[u8; 4]]) -> u32 {
        let pool = &mut self.pool;
        *(self.first.entry(std::ptr::from_ref(group))).or_insert_with(|| {
            pool.extend_from_slice(colours);
            (pool.len() - colours.len()) as u32
        })
    }
}

/// The length of unit `of` in units of `to`.
fn ratio(of: Unit, to: Unit) -> f64 {
    if of == to {
        1.0
    } else {
        of.metres() / to.metres()
    }
}
