//! A picture of a mesh before and after, drawn without a graphics card or a browser.
//!
//! The upper row shows the whole, the lower one the largest patch with its triangles. The same scene gives the same bytes,
//! whatever the number of threads.

mod camera;
mod letters;
mod raster;
mod shade;

use super::view::{Scene, Side};
use raster::Camera;
use thiserror::Error;

pub use camera::{Views, views};

/// Height and width of a panel in pixels.
const PANEL: usize = 720;
/// Samples along a pixel's side.
const SAMPLES: usize = 3;
/// Pixels between panels, and over them for their names.
const GAP: usize = 8;
const HEAD: usize = 44;

/// Why a picture could not be encoded.
#[derive(Debug, Error)]
#[error("cannot encode the picture: {0}")]
pub struct PictureError(#[from] png::EncodingError);

/// Draws a scene and returns the bytes of a PNG file: before and after, and below them the largest patch from near by.
///
/// # Errors
/// When the encoder fails, which it does not for want of anything but memory.
pub fn picture(scene: &Scene) -> Result<Vec<u8>, PictureError> {
    let views = views(scene);
    let rows: Vec<(Camera, bool)> = [Some((views.whole, false)), views.close.map(|c| (c, true))]
        .into_iter()
        .flatten()
        .collect();
    let size = |panels: usize| panels * PANEL + (panels - 1) * GAP;
    let (width, height) = (size(2), HEAD + size(rows.len()));
    let mut pixels = vec![255u8; 3 * width * height];
    for (row, (camera, edges)) in rows.iter().enumerate() {
        for (column, side) in [Side::Before, Side::After].into_iter().enumerate() {
            let panel = shade::panel(scene, side, camera, *edges, [PANEL, SAMPLES]);
            let left = column * (PANEL + GAP);
            if row == 0 {
                letters::write(&mut pixels, width, left, side);
            }
            for (y, line) in panel.chunks(3 * PANEL).enumerate() {
                let at = 3 * ((HEAD + row * (PANEL + GAP) + y) * width + left);
                pixels[at..at + line.len()].copy_from_slice(line);
            }
        }
    }
    encoded(&pixels, width, height)
}

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
