//! Tests of values, of attributes after faces were removed, and of the faces of a file.

use super::*;

#[test]
fn values_are_rounded_to_their_type_and_may_be_missing() {
    let mut colour = Attribute::new("red", Role::Colour, Scalar::U8, 1);
    colour.push(Some(&[12.6]));
    colour.push(None);
    colour.push(Some(&[300.0]));
    assert_eq!(colour.values, [13.0, 0.0, 255.0]);
    assert_eq!(colour.get(1), None);
    assert_eq!(colour.get(2), Some(&[255.0][..]));
    assert_eq!((colour.len(), colour.unit()), (3, 255.0));
    assert_eq!(colour.get(3), None);
}

#[test]
fn faces_know_the_face_of_the_file_after_several_steps() {
    let file = (0..3).map(FaceOrigin::same).collect();
    let all = Attributes {
        file_faces: Some(file),
        ..Attributes::default()
    };
    let some = all.with_faces(&[false, true, true]);
    let part = |face: u32, corners: [u8; 3]| FaceOrigin { face, corners };
    let turn = |faces: Vec<FaceOrigin>| Origins {
        vertices: Vec::new(),
        faces,
    };
    let once = turn(vec![
        part(1, [0, 2, 1]),
        part(0, [1, 2, 3]),
        FaceOrigin::NEW,
    ]);
    let turned = some.derived(&once, &[true, true]);
    let twice = turn(vec![
        part(0, [0, 2, 1]),
        part(1, [2, 0, 1]),
        part(2, [0; 3]),
    ]);
    let back = turned.derived(&twice, &[true; 3]).file_faces.unwrap();
    assert_eq!(
        back,
        [FaceOrigin::same(2), part(1, [3, 1, 2]), FaceOrigin::NEW]
    );
}

#[test]
fn faces_taken_out_take_their_values_along() {
    let mut face = Attribute::new("id", Role::Other, Scalar::I32, 1);
    (0..4).for_each(|i| face.push(Some(&[f64::from(i)])));
    let mut material = Labels::new(LabelKind::Material);
    material.of_face = ["a", "b", "a", "c"].map(|n| material.place(n)).to_vec();
    let all = Attributes {
        face: vec![face],
        labels: vec![material],
        ..Attributes::default()
    };
    let some = all.with_faces(&[true, false, true, true]);
    assert_eq!(some.face[0].values, [0.0, 2.0, 3.0]);
    assert_eq!(some.labels[0].get(2), Some("c"));
    let fewer = some.with_faces(&[false, true, true]);
    assert_eq!(fewer.face[0].values, [2.0, 3.0]);
    assert_eq!(fewer.kept_of_file, Some(vec![false, false, true, true]));
    assert_eq!(fewer.listed(), "'id', materials");
}
