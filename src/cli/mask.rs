//! Command-line options that mark a region of the surface.

use std::path::PathBuf;
use std::str::FromStr;

use clap::Args;
use isomend::Selector;
use isomend::glam::DVec3;
use isomend::job::{MaskSpec, PaintedColour};

use super::arguments;

/// The heading of these options in the help; other options stand under the usual heading.
pub const HEADING: &str = "Mask";

/// Options that select faces; the mask is the union of their selections.
#[derive(Clone, Debug, Default, Args)]
pub struct MaskArgs {
    /// Mark the faces whose centroids are in a box. May be given several times, like all options of masks.
    #[arg(
        help_heading = HEADING,
        long = "box",
        value_name = "X0,Y0,Z0,X1,Y1,Z1",
        allow_hyphen_values = true
    )]
    boxes: Vec<BoxArg>,

    /// Mark the faces in a ball, given by centre and radius.
    #[arg(help_heading = HEADING, long = "ball", value_name = "X,Y,Z,R", allow_hyphen_values = true)]
    balls: Vec<BallArg>,

    /// Mark the faces inside a closed mesh.
    #[arg(help_heading = HEADING, long = "mask", value_name = "FILE")]
    meshes: Vec<PathBuf>,

    /// Mark faces by their numbers, from 0: a file with one number per line, or with a JSON array.
    #[arg(help_heading = HEADING, long = "faces", value_name = "FILE")]
    lists: Vec<PathBuf>,

    /// Mark the faces whose vertices have a colour; the tolerance is the largest difference of a channel, from 0 to 255.
    #[arg(help_heading = HEADING, long = "colour", alias = "color", value_name = "RRGGBB[,TOLERANCE]")]
    colours: Vec<PaintedArg>,

    /// Mark the faces of a material.
    #[arg(help_heading = HEADING, long = "material", value_name = "NAME")]
    materials: Vec<String>,

    /// Add the faces within this distance of the marked ones, measured along the edges of the mesh.
    #[arg(help_heading = HEADING, long, value_name = "LENGTH", value_parser = arguments::positive)]
    grow: Option<f64>,

    /// Then remove the faces that are nearer than this to unmarked faces, measured along the edges of the mesh.
    #[arg(help_heading = HEADING, long, value_name = "LENGTH", value_parser = arguments::positive)]
    shrink: Option<f64>,
}

/// `N` finite numbers with commas between them.
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

/// A colour with a tolerance.
#[derive(Clone, Copy, Debug)]
pub struct PaintedArg(PaintedColour);

impl FromStr for PaintedArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (hex, tolerance) = text.split_once(',').unwrap_or((text, "0"));
        let hex = hex.trim_start_matches('#');
        let number = Some(hex)
            .filter(|h| h.len() == 6 && h.bytes().all(|b| b.is_ascii_hexdigit()))
            .and_then(|h| u32::from_str_radix(h, 16).ok());
        let tolerance = tolerance.trim().parse::<f64>().ok();
        match (number, tolerance.filter(|t| (0.0..=255.0).contains(t))) {
            (Some(n), Some(tolerance)) => Ok(Self(PaintedColour {
                rgb: [n >> 16, n >> 8, n].map(|c| f64::from(c & 255) / 255.0),
                tolerance: tolerance / 255.0,
            })),
            _ => Err("six hexadecimal digits are needed, optionally with a tolerance from 0 to 255, such as ff8000,20".to_owned()),
        }
    }
}

impl MaskArgs {
    /// The mask of these options; `None` if no selection is given. Options without one are an error of usage.
    pub fn mask(&self) -> Result<Option<MaskSpec>, String> {
        let spec = MaskSpec {
            boxes: self.boxes.iter().map(|b| b.0).collect(),
            balls: self.balls.iter().map(|b| (b.0, b.1)).collect(),
            inside: self.meshes.clone(),
            faces: Vec::new(),
            face_files: self.lists.clone(),
            colours: self.colours.iter().map(|c| c.0).collect(),
            materials: self.materials.clone(),
            grow: self.grow,
            shrink: self.shrink,
        };
        if spec.is_empty() {
            if self.grow.or(self.shrink).is_some() {
                let what = "--grow and --shrink change a mask, but no mask is given; add one, such as --ball";
                return Err(what.to_owned());
            }
            return Ok(None);
        }
        Ok(Some(spec))
    }
}
