//! The lines of a written USD text: arrays, names, and values of vertices, faces and corners.

use std::collections::HashMap;
use std::fmt::{self, Display, Formatter, LowerExp, Write as _};

use super::super::Contents;
use super::super::text::Distinct;
use isomend_core::mesh::attributes::{Attribute, CornerAttribute, NONE, PATCH_NAME, Role, Scalar};

/// A text with indented lines.
pub(super) struct Lines {
    pub(super) text: String,
    pub(super) depth: usize,
}

impl Lines {
    pub(super) fn line(&mut self, line: &str) {
        let _ = writeln!(self.text, "{:1$}{line}", "", 4 * self.depth);
    }

    /// Begins a prim.
    pub(super) fn open(&mut self, line: &str) {
        self.line(line);
        self.line("{");
        self.depth += 1;
    }

    /// Ends a prim.
    pub(super) fn close(&mut self) {
        self.depth -= 1;
        self.line("}");
    }

    /// Writes an array of numbers or tuples, with lines of metadata behind it.
    pub(super) fn array<'n, N: Display + 'n>(
        &mut self,
        name: &str,
        rows: impl Iterator<Item = &'n [N]>,
        metadata: &[String],
    ) {
        let _ = write!(self.text, "{:1$}{name} = [", "", 4 * self.depth);
        for (at, row) in rows.enumerate() {
            self.text.push_str(if at > 0 { ", " } else { "" });
            self.row(row);
        }
        self.text
            .push_str(if metadata.is_empty() { "]\n" } else { "] (\n" });
        if !metadata.is_empty() {
            self.depth += 1;
            metadata.iter().for_each(|line| self.line(line));
            self.depth -= 1;
            self.line(")");
        }
    }

    fn row<N: Display>(&mut self, row: &[N]) {
        if row.len() > 1 {
            self.text.push('(');
        }
        for (at, number) in row.iter().enumerate() {
            let separator = if at > 0 { ", " } else { "" };
            let _ = write!(self.text, "{separator}{number}");
        }
        if row.len() > 1 {
            self.text.push(')');
        }
    }
}

/// A number in its shortest form, with an exponent if it is very small or very large.
pub(super) struct Decimal<F>(pub(super) F);

impl<F: Copy + Display + LowerExp + Into<f64>> Display for Decimal<F> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let size = self.0.into().abs();
        match size == 0.0 || (1e-5..1e15).contains(&size) {
            true => write!(f, "{}", self.0),
            false => write!(f, "{:e}", self.0),
        }
    }
}

/// A name that USD allows: ASCII letters, digits and underscores.
pub(super) fn identifier(name: &str, otherwise: &str) -> String {
    let allowed = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let name: String = name.chars().map(allowed).collect();
    match name.chars().next() {
        None => otherwise.to_owned(),
        Some(first) if first.is_ascii_digit() => format!("_{name}"),
        Some(_) => name,
    }
}

/// The faces and vertices of a written mesh.
pub(super) struct Local<'a> {
    pub(super) model: &'a Contents<'a>,
    /// The faces of the model that it has.
    pub(super) faces: &'a [u32],
    /// The vertices of the model that it has, in order.
    pub(super) used: &'a [u32],
    /// Whether texture coordinates keep their names, since they come from USD.
    pub(super) keeps_names: bool,
}

impl Local<'_> {
    /// The places of marked faces in this mesh.
    pub(super) fn places(&self, is_marked: impl Fn(usize) -> bool) -> Vec<u32> {
        let all = (0..).zip(self.faces);
        all.filter(|(_, old)| is_marked(**old as usize))
            .map(|(new, _)| new)
            .collect()
    }
}

/// Writes all values of vertices, faces and corners.
pub(super) fn primvars(out: &mut Lines, local: &Local<'_>) {
    let mut names = Distinct::default();
    let attributes = local.model.attributes;
    for attribute in &attributes.vertex {
        let items: Vec<usize> = local.used.iter().map(|v| *v as usize).collect();
        plain(out, local, attribute, &items, "vertex", &mut names);
    }
    for attribute in attributes
        .face
        .iter()
        .filter(|attribute| attribute.name != PATCH_NAME)
    {
        let items: Vec<usize> = local.faces.iter().map(|f| *f as usize).collect();
        plain(out, local, attribute, &items, "uniform", &mut names);
    }
    for attribute in &attributes.corner {
        of_corners(out, local, attribute, &mut names);
    }
}

/// Writes one value for each item, unless all are missing.
fn plain(
    out: &mut Lines,
    local: &Local<'_>,
    attribute: &Attribute,
    items: &[usize],
    interpolation: &str,
    names: &mut Distinct,
) {
    let there = items.iter().filter(|item| attribute.get(**item).is_some());
    let count = there.count();
    if count == 0 {
        return;
    }
    let form = Form::of(attribute, local.keeps_names, names);
    if count == items.len() {
        let values = items.iter().map(|item| form.value(attribute.get(*item)));
        return form.write(
            out,
            &values.collect::<Vec<_>>(),
            &form.metadata(interpolation, None),
        );
    }
    form.indexed(
        out,
        items.iter().map(|item| (*item, attribute.get(*item))),
        interpolation,
    );
}

