//! Tests of USD: the same stage as text, as a binary file that OpenUSD 26.11 wrote, and as a package; transforms, references, faults, and
//! written files.

use base64::Engine;
use base64::engine::general_purpose::STANDARD as BASE64;
use glam::DVec3;

use super::super::samples::*;
use super::super::{Contents, Precision, WriteOptions, model_to_bytes, read_bytes};
use super::*;
use isomend_core::mesh::attributes::{LabelKind, PATCH_NAME, Role};
use isomend_core::mesh::{Mesh, Unit};

/// A strip of eight squares under a translation in time and a rotation, with values of all kinds and a subset with a material; a
/// reference to it; and a prim with two variants.
const STAGE: &str = r#"#usda 1.0
(
    "A comment"
    defaultPrim = "W"
    metersPerUnit = 0.001
    upAxis = "Z"
    customLayerData = { string by = "}"; dictionary more = { int a = 1 } }
)

def Xform "W" # the world
{
    def Xform "X"
    {
        float xformOp:rotateZ = 90
        double3 xformOp:translate.timeSamples = { 2: (0, 0, 9), 1: (0, 0, 5), }
        uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateZ"]
        def Mesh "Strip"
        {
            int[] faceVertexCounts = [4, 4, 4, 4, 4, 4, 4, 4]
            int[] faceVertexIndices = [0, 2, 3, 1, 2, 4, 5, 3, 4, 6, 7, 5, 6, 8, 9, 7, 8, 10, 11, 9, 10, 12, 13, 11, 12, 14, 15, 13, 14, 16, 17, 15]
            point3f[] points = [(0, 0, 0), (0, 1, 0), (1, 0, 0), (1, 1, 0), (2, 0, 0), (2, 1, 0), (3, 0, 0), (3, 1, 0), (4, 0, 0), (4, 1, 0), (5, 0, 0), (5, 1, 0), (6, 0, 0), (6, 1, 0), (7, 0, 0), (7, 1, 0), (8, 0, 0), (8, 1, 0)]
            color3f[] primvars:displayColor = [(0, 0.5, 0.25), (0.125, 0.5, 0.25), (0.25, 0.5, 0.25), (0.375, 0.5, 0.25), (0.5, 0.5, 0.25), (0.625, 0.5, 0.25), (0.75, 0.5, 0.25), (0.875, 0.5, 0.25)] (
                interpolation = "uniform"
            )
            texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] (interpolation = "faceVarying")
            int[] primvars:st:indices = [0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3]
            float[] primvars:table = [0.5, 0.75, 0.5, 0.75, 0.5, 0.75, 0.5, 0.75, 0.5, 0.75, 0.5, 0.75, 0.5, 0.75, 0.5, 0.75, 0.5, 0.75] (interpolation = "vertex")
            float[] primvars:whole = [0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2] (interpolation = "vertex")
            uniform token subdivisionScheme = "none"
            def GeomSubset "half" (prepend apiSchemas = ["MaterialBindingAPI"])
            {
                uniform token elementType = "face"
                int[] indices = [0, 1, 2, 3]
                rel material:binding = </W/Looks/Red>
            }
        }
    }
    def "Looks" { def Material "Red" { } }
    def Xform "Copy" (prepend references = </W/X> (offset = 1))
    {
        double3 xformOp:translate:c = (0, 0, -100)
        uniform token[] xformOpOrder = ["xformOp:translate:c"]
    }
    def Xform "V" (
        variants = { string shape = "a" }
        prepend variantSets = "shape"
    )
    {
        variantSet "shape" = {
            "a" {
                def Mesh "Ta" { int[] faceVertexCounts = [3]; int[] faceVertexIndices = [0, 1, 2]; point3f[] points = [(50, 0, 0), (51, 0, 0), (50, 1, 0)] }
            }
            "b" {
                def Mesh "Tb" { int[] faceVertexCounts = [3]; int[] faceVertexIndices = [0, 1, 2]; point3f[] points = [(51, 0, 0), (52, 0, 0), (51, 1, 0)] }
            }
        }
    }
}
"#;

