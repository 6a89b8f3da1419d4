//! Masks: those of the library on small meshes, and what the command line makes them of.

use std::sync::Arc;

use arbitrary::{Result, Unstructured};
use isomend::glam::DVec3;
use isomend::job::parse_face_numbers;
use isomend::{Attribute, Attributes, LabelKind, Labels, Role, Scalar};
use isomend::{Mask, Selection, Selector};
use isomend::{Mesh, RestoreParams};

use crate::cli::mask::{BallArg, BoxArg, PaintedArg};
use crate::shapes;

/// Marks faces of a small mesh, measures them, and plans to restore them; then reads the bytes that are left as the
/// command line reads masks.
pub fn mask(data: &[u8]) {
    let mut input = Unstructured::new(data);
    let (Ok(mesh), Ok(attributes)) = (shapes::mesh(&mut input), attributes(&mut input)) else {
        return;
    };
    if let Ok(mask) = made(&mesh, &mut input) {
        apply(&mask, &mesh, &attributes);
    }
    let text = String::from_utf8_lossy(input.take_rest());
    let _ = text.parse::<BoxArg>();
    let _ = text.parse::<BallArg>();
    let _ = text.parse::<PaintedArg>();
    let _ = parse_face_numbers(&text, "faces.txt");
}

fn apply(mask: &Mask, mesh: &Mesh, attributes: &Attributes) {
    let marked = match mask.faces(mesh, attributes) {
        Ok(marked) => marked,
        Err(error) => {
            assert!(error.to_string().len() > 10);
            return;
        }
    };
    assert_eq!(marked.len(), mesh.faces.len());
    let selection = Selection::new(mesh, &marked);
    let count = marked.iter().filter(|m| **m).count();
    assert_eq!(selection.faces, count);
    assert_eq!(selection.bounds.is_some(), count > 0);
    assert!(selection.components <= count && (selection.components > 0) == (count > 0));
    let without_shrinking = Mask {
        shrink: 0.0,
        ..mask.clone()
    };
    let more = without_shrinking.faces(mesh, attributes);
    let more = more.expect("it is the same but for the shrinking");
    let shrunk = marked.iter().zip(&more).all(|(m, n)| *n || !*m);
    assert!(shrunk, "shrinking marks a face");
    let found = isomend::inspect(mesh).expect("it has faces, and their vertices are finite");
    if let Ok(plan) = found.plan_restore(&marked, &RestoreParams::default()) {
        assert_eq!(plan.cut.marked_faces, count);
        assert!((count..=mesh.faces.len()).contains(&plan.cut.removed_faces));
    }
}

/// Colours of vertices and materials of faces; there may be too few of either.
fn attributes(input: &mut Unstructured) -> Result<Attributes> {
    let mut colours = Attribute::new("rgb", Role::Colour, Scalar::U8, input.int_in_range(1..=4)?);
    for _ in 0..input.int_in_range(0..=64)? {
        let value: [u8; 4] = input.arbitrary()?;
        let value = value.map(f64::from);
        let value = &value[..colours.components];
        colours.push(input.ratio(7, 8)?.then_some(value));
    }
    let mut materials = Labels::new(LabelKind::Material);
    for _ in 0..input.int_in_range(0..=64)? {
        let place = materials.place(["a", "b", ""][input.int_in_range(0..=2)?]);
        materials.of_face.push(place);
    }
    Ok(Attributes {
        vertex: vec![colours],
        labels: vec![materials],
        ..Attributes::default()
    })
}

fn made(mesh: &Mesh, input: &mut Unstructured) -> Result<Mask> {
    let mut mask = Mask::default();
    for _ in 0..input.int_in_range(0..=3)? {
        let at = mesh.positions[input.choose_index(mesh.positions.len())?];
        let selector = match input.int_in_range(0..=5)? {
            0 => Selector::Box {
                low: at - DVec3::splat(length(input)?),
                high: at + DVec3::splat(length(input)?),
            },
            1 => Selector::Ball {
                centre: at,
                radius: length(input)?,
            },
            2 => Selector::Faces(vec![
                input.choose_index(mesh.faces.len() + 1)?,
                input.choose_index(mesh.faces.len())?,
            ]),
            3 => Selector::Colour {
                rgb: [input.arbitrary::<u8>()?; 3].map(|c| f64::from(c) / 255.0),
                tolerance: f64::from(input.arbitrary::<u8>()?) / 255.0,
            },
            4 => Selector::Material(["a", "b", "c"][input.int_in_range(0..=2)?].to_owned()),
            _ => Selector::Inside(Arc::new(move |p| p.x > at.x)),
        };
        mask.selectors.push(selector);
    }
    mask.grow = length(input)?;
    mask.shrink = length(input)?;
    Ok(mask)
}

fn length(input: &mut Unstructured) -> Result<f64> {
    let common = f64::from(input.arbitrary::<u8>()?) / 64.0;
    let lengths = [
        0.0,
        common,
        common,
        common,
        1e-30,
        1e30,
        f64::INFINITY,
        -1.0,
    ];
    Ok(*input.choose(&lengths)?)
}
