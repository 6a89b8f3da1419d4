//! Detects the file format from content or name.

use std::path::Path;
use std::str::FromStr;

use super::{Format, IoError, text};

impl Format {
    /// The format by content, or `None` where the content is ambiguous.
    ///
    /// # Errors
    /// When the content is clearly of a kind that is not supported, for example FBX or a compressed archive.
    pub fn sniff(bytes: &[u8]) -> Result<Option<Format>, IoError> {
        if super::threemf::is_package(bytes) {
            return Ok(Some(Format::ThreeMf));
        }
        if super::usd::is_package(bytes) {
            return Ok(Some(Format::Usdz));
        }
        if super::usd::is_layer(bytes) {
            return Ok(Some(Format::Usda));
        }
        if let Some(name) = foreign(bytes) {
            return Err(IoError::UnknownFormat {
                what: format!("the content is {name}, which is not supported"),
            });
        }
        if bytes.starts_with(b"glTF") {
            return Ok(Some(Format::Glb));
        }
        let start = text::skip_blank(text::strip_bom(bytes));
        if start.starts_with(b"ply") && start.get(3).is_some_and(u8::is_ascii_whitespace) {
            return Ok(Some(Format::Ply));
        }
        if starts_with_ignoring_case(start, b"# vtk DataFile") {
            return Ok(Some(Format::Vtk));
        }
        if start.starts_with(b"<")
            && text::find(&start[..start.len().min(4096)], b"<VTKFile").is_some()
        {
            return Ok(Some(Format::Vtp));
        }
        if start.starts_with(b"{") && text::find(start, b"\"asset\"").is_some() {
            return Ok(Some(Format::Gltf));
        }
        let first_word = start.split(u8::is_ascii_whitespace).next();
        if first_word.is_some_and(super::off::is_first_word) {
            return Ok(Some(Format::Off));
        }
        if starts_with_ignoring_case(start, b"solid") || super::stl::has_binary_size(bytes) {
            return Ok(Some(Format::Stl));
        }
        Ok(None)
    }

    /// The format of a file: by content, else by extension, else OBJ if the text looks like OBJ.
    ///
    /// # Errors
    /// When neither content nor name is of a supported format. The message lists the supported ones.
    pub fn detect(bytes: &[u8], path: &Path) -> Result<Format, IoError> {
        if let Some(format) = Format::sniff(bytes)? {
            return Ok(format);
        }
        if let Some(format) = Format::from_extension(path) {
            return Ok(format);
        }
        if super::obj::looks_like_obj(bytes) {
            return Ok(Format::Obj);
        }
        let what = match path.extension() {
            Some(extension) => format!(
                "the content and the extension .{} are of no supported format",
                extension.display()
            ),
            None => {
                "the content is of no supported format and the name has no extension".to_string()
            }
        };
        Err(IoError::UnknownFormat { what })
    }
}

impl FromStr for Format {
    type Err = IoError;

    /// Accepts an extension with or without the dot, in any case, and `usd` for USD as text.
    fn from_str(name: &str) -> Result<Self, IoError> {
        let wanted = name.trim_start_matches('.');
        if wanted.eq_ignore_ascii_case("usd") {
            return Ok(Format::Usda);
        }
        if wanted.eq_ignore_ascii_case("usdc") {
            let what = "binary USD (.usdc) is recognised by its content and read, but not written: write .usda or .usdz";
            return Err(IoError::UnknownFormat {
                what: what.to_owned(),
            });
        }
        Format::ALL
            .into_iter()
            .find(|format| format.extension().eq_ignore_ascii_case(wanted))
            .ok_or_else(|| IoError::UnknownFormat {
                what: format!("'{name}' is not a supported mesh format"),
            })
    }
}

/// Refuses the bytes of a mesh where a volume is wanted. VTK files may hold either.
pub(super) fn refuse_mesh(bytes: &[u8]) -> Result<(), IoError> {
    match Format::sniff(bytes)? {
        None | Some(Format::Vtk | Format::Vtp) => Ok(()),
        Some(format) => Err(IoError::Unsupported {
            format,
            what: "it holds a mesh, not a volume".to_owned(),
            advice: "'isomend sdf' makes a volume of it",
        }),
    }
}

