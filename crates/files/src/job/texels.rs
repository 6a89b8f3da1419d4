//! Files for the materials of patches: a plain MTL file, and a texture image (page) for patches across seams of the texture.

use std::fs;
use std::io::Read;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::deliver::Component;
use super::staging::{Staging, make_folder};
use super::{JobError, Place};
use crate::io::{FileDocument, Format, Image, IoError, Loaded, beside, no_side_files};
use crate::report::ranges;
use crate::texture::{TexturePage, is_own, paint};
use isomend_core::attributes::SEAM_NOTE;
use isomend_core::cancel::Cancel;
use isomend_core::mesh::attributes::{LabelKind, Labels, PATCH_NAME};
use isomend_core::mesh::{Attributes, HoleId, Model};

/// The material file of plain patches, beside an OBJ file that has material files.
pub(super) const PATCH_LIBRARY: &str = "isomend_patch.mtl";
pub(super) const PATCH_MATERIAL: &str = "# Material of patches to which the texture of their surroundings cannot be continued.\n\
                              newmtl isomend_patch\nKd 0.8 0.8 0.8\n";
/// The first line of a page's material file, by which files of earlier runs are recognised.
const PAGE_HEAD: &str = "# Texels of patches that lie across seams of the texture, by isomend.\n";
/// Bytes at the beginning of a file that suffice to recognise a file of an earlier run.
const HEAD: u64 = 512;
/// What follows the name of the input, before the number of the step, in the name of an intermediate file of a recipe.
#[doc(hidden)]
pub const INTERMEDIATE: &str = ".isomend-step";

/// The data for adding texels to the patches of a mesh before it is written.
pub(super) struct Texels<'a> {
    /// Where the mesh is written, in which format, and whether its folder is created.
    pub(super) place: &'a Place,
    pub(super) format: Format,
    pub(super) make_folder: bool,
    /// The kept part of the input, and where it was read from.
    pub(super) input: &'a Loaded,
    pub(super) source: &'a Place,
    /// The components of the patches.
    pub(super) components: &'a [Component],
    /// The token that stops the work.
    pub(super) cancel: &'a Cancel,
}

