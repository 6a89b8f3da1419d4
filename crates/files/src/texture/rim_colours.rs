//! Base colours of the input's faces, sampled from the factors and texture images of their materials.

use std::collections::BTreeMap;

use super::image::{Image, Linear, MOST_BYTES, Wrap};
use crate::io::{BaseImage, FileDocument, Format, Image as Stored, Loaded, Resolve, Wrapping};
use isomend_core::attributes::FieldSource;
use isomend_core::elementary::{hypot, sin_cos};
use isomend_core::mesh::attributes::{LabelKind, NONE, Role};

/// Upper bound of the number of images.
const MOST_IMAGES: usize = 64;
/// No further image is read once the images have this many texels together: 2²⁷, half a gigabyte.
const MOST_TEXELS: f64 = (1u64 << 27) as f64;

/// The base colour of a material.
#[derive(Clone, Debug)]
struct MaterialColour {
    /// Red, green, blue and opacity that multiply the image.
    factor: Linear,
    /// Whether opacity is ignored.
    opaque: bool,
    texture: Option<Texture>,
}

/// An image and its mapping to faces.
#[derive(Clone, Debug)]
struct Texture {
    /// The image; `None` if its format is not supported.
    key: Option<Key>,
    /// Number of the set of texture coordinates.
    set: u32,
    /// Affine map from (u, v, 1) to the position as a fraction of the image's size, from the upper left corner.
    rows: [[f64; 3]; 2],
    wrap: [Wrap; 2],
}

/// Where an image is stored.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Key {
    /// In the mesh file, by its number.
    Inside(usize),
    /// In a file beside it, by its name.
    Beside(String),
}

/// The base colours of the materials of some faces, with their images.
pub(super) struct RimColours<'a> {
    loaded: &'a Loaded,
    /// By the label of the material.
    of_materials: BTreeMap<u32, MaterialColour>,
    /// Sets of texture coordinates, by their numbers.
    sets: Vec<(u32, FieldSource<'a>)>,
    /// Images that were read, or why they could not be.
    images: BTreeMap<Key, Result<Image, String>>,
    /// The factor if all materials have the same one. It then becomes the factor of the page's material; otherwise it is multiplied into
    /// the page's texels.
    factor: Option<Linear>,
}

impl<'a> RimColours<'a> {
    /// The base colours of the given faces; `resolve` loads image files.
    pub(super) fn new(loaded: &'a Loaded, faces: &[u32], resolve: &Resolve<'_>) -> Self {
        let attributes = &loaded.attributes;
        let pools = attributes.corner.iter().map(FieldSource::Corner);
        let all = pools.chain(attributes.vertex.iter().map(FieldSource::Vertex));
        let sets = all.filter_map(|source| match source.attribute().role {
            Role::Uv(set) if source.attribute().components >= 2 => Some((set, source)),
            _ => None,
        });
        let mut colours = Self {
            loaded,
            of_materials: BTreeMap::new(),
            sets: sets.collect(),
            images: BTreeMap::new(),
            factor: None,
        };
        for &face in faces {
            let label = colours.label(face);
            if !colours.of_materials.contains_key(&label) {
                let material = colours.of_label(label);
                colours.load(&material, resolve);
                colours.of_materials.insert(label, material);
            }
        }
        let mut factors = colours
            .of_materials
            .values()
            .map(|material| material.factor);
        let first = factors.next();
        colours.factor = first.filter(|first| factors.all(|f| f == *first));
        colours
    }

    /// The factor of all materials; white if they differ.
    pub(super) fn factor(&self) -> Linear {
        self.factor.unwrap_or([1.0; 4])
    }

    /// The label of a face's material; [`NONE`] without a material.
    pub(super) fn label(&self, face: u32) -> u32 {
        let labels = self.loaded.attributes.labels_of(LabelKind::Material);
        let label = labels.and_then(|l| l.of_face.get(face as usize));
        label.copied().unwrap_or(NONE)
    }

    /// Whether the second texture coordinate counts upwards from the bottom of the image: in all formats but glTF.
    pub(super) fn goes_up(&self) -> bool {
        !matches!(self.loaded.format, Format::Gltf | Format::Glb)
    }

