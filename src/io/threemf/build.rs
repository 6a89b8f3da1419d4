//! The build of a 3MF package as one mesh: objects put where they are used, with colours and materials.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DAffine3, DVec3};

use super::super::mesh_builder::MeshBuilder;
use super::super::{Format, IoError, Loaded};
use super::fault;
use super::model::{Group, NO_MATERIAL, Object, Part, Use};
use super::package::Models;
use crate::mesh::Unit;
use crate::mesh::attributes::{
    Attribute, CornerAttribute, LabelKind, Labels, Material, NONE, PATCH_NAME, Role, Scalar,
};

/// Bytes that the objects of a build may take where they are used several times: at least the first number, for small files with an object
/// on a whole plate, and the second times the size of the file. A mesh used once takes about 10 times its file, so that 64 leaves room for
/// six copies of each object.
const ALLOWANCE: [usize; 2] = [256 << 20, 64];
/// Bytes of a vertex (three floats of 8 bytes) and of a face (corners, places of colours, labels, and the copies of these while triangles are
/// put together: estimated, not measured).
const BYTES: [usize; 2] = [24, 64];
/// Objects in objects, at most.
const MOST_DEPTH: usize = 32;
/// Objects put somewhere, at most.
const MOST_USES: usize = 100_000;

/// Puts all items of the main model together.
pub(super) fn build(models: Models, file: usize) -> Result<Loaded, IoError> {
    let main = &models.parts[&models.main];
    let [least, times] = ALLOWANCE;
    let mut build = Build {
        models: &models,
        unit: main.unit,
        surface: MeshBuilder::new(Format::ThreeMf),
        left: least.max(times.saturating_mul(file)),
        uses: 0,
        colours: Colours::default(),
        objects: Names::new(LabelKind::Object),
        names: BTreeSet::new(),
        counts: BTreeMap::new(),
        renamed: 0,
        materials: Names::new(LabelKind::Material),
        looks: BTreeMap::new(),
        patches: Vec::new(),
        passed_over: 0,
        supports: 0,
    };
    let all: Vec<Use> = match main.items.is_empty() {
        false => main.items.clone(),
        // Without a build all objects that are no part of others are meant.
        true => top_objects(main),
    };
    for item in &all {
        let name = build.name_of(item);
        let name = build.own_name(name);
        build.place(&models.main, item, DAffine3::IDENTITY, &name, 0)?;
    }
    build.finish()
}

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
    /// Bytes that what is put somewhere may still take.
    left: usize,
    uses: usize,
    colours: Colours,
    objects: Names,
    /// The names of the items, how many have each one that several have, and how many were given another one.
    names: BTreeSet<String>,
    counts: BTreeMap<String, usize>,
    renamed: usize,
    materials: Names,
    looks: BTreeMap<String, [u8; 4]>,
    patches: Vec<bool>,
    /// Triangles with properties that are not read.
    passed_over: usize,
    /// Uses of support objects, which are not read.
    supports: usize,
}

/// Labels, and the place of each name in them.
struct Names {
    labels: Labels,
    places: BTreeMap<String, u32>,
}

impl Names {
    fn new(kind: LabelKind) -> Self {
        Self {
            labels: Labels::new(kind),
            places: BTreeMap::new(),
        }
    }

    /// The place of a name, and whether it is new.
    fn place(&mut self, name: &str) -> (u32, bool) {
        if let Some(place) = self.places.get(name) {
            return (*place, false);
        }
        let place = self.labels.names.len() as u32;
        self.labels.names.push(name.to_owned());
        self.places.insert(name.to_owned(), place);
        (place, true)
    }
}

/// The colours of corners.
#[derive(Default)]
struct Colours {
    pool: Vec<[u8; 4]>,
    /// The first place in the pool of the colours of each group, by the address of the group.
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

    /// The name of an item: that of its object, or its number.
    fn name_of(&self, item: &Use) -> String {
        let part = item.part.as_ref().unwrap_or(&self.models.main);
        let object = self.object(part, item.object).ok();
        let name = object.map(|(_, o)| o.name.trim().to_owned());
        let name = name.filter(|name| !name.is_empty());
        name.unwrap_or_else(|| format!("object_{}", item.object))
    }

    /// A name that no item before has: items of the same name, as of one object that is there several times, are numbered.
    fn own_name(&mut self, name: String) -> String {
        if self.names.insert(name.clone()) {
            return name;
        }
        self.renamed += 1;
        let count = self.counts.entry(name.clone()).or_insert(1);
        loop {
            *count += 1;
            let numbered = format!("{name}_{count}");
            if self.names.insert(numbered.clone()) {
                return numbered;
            }
        }
    }

