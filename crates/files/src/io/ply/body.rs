//! Reads the body of a PLY file: vertices, faces and triangle strips, text or binary.

use glam::DVec3;

use super::super::binary::BinaryNumber;
use super::super::mesh_builder::MeshBuilder;
use super::super::{Format, IoError, Location, text};
use super::NO_UV;
use super::columns::{Columns, FaceValues, Use};
use super::header::{Element, Encoding, Header, Property};
use isomend_core::mesh::attributes::{Attribute, NONE, Role, Scalar};

/// The points and faces of a file with their attributes.
pub(super) struct Body {
    pub(super) surface: MeshBuilder,
    pub(super) vertex: Vec<Attribute>,
    pub(super) face: FaceValues,
}

/// Reads vertices, faces and strips; other elements are skipped.
pub(super) fn read(bytes: &[u8], header: &Header) -> Result<Body, IoError> {
    let rest = &bytes[header.body..];
    match header.encoding {
        Encoding::Ascii => read_text(bytes, header),
        Encoding::Little => read_elements(&mut BinaryValues::<false> { rest }, header),
        Encoding::Big => read_elements(&mut BinaryValues::<true> { rest }, header),
    }
}

/// Reads a text body, in which items are numbers separated by any white space. Files whose lines have more numbers than the
/// header declares are read line by line instead, if they have one line for each item.
fn read_text(bytes: &[u8], header: &Header) -> Result<Body, IoError> {
    let mut values = TextValues::new(bytes, header.body);
    let body = read_elements(&mut values, header);
    if body.is_ok() && text::skip_blank(&bytes[values.tokens.offset()..]).is_empty() {
        return body;
    }
    let items = header.elements.iter().filter(|e| !e.properties.is_empty());
    let items = items.fold(0u64, |sum, element| sum.saturating_add(element.count));
    let lines = bytes[header.body..].split(|b| matches!(b, b'\n' | b'\r'));
    let lines = lines.filter(|line| !line.trim_ascii().is_empty()).count();
    if lines as u64 != items {
        return body;
    }
    let mut values = TextValues::new(bytes, header.body);
    values.longer_lines = Some(0);
    let by_line = read_elements(&mut values, header);
    let (Ok(mut by_line), Some(longer)) = (by_line, values.longer_lines) else {
        return body;
    };
    by_line.surface.notes.push(format!(
        "lines with more numbers than the header declares, which are not read: {longer}"
    ));
    Ok(by_line)
}

/// A stream of numbers, from text or binary.
trait Values {
    /// The smallest number of bytes that a value of a type takes.
    fn least_size(scalar: Scalar) -> usize;
    /// The number of bytes left.
    fn left(&self) -> usize;
    /// The next number, or `None` at the end or at something that is not a number.
    fn take(&mut self, scalar: Scalar) -> Option<f64>;
    /// Why the last `take` gave `None`; no error if the file ended.
    fn complaint(&self) -> Option<IoError>;
    /// Ends an item of an element.
    fn end_item(&mut self) {}
}

struct BinaryValues<'a, const BIG: bool> {
    rest: &'a [u8],
}

impl<const BIG: bool> Values for BinaryValues<'_, BIG> {
    fn least_size(scalar: Scalar) -> usize {
        scalar.size()
    }

    fn left(&self) -> usize {
        self.rest.len()
    }

    #[inline]
    fn take(&mut self, scalar: Scalar) -> Option<f64> {
        let (value, rest) = scalar.take::<BIG>(self.rest)?;
        self.rest = rest;
        Some(value)
    }

    fn complaint(&self) -> Option<IoError> {
        None
    }
}

struct TextValues<'a> {
    tokens: text::Tokens<'a>,
    bad: Option<&'a [u8]>,
    /// If every line is an item: the number of lines with more numbers than the item has.
    longer_lines: Option<usize>,
}

impl<'a> TextValues<'a> {
    fn new(bytes: &'a [u8], body: usize) -> Self {
        Self {
            tokens: text::Tokens::new(bytes, body),
            bad: None,
            longer_lines: None,
        }
    }
}

impl Values for TextValues<'_> {
    fn least_size(_: Scalar) -> usize {
        2
    }

    fn left(&self) -> usize {
        // The last number of a file needs no white space after it.
        self.tokens.left() + 1
    }

    fn take(&mut self, scalar: Scalar) -> Option<f64> {
        let token = self.tokens.next()?;
        let value = match scalar {
            Scalar::F32 => text::number_f32(token).map(f64::from),
            _ => text::number(token),
        };
        if value.is_none() {
            self.bad = Some(token);
        }
        value
    }

    fn complaint(&self) -> Option<IoError> {
        let what = format!("{} is not a number", text::shown(self.bad?));
        Some(IoError::malformed(
            Format::Ply,
            Location::Line(self.tokens.line()),
            what,
        ))
    }

    fn end_item(&mut self) {
        if let Some(longer) = &mut self.longer_lines {
            *longer += usize::from(!self.tokens.rest_of_line().is_empty());
        }
    }
}

