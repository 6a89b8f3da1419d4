//! The options that mark a region of the surface.

use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;

use anyhow::{Context, bail};
use clap::Args;
use isomend::glam::DVec3;
use isomend::io::{Loaded, read_path};
use isomend::mesh::mask::{Mask, Selector};
use isomend::mesh::welded;
use isomend::report::missed_lines;
use isomend::spatial::{Bvh, WindingTree};

use super::arguments;

/// Options that choose faces; what several of them choose adds up.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Mask")]
pub struct MaskArgs {
    /// Mark the faces in a box: their centroids count; may be given several times, as all options of masks.
    #[arg(
        long = "box",
        value_name = "X0,Y0,Z0,X1,Y1,Z1",
        allow_hyphen_values = true
    )]
    boxes: Vec<BoxArg>,

    /// Mark the faces in a ball: its centre and radius.
    #[arg(long = "ball", value_name = "X,Y,Z,R", allow_hyphen_values = true)]
    balls: Vec<BallArg>,

    /// Mark the faces inside a closed mesh.
    #[arg(long = "mask", value_name = "FILE")]
    meshes: Vec<PathBuf>,

    /// Mark faces by their numbers, from 0: one on each line of a file, or a JSON array.
    #[arg(long = "faces", value_name = "FILE")]
    lists: Vec<PathBuf>,

    /// Mark the faces whose vertices are painted so; the tolerance is of 255.
    #[arg(long = "colour", alias = "color", value_name = "RRGGBB[,TOLERANCE]")]
    colours: Vec<Colour>,

    /// Mark the faces of a material.
    #[arg(long = "material", value_name = "NAME")]
    materials: Vec<String>,

    /// Take in what is at most so far from the marked faces, along the edges of the mesh.
    #[arg(long, value_name = "LENGTH", value_parser = arguments::positive)]
    grow: Option<f64>,

    /// Then leave out what is nearer than this to faces that are not marked, along the edges of the mesh.
    #[arg(long, value_name = "LENGTH", value_parser = arguments::positive)]
    shrink: Option<f64>,
}

/// Numbers with commas between them.
fn separated<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let numbers: Option<Vec<f64>> = text
        .split(',')
        .map(|part| part.trim().parse().ok().filter(|v: &f64| v.is_finite()))
        .collect();
    numbers
        .and_then(|numbers| numbers.try_into().ok())
        .ok_or_else(|| format!("{N} numbers with commas between them are needed"))
}

/// A box by its corners.
#[derive(Clone, Copy, Debug)]
pub struct BoxArg([DVec3; 2]);

impl BoxArg {
    fn selector(self) -> Selector {
        let [low, high] = self.0;
        Selector::Box { low, high }
    }
}

impl FromStr for BoxArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let [a, b, c, x, y, z] = separated(text)?;
        let new = Self([DVec3::new(a, b, c), DVec3::new(x, y, z)]);
        checked(&new.selector())?;
        Ok(new)
    }
}

/// A ball by its centre and radius.
#[derive(Clone, Copy, Debug)]
pub struct BallArg(DVec3, f64);

impl BallArg {
    fn selector(self) -> Selector {
        let Self(centre, radius) = self;
        Selector::Ball { centre, radius }
    }
}

impl FromStr for BallArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let [x, y, z, radius] = separated(text)?;
        let new = Self(DVec3::new(x, y, z), radius);
        checked(&new.selector())?;
        Ok(new)
    }
}

fn checked(selector: &Selector) -> Result<(), String> {
    selector.check().map_err(|error| error.to_string())
}

/// A colour and how far off others may be.
#[derive(Clone, Copy, Debug)]
pub struct Colour {
    rgb: [f64; 3],
    tolerance: f64,
}

impl FromStr for Colour {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (hex, tolerance) = text.split_once(',').unwrap_or((text, "0"));
        let hex = hex.trim_start_matches('#');
        let number = Some(hex)
            .filter(|h| h.len() == 6 && h.bytes().all(|b| b.is_ascii_hexdigit()))
            .and_then(|h| u32::from_str_radix(h, 16).ok());
        let tolerance = tolerance.trim().parse::<f64>().ok();
        match (number, tolerance.filter(|t| (0.0..=255.0).contains(t))) {
            (Some(n), Some(tolerance)) => Ok(Self {
                rgb: [n >> 16, n >> 8, n].map(|c| f64::from(c & 255) / 255.0),
                tolerance: tolerance / 255.0,
            }),
            _ => Err("six hexadecimal digits are needed, and perhaps a tolerance from 0 to 255, such as ff8000,20".to_owned()),
        }
    }
}

