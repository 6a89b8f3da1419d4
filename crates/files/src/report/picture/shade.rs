//! Shades the visible faces of a picture: lights, colours of patches, and edges.

use glam::Vec3;
use rayon::prelude::*;

use super::super::scene::{Scene, Side};
use super::overlay;
use super::raster::{Camera, NONE, Projected, Seen, draw};

// Colours are linear RGB from 0 to 1 until they are encoded.

/// The kept surface.
const GREY: Vec3 = Vec3::new(0.54, 0.56, 0.60);
/// Patches.
const ORANGE: Vec3 = Vec3::new(0.85, 0.24, 0.025);
/// The inside of the surface.
const INSIDE: Vec3 = Vec3::new(0.22, 0.17, 0.14);
const BACKGROUND: Vec3 = Vec3::new(1.0, 1.0, 1.0);
/// Directions to the lights in the camera's frame (right, up, towards the eye), with their strengths.
const LIGHTS: [(Vec3, f32); 3] = [
    (Vec3::new(-0.45, 0.65, 0.61), 0.72),
    (Vec3::new(0.85, 0.1, 0.5), 0.24),
    (Vec3::new(0.0, -0.9, 0.3), 0.08),
];
const AMBIENT: f32 = 0.13;
/// Strength and exponent of the highlight (Blinn-Phong).
const GLOSS: (f32, i32) = (0.10, 24);
/// Edges are drawn if triangles are at least this many pixels wide on average.
const EDGE_SPACE: f32 = 5.0;
/// Fraction by which edges darken the surface.
const EDGE_DARK: f32 = 0.45;
/// Width of edges, in pixels.
const EDGE_WIDTH: f32 = 0.7;

/// Draws a square panel: RGB bytes, row by row. `pixels` is its side, `samples` the number of samples along a pixel's side.
pub fn panel(
    scene: &Scene,
    side: Side,
    camera: &Camera,
    edges: bool,
    [pixels, samples]: [usize; 2],
) -> Vec<u8> {
    let seen = draw(scene, side, camera, [pixels * samples, pixels * samples]);
    let width = if edges {
        edge_width(&seen, samples as f32)
    } else {
        0.0
    };
    let shader = Shader {
        scene,
        seen: &seen,
        camera,
        edge_width: width,
    };
    let mut out = vec![0u8; 3 * pixels * pixels];
    out.par_chunks_mut(3 * pixels)
        .enumerate()
        .for_each(|(y, line)| {
            for (x, rgb) in line.chunks_mut(3).enumerate() {
                let mut sum = Vec3::ZERO;
                for i in 0..samples * samples {
                    sum += shader.sample(x * samples + i % samples, y * samples + i / samples);
                }
                let mean = sum / (samples * samples) as f32;
                for (byte, value) in rgb.iter_mut().zip(mean.to_array()) {
                    *byte = encoded(value);
                }
            }
        });
    overlay::draw(&mut out, scene, camera, &seen, [pixels, samples]);
    out
}

/// Half the width of edges in samples; 0 if edges would be too dense.
fn edge_width(seen: &Seen, samples: f32) -> f32 {
    let mut shown: Vec<u32> = seen
        .nearest
        .iter()
        .copied()
        .filter(|i| *i != NONE)
        .collect();
    let covered = shown.len() as f32;
    shown.sort_unstable();
    shown.dedup();
    let side = (2.0 * covered / (shown.len() as f32).max(1.0)).sqrt();
    if side > EDGE_SPACE * samples {
        0.5 * EDGE_WIDTH * samples
    } else {
        0.0
    }
}

struct Shader<'a> {
    scene: &'a Scene,
    seen: &'a Seen,
    camera: &'a Camera,
    edge_width: f32,
}

impl Shader<'_> {
    /// The colour of a sample.
    fn sample(&self, x: usize, y: usize) -> Vec3 {
        let index = self.seen.nearest[y * self.seen.width + x];
        if index == NONE {
            return BACKGROUND;
        }
        let face = &self.seen.faces[index as usize];
        let weights = face.weights(x as f32 + 0.5, y as f32 + 0.5);
        let lit = self.lit(face, weights);
        let near = self.edge_width - face.edge_distance(weights) + 0.5;
        lit * (1.0
            - EDGE_DARK
                * if self.edge_width > 0.0 {
                    near.clamp(0.0, 1.0)
                } else {
                    0.0
                })
    }

    /// The colour of a region's faces.
    fn marked(&self, region: u32) -> Vec3 {
        let own = (region as usize).checked_sub(1);
        let own = own.and_then(|i| self.scene.palette.get(i));
        own.map_or(ORANGE, |c| linear(c.rgb))
    }

    /// The colour of a point of a face under the lights, without edges.
    fn lit(&self, face: &Projected, weights: [f32; 3]) -> Vec3 {
        let corners = self.scene.faces[face.face as usize];
        let normal: Vec3 = (0..3)
            .map(|k| weights[k] * self.scene.normals[corners[k] as usize])
            .sum();
        let back = face.is_back();
        let normal = if back { -normal } else { normal }.normalize_or_zero();
        let camera = self.camera;
        let n = Vec3::new(
            normal.dot(camera.right),
            normal.dot(camera.up),
            normal.dot(camera.towards).max(0.0),
        );
        let colour = match self.scene.region(face.face) {
            _ if back => INSIDE,
            Some(region) if self.scene.marks_new() => self.marked(region),
            _ => GREY,
        };
        let light: f32 = LIGHTS
            .iter()
            .map(|(from, strength)| strength * n.dot(from.normalize()).max(0.0))
            .sum();
        let half = (LIGHTS[0].0.normalize() + Vec3::Z).normalize();
        let shine = GLOSS.0 * n.dot(half).max(0.0).powi(GLOSS.1);
        colour * (AMBIENT + 1.35 * light) + Vec3::splat(if back { 0.0 } else { shine })
    }
}

/// The linear values of an sRGB colour.
fn linear(rgb: [u8; 3]) -> Vec3 {
    Vec3::from_array(rgb.map(|byte| {
        let v = f32::from(byte) / 255.0;
        if v <= 0.04045 {
            v / 12.92
        } else {
            ((v + 0.055) / 1.055).powf(2.4)
        }
    }))
}

/// A linear value as an sRGB byte.
fn encoded(value: f32) -> u8 {
    let v = value.clamp(0.0, 1.0);
    let srgb = if v <= 0.003_130_8 {
        12.92 * v
    } else {
        1.055 * v.powf(1.0 / 2.4) - 0.055
    };
    (srgb * 255.0 + 0.5) as u8
}
