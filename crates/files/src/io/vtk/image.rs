//! Reads VTK XML image data (VTI) as a volume.

use glam::DVec3;

use super::super::{Format, IoError, Location, text};
use super::markup::{Array, Attributes, Document, Piece, Section, attribute, split_appended};
use super::payload::{Budget, Expected};
use super::xml::Decoder;
use isomend_core::grid::Volume;
use isomend_core::mesh::{LARGEST, SMALLEST};

/// Memory limit of decoded values: this many bytes plus this multiple of the file size.
const ALLOWANCE: [usize; 2] = [96 << 20, 64];

/// Reads a point data array as a volume.
pub(in super::super) fn read(bytes: &[u8], array: Option<&str>) -> Result<Volume, IoError> {
    read_vti(bytes, array).map_err(|error| error.of_format(Format::Vti))
}

fn read_vti(bytes: &[u8], wanted: Option<&str>) -> Result<Volume, IoError> {
    let (markup, appended) = split_appended(bytes);
    let document = Document::parse(markup, "ImageData")?;
    let (extent, origin, spacing) = geometry(&document.dataset)?;
    let dims = dims(&extent)?;
    let decoder = Decoder::new(&document, appended.as_ref(), Budget::new(bytes, ALLOWANCE));
    let mut parts = Vec::new();
    let mut room = 0usize;
    for piece in &document.pieces {
        let array = pick(piece, wanted)?;
        let part = match attribute(&piece.attributes, b"Extent") {
            Some(text) => integers(text, "Extent")?,
            None => extent,
        };
        let counts = self::dims(&part)?;
        let nodes = count(&counts).ok_or_else(|| {
            let [x, y, z] = counts;
            fault(format!("{x} x {y} x {z} nodes are too many"))
        })?;
        let values = decoder.numbers(array, "the values", Expected::Exactly(nodes))?;
        room = room.saturating_add(values.len());
        parts.push((part, values));
    }
    let total = count(&dims).filter(|total| *total <= room).ok_or_else(|| {
        fault(format!(
            "the extent is {} x {} x {} nodes, but the pieces have only {room} values",
            dims[0], dims[1], dims[2]
        ))
    })?;
    let values = match &mut parts[..] {
        [(part, values)] if *part == extent => std::mem::take(values),
        _ => assemble(&extent, dims, total, &parts)?,
    };
    let first = DVec3::new(extent[0] as f64, extent[2] as f64, extent[4] as f64);
    Ok(Volume {
        dims,
        origin: origin + first * spacing,
        spacing,
        values,
    })
}

/// Parses the extent in nodes, the origin and the spacing.
fn geometry(dataset: &Attributes) -> Result<([i64; 6], DVec3, DVec3), IoError> {
    let Some(extent) = attribute(dataset, b"WholeExtent") else {
        return Err(fault("the image data has no WholeExtent".to_owned()));
    };
    let extent = integers(extent, "WholeExtent")?;
    let vector = |name: &str, usual: DVec3| match attribute(dataset, name.as_bytes()) {
        Some(text) => floats::<3>(text, name).map(DVec3::from_array),
        None => Ok(usual),
    };
    if let Some(direction) = attribute(dataset, b"Direction")
        && floats::<9>(direction, "Direction")? != [1., 0., 0., 0., 1., 0., 0., 0., 1.]
    {
        return Err(IoError::Unsupported {
            format: Format::Vti,
            what: "its lattice is rotated (Direction is not the identity)".to_owned(),
            advice: "resample it on a lattice along the axes first",
        });
    }
    let (origin, spacing) = (
        vector("Origin", DVec3::ZERO)?,
        vector("Spacing", DVec3::ONE)?,
    );
    check_geometry(origin, spacing).map_err(fault)?;
    Ok((extent, origin, spacing))
}

/// Checks that origin and spacing are finite, positive where needed, and within the range that can be measured.
pub(super) fn check_geometry(origin: DVec3, spacing: DVec3) -> Result<(), String> {
    if !origin.is_finite() {
        return Err(format!("the origin {origin} is not finite"));
    }
    if !spacing.is_finite() || spacing.min_element() <= 0.0 {
        return Err(format!(
            "the spacing {spacing} is not positive along every axis"
        ));
    }
    let largest = origin.abs().max(spacing).max_element();
    if largest > LARGEST || spacing.min_element() < SMALLEST {
        return Err(format!(
            "the origin {:?} or the spacing {:?} is too large or too small to measure; scale the volume",
            origin.to_array(),
            spacing.to_array()
        ));
    }
    Ok(())
}