fn read_elements<V: Values>(values: &mut V, header: &Header) -> Result<Body, IoError> {
    let mut body = Body {
        surface: MeshBuilder::new(Format::Ply),
        vertex: Vec::new(),
        face: FaceValues::default(),
    };
    let mut found = [false; 3];
    for element in &header.elements {
        let kind = match &element.name[..] {
            b"vertex" => 0,
            b"face" => 1,
            b"tristrips" => 2,
            name => {
                skip_element(values, element)?;
                if name == b"edge" {
                    body.surface.skipped += usize::try_from(element.count).unwrap_or(0);
                }
                continue;
            }
        };
        if std::mem::replace(&mut found[kind], true) {
            let what = format!(
                "there are two elements named {}",
                text::shown(&element.name)
            );
            return Err(IoError::malformed(Format::Ply, Location::File, what));
        }
        match kind {
            0 => read_vertices(values, element, &mut body)?,
            1 => read_faces(values, element, &mut body)?,
            _ => read_strips(values, element, &mut body.surface)?,
        }
    }
    Ok(body)
}

/// Upper bound of the items that fit into the rest of the file, at most the claimed count. `corners` is the smallest
/// size in bytes of the items' list.
fn plausible<V: Values>(values: &V, element: &Element, corners: usize) -> usize {
    let row: usize = element
        .properties
        .iter()
        .map(|p| V::least_size(p.length.unwrap_or(p.scalar)))
        .sum();
    let room = values.left() / (row + corners).max(1);
    usize::try_from(element.count).map_or(room, |count| count.min(room))
}

fn read_vertices<V: Values>(
    values: &mut V,
    element: &Element,
    body: &mut Body,
) -> Result<(), IoError> {
    if element.count == 0 {
        return Ok(());
    }
    let mut axes = vec![None; element.properties.len()];
    for (axis, name) in [&b"x"[..], b"y", b"z"].into_iter().enumerate() {
        match element
            .properties
            .iter()
            .position(|p| p.name == name && p.length.is_none())
        {
            Some(property) => axes[property] = Some(axis),
            None => {
                let what = format!(
                    "the vertices have no {} coordinate",
                    String::from_utf8_lossy(name)
                );
                return Err(IoError::malformed(Format::Ply, Location::File, what));
            }
        }
    }
    let mut columns = Columns::new(element, &axes);
    let room = plausible(values, element, 0);
    body.surface.positions.reserve(room);
    columns.reserve(room);
    for row in 0..element.count {
        let mut point = [0.0; 3];
        columns.next_row();
        for (i, property) in element.properties.iter().enumerate() {
            match columns.uses[i] {
                Use::Axis(axis) => point[axis] = number(values, property.scalar, element, row)?,
                Use::Value {
                    attribute,
                    component,
                } => {
                    let value = number(values, property.scalar, element, row)?;
                    columns.set(attribute, component, value);
                }
                _ => skip_property(values, property, element, row)?,
            }
        }
        body.surface.positions.push(DVec3::from_array(point));
        values.end_item();
    }
    body.vertex = columns.attributes;
    Ok(())
}

/// The index of the property that lists the corners of faces or strips.
fn corners_of(element: &Element) -> Result<usize, IoError> {
    let is_corners = |p: &Property| {
        p.length.is_some() && matches!(&p.name[..], b"vertex_indices" | b"vertex_index")
    };
    element
        .properties
        .iter()
        .position(is_corners)
        .ok_or_else(|| {
            let what = format!(
                "the {} elements have no list 'vertex_indices'",
                text::shown(&element.name)
            );
            IoError::malformed(Format::Ply, Location::File, what)
        })
}

fn read_faces<V: Values>(
    values: &mut V,
    element: &Element,
    body: &mut Body,
) -> Result<(), IoError> {
    if element.count == 0 {
        return Ok(());
    }
    let corners_at = corners_of(element)?;
    let mut columns = Columns::new(element, &vec![None; element.properties.len()]);
    let uv_at = element.properties.iter().position(|p| {
        p.length.is_some()
            && matches!(p.scalar, Scalar::F32 | Scalar::F64)
            && matches!(&p.name[..], b"texcoord" | b"texcoords")
    });
    if let Some(at) = uv_at {
        columns.uses[at] = Use::CornerUv;
        let scalar = element.properties[at].scalar;
        let pool = Attribute::new("texcoord", Role::Uv(0), scalar, 2);
        body.face.uv = Some((pool, Vec::new()));
    }
    let three_corners = 3 * V::least_size(element.properties[corners_at].scalar);
    let room = plausible(values, element, three_corners);
    body.surface.reserve_faces(room);
    columns.reserve(room);
    let (mut corners, mut uv) = (Vec::new(), Vec::new());
    for row in 0..element.count {
        columns.next_row();
        uv.clear();
        for (i, property) in element.properties.iter().enumerate() {
            match columns.uses[i] {
                _ if i == corners_at => {
                    corners.clear();
                    for _ in 0..list_length(values, property, element, row)? {
                        let value = number(values, property.scalar, element, row)?;
                        corners.push(vertex_index(value, row)?);
                    }
                }
                Use::Value {
                    attribute,
                    component,
                } => {
                    let value = number(values, property.scalar, element, row)?;
                    columns.set(attribute, component, value);
                }
                Use::CornerUv => {
                    for _ in 0..list_length(values, property, element, row)? {
                        uv.push(number(values, property.scalar, element, row)?);
                    }
                }
                _ => skip_property(values, property, element, row)?,
            }
        }
        values.end_item();
        body.surface.push_face(&corners)?;
        if let Some((pool, places)) = &mut body.face.uv {
            add_uv(&uv, corners.len(), pool, places);
        }
    }
    body.face.attributes = columns.attributes;
    Ok(())
}

