//! The transform of a USD prim from its list of operations (`xformOpOrder`).

use glam::{DMat4, DQuat, DVec3, DVec4};

use super::prim::Prim;
use isomend_core::elementary::sin_cos;

/// The transform of a prim to its parent.
#[derive(Default)]
pub(super) struct Local {
    /// The matrix; the identity if an operation cannot be read.
    pub(super) matrix: DMat4,
    /// Whether the transforms of the parents do not apply.
    pub(super) resets: bool,
    /// Whether an operation cannot be read.
    pub(super) is_unread: bool,
    /// The number of operations without a value, which are taken as none.
    pub(super) without_value: usize,
}

/// The transform of a prim to its parent.
pub(super) fn local(prim: &Prim) -> Local {
    let mut local = Local::default();
    let order = prim.value("xformOpOrder");
    for name in order.iter().flat_map(|order| order.texts()) {
        if name == "!resetXformStack!" {
            local = Local {
                resets: true,
                ..Local::default()
            };
            continue;
        }
        let (name, is_inverse) = match name.strip_prefix("!invert!") {
            Some(name) => (name, true),
            None => (&name[..], false),
        };
        let Some(value) = prim.value(name) else {
            local.without_value += 1;
            continue;
        };
        match operation(name, value.numbers()) {
            Some(operation) if is_inverse => local.matrix *= operation.inverse(),
            Some(operation) => local.matrix *= operation,
            None => local.is_unread = true,
        }
    }
    if local.is_unread || !local.matrix.is_finite() {
        (local.matrix, local.is_unread) = (DMat4::IDENTITY, true);
    }
    local
}

/// The matrix of an operation, for example `xformOp:rotateXYZ:pivot`. The first operation of a list is the outermost.
fn operation(name: &str, numbers: &[f64]) -> Option<DMat4> {
    let kind = name.strip_prefix("xformOp:")?.split(':').next()?;
    let vector = || Some(DVec3::from_slice(numbers.get(..3)?));
    let angle = || numbers.first().copied();
    match kind {
        "translate" => vector().map(DMat4::from_translation),
        "translateX" => Some(DMat4::from_translation(DVec3::X * *numbers.first()?)),
        "translateY" => Some(DMat4::from_translation(DVec3::Y * *numbers.first()?)),
        "translateZ" => Some(DMat4::from_translation(DVec3::Z * *numbers.first()?)),
        "scale" => vector().map(DMat4::from_scale),
        "scaleX" => Some(DMat4::from_scale(DVec3::new(*numbers.first()?, 1.0, 1.0))),
        "scaleY" => Some(DMat4::from_scale(DVec3::new(1.0, *numbers.first()?, 1.0))),
        "scaleZ" => Some(DMat4::from_scale(DVec3::new(1.0, 1.0, *numbers.first()?))),
        "rotateX" => angle().map(|angle| rotation('X', angle)),
        "rotateY" => angle().map(|angle| rotation('Y', angle)),
        "rotateZ" => angle().map(|angle| rotation('Z', angle)),
        "orient" => {
            let [w, x, y, z] = *numbers.first_chunk::<4>()?;
            Some(DMat4::from_quat(DQuat::from_xyzw(x, y, z, w).normalize()))
        }
        // Rows of a matrix that is multiplied from the right are columns here.
        "transform" => Some(DMat4::from_cols_array(numbers.first_chunk::<16>()?)),
        _ => rotations(kind.strip_prefix("rotate")?, vector()?),
    }
}

/// Rotations about three axes in the order of their letters: the first is applied first.
fn rotations(axes: &str, angles: DVec3) -> Option<DMat4> {
    let mut matrix = DMat4::IDENTITY;
    if axes.len() != 3 {
        return None;
    }
    for axis in axes.chars() {
        let angle = match axis {
            'X' => angles.x,
            'Y' => angles.y,
            'Z' => angles.z,
            _ => return None,
        };
        matrix = rotation(axis, angle) * matrix;
    }
    Some(matrix)
}

/// The rotation about an axis by an angle in degrees; exact for quarters.
fn rotation(axis: char, degrees: f64) -> DMat4 {
    let (sin, cos) = match degrees.rem_euclid(360.0) {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        _ => sin_cos(degrees.to_radians()),
    };
    let (x, y, z) = match axis {
        'X' => (
            DVec3::X,
            DVec3::new(0.0, cos, sin),
            DVec3::new(0.0, -sin, cos),
        ),
        'Y' => (
            DVec3::new(cos, 0.0, -sin),
            DVec3::Y,
            DVec3::new(sin, 0.0, cos),
        ),
        _ => (
            DVec3::new(cos, sin, 0.0),
            DVec3::new(-sin, cos, 0.0),
            DVec3::Z,
        ),
    };
    DMat4::from_cols(x.extend(0.0), y.extend(0.0), z.extend(0.0), DVec4::W)
}
