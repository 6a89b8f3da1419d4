//! Text in pictures, drawn as strokes: the titles of the panels and the numbers of holes.

use glam::Vec2;

use super::super::scene::Side;

/// Height of a title's capitals, in pixels.
const HEIGHT: f32 = 17.0;
/// Distance of a title from the top left corner of its panel, in pixels.
const MARGIN: f32 = 16.0;
/// Half the stroke width of titles, in pixels.
const PEN: f32 = 1.05;
/// Grey of titles, from 0 to 255.
const INK: f32 = 70.0;

/// Polylines of a letter in a box of height 6 and width 4, with the origin at the top left.
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

/// The lower loop of 6 and 8.
const ROUND: &[(f32, f32)] = &[
    (2.0, 2.8),
    (0.8, 3.2),
    (0.2, 4.3),
    (0.8, 5.6),
    (2.0, 6.0),
    (3.2, 5.6),
    (3.8, 4.3),
    (3.2, 3.2),
    (2.0, 2.8),
];
const DIGITS: [Strokes; 10] = [
    &[&[
        (2.0, 0.0),
        (0.9, 0.5),
        (0.3, 1.7),
        (0.3, 4.3),
        (0.9, 5.5),
        (2.0, 6.0),
        (3.1, 5.5),
        (3.7, 4.3),
        (3.7, 1.7),
        (3.1, 0.5),
        (2.0, 0.0),
    ]],
    &[&[(0.7, 1.3), (2.3, 0.0), (2.3, 6.0)]],
    &[&[
        (0.3, 1.5),
        (0.8, 0.4),
        (2.0, 0.0),
        (3.2, 0.4),
        (3.6, 1.5),
        (3.2, 2.6),
        (0.3, 6.0),
        (3.8, 6.0),
    ]],
    &[&[
        (0.3, 0.8),
        (1.9, 0.0),
        (3.2, 0.4),
        (3.5, 1.4),
        (3.1, 2.4),
        (1.7, 2.8),
        (3.2, 3.2),
        (3.8, 4.3),
        (3.3, 5.5),
        (1.9, 6.0),
        (0.2, 5.2),
    ]],
    &[&[(2.9, 6.0), (2.9, 0.0), (0.1, 4.3), (4.0, 4.3)]],
    &[&[
        (3.5, 0.0),
        (0.8, 0.0),
        (0.5, 2.7),
        (1.9, 2.3),
        (3.3, 2.8),
        (3.8, 4.1),
        (3.3, 5.5),
        (1.9, 6.0),
        (0.3, 5.3),
    ]],
    &[&[(3.3, 0.3), (2.0, 0.4), (0.8, 1.7), (0.2, 4.3)], ROUND],
    &[&[(0.2, 0.0), (3.8, 0.0), (1.5, 6.0)]],
    &[
        &[
            (2.0, 0.0),
            (0.9, 0.4),
            (0.5, 1.4),
            (0.9, 2.4),
            (2.0, 2.8),
            (3.1, 2.4),
            (3.5, 1.4),
            (3.1, 0.4),
            (2.0, 0.0),
        ],
        ROUND,
    ],
    &[
        &[
            (2.0, 0.0),
            (0.8, 0.4),
            (0.2, 1.7),
            (0.8, 2.8),
            (2.0, 3.2),
            (3.2, 2.8),
            (3.8, 1.7),
            (3.2, 0.4),
            (2.0, 0.0),
        ],
        &[(3.8, 1.7), (3.2, 4.3), (2.0, 5.6), (0.7, 5.7)],
    ],
];
/// Height of a number, in pixels.
const NUMBER: f32 = 14.0;
/// Half the stroke width of numbers, in pixels.
const NUMBER_PEN: f32 = 1.0;
/// Half the stroke width of the white outline of numbers, in pixels.
const HALO: f32 = 3.2;
/// Distance between the left sides of adjacent digits, in sixths of the height.
const ADVANCE: f32 = 5.4;

/// Line segments by their ends, in pixels.
type Lines = Vec<(Vec2, Vec2)>;

/// The lines of a word. `corner` is its top left corner in pixels, `unit` the pixels of a letter's unit, `advance` the units from letter to
/// letter.
fn lines(word: &[Strokes], corner: Vec2, unit: f32, advance: f32) -> Lines {
    let letters = word.iter().enumerate();
    letters
        .flat_map(|(i, letter)| letter.iter().map(move |stroke| (i, stroke)))
        .flat_map(|(i, stroke)| {
            let place =
                move |&(x, y): &(f32, f32)| corner + Vec2::new(x + advance * i as f32, y) * unit;
            stroke.windows(2).map(move |w| (place(&w[0]), place(&w[1])))
        })
        .collect()
}

