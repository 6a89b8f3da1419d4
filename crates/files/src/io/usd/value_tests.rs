//! Tests of the values of USD meshes: memory of instances, subsets of missing faces, sets of texture coordinates, transforms, the unit.

use super::super::{Contents, WriteOptions, model_to_bytes};
use super::tests::{message, read, square};
use super::*;
use isomend_core::mesh::attributes::{LabelKind, NONE, PATCH_NAME, Role};

#[test]
fn faces_of_subsets_that_do_not_exist_are_ignored() {
    for name in ["G", PATCH_NAME] {
        let subset = format!("def GeomSubset \"{name}\" {{ int[] indices = [-1, 1, 7] }}");
        let all = read(&square(&subset, "")).attributes;
        let group = all.labels_of(LabelKind::Group);
        assert!(group.is_none_or(|labels| labels.of_face == [NONE, NONE]));
        assert!(!all.is_patch(0) && !all.is_patch(1));
    }
}

#[test]
fn memory_of_instances_is_charged() {
    let copies: String = (0..300)
        .map(|at| format!("def \"I{at}\" (references = </P>) {{ }}\n"))
        .collect();
    let many = "0,".repeat(100_000);
    for lines in [
        format!(
            "float[] primvars:a = [{many}] (interpolation = \"faceVarying\")\nint[] primvars:a:indices = [0, 0, 0, 0]"
        ),
        format!("def GeomSubset \"G\" {{ int[] indices = [{many}] }}"),
        format!("int[] holeIndices = [{}]", many.replace('0', "9")),
    ] {
        let text = square(&lines, "");
        assert_eq!(read(&text).mesh.faces.len(), 2);
        assert!(
            message(&(text + &copies)).contains("limit"),
            "{}",
            &lines[..20]
        );
    }
}

#[test]
fn texture_coordinates_have_one_number_for_a_name() {
    let values = "= [(0, 0), (1, 0), (1, 1), (0, 1)] (interpolation = \"vertex\")";
    let first = square(&format!("texCoord2f[] primvars:map {values}"), "");
    let second = square(
        &format!("texCoord2f[] primvars:map {values}\ntexCoord2f[] primvars:st {values}"),
        "",
    );
    let third = square(&format!("float2[] primvars:tint {values}"), "")
        + &square(&format!("texCoord2f[] primvars:tint {values}"), "").replace("#usda 1.0\n", "");
    let text = first + &second.replace("#usda 1.0\n", "").replace("\"P\"", "\"Q\"");
    let loaded = read(&text);
    let found = loaded.attributes.vertex.iter().map(|values| {
        let count = values.values.iter().filter(|value| **value == 1.0).count();
        (&values.name[..], values.role, count)
    });
    let wanted = [("map", Role::Uv(1), 8), ("st", Role::Uv(0), 4)];
    assert!(found.eq(wanted), "{:?}", loaded.attributes.vertex);
    let third = third.replacen("\"P\"", "\"Q\"", 1);
    let notes = read(&third).notes;
    let note = "values of meshes whose name has another type in an earlier mesh: 1";
    assert!(notes.iter().any(|n| n.contains(note)), "{notes:?}");
}

#[test]
fn operations_without_a_value_leave_the_others() {
    let order = |names: &str| format!("uniform token[] xformOpOrder = [{names}]");
    let lift = "double3 xformOp:translate = (0, 0, 5)\n";
    let height = |parent: &str| {
        let outer = "def \"O\" { double3 xformOp:translate = (0, 0, 100)\n".to_owned()
            + &order("\"xformOp:translate\"");
        let text = square("", parent).replace("#usda 1.0\n", &format!("#usda 1.0\n{outer}\n"));
        let loaded = read(&(text + "}\n"));
        (loaded.mesh.positions[0].z, loaded.notes)
    };
    let without = order("\"xformOp:translate\", \"xformOp:rotateX:gone\"");
    let (z, notes) = height(&(lift.to_owned() + &without));
    assert_eq!(z, 105.0);
    let note = "operations of transforms without a value: 1";
    assert!(notes.iter().any(|n| n.contains(note)), "{notes:?}");
    let unknown = order("\"!resetXformStack!\", \"xformOp:bend\"");
    let (z, notes) = height(&format!("double xformOp:bend = 1\n{unknown}"));
    assert_eq!(z, 0.0);
    let note = "transforms that cannot be read, taken as none: 1";
    assert!(notes.iter().any(|n| n.contains(note)), "{notes:?}");
}

#[test]
fn a_stage_without_a_unit_is_written_without_one() {
    let loaded = read(&square("", ""));
    let model = |document| Contents {
        mesh: &loaded.mesh,
        attributes: &loaded.attributes,
        document,
    };
    let has_unit = |document| {
        let options = WriteOptions::default();
        let written = model_to_bytes(&model(document), Format::Usda, &options).unwrap();
        let notes = written.notes.iter().filter(|n| n.contains("millimetres"));
        let text = String::from_utf8(written.bytes).unwrap();
        (text.contains("metersPerUnit"), notes.count())
    };
    assert_eq!(has_unit(loaded.document.as_ref()), (false, 0));
    // Of a mesh from another format the unit is named.
    assert_eq!(has_unit(None), (true, 1));
}
