//! Writing the output, and what can be checked before the long work.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use isomend::attributes::transfer;
use isomend::glam::DVec3;
use isomend::io::{Document, Format, Loaded, Model, Precision, WriteOptions, model_to_bytes};
use isomend::mesh::Attributes;
use isomend::mesh::attributes::{LabelKind, Labels, PATCH_NAME};
use isomend::report::RegionReport;
use isomend::stitch::count_crossing;
use isomend::{FillParams, Mesh, SurfaceKind};

use super::input::is_stream;
use super::{Usage, console};

/// The file that describes the material of patches, beside an OBJ file that has material files.
const PATCH_LIBRARY: &str = "isomend_patch.mtl";
const PATCH_MATERIAL: &str = "# The material of patches that the texture of what is round them cannot cover.\n\
                              newmtl isomend_patch\nKd 0.8 0.8 0.8\n";

/// Where the mesh goes, in which format.
#[derive(Debug)]
pub struct Output {
    /// The file.
    pub path: PathBuf,
    /// Its format.
    pub format: Format,
    /// Text instead of binary.
    ascii: bool,
    /// Make its folder where it is not there.
    make_folder: bool,
}

impl Output {
    /// Checks what can be known before the mesh is.
    pub fn new(path: &Path, to: Option<Format>, ascii: bool) -> anyhow::Result<Self> {
        check_writable(path)?;
        check_text(path, format_of(path, to)?, ascii)?;
        let output = Self {
            path: path.to_path_buf(),
            format: format_of(path, to)?,
            ascii,
            make_folder: false,
        };
        if is_stream(path) && std::io::stdout().is_terminal() && !output.is_text() {
            let what = format!(
                "standard output is a terminal, which {} would upset; send it to a file or a program",
                output.format
            );
            return Err(Usage(what).into());
        }
        Ok(output)
    }

    /// As [`Output::new`], in a folder that is made when the mesh is written.
    pub fn in_folder(path: &Path, to: Option<Format>, ascii: bool) -> anyhow::Result<Self> {
        check_text(path, format_of(path, to)?, ascii)?;
        let there = path.parent().is_some_and(Path::is_dir);
        if there {
            check_writable(path)?;
        }
        Ok(Self {
            path: path.to_path_buf(),
            format: format_of(path, to)?,
            ascii,
            make_folder: !there,
        })
    }

    fn is_text(&self) -> bool {
        let text = matches!(self.format, Format::Obj | Format::Gltf | Format::Vtp);
        text || (self.ascii && self.format != Format::Glb)
    }

    /// Gives the patches of a filled mesh their attributes and writes it; returns the mesh as written, and remarks.
    ///
    /// Where the input's coordinates are all 32-bit floats the output's are too: only new vertices are rounded. The faces of
    /// patches that intersect others are counted again in what is written.
    pub fn write(
        &self,
        mut mesh: Mesh,
        input: &Loaded,
        params: &FillParams,
        regions: &mut [RegionReport],
    ) -> anyhow::Result<(Mesh, Vec<String>)> {
        let whole = params.surface == SurfaceKind::Whole;
        let kept = if whole { 0 } else { input.mesh.positions.len() };
        let rounds = matches!(self.format, Format::Gltf | Format::Glb | Format::Stl);
        let rounded = |p: &DVec3| p.as_vec3().as_dvec3();
        if input.f32_exact && self.format != Format::Obj {
            for position in &mut mesh.positions[kept..] {
                *position = rounded(position);
            }
            count_crossing_again(&mesh, input, whole, regions);
        } else if rounds {
            let positions = mesh.positions.iter().map(rounded).collect();
            let written = Mesh::new(positions, mesh.faces.clone());
            count_crossing_again(&written, input, whole, regions);
        }
        if whole {
            let mut notes = self.write_model(&mesh, &Attributes::default(), None, input)?;
            let listed = input.attributes.listed();
            if !listed.is_empty() {
                notes.push(format!(
                    "left out, because a whole level set has none: {listed}"
                ));
            }
            return Ok((mesh, notes));
        }
        let mut done = transfer(&input.mesh, &input.attributes, mesh);
        let document = input.document.as_ref();
        let mut notes = done.notes;
        let beside = self.format == Format::Obj && !is_stream(&self.path);
        let material = beside && refer_to_material(&mut done.attributes);
        notes.extend(self.write_model(&done.mesh, &done.attributes, document, input)?);
        if material {
            self.write_material()?;
        }
        notes.extend(self.side_files(input));
        Ok((done.mesh, notes))
    }

    /// Writes the file that describes the material of patches, unless there is one, which may be the user's own.
    fn write_material(&self) -> anyhow::Result<()> {
        let path = self.path.with_file_name(PATCH_LIBRARY);
        if path.exists() {
            return Ok(());
        }
        write_text(&path, PATCH_MATERIAL)
    }

    fn write_model(
        &self,
        mesh: &Mesh,
        attributes: &Attributes,
        document: Option<&Document>,
        input: &Loaded,
    ) -> anyhow::Result<Vec<String>> {
        let precision = if input.f32_exact {
            Precision::F32
        } else {
            Precision::F64
        };
        let options = WriteOptions {
            precision,
            ascii: self.ascii,
        };
        let model = Model {
            mesh,
            attributes,
            document,
        };
        self.write_as_is(&model, &options)
    }

