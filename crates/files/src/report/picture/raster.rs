//! Software rasteriser: orthographic projection with a depth buffer, which finds the visible face at each sample.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::super::scene::{Scene, Side};

/// Marks a sample without a face.
pub const NONE: u32 = u32::MAX;
/// Samples. Rounding moves the edges of a face on the screen by less.
const ROUNDING: f32 = 0.05;
/// Rows of a band; bands are drawn in parallel.
const BAND: usize = 16;

/// An orthographic camera.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    /// Unit vector to the right.
    pub right: Vec3,
    /// Unit vector upward.
    pub up: Vec3,
    /// Unit vector towards the eye.
    pub towards: Vec3,
    /// The point in the middle of the picture.
    pub centre: Vec3,
    /// Half of the picture's height, in units of the scene.
    pub reach: f32,
}

impl Camera {
    /// A camera whose eye is in the direction `towards`, with `up` as upright as possible.
    pub fn new(towards: Vec3, up: Vec3, centre: Vec3, reach: f32) -> Self {
        let towards = towards.try_normalize().unwrap_or(Vec3::X);
        let right = up.cross(towards);
        let right = match right.try_normalize() {
            Some(right) if right.is_finite() && up.dot(towards).abs() < 0.999 => right,
            _ => towards.any_orthonormal_vector(),
        };
        Self {
            right,
            up: towards.cross(right),
            towards,
            centre,
            reach: reach.max(f32::MIN_POSITIVE),
        }
    }

    /// The same from another direction.
    pub fn towards(&self, towards: Vec3, up: Vec3) -> Self {
        Self::new(towards, up, self.centre, self.reach)
    }

    /// Coordinates of a point to the right, up and towards the eye, in units of half the height. Larger depths are nearer.
    pub fn place(&self, p: Vec3) -> Vec3 {
        let d = (p - self.centre) / self.reach;
        Vec3::new(d.dot(self.right), d.dot(self.up), d.dot(self.towards))
    }
}

/// A face, projected onto the screen.
#[derive(Clone, Copy)]
pub struct Projected {
    /// Its number in the scene.
    pub face: u32,
    /// Its corners in samples, with their depths.
    pub corners: [Vec3; 3],
    low: Vec2,
    high: Vec2,
    /// Twice its signed area on the screen; see [`Projected::is_back`].
    area: f32,
}

impl Projected {
    /// Barycentric coordinates of a sample.
    pub fn weights(&self, x: f32, y: f32) -> [f32; 3] {
        let [a, b, c] = self.corners;
        let edge = |p: Vec3, q: Vec3| (q.x - p.x) * (y - p.y) - (q.y - p.y) * (x - p.x);
        let first = edge(b, c) / self.area;
        let second = edge(c, a) / self.area;
        [first, second, 1.0 - first - second]
    }

    /// Its edges, for the rows that it covers.
    fn sides(&self) -> [ScreenEdge; 3] {
        std::array::from_fn(|k| ScreenEdge::new(self.corners[k], self.corners[(k + 1) % 3]))
    }

    /// Whether its back side is seen. Rows of the screen run downward, so this is a positive area.
    pub fn is_back(&self) -> bool {
        self.area > 0.0
    }

    /// Distance in samples from the point with these barycentric coordinates to the nearest edge.
    pub fn edge_distance(&self, weights: [f32; 3]) -> f32 {
        (0..3)
            .map(|k| {
                let edge = self.corners[(k + 2) % 3] - self.corners[(k + 1) % 3];
                weights[k] * self.area.abs() / edge.truncate().length().max(1e-6)
            })
            .fold(f32::INFINITY, f32::min)
    }
}

/// An edge of a face on the screen, from its upper to its lower end.
#[derive(Clone, Copy)]
struct ScreenEdge {
    /// Its upper end.
    top: Vec2,
    /// Row of its lower end.
    bottom: f32,
    /// Its smallest and largest column.
    columns: [f32; 2],
    /// Columns for each row; not finite if it is level.
    slope: f32,
}

impl ScreenEdge {
    fn new(p: Vec3, q: Vec3) -> Self {
        let (p, q) = if p.y <= q.y { (p, q) } else { (q, p) };
        Self {
            top: p.truncate(),
            bottom: q.y,
            columns: [p.x.min(q.x), p.x.max(q.x)],
            slope: (q.x - p.x) / (q.y - p.y),
        }
    }

    /// The smallest and largest x of the edge within [`ROUNDING`] of a row of samples; empty if it does not reach the row.
    fn span(&self, y: f32) -> [f32; 2] {
        if y < self.top.y - ROUNDING || y > self.bottom + ROUNDING {
            return [f32::INFINITY, f32::NEG_INFINITY];
        }
        let [left, right] = self.columns;
        let x = self.top.x + self.slope * (y - self.top.y);
        let reach = self.slope.abs() * ROUNDING;
        // `max` and `min` replace the NaN of a level edge by its ends.
        [
            (x - reach).max(left).min(right),
            (x + reach).min(right).max(left),
        ]
    }
}

