//! Draws the rims and numbers of holes over a panel, and marked points with their numbers.

use glam::{Vec2, Vec3};

use super::super::scene::Scene;
use super::letters;
use super::raster::{Camera, Seen};

/// Colour of rims and of the numbers of holes.
const BLUE: [f32; 3] = [16.0, 74.0, 150.0];
/// Half the width of a rim's line, in pixels.
const HALF_WIDTH: f32 = 1.0;
/// Colour of marked points and their numbers.
const RED: [f32; 3] = [176.0, 24.0, 60.0];
/// Radius of marked points, in pixels.
const RADIUS: f32 = 3.5;
/// Candidate offsets of a number from its point, in pixels; the first free one is used.
const BESIDE: [Vec2; 4] = [
    Vec2::new(13.0, -11.0),
    Vec2::new(-13.0, -11.0),
    Vec2::new(13.0, 12.0),
    Vec2::new(-13.0, 12.0),
];
/// Rims are drawn this much nearer to the eye than the surface, so that it does not hide them. In units of the panel's half height.
const LIFT: f32 = 0.01;
/// Most numbers on a panel; the longest holes come first.
const NUMBERS: usize = 200;
/// About this many vertices of a rim are tested for visibility.
const LOOKED_AT: usize = 64;
/// A number is drawn if at least this fraction of the tested vertices is visible.
const SEEN_PART: f32 = 0.25;
/// A number is hidden if the surface is nearer to the eye than the middle of its hole by more than this fraction of the hole's size. The
/// hole's patch bulges less, so it does not hide the number.
const BULGE: f32 = 0.45;

/// A panel to draw on.
struct Sheet<'a> {
    camera: &'a Camera,
    seen: &'a Seen,
    /// Pixels along a side of the panel.
    pixels: usize,
    /// Samples along a pixel's side.
    samples: usize,
}

/// Draws all rims, the numbers of the longest holes with visible rims, and the visible marked points.
pub fn draw(
    out: &mut [u8],
    scene: &Scene,
    camera: &Camera,
    seen: &Seen,
    [pixels, samples]: [usize; 2],
) {
    let sheet = Sheet {
        camera,
        seen,
        pixels,
        samples,
    };
    let mut ink = vec![0.0f32; pixels * pixels];
    for rim in &scene.rims {
        for (i, &a) in rim.iter().enumerate() {
            sheet.line(&mut ink, [a, rim[(i + 1) % rim.len()]]);
        }
    }
    for (rgb, ink) in out.chunks_mut(3).zip(&ink).filter(|(_, ink)| **ink > 0.0) {
        for (byte, colour) in rgb.iter_mut().zip(BLUE) {
            *byte = (f32::from(*byte) * (1.0 - ink) + colour * ink) as u8;
        }
    }
    let mut taken: Vec<[Vec2; 2]> = Vec::new();
    for (rim, number) in scene.rims.iter().zip(1..).take(NUMBERS) {
        if let Some(middle) = sheet.middle(rim) {
            sheet.number(out, number, middle, (BLUE, &mut taken));
        }
    }
    sheet.points(out, &scene.points, &mut taken);
}