/// Draws lines into the part of a picture from `low` to `high`. `pen` is half the stroke width in pixels.
fn draw(
    pixels: &mut [u8],
    width: usize,
    [low, high]: [Vec2; 2],
    lines: &Lines,
    (pen, colour): (f32, [f32; 3]),
) {
    let rows = pixels.len() / (3 * width);
    let (low, high) = (low.max(Vec2::ZERO), high.max(Vec2::ZERO));
    for y in low.y as usize..(high.y as usize).min(rows) {
        for x in low.x as usize..(high.x as usize).min(width) {
            let p = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
            let near = lines
                .iter()
                .map(|l| distance(p, *l).0)
                .fold(f32::MAX, f32::min);
            let ink = (pen + 0.5 - near).clamp(0.0, 1.0);
            for (byte, colour) in pixels[3 * (y * width + x)..][..3].iter_mut().zip(colour) {
                *byte = (f32::from(*byte) * (1.0 - ink) + colour * ink) as u8;
            }
        }
    }
}

/// Writes the name of a side at the top of a picture that is `width` pixels wide, `left` pixels from its left edge.
pub fn write(pixels: &mut [u8], width: usize, left: usize, side: Side) {
    let word: &[Strokes] = match side {
        Side::Before => &[B, E, F, O, R, E],
        Side::After => &[A, F, T, E, R],
    };
    let unit = HEIGHT / 6.0;
    let corner = Vec2::new(left as f32 + MARGIN, MARGIN);
    let lines = lines(word, corner, unit, 6.0);
    let end = corner + Vec2::new(unit * 6.0 * word.len() as f32 + 2.0, HEIGHT + 4.0);
    let area = [Vec2::new(left as f32, 0.0), end];
    draw(pixels, width, area, &lines, (PEN, [INK; 3]));
}

/// The box of a number that is centred at a point, in pixels.
pub fn place_of_number(number: usize, middle: Vec2) -> [Vec2; 2] {
    let digits = number.to_string().len() as f32;
    let half = 0.5 * Vec2::new(NUMBER / 6.0 * (ADVANCE * digits - 1.4), NUMBER);
    [middle - half - HALO - 1.0, middle + half + HALO + 1.0]
}

/// Writes a number centred at a point, with a white outline.
pub fn number(pixels: &mut [u8], width: usize, number: usize, middle: Vec2, colour: [f32; 3]) {
    let word: Vec<Strokes> = number
        .to_string()
        .bytes()
        .map(|b| DIGITS[usize::from(b - b'0')])
        .collect();
    let area = place_of_number(number, middle);
    let lines = lines(&word, area[0] + HALO + 1.0, NUMBER / 6.0, ADVANCE);
    for (pen, colour) in [(HALO, [255.0; 3]), (NUMBER_PEN, colour)] {
        draw(pixels, width, area, &lines, (pen, colour));
    }
}

/// Distance of a point from a line segment, and the parameter of the nearest point, from 0 to 1.
pub fn distance(p: Vec2, (a, b): (Vec2, Vec2)) -> (f32, f32) {
    let along = ((p - a).dot(b - a) / (b - a).length_squared().max(1e-6)).clamp(0.0, 1.0);
    (p.distance(a + along * (b - a)), along)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_number_looks_different_and_stays_in_its_place() {
        let (width, middle) = (80, Vec2::splat(40.0));
        let mut seen = Vec::new();
        for n in (0..10).chain([10, 17, 200]) {
            let mut pixels = vec![128u8; 3 * width * width];
            number(&mut pixels, width, n, middle, [0.0; 3]);
            let [low, high] = place_of_number(n, middle);
            let inked: Vec<usize> = (0..width * width)
                .filter(|i| pixels[3 * i] != 128)
                .collect();
            assert!(inked.iter().any(|i| pixels[3 * i] < 20), "{n} has ink");
            assert!(
                inked.iter().any(|i| pixels[3 * i] > 240),
                "{n} has white round it"
            );
            for i in inked {
                let p = Vec2::new((i % width) as f32, (i / width) as f32);
                assert!(
                    p.cmpge(low - 1.0).all() && p.cmple(high).all(),
                    "{n} at {p}"
                );
            }
            assert!(!seen.contains(&pixels), "{n} looks like another");
            seen.push(pixels);
        }
    }
}
