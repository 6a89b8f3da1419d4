//! Images: reading PNG and JPEG with limits on size, bilinear sampling in linear light, and writing PNG.

use std::io::Cursor;
use std::sync::LazyLock;

use isomend_core::elementary::powf;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

/// Upper bound of the size of an image file, in bytes: 256 MiB.
pub(super) const MOST_BYTES: u64 = 256 << 20;
/// Upper bound of the texels of an image, 4 bytes each: 8192 by 8192. It protects against small compressed files with huge dimensions.
const MOST_TEXELS: u64 = 1 << 26;
/// Upper bound of an image's width and height, in texels.
const LONGEST: u32 = 1 << 15;

/// A colour in linear light: red, green, blue, opacity.
pub(super) type Linear = [f64; 4];

/// How an image continues beyond its border.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Wrap {
    /// Repeats.
    #[default]
    Repeat,
    /// Repeats, every other copy mirrored.
    Mirror,
    /// Repeats the texels at the border.
    Clamp,
}

/// An image with 8 bits per channel: red, green and blue in sRGB, and opacity; rows from the top.
pub(super) struct Image {
    size: [u32; 2],
    texels: Vec<[u8; 4]>,
}

impl Image {
    /// Reads a PNG or JPEG file.
    ///
    /// # Errors
    /// Why it cannot be used, as a predicate whose subject is the image ("is neither PNG nor JPEG").
    pub(super) fn read(bytes: &[u8]) -> Result<Self, String> {
        if bytes.starts_with(b"\x89PNG\r\n\x1a\n") {
            png_image(bytes)
        } else if bytes.starts_with(&[0xff, 0xd8, 0xff]) {
            jpeg_image(bytes)
        } else {
            Err("is neither PNG nor JPEG".to_owned())
        }
    }

    /// Texels in width and height.
    pub(super) fn size(&self) -> [f64; 2] {
        self.size.map(f64::from)
    }

    /// The colour at a position in texels from the upper left corner, bilinear between texel centres.
    pub(super) fn sample(&self, place: [f64; 2], wrap: [Wrap; 2]) -> Linear {
        let [x, y] = [0, 1].map(|axis| {
            let at = place[axis] - 0.5;
            let first = at.floor();
            let number = |n: f64| wrap[axis].number(n, self.size[axis]);
            (number(first), number(first + 1.0), at - first)
        });
        let texel = |x: usize, y: usize| self.texels[y * self.size[0] as usize + x];
        let mut sum = [0.0; 4];
        for (row, part_y) in [(y.0, 1.0 - y.2), (y.1, y.2)] {
            for (column, part_x) in [(x.0, 1.0 - x.2), (x.1, x.2)] {
                let colour = linear(texel(column, row));
                for (sum, value) in sum.iter_mut().zip(colour) {
                    *sum += part_x * part_y * value;
                }
            }
        }
        sum
    }
}

impl Wrap {
    /// The index of the texel that column or row `n` shows; `n` may lie beyond the image.
    fn number(self, n: f64, size: u32) -> usize {
        // Beyond 1e15 floats hardly resolve single texels, so the result does not matter.
        let (n, size) = (n.clamp(-1e15, 1e15) as i64, i64::from(size));
        let inside = match self {
            Self::Repeat => n.rem_euclid(size),
            Self::Clamp => n.clamp(0, size - 1),
            Self::Mirror => {
                let twice = n.rem_euclid(2 * size);
                twice.min(2 * size - 1 - twice)
            }
        };
        inside as usize
    }
}

/// Linear light of each sRGB byte (IEC 61966-2-1).
static LINEAR: LazyLock<[f64; 256]> = LazyLock::new(|| {
    std::array::from_fn(|byte| {
        let value = byte as f64 / 255.0;
        match value <= 0.04045 {
            true => value / 12.92,
            false => powf((value + 0.055) / 1.055, 2.4),
        }
    })
});

/// A texel in linear light.
fn linear([r, g, b, a]: [u8; 4]) -> Linear {
    let light = |byte: u8| LINEAR[usize::from(byte)];
    [light(r), light(g), light(b), f64::from(a) / 255.0]
}

/// The colour in sRGB, rounded to 8 bits per channel.
pub(super) fn texel([r, g, b, a]: Linear) -> [u8; 4] {
    let byte = |light: f64| {
        let light = light.clamp(0.0, 1.0);
        let value = match light <= 0.003_130_8 {
            true => 12.92 * light,
            false => 1.055 * powf(light, 1.0 / 2.4) - 0.055,
        };
        (255.0 * value).round() as u8
    };
    [
        byte(r),
        byte(g),
        byte(b),
        (255.0 * a.clamp(0.0, 1.0)).round() as u8,
    ]
}