    fn set(&self, number: u32) -> Option<FieldSource<'a>> {
        let found = self.sets.iter().find(|(set, _)| *set == number);
        found.map(|(_, source)| *source)
    }

    fn of_label(&self, label: u32) -> MaterialColour {
        let plain = MaterialColour {
            factor: [1.0; 4],
            opaque: true,
            texture: None,
        };
        if label == NONE {
            return plain;
        }
        if let Some(document) = self.loaded.document.as_ref().and_then(FileDocument::gltf) {
            let found = document.base_colour(label as usize);
            return MaterialColour {
                factor: found.factor,
                opaque: found.opaque,
                texture: found.image.map(|image| Texture::of_document(&image)),
            };
        }
        let labels = self.loaded.attributes.labels_of(LabelKind::Material);
        let name = labels.and_then(|l| l.names.get(label as usize));
        let materials = &self.loaded.attributes.materials;
        let Some(found) = name.and_then(|name| materials.iter().find(|m| m.name == name.trim()))
        else {
            return plain;
        };
        let [r, g, b] = found.colour.unwrap_or([1.0; 3]).map(f64::from);
        let texture = |path: &String| Texture {
            key: Some(Key::Beside(path.clone())),
            set: 0,
            // The second coordinate counts from the bottom.
            rows: [[1.0, 0.0, 0.0], [0.0, -1.0, 1.0]],
            wrap: [Wrap::Repeat; 2],
        };
        MaterialColour {
            factor: [r, g, b, f64::from(found.opacity.unwrap_or(1.0))],
            opaque: true,
            texture: found.texture.as_ref().map(texture),
        }
    }

    /// Reads the image of a material, once.
    fn load(&mut self, material: &MaterialColour, resolve: &Resolve<'_>) {
        let Some(key) = material.texture.as_ref().and_then(|t| t.key.clone()) else {
            return;
        };
        if self.images.contains_key(&key) {
            return;
        }
        let texels = |image: &Image| image.size()[0] * image.size()[1];
        let used: f64 = self.images.values().flatten().map(texels).sum();
        let image = match self.images.len() < MOST_IMAGES && used < MOST_TEXELS {
            true => self
                .bytes(&key, resolve)
                .and_then(|bytes| Image::read(&bytes)),
            false => Err("is one of more images than are read".to_owned()),
        };
        self.images.insert(key, image);
    }

    fn bytes(&self, key: &Key, resolve: &Resolve<'_>) -> Result<Vec<u8>, String> {
        let document = self.loaded.document.as_ref().and_then(FileDocument::gltf);
        let found = match key {
            Key::Beside(name) => Some(Stored::File(name.clone())),
            Key::Inside(number) => document.and_then(|d| d.image(*number)),
        };
        match found {
            None => Err("is not in the file".to_owned()),
            Some(Stored::Bytes(bytes)) => Ok(bytes),
            Some(Stored::File(name)) => {
                let bytes = resolve(&name, MOST_BYTES + 1);
                let bytes = bytes.map_err(|error| format!("cannot be read ({error})"))?;
                match bytes.len() as u64 > MOST_BYTES {
                    true => Err(format!("is larger than {} MB", MOST_BYTES >> 20)),
                    false => Ok(bytes),
                }
            }
        }
    }

    /// Why the colours of a face are not available; `None` if they are.
    pub(super) fn refusal(&self, face: u32) -> Option<String> {
        let texture = self.material(face)?.texture.as_ref()?;
        let Some(key) = &texture.key else {
            return Some("an image is in a format that is not read".to_owned());
        };
        let name = match key {
            Key::Inside(number) => format!("image {number}"),
            Key::Beside(name) => format!("the image '{}'", name.escape_debug()),
        };
        let why = self.images.get(key)?.as_ref().err()?;
        Some(format!("{name} {why}"))
    }

    fn material(&self, face: u32) -> Option<&MaterialColour> {
        self.of_materials.get(&self.label(face))
    }

    /// The texture of a face, its image and its set of texture coordinates.
    fn texture(&self, face: u32) -> Option<(&Texture, &Image, FieldSource<'a>)> {
        let texture = self.material(face)?.texture.as_ref()?;
        let image = self.images.get(texture.key.as_ref()?)?.as_ref().ok()?;
        Some((texture, image, self.set(texture.set)?))
    }

    /// The position on the image, in texels, of a point between two corners of a face: the fraction `part` of the way from the first.
    fn place(
        &self,
        face: u32,
        corners: [u8; 2],
        part: f64,
    ) -> Option<([f64; 2], &Texture, &Image)> {
        let (texture, image, source) = self.texture(face)?;
        let unit = source.attribute().unit();
        let ends = corners.map(|k| source.at(&self.loaded.mesh, face as usize, usize::from(k)));
        let [a, b] = [ends[0]?, ends[1]?];
        let [u, v] = [0, 1].map(|k| (a[k] + part * (b[k] - a[k])) / unit);
        let size = image.size();
        let at = [0, 1].map(|k| {
            let [x, y, one] = texture.rows[k];
            size[k] * (x * u + y * v + one)
        });
        at.iter()
            .all(|x| x.is_finite())
            .then_some((at, texture, image))
    }

    /// The colour at a point between two corners of a face, the fraction `part` of the way from the first, without the common factor.
    pub(super) fn colour(&self, face: u32, corners: [u8; 2], part: f64) -> Linear {
        let Some(material) = self.material(face) else {
            return [1.0; 4];
        };
        let mut colour = match self.place(face, corners, part) {
            Some((at, texture, image)) => image.sample(at, texture.wrap),
            None => [1.0; 4],
        };
        if self.factor.is_none() {
            colour
                .iter_mut()
                .zip(material.factor)
                .for_each(|(c, f)| *c *= f);
        }
        if material.opaque {
            colour[3] = 1.0;
        }
        colour
    }

    /// The length of a face's edge on its image, in texels; `None` without an image.
    pub(super) fn texels(&self, face: u32, [a, b]: [u8; 2]) -> Option<f64> {
        let (start, ..) = self.place(face, [a, b], 0.0)?;
        let (end, ..) = self.place(face, [a, b], 1.0)?;
        Some(hypot(end[0] - start[0], end[1] - start[1]))
    }
}

impl Texture {
    fn of_document(image: &BaseImage) -> Self {
        let ([ox, oy], [sx, sy]) = (image.offset, image.scale);
        let (sin, cos) = sin_cos(image.rotation);
        Self {
            key: image.number.map(Key::Inside),
            set: image.set,
            // Translation · rotation · scale, as KHR_texture_transform defines.
            rows: [[cos * sx, sin * sy, ox], [-sin * sx, cos * sy, oy]],
            wrap: image.wrap.map(|wrap| match wrap {
                Wrapping::Repeat => Wrap::Repeat,
                Wrapping::Mirror => Wrap::Mirror,
                Wrapping::Clamp => Wrap::Clamp,
            }),
        }
    }
}