impl Texels<'_> {
    /// Adds a page for patches across seams of the texture, if the format can hold one: as the file `NAME_isomend.png` beside the mesh, or
    /// inside a GLB file. Remarks list the patches with texels, and say why others have none.
    pub(super) fn add(&self, done: &mut Model, staging: &mut Staging) -> Result<(), JobError> {
        // Whether the format can hold a page, and whether there are patches across seams.
        let input = self.input;
        let from_gltf = matches!(input.format, Format::Gltf | Format::Glb);
        let holds = match self.format {
            Format::Obj => input.format == Format::Obj && self.place.path().is_some(),
            Format::Gltf | Format::Glb => from_gltf || input.format == Format::Obj,
            _ => false,
        };
        let note = done.notes.iter().position(|n| n.starts_with(SEAM_NOTE));
        let Some(note) = note.filter(|_| holds) else {
            return Ok(());
        };
        // Image files are loaded from the folder of the input, if it has one.
        let (folder, mesh) = match self.source {
            Place::File(path) => (true, path.clone()),
            Place::Memory { folder, .. } => {
                let inside = folder.as_ref().map(|f| f.join("mesh"));
                (inside.is_some(), inside.unwrap_or_default())
            }
        };
        let load = beside(&mesh);
        let resolve = |name: &str, most: u64| -> Result<Vec<u8>, IoError> {
            match folder {
                true => load(name, most),
                false => no_side_files(name, most),
            }
        };
        // Paint the page, store it, and replace the remark on seams.
        let painted = paint(input, done, &resolve, self.cancel);
        if let Some(page) = &painted.page {
            done.notes.remove(note);
            let name = self.page_name(&done.attributes);
            self.put_page(page, &name, &mut done.attributes, staging)?;
            let is_inside = self.place.path().is_none() || self.format == Format::Glb;
            let image = match is_inside {
                true => format!("the image {name}"),
                false => format!("{name}.png"),
            };
            done.notes.push(remark(page, self.components, &image));
        }
        for (why, count) in painted.refused {
            if painted.page.is_some() {
                let what = match count {
                    1 => "a patch has".to_owned(),
                    _ => format!("{count} patches have"),
                };
                done.notes.push(format!(
                    "{what} no texels of its own across seams of the texture: {why}"
                ));
            } else {
                done.notes[note] += &format!("; {count} have no texels of their own: {why}");
            }
        }
        Ok(())
    }

    /// Adds a page's material, and stages its files; in memory and in GLB the image becomes a data URI.
    fn put_page(
        &self,
        page: &TexturePage,
        name: &str,
        attributes: &mut Attributes,
        staging: &mut Staging,
    ) -> Result<(), JobError> {
        let file = format!("{name}.png");
        let path = self.place.path().filter(|_| self.format != Format::Glb);
        let Some(path) = path else {
            let image = format!("data:image/png;base64,{}", STANDARD.encode(&page.png));
            page.assign_material(attributes, name, image);
            return Ok(());
        };
        page.assign_material(attributes, name, file.clone());
        make_folder(path, self.make_folder)?;
        staging.add(&path.with_file_name(&file), &page.png)?;
        if self.format == Format::Obj {
            let library = format!("{name}.mtl");
            let text = page_material(attributes, name, &file);
            staging.add(&path.with_file_name(&library), text.as_bytes())?;
            attributes.libraries.push(library);
        }
        Ok(())
    }

    /// The name of a page's material and files: the first that the input does not use and that would not replace a file that isomend did
    /// not write.
    fn page_name(&self, attributes: &Attributes) -> String {
        // The name of the output, without characters that OBJ and MTL files cannot hold.
        let stem = stem_of(self.place);
        let word = |c: char| {
            if c.is_whitespace() || c.is_control() || c == '#' {
                '_'
            } else {
                c
            }
        };
        let stem: String = stem.chars().map(word).collect();
        // The names that the input uses: materials, material files, textures.
        let labels = attributes.labels_of(LabelKind::Material);
        let mut used: Vec<String> = labels.map_or(Vec::new(), |l| l.names.clone());
        used.extend(attributes.libraries.iter().cloned());
        used.extend(
            attributes
                .materials
                .iter()
                .filter_map(|m| m.texture.clone()),
        );
        if let Some(document) = self.input.document.as_ref().and_then(FileDocument::gltf) {
            let files = (0..)
                .map_while(|i| document.image(i))
                .map(|image| match image {
                    Image::File(name) => name,
                    Image::Bytes(_) => String::new(),
                });
            used.extend(files);
        }
        // A GLB file contains the image, so that no file beside it is written.
        let beside = self.place.path().filter(|_| self.format != Format::Glb);
        // Number the name until it is free.
        let is_free = |file: &str| {
            let path = beside.map(|p| p.with_file_name(file));
            path.is_none_or(|path| match fs::symlink_metadata(&path) {
                Err(_) => true,
                // A link could lead out of the folder, and a pipe would block.
                Ok(about) if !about.is_file() => false,
                Ok(_) => {
                    let head = head_of(&path);
                    is_own(&head) || head.starts_with(PAGE_HEAD.as_bytes())
                }
            })
        };
        let name = |count: usize| match count {
            1 => format!("{stem}_isomend"),
            _ => format!("{stem}_isomend_{count}"),
        };
        let is_unused = |name: &String| {
            let files = [format!("{name}.png"), format!("{name}.mtl")];
            let taken = |n: &String| n == name || files.contains(n);
            !used.iter().any(taken) && files.iter().all(|file| is_free(file))
        };
        (1..).map(name).find(is_unused).unwrap_or_default()
    }
}

