//! Tests of `EXT_meshopt_compression` against an encoder that uses every form of the streams, and against damaged streams.

use base64::Engine;
use serde_json::json;

use super::super::super::samples::*;
use super::super::super::{Contents, Format};
use super::*;

/// Pseudorandom numbers (xorshift).
struct Noise(u64);

impl Noise {
    fn next(&mut self, below: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 % below
    }
}

/// Encodes the 16 differences of a group in the shortest form; returns the form and the bytes.
fn group(differences: [u8; 16]) -> (u8, Vec<u8>) {
    let sentinels = |bits: usize| {
        let largest = (1u8 << bits) - 1;
        let mut bytes = vec![0u8; 2 * bits];
        let mut more = Vec::new();
        for (number, difference) in differences.into_iter().enumerate() {
            let at = number * bits;
            bytes[at / 8] |= difference.min(largest) << (8 - bits - at % 8);
            more.extend((difference >= largest).then_some(difference));
        }
        [bytes, more].concat()
    };
    if differences == [0; 16] {
        return (0, Vec::new());
    }
    let forms = [
        (1, sentinels(2)),
        (2, sentinels(4)),
        (3, differences.to_vec()),
    ];
    forms
        .into_iter()
        .min_by_key(|(_, bytes)| bytes.len())
        .unwrap()
}

/// Encodes elements in the mode of attributes.
pub(super) fn encoded(elements: &[u8], stride: usize) -> Vec<u8> {
    let mut out = vec![0xa0];
    let first = elements
        .get(..stride)
        .map_or(vec![0; stride], <[u8]>::to_vec);
    let mut before = first.clone();
    for block in elements.chunks(stride * attributes::block_elements(stride)) {
        for place in 0..stride {
            let mut differences: Vec<u8> = Vec::new();
            for element in block.chunks(stride) {
                let difference = element[place].wrapping_sub(before[place]) as i8;
                differences.push(((difference << 1) ^ (difference >> 7)) as u8);
                before[place] = element[place];
            }
            differences.resize(differences.len().next_multiple_of(16), 0);
            let groups: Vec<_> = differences
                .chunks(16)
                .map(|g| group(g.try_into().unwrap()))
                .collect();
            for four in groups.chunks(4) {
                out.push(
                    (0..)
                        .zip(four)
                        .map(|(at, (mode, _))| mode << (2 * at))
                        .sum(),
                );
            }
            groups.iter().for_each(|(_, bytes)| out.extend(bytes));
        }
    }
    out.resize(out.len() + 32usize.saturating_sub(stride), 0);
    out.extend(first);
    out
}

fn varint(mut value: u32, out: &mut Vec<u8>) {
    while value > 127 {
        out.push(value as u8 | 128);
        value >>= 7;
    }
    out.push(value as u8);
}

fn zigzag(difference: u32) -> u32 {
    (difference << 1) ^ ((difference as i32) >> 31) as u32
}

/// The table of an encoder: entries for new vertices, and for recent ones in either place.
const TABLE: [u8; 16] = [
    0, 0x10, 0x01, 0x20, 0x02, 0x12, 0x21, 0, 0, 0, 0, 0, 0, 0, 0, 0,
];

/// An encoder of triangles.
#[derive(Default)]
struct TriangleEncoder {
    codes: Vec<u8>,
    data: Vec<u8>,
    next: u32,
    last: u32,
    edges: Vec<(u32, u32)>,
    vertices: Vec<u32>,
}

impl TriangleEncoder {
    /// Adds a triangle: at a recent edge where there is one, else by the table or explicitly.
    fn add(&mut self, [a, b, c]: [u32; 3]) {
        let turned = [[a, b, c], [b, c, a], [c, a, b]];
        let at_edge = turned.into_iter().find_map(|[a, b, c]| {
            let mut recent = self.edges.iter().rev().take(15);
            let edge = recent.position(|e| *e == (a, b))?;
            Some((edge as u8, [a, b, c]))
        });
        match at_edge {
            Some((edge, corners)) => self.beside(edge, corners),
            None => self.alone([a, b, c]),
        }
    }