/// Refuses empty images and those beyond [`MOST_TEXELS`] or [`LONGEST`].
fn check_size(width: u32, height: u32) -> Result<(), String> {
    let texels = u64::from(width) * u64::from(height);
    if texels == 0 || texels > MOST_TEXELS || width.max(height) > LONGEST {
        return Err(format!(
            "has {width} by {height} texels, where at most {MOST_TEXELS} are read"
        ));
    }
    Ok(())
}

fn png_image(bytes: &[u8]) -> Result<Image, String> {
    let bad = |error: png::DecodingError| format!("is a damaged PNG file ({error})");
    // Twice the memory of the texels, since rows may have 16 bits per channel while they are decoded.
    let limits = png::Limits {
        bytes: (8 * MOST_TEXELS) as usize,
    };
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), limits);
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let header = decoder.read_header_info().map_err(bad)?;
    let (width, height) = (header.width, header.height);
    check_size(width, height)?;
    let mut reader = decoder.read_info().map_err(bad)?;
    let size = reader.output_buffer_size().unwrap_or(0);
    let mut buffer = vec![0; size];
    let info = reader.next_frame(&mut buffer).map_err(bad)?;
    let rows = &buffer[..info.buffer_size()];
    let texels = match info.color_type {
        png::ColorType::Grayscale => rows.iter().map(|&v| [v, v, v, 255]).collect(),
        png::ColorType::GrayscaleAlpha => {
            let pairs = rows.as_chunks::<2>().0.iter();
            pairs.map(|&[v, a]| [v, v, v, a]).collect()
        }
        png::ColorType::Rgba => rows.as_chunks::<4>().0.to_vec(),
        _ => opaque(rows),
    };
    whole(width, height, texels)
}

fn jpeg_image(bytes: &[u8]) -> Result<Image, String> {
    let bad =
        |error: &dyn std::fmt::Display| format!("is a JPEG file that cannot be read ({error})");
    let options = DecoderOptions::default()
        .set_max_width(LONGEST as usize)
        .set_max_height(LONGEST as usize)
        .jpeg_set_out_colorspace(ColorSpace::RGB);
    let mut decoder = JpegDecoder::new_with_options(Cursor::new(bytes), options);
    decoder.decode_headers().map_err(|error| bad(&error))?;
    let (width, height) = decoder.dimensions().ok_or_else(|| bad(&"no size"))?;
    check_size(width as u32, height as u32)?;
    let rows = decoder.decode().map_err(|error| bad(&error))?;
    whole(width as u32, height as u32, opaque(&rows))
}

fn opaque(rows: &[u8]) -> Vec<[u8; 4]> {
    let triples = rows.as_chunks::<3>().0.iter();
    triples.map(|&[r, g, b]| [r, g, b, 255]).collect()
}

fn whole(width: u32, height: u32, texels: Vec<[u8; 4]>) -> Result<Image, String> {
    match texels.len() as u64 == u64::from(width) * u64::from(height) {
        true => Ok(Image {
            size: [width, height],
            texels,
        }),
        false => Err("has fewer texels than it claims".to_owned()),
    }
}

/// The PNG text chunk (keyword and text) by which pages are recognised.
const MARK: (&str, &str) = ("Software", "isomend: texels of patches");

/// A PNG file of texels in rows from the top; without an alpha channel if all are opaque.
///
/// # Errors
/// If the encoder fails.
pub(super) fn png_file(size: [u32; 2], texels: &[[u8; 4]]) -> Result<Vec<u8>, png::EncodingError> {
    let is_opaque = texels.iter().all(|t| t[3] == 255);
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, size[0], size[1]);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.add_text_chunk(MARK.0.to_owned(), MARK.1.to_owned())?;
    let data: Vec<u8> = match is_opaque {
        true => {
            encoder.set_color(png::ColorType::Rgb);
            texels.iter().flat_map(|t| [t[0], t[1], t[2]]).collect()
        }
        false => {
            encoder.set_color(png::ColorType::Rgba);
            texels.as_flattened().to_vec()
        }
    };
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&data)?;
    writer.finish()?;
    Ok(bytes)
}

