//! PNG pictures of a mesh before and after, rendered in software.
//!
//! The upper row shows the whole mesh, the lower row the largest patch with its triangles. Holes are outlined and numbered. The same scene
//! gives the same bytes at any number of threads.

mod camera;
mod letters;
mod overlay;
mod raster;
mod shade;

use super::scene::{Scene, Side};
use raster::Camera;
use thiserror::Error;

pub(crate) use camera::views;

/// Height and width of a panel in pixels.
const PANEL: usize = 720;
/// Samples along a pixel's side, for antialiasing.
const SAMPLES: usize = 3;
/// Pixels between panels.
const GAP: usize = 8;
/// Pixels above the panels for their titles.
const HEAD: usize = 44;

/// Why a picture could not be encoded.
#[derive(Debug, Error)]
#[error("cannot encode the picture: {0}")]
pub struct PictureError(#[from] png::EncodingError);

/// A panel: the side that it shows, the camera, and whether edges are drawn.
type Panel = (Side, Camera, bool);

/// Draws a scene as a PNG file: before and after, below them close-ups of the largest patch; with the rims of holes, and the numbers of
/// the longest ones.
///
/// # Errors
/// If the encoder fails, which happens only if memory runs out.
pub fn picture(scene: &Scene) -> Result<Vec<u8>, PictureError> {
    let views = views(scene);
    let rows: Vec<[Panel; 2]> = [Some((views.whole, false)), views.close.map(|c| (c, true))]
        .into_iter()
        .flatten()
        .map(|(camera, edges)| [Side::Before, Side::After].map(|side| (side, camera, edges)))
        .collect();
    drawn(scene, &rows, true)
}

/// Draws a mesh that was not changed from two opposite sides, one of them facing its longest hole.
///
/// # Errors
/// As [`picture`].
pub fn picture_of_one(scene: &Scene) -> Result<Vec<u8>, PictureError> {
    let camera = views(scene).whole;
    let back = Camera::new(-camera.towards, camera.up, camera.centre, camera.reach);
    drawn(
        scene,
        &[[camera, back].map(|camera| (Side::Before, camera, false))],
        false,
    )
}

/// Draws a mesh whose new faces have the colours of their regions, from two opposite sides, with close-ups of the largest region.
///
/// # Errors
/// As [`picture`].
pub(crate) fn picture_of_marked(scene: &Scene) -> Result<Vec<u8>, PictureError> {
    let views = views(scene);
    let row = |camera: Camera, edges: bool| {
        let back = Camera::new(-camera.towards, camera.up, camera.centre, camera.reach);
        [camera, back].map(|camera| (Side::After, camera, edges))
    };
    let rows: Vec<[Panel; 2]> = [Some((views.whole, false)), views.close.map(|c| (c, true))]
        .into_iter()
        .flatten()
        .map(|(camera, edges)| row(camera, edges))
        .collect();
    drawn(scene, &rows, false)
}

/// Draws rows of panels, with the names of the sides above them if `named`.
fn drawn(scene: &Scene, rows: &[[Panel; 2]], named: bool) -> Result<Vec<u8>, PictureError> {
    let size = |panels: usize| panels * PANEL + (panels - 1) * GAP;
    let head = if named { HEAD } else { 0 };
    let (width, height) = (size(2), head + size(rows.len()));
    let mut pixels = vec![255u8; 3 * width * height];
    for (row, panels) in rows.iter().enumerate() {
        for (column, (side, camera, edges)) in panels.iter().enumerate() {
            let panel = shade::panel(scene, *side, camera, *edges, [PANEL, SAMPLES]);
            let left = column * (PANEL + GAP);
            if row == 0 && named {
                letters::write(&mut pixels, width, left, *side);
            }
            for (y, line) in panel.chunks(3 * PANEL).enumerate() {
                let at = 3 * ((head + row * (PANEL + GAP) + y) * width + left);
                pixels[at..at + line.len()].copy_from_slice(line);
            }
        }
    }
    encoded(&pixels, width, height)
}

/// Encodes RGB pixels as PNG.
fn encoded(pixels: &[u8], width: usize, height: usize) -> Result<Vec<u8>, PictureError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width as u32, height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(pixels)?;
    writer.finish()?;
    Ok(bytes)
}
