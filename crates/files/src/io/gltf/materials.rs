//! Writes materials with colours and textures to a new glTF document.

use std::collections::HashMap;

use serde_json::{Value, json};

use super::super::{Contents, Format};
use super::build::Builder;
use isomend_core::mesh::attributes::{Attribute, Attributes, LabelKind, Material, Role};

/// The materials of a document, with the same indices as the face labels.
pub(super) struct Materials<'a> {
    names: &'a [String],
    appearances: HashMap<&'a str, &'a Material>,
    /// For labels with a textured material, the index of its copy without texture, once needed.
    plain: HashMap<u32, usize>,
}

impl<'a> Materials<'a> {
    /// Adds all materials to a document, with textures and images.
    pub(super) fn new(builder: &mut Builder, attributes: &'a Attributes) -> Self {
        let labels = attributes.labels_of(LabelKind::Material);
        let materials = Self {
            names: labels.map_or(&[], |l| &l.names),
            appearances: attributes
                .materials
                .iter()
                .map(|m| (m.name.as_str(), m))
                .collect(),
            plain: HashMap::new(),
        };
        let mut textures: HashMap<&str, usize> = HashMap::new();
        for name in materials.names {
            let mut material = materials.described(name);
            if let Some(image) = materials.look(name).and_then(|m| m.texture.as_deref()) {
                let texture = *textures
                    .entry(image)
                    .or_insert_with(|| builder.texture(image));
                material["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": texture });
            }
            builder.push("materials", material);
        }
        materials
    }

    /// The index of a label's material. Faces without texture coordinates get the copy without texture.
    pub(super) fn index(&mut self, builder: &mut Builder, label: u32, has_uv: bool) -> usize {
        let name = &self.names[label as usize];
        let textured = self.look(name).is_some_and(|m| m.texture.is_some());
        if has_uv || !textured {
            return label as usize;
        }
        let plain = self.described(name);
        *self
            .plain
            .entry(label)
            .or_insert_with(|| builder.push("materials", plain))
    }

    fn look(&self, name: &str) -> Option<&'a Material> {
        self.appearances.get(name.trim()).copied()
    }

    /// The JSON of a material without its texture.
    fn described(&self, name: &str) -> Value {
        let mut material = json!({ "name": name });
        let Some(look) = self.look(name) else {
            return material;
        };
        let [r, g, b] = look.colour.unwrap_or([1.0; 3]);
        let opacity = look.opacity.unwrap_or(1.0);
        // glTF's default metallic factor is 1; materials that give no factor are not metallic.
        let colour = [r, g, b, opacity].map(decimal);
        material["pbrMetallicRoughness"] = json!({
            "baseColorFactor": colour,
            "metallicFactor": decimal(look.metallic.unwrap_or(0.0)),
            "roughnessFactor": decimal(look.roughness.unwrap_or(1.0)),
        });
        if opacity < 1.0 {
            material["alphaMode"] = json!("BLEND");
        }
        material
    }
}

/// The number with the digits that a 32-bit float has.
pub(super) fn decimal(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
}

/// Texture coordinates with two components, whose second is measured from the other side of the image: glTF measures it from the top, other
/// formats from the bottom.
pub(super) fn turned(uv: &Attribute) -> Option<Attribute> {
    if !matches!(uv.role, Role::Uv(_)) || uv.components < 2 {
        return None;
    }
    let mut turned = Attribute::new(&uv.name, uv.role, uv.scalar, 2);
    turned.normalized = uv.normalized;
    for item in 0..uv.len() {
        let value = uv.get(item).map(|value| [value[0], uv.unit() - value[1]]);
        turned.push(value.as_ref().map(|v| &v[..]));
    }
    Some(turned)
}

/// The attributes as another format than the source's needs them: between glTF and others all texture coordinates of two components are
/// turned. None if they stay.
pub(in super::super) fn all_turned(model: &Contents<'_>, format: Format) -> Option<Attributes> {
    let is_for_gltf = matches!(format, Format::Gltf | Format::Glb);
    let attributes = model.attributes;
    // Integers that are no fractions count texels.
    let is_fraction = |a: &Attribute| a.scalar.is_float() || a.normalized;
    let is_pair = |a: &Attribute| matches!(a.role, Role::Uv(_)) && a.components == 2;
    let is_turned = |a: &Attribute| is_pair(a) && is_fraction(a);
    let pools = attributes.corner.iter().map(|corner| &corner.pool);
    let mut every = attributes.vertex.iter().chain(pools);
    if model.is_of_gltf() == is_for_gltf || !every.any(is_turned) {
        return None;
    }
    let mut all = attributes.clone();
    let pools = all.corner.iter_mut().map(|corner| &mut corner.pool);
    for own in all.vertex.iter_mut().chain(pools) {
        if let Some(turned) = turned(own).filter(|_| is_turned(own)) {
            *own = turned;
        }
    }
    Some(all)
}