/// The visible face at each sample.
pub struct Seen {
    /// Samples in a row.
    pub width: usize,
    /// The faces inside the picture.
    pub faces: Vec<Projected>,
    /// For each sample, the index of its visible face in `faces`, or [`NONE`].
    pub nearest: Vec<u32>,
}

impl Seen {
    /// The depth of the surface at a sample, in units of half the height; larger is nearer.
    pub fn depth(&self, x: usize, y: usize) -> f32 {
        let Some(face) = self.faces.get(self.nearest[y * self.width + x] as usize) else {
            return f32::NEG_INFINITY;
        };
        let weights = face.weights(x as f32 + 0.5, y as f32 + 0.5);
        (0..3).map(|k| weights[k] * face.corners[k].z).sum()
    }
}

/// Draws one side of a scene into `width` × `height` samples.
pub fn draw(scene: &Scene, side: Side, camera: &Camera, [width, height]: [usize; 2]) -> Seen {
    let faces = project(scene, side, camera, [width, height]);
    let mut bands: Vec<Vec<u32>> = vec![Vec::new(); height.div_ceil(BAND)];
    for (i, face) in faces.iter().enumerate() {
        let first = face.low.y.max(0.0) as usize / BAND;
        let last = (face.high.y.max(0.0) as usize / BAND).min(bands.len() - 1);
        (first..=last).for_each(|band| bands[band].push(i as u32));
    }
    let mut nearest = vec![NONE; width * height];
    nearest
        .par_chunks_mut(BAND * width)
        .zip(&bands)
        .enumerate()
        .for_each(|(band, (samples, members))| {
            let mut depth = vec![f32::NEG_INFINITY; samples.len()];
            for &i in members {
                fill(
                    &faces[i as usize],
                    i,
                    band * BAND,
                    width,
                    samples,
                    &mut depth,
                );
            }
        });
    Seen {
        width,
        faces,
        nearest,
    }
}

/// Projects the faces of one side; drops those outside the picture and those seen edge-on.
fn project(
    scene: &Scene,
    side: Side,
    camera: &Camera,
    [width, height]: [usize; 2],
) -> Vec<Projected> {
    let half = Vec2::new(width as f32, height as f32) * 0.5;
    let places: Vec<Vec3> = scene
        .positions
        .par_iter()
        .map(|&p| {
            let q = camera.place(p);
            Vec3::new(half.x + q.x * half.y, half.y - q.y * half.y, q.z)
        })
        .collect();
    let numbers: Vec<u32> = scene.side(side).collect();
    numbers
        .into_par_iter()
        .filter_map(|face| {
            let corners = scene.faces[face as usize].map(|v| places[v as usize]);
            let [a, b, c] = corners.map(Vec3::truncate);
            let (low, high) = (a.min(b).min(c), a.max(b).max(c));
            let inside =
                high.x >= 0.0 && high.y >= 0.0 && low.x < width as f32 && low.y < height as f32;
            let area = (b - a).perp_dot(c - a);
            (inside && area != 0.0 && area.is_finite()).then_some(Projected {
                face,
                corners,
                low,
                high,
                area,
            })
        })
        .collect()
}

/// Draws a face into the samples of a band where it is nearer than the faces before.
fn fill(
    face: &Projected,
    index: u32,
    first_row: usize,
    width: usize,
    samples: &mut [u32],
    depth: &mut [f32],
) {
    let rows = samples.len() / width;
    let start = |x: f32| (x - 0.5).ceil().max(0.0) as usize;
    let end = |x: f32| (x - 0.5).floor().max(-1.0) as isize;
    let top = start(face.low.y).max(first_row);
    let bottom = end(face.high.y).min((first_row + rows) as isize - 1);
    let (left, right) = (start(face.low.x), end(face.high.x).min(width as isize - 1));
    let sides = face.sides();
    for y in top as isize..=bottom {
        // A long, thin face covers few samples of its bounding box.
        let [a, b, c] = sides.map(|side| side.span(y as f32 + 0.5));
        let (low, high) = (a[0].min(b[0]).min(c[0]), a[1].max(b[1]).max(c[1]));
        if low > high {
            continue;
        }
        let (left, right) = (
            left.max(start(low - ROUNDING)),
            right.min(end(high + ROUNDING)),
        );
        for x in left as isize..=right {
            let weights = face.weights(x as f32 + 0.5, y as f32 + 0.5);
            if weights.iter().any(|w| *w < 0.0) {
                continue;
            }
            let z: f32 = (0..3).map(|k| weights[k] * face.corners[k].z).sum();
            let at = (y as usize - first_row) * width + x as usize;
            if z > depth[at] {
                depth[at] = z;
                samples[at] = index;
            }
        }
    }
}
