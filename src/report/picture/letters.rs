//! The words over the panels, as strokes.

use glam::Vec2;

use super::super::view::Side;

/// Height of a capital in pixels, from the top left corner so far.
const HEIGHT: f32 = 17.0;
const MARGIN: f32 = 16.0;
/// Half the width of a stroke.
const PEN: f32 = 1.05;
const INK: f32 = 70.0;

/// Lines of a letter in a box as high as 6 and as wide as 4, from the top left.
type Strokes = &'static [&'static [(f32, f32)]];

const B: Strokes = &[
    &[
        (0.0, 0.0),
        (0.0, 6.0),
        (2.6, 6.0),
        (3.6, 5.5),
        (4.0, 4.5),
        (3.6, 3.4),
        (2.6, 2.9),
        (0.0, 2.9),
    ],
    &[
        (0.0, 0.0),
        (2.3, 0.0),
        (3.2, 0.4),
        (3.6, 1.4),
        (3.2, 2.5),
        (2.3, 2.9),
    ],
];
const E: Strokes = &[
    &[(3.6, 0.0), (0.0, 0.0), (0.0, 6.0), (3.6, 6.0)],
    &[(0.0, 2.9), (3.0, 2.9)],
];
const F: Strokes = &[
    &[(3.6, 0.0), (0.0, 0.0), (0.0, 6.0)],
    &[(0.0, 2.9), (3.0, 2.9)],
];
const O: Strokes = &[&[
    (2.2, 0.0),
    (0.9, 0.5),
    (0.1, 1.7),
    (-0.1, 3.0),
    (0.1, 4.3),
    (0.9, 5.5),
    (2.2, 6.0),
    (3.5, 5.5),
    (4.3, 4.3),
    (4.5, 3.0),
    (4.3, 1.7),
    (3.5, 0.5),
    (2.2, 0.0),
]];
const R: Strokes = &[
    &[
        (0.0, 6.0),
        (0.0, 0.0),
        (2.4, 0.0),
        (3.4, 0.4),
        (3.8, 1.5),
        (3.4, 2.6),
        (2.4, 3.0),
        (0.0, 3.0),
    ],
    &[(2.2, 3.0), (4.0, 6.0)],
];
const A: Strokes = &[
    &[(-0.1, 6.0), (2.1, 0.0), (4.3, 6.0)],
    &[(0.65, 4.0), (3.55, 4.0)],
];
const T: Strokes = &[&[(0.0, 0.0), (4.2, 0.0)], &[(2.1, 0.0), (2.1, 6.0)]];

/// Writes the name of a side at the upper edge of a picture of so many pixels in a row, from `left` on.
pub fn write(pixels: &mut [u8], width: usize, left: usize, side: Side) {
    let word: &[Strokes] = match side {
        Side::Before => &[B, E, F, O, R, E],
        Side::After => &[A, F, T, E, R],
    };
    let unit = HEIGHT / 6.0;
    let lines: Vec<(Vec2, Vec2)> = word
        .iter()
        .enumerate()
        .flat_map(|(i, letter)| letter.iter().map(move |stroke| (i, stroke)))
        .flat_map(|(i, stroke)| {
            let place =
                move |&(x, y): &(f32, f32)| MARGIN + Vec2::new(x + 6.0 * i as f32, y) * unit;
            stroke.windows(2).map(move |w| (place(&w[0]), place(&w[1])))
        })
        .collect();
    let right = (MARGIN + unit * 6.0 * word.len() as f32) as usize + 2;
    for y in 0..((MARGIN + HEIGHT) as usize + 4) {
        for x in 0..right.min(width - left) {
            let p = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
            let near = lines
                .iter()
                .map(|l| distance(p, *l))
                .fold(f32::MAX, f32::min);
            let ink = (PEN + 0.5 - near).clamp(0.0, 1.0);
            for byte in &mut pixels[3 * (y * width + left + x)..][..3] {
                *byte = (f32::from(*byte) * (1.0 - ink) + INK * ink) as u8;
            }
        }
    }
}

/// Distance of a point from a line.
fn distance(p: Vec2, (a, b): (Vec2, Vec2)) -> f32 {
    let along = ((p - a).dot(b - a) / (b - a).length_squared().max(1e-6)).clamp(0.0, 1.0);
    p.distance(a + along * (b - a))
}