/// The same stage, as OpenUSD wrote it in its binary format.
const BINARY: &str = "UFhSLVVTREMACAAAAAAAALEKAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAPyp8dJNYlA/AQAAAAAAAAAFAAAABAAAAAAAAAALAAAADAAAAA0AAAAOAAAAIAEAAAAAAAAAAAAAAAIAAAAAAAAAAAAAAAAAAAAAAPA/AAAAAAAAAAACAAAAAAAAABAAAAARAAAAAQAAAAAAAAATAAAAAQAAAAAAAAAVAAAAIAEAAAAAAAAAAQAAAAEAAAAAAAAAAQAAAAIAAAACAAAAAAAAABgAAAAaAAAAAQAAAAAAAAAdAAAAAwAAAAAAAAAgAAAAIQAAACIAAAABAAAAAAAAACMAAAADAAAAAAAAACUAAAARAAAAJgAAAAEAAAAAAAAAJwAAAAkAAAAAAAAAIAAAACEAAAAiAAAAKAAAACkAAAAqAAAAKwAAACwAAAAtAAAAAQAAAAAAAAAuAAAAIAEAAAAAAAAAMAAAAAQAAAAAAAAAMgAAADMAAAA0AAAANQAAAAEAAAAAAAAAAwAAAAgAAAAAAAAABAAAAAQAAAAEAAAABAAAAAQAAAAEAAAABAAAAAQAAAADAAAAAAAAAAAAAAABAAAAAgAAACAAAAAAAAAAFgAAAAAAAAAAYgEAAABFRAEANQAC/gIAUP4C/gL+BAAAAAAAAAAAAAAAAQAAAAIAAAADAAAAAwEAAAAAAAAABQAAAAAAAwAAAAAAAAAAAEhCAAAAAAAAAAAAAExCAAAAAAAAAAAAAEhCAACAPwAAAAAAAAAAAwAAAAAAAAAAAExCAAAAAAAAAAAAAFBCAAAAAAAAAAAAAExCAACAPwAAAAAAAAAAEgAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAACAPwAAAAAAAIA/AAAAAAAAAAAAAIA/AACAPwAAAAAAAABAAAAAAAAAAAAAAABAAACAPwAAAAAAAEBAAAAAAAAAAAAAAEBAAACAPwAAAAAAAIBAAAAAAAAAAAAAAIBAAACAPwAAAAAAAKBAAAAAAAAAAAAAAKBAAACAPwAAAAAAAMBAAAAAAAAAAAAAAMBAAACAPwAAAAAAAOBAAAAAAAAAAAAAAOBAAACAPwAAAAAAAABBAAAAAAAAAAAAAABBAACAPwAAAAAIAAAAAAAAAAAAAAAAAAA/AACAPgAAAD4AAAA/AACAPgAAgD4AAAA/AACAPgAAwD4AAAA/AACAPgAAAD8AAAA/AACAPgAAID8AAAA/AACAPgAAQD8AAAA/AACAPgAAYD8AAAA/AACAPgQAAAAAAAAAAAAAAAAAAAAAAIA/AAAAAAAAgD8AAIA/AAAAAAAAgD8gAAAAAAAAABIAAAAAAAAAAFMBAAAAAQEAgAD9/f39/f39EgAAAAAAAAB0AgAAAAAAAD8AAEA/FQAAAAAAAAAA8AMBAAAAEREREQEA//////////8SAAAAAAAAAGkSAAAAAAAAAADwAAEAAABBEARBAAD+/v7+/gABAAAAAAAAABAAAAAAAAAAAgAAAAAAAAAlAAAAJgAAACAAAAAAAAAAAgAAAAAAAAAAAAAAAADwPwAAAAAAAABAsAQAAAAAMAAIAAAAAAAAAAIAAAAAAAAAAAAFAAAAF0AAAAkAAAAXQEoAAAAAAAAA5gIAAAAAAABDAgAAAAAAAAD0bjstKQAAWgB1cEF4aXMAbWV0ZXJzUGVyVW5pdABXAHByaW1DaGlsZHJlbgBkZWZhdWx0UHJpbQBzcGVjaWZpZXIAWGZvcm0AdHlwZU5hbWUAWABMb29rcwBDb3B5AFYAcmVmZXJlbmNlcwB4Zm9ybU9wOnRyYW5zbGF0ZTpjFAD1H09yZGVyAHByb3BlcnRpZXMAUmVkAE1hdGVyaWFsAHNoYXBlAHZhcmlhbnRTZXSRAAYTAHZOYW1lcwBhJQCUbGVjdGlvbgBiEwAFNQARe08AVD19AFRhDAD6DWF9AE1lc2gAcG9pbnRzAGZhY2VWZXJ0ZXhDb3URAEBJbmRpzAAkVGI8ACRifcUABtkABRIA8RByb3RhdGVaAFN0cmlwAHN1YmRpdmlzaW9uU2NoZW1lXwHwAXZhcnM6ZGlzcGxheUNvbG8IAQMWAEd3aG9sJQA4dGFiDwAmc3RAAENzdDppmwD1AGhhbGYAR2VvbVN1YnNldEcBEEIhAJFuZ0FQSQBhcGmBAPAAYXMAZWxlbWVudFR5cGUAIQAA3QBgZmFtaWx5UwEjAG2EASA6Yh0AZG5nAHRva3kBYWJpbGl0eS4BBBsCZQBpbnRbXTYAAHMAwgB0YXJnZXRQYXRoc2EBYDNmW10AY+oAAQoAMXVuaUICkWludGVycG9sYbgBAX0BQG9yZDItAAGRAbBhcnlpbmcAZmxvYWQAEXahAVIAbm9uZRQAggBkb3VibGUzowDwAFtdAHRpbWVTYW1wbGVzAAMAAAAAAAAAAQAAABUAAAAYAAAAPQAAAAAAAABCAAAAAAAAAABSAAAAAFUBAPMfFQAVVBUVVBUBAwECAQEC/AkD9AQMAQIC6wQI9Az0DPQEJ+H4LQLRLwPOL9E2+QMAYC/RL9EvEEUBAAAAAAAAACACAAEAMAtAWAcAQQAJAGAIADEpAAUIACELQAcAQQAqQAkJADELQGwIADEpAIQIADEjAK0IADMpAL0IABEUCAAxC0DJCAAxKQDVCAAxIQDiCAAxLQDyCABAKQACAQkAMCkAHwcAQwALQA4QABMiCAATLggAE0IIABNOCAATeggAEy84ABGGEAAxIACTCAAzKQA2GAABDwBDACxAOBAAEzoIABGrGQAzA4C3CAAT3wgAEvMIACOgOygAERkZATEDgDEIADMiAD0YABFAEAAzGIBwCAAToAgAEz4gABM/CAAggAMJADAYgEEHAEMAC0BCCAAR6BgAQBSAEAQRADADoEMHAEMAC0BECAARMhgAMwigZAgAE0UYABNGCACVAAC0QgAACEBHEABznAAAABdASBAAEYg4ADMLgJgIAICoBAAAAAAuAH4AAAAAAAAAhgAAAAAAAAAA8HQBAAAAAQVFVFURVFVUEVVUUFBUVVVUVUVVFRRUBUVFRVFVVQUA/AX5BQL3BQX2BQb1BQbyD/EQ8AUM7hPtBQ7rBQwF6QUT5hvjHuEeAuAeA98eBN4bB90eBtwcCdsm2SYC2CYD1yrULdEeEtAxzTECzBsZyzbJOMc64h/FOuIgxDgFwyYAAAAAAAAAJgAAAAAAAAAlAAAAAAAAAADwEwEAAABRBEAVVVEVAEQAAAIg4AYDBvIFAwbpHwPnBQMG7QcwAAAAAAAAAADwHv////9VVEUUUVVRUVUFAQQI4x0H+w4CwgJEvAIrzwEUOLgC9/0CAQJWoP4B/icAAAAAAAAAAPAVAAAAAFFVVRRRQQEAFAT/BP3+BPwO9AX6Af4BAf4BAf8B/wH+JgAAAAAAAAAVAAAAAAAAAABwAQAAABEAQAcAkAAQBAAC9woC/SkAAAAAAAAAAPAXAwAAAFVQVVVBEABFBQUABQQFBgICBPwGBQUFBAAABAQEBAQEBAQbAAAAAAAAAADwCQAAAAAFUBUQAEABAAAAB/8F//wE/PsH+QYAAAAAAAAAVE9LRU5TAAAAAAAAAAAAAPAEAAAAAAAAWwIAAAAAAABTVFJJTkdTAAAAAAAAAAAASwcAAAAAAAAUAAAAAAAAAEZJRUxEUwAAAAAAAAAAAABfBwAAAAAAAJ8BAAAAAAAARklFTERTRVRTAAAAAAAAAP4IAAAAAAAAlgAAAAAAAABQQVRIUwAAAAAAAAAAAAAAlAkAAAAAAACkAAAAAAAAAFNQRUNTAAAAAAAAAAAAAAA4CgAAAAAAAHkAAAAAAAAA";

