//! The scene as text for the page's script: whole numbers, differences, zlib, base64.

use std::io::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use glam::Vec3;
use serde::Serialize;

use super::super::picture::views;
use super::super::scene::Scene;

/// Steps along the longest extent.
const STEPS: f64 = 1_048_576.0;
/// Values of the curvature, the distance and the expected error go up to this.
const VALUES: f32 = 127.0;
/// The largest values, this part of all, are shown as one.
const OUTLIERS: f64 = 0.03;

/// What the script must know beside the arrays.
#[derive(Serialize)]
pub struct Header {
    /// Positions are these steps times whole numbers, less `radius`.
    step: f64,
    radius: f64,
    /// The point that positions are relative to.
    origin: [f64; 3],
    /// Numbers of faces of both meshes, and of new ones.
    kept: usize,
    new: usize,
    /// Curvature, distance and expected error at the largest value; the last is 0 where none is known.
    curvature: f32,
    distance: f32,
    error: f32,
    /// Whether new faces get a colour of their own.
    marks: bool,
    /// The colour of each region, where they have their own: red, green and blue from 0 to 1.
    palette: Vec<[f32; 3]>,
    /// From where to look first, at what, how far to both sides, and what is upward.
    towards: [f32; 3],
    centre: [f32; 3],
    reach: f32,
    up: [f32; 3],
}

/// The arrays as text, and what belongs to them.
pub fn packed(scene: &Scene) -> (String, Header) {
    let radius = scene.radius.max(f64::MIN_POSITIVE);
    let step = 2.0 * radius / STEPS;
    let whole = |p: Vec3| {
        let steps = (p.as_dvec3() + radius) / step;
        steps.to_array().map(|x| x.round() as i64)
    };
    let curvature = limit(scene.curvature.iter().map(|h| h.abs()));
    let distance = limit(scene.distance.iter().copied().filter(|d| *d > 0.0));
    let error = limit(scene.error.iter().copied().filter(|e| *e > 0.0));
    let scaled = |x: &f32, top: f32| {
        let part = if top > 0.0 { x / top } else { 0.0 };
        (part.clamp(-1.0, 1.0) * VALUES).round() as i64
    };
    let rims = scene.rims.iter().flatten();
    let mut bytes = Vec::new();
    let mut put = |stride: usize, values: Vec<i64>| array(&mut bytes, stride, &values);
    put(3, scene.positions.iter().flat_map(|&p| whole(p)).collect());
    put(
        2,
        scene.normals.iter().flat_map(|&n| octahedral(n)).collect(),
    );
    let values = scene.curvature.iter();
    put(1, values.map(|x| scaled(x, curvature)).collect());
    let values = scene.distance.iter();
    put(1, values.map(|x| scaled(x, distance)).collect());
    let values = scene.error.iter();
    // Errors are not negative: that stands for those that are not known.
    let scaled_error = |x: &f32| match x.is_nan() {
        true => -VALUES as i64,
        false => scaled(x, error),
    };
    put(1, values.map(scaled_error).collect());
    let corners = scene.faces.iter().flatten();
    put(1, corners.map(|&v| i64::from(v)).collect());
    put(1, scene.regions.iter().map(|&r| i64::from(r)).collect());
    put(3, rims.flat_map(|&p| whole(p)).collect());
    put(1, scene.rims.iter().map(|r| r.len() as i64).collect());
    let camera = views(scene).whole;
    let header = Header {
        step,
        radius,
        origin: scene.origin.to_array(),
        kept: scene.kept,
        new: scene.regions.len(),
        curvature,
        distance,
        error,
        marks: scene.marks_new(),
        palette: (scene.palette.iter())
            .map(|c| c.rgb.map(|byte| f32::from(byte) / 255.0))
            .collect(),
        towards: camera.towards.to_array(),
        centre: camera.centre.to_array(),
        reach: camera.reach,
        up: camera.up.to_array(),
    };
    (STANDARD.encode(deflated(&bytes)), header)
}

/// The value that all but the largest few stay below.
fn limit(values: impl Iterator<Item = f32>) -> f32 {
    let mut values: Vec<f32> = values.filter(|v| v.is_finite()).collect();
    values.sort_unstable_by(f32::total_cmp);
    let at = (values.len() as f64 * (1.0 - OUTLIERS)) as usize;
    values.get(at).or(values.last()).copied().unwrap_or(0.0)
}

/// A direction as two numbers up to 1023: projected onto an octahedron that is unfolded (Meyer et al. 2010).
fn octahedral(n: Vec3) -> [i64; 2] {
    let size = n.abs().element_sum();
    if size == 0.0 || !size.is_finite() {
        return [0, 0];
    }
    let n = n / size;
    let sign = |x: f32| if x < 0.0 { -1.0 } else { 1.0 };
    let (x, y) = if n.z < 0.0 {
        ((1.0 - n.y.abs()) * sign(n.x), (1.0 - n.x.abs()) * sign(n.y))
    } else {
        (n.x, n.y)
    };
    [x, y].map(|v| (v * 1023.0).round() as i64)
}

/// Appends an array: its length and stride, then each value less the one a stride before, in bytes of seven bits.
fn array(bytes: &mut Vec<u8>, stride: usize, values: &[i64]) {
    varint(bytes, values.len() as u64);
    varint(bytes, stride as u64);
    for (i, value) in values.iter().enumerate() {
        let before = if i >= stride { values[i - stride] } else { 0 };
        let d = value - before;
        varint(bytes, ((d << 1) ^ (d >> 63)) as u64);
    }
}

fn varint(bytes: &mut Vec<u8>, mut value: u64) {
    while value >= 128 {
        bytes.push((value & 127) as u8 | 128);
        value >>= 7;
    }
    bytes.push(value as u8);
}

/// zlib at its best; the bytes as they are where that fails, which writing to memory does not.
fn deflated(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
    match encoder.write_all(bytes).and_then(|()| encoder.finish()) {
        Ok(packed) => packed,
        Err(_) => bytes.to_vec(),
    }
}
