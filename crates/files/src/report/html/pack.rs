//! Packs a scene as text for the page's script: arrays of integers, stored as differences in variable-length bytes, compressed by zlib and
//! encoded in base64.

use std::io::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use glam::Vec3;
use serde::Serialize;

use super::super::picture::views;
use super::super::scene::Scene;

/// Quantisation steps of positions along the scene's diameter (2^20).
const STEPS: f64 = 1_048_576.0;
/// Curvatures, distances and expected errors are scaled to integers up to this.
const VALUES: f32 = 127.0;
/// The largest values, this fraction of all, are clipped: all get the last colour of the scale.
const OUTLIERS: f64 = 0.03;

/// The data that the script needs besides the arrays.
#[derive(Serialize)]
pub struct Header {
    /// A coordinate is its integer times `step`, minus `radius`.
    step: f64,
    radius: f64,
    /// Origin of the positions in the mesh's coordinates.
    origin: [f64; 3],
    /// Number of faces that both meshes have.
    kept: usize,
    /// Number of new faces.
    new: usize,
    /// Curvature at the end of the colour scale.
    curvature: f32,
    /// Distance at the end of the colour scale.
    distance: f32,
    /// Expected error at the end of the colour scale; 0 if none is known.
    error: f32,
    /// Whether new faces get a different colour.
    marks: bool,
    /// The colour of each region as red, green and blue from 0 to 1; empty if all regions have the same.
    palette: Vec<[f32; 3]>,
    /// First camera: direction to the eye.
    towards: [f32; 3],
    /// First camera: the point in the middle.
    centre: [f32; 3],
    /// First camera: half the height of the picture, in units of the mesh.
    reach: f32,
    /// First camera: the upward direction.
    up: [f32; 3],
}

/// The arrays as text, and the header for reading them.
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
    // Errors are never negative, so a negative value marks an unknown one.
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

/// The end of a colour scale: the value that all but the fraction [`OUTLIERS`] of the values do not exceed.
fn limit(values: impl Iterator<Item = f32>) -> f32 {
    let mut values: Vec<f32> = values.filter(|v| v.is_finite()).collect();
    values.sort_unstable_by(f32::total_cmp);
    let at = (values.len() as f64 * (1.0 - OUTLIERS)) as usize;
    values.get(at).or(values.last()).copied().unwrap_or(0.0)
}

/// A direction as two integers in ±1023: projected onto an octahedron, which is unfolded into a square (Meyer et al. 2010).
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

/// Appends an array: its length, its stride, then the difference of each value from the value one stride before, zigzag-encoded.
fn array(bytes: &mut Vec<u8>, stride: usize, values: &[i64]) {
    varint(bytes, values.len() as u64);
    varint(bytes, stride as u64);
    for (i, value) in values.iter().enumerate() {
        let before = if i >= stride { values[i - stride] } else { 0 };
        let d = value - before;
        varint(bytes, ((d << 1) ^ (d >> 63)) as u64);
    }
}

/// Appends a number in bytes of seven bits, lowest first; the eighth bit says that more bytes follow.
fn varint(bytes: &mut Vec<u8>, mut value: u64) {
    while value >= 128 {
        bytes.push((value & 127) as u8 | 128);
        value >>= 7;
    }
    bytes.push(value as u8);
}

/// Compresses bytes by zlib at its highest level. Writing to memory does not fail; if it did, the bytes would stay uncompressed.
fn deflated(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
    match encoder.write_all(bytes).and_then(|()| encoder.finish()) {
        Ok(packed) => packed,
        Err(_) => bytes.to_vec(),
    }
}