pub(super) fn binary() -> Vec<u8> {
    BASE64.decode(BINARY).unwrap()
}

/// A stage of one mesh of a square, with lines in the mesh, and lines of its parent.
pub(super) fn square(mesh: &str, parent: &str) -> String {
    format!(
        "#usda 1.0\ndef Xform \"P\" {{\n{parent}\ndef Mesh \"M\" {{\nint[] faceVertexCounts = [4]\nint[] faceVertexIndices = [0, 1, 2, 3]\n\
         point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]\n{mesh}\n}}\n}}\n"
    )
}

pub(super) fn read(text: &str) -> Loaded {
    read_alone(text.as_bytes(), Format::Usda).unwrap()
}

pub(super) fn message(text: &str) -> String {
    refusal(text.as_bytes(), Format::Usda)
}

fn written(loaded: &Loaded, format: Format) -> Written {
    let model = Contents {
        mesh: &loaded.mesh,
        attributes: &loaded.attributes,
        document: loaded.document.as_ref(),
    };
    model_to_bytes(&model, format, &WriteOptions::default()).unwrap()
}

#[test]
fn a_stage_is_read_with_transforms_values_materials_references_and_variants() {
    let loaded = read(STAGE);
    let (mesh, all) = (&loaded.mesh, &loaded.attributes);
    assert_eq!((mesh.positions.len(), mesh.faces.len()), (39, 33));
    // The last point of the strip is turned by a quarter, and lifted by the first of two translations.
    let near =
        |vertex: usize, point: [f64; 3]| mesh.positions[vertex].distance(point.into()) < 1e-12;
    assert!(
        near(17, [-1.0, 8.0, 5.0]) && near(35, [8.0, 1.0, -100.0]) && near(36, [50.0, 0.0, 0.0])
    );
    assert_eq!(all.unit, Some(Unit::Millimetre));
    let names = |kind| all.labels_of(kind).unwrap().names.clone();
    assert_eq!(names(LabelKind::Object), ["Strip", "Strip_", "Ta"]);
    let materials = all.labels_of(LabelKind::Material).unwrap();
    let red = |face: usize| materials.get(face) == Some("Red");
    assert!(red(0) && red(7) && !red(8) && red(16) && !red(32));
    // Each square has two triangles with its colour and its corners of the texture.
    let colours = &all.face[0];
    assert_eq!(
        (colours.role, colours.get(5), colours.get(32)),
        (Role::Colour, Some(&[0.25, 0.5, 0.25][..]), None)
    );
    let uvs = &all.corner[0];
    let uv = |face: usize| [0, 1, 2].map(|k| uvs.get(face, k).unwrap().to_vec());
    assert_eq!(
        (uvs.pool.role, uv(20)),
        (
            Role::Uv(0),
            [vec![0.0, 0.0], vec![1.0, 0.0], vec![1.0, 1.0]]
        )
    );
    let values = |name: &str, vertex: usize| {
        let attribute = all.vertex.iter().find(|a| a.name == name).unwrap();
        attribute.get(vertex).map(|value| value[0])
    };
    assert_eq!(
        [values("table", 1), values("whole", 20), values("whole", 37)],
        [Some(0.75), Some(2.0), None]
    );
}