/// Writes the values that corners refer to, and the place of each corner's value among them.
fn of_corners(
    out: &mut Lines,
    local: &Local<'_>,
    attribute: &CornerAttribute,
    names: &mut Distinct,
) {
    let corners = local
        .faces
        .iter()
        .flat_map(|face| attribute.corners[*face as usize]);
    let values = corners.map(|corner| {
        let value = attribute
            .pool
            .get(corner as usize)
            .filter(|_| corner != NONE);
        (corner as usize, value)
    });
    if values.clone().any(|(_, value)| value.is_some()) {
        let form = Form::of(&attribute.pool, local.keeps_names, names);
        form.indexed(out, values, "faceVarying");
    }
}

/// How an attribute is written.
struct Form {
    /// The full name.
    name: String,
    kind: String,
    components: usize,
    /// Divisor of integers that stand for fractions.
    unit: f64,
    is_single: bool,
    /// Whether the fourth component of colours is written as an opacity.
    has_opacity: bool,
    /// Whether values of a type without tuples of this length are written one after the other.
    is_flat: bool,
}

impl Form {
    fn of(attribute: &Attribute, keeps_names: bool, names: &mut Distinct) -> Self {
        let components = attribute.components;
        let own = identifier(&attribute.name, "value");
        let mut take = |wanted: String| names.name(wanted);
        let (name, kind) = match (attribute.role, components) {
            (Role::Normal, 3) => (take("normals".to_owned()), "normal3f"),
            (Role::Uv(_), 2) if keeps_names => (take(own), "texCoord2f"),
            (Role::Uv(0), 2) => (take("st".to_owned()), "texCoord2f"),
            (Role::Uv(set), 2) => (take(format!("st{set}")), "texCoord2f"),
            (Role::Colour, 3 | 4) => (take("displayColor".to_owned()), "color3f"),
            (Role::Tangent, _) => (take("tangents".to_owned()), ""),
            _ => (take(own), ""),
        };
        let has_opacity = name == "displayColor" && components == 4 && names.take("displayOpacity");
        let (number, is_single) = match attribute.scalar {
            _ if !kind.is_empty() => ("", true),
            Scalar::F32 => ("float", true),
            Scalar::I64 if components == 1 => ("int64", false),
            Scalar::U64 if components == 1 => ("uint64", false),
            Scalar::U32 if components == 1 => ("uint", false),
            Scalar::F64 | Scalar::U32 | Scalar::I64 | Scalar::U64 => ("double", false),
            _ => ("int", false),
        };
        let is_flat = kind.is_empty() && components > 4;
        let kind = match kind {
            "" if components == 1 || is_flat => number.to_owned(),
            "" => format!("{number}{components}"),
            kind => kind.to_owned(),
        };
        let unit = if attribute.role == Role::Colour {
            attribute.unit()
        } else {
            1.0
        };
        let name = format!("primvars:{name}");
        Self {
            name,
            kind,
            components,
            unit,
            is_single,
            has_opacity,
            is_flat,
        }
    }

    /// Lines of metadata; `missing` is the place of a value that stands for none.
    fn metadata(&self, interpolation: &str, missing: Option<u32>) -> Vec<String> {
        let size = self
            .is_flat
            .then(|| format!("elementSize = {}", self.components));
        let interpolation = format!("interpolation = \"{interpolation}\"");
        let missing = missing.map(|place| format!("unauthoredValuesIndex = {place}"));
        size.into_iter()
            .chain([interpolation])
            .chain(missing)
            .collect()
    }

    /// Writes the distinct values of items, by their numbers, and the place of each item's value among them.
    fn indexed<'v>(
        &self,
        out: &mut Lines,
        items: impl Iterator<Item = (usize, Option<&'v [f64]>)>,
        interpolation: &str,
    ) {
        let (mut values, mut indices, mut missing) = (Vec::new(), Vec::new(), None);
        let mut places: HashMap<usize, u32> = HashMap::new();
        for (item, value) in items {
            let next = values.len() as u32;
            let place = match value {
                Some(_) => *places.entry(item).or_insert(next),
                None => *missing.get_or_insert(next),
            };
            if place == next {
                values.push(self.value(value));
            }
            indices.push(place);
        }
        self.write(out, &values, &self.metadata(interpolation, missing));
        out.array(
            &format!("int[] {}:indices", self.name),
            indices.chunks(1),
            &[],
        );
        if self.has_opacity {
            out.array(
                "int[] primvars:displayOpacity:indices",
                indices.chunks(1),
                &[],
            );
        }
    }

    /// A value as it is written; zeros for a missing one.
    fn value(&self, value: Option<&[f64]>) -> Vec<f64> {
        let value = value.map_or_else(|| vec![0.0; self.components], <[f64]>::to_vec);
        value.into_iter().map(|x| x / self.unit).collect()
    }

    fn write(&self, out: &mut Lines, values: &[Vec<f64>], metadata: &[String]) {
        let width = if self.kind == "color3f" {
            3
        } else {
            self.components
        };
        let name = format!("{}[] {}", self.kind, self.name);
        let step = if self.is_flat { 1 } else { width };
        let numbers = values.iter().flat_map(|value| &value[..width]);
        match self.is_single {
            true => {
                let single: Vec<_> = numbers.map(|x| Decimal(*x as f32)).collect();
                out.array(&name, single.chunks(step), metadata);
            }
            false => {
                let double: Vec<_> = numbers.map(|x| Decimal(*x)).collect();
                out.array(&name, double.chunks(step), metadata);
            }
        }
        if self.has_opacity {
            let opacities: Vec<_> = values
                .iter()
                .map(|value| Decimal(value[3] as f32))
                .collect();
            out.array(
                "float[] primvars:displayOpacity",
                opacities.chunks(1),
                metadata,
            );
        }
    }
}
