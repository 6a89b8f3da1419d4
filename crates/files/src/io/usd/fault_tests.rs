//! Tests of damaged, hostile and old USD files, and of names that cannot be written.

use super::super::read_bytes;
use super::super::samples::*;
use super::tests::{binary, message, read, square};
use super::*;

#[test]
fn faults_are_named_with_their_places() {
    let of = |from: &str, to: &str| message(&square("", "").replace(from, to));
    for (found, words) in [
        (
            of("[0, 1, 2, 3]", "[0, 1, 2, 4]"),
            ["mesh 0", "has vertex 4, but the mesh has 4"],
        ),
        (
            of("[0, 1, 2, 3]", "[0, 1, 2, -1]"),
            ["mesh 0", "has vertex -1"],
        ),
        (of("[4]", "[5]"), ["mesh 0", "more than its 4 corners"]),
        (
            of("(1, 0, 0)", "(1, x, 0)"),
            ["line 7", "'x' is not a value"],
        ),
        (
            of("(1, 0, 0)", "(1, 0, 0"),
            ["line 7", "the bracket that fits"],
        ),
        (of("def Mesh", "deff Mesh"), ["line 4", "where"]),
        (of("}\n}\n", "}\n"), ["line 10", "the file ends"]),
        (
            of("(1, 0, 0)", "(1, 1e39, 0)"),
            ["vertex 1", "not all finite"],
        ),
    ] {
        assert!(words.iter().all(|word| found.contains(word)), "{found}");
    }
    assert!(message("#usda 1.0\n").contains("no faces"));
    let deep = format!("#usda 1.0\n{}", "def \"a\" {".repeat(100_000));
    assert!(message(&deep).contains("deep inside each other"));
    let mut old = binary();
    old[9] = 3;
    let refused = refusal(&old, Format::Usda);
    assert!(
        refused.contains("version 0.3") && refused.contains("usdcat"),
        "{refused}"
    );
}

#[test]
fn classes_are_read_where_they_are_inherited_only() {
    let text = square("", "").replace("def Xform", "class Xform")
        + "def \"I\" (inherits = </P>) { }\ndef \"Off\" (\nactive = false\ninherits = </P>) { }\n";
    assert_eq!(read(&text).mesh.faces.len(), 2);
}

#[test]
fn references_in_a_circle_end() {
    let text = square("", "").replace("def Xform \"P\" {", "def Xform \"P\" (references = </P>) {");
    assert_eq!(read(&text).mesh.faces.len(), 2);
    let branching = square("", "")
        + "def \"A\" (references = </A>\npayload = </A>) { variantSet \"v\" = { \"x\" {} } }\n";
    let notes = read(&branching).notes;
    let note = "references in a circle, which are not followed: 2";
    assert!(notes.iter().any(|n| n == note), "{notes:?}");
    // A prim inside another one that refers to it, over two layers.
    let [one, two] = ["two", "one"].map(|other| {
        square(
            "",
            &format!("def \"P\" (references = @{other}.usda@</P>) {{ }}"),
        )
    });
    let resolve = |name: &str, _: u64| match name {
        "one.usda" => Ok(one.clone().into_bytes()),
        _ => Ok(two.clone().into_bytes()),
    };
    let loaded = read_bytes(one.as_bytes(), Format::Usda, &resolve).unwrap();
    assert!(loaded.notes.iter().any(|n| n.contains("in a circle")));
    let layers = square("", "").replace("1.0\n", "1.0\n(subLayers = [@a.usda@, @a.usda@])\n");
    let resolve = |_: &str, _: u64| Ok(layers.clone().into_bytes());
    let loaded = read_bytes(layers.as_bytes(), Format::Usda, &resolve).unwrap();
    assert_eq!(loaded.mesh.faces.len(), 2);
    // Each prim has two children that refer to the next one: 2 to the power of 40 prims.
    let mut text = "#usda 1.0\n".to_owned();
    for at in 0..40 {
        let next = at + 1;
        text += &format!(
            "def \"a{at}\" {{ def \"l\" (references = </a{next}>) {{ }}\ndef \"r\" (references = </a{next}>) {{ }} }}\n"
        );
    }
    assert!(message(&text).contains("limit"));
}

#[test]
fn data_behind_references_is_skipped_at_any_depth() {
    let deep = "payload = </P> (".repeat(100_000);
    assert!(message(&format!("#usda 1.0\ndef \"A\" ({deep}")).contains("the file ends"));
    let about = "(offset = 1; customData = { string s = \")\"\nint[] a = [(1)] })";
    let text = square("", "") + &format!("def \"A\" (references = </P> {about}) {{ }}\n");
    assert_eq!(read(&text).mesh.faces.len(), 4);
}

#[test]
fn names_of_missing_references_are_counted_and_charged() {
    let arcs: Vec<String> = (0..1000).map(|at| format!("</Gone{at}>")).collect();
    let arcs = arcs.join(", ");
    let text = square("", "") + &format!("def \"A\" (references = [{arcs}]) {{ }}\n");
    let notes = read(&text).notes;
    let note = "references that cannot be followed: 1000, the first to '/Gone0'";
    assert!(notes.iter().any(|n| n == note), "{notes:?}");
    // The same references, used by 3000 prims, whose names would exceed the limit.
    let user = |at| format!("def \"B{at}\" (references = </A>) {{ }}\n");
    let users: String = (0..3000).map(user).collect();
    assert!(message(&(text + &users)).contains("limit"));
}

#[test]
fn files_that_are_no_layers_are_not_read_whole() {
    let text = square("", "") + "def \"A\" (references = @film.mov@) { }\n";
    let resolve = |_: &str, most: u64| match most {
        16 => Ok(b"no layer at all.".to_vec()),
        most => panic!("{most} bytes are read"),
    };
    let loaded = read_bytes(text.as_bytes(), Format::Usda, &resolve).unwrap();
    assert!(loaded.notes.iter().any(|n| n.contains("'film.mov'")));
}

#[test]
fn damaged_files_are_survived() {
    let bytes = binary();
    for at in 0..bytes.len() {
        let _ = read_alone(&bytes[..at], Format::Usda);
        for value in [0, 1, 0x7f, 0xff] {
            let mut damaged = bytes.clone();
            damaged[at] = value;
            let _ = read_alone(&damaged, Format::Usda);
        }
    }
    assert_survives_damage(
        square("int[] a = [1] (elementSize = 2)", "").as_bytes(),
        Format::Usda,
    );
    let package = package::packed(Written {
        bytes: square("", "").into_bytes(),
        notes: Vec::new(),
    });
    assert_survives_damage(&package.unwrap().bytes, Format::Usdz);
}

#[test]
fn binary_usd_is_refused_as_an_output_by_name() {
    let error = "usdc".parse::<Format>().unwrap_err().to_string();
    assert!(error.contains("write .usda or .usdz"), "{error}");
    let output = crate::job::Output::new(std::path::PathBuf::from("out.usdc"), None);
    let error = output.err().unwrap().to_string();
    assert!(
        error.contains("out.usdc") && error.contains(".usda or .usdz"),
        "{error}"
    );
    assert_eq!("usd".parse::<Format>().unwrap(), Format::Usda);
}