    fn beside(&mut self, edge: u8, [a, b, c]: [u32; 3]) {
        let recent = self.recent(c).filter(|at| (1..13).contains(at));
        let third = match recent {
            _ if c == self.next => {
                self.next += 1;
                0
            }
            Some(at) => at,
            None if c == self.last.wrapping_sub(1) => 13,
            None if c == self.last.wrapping_add(1) => 14,
            None => {
                self.give(c);
                15
            }
        };
        if third >= 13 {
            self.last = c;
        }
        if third == 0 || third >= 13 {
            self.vertices.push(c);
        }
        self.codes.push(edge << 4 | third);
        self.edges.extend([(c, b), (a, c)]);
    }

    fn alone(&mut self, [a, b, c]: [u32; 3]) {
        let is_next = a == self.next;
        self.next += u32::from(is_next);
        let parts = [self.part(b), self.part(c)];
        let entry = parts[0] << 4 | parts[1];
        let listed = TABLE.iter().take(14).position(|e| *e == entry);
        match listed.filter(|_| is_next) {
            Some(at) => self.codes.push(0xf0 | at as u8),
            None => {
                // An entry of 0 would begin the count of new vertices again.
                assert_ne!(entry, 0);
                self.codes.push(if is_next { 0xfe } else { 0xff });
                self.data.push(entry);
                let given = [!is_next, parts[0] == 15, parts[1] == 15];
                for (v, is_given) in [a, b, c].into_iter().zip(given) {
                    if is_given {
                        self.give(v);
                    }
                }
            }
        }
        let is_pushed = |part: u8| part == 0 || part == 15;
        self.vertices.push(a);
        self.vertices.extend(is_pushed(parts[0]).then_some(b));
        self.vertices.extend(is_pushed(parts[1]).then_some(c));
        self.edges.extend([(b, a), (c, b), (a, c)]);
    }

    /// How a vertex of a triangle without a recent edge is described: new, recent or given.
    fn part(&mut self, v: u32) -> u8 {
        if v == self.next {
            self.next += 1;
            return 0;
        }
        self.recent(v).map_or(15, |at| at + 1)
    }

    fn recent(&self, v: u32) -> Option<u8> {
        let mut recent = self.vertices.iter().rev().take(14);
        recent.position(|x| *x == v).map(|at| at as u8)
    }

    fn give(&mut self, v: u32) {
        varint(zigzag(v.wrapping_sub(self.last)), &mut self.data);
        self.last = v;
    }
}

fn encoded_triangles(faces: &[[u32; 3]]) -> Vec<u8> {
    let mut encoder = TriangleEncoder::default();
    faces.iter().for_each(|face| encoder.add(*face));
    [&[0xe1], &encoder.codes[..], &encoder.data, &TABLE].concat()
}

/// Encodes indices, alternately by the two baselines.
fn encoded_sequence(all: &[u32]) -> Vec<u8> {
    let (mut out, mut last) = (vec![0xd1], [0u32; 2]);
    for (at, index) in all.iter().enumerate() {
        let baseline = at % 2;
        let difference = zigzag(index.wrapping_sub(last[baseline]));
        varint(difference << 1 | baseline as u32, &mut out);
        last[baseline] = *index;
    }
    out.extend([0; 4]);
    out
}

/// A triangle as a list of corners that begins with the smallest, so that turned triangles are the same.
fn turned(face: &[u32]) -> [u32; 3] {
    let at = (0..3).min_by_key(|at| face[*at]).unwrap();
    [0, 1, 2].map(|step| face[(at + step) % 3])
}

/// A grid of triangles in rows, with a far one and one that was there before.
fn faces() -> Vec<[u32; 3]> {
    let vertex = |i: u32, j: u32| 20 * i + j;
    let mut all = Vec::new();
    for i in 0..19 {
        for j in 0..19 {
            let [a, b, c, d] = [
                vertex(i, j),
                vertex(i + 1, j),
                vertex(i + 1, j + 1),
                vertex(i, j + 1),
            ];
            all.extend([[a, b, c], [a, c, d]]);
        }
    }
    all.extend([[7, 390, 200], [100_000, 3, 100_001], [0, 1, 2]]);
    all
}