/// Adds the texture coordinates of a face, two numbers per corner. A list of another length, with numbers that are not finite, or of
/// [`NO_UV`] only is ignored.
fn add_uv(uv: &[f64], corners: usize, pool: &mut Attribute, places: &mut Vec<u32>) {
    let is_none = |v: &f64| v.to_bits() == NO_UV.to_bits();
    let fits =
        uv.len() == 2 * corners && uv.iter().all(|v| v.is_finite()) && !uv.iter().all(is_none);
    for corner in 0..corners {
        if fits {
            places.push(pool.len() as u32);
            pool.values
                .extend_from_slice(&uv[2 * corner..2 * corner + 2]);
        } else {
            places.push(NONE);
        }
    }
}

fn read_strips<V: Values>(
    values: &mut V,
    element: &Element,
    surface: &mut MeshBuilder,
) -> Result<(), IoError> {
    if element.count == 0 {
        return Ok(());
    }
    let corners_at = corners_of(element)?;
    let mut corners = Vec::new();
    for row in 0..element.count {
        for (i, property) in element.properties.iter().enumerate() {
            if i != corners_at {
                skip_property(values, property, element, row)?;
                continue;
            }
            corners.clear();
            for _ in 0..list_length(values, property, element, row)? {
                let value = number(values, property.scalar, element, row)?;
                if value == -1.0 {
                    surface.push_strip(&corners);
                    corners.clear();
                } else {
                    corners.push(vertex_index(value, row)?);
                }
            }
            surface.push_strip(&corners);
        }
        values.end_item();
    }
    Ok(())
}

fn vertex_index(value: f64, row: u64) -> Result<u32, IoError> {
    let index = value as u32;
    if f64::from(index) == value {
        return Ok(index);
    }
    let what = format!("it uses vertex {value}, which is not a valid index");
    Err(IoError::malformed(
        Format::Ply,
        Location::Item("face", row as usize),
        what,
    ))
}

fn skip_element<V: Values>(values: &mut V, element: &Element) -> Result<(), IoError> {
    if element.properties.is_empty() {
        return Ok(());
    }
    for row in 0..element.count {
        for property in &element.properties {
            skip_property(values, property, element, row)?;
        }
        values.end_item();
    }
    Ok(())
}

fn skip_property<V: Values>(
    values: &mut V,
    property: &Property,
    element: &Element,
    row: u64,
) -> Result<(), IoError> {
    for _ in 0..list_length(values, property, element, row)? {
        number(values, property.scalar, element, row)?;
    }
    Ok(())
}

/// The length of a list, checked against the rest of the file; 1 for a scalar property.
fn list_length<V: Values>(
    values: &mut V,
    property: &Property,
    element: &Element,
    row: u64,
) -> Result<usize, IoError> {
    let Some(scalar) = property.length else {
        return Ok(1);
    };
    let length = number(values, scalar, element, row)?;
    let room = values.left() / V::least_size(property.scalar);
    if length < 0.0 || length.fract() != 0.0 || length > room as f64 {
        let what =
            format!("it claims a list of {length} numbers, but the file has room for {room}");
        return Err(IoError::malformed(Format::Ply, place(element, row), what));
    }
    Ok(length as usize)
}

#[inline]
fn number<V: Values>(
    values: &mut V,
    scalar: Scalar,
    element: &Element,
    row: u64,
) -> Result<f64, IoError> {
    match values.take(scalar) {
        Some(value) => Ok(value),
        None => Err(ended(values, element, row)),
    }
}

#[cold]
fn ended<V: Values>(values: &V, element: &Element, row: u64) -> IoError {
    values.complaint().unwrap_or_else(|| {
        let name = String::from_utf8_lossy(&element.name);
        let what = format!(
            "the file ends inside {name} {row} of the {} it claims to have",
            element.count
        );
        IoError::malformed(Format::Ply, Location::File, what)
    })
}

fn place(element: &Element, row: u64) -> Location {
    let kind = match &element.name[..] {
        b"vertex" => "vertex",
        b"face" => "face",
        _ => "element",
    };
    Location::Item(kind, row as usize)
}