    /// Puts an object, named in `part`, and what it consists of somewhere.
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
            let what = format!("objects lie in each other more than {MOST_DEPTH} times");
            return Err(fault(what));
        }
        if self.uses > MOST_USES {
            return Err(fault(format!(
                "it uses objects more than {MOST_USES} times"
            )));
        }
        let own = used.part.as_deref().unwrap_or(part);
        let (model, object) = self.object(own, used.object)?;
        if object.is_support {
            self.supports += 1;
            return Ok(());
        }
        // A translation is in the unit of the model that it stands in.
        let outside = self.models.parts.get(part).map_or(self.unit, |p| p.unit);
        let mut transform = used.transform;
        transform.translation *= ratio(outside, self.unit);
        let transform = outer * transform;
        for component in &object.components {
            self.place(own, component, transform, name, depth + 1)?;
        }
        let scale = ratio(model.unit, self.unit);
        self.add(model, object, transform, scale, name)
    }

    fn add(
        &mut self,
        model: &Part,
        object: &Object,
        transform: DAffine3,
        scale: f64,
        name: &str,
    ) -> Result<(), IoError> {
        if object.triangles.is_empty() {
            return Ok(());
        }
        let bytes = BYTES[0].saturating_mul(object.positions.len())
            + BYTES[1].saturating_mul(object.triangles.len());
        self.left = self.left.checked_sub(bytes).ok_or_else(|| {
            fault("its objects are used so often that they do not fit into memory")
        })?;
        let after = self.surface.positions.len() + object.positions.len();
        if u32::try_from(after).is_err() {
            return Err(fault("it has more vertices than can be numbered"));
        }
        let base = (after - object.positions.len()) as u32;
        let is_plain = transform == DAffine3::IDENTITY && scale == 1.0;
        let placed = |p: &DVec3| match is_plain {
            true => *p,
            false => transform.transform_point3(scale * *p),
        };
        self.surface
            .positions
            .extend(object.positions.iter().map(placed));
        let is_mirrored = transform.matrix3.determinant() < 0.0;
        let (label, _) = self.objects.place(name);
        let first = self.surface.face_count();
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
            self.passed_over += usize::from(group.is_none() && triangle.group != NONE);
            self.add_property(group, turned_places, triangle.places[0]);
        }
        self.mark(object, first);
        Ok(())
    }

    /// Takes the property of the last triangle: the places in its group of its corners, and of its first corner in the file.
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
                        self.looks.insert(name.clone(), *colour);
                    }
                }
            }
            None => {}
        }
        self.colours.corners.push(colours);
        self.materials.labels.of_face.push(material);
    }

    /// Marks the faces of an object that are of patches.
    fn mark(&mut self, object: &Object, first: usize) {
        self.patches.resize(self.surface.face_count(), false);
        let own = &mut self.patches[first..];
        for [from, to] in &object.patches {
            own[*from..=*to].fill(true);
        }
    }

    fn finish(self) -> Result<Loaded, IoError> {
        let mut loaded = self.surface.finish()?;
        let all = &mut loaded.attributes;
        all.unit = Some(self.unit);
        if self.objects.labels.names.len() > 1 {
            all.labels.push(self.objects.labels);
        }
        if !self.materials.labels.names.is_empty() {
            let look = |(name, [r, g, b, a]): (String, [u8; 4])| Material {
                name,
                colour: Some([r, g, b].map(|x| f32::from(x) / 255.0)),
                opacity: Some(f32::from(a) / 255.0),
                ..Material::default()
            };
            all.materials = self.looks.into_iter().map(look).collect();
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
        if self.renamed > 0 {
            let what = "objects that were numbered, since others have the same name";
            loaded.notes.push(format!("{what}: {}", self.renamed));
        }
        if self.passed_over > 0 {
            let what = "triangles with properties that are not read, such as textures";
            loaded.notes.push(format!("{what}: {}", self.passed_over));
        }
        if self.supports > 0 {
            let what = "support objects, which are not read";
            loaded.notes.push(format!("{what}: {}", self.supports));
        }
        let misfits: usize = self.models.parts.values().map(|part| part.misfits).sum();
        if misfits > 0 {
            let what =
                "objects whose marks of patches do not fit their faces, so that they are ignored";
            loaded.notes.push(format!("{what}: {misfits}"));
        }
        Ok(loaded)
    }
}

impl Colours {
    /// The first place of the colours of a group in the pool, where they are put when they are first used.
    fn first_of(&mut self, group: &Group, colours: &[[u8; 4]]) -> u32 {
        let pool = &mut self.pool;
        *(self.first.entry(std::ptr::from_ref(group))).or_insert_with(|| {
            pool.extend_from_slice(colours);
            (pool.len() - colours.len()) as u32
        })
    }
}

/// How many of one unit another is.
fn ratio(of: Unit, to: Unit) -> f64 {
    if of == to {
        1.0
    } else {
        of.metres() / to.metres()
    }
}
