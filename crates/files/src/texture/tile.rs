//! Rasterises one chart: the colours of its rim, continued harmonically inside and extrapolated into a gutter.

use std::f64::consts::TAU;

use glam::DVec2;

use super::chart::Border;
use super::disk::Disk;
use super::image::Linear;
use isomend_core::elementary::{angle_of, at_angle, ln};

/// Width in texels of the painted gutter round a chart, for filters that read beyond its border.
pub(super) const GUTTER: u32 = 4;
/// Lower bound of the radius of a chart, in texels: smaller charts have hardly any texel centre well inside.
pub(super) const LEAST_RADIUS: f64 = 4.0;
/// Upper bound of the number of samples along a rim.
const MOST_SAMPLES: usize = 4096;
/// Linear light, from 0 to 1. The detail of a rim (its colours minus those interpolated between its vertices) is omitted if it is smaller
/// than this everywhere.
const LEAST_DETAIL: f64 = 1.0 / 1024.0;
/// The Fourier series is truncated where r^k falls below this.
const TERM: f64 = 1e-4;
/// Texels. Colours are extrapolated linearly up to this distance beyond the border and are constant farther out; a bilinear filter on the
/// border reads no farther.
const SLOPE: f64 = 1.5;

/// The data from which a chart is painted.
pub(super) struct Canvas<'a> {
    pub(super) disk: &'a Disk,
    pub(super) border: &'a Border,
    /// The positions of the vertices in the unit circle.
    pub(super) places: &'a [DVec2],
    /// The radius of the circle in texels.
    pub(super) radius: f64,
    /// The colours of the vertices.
    pub(super) colours: &'a [Linear],
    /// The colour of the rim at a fraction of an edge of the border; `None` on a cut.
    pub(super) rim: &'a (dyn Fn(usize, f64) -> Option<Linear> + Sync),
}

/// The side in texels of the tile of a chart with this radius.
pub(super) fn side(radius: f64) -> u32 {
    2 * (radius.ceil() as u32 + GUTTER)
}

/// The position in the tile of a point in the unit circle, in texels from the upper left corner.
pub(super) fn in_tile(place: DVec2, radius: f64) -> DVec2 {
    let centre = 0.5 * f64::from(side(radius));
    DVec2::new(centre + radius * place.x, centre - radius * place.y)
}