#[test]
fn binary_files_and_packages_are_read_as_text_is() {
    let text = read(STAGE);
    let compared = |other: &Loaded| {
        assert_eq!(
            (&other.mesh, &other.attributes),
            (&text.mesh, &text.attributes)
        );
        assert_eq!(other.notes, text.notes);
    };
    compared(&read_alone(&binary(), Format::Usda).unwrap());
    for layer in [STAGE.as_bytes().to_vec(), binary()] {
        let package = package::packed(Written {
            bytes: layer,
            notes: Vec::new(),
        })
        .unwrap()
        .bytes;
        // The data begin at a multiple of 64 bytes.
        let start = package
            .windows(4)
            .position(|b| b == b"#usd" || b == b"PXR-")
            .unwrap();
        assert_eq!(start % 64, 0);
        assert_eq!(Format::sniff(&package).unwrap(), Some(Format::Usdz));
        compared(&read_alone(&package, Format::Usdz).unwrap());
    }
    for layer in [STAGE.as_bytes(), &binary()] {
        assert_eq!(Format::sniff(layer).unwrap(), Some(Format::Usda));
    }
}

#[test]
fn written_stages_are_read_back() {
    let first = read(STAGE);
    for format in [Format::Usda, Format::Usdz] {
        let bytes = written(&first, format).bytes;
        let second = read_alone(&bytes, format).unwrap();
        assert_eq!(second.mesh.faces, first.mesh.faces);
        let near = |(a, b): (&DVec3, &DVec3)| a.distance(*b) < 1e-5;
        assert!(
            second
                .mesh
                .positions
                .iter()
                .zip(&first.mesh.positions)
                .all(near)
        );
        assert_eq!(second.attributes.labels, first.attributes.labels);
        assert_eq!(second.attributes.face, first.attributes.face);
        assert_eq!(second.attributes.unit, first.attributes.unit);
        let corners = |loaded: &Loaded| {
            let uvs = &loaded.attributes.corner[0];
            let all = (0..33).flat_map(|f| [0, 1, 2].map(|k| uvs.get(f, k).map(<[f64]>::to_vec)));
            all.collect::<Vec<_>>()
        };
        assert_eq!(corners(&second), corners(&first));
        assert_eq!(written(&second, format).bytes, bytes);
    }
}

