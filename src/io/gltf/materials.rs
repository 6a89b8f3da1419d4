//! The materials of a new document, with what is known of how they look.

use std::collections::HashMap;

use serde_json::{Value, json};

use super::build::Builder;
use crate::mesh::attributes::{Attribute, Attributes, LabelKind, Material, Role};

/// The materials of a document, numbered as the labels of its faces are.
pub(super) struct Materials<'a> {
    names: &'a [String],
    looks: HashMap<&'a str, &'a Material>,
    /// For labels whose material has a texture, the same material without, once it has been needed.
    plain: HashMap<u32, usize>,
}

impl<'a> Materials<'a> {
    /// Adds the materials to a document, with their textures and images.
    pub(super) fn new(builder: &mut Builder, attributes: &'a Attributes) -> Self {
        let labels = attributes.labels_of(LabelKind::Material);
        let materials = Self {
            names: labels.map_or(&[], |l| &l.names),
            looks: attributes
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

    /// The material of a label for faces that have texture coordinates or have none: a texture needs them.
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
        self.looks.get(name.trim()).copied()
    }

    /// A material without its texture.
    fn described(&self, name: &str) -> Value {
        let mut material = json!({ "name": name });
        let Some(look) = self.look(name) else {
            return material;
        };
        let [r, g, b] = look.colour.unwrap_or([1.0; 3]);
        let opacity = look.opacity.unwrap_or(1.0);
        // Without a word on it a material is no metal, where glTF would take one for metal.
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

/// Texture coordinates as glTF has them, for a texture that was not glTF's: two numbers, of which the second counts from the
/// top, where other formats count from the bottom.
pub(super) fn turned(uv: &Attribute) -> Option<Attribute> {
    if !matches!(uv.role, Role::Uv(_)) || uv.components < 2 {
        return None;
    }
    let mut turned = Attribute::new(&uv.name, uv.role, uv.scalar, 2);
    for item in 0..uv.len() {
        let value = uv.get(item).map(|value| [value[0], 1.0 - value[1]]);
        turned.push(value.as_ref().map(|v| &v[..]));
    }
    Some(turned)
}

/// A path as a relative reference (RFC 3986).
pub(super) fn percent_encoded(path: &str) -> String {
    let mut out = String::with_capacity(path.len());
    for byte in path.bytes() {
        match byte {
            b'-' | b'.' | b'_' | b'~' | b'/' => out.push(char::from(byte)),
            byte if byte.is_ascii_alphanumeric() => out.push(char::from(byte)),
            byte => out += &format!("%{byte:02X}"),
        }
    }
    out
}
