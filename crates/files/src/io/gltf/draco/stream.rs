//! Decodes one Draco stream and converts its attributes to the component types of accessors.

use draco_core::{
    DataType, DecodeLimits, DecoderBuffer, ErrorKind, FaceIndex, Mesh, MeshDecoder, PointAttribute,
    PointIndex,
};
use isomend_core::mesh::attributes::Scalar;

use super::super::super::binary::BinaryNumber;

/// Least bytes of memory that each decoded face takes: three indices, and half a vertex with a position and a normal. A mesh of two million faces
/// took 100 bytes for each while it was decoded.
const FACE: usize = 24;

/// A decoded mesh.
pub(super) struct Stream {
    mesh: Mesh,
}

impl Stream {
    /// Decodes a stream whose mesh needs at most `most` bytes; the error completes a sentence about the stream.
    pub(super) fn decoded(bytes: &[u8], most: usize) -> Result<Self, String> {
        let limits = DecodeLimits::default()
            .with_max_faces((most / FACE) as u64)
            .with_max_decoded_bytes(most as u64);
        let mut buffer = DecoderBuffer::new(bytes).with_limits(limits);
        let mut mesh = Mesh::new();
        let decoded = MeshDecoder::new().decode(&mut buffer, &mut mesh);
        decoded.map_err(|error| match error.kind() {
            ErrorKind::LimitExceeded | ErrorKind::AllocationExceedsInput => {
                format!("needs more memory than the limit for a file of this size: {error}")
            }
            _ => format!("cannot be decoded: {error}"),
        })?;
        let points = mesh.num_points();
        let corners = mesh.faces().iter().flatten();
        match corners.map(|point| point.0 as usize).find(|p| *p >= points) {
            Some(point) => Err(format!(
                "has vertex {point} in a face, but {points} vertices"
            )),
            None => Ok(Self { mesh }),
        }
    }

    /// The number of vertices.
    pub(super) fn points(&self) -> usize {
        self.mesh.num_points()
    }

    /// The number of corners of faces.
    pub(super) fn corners(&self) -> usize {
        3 * self.mesh.num_faces()
    }

    /// Bytes of memory that the decoded mesh takes.
    pub(super) fn memory(&self) -> usize {
        let attributes = 0..self.mesh.num_attributes();
        let values = attributes.map(|at| self.mesh.attribute(at).buffer().data_size());
        4 * self.corners() + values.sum::<usize>()
    }

    /// The corners as bytes, and the number of their component type: 16 bits where they are enough.
    pub(super) fn indices(&self) -> (Vec<u8>, u64) {
        let faces = (0..self.mesh.num_faces()).map(|face| self.mesh.face(FaceIndex(face as u32)));
        let corners = faces.flatten().map(|point| point.0);
        match self.points() <= usize::from(u16::MAX) {
            true => (
                corners.flat_map(|c| (c as u16).to_le_bytes()).collect(),
                5123,
            ),
            false => (corners.flat_map(u32::to_le_bytes).collect(), 5125),
        }
    }

    /// The values of an attribute for all vertices in a component type; each vertex begins at a multiple of 4 bytes.
    pub(super) fn values(
        &self,
        id: u32,
        wanted: Scalar,
        components: usize,
    ) -> Result<Vec<u8>, String> {
        let attribute = self.mesh.attribute_by_unique_id(id);
        let attribute = attribute.ok_or_else(|| format!("has no attribute {id}"))?;
        let own = usize::from(attribute.num_components());
        if own != components {
            return Err(format!(
                "has {own} components of attribute {id}, but its accessor has {components}"
            ));
        }
        let scalar = scalar(attribute.data_type());
        let scalar =
            scalar.ok_or_else(|| format!("has values of an unknown type in attribute {id}"))?;
        let stride = (components * wanted.size()).next_multiple_of(4);
        let mut values = Vec::with_capacity(stride * self.points());
        for point in 0..self.points() {
            let value = value(
                attribute,
                PointIndex(point as u32),
                components * scalar.size(),
            );
            let value =
                value.ok_or_else(|| format!("has no value of attribute {id} at vertex {point}"))?;
            match scalar == wanted {
                true => values.extend_from_slice(value),
                false => {
                    for part in value.chunks_exact(scalar.size()) {
                        let number = scalar.take::<false>(part).map_or(0.0, |(number, _)| number);
                        let is_fraction =
                            attribute.normalized() && wanted == Scalar::F32 && !scalar.is_float();
                        let unit = if is_fraction { scalar.range()[1] } else { 1.0 };
                        wanted.put(wanted.nearest(number / unit), &mut values);
                    }
                }
            }
            values.resize(values.len().next_multiple_of(4), 0);
        }
        Ok(values)
    }
}

/// The bytes of the value of an attribute at a point.
fn value(attribute: &PointAttribute, point: PointIndex, size: usize) -> Option<&[u8]> {
    let stride = usize::try_from(attribute.byte_stride()).ok()?;
    let start = (attribute.mapped_index(point).0 as usize).checked_mul(stride)?;
    attribute
        .buffer()
        .data()
        .get(start..start.checked_add(size)?)
}

/// The smallest and the largest value of each component.
pub(super) fn bounds(
    values: &[u8],
    scalar: Scalar,
    components: usize,
    stride: usize,
) -> [Vec<f64>; 2] {
    let mut bounds = [
        vec![f64::INFINITY; components],
        vec![f64::NEG_INFINITY; components],
    ];
    for row in values.chunks_exact(stride) {
        for (at, part) in row.chunks_exact(scalar.size()).take(components).enumerate() {
            let number = scalar
                .take::<false>(part)
                .map_or(f64::NAN, |(number, _)| number);
            bounds[0][at] = bounds[0][at].min(number);
            bounds[1][at] = bounds[1][at].max(number);
        }
    }
    bounds
}

fn scalar(kind: DataType) -> Option<Scalar> {
    match kind {
        DataType::Int8 => Some(Scalar::I8),
        DataType::Uint8 | DataType::Bool => Some(Scalar::U8),
        DataType::Int16 => Some(Scalar::I16),
        DataType::Uint16 => Some(Scalar::U16),
        DataType::Int32 => Some(Scalar::I32),
        DataType::Uint32 => Some(Scalar::U32),
        DataType::Int64 => Some(Scalar::I64),
        DataType::Uint64 => Some(Scalar::U64),
        DataType::Float32 => Some(Scalar::F32),
        DataType::Float64 => Some(Scalar::F64),
        DataType::Invalid => None,
    }
}
