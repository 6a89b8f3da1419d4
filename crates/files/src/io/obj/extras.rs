//! OBJ attributes: texture coordinates, normals, colours, materials, groups and smoothing groups.
//!
//! No fault in them makes a file unreadable: damaged values are left out, with a remark.

use std::collections::HashMap;

use super::super::mesh_builder::{CutFrom, MeshBuilder};
use super::super::{IoError, Loaded, text};
use isomend_core::mesh::Attributes;
use isomend_core::mesh::attributes::{
    Attribute, CornerAttribute, LabelKind, Labels, NONE, Role, Scalar,
};

/// Values that corners refer to by index.
#[derive(Default)]
struct Pool {
    values: Vec<[f64; 3]>,
    /// The largest count of numbers on a line.
    widest: usize,
    /// The index of the value of each corner, over the corners of all faces; ends at the last corner that has one.
    corners: Vec<u32>,
}

impl Pool {
    /// Adds a value. A value that is not a number is kept as NaN, so that the indices of the others stay right.
    fn add(&mut self, line: &[u8]) {
        let mut value = [0.0; 3];
        let mut width = 0;
        for (component, token) in value.iter_mut().zip(text::Tokens::new(line, 0)) {
            if token.starts_with(b"#") {
                break;
            }
            *component = text::number(token).unwrap_or(f64::NAN);
            width += 1;
        }
        self.widest = self.widest.max(width);
        self.values
            .push(if width == 0 { [f64::NAN; 3] } else { value });
    }

    /// Sets the value of a corner from its index in the file (from 1, or negative from the last value). Returns whether
    /// the index is valid.
    fn refer(&mut self, corner: usize, token: &[u8]) -> bool {
        let index = match text::integer(token) {
            Some(index) if index > 0 => u32::try_from(index - 1).ok(),
            Some(index) if index < 0 => usize::try_from(index.unsigned_abs())
                .ok()
                .and_then(|back| self.values.len().checked_sub(back))
                .and_then(|index| u32::try_from(index).ok()),
            _ => None,
        };
        self.corners.resize(corner, NONE);
        self.corners.push(index.unwrap_or(NONE));
        index.is_some()
    }

    fn attribute(
        self,
        name: &str,
        role: Role,
        cut: &CutFrom,
        faults: &mut usize,
    ) -> CornerAttribute {
        let components = if role == Role::Normal {
            3
        } else {
            self.widest.clamp(2, 3)
        };
        let mut pool = Attribute::new(name, role, Scalar::F64, components);
        for value in &self.values {
            let finite = value.iter().all(|v| v.is_finite());
            *faults += usize::from(!finite);
            pool.push(finite.then_some(&value[..components]));
        }
        let mut place = |corner: u32| {
            let place = self.corners.get(corner as usize).copied().unwrap_or(NONE);
            let lost = place != NONE && place as usize >= self.values.len();
            *faults += usize::from(lost);
            if lost { NONE } else { place }
        };
        let corners = cut
            .corners
            .iter()
            .map(|face| face.map(&mut place))
            .collect();
        CornerAttribute { pool, corners }
    }
}

/// Labels of one kind; the label set last applies to the faces that follow.
struct Running {
    labels: Labels,
    places: HashMap<String, u32>,
    now: u32,
}

/// All attributes collected while a file is read.
#[derive(Default)]
pub(super) struct Extras {
    uv: Pool,
    normals: Pool,
    /// Red, green, blue and alpha; NaN where a vertex has no colour.
    colours: Vec<[f64; 4]>,
    has_alpha: bool,
    running: Vec<Running>,
    libraries: Vec<String>,
    faces: usize,
    corners: usize,
    faults: usize,
}

impl Extras {
    /// Handles a statement that is neither a vertex nor a face.
    pub(super) fn statement(&mut self, line: &[u8]) {
        let word = line
            .iter()
            .position(u8::is_ascii_whitespace)
            .unwrap_or(line.len());
        let rest = line[word..].trim_ascii();
        let kind = match &line[..word] {
            b"vt" => return self.uv.add(rest),
            b"vn" => return self.normals.add(rest),
            b"mtllib" => {
                self.libraries
                    .push(String::from_utf8_lossy(rest).into_owned());
                return;
            }
            b"o" => LabelKind::Object,
            b"g" => LabelKind::Group,
            b"usemtl" => LabelKind::Material,
            b"s" => LabelKind::Smoothing,
            _ => return,
        };
        self.label(kind, &String::from_utf8_lossy(rest));
    }