impl Sheet<'_> {
    /// A point in pixels, with its depth.
    fn place(&self, p: Vec3) -> Vec3 {
        let q = self.camera.place(p);
        let half = 0.5 * self.pixels as f32;
        Vec3::new(half + q.x * half, half - q.y * half, q.z)
    }

    /// Whether a point, moved `lift` towards the eye, is in front of the surface; `None` outside the panel.
    fn is_seen(&self, p: Vec3, lift: f32) -> Option<bool> {
        let side = self.pixels as f32;
        if !(p.x >= 0.0 && p.y >= 0.0 && p.x < side && p.y < side) {
            return None;
        }
        let sample = |x: f32| (x * self.samples as f32) as usize;
        let surface = self.seen.depth(sample(p.x), sample(p.y));
        Some(p.z + lift >= surface)
    }

    /// Writes a number centred at a point, unless it would overlap something drawn before or the edge of the panel. Returns whether it was
    /// written.
    fn number(
        &self,
        out: &mut [u8],
        number: usize,
        middle: Vec2,
        (colour, taken): ([f32; 3], &mut Vec<[Vec2; 2]>),
    ) -> bool {
        let place = letters::place_of_number(number, middle);
        let clear =
            |other: &[Vec2; 2]| place[0].cmpgt(other[1]).any() || place[1].cmplt(other[0]).any();
        let most = Vec2::splat(self.pixels as f32);
        let inside = place[0].cmpge(Vec2::ZERO).all() && place[1].cmple(most).all();
        let is_free = inside && taken.iter().all(clear);
        if is_free {
            letters::number(out, self.pixels, number, middle, colour);
            taken.push(place);
        }
        is_free
    }

    /// Draws the visible marked points, with their numbers where there is room.
    fn points(&self, out: &mut [u8], points: &[Vec3], taken: &mut Vec<[Vec2; 2]>) {
        let seen = points.iter().zip(1..).filter_map(|(p, number)| {
            let place = self.place(*p);
            (self.is_seen(place, LIFT) == Some(true)).then_some((place.truncate(), number))
        });
        let seen: Vec<(Vec2, usize)> = seen.collect();
        for (middle, _) in &seen {
            self.dot(out, *middle);
            taken.push([*middle - RADIUS, *middle + RADIUS]);
        }
        for (middle, number) in seen.into_iter().take(NUMBERS) {
            BESIDE
                .into_iter()
                .find(|off| self.number(out, number, middle + *off, (RED, &mut *taken)));
        }
    }

    /// Draws a disc.
    fn dot(&self, out: &mut [u8], middle: Vec2) {
        let most = Vec2::splat(self.pixels as f32 - 1.0);
        let low = (middle - RADIUS - 1.0).max(Vec2::ZERO);
        let high = (middle + RADIUS + 1.0).min(most);
        for y in low.y as usize..=high.y as usize {
            for x in low.x as usize..=high.x as usize {
                let away = middle.distance(Vec2::new(x as f32 + 0.5, y as f32 + 0.5));
                let ink = (RADIUS + 0.5 - away).clamp(0.0, 1.0);
                for (byte, colour) in out[3 * (y * self.pixels + x)..][..3].iter_mut().zip(RED) {
                    *byte = (f32::from(*byte) * (1.0 - ink) + colour * ink) as u8;
                }
            }
        }
    }

    /// Adds the visible part of a line to the ink of the pixels.
    fn line(&self, ink: &mut [f32], ends: [Vec3; 2]) {
        let [a, b] = ends.map(|p| self.place(p));
        if !(a.is_finite() && b.is_finite()) {
            return;
        }
        let (from, to) = (a.truncate(), b.truncate());
        let reach = Vec2::splat(HALF_WIDTH + 1.0);
        let most = Vec2::splat(self.pixels as f32 - 1.0);
        let low = (from.min(to) - reach).max(Vec2::ZERO);
        let high = (from.max(to) + reach).min(most);
        if low.cmpgt(high).any() {
            return;
        }
        for y in low.y as usize..=high.y as usize {
            for x in low.x as usize..=high.x as usize {
                let p = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
                let (away, along) = letters::distance(p, (from, to));
                let strength = (HALF_WIDTH + 0.5 - away).clamp(0.0, 1.0);
                let slot = &mut ink[y * self.pixels + x];
                let depth = a.z + along * (b.z - a.z);
                if strength > *slot && self.is_seen(p.extend(depth), LIFT) == Some(true) {
                    *slot = strength;
                }
            }
        }
    }

    /// The middle of a rim on the panel, if enough of the rim is visible.
    fn middle(&self, rim: &[Vec3]) -> Option<Vec2> {
        let start = (Vec3::INFINITY, Vec3::NEG_INFINITY, Vec3::ZERO);
        let (low, high, sum) = rim
            .iter()
            .fold(start, |(l, h, s), &p| (l.min(p), h.max(p), s + p));
        let middle = self.place(sum / rim.len() as f32);
        let size = low.distance(high) / self.camera.reach;
        if !self.is_seen(middle, BULGE * size)? {
            return None;
        }
        let step = rim.len().div_ceil(LOOKED_AT).max(1);
        let looked_at = rim.iter().step_by(step);
        let seen = looked_at
            .clone()
            .filter(|p| self.is_seen(self.place(**p), LIFT) == Some(true));
        let enough = seen.count() as f32 >= SEEN_PART * looked_at.count() as f32;
        enough.then_some(middle.truncate())
    }
}
