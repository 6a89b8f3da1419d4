//! Materials of patches in a glTF document: the document's materials, a plain one, and one for a page of texels.

use std::collections::BTreeMap;

use serde_json::{Map, Value, json};

use super::build::Builder;
use super::document::GltfDocument;
use super::materials::decimal;
use isomend_core::mesh::Attributes;
use isomend_core::mesh::attributes::{LabelKind, Material, PATCH_NAME};

/// The extension for unlit materials.
const UNLIT: &str = "KHR_materials_unlit";

/// Maps material labels to materials of the document, and adds new ones.
pub(super) struct PatchMaterials<'a> {
    names: &'a [String],
    materials: &'a [Material],
    /// Number of materials of the original document.
    original: usize,
    /// The most used textured material of the document, the model for new textured ones.
    model: Value,
    /// Indices of the added materials, by their labels.
    added: BTreeMap<u32, usize>,
}

impl<'a> PatchMaterials<'a> {
    pub(super) fn new(
        document: &GltfDocument,
        attributes: &'a Attributes,
        builder: &mut Builder,
    ) -> Self {
        let labels = attributes.labels_of(LabelKind::Material);
        // Not `list` alone, which would add an empty list to a document without materials.
        let original = match builder.json.get("materials") {
            Some(_) => builder.list("materials").len(),
            None => 0,
        };
        Self {
            names: labels.map_or(&[], |l| &l.names),
            materials: &attributes.materials,
            original,
            model: most_used(document),
            added: BTreeMap::new(),
        }
    }

    /// The index of a label's material in the document; a new material is added when first used.
    pub(super) fn index(&mut self, builder: &mut Builder, label: u32) -> usize {
        if (label as usize) < self.original {
            return label as usize;
        }
        if let Some(place) = self.added.get(&label) {
            return *place;
        }
        let name = self.names.get(label as usize);
        let found = self.materials.iter().find(|m| Some(&m.name) == name);
        let image = found.and_then(|found| Some((found, found.texture.as_deref()?)));
        let material = match image {
            Some((found, image)) => {
                let texture = builder.texture(image);
                self.textured(found, texture)
            }
            None => json!({
                "name": PATCH_NAME,
                "pbrMetallicRoughness": {
                    "baseColorFactor": [0.8, 0.8, 0.8, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.8
                }
            }),
        };
        let place = builder.push("materials", material);
        self.added.insert(label, place);
        place
    }

    /// A copy of the model material with another base texture. It has no normal map or other maps, for which patches have no texture
    /// coordinates.
    fn textured(&self, wanted: &Material, texture: usize) -> Value {
        let before = &self.model["pbrMetallicRoughness"];
        let mut metal = Map::new();
        let [r, g, b] = wanted.colour.unwrap_or([1.0; 3]);
        let factor = [r, g, b, wanted.opacity.unwrap_or(1.0)];
        if factor != [1.0; 4] {
            metal.insert("baseColorFactor".to_owned(), json!(factor.map(decimal)));
        }
        metal.insert("baseColorTexture".to_owned(), json!({ "index": texture }));
        // Factors that multiplied a metallic-roughness map are reset to a rough dielectric: 0 and 1.
        let has_map = before.get("metallicRoughnessTexture").is_some();
        for (key, otherwise) in [("metallicFactor", 0.0), ("roughnessFactor", 1.0)] {
            match before.get(key).filter(|_| !has_map) {
                Some(own) => _ = metal.insert(key.to_owned(), own.clone()),
                None if has_map => _ = metal.insert(key.to_owned(), json!(otherwise)),
                None => {}
            }
        }
        let mut material = json!({ "name": wanted.name, "pbrMetallicRoughness": metal });
        for key in ["alphaMode", "alphaCutoff", "doubleSided"] {
            if let Some(own) = self.model.get(key) {
                material[key] = own.clone();
            }
        }
        if self
            .model
            .pointer(&format!("/extensions/{UNLIT}"))
            .is_some()
        {
            material["extensions"] = json!({ UNLIT: {} });
        }
        material
    }
}

/// The textured material with the most faces; null if there is none.
fn most_used(document: &GltfDocument) -> Value {
    let material = |number: usize| document.json.get("materials")?.get(number);
    let mut count: BTreeMap<usize, usize> = BTreeMap::new();
    for part in &document.parts {
        if let Some(number) = part.material {
            *count.entry(number).or_default() += part.faces.1;
        }
    }
    let textured = count.iter().filter(|(number, _)| {
        let texture = "/pbrMetallicRoughness/baseColorTexture";
        material(**number).is_some_and(|m| m.pointer(texture).is_some())
    });
    let most = textured.max_by_key(|(number, n)| (**n, usize::MAX - **number));
    most.and_then(|(number, _)| material(*number))
        .cloned()
        .unwrap_or(Value::Null)
}