#[test]
fn attributes_are_decoded_in_all_forms_of_groups() {
    let mut noise = Noise(7);
    for stride in [4, 8, 12, 16, 20, 64, 252, 256] {
        for count in [0, 1, 15, 16, 17, 200, 600] {
            // Bytes that stay, change a little, change more, and are noise.
            let mut elements = vec![0u8; count * stride];
            for at in 0..elements.len() {
                let before = at.checked_sub(stride).map_or(9, |at| elements[at]);
                let step = match at % stride % 4 {
                    0 => 0,
                    1 => noise.next(4),
                    2 => noise.next(18),
                    _ => noise.next(256),
                };
                elements[at] = before.wrapping_add(step as u8);
            }
            let bytes = encoded(&elements, stride);
            assert_eq!(
                attributes::decoded(&bytes, count, stride),
                Some(elements),
                "{stride} {count}"
            );
            // Neither a shorter nor a longer stream is taken.
            assert_eq!(
                attributes::decoded(&bytes[..bytes.len() - 1], count, stride),
                None
            );
            let longer = [&bytes[..1], &[0], &bytes[1..]].concat();
            assert!(
                attributes::decoded(&longer, count, stride)
                    .is_none_or(|e| e.len() == count * stride)
            );
        }
    }
}

#[test]
fn the_example_of_the_specification_is_decoded() {
    let packed = [0x17, 0x5f, 0xf0, 0xbc, 0x77, 0xa9, 0x21, 0x00, 0x34, 0xb5];
    // One element of 4 bytes a group member: the example is the first byte, the others do not change.
    let stream = [&[0xa0, 2][..], &packed, &[0, 0, 0], &[0; 32]].concat();
    let elements = attributes::decoded(&stream, 16, 4).unwrap();
    let differences = [-1, -4, -3, 26, -91, 0, -6, 6, -4, -4, 5, -5, 1, -1, 0, 0];
    let mut value = 0i8;
    for (element, difference) in elements.chunks(4).zip(differences) {
        value = value.wrapping_add(difference);
        assert_eq!(element, [value as u8, 0, 0, 0]);
    }
}

#[test]
fn triangles_and_sequences_are_decoded() {
    let faces = faces();
    let bytes = encoded_triangles(&faces);
    let decoded = indices::triangles(&bytes, 3 * faces.len()).unwrap();
    let same: Vec<_> = decoded.chunks(3).map(turned).collect();
    let wanted: Vec<_> = faces.iter().map(|f| turned(f)).collect();
    assert_eq!(same, wanted);
    assert!(bytes.len() < 4 * faces.len());
    assert_eq!(
        indices::triangles(&bytes[..bytes.len() - 1], 3 * faces.len()),
        None
    );
    assert_eq!(indices::triangles(&bytes, 3 * faces.len() + 1), None);
    // Counting begins again with an appended stream: the code 0xfe with the entry 0.
    let again = [&[0xe1, 0xf0, 0xfe, 0][..], &[0; 16]].concat();
    assert_eq!(indices::triangles(&again, 6), Some(vec![0, 1, 2, 0, 1, 2]));
    let mut noise = Noise(3);
    let all: Vec<u32> = (0..500).map(|_| noise.next(1 << 28) as u32).collect();
    let bytes = encoded_sequence(&all);
    assert_eq!(indices::sequence(&bytes, all.len()), Some(all.clone()));
    assert_eq!(indices::sequence(&bytes, all.len() - 1), None);
    assert_eq!(indices::sequence(&bytes, usize::MAX), None);
}

