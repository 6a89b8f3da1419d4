use super::*;
use crate::mesh::attributes::{Attribute, Labels, Scalar};

/// A flat sheet of 20 × 20 unit squares, each of two triangles.
fn sheet() -> Mesh {
    let at = |i: u32, j: u32| j * 21 + i;
    let mut mesh = Mesh::default();
    for (j, i) in (0..=20).flat_map(|j| (0..=20).map(move |i| (j, i))) {
        mesh.positions.push(DVec3::new(i.into(), j.into(), 0.0));
        if i < 20 && j < 20 {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            mesh.faces.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

fn chosen(selectors: Vec<Selector>, grow: f64, shrink: f64) -> Selection {
    let mask = Mask {
        selectors,
        grow,
        shrink,
    };
    let mesh = sheet();
    Selection::new(&mesh, &mask.faces(&mesh, &Attributes::default()).unwrap())
}

fn square(low: f64, high: f64) -> Selector {
    Selector::Box {
        low: DVec3::new(low, low, -1.0),
        high: DVec3::new(high, high, 1.0),
    }
}

#[test]
fn places_choose_by_centroid_and_add_up() {
    let one = chosen(vec![square(5.0, 8.0)], 0.0, 0.0);
    assert_eq!((one.faces, one.area, one.components), (18, 9.0, 1));
    assert_eq!(
        one.bounds,
        Some([DVec3::new(5.0, 5.0, 0.0), DVec3::new(8.0, 8.0, 0.0)])
    );
    let two = chosen(
        vec![square(5.0, 8.0), square(7.0, 9.0), square(12.0, 13.0)],
        0.0,
        0.0,
    );
    assert_eq!((two.area, two.components), (9.0 + 4.0 - 1.0 + 1.0, 2));
    let ball = Selector::Ball {
        centre: DVec3::new(10.0, 10.0, 0.0),
        radius: 6.0,
    };
    let area = chosen(vec![ball], 0.0, 0.0).area;
    assert!(
        (area / (36.0 * std::f64::consts::PI) - 1.0).abs() < 0.05,
        "{area}"
    );
    let inside = Selector::Inside(std::sync::Arc::new(|p: DVec3| p.x < 1.0));
    assert_eq!(chosen(vec![inside], 0.0, 0.0).area, 20.0);
    assert_eq!(
        chosen(vec![Selector::Faces(vec![3, 3, 0])], 0.0, 0.0).faces,
        2
    );
    let none = chosen(Vec::new(), 2.0, 0.0);
    assert_eq!((none.faces, none.bounds), (0, None));
}

#[test]
fn selections_grow_and_shrink_by_lengths_along_the_surface() {
    let grown = chosen(vec![square(8.0, 12.0)], 2.0, 0.0);
    let [low, high] = grown.bounds.unwrap();
    assert_eq!((low.x, high.x), (6.0, 14.0));
    assert!(
        grown.area > 16.0 + 32.0 && grown.area <= 64.0,
        "{}",
        grown.area
    );
    let shrunk = chosen(vec![square(4.0, 16.0)], 0.0, 3.0);
    assert_eq!(
        shrunk.bounds,
        Some([DVec3::new(7.0, 7.0, 0.0), DVec3::new(13.0, 13.0, 0.0)])
    );
    // Closing: two separate regions become one.
    let apart = vec![square(5.0, 9.0), square(10.0, 14.0)];
    assert_eq!(chosen(apart.clone(), 0.0, 0.0).components, 2);
    assert_eq!(chosen(apart, 2.0, 1.0).components, 1);
    // Paths cross seams between duplicate vertices, but not gaps.
    let mut split = sheet();
    let copy = split.positions.clone();
    split.positions.extend(copy);
    for face in split.faces.iter_mut().skip(400) {
        *face = face.map(|v| v + 441);
    }
    let mask = Mask {
        selectors: vec![square(0.0, 9.0)],
        grow: 5.0,
        shrink: 0.0,
    };
    let count = |mesh: &Mesh| {
        let selected = mask.faces(mesh, &Attributes::default()).unwrap();
        selected.iter().filter(|s| **s).count()
    };
    assert_eq!(count(&split), count(&sheet()));
}

#[test]
fn paint_and_materials_choose() {
    let mesh = sheet();
    let mut colour = Attribute::new("c", Role::Colour, Scalar::U8, 3);
    let mut material = Labels::new(LabelKind::Material);
    for p in &mesh.positions {
        let red = if p.x <= 3.0 { 250.0 } else { 10.0 };
        colour.push(Some(&[red, 0.0, 0.0]));
    }
    material.of_face = (0..800)
        .map(|f| material.place(if f < 40 { "skin" } else { "bone" }))
        .collect();
    let attributes = Attributes {
        vertex: vec![colour],
        labels: vec![material],
        ..Attributes::default()
    };
    let count = |selector| {
        let mask = Mask {
            selectors: vec![selector],
            ..Mask::default()
        };
        let selected = mask.faces(&mesh, &attributes)?;
        Ok(selected.iter().filter(|s| **s).count())
    };
    let red = |tolerance| Selector::Colour {
        rgb: [1.0, 0.0, 0.0],
        tolerance,
    };
    assert_eq!(count(red(5.0 / 255.0)), Ok(120));
    assert_eq!(count(red(4.0 / 255.0)), Ok(0));
    assert_eq!(count(Selector::Material("skin".to_owned())), Ok(40));
    let error: MaskError = count(Selector::Material("x".to_owned())).unwrap_err();
    assert!(error.to_string().contains("'skin', 'bone'"), "{error}");
    assert_eq!(
        count(Selector::Faces(vec![800])),
        Err(MaskError::NoSuchFace {
            face: 800,
            count: 800
        })
    );
    let mask = Mask {
        selectors: vec![red(0.0)],
        ..Mask::default()
    };
    assert_eq!(
        mask.faces(&mesh, &Attributes::default()),
        Err(MaskError::NoColours)
    );
    let mask = Mask {
        grow: f64::NAN,
        ..Mask::default()
    };
    assert!(mask.faces(&mesh, &attributes).is_err());
}
