//! Writes a volume as VTI: raw appended data in zlib-compressed blocks, as VTK writes it.
//!
//! vtkio is not used here, because it stores origin and spacing in 32 bits.

use std::io::Write;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use rayon::prelude::*;

use super::super::{Format, IoError, Precision};
use isomend_core::grid::Volume;

/// Uncompressed bytes of a block.
const BLOCK: usize = 1 << 20;

/// Writes a volume with one array of the given name.
pub(in super::super) fn write(
    volume: &Volume,
    name: &str,
    precision: Precision,
) -> Result<Vec<u8>, IoError> {
    check(volume, name, precision)?;
    let raw: Vec<u8> = match precision {
        Precision::F32 => volume
            .values
            .iter()
            .flat_map(|v| (*v as f32).to_le_bytes())
            .collect(),
        Precision::F64 => volume.values.iter().flat_map(|v| v.to_le_bytes()).collect(),
    };
    let packed = raw
        .par_chunks(BLOCK)
        .map(|block| {
            let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
            encoder.write_all(block)?;
            encoder.finish()
        })
        .collect::<std::io::Result<Vec<Vec<u8>>>>()
        .map_err(|error| refuse(format!("the values cannot be compressed ({error})")))?;
    let mut bytes = markup(volume, name, precision).into_bytes();
    let sizes = [packed.len(), BLOCK, raw.len() % BLOCK];
    let lengths = packed.iter().map(Vec::len);
    for size in sizes.into_iter().chain(lengths) {
        bytes.extend((size as u64).to_le_bytes());
    }
    packed.iter().for_each(|block| bytes.extend(block));
    bytes.extend(b"\n  </AppendedData>\n</VTKFile>\n");
    Ok(bytes)
}

fn markup(volume: &Volume, name: &str, precision: Precision) -> String {
    let [x, y, z] = volume.dims.map(|n| n - 1);
    let (o, s) = (volume.origin, volume.spacing);
    let [low, high] = volume.range();
    let kind = match precision {
        Precision::F32 => "Float32",
        Precision::F64 => "Float64",
    };
    format!(
        "<?xml version=\"1.0\"?>\n\
         <VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\" \
         compressor=\"vtkZLibDataCompressor\">\n  \
         <ImageData WholeExtent=\"0 {x} 0 {y} 0 {z}\" Origin=\"{} {} {}\" Spacing=\"{} {} {}\" \
         Direction=\"1 0 0 0 1 0 0 0 1\">\n    \
         <Piece Extent=\"0 {x} 0 {y} 0 {z}\">\n      \
         <PointData Scalars=\"{name}\">\n        \
         <DataArray type=\"{kind}\" Name=\"{name}\" format=\"appended\" RangeMin=\"{low}\" RangeMax=\"{high}\" \
         offset=\"0\"/>\n      \
         </PointData>\n      <CellData/>\n    </Piece>\n  </ImageData>\n  \
         <AppendedData encoding=\"raw\">\n   _",
        o.x, o.y, o.z, s.x, s.y, s.z
    )
}

fn check(volume: &Volume, name: &str, precision: Precision) -> Result<(), IoError> {
    let [x, y, z] = volume.dims;
    let total = x.checked_mul(y).and_then(|n| n.checked_mul(z));
    if total != Some(volume.values.len()) || volume.values.is_empty() {
        return Err(refuse(format!(
            "{} values do not make {x} x {y} x {z} nodes",
            volume.values.len()
        )));
    }
    if name.is_empty() || name.contains(['<', '>', '&', '"']) {
        return Err(refuse(format!("'{name}' cannot name an array")));
    }
    super::image::check_geometry(volume.origin, volume.spacing).map_err(refuse)?;
    let fits = |v: &f64| match precision {
        Precision::F32 => (*v as f32).is_finite(),
        Precision::F64 => v.is_finite(),
    };
    match volume.values.iter().position(|v| !fits(v)) {
        Some(node) => Err(refuse(format!(
            "the value {} of node {node} does not fit",
            volume.values[node]
        ))),
        None => Ok(()),
    }
}

fn refuse(what: String) -> IoError {
    IoError::NotWritable {
        format: Format::Vti,
        what,
        advice: "repair the volume before writing it",
    }
}
