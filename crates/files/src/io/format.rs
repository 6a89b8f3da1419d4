//! The list of mesh and volume file formats, with their names and extensions.

use std::fmt;
use std::path::Path;

use serde::{Deserialize, Serialize};

/// A mesh or volume file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Format {
    /// Wavefront OBJ, text.
    Obj,
    /// Stanford PLY, text or binary.
    Ply,
    /// STL, text or binary.
    Stl,
    /// glTF 2.0 as JSON with external or embedded buffers.
    Gltf,
    /// glTF 2.0 as one binary file.
    Glb,
    /// VTK legacy: mesh or volume, text or binary.
    Vtk,
    /// VTK XML poly data.
    Vtp,
    /// OFF, text.
    Off,
    /// 3MF: a ZIP package of objects, with a unit of length.
    #[serde(rename = "3mf")]
    ThreeMf,
    /// USD (Universal Scene Description) as text; binary files are read.
    Usda,
    /// USD as a package: an uncompressed ZIP archive of layers.
    Usdz,
    /// VTK XML image data, a volume.
    Vti,
}

impl Format {
    /// All mesh formats, in the order in which users see them.
    pub const ALL: [Format; 11] = [
        Format::Obj,
        Format::Ply,
        Format::Stl,
        Format::Gltf,
        Format::Glb,
        Format::Vtk,
        Format::Vtp,
        Format::Off,
        Format::ThreeMf,
        Format::Usda,
        Format::Usdz,
    ];

    /// The mesh formats as one line for messages and help texts.
    pub const LIST: &'static str = "OBJ (.obj), PLY (.ply), STL (.stl), glTF (.gltf, .glb), VTK legacy (.vtk), \
                                    VTK XML poly data (.vtp), OFF (.off), 3MF (.3mf) and USD (.usda, .usdz; .usdc is read)";

    /// The usual file name extension, in lower case and without a dot.
    pub fn extension(self) -> &'static str {
        match self {
            Format::Obj => "obj",
            Format::Ply => "ply",
            Format::Stl => "stl",
            Format::Gltf => "gltf",
            Format::Glb => "glb",
            Format::Vtk => "vtk",
            Format::Vtp => "vtp",
            Format::Off => "off",
            Format::ThreeMf => "3mf",
            Format::Usda => "usda",
            Format::Usdz => "usdz",
            Format::Vti => "vti",
        }
    }

    /// The mesh format of a file name's extension, if supported. `.usd` and `.usdc` are USD.
    pub fn from_extension(path: &Path) -> Option<Format> {
        let extension = path.extension()?.to_str()?;
        match Self::is_binary_usd(path) {
            true => Some(Format::Usda),
            false => extension.parse().ok(),
        }
    }

    /// Whether coordinates are always stored as 32-bit floats; text STL has the digits of any.
    #[doc(hidden)]
    pub fn is_single(self) -> bool {
        matches!(
            self,
            Format::Stl | Format::Gltf | Format::Glb | Format::Usda | Format::Usdz
        )
    }

    /// Whether a file of this name would have to be binary USD, which is read but not written.
    pub(crate) fn is_binary_usd(path: &Path) -> bool {
        path.extension()
            .is_some_and(|extension| extension.eq_ignore_ascii_case("usdc"))
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Format::Obj => "OBJ",
            Format::Ply => "PLY",
            Format::Stl => "STL",
            Format::Gltf => "glTF",
            Format::Glb => "GLB",
            Format::Vtk => "VTK legacy",
            Format::Vtp => "VTP",
            Format::Off => "OFF",
            Format::ThreeMf => "3MF",
            Format::Usda => "USD",
            Format::Usdz => "USDZ",
            Format::Vti => "VTI",
        })
    }
}
