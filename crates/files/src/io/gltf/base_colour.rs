//! Base colour of a glTF material: its factor, and its image with texture transform and wrapping.

use serde_json::Value;

use super::document::GltfDocument;

/// OpenGL's codes for wrapping: `CLAMP_TO_EDGE` and `MIRRORED_REPEAT`.
const CLAMP: u64 = 33071;
const MIRROR: u64 = 33648;

/// How an image continues beyond its border.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wrapping {
    /// Repeats.
    Repeat,
    /// Repeats, every other copy mirrored.
    Mirror,
    /// Repeats the texels at the border.
    Clamp,
}

/// The base colour of a material.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct BaseColour {
    /// Red, green and blue in linear light, and opacity; they multiply the image.
    pub(crate) factor: [f64; 4],
    /// Whether opacity is ignored.
    pub(crate) opaque: bool,
    /// The image, if there is one.
    pub(crate) image: Option<BaseImage>,
}

/// The image of a material's base colour.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct BaseImage {
    /// The image's index in the document; `None` if only an extension defines it.
    pub(crate) number: Option<usize>,
    /// The number of the set of texture coordinates.
    pub(crate) set: u32,
    /// Offset, rotation in radians and scale of texture coordinates (`KHR_texture_transform`).
    pub offset: [f64; 2],
    pub(crate) rotation: f64,
    pub(crate) scale: [f64; 2],
    /// Wrapping in u and in v.
    pub(crate) wrap: [Wrapping; 2],
}

impl GltfDocument {
    /// The base colour of a material by its index.
    pub(crate) fn base_colour(&self, material: usize) -> BaseColour {
        let empty = Value::Null;
        let all = self.json.get("materials");
        let material = all.and_then(|all| all.get(material)).unwrap_or(&empty);
        let metal = material.get("pbrMetallicRoughness").unwrap_or(&empty);
        // Colours of the specular-glossiness extension are not read: an image without a number says so.
        let is_foreign = material
            .pointer("/extensions/KHR_materials_pbrSpecularGlossiness")
            .is_some();
        let image = match metal.get("baseColorTexture") {
            Some(texture) => Some(self.base_image(texture)),
            None => is_foreign.then(|| self.base_image(&empty)),
        };
        let mode = material.get("alphaMode").and_then(Value::as_str);
        BaseColour {
            factor: numbers(metal.get("baseColorFactor"), [1.0; 4]),
            opaque: !matches!(mode, Some("MASK" | "BLEND")),
            image,
        }
    }

    fn base_image(&self, texture: &Value) -> BaseImage {
        let item = |list: &str, number: Option<usize>| self.json.get(list)?.get(number?);
        let transform = texture.pointer("/extensions/KHR_texture_transform");
        let of_transform = |key: &str| transform.and_then(|t| t.get(key));
        let set = of_transform("texCoord").or_else(|| texture.get("texCoord"));
        let found = item("textures", number(texture.get("index")));
        let sampler = item("samplers", number(found.and_then(|t| t.get("sampler"))));
        let wrap = |key: &str| {
            let code = sampler.and_then(|s| s.get(key)).and_then(Value::as_u64);
            match code {
                Some(CLAMP) => Wrapping::Clamp,
                Some(MIRROR) => Wrapping::Mirror,
                _ => Wrapping::Repeat,
            }
        };
        BaseImage {
            number: number(found.and_then(|t| t.get("source"))),
            set: number(set).map_or(0, |set| set as u32),
            offset: numbers(of_transform("offset"), [0.0; 2]),
            rotation: of_transform("rotation")
                .and_then(Value::as_f64)
                .unwrap_or(0.0),
            scale: numbers(of_transform("scale"), [1.0; 2]),
            wrap: [wrap("wrapS"), wrap("wrapT")],
        }
    }
}

fn number(value: Option<&Value>) -> Option<usize> {
    value?.as_u64().and_then(|n| usize::try_from(n).ok())
}

/// The numbers of a list; missing ones are taken from `otherwise`.
fn numbers<const N: usize>(value: Option<&Value>, mut otherwise: [f64; N]) -> [f64; N] {
    let list = value.and_then(Value::as_array).into_iter().flatten();
    for (number, value) in otherwise.iter_mut().zip(list) {
        *number = value.as_f64().filter(|v| v.is_finite()).unwrap_or(*number);
    }
    otherwise
}
