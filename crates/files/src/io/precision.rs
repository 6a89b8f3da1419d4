//! How exactly a mesh is written.

use isomend_core::mesh::Mesh;

/// The floating-point type of written coordinates, for formats that have a choice.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Precision {
    /// 32-bit floats.
    #[default]
    F32,
    /// 64-bit floats.
    F64,
}

impl Precision {
    /// The smallest precision that holds every coordinate of a mesh exactly.
    pub fn of(mesh: &Mesh) -> Self {
        let exact = mesh.positions.iter().all(|p| p.as_vec3().as_dvec3() == *p);
        if exact {
            Precision::F32
        } else {
            Precision::F64
        }
    }
}

/// How a mesh is written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WriteOptions {
    /// The type of coordinates in PLY, VTK legacy, VTP and text STL. OBJ, OFF and 3MF are always exact; binary STL, glTF and GLB
    /// always hold 32-bit floats.
    pub precision: Precision,
    /// Text instead of binary, for PLY, STL and VTK legacy. OBJ and OFF are always text; glTF, GLB, VTP and 3MF do not change.
    pub ascii: bool,
}