/// The name of a mesh without its extension, as the name of its page begins. An intermediate file and the mesh in memory that it stands for
/// have the same one, so that both give the same bytes.
fn stem_of(place: &Place) -> String {
    let stem = |path: &Path| path.file_stem().map(|s| s.to_string_lossy().into_owned());
    let found = match place {
        Place::File(path) => stem(path).map(|stem| match stem.rsplit_once(INTERMEDIATE) {
            Some((stem, number)) if number.parse::<usize>().is_ok() => stem.to_owned(),
            _ => stem,
        }),
        Place::Memory { name, folder } => folder.as_ref().and_then(|_| stem(Path::new(name))),
    };
    found.unwrap_or_else(|| "patches".to_owned())
}

/// Stages the material file of plain patches beside a mesh, unless it exists: the user may have edited it.
pub(super) fn add_material(
    mesh: &Place,
    makes_folder: bool,
    staging: &mut Staging,
) -> Result<(), JobError> {
    let beside = mesh.path().map(|p| p.with_file_name(PATCH_LIBRARY));
    match beside.filter(|path| fs::symlink_metadata(path).is_err()) {
        Some(path) => {
            make_folder(&path, makes_folder)?;
            staging.add(&path, PATCH_MATERIAL.as_bytes())
        }
        None => Ok(()),
    }
}

/// The first bytes of a file; empty if it cannot be read.
fn head_of(path: &Path) -> Vec<u8> {
    let mut head = Vec::new();
    if let Ok(file) = fs::File::open(path) {
        let _ = file.take(HEAD).read_to_end(&mut head);
    }
    head
}

/// The material file of a page.
fn page_material(attributes: &Attributes, name: &str, file: &str) -> String {
    let found = attributes.materials.iter().find(|m| m.name == name);
    let [r, g, b] = found.and_then(|m| m.colour).unwrap_or([1.0; 3]);
    let mut text = format!("{PAGE_HEAD}newmtl {name}\nKd {r} {g} {b}\n");
    if let Some(opacity) = found.and_then(|m| m.opacity) {
        text += &format!("d {opacity}\n");
    }
    text + &format!("map_Kd {file}\n")
}

/// A remark that lists the patches with texels of their own.
fn remark(page: &TexturePage, components: &[Component], image: &str) -> String {
    let on_page = |c: &&Component| {
        let first = c.faces.first();
        first.is_some_and(|f| page.faces.binary_search(f).is_ok())
    };
    let of_page: Vec<&Component> = components.iter().filter(on_page).collect();
    let mut holes: Vec<HoleId> = of_page.iter().flat_map(|c| c.holes.clone()).collect();
    holes.sort_unstable();
    holes.dedup();
    let which = match &holes[..] {
        [] => format!("{} patches", of_page.len()),
        [one] => format!("the patch of hole {one}"),
        all => format!("the patches of holes {}", ranges(all)),
    };
    let [width, height] = page.size;
    let mut note = format!(
        "texels of their own, since their rims cross seams of the texture: {which}, {width} by {height} in {image}"
    );
    if page.density < 1.0 {
        note += &format!(
            ", at {:.0} % of the resolution around them, since the page is full",
            100.0 * page.density
        );
    }
    note
}

/// Adds the material file of plain patches to the mesh's material files, if it has some and a patch has that material. Returns whether it
/// is needed.
pub(super) fn refer_to_material(attributes: &mut Attributes) -> bool {
    let materials = attributes.labels_of(LabelKind::Material);
    let place = materials.and_then(|m| m.names.iter().position(|name| name == PATCH_NAME));
    let used = |m: &Labels| place.is_some_and(|place| m.of_face.contains(&(place as u32)));
    if attributes.libraries.is_empty() || !materials.is_some_and(used) {
        return false;
    }
    if !attributes
        .libraries
        .iter()
        .any(|name| name == PATCH_LIBRARY)
    {
        attributes.libraries.push(PATCH_LIBRARY.to_owned());
    }
    true
}