impl Canvas<'_> {
    /// The texels of the tile, in rows from the top.
    ///
    /// Inside, a texel is the sum of two interpolants: the colours of the vertices, harmonic on the surface and linear over each triangle;
    /// and the detail of the rim between its vertices, harmonic in the circle. Colours are extrapolated linearly into the gutter, so that a
    /// bilinear filter gives the rim's colour on the border.
    pub(super) fn painted(&self) -> Vec<Linear> {
        let side = side(self.radius) as usize;
        let detail = self.detail();
        let mut inside: Vec<Option<Linear>> = vec![None; side * side];
        for face in &self.disk.faces {
            self.paint_face(face, &detail, side, &mut inside);
        }
        let centre = DVec2::splat(0.5 * side as f64);
        (0..side * side)
            .map(|i| {
                inside[i].unwrap_or_else(|| {
                    let at = DVec2::new((i % side) as f64 + 0.5, (i / side) as f64 + 0.5);
                    self.beyond(at - centre, side, &inside)
                })
            })
            .collect()
    }

    fn paint_face(
        &self,
        face: &[u32; 3],
        detail: &Detail,
        side: usize,
        texels: &mut [Option<Linear>],
    ) {
        let [a, b, c] = face.map(|v| in_tile(self.places[v as usize], self.radius));
        let area = (b - a).perp_dot(c - a);
        if area == 0.0 {
            return;
        }
        // The texels whose centres are in the triangle's bounding box.
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let range = |axis: usize| {
            let first = (low[axis] - 0.5).ceil().max(0.0) as usize;
            let last = (high[axis] - 0.5).floor().max(-1.0) + 1.0;
            first..(last as usize).min(side)
        };
        for y in range(1) {
            for x in range(0) {
                let at = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                // Barycentric coordinates of the texel's centre.
                let parts = [
                    (b - at).perp_dot(c - at),
                    (c - at).perp_dot(a - at),
                    (a - at).perp_dot(b - at),
                ];
                let parts = parts.map(|part| part / area);
                let texel = &mut texels[y * side + x];
                // On an edge shared by two faces the first face paints.
                if texel.is_none() && parts.iter().all(|part| *part >= 0.0) {
                    let mut colour = [0.0; 4];
                    for (vertex, part) in face.iter().zip(parts) {
                        add(&mut colour, part, &self.colours[*vertex as usize]);
                    }
                    detail.add(
                        &mut colour,
                        self.in_circle(at - DVec2::splat(0.5 * side as f64)),
                    );
                    *texel = Some(colour);
                }
            }
        }
    }

    /// Maps a position relative to the tile's centre, in texels, into the unit circle: radially, so that the border polygon maps to the
    /// circle.
    fn in_circle(&self, at: DVec2) -> DVec2 {
        let at = DVec2::new(at.x, -at.y) / self.radius;
        at / self.border.at_angle(angle_of(at)).2
    }

    /// The colour beyond the border, at a position relative to the tile's centre in texels.
    fn beyond(&self, at: DVec2, side: usize, inside: &[Option<Linear>]) -> Linear {
        let (colour, distance) = self.on_border(at);
        let beyond = at.length() - distance;
        // The slope across the border, from the texel about 1.5 texels inside it.
        let inner = at.normalize_or(DVec2::X) * (distance - 1.5).max(0.0) + 0.5 * side as f64;
        let (x, y) = (inner.x as usize, inner.y as usize);
        let inner = DVec2::new(x as f64 + 0.5, y as f64 + 0.5) - 0.5 * side as f64;
        let Some(Some(other)) = inside.get(y * side + x) else {
            return colour;
        };
        let (own, end) = self.on_border(inner);
        let far = end - inner.length();
        if far < 0.5 {
            return colour;
        }
        let steps = beyond.clamp(0.0, SLOPE) / far;
        std::array::from_fn(|k| (colour[k] + steps * (own[k] - other[k])).clamp(0.0, 1.0))
    }

    /// The colour of the border in the direction of a position, and the border's distance from the centre in texels.
    fn on_border(&self, at: DVec2) -> (Linear, f64) {
        let (edge, part, distance) = self.border.at_angle(angle_of(DVec2::new(at.x, -at.y)));
        let colour = (self.rim)(edge, part).unwrap_or_else(|| self.between(edge, part));
        (colour, distance * self.radius)
    }

    /// The colour at a fraction of an edge of the border, interpolated linearly between its ends.
    fn between(&self, edge: usize, part: f64) -> Linear {
        let [a, b] = self.border.ends(edge).map(|v| &self.colours[v as usize]);
        std::array::from_fn(|k| a[k] + part * (b[k] - a[k]))
    }

    /// The difference between the rim's colours and their linear interpolation between its vertices; 0 on cuts.
    fn detail(&self) -> Detail {
        let wanted = (2.0 * TAU * self.radius).ceil() as usize;
        let count = wanted.clamp(16, MOST_SAMPLES);
        let difference = |i: usize| {
            let (edge, part, _) = self.border.at_angle(TAU * i as f64 / count as f64);
            let own = (self.rim)(edge, part)?;
            let plain = self.between(edge, part);
            Some(std::array::from_fn(|k| own[k] - plain[k]))
        };
        let samples: Vec<Linear> = (0..count)
            .map(|i| difference(i).unwrap_or_default())
            .collect();
        Detail::new(&samples)
    }
}

fn add(sum: &mut Linear, part: f64, value: &Linear) {
    for (sum, value) in sum.iter_mut().zip(value) {
        *sum += part * value;
    }
}

/// A function on the unit circle, continued harmonically into it: u(r, θ) = Re Σ c_k r^k e^{ikθ}, the real part of a polynomial in
/// z = r e^{iθ}.
struct Detail {
    /// The coefficients c_k of each of the four channels.
    coefficients: Vec<[DVec2; 4]>,
}

impl Detail {
    /// From samples at equally spaced angles, starting at 0, by a discrete Fourier transform.
    fn new(samples: &[Linear]) -> Self {
        let largest = samples
            .iter()
            .flatten()
            .fold(0.0, |l: f64, v| l.max(v.abs()));
        if largest < LEAST_DETAIL {
            return Self {
                coefficients: Vec::new(),
            };
        }
        let count = samples.len();
        let coefficient = |k: usize| {
            let step = at_angle(-TAU * k as f64 / count as f64);
            let mut turn = DVec2::X;
            let mut sum = [DVec2::ZERO; 4];
            for sample in samples {
                for (sum, value) in sum.iter_mut().zip(sample) {
                    *sum += *value * turn;
                }
                turn = step.rotate(turn);
            }
            let weight = if k == 0 { 1.0 } else { 2.0 };
            sum.map(|sum| sum * weight / count as f64)
        };
        Self {
            coefficients: (0..count.div_ceil(2)).map(coefficient).collect(),
        }
    }