/// The name of a known but unsupported format, by its first bytes.
fn foreign(bytes: &[u8]) -> Option<&'static str> {
    const MAGIC: [(&[u8], &str); 8] = [
        (
            b"PK\x03\x04",
            "a ZIP archive without a 3MF model or a USD layer (unpack it first)",
        ),
        (b"\x1f\x8b", "gzip data (unpack it first)"),
        (b"Kaydara FBX", "FBX"),
        (b"ISO-10303-21", "STEP"),
        (b"DRACO", "Draco"),
        (b"BZh", "bzip2 data (unpack it first)"),
        (b"\xfd7zXZ", "xz data (unpack it first)"),
        (b"\x89HDF", "HDF5"),
    ];
    if let Some((_, name)) = MAGIC.iter().find(|(magic, _)| bytes.starts_with(magic)) {
        return Some(name);
    }
    let first_word = text::skip_blank(bytes)
        .split(u8::is_ascii_whitespace)
        .next()?;
    (first_word == b"$MeshFormat").then_some("a Gmsh mesh")
}

fn starts_with_ignoring_case(bytes: &[u8], prefix: &[u8]) -> bool {
    bytes
        .get(..prefix.len())
        .is_some_and(|start| start.eq_ignore_ascii_case(prefix))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn content_goes_before_the_name() {
        let path = Path::new("wrong.obj");
        assert_eq!(
            Format::detect(b"ply\nformat ascii 1.0\n", path).unwrap(),
            Format::Ply
        );
        assert_eq!(
            Format::detect(b"# vtk DataFile Version 3.0\n", path).unwrap(),
            Format::Vtk
        );
        assert_eq!(
            Format::detect(
                b"<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\">",
                path
            )
            .unwrap(),
            Format::Vtp
        );
        assert_eq!(
            Format::detect(b" {\"asset\":{\"version\":\"2.0\"}}", path).unwrap(),
            Format::Gltf
        );
        assert_eq!(
            Format::detect(b"glTF\x02\0\0\0", path).unwrap(),
            Format::Glb
        );
        assert_eq!(Format::detect(b"solid name\n", path).unwrap(), Format::Stl);
        assert_eq!(Format::detect(b"v 0 0 0\n", path).unwrap(), Format::Obj);
        for first in [
            &b"OFF\n3 1 0\n"[..],
            b"STCNOFF 3 1 0",
            b"4OFF\n",
            b"OFF8 6 12",
        ] {
            assert_eq!(Format::detect(first, path).unwrap(), Format::Off);
        }
    }

    #[test]
    fn binary_stl_is_detected_by_its_size() {
        let mut bytes = vec![0u8; 134];
        bytes[80] = 1;
        assert_eq!(
            Format::detect(&bytes, Path::new("scan")).unwrap(),
            Format::Stl
        );
    }

    #[test]
    fn unsupported_formats_are_refused_with_the_supported_ones_listed() {
        for (bytes, name) in [
            (&b"Kaydara FBX Binary"[..], "FBX"),
            (b"PK\x03\x04rest", "ZIP"),
            (b"hello", ".xyz"),
        ] {
            let message = Format::detect(bytes, Path::new("mesh.xyz"))
                .unwrap_err()
                .to_string();
            assert!(
                message.contains(name) && message.contains(Format::LIST),
                "{message}"
            );
        }
    }

    #[test]
    fn names_are_taken_with_or_without_the_dot_in_any_case() {
        assert_eq!(".PLY".parse::<Format>().unwrap(), Format::Ply);
        assert_eq!("glb".parse::<Format>().unwrap(), Format::Glb);
        assert!("fbx".parse::<Format>().is_err());
        assert_eq!("3MF".parse::<Format>().unwrap(), Format::ThreeMf);
        for format in Format::ALL {
            assert_eq!(format.extension().parse::<Format>().unwrap(), format);
        }
    }
}