#[test]
fn damaged_streams_end_without_a_panic() {
    let mut noise = Noise(11);
    let whole = [
        (0, encoded(&[5; 640], 16)),
        (1, encoded_triangles(&faces())),
        (2, encoded_sequence(&[1, 5, 9, 4])),
    ];
    for round in 0..20_000 {
        let (mode, mut bytes) = whole[round % 3].clone();
        for _ in 0..=noise.next(4) {
            let at = noise.next(bytes.len() as u64) as usize;
            bytes[at] = noise.next(256) as u8;
        }
        bytes.truncate(bytes.len() - noise.next(3) as usize);
        let count = 3 * noise.next(300) as usize;
        match mode {
            0 => _ = attributes::decoded(&bytes, count, 16),
            1 => _ = indices::triangles(&bytes, count),
            _ => _ = indices::sequence(&bytes, count),
        }
    }
}

#[test]
fn filters_give_unit_vectors_quaternions_and_numbers() {
    let mut normal = [0u8, 0, 127, 5];
    filters::apply(Filter::Octahedral, 4, &mut normal);
    assert_eq!(normal, [0, 0, 127, 5]);
    // (1, 1, 1) normalised is at (1/3, 1/3), and (-1, -1, -1) at (-2/3, -2/3).
    for (at, sign) in [(1.0f32 / 3.0, 1.0f32), (-2.0 / 3.0, -1.0)] {
        let part = (at * 32767.0).round() as i16;
        let mut bytes: Vec<u8> = [part, part, 32767, 9]
            .iter()
            .flat_map(|v| v.to_le_bytes())
            .collect();
        filters::apply(Filter::Octahedral, 8, &mut bytes);
        let wanted = (sign / 3f32.sqrt() * 32767.0).round() as i16;
        for value in bytes.chunks(2).take(3) {
            let value = i16::from_le_bytes([value[0], value[1]]);
            assert!((value - wanted).abs() <= 1, "{value} {wanted}");
        }
        assert_eq!(bytes[6..], [9, 0]);
    }
    // The identity: the largest component is the last, w.
    let mut bytes: Vec<u8> = [0i16, 0, 0, 2047]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    filters::apply(Filter::Quaternion, 8, &mut bytes);
    assert_eq!(bytes, [0, 0, 0, 0, 0, 0, 0xff, 0x7f]);
    for (mantissa, exponent, wanted) in [
        (3i32, -1i32, 1.5f32),
        (-5, 2, -20.0),
        (1, -126, 2f32.powi(-126)),
    ] {
        let mut bytes = (exponent << 24 | mantissa & 0xff_ffff).to_le_bytes();
        filters::apply(Filter::Exponential, 4, &mut bytes);
        assert_eq!(f32::from_le_bytes(bytes), wanted);
    }
}

/// A glTF file of a grid of triangles: compressed, with quantised positions and a node that scales them back.
pub(super) fn file(change: impl Fn(&mut Value)) -> Vec<u8> {
    let positions: Vec<u8> = (0..400u16)
        .flat_map(|v| [v / 20 * 100, v % 20 * 100, v.wrapping_mul(v) % 77, 0])
        .flat_map(u16::to_le_bytes)
        .collect();
    let faces = &faces()[..722];
    let (points, corners) = (encoded(&positions, 8), encoded_triangles(faces));
    let data = [&points[..], &corners].concat();
    let uri = base64::engine::general_purpose::STANDARD.encode(&data);
    let count = 3 * faces.len();
    let mut json = json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }],
        "extensionsUsed": [MESHOPT, "KHR_mesh_quantization"], "extensionsRequired": [MESHOPT, "KHR_mesh_quantization"],
        "nodes": [{ "mesh": 0, "scale": [0.01, 0.01, 0.01] }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "buffers": [
            { "byteLength": data.len(), "uri": format!("data:application/octet-stream;base64,{uri}") },
            { "byteLength": 3200 + 2 * count, "extensions": { MESHOPT: { "fallback": true } } },
        ],
        "bufferViews": [
            { "buffer": 1, "byteLength": 3200, "byteStride": 8, "extensions": { MESHOPT: {
                "buffer": 0, "byteLength": points.len(), "byteStride": 8, "mode": "ATTRIBUTES", "count": 400 } } },
            { "buffer": 1, "byteOffset": 3200, "byteLength": 2 * count, "extensions": { MESHOPT: {
                "buffer": 0, "byteOffset": points.len(), "byteLength": corners.len(), "byteStride": 2, "mode": "TRIANGLES",
                "count": count } } },
        ],
        "accessors": [
            { "bufferView": 0, "componentType": 5123, "count": 400, "type": "VEC3", "min": [0, 0, 0], "max": [1900, 1900, 76] },
            { "bufferView": 1, "componentType": 5123, "count": count, "type": "SCALAR" },
        ],
    });
    change(&mut json);
    serde_json::to_vec(&json).unwrap()
}