    /// Adds its value at a point in the unit circle, by Horner's rule.
    fn add(&self, colour: &mut Linear, z: DVec2) {
        let radius = z.length().min(1.0);
        let terms = (ln(TERM) / ln(radius.max(1e-9))).abs().ceil().min(1e6) as usize;
        let used = &self.coefficients[..self.coefficients.len().min(terms.max(1))];
        let mut sum = [DVec2::ZERO; 4];
        for coefficient in used.iter().rev() {
            for (sum, c) in sum.iter_mut().zip(coefficient) {
                *sum = z.rotate(*sum) + *c;
            }
        }
        for (colour, sum) in colour.iter_mut().zip(sum) {
            *colour += sum.x;
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::chart::{Weights, layout};
    use super::*;

    #[test]
    fn a_harmonic_function_on_the_circle_comes_back() {
        let wanted = |z: DVec2| z.x * z.x - z.y * z.y + 0.3 * z.y - 0.1;
        let sample = |i: usize| {
            [
                wanted(DVec2::from_angle(TAU * i as f64 / 64.0)),
                0.0,
                1.0,
                -1.0,
            ]
        };
        let detail = Detail::new(&(0..64).map(sample).collect::<Vec<_>>());
        for z in [DVec2::ZERO, DVec2::new(0.5, -0.2), DVec2::new(-0.1, 0.97)] {
            let mut colour = [0.0; 4];
            detail.add(&mut colour, z);
            assert!((colour[0] - wanted(z)).abs() < 1e-3, "{colour:?}");
            assert!((colour[2] - 1.0).abs() < 1e-9 && (colour[3] + 1.0).abs() < 1e-9);
        }
    }

    /// Bilinear sampling gives the rim's colour on the border, and inside the harmonic function that the rim's colours are taken from.
    #[test]
    fn the_border_has_the_colours_of_the_rim() {
        let count = 24;
        let mut points = vec![DVec3::ZERO];
        points.extend(
            (0..count)
                .map(|i| DVec2::from_angle(TAU * f64::from(i) / f64::from(count)).extend(0.0)),
        );
        let faces: Vec<[u32; 3]> = (0..count)
            .map(|i| [0, 1 + i, 1 + (i + 1) % count])
            .collect();
        let disk = Disk::cut(&faces).unwrap();
        let own: Vec<DVec3> = disk.slots.iter().map(|s| points[*s as usize]).collect();
        let border = Border::new(&disk, &own);
        let places = layout(
            &disk,
            &own,
            &border,
            Weights::MeanValue,
            &isomend_core::cancel::Cancel::new(),
        );
        // A wave that vanishes at the vertices of the rim.
        let wave = |edge: usize, part: f64| {
            0.5 + 0.2 * places[border.ends(edge)[0] as usize].x + 0.1 * (TAU * part).sin()
        };
        let colours: Vec<Linear> = places
            .iter()
            .map(|p| [0.5 + 0.2 * p.x, 0.5, 0.5, 1.0])
            .collect();
        let rim = |edge: usize, part: f64| {
            let [a, b] = border.ends(edge).map(|v| places[v as usize].x);
            let plain = wave(edge, part) + 0.2 * part * (b - a);
            Some([plain, 0.5, 0.5, 1.0])
        };
        let canvas = Canvas {
            disk: &disk,
            border: &border,
            places: &places,
            radius: 60.0,
            colours: &colours,
            rim: &rim,
        };
        let texels = canvas.painted();
        let side = side(60.0) as usize;
        let read = |at: DVec2| {
            let low = (at - 0.5).floor();
            let part = at - 0.5 - low;
            let texel = |x: f64, y: f64| texels[y as usize * side + x as usize][0];
            let row = |y: f64| texel(low.x, y) * (1.0 - part.x) + texel(low.x + 1.0, y) * part.x;
            row(low.y) * (1.0 - part.y) + row(low.y + 1.0) * part.y
        };
        for i in 0..500 {
            let direction = DVec2::from_angle(TAU * f64::from(i) / 500.0);
            let (edge, part, distance) = border.at_angle(direction.to_angle());
            let found = read(in_tile(distance * direction, 60.0));
            let wanted = rim(edge, part).unwrap()[0];
            assert!((found - wanted).abs() < 0.01, "{found} {wanted}");
            let inner = 0.5 * direction;
            assert!((read(in_tile(inner, 60.0)) - 0.5 - 0.2 * inner.x).abs() < 0.01);
        }
    }
}