fn dims(extent: &[i64; 6]) -> Result<[usize; 3], IoError> {
    let mut dims = [0; 3];
    for (axis, count) in dims.iter_mut().enumerate() {
        let (low, high) = (extent[2 * axis], extent[2 * axis + 1]);
        let nodes = high.checked_sub(low).and_then(|n| n.checked_add(1));
        *count = nodes
            .filter(|n| *n > 0 && *n <= i64::from(i32::MAX))
            .and_then(|n| usize::try_from(n).ok())
            .ok_or_else(|| fault(format!("the extent {low} to {high} holds no nodes")))?;
    }
    Ok(dims)
}

fn count(dims: &[usize; 3]) -> Option<usize> {
    dims[0].checked_mul(dims[1])?.checked_mul(dims[2])
}

/// Joins pieces into one array; neighbouring pieces share the nodes between them.
fn assemble(
    extent: &[i64; 6],
    dims: [usize; 3],
    total: usize,
    parts: &[([i64; 6], Vec<f64>)],
) -> Result<Vec<f64>, IoError> {
    let mut values = vec![f64::NAN; total];
    for (part, numbers) in parts {
        let inside =
            (0..3).all(|a| part[2 * a] >= extent[2 * a] && part[2 * a + 1] <= extent[2 * a + 1]);
        if !inside {
            return Err(fault(format!(
                "the piece of extent {part:?} is outside the whole extent"
            )));
        }
        let counts = self::dims(part)?;
        let offset = |axis: usize| (part[2 * axis] - extent[2 * axis]) as usize;
        for (row, line) in numbers.chunks_exact(counts[0]).enumerate() {
            let (j, k) = (row % counts[1] + offset(1), row / counts[1] + offset(2));
            let start = (k * dims[1] + j) * dims[0] + offset(0);
            values[start..start + counts[0]].copy_from_slice(line);
        }
    }
    match values.iter().position(|v| v.is_nan()) {
        Some(node) => Err(fault(format!("no piece has a value for node {node}"))),
        None => Ok(values),
    }
}

fn pick<'p>(piece: &'p Piece, wanted: Option<&str>) -> Result<&'p Array, IoError> {
    let name = |a: &Array| {
        let name = attribute(&a.attributes, b"Name").unwrap_or(b"");
        String::from_utf8_lossy(name).into_owned()
    };
    let single = |a: &&Array| {
        let components = attribute(&a.attributes, b"NumberOfComponents");
        a.section == Section::PointData && matches!(components, None | Some(b"1") | Some(b""))
    };
    let arrays: Vec<&Array> = piece.arrays.iter().filter(single).collect();
    let names: Vec<String> = arrays.iter().map(|a| name(a)).collect();
    let of_cells = piece.arrays.iter().any(|a| a.section == Section::CellData);
    let place = choose(&names, wanted, of_cells)?;
    Ok(arrays[place])
}

/// The index of the array to read.
pub(super) fn choose(
    names: &[String],
    wanted: Option<&str>,
    of_cells: bool,
) -> Result<usize, IoError> {
    let refuse = |what: String, advice: &'static str| {
        Err(IoError::Unsupported {
            format: Format::Vti,
            what,
            advice,
        })
    };
    let listed = names.join("', '");
    match (names, wanted) {
        ([], _) if of_cells => refuse(
            "its values belong to cells, not to nodes".to_owned(),
            "convert them first, for example with ParaView's 'Cell Data to Point Data'",
        ),
        ([], _) => refuse(
            "it has no array with one number for each node".to_owned(),
            "check which arrays the program that wrote it exports",
        ),
        (_, Some(name)) => match names.iter().position(|n| n == name) {
            Some(place) => Ok(place),
            None => refuse(
                format!("it has no array '{name}', only '{listed}'"),
                "name one of these",
            ),
        },
        ([_], None) => Ok(0),
        (_, None) => refuse(
            format!("it has several arrays: '{listed}'"),
            "name one of them",
        ),
    }
}

fn words(text: &[u8]) -> impl Iterator<Item = &[u8]> {
    text::Tokens::new(text, 0)
}

fn integers(text: &[u8], name: &str) -> Result<[i64; 6], IoError> {
    let values: Option<Vec<i64>> = words(text).map(text::integer).collect();
    values
        .and_then(|values| values.try_into().ok())
        .ok_or_else(|| fault(format!("{name} {} is not six numbers", text::shown(text))))
}

fn floats<const N: usize>(text: &[u8], name: &str) -> Result<[f64; N], IoError> {
    let values: Option<Vec<f64>> = words(text).map(text::number).collect();
    values
        .and_then(|values| values.try_into().ok())
        .ok_or_else(|| fault(format!("{name} {} is not {N} numbers", text::shown(text))))
}

fn fault(what: String) -> IoError {
    IoError::malformed(Format::Vti, Location::File, what)
}