    /// Writes a mesh and what it carries; returns remarks.
    pub fn write_as_is(
        &self,
        model: &Model<'_>,
        options: &WriteOptions,
    ) -> anyhow::Result<Vec<String>> {
        let written = model_to_bytes(model, self.format, options).with_context(|| self.name())?;
        if let Some(folder) = self.path.parent().filter(|_| self.make_folder) {
            std::fs::create_dir_all(folder)
                .with_context(|| format!("cannot make the folder {}", folder.display()))?;
        }
        write_bytes(&self.path, &written.bytes)?;
        Ok(written.notes)
    }

    /// Its name in messages.
    pub fn name(&self) -> String {
        if is_stream(&self.path) {
            "standard output".to_owned()
        } else {
            self.path.display().to_string()
        }
    }

    /// A remark on material and texture files that the output refers to and that are not beside it.
    fn side_files(&self, input: &Loaded) -> Option<String> {
        let names = match (input.format, self.format) {
            (Format::Obj, Format::Obj) => input.attributes.libraries.clone(),
            (Format::Ply, Format::Ply) => input.attributes.textures.clone(),
            (Format::Gltf | Format::Glb, Format::Gltf | Format::Glb) => {
                input.document.as_ref().map(Document::side_files)?
            }
            _ => return None,
        };
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let gone: Vec<String> = names
            .into_iter()
            .filter(|name| !folder.join(name).exists())
            .collect();
        (!gone.is_empty()).then(|| {
            format!(
                "put beside it, since it refers to them: {}",
                gone.join(", ")
            )
        })
    }
}

/// Counts the faces of patches that intersect others in the positions that are written.
fn count_crossing_again(mesh: &Mesh, input: &Loaded, whole: bool, regions: &mut [RegionReport]) {
    if whole && regions.iter().any(|r| !r.holes.is_empty()) {
        // Zero sets by themselves may pass through each other.
        return;
    }
    let kept = if whole { 0 } else { input.mesh.faces.len() };
    let patches: Vec<usize> = regions.iter().map(|r| r.new_faces).collect();
    let counts = count_crossing(mesh, kept, &patches);
    for (region, count) in regions.iter_mut().zip(counts) {
        region.intersecting_faces = count;
    }
}

/// Names the file of the patches' material where other material files are named and a patch has that material.
fn refer_to_material(attributes: &mut Attributes) -> bool {
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

/// Refuses text where the format has none: GLB is binary, and VTP packs its numbers.
fn check_text(path: &Path, format: Format, ascii: bool) -> anyhow::Result<()> {
    let other = match format {
        Format::Glb => "gltf",
        Format::Vtp => "vtk",
        _ => return Ok(()),
    };
    if ascii {
        let name = path.display();
        let what =
            format!("--ascii: {name} is written as {format}, which has no text form; {other} has");
        return Err(Usage(what).into());
    }
    Ok(())
}

/// The format to write: the one that is asked for, else that of the extension.
fn format_of(path: &Path, to: Option<Format>) -> anyhow::Result<Format> {
    match to.or_else(|| Format::from_extension(path)) {
        Some(format) => Ok(format),
        None if is_stream(path) => {
            let what = "--output - needs --to, such as --to ply: standard output has no name that tells the format";
            Err(Usage(what.to_owned()).into())
        }
        None => bail!(
            "the name {} does not tell a format to write; name it otherwise or give --to; supported are {}",
            path.display(),
            Format::LIST
        ),
    }
}

/// Refuses a path whose folder is not there, or which is a folder itself.
pub fn check_writable(path: &Path) -> anyhow::Result<()> {
    if is_stream(path) {
        return Ok(());
    }
    if path.is_dir() {
        bail!(
            "cannot write {}: it is a folder; name a file in it",
            path.display()
        );
    }
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    if !folder.is_dir() {
        bail!(
            "cannot write {}: there is no folder {}; make it first",
            path.display(),
            folder.display()
        );
    }
    Ok(())
}

/// Whether two paths name the same file.
pub fn same_file(a: &Path, b: &Path) -> bool {
    let place = |path: &Path| {
        std::fs::canonicalize(path).ok().or_else(|| {
            let folder = path.parent().filter(|f| !f.as_os_str().is_empty());
            let folder = std::fs::canonicalize(folder.unwrap_or(Path::new("."))).ok()?;
            Some(folder.join(path.file_name()?))
        })
    };
    place(a).is_some_and(|a| place(b) == Some(a))
}

/// Writes text beside its target and moves it over it.
pub fn write_text(path: &Path, text: &str) -> anyhow::Result<()> {
    write_bytes(path, text.as_bytes())
}

/// Writes bytes beside their target and moves them over it; `-` is standard output.
pub fn write_bytes(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    if is_stream(path) {
        return console::write_file(bytes).context("cannot write to standard output");
    }
    isomend::io::save(path, bytes).with_context(|| format!("cannot write {}", path.display()))
}