#[test]
fn a_compressed_file_is_read_and_written_without_compression() {
    let loaded = read_alone(&file(|_| {}), Format::Gltf).unwrap();
    assert_eq!(loaded.mesh.faces.len(), 722);
    assert!((loaded.mesh.positions[399].x - 19.0).abs() < 1e-6);
    assert!(loaded.notes.iter().any(|note| note.contains(MESHOPT)));
    let contents = Contents {
        mesh: &loaded.mesh,
        attributes: &loaded.attributes,
        document: loaded.document.as_ref(),
    };
    for format in [Format::Gltf, Format::Glb] {
        let written = super::super::write(&contents, format).unwrap().bytes;
        let again = read_alone(&written, format).unwrap();
        assert_eq!(again.mesh, loaded.mesh);
        assert!(again.notes.iter().all(|note| !note.contains(MESHOPT)));
    }
    let document = loaded.document.as_ref().and_then(|d| d.gltf()).unwrap();
    let text = document.json.to_string();
    assert!(
        !text.contains(MESHOPT) && text.contains("KHR_mesh_quantization"),
        "{text}"
    );
    // A patch, whose positions are 32-bit floats, can share each of these.
    let normalised = read_alone(
        &file(|json| json["accessors"][0]["normalized"] = json!(true)),
        Format::Gltf,
    )
    .unwrap();
    let document_of_floats = normalised.document.as_ref().and_then(|d| d.gltf()).unwrap();
    let mut local = document_of_floats.blocks[0].local.iter().flatten();
    assert!(local.all(|x| f64::from(*x as f32) == *x));
    // The compressed bytes are not kept.
    assert_eq!(document.buffers[0].as_ref().unwrap().len(), 0);
    assert_eq!(
        document.buffers[1].as_ref().unwrap().len(),
        3200 + 2 * 3 * 722
    );
}

#[test]
fn wrong_views_are_named() {
    let said = |path: &str, value: Value| {
        let bytes = file(|json| *json.pointer_mut(path).unwrap() = value.clone());
        refusal(&bytes, Format::Gltf)
    };
    let view = format!("/bufferViews/0/extensions/{MESHOPT}");
    for (path, value, part) in [
        ("byteStride", json!(6), "stride"),
        ("byteStride", json!(4), "another size"),
        ("count", json!(399), "another size"),
        ("count", json!(u64::MAX), "another size"),
        ("mode", json!("POINTS"), "is damaged"),
        ("mode", json!("INDICES"), "stride"),
        ("buffer", json!(9), "only 2 buffers"),
        ("buffer", json!(1), "neither a URI nor a binary chunk"),
        ("byteLength", json!(1u64 << 40), "beyond buffer 0"),
        ("byteLength", json!(40), "compressed bytes are damaged"),
    ] {
        let message = said(&format!("{view}/{path}"), value.clone());
        assert!(
            message.contains(part) && message.contains("buffer"),
            "{path} {value}: {message}"
        );
    }
    let filter =
        file(|json| json["bufferViews"][1]["extensions"][MESHOPT]["filter"] = json!("OCTAHEDRAL"));
    assert!(refusal(&filter, Format::Gltf).contains("buffer view 1"));
    assert!(said("/buffers/1/byteLength", json!(100)).contains("beyond buffer 1"));
    assert!(said("/buffers/1/byteLength", json!(1u64 << 60)).contains("memory"));
    assert!(said("/bufferViews/0/buffer", json!(7)).contains("no buffer 7"));
}