#[test]
fn missing_values_stay_missing() {
    let first = read(STAGE);
    let values = |loaded: &Loaded| -> Vec<Option<f64>> {
        let table = loaded
            .attributes
            .vertex
            .iter()
            .find(|a| a.name == "table")
            .unwrap();
        (0..39)
            .map(|vertex| table.get(vertex).map(|value| value[0]))
            .collect()
    };
    // One mesh with values at some of its vertices, faces and corners.
    let mut joined = first.clone();
    joined.attributes.labels.clear();
    let bytes = written(&joined, Format::Usda).bytes;
    let second = read_alone(&bytes, Format::Usda).unwrap();
    assert_eq!(values(&second), values(&first));
    assert!(values(&first).contains(&None));
    let faces = |loaded: &Loaded| {
        (0..33)
            .map(|f| loaded.attributes.face[0].get(f).is_some())
            .collect::<Vec<_>>()
    };
    assert_eq!(faces(&second), faces(&first));
    assert_eq!(second.attributes.corner[0].get(32, 0), None);
    assert_eq!(
        String::from_utf8(bytes)
            .unwrap()
            .matches("unauthoredValuesIndex")
            .count(),
        4
    );
}

#[test]
fn meshes_keep_their_bits() {
    for format in [Format::Usda, Format::Usdz] {
        let written = model_to_bytes(
            &Contents {
                mesh: &open_tetrahedron(),
                attributes: &Default::default(),
                document: None,
            },
            format,
            &WriteOptions::default(),
        );
        let written = written.unwrap();
        assert_eq!(
            written.notes,
            ["the unit of the coordinates is not known, so millimetres are written"]
        );
        let loaded = read_alone(&written.bytes, format).unwrap();
        assert_eq!(loaded.mesh, open_tetrahedron());
        assert_eq!(Precision::of(&loaded.mesh), Precision::F32);
    }
}

#[test]
fn patches_units_and_axes_are_kept() {
    let mut loaded = read(
        &square("uniform token subdivisionScheme = \"none\"", "").replace(
            "#usda 1.0\n",
            "#usda 1.0\n(metersPerUnit = 0.5\nupAxis = \"Y\")\n",
        ),
    );
    assert!(loaded.notes[1].contains("0.5 m"), "{:?}", loaded.notes);
    let mut marks = isomend_core::mesh::attributes::Attribute::new(
        PATCH_NAME,
        Role::Other,
        isomend_core::mesh::attributes::Scalar::U8,
        1,
    );
    marks.values = vec![0.0, 1.0];
    loaded.attributes.face.push(marks);
    let bytes = written(&loaded, Format::Usda).bytes;
    let text = String::from_utf8(bytes.clone()).unwrap();
    assert!(text.contains("metersPerUnit = 0.5\n") && text.contains("upAxis = \"Y\""));
    let again = read_alone(&bytes, Format::Usda).unwrap();
    assert_eq!(
        [0, 1].map(|face| again.attributes.is_patch(face)),
        [false, true]
    );
}

