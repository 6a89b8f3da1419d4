//! Tests of composition: sublayers, the strength of arcs, lists of several layers, variants, packages beside the file. What is expected
//! is what OpenUSD 26.11 makes of the same layers.

use super::super::read_bytes;
use super::*;

/// A triangle at a place along x.
fn triangle(x: u32) -> String {
    format!(
        "int[] faceVertexCounts = [3]\nint[] faceVertexIndices = [0, 1, 2]\npoint3f[] points = [({x}, 0, 0), ({x}, 1, 0), ({x}, 0, 1)]\n"
    )
}

/// A prim with a mesh `M` at a place along x.
fn holder(name: &str, about: &str, x: u32) -> String {
    let mesh = triangle(x);
    format!("def Xform \"{name}\" ({about}) {{\ndef Mesh \"M\" {{\n{mesh}}}\n}}\n")
}

fn layer(about: &str, prims: &str) -> String {
    format!("#usda 1.0\n(\n{about}\n)\n{prims}")
}

/// The places of the triangles of a stage, sorted, and the remarks.
fn places(main: &str, others: &[(&str, Vec<u8>)]) -> (Vec<f64>, Vec<String>) {
    let resolve = |name: &str, most: u64| {
        let found = others.iter().find(|(known, _)| *known == name);
        let bytes = found.map(|(_, bytes)| bytes.iter().copied().take(most as usize).collect());
        bytes.map_or_else(|| super::super::no_side_files(name, 0), Ok)
    };
    let loaded = read_bytes(main.as_bytes(), Format::Usda, &resolve).unwrap();
    let first = loaded.mesh.faces.iter().map(|f| f[0] as usize);
    let mut all: Vec<f64> = first.map(|v| loaded.mesh.positions[v].x).collect();
    all.sort_by(f64::total_cmp);
    (all, loaded.notes)
}

fn bytes(text: String) -> Vec<u8> {
    text.into_bytes()
}

#[test]
fn the_strongest_arc_has_its_say() {
    // The same mesh in a class, a variant, a reference, a payload and a specialised class: each time the strongest is left out.
    let prims = |arcs: &str, variant: &str| {
        ["I", "R", "P", "S"]
            .iter()
            .zip(1..)
            .map(|(name, x)| holder(name, "", x).replace("def Xform", "class Xform"))
            .collect::<String>()
            + &format!(
                "def Xform \"A\" ({arcs}\nvariants = {{ string v = \"{variant}\" }}\nprepend variantSets = \"v\") {{\n\
                 variantSet \"v\" = {{ \"x\" {{ def Mesh \"M\" {{ {} }} }} }} }}\n",
                triangle(5)
            )
    };
    let [inherits, reference, payload, specializes] = [
        "inherits = </I>",
        "references = </R>",
        "payload = </P>",
        "specializes = </S>",
    ];
    for (arcs, variant, wanted) in [
        (
            [specializes, payload, reference, inherits].join("\n"),
            "x",
            1.0,
        ),
        ([specializes, payload, reference].join("\n"), "x", 5.0),
        ([specializes, payload, reference].join("\n"), "gone", 2.0),
        ([specializes, payload].join("\n"), "gone", 3.0),
        (specializes.to_owned(), "gone", 4.0),
    ] {
        let (found, notes) = places(&layer("", &prims(&arcs, variant)), &[]);
        assert_eq!(found, [wanted], "{arcs} {variant}");
        let left = notes.iter().any(|n| n.contains("without a chosen one: 1"));
        assert_eq!(left, variant == "gone", "{notes:?}");
    }
}

#[test]
fn local_opinions_of_all_sublayers_are_stronger_than_references() {
    let main = layer(
        "subLayers = [@weak.usda@]",
        "over \"A\" (prepend references = @ref.usda@</A>) { }\n",
    );
    let others = [
        ("weak.usda", bytes(layer("", &holder("A", "", 1)))),
        ("ref.usda", bytes(layer("", &holder("A", "", 2)))),
    ];
    assert_eq!(places(&main, &others).0, [1.0]);
    // A layer that is referred to has sublayers too, and its default prim stands in one of them.
    let main = layer("", "def \"B\" (payload = @set/ref.usda@) { }\n");
    let about = "subLayers = [@./more.usda@]\ndefaultPrim = \"A\"";
    let others = [
        ("set/ref.usda", bytes(layer(about, ""))),
        ("set/more.usda", bytes(layer("", &holder("A", "", 3)))),
    ];
    assert_eq!(places(&main, &others).0, [3.0]);
}