/// Whether a file was made by [`png_file`], from its first bytes.
pub(crate) fn is_own(head: &[u8]) -> bool {
    let text = format!("{}\0{}", MARK.0, MARK.1);
    head.starts_with(b"\x89PNG") && head.windows(text.len()).any(|part| part == text.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample_file() -> Vec<u8> {
        let texels: Vec<[u8; 4]> = (0..12u8).map(|i| [20 * i, 255 - 20 * i, 7, 255]).collect();
        png_file([4, 3], &texels).unwrap()
    }

    #[test]
    fn what_is_written_is_read_again_and_known() {
        let bytes = sample_file();
        let image = Image::read(&bytes).unwrap();
        assert_eq!(image.size, [4, 3]);
        assert_eq!(image.texels[5], [100, 155, 7, 255]);
        assert!(is_own(&bytes) && !is_own(b"\x89PNG\r\n\x1a\n"));
        // Sampling at a texel's centre gives its colour.
        assert_eq!(
            texel(image.sample([1.5, 1.5], [Wrap::Clamp; 2])),
            [100, 155, 7, 255]
        );
    }

    /// 8 by 8 texels of the colour (200, 60, 30).
    const JPEG: &str = "/9j/4AAQSkZJRgABAQAAAQABAAD/2wBDAAMCAgMCAgMDAwMEAwMEBQgFBQQEBQoHBwYIDAoMDAsKCwsNDhIQDQ4RDgsLEBYQERMUFRUVDA8XGBYUGBIUFRT/\
        2wBDAQMEBAUEBQkFBQkUDQsNFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBQUFBT/wAARCAAIAAgDASIAAhEBAxEB/8QA\
        FQABAQAAAAAAAAAAAAAAAAAAAAf/xAAUEAEAAAAAAAAAAAAAAAAAAAAA/8QAFQEBAQAAAAAAAAAAAAAAAAAABwj/xAAUEQEAAAAAAAAAAAAAAAAAAAAA/9oA\
        DAMBAAIRAxEAPwCXgBdYD//Z";

    #[test]
    fn jpeg_files_are_read() {
        use base64::Engine;
        let bytes = base64::engine::general_purpose::STANDARD
            .decode(JPEG)
            .unwrap();
        let image = Image::read(&bytes).unwrap();
        assert_eq!(image.size, [8, 8]);
        for texel in &image.texels {
            let apart = texel
                .iter()
                .zip([200, 60, 30, 255])
                .map(|(a, b)| a.abs_diff(b));
            assert!(apart.max().unwrap() <= 3, "{texel:?}");
        }
        for length in 0..bytes.len() {
            let _ = Image::read(&bytes[..length]);
        }
    }

    #[test]
    fn colours_survive_linear_light() {
        for byte in 0..=255 {
            assert_eq!(texel(linear([byte, 0, 255, byte])), [byte, 0, 255, byte]);
        }
    }

    #[test]
    fn texels_beyond_the_border_are_those_that_the_wrap_says() {
        let numbers = |wrap: Wrap| [-2.0, -1.0, 0.0, 2.0, 3.0, 7.0].map(|n| wrap.number(n, 3));
        assert_eq!(numbers(Wrap::Repeat), [1, 2, 0, 2, 0, 1]);
        assert_eq!(numbers(Wrap::Clamp), [0, 0, 0, 2, 2, 2]);
        assert_eq!(numbers(Wrap::Mirror), [1, 0, 0, 2, 2, 1]);
        let _ = [f64::NAN, f64::INFINITY, -1e300].map(|n| Wrap::Repeat.number(n, 3));
    }

    #[test]
    fn damaged_and_enormous_images_are_refused() {
        let bytes = sample_file();
        for length in 0..bytes.len() {
            let _ = Image::read(&bytes[..length]);
        }
        for at in 0..bytes.len() {
            for value in [0, 0x7f, 0xff] {
                let mut damaged = bytes.clone();
                damaged[at] = value;
                let _ = Image::read(&damaged);
            }
        }
        // A header that claims 2¹⁵ by 2¹⁵ texels, with its checksum.
        let header = *b"IHDR\0\0\x80\0\0\0\x80\0\x08\x02\0\0\0";
        let mut bomb = b"\x89PNG\r\n\x1a\n\0\0\0\x0d".to_vec();
        bomb.extend(header);
        bomb.extend(crc(&header).to_be_bytes());
        let why = Image::read(&bomb).err().unwrap();
        assert!(why.contains("32768 by 32768"), "{why}");
        // Start of image, then a frame of 65535 by 65535 texels.
        let jpeg = b"\xff\xd8\xff\xc0\0\x11\x08\xff\xff\xff\xff\x03\x01\x11\0\x02\x11\0\x03\x11\0";
        assert!(Image::read(jpeg).is_err());
        assert!(Image::read(b"GIF89a").err().unwrap().contains("neither"));
    }

    fn crc(bytes: &[u8]) -> u32 {
        let mut crc = flate2::Crc::new();
        crc.update(bytes);
        crc.sum()
    }
}