#[test]
fn operations_of_transforms_are_applied_in_order() {
    let moved = |operations: &str| {
        let loaded = read(&square("", operations));
        loaded.mesh.positions[1]
    };
    for (operations, wanted) in [
        (
            "float3 xformOp:rotateXYZ = (0, 0, 90)\ndouble3 xformOp:translate = (1, 0, 0)\nuniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:rotateXYZ\"]",
            [1.0, 1.0, 0.0],
        ),
        (
            "float3 xformOp:rotateXYZ = (0, 0, 90)\ndouble3 xformOp:translate = (1, 0, 0)\nuniform token[] xformOpOrder = [\"xformOp:rotateXYZ\", \"xformOp:translate\"]",
            [0.0, 2.0, 0.0],
        ),
        (
            "quatf xformOp:orient = (0.70710678, 0, 0, 0.70710678)\nuniform token[] xformOpOrder = [\"xformOp:orient\"]",
            [0.0, 1.0, 0.0],
        ),
        (
            "matrix4d xformOp:transform = ((0, 2, 0, 0), (-1, 0, 0, 0), (0, 0, 1, 0), (3, 4, 5, 1))\nuniform token[] xformOpOrder = [\"xformOp:transform\"]",
            [3.0, 6.0, 5.0],
        ),
        (
            "double3 xformOp:translate:pivot = (1, 0, 0)\nuniform token[] xformOpOrder = [\"!invert!xformOp:translate:pivot\"]",
            [0.0, 0.0, 0.0],
        ),
        (
            "float3 xformOp:scale = (3, 1, 1)\nuniform token[] xformOpOrder = [\"xformOp:scale\"]",
            [3.0, 0.0, 0.0],
        ),
        // First about x, which leaves the point, then about y.
        (
            "float3 xformOp:rotateXYZ = (90, 90, 0)\nuniform token[] xformOpOrder = [\"xformOp:rotateXYZ\"]",
            [0.0, 0.0, -1.0],
        ),
    ] {
        let found = moved(operations);
        assert!(
            found.distance(wanted.into()) < 1e-6,
            "{operations}: {found}"
        );
    }
}

#[test]
fn left_handed_and_mirrored_meshes_are_turned_and_holes_are_left_out() {
    let normal = |mesh: &Mesh| {
        let [a, b, c] = mesh.corners(0);
        (b - a).cross(c - a).z.signum()
    };
    let left = "uniform token orientation = \"leftHanded\"";
    let mirrored =
        "float3 xformOp:scale = (-1, 1, 1)\nuniform token[] xformOpOrder = [\"xformOp:scale\"]";
    let st = "texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] (interpolation = \"faceVarying\")";
    for (mesh, parent, wanted) in [
        ("", "", 1.0),
        (left, "", -1.0),
        ("", mirrored, 1.0),
        (left, mirrored, -1.0),
    ] {
        let loaded = read(&square(&[mesh, st].join("\n"), parent));
        assert_eq!(normal(&loaded.mesh), wanted, "{mesh} {parent}");
        // The coordinates of the texture stay at their vertices.
        for (f, face) in loaded.mesh.faces.iter().enumerate() {
            for (k, vertex) in face.iter().enumerate() {
                let [x, y, _] = loaded.mesh.positions[*vertex as usize].to_array();
                assert_eq!(
                    loaded.attributes.corner[0].get(f, k),
                    Some(&[x.abs(), y][..])
                );
            }
        }
    }
    let strip = STAGE.replace(
        "uniform token subdivisionScheme",
        "int[] holeIndices = [0, 7]\nuniform token subdivisionScheme",
    );
    let loaded = read(&strip);
    assert_eq!(loaded.mesh.faces.len(), 33 - 8);
    assert!(
        loaded
            .notes
            .iter()
            .any(|note| note == "skipped: faces that are holes: 4"),
        "{:?}",
        loaded.notes
    );
}

#[test]
fn layers_beside_the_file_and_in_a_package_are_followed() {
    let main = "#usda 1.0\ndef Xform \"A\" (references = @./parts/one.usda@</P>) { }\ndef \"B\" (payload = @parts/one.usda@) { }\n\
                def \"C\" (references = @gone.usda@</P>) { }\n";
    let one = square("", "").replace(
        "#usda 1.0\n",
        "#usda 1.0\n(subLayers = [@../more.usda@]\ndefaultPrim = \"P\")\n",
    );
    let resolve = |name: &str, _: u64| match name {
        "parts/one.usda" => Ok(one.clone().into_bytes()),
        name => no_side_file(name),
    };
    let loaded = read_bytes(main.as_bytes(), Format::Usda, &resolve).unwrap();
    assert_eq!(loaded.mesh.positions.len(), 8);
    let note = "references that cannot be followed: 2, the first to '../more.usda'";
    assert!(
        loaded.notes.iter().any(|n| n.starts_with(note)),
        "{:?}",
        loaded.notes
    );
}

fn no_side_file(name: &str) -> Result<Vec<u8>, IoError> {
    super::super::no_side_files(name, 0)
}