#[test]
fn lists_of_stronger_layers_change_those_of_weaker_ones() {
    let sources = || (1..4).map(|x| holder(&format!("S{x}"), "", x).replace("def X", "class X"));
    let sources: String = sources().collect();
    let weak = layer("", "def \"A\" (references = [</S1>, </S2>]) { }\n");
    for (list, wanted) in [
        ("prepend references = </S3>", 3.0),
        ("append references = </S3>", 1.0),
        ("delete references = </S1>", 2.0),
        ("references = </S2>", 2.0),
        ("prepend references = </S2>", 2.0),
        ("reorder references = [</S2>, </S1>]", 1.0),
    ] {
        let main = layer(
            "subLayers = [@weak.usda@]",
            &format!("over \"A\" ({list}) {{ }}\n{sources}"),
        );
        let found = places(&main, &[("weak.usda", bytes(weak.clone()))]);
        assert_eq!(found.0, [wanted], "{list}");
    }
    let main = layer(
        "subLayers = [@weak.usda@]",
        &format!(
            "over \"A\" (references = None) {{ }}\ndef \"B\" (references = </S3>) {{ }}\n{sources}"
        ),
    );
    assert_eq!(places(&main, &[("weak.usda", bytes(weak))]).0, [3.0]);
}

#[test]
fn a_stronger_layer_chooses_the_variant_of_a_weaker_one() {
    let set = |chosen: &str| {
        let variant =
            |name: &str, x| format!("\"{name}\" {{ def Mesh \"M\" {{ {} }} }}\n", triangle(x));
        let both = variant("a", 1) + &variant("b", 2);
        format!(
            "def Xform \"A\" ({chosen}\nprepend variantSets = \"v\") {{\nvariantSet \"v\" = {{\n{both}}}\n}}\n"
        )
    };
    let asset = layer(
        "defaultPrim = \"A\"",
        &set("variants = { string v = \"a\" }"),
    );
    let others = [("asset.usda", bytes(asset))];
    let main = |about: &str| {
        layer(
            "",
            &format!("def \"X\" (references = @asset.usda@\n{about}) {{ }}\n"),
        )
    };
    assert_eq!(places(&main(""), &others).0, [1.0]);
    let chosen = main("variants = { string v = \"b\" }");
    assert_eq!(places(&chosen, &others).0, [2.0]);
    // A weaker layer chooses where no other does.
    let classes = layer(
        "",
        &(set("inherits = </C>") + "class \"C\" (variants = { string v = \"b\" }) { }\n"),
    );
    assert_eq!(places(&classes, &[]).0, [2.0]);
}

#[test]
fn prims_that_stand_behind_references_are_found() {
    // The target is a child only by the reference of its parent.
    let main = layer(
        "",
        "class \"W\" (references = @asset.usda@</A>) { }\ndef \"X\" (references = </W/Inner>) { }\n",
    );
    let inner = format!(
        "def \"A\" {{ {} }}\n",
        holder("Inner", "", 7).replace('\n', " ; ")
    );
    let others = [("asset.usda", bytes(layer("", &inner)))];
    assert_eq!(places(&main, &others).0, [7.0]);
    // A class of the main layer adds to the class of the same name of a layer that is referred to.
    let asset = layer(
        "",
        "def \"A\" (inherits = </_class>) { }\nclass \"_class\" { }\n",
    );
    let main = layer(
        "",
        &("def \"X\" (references = @asset.usda@</A>) { }\n".to_owned()
            + &holder("_class", "", 8).replace("def Xform", "class Xform")),
    );
    assert_eq!(places(&main, &[("asset.usda", bytes(asset))]).0, [8.0]);
}

#[test]
fn packages_beside_the_file_are_followed() {
    let package = package::packed(Written {
        bytes: bytes(layer("defaultPrim = \"A\"", &holder("A", "", 4))),
        notes: Vec::new(),
    });
    let others = [("parts/chair.usdz", package.unwrap().bytes)];
    for asset in ["./parts/chair.usdz", "parts/chair.usdz[mesh.usda]"] {
        let main = layer("", &format!("def \"X\" (references = @{asset}@) {{ }}\n"));
        let (found, notes) = places(&main, &others);
        assert_eq!(found, [4.0]);
        assert!(!notes.iter().any(|n| n.contains("followed")), "{notes:?}");
    }
    let main = layer(
        "",
        &holder("A", "references = @parts/chair.usdz[gone.usda]@", 1),
    );
    let (found, notes) = places(&main, &others);
    assert_eq!(found, [1.0]);
    let note = "references that cannot be followed: 1, the first to 'parts/chair.usdz[gone.usda]'";
    assert!(notes.iter().any(|n| n == note), "{notes:?}");
}

#[test]
fn damaged_layers_and_files_outside_the_folder_are_named() {
    let main = layer(
        "subLayers = [@bad.usda@, @../out.usda@, @cut.usdz@]",
        &holder("A", "references = @/etc/x.usda@", 1),
    );
    let others = [
        ("bad.usda", b"#usda 1.0\ndef { }".to_vec()),
        ("cut.usdz", b"PK\x03\x04 no package".to_vec()),
    ];
    let (found, notes) = places(&main, &others);
    assert_eq!(found, [1.0]);
    for note in [
        "layers that are damaged: 1, the first 'bad.usda': ",
        "references that cannot be followed: 4, the first to 'bad.usda'",
    ] {
        assert!(notes.iter().any(|n| n.starts_with(note)), "{notes:?}");
    }
}
