//! Converts attributes to the point and cell data of VTK files.

use super::super::{Contents, Format, lost, text};
use super::arrays::Array;
use super::scalar::Scalar;
use isomend_core::mesh::attributes::{Active, Attribute, CornerAttribute, Role};

/// The arrays of points and of cells of a model for a format, and the remark on attributes that are left out.
pub(super) fn arrays(model: &Contents<'_>, format: Format) -> ([Vec<Array>; 2], Option<String>) {
    let all = model.attributes;
    // Corner attributes become point data where all corners at a point agree.
    let corner: Vec<Option<Attribute>> = all
        .corner
        .iter()
        .map(|c: &CornerAttribute| c.per_vertex(model.mesh))
        .collect();
    let held = |a: &Attribute| {
        let place = all.corner.iter().position(|c| std::ptr::eq(&c.pool, a));
        place.is_none_or(|place| corner[place].is_some())
    };
    let note = lost::note(&all.listed_where(|a| !held(a), |_| true), format);
    let point = all.vertex.iter().chain(corner.iter().flatten());
    let cell = all.face.iter();
    let data = [named(point, format, true), named(cell, format, false)];
    (data, note)
}

/// The arrays of attributes, with names that differ; of several for the same use the first is active.
fn named<'a>(
    attributes: impl Iterator<Item = &'a Attribute>,
    format: Format,
    of_points: bool,
) -> Vec<Array> {
    let (mut names, mut uses) = (text::Distinct::default(), Vec::new());
    let array = |attribute: &Attribute| {
        let mut name = name(attribute);
        if name.is_empty() && format == Format::Vtk {
            // An empty name would leave the line of the array one word short.
            name = "unnamed".to_owned();
        }
        let mut use_ = use_of(attribute, of_points);
        if uses.contains(&use_) {
            use_ = Active::Plain;
        }
        uses.push(use_);
        let (scalar, values) = values(attribute);
        Array {
            name: names.name(name),
            scalar,
            components: attribute.components,
            values,
            use_: match takes(use_, attribute.components) {
                true => use_,
                false => Active::Plain,
            },
        }
    };
    attributes.map(array).collect()
}

/// How VTK is to use an array.
fn use_of(attribute: &Attribute, of_points: bool) -> Active {
    if let Some(use_) = attribute.active {
        return use_;
    }
    match attribute.role {
        Role::Normal if of_points && attribute.components == 3 => Active::Normals,
        Role::Uv(0) if of_points => Active::TextureCoordinates,
        Role::Colour if matches!(attribute.components, 3 | 4) => Active::Scalars,
        _ => Active::Plain,
    }
}

/// Whether an array with this number of components can have a use.
fn takes(use_: Active, components: usize) -> bool {
    match use_ {
        Active::Plain => true,
        Active::Scalars => (1..=4).contains(&components),
        Active::Vectors | Active::Normals => components == 3,
        Active::TextureCoordinates => (1..=3).contains(&components),
        Active::Tensors => components == 9,
    }
}

/// The name in a VTK file: the attribute's own if it came from a VTK file, or else the usual name of its role.
fn name(attribute: &Attribute) -> String {
    let role = attribute.role;
    match (attribute.active, role, attribute.components) {
        (None, Role::Normal, _) => "Normals".to_owned(),
        (None, Role::Colour, 4) => "RGBA".to_owned(),
        (None, Role::Colour, 3) => "RGB".to_owned(),
        (None, Role::Uv(0), _) => "TCoords".to_owned(),
        (None, Role::Uv(set), _) => format!("TCoords{set}"),
        (None, Role::Tangent, _) => "Tangents".to_owned(),
        _ if attribute.name.is_empty() => "array".to_owned(),
        _ => attribute.name.clone(),
    }
}

/// The values in the type to write. Attributes that did not come from a VTK file are converted to what VTK expects:
/// bytes for colours, floats for fractions.
fn values(attribute: &Attribute) -> (Scalar, Vec<f64>) {
    let own = attribute.active.is_some();
    let unit = attribute.unit();
    let (scalar, factor) = match attribute.role {
        Role::Colour if !own => (Scalar::U8, 255.0 / unit),
        _ if !own && unit != 1.0 => (Scalar::F32, 1.0 / unit),
        _ => (attribute.scalar, 1.0),
    };
    let mut values = attribute.values.clone();
    if factor != 1.0 || scalar != attribute.scalar {
        let scaled = |v: &mut f64| *v = scalar.nearest(*v * factor);
        values.iter_mut().for_each(scaled);
    }
    (scalar, values)
}