/// A mask, and the bounds of the closed meshes among its selectors.
pub struct Chosen {
    mask: Mask,
    inside: Vec<[DVec3; 2]>,
}

/// What a mask marks of a mesh.
pub struct Marked {
    /// For each face whether it is marked.
    pub faces: Vec<bool>,
    /// Where nothing is marked, why.
    pub missed: Vec<String>,
}

impl Marked {
    /// The marks.
    ///
    /// # Errors
    /// When there is none, with the reason.
    pub fn some(self) -> anyhow::Result<Vec<bool>> {
        if !self.missed.is_empty() {
            bail!("the mask marks no face: {}", self.missed.join("; "));
        }
        Ok(self.faces)
    }
}

impl MaskArgs {
    /// The mask that is asked for; `None` where none of its options is given.
    pub fn mask(&self) -> anyhow::Result<Option<Chosen>> {
        let mut selectors: Vec<Selector> = self.boxes.iter().map(|b| b.selector()).collect();
        selectors.extend(self.balls.iter().map(|b| b.selector()));
        let mut inside = Vec::new();
        for path in &self.meshes {
            let (selector, bounds) = within(path)?;
            selectors.push(selector);
            inside.push(bounds);
        }
        for path in &self.lists {
            let text = std::fs::read_to_string(path)
                .with_context(|| format!("cannot read {}", path.display()))?;
            let name = path.display().to_string();
            selectors.push(Selector::Faces(numbers(&text, &name)?));
        }
        selectors.extend(self.colours.iter().map(|colour| Selector::Colour {
            rgb: colour.rgb,
            tolerance: colour.tolerance,
        }));
        let materials = self.materials.iter().cloned();
        selectors.extend(materials.map(Selector::Material));
        if selectors.is_empty() {
            if self.grow.or(self.shrink).is_some() {
                bail!("--grow and --shrink change a mask, but none is given, such as --ball");
            }
            return Ok(None);
        }
        let mask = Mask {
            selectors,
            grow: self.grow.unwrap_or(0.0),
            shrink: self.shrink.unwrap_or(0.0),
        };
        Ok(Some(Chosen { mask, inside }))
    }

    /// Which faces of a mesh are marked; `None` where no mask is asked for.
    pub fn marked(&self, loaded: &Loaded) -> anyhow::Result<Option<Marked>> {
        let Some(Chosen { mask, inside }) = self.mask()? else {
            return Ok(None);
        };
        let (mesh, attributes) = (&loaded.mesh, &loaded.attributes);
        let faces = mask.faces(mesh, attributes)?;
        let missed = if faces.contains(&true) {
            Vec::new()
        } else {
            missed_lines(&mask, &inside, mesh, attributes)
        };
        Ok(Some(Marked { faces, missed }))
    }
}

/// What lies inside a closed mesh, by its generalized winding number; and the bounds of the mesh.
fn within(path: &Path) -> anyhow::Result<(Selector, [DVec3; 2])> {
    let loaded = read_path(path, None)?;
    let (mesh, _) = welded(&loaded.mesh);
    let found =
        isomend::inspect(&mesh).with_context(|| format!("cannot use {}", path.display()))?;
    if found.topology.boundary.contains(&true) {
        bail!(
            "{} cannot be a mask: it is not closed; `isomend fill` closes it",
            path.display()
        );
    }
    let bvh = Bvh::new(&found.mesh, 0..found.mesh.faces.len() as u32);
    let tree = WindingTree::new(&bvh);
    let selector = Selector::Inside(Arc::new(move |p| tree.winding_number(&bvh, p).abs() > 0.5));
    Ok((selector, loaded.mesh.bounds()))
}

/// Face numbers from the text of a file of that name: a JSON array, or one on each line, with `#` before remarks.
pub fn numbers(text: &str, name: &str) -> anyhow::Result<Vec<usize>> {
    if text.trim_start().starts_with('[') {
        return serde_json::from_str(text)
            .with_context(|| format!("{name} is no JSON array of face numbers"));
    }
    let mut numbers = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or("").trim();
        if !line.is_empty() {
            let number = line.parse();
            numbers.push(number.with_context(|| {
                format!(
                    "{name}, line {}: '{line}' is not the number of a face",
                    i + 1
                )
            })?);
        }
    }
    Ok(numbers)
}
