//! The texture images of a mesh, and its texture coordinates, for the page.

use std::path::Path;

use isomend_core::mesh::attributes::{LabelKind, Role};
use isomend_files::io::{FileDocument, Format, Image, Loaded, beside};

/// Upper bound of the number of images; their numbers are stored in a byte.
const MOST: usize = 255;
/// Upper bound of the size of an image, in bytes.
const LARGEST: u64 = 512 << 20;
/// Image number of a face without an image.
pub const NONE: u8 = u8::MAX;

/// The location of an image.
#[derive(Clone, Debug, PartialEq, Eq)]
enum ImagePlace {
    /// In the mesh file; the image's number in it.
    Inside(usize),
    /// A file, relative to the folder of the mesh file.
    File(String),
}

/// The images of a mesh, and the image of each face.
#[derive(Default)]
pub struct Textures {
    images: Vec<ImagePlace>,
    /// For each face the number of its image, or [`NONE`].
    pub of_face: Vec<u8>,
}

impl Textures {
    /// The images of a mesh that was read; none if it has no texture coordinates.
    pub fn new(loaded: &Loaded) -> Self {
        let mut textures = Self {
            images: Vec::new(),
            of_face: vec![NONE; loaded.mesh.faces.len()],
        };
        let document = loaded.document.as_ref();
        if let Some(images) = document.and_then(FileDocument::images_of_faces) {
            // glTF: the file's own materials.
            for (faces, image) in images {
                let number = image.map_or(NONE, |image| textures.number(ImagePlace::Inside(image)));
                if let Some(part) = textures.of_face.get_mut(faces) {
                    part.fill(number);
                }
            }
        } else if let Some(labels) = loaded.attributes.labels_of(LabelKind::Material) {
            // The materials of labelled faces, as in OBJ.
            let materials = &loaded.attributes.materials;
            let image = |name: &String| {
                let material = materials.iter().find(|m| m.name == name.trim());
                material.and_then(|m| m.texture.clone())
            };
            let images: Vec<Option<String>> = labels.names.iter().map(image).collect();
            let numbers: Vec<u8> = (images.into_iter())
                .map(|i| i.map_or(NONE, |i| textures.number(ImagePlace::File(i))))
                .collect();
            for (slot, label) in textures.of_face.iter_mut().zip(&labels.of_face) {
                *slot = numbers.get(*label as usize).copied().unwrap_or(NONE);
            }
        } else if let Some(name) = loaded.attributes.textures.first() {
            // One image for all faces.
            let number = textures.number(ImagePlace::File(name.clone()));
            textures.of_face.fill(number);
        }
        let has_coordinates = uv(loaded, 0, 0).is_some()
            || (0..loaded.mesh.faces.len()).any(|face| uv(loaded, face, 0).is_some());
        match has_coordinates {
            true => textures,
            false => Self::default(),
        }
    }

    /// The number of an image, which is added if it is new; [`NONE`] above [`MOST`].
    fn number(&mut self, place: ImagePlace) -> u8 {
        let known = self.images.iter().position(|p| *p == place);
        let number = known.unwrap_or_else(|| {
            self.images.push(place);
            self.images.len() - 1
        });
        if number >= MOST {
            self.images.truncate(MOST);
        }
        u8::try_from(number).unwrap_or(NONE)
    }

    /// The number of images.
    pub fn count(&self) -> usize {
        self.images.len()
    }

    /// The bytes of an image and their media type; none if it cannot be read or no browser shows it.
    pub fn image(
        &self,
        index: usize,
        loaded: &Loaded,
        input: &Path,
    ) -> Option<(&'static str, Vec<u8>)> {
        let found = match self.images.get(index)? {
            ImagePlace::Inside(image) => loaded.document.as_ref()?.image(*image)?,
            ImagePlace::File(name) => Image::File(name.clone()),
        };
        let bytes = match found {
            Image::Bytes(bytes) => bytes,
            // Only from the folder of the mesh, as when the mesh is read.
            Image::File(name) => beside(input)(&name, LARGEST).ok()?,
        };
        Some((kind(&bytes)?, bytes))
    }
}

/// The media type of an image, detected from its first bytes. Only formats that contain nothing but an image: SVG may contain scripts.
fn kind(bytes: &[u8]) -> Option<&'static str> {
    let kinds: [(&[u8], &str); 4] = [
        (b"\x89PNG\r\n\x1a\n", "image/png"),
        (b"\xff\xd8\xff", "image/jpeg"),
        (b"GIF8", "image/gif"),
        (b"BM", "image/bmp"),
    ];
    let is_webp = bytes.starts_with(b"RIFF") && bytes.get(8..12) == Some(b"WEBP");
    let found = kinds.iter().find(|(magic, _)| bytes.starts_with(magic));
    found
        .map(|(_, kind)| *kind)
        .or(is_webp.then_some("image/webp"))
}

/// The texture coordinates at a corner of a face.
pub fn uv(loaded: &Loaded, face: usize, corner: usize) -> Option<[f32; 2]> {
    let attributes = &loaded.attributes;
    let of_corners = attributes
        .corner
        .iter()
        .find(|c| c.pool.role == Role::Uv(0));
    let (attribute, value) = match of_corners {
        Some(corners) => (&corners.pool, corners.get(face, corner)),
        None => {
            let attribute = attributes.vertex_role(Role::Uv(0))?;
            let vertex = loaded.mesh.faces.get(face)?[corner];
            (attribute, attribute.get(vertex as usize))
        }
    };
    let unit = attribute.unit();
    let value = value?;
    Some([value.first()?, value.get(1)?].map(|x| (x / unit) as f32))
}

/// Whether the second texture coordinate points up in the image, as in all formats except glTF.
pub fn v_points_up(format: Format) -> bool {
    !matches!(format, Format::Gltf | Format::Glb)
}

#[cfg(test)]
mod tests {
    use super::kind;

    #[test]
    fn only_images_are_served() {
        assert_eq!(kind(b"\x89PNG\r\n\x1a\nrest"), Some("image/png"));
        assert_eq!(kind(b"RIFF\0\0\0\0WEBPVP8 "), Some("image/webp"));
        for other in [&b"<svg onload='alert(1)'/>"[..], b"<html>", b""] {
            assert_eq!(kind(other), None);
        }
    }
}