    fn label(&mut self, kind: LabelKind, name: &str) {
        let found = self.running.iter().position(|r| r.labels.kind == kind);
        let at = found.unwrap_or_else(|| {
            let mut labels = Labels::new(kind);
            labels.of_face = vec![NONE; self.faces];
            self.running.push(Running {
                labels,
                places: HashMap::new(),
                now: NONE,
            });
            self.running.len() - 1
        });
        let running = &mut self.running[at];
        running.now = match running.places.get(name) {
            Some(place) => *place,
            None => {
                let place = running.labels.names.len() as u32;
                running.labels.names.push(name.to_owned());
                running.places.insert(name.to_owned(), place);
                place
            }
        };
    }

    /// Handles the numbers after the coordinates of the last vertex; `vertices` counts the vertices so far. One number
    /// is a weight and ignored, three or more are a colour.
    pub(super) fn colour(&mut self, vertices: usize, tokens: text::Tokens<'_>) {
        let mut colour = [f64::NAN, 0.0, 0.0, 1.0];
        let mut count = 0;
        for (value, token) in colour.iter_mut().zip(tokens) {
            match text::number(token).filter(|v| v.is_finite()) {
                Some(number) => *value = number,
                None => break,
            }
            count += 1;
        }
        if count >= 3 {
            self.colours.resize(vertices - 1, [f64::NAN; 4]);
            self.colours.push(colour);
            self.has_alpha |= count == 4;
        }
    }

    /// Handles the part of a face corner after its first slash.
    pub(super) fn corner(&mut self, corner: usize, token: &[u8]) {
        let corner = self.corners + corner;
        let slash = token.iter().position(|b| *b == b'/');
        let (uv, normal) = token.split_at(slash.unwrap_or(token.len()));
        if !uv.is_empty() && !self.uv.refer(corner, uv) {
            self.faults += 1;
        }
        if normal.len() > 1 && !self.normals.refer(corner, &normal[1..]) {
            self.faults += 1;
        }
    }

    /// Ends a face of `corners` corners.
    pub(super) fn face_done(&mut self, corners: usize) {
        self.faces += 1;
        self.corners += corners;
        for running in &mut self.running {
            running.labels.of_face.push(running.now);
        }
    }

    /// Drops what was noted of the corners of a face that is left out.
    pub(super) fn face_left_out(&mut self) {
        for pool in [&mut self.uv, &mut self.normals] {
            pool.corners.truncate(self.corners);
        }
    }

    /// Finishes the surface and sets its attributes.
    pub(super) fn finish(mut self, surface: MeshBuilder) -> Result<Loaded, IoError> {
        let with_corners = !self.uv.corners.is_empty() || !self.normals.corners.is_empty();
        let mut cut = (with_corners || !self.running.is_empty()).then(|| CutFrom::identity(0));
        let mut loaded = surface.finish_with(&mut cut)?;
        let mut attributes = Attributes {
            libraries: std::mem::take(&mut self.libraries),
            ..Attributes::default()
        };
        attributes
            .vertex
            .extend(self.colours(loaded.mesh.positions.len()));
        if let Some(cut) = cut {
            let pools = [
                (self.uv, "vt", Role::Uv(0)),
                (self.normals, "vn", Role::Normal),
            ];
            for (pool, name, role) in pools {
                if !pool.corners.is_empty() {
                    let attribute = pool.attribute(name, role, &cut, &mut self.faults);
                    attributes.corner.push(attribute);
                }
            }
            for Running { mut labels, .. } in self.running {
                labels.of_face = cut
                    .face
                    .iter()
                    .map(|f| labels.of_face[*f as usize])
                    .collect();
                attributes.labels.push(labels);
            }
        }
        if self.faults > 0 {
            loaded.notes.push(format!(
                "texture coordinates and normals left out, because they are not numbers or their index does not exist: {}",
                self.faults
            ));
        }
        loaded.attributes = attributes;
        Ok(loaded)
    }

    fn colours(&mut self, vertices: usize) -> Option<Attribute> {
        if self.colours.is_empty() {
            return None;
        }
        let components = if self.has_alpha { 4 } else { 3 };
        let mut colour = Attribute::new("colour", Role::Colour, Scalar::F64, components);
        for value in &self.colours {
            colour.push((!value[0].is_nan()).then_some(&value[..components]));
        }
        colour.pad(vertices);
        Some(colour)
    }
}
