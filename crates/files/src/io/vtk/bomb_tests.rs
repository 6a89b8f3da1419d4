//! Tests of small VTK files that claim, or decompress to, too much data.

use std::io::Write;
use std::time::Instant;

use lzma_rust2::XzOptions;

use super::super::samples::*;
use super::super::{Format, read_volume_bytes};

const COMPRESSORS: [&str; 3] = ["ZLib", "LZ4", "LZMA"];

/// A compressed array: `blocks` equal blocks of `block` zeros, after their sizes.
fn packed(compressor: &str, blocks: usize, block: usize) -> Vec<u8> {
    let zeros = vec![0; block];
    let one = match compressor {
        "ZLib" => {
            let mut encoder =
                flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
            encoder.write_all(&zeros).unwrap();
            encoder.finish().unwrap()
        }
        "LZ4" => lz4_flex::block::compress(&zeros),
        _ => {
            let mut encoder =
                lzma_rust2::XzWriter::new(Vec::new(), XzOptions::with_preset(1)).unwrap();
            encoder.write_all(&zeros).unwrap();
            encoder.finish().unwrap()
        }
    };
    let mut bytes = Vec::new();
    for size in [blocks, block, 0]
        .into_iter()
        .chain(std::iter::repeat_n(one.len(), blocks))
    {
        bytes.extend((size as u64).to_le_bytes());
    }
    (0..blocks).for_each(|_| bytes.extend(&one));
    bytes
}

/// A file of one piece with raw appended data.
fn file(kind: &str, compressor: &str, inner: &str, appended: &[u8]) -> Vec<u8> {
    let head = format!(
        "<VTKFile type=\"{kind}\" header_type=\"UInt64\" compressor=\"vtk{compressor}DataCompressor\">\
         {inner}<AppendedData encoding=\"raw\">_"
    );
    let tail = b"</AppendedData></VTKFile>";
    [head.as_bytes(), appended, tail].concat()
}

fn poly_data(points: usize, data: &str) -> String {
    format!(
        "<PolyData><Piece NumberOfPoints=\"{points}\" NumberOfPolys=\"1\"><PointData>{data}</PointData><Points>\
         <DataArray type=\"Int8\" NumberOfComponents=\"3\" format=\"appended\" offset=\"0\"/></Points>\
         <Polys><DataArray type=\"Int8\" Name=\"connectivity\">0 1 2</DataArray>\
         <DataArray type=\"Int8\" Name=\"offsets\">3</DataArray></Polys></Piece></PolyData>"
    )
}

#[test]
fn no_more_is_unpacked_than_is_declared() {
    for compressor in COMPRESSORS {
        // 300 MB, of which 9 bytes are declared.
        let data = packed(compressor, 300, 1 << 20);
        let bytes = file("PolyData", compressor, &poly_data(3, ""), &data);
        let message = refusal(&bytes, Format::Vtp);
        for figure in ["9 numbers are declared", "there are 314572800"] {
            assert!(message.contains(figure), "{compressor}: {message}");
        }
    }
}

#[test]
fn no_more_is_unpacked_than_a_file_of_that_size_may_take() {
    for compressor in COMPRESSORS {
        let data = packed(compressor, 300, 3 << 20);
        let bytes = file("PolyData", compressor, &poly_data(300 << 20, ""), &data);
        let message = refusal(&bytes, Format::Vtp);
        let expected = ["7549747200 more bytes", "without compression"];
        assert!(
            expected.iter().all(|e| message.contains(e)),
            "{compressor}: {message}"
        );
        let image = "<ImageData WholeExtent=\"0 511 0 511 0 511\"><Piece Extent=\"0 511 0 511 0 511\"><PointData>\
                     <DataArray type=\"Int8\" Name=\"d\" format=\"appended\" offset=\"0\"/></PointData></Piece></ImageData>";
        let data = packed(compressor, 128, 1 << 20);
        let bytes = file("ImageData", compressor, image, &data);
        let message = read_volume_bytes(&bytes, None).unwrap_err().to_string();
        let expected = ["1073741824 more bytes", "without compression"];
        assert!(
            expected.iter().all(|e| message.contains(e)),
            "{compressor}: {message}"
        );
    }
}

#[test]
fn arrays_at_one_place_are_decoded_once_and_all_counted() {
    let array = |i: usize, kind: &str| {
        format!("<DataArray type=\"{kind}\" Name=\"a{i}\" format=\"appended\" offset=\"0\"/>")
    };
    // Each array declares three of the nine zeros; the points follow.
    let data = |count: usize, kind: &str| (0..count).map(|i| array(i, kind)).collect::<String>();
    let points: Vec<u8> = [9u64, 0]
        .iter()
        .flat_map(|n| n.to_le_bytes())
        .take(8)
        .chain([0, 0, 0, 1, 0, 0, 0, 1, 0])
        .collect();
    let plain = |data: &str| {
        let bytes = file("PolyData", "", &poly_data(3, data), &points);
        let text = String::from_utf8(bytes).unwrap();
        let text = text.replace(" compressor=\"vtkDataCompressor\"", "");
        read_alone(text.as_bytes(), Format::Vtp).unwrap()
    };
    let three = data(3, "Int8").replace("/>", " NumberOfComponents=\"3\"/>");
    let loaded = plain(&three);
    assert_eq!(loaded.attributes.vertex.len(), 3);
    for attribute in &loaded.attributes.vertex {
        assert_eq!(attribute.values, [0., 0., 0., 1., 0., 0., 0., 1., 0.]);
    }
    let start = Instant::now();
    assert!(plain(&data(5000, "Int8")).attributes.is_empty());
    // 6 MB of numbers for each of 2000 arrays, with one value per point.
    let zeros = packed("ZLib", 3, 1 << 18);
    let all = data(2000, "Int8").replace("/>", " NumberOfComponents=\"3\"/>");
    let bytes = file("PolyData", "ZLib", &poly_data(1 << 18, &all), &zeros);
    let message = refusal(&bytes, Format::Vtp);
    assert!(message.contains("degenerate"), "{message}");
    assert!(start.elapsed().as_secs() < 10);
}

#[test]
fn many_attributes_arrays_and_sections_are_read_in_time() {
    let start = Instant::now();
    let attributes: String = (0..80_000).map(|i| format!(" a{i}=\"1\"")).collect();
    let text = format!("<VTKFile type=\"PolyData\"{attributes}><PolyData/></VTKFile>");
    assert!(refusal(text.as_bytes(), Format::Vtp).contains("no faces"));
    let sections: String = (0..20_000)
        .map(|i| format!("<PointData Scalars=\"s{i}\"></PointData>"))
        .collect();
    let arrays: String = (0..10_000)
        .map(|i| format!("<DataArray type=\"Int8\" Name=\"a{i}\">1 2 3</DataArray>"))
        .collect();
    let piece = format!(
        "<Piece NumberOfPoints=\"3\" NumberOfPolys=\"1\">{sections}<PointData Scalars=\"a7\">{arrays}</PointData>\
         <Points><DataArray type=\"Int8\" NumberOfComponents=\"3\">0 0 0 1 0 0 0 1 0</DataArray></Points>\
         <Polys><DataArray type=\"Int8\" Name=\"connectivity\">0 1 2</DataArray>\
         <DataArray type=\"Int8\" Name=\"offsets\">3</DataArray></Polys></Piece>"
    );
    let text = format!("<VTKFile type=\"PolyData\"><PolyData>{piece}{piece}</PolyData></VTKFile>");
    let loaded = read_alone(text.as_bytes(), Format::Vtp).unwrap();
    assert_eq!(loaded.attributes.vertex.len(), 10_000);
    let scalars = isomend_core::mesh::attributes::Active::Scalars;
    assert_eq!(loaded.attributes.vertex[7].active, Some(scalars));
    assert!(start.elapsed().as_secs() < 10, "{:?}", start.elapsed());
}

#[test]
fn markup_among_numbers_is_refused() {
    for inside in ["0 0 0 1&#32;0 0 0 1 0", "0 0 0 1 <![CDATA[0 0]]> 0 1 0"] {
        let text = format!(
            "<VTKFile type=\"PolyData\"><PolyData><Piece NumberOfPoints=\"3\"><Points><DataArray type=\"Int8\" \
             NumberOfComponents=\"3\">{inside}</DataArray></Points></Piece></PolyData></VTKFile>"
        );
        let message = refusal(text.as_bytes(), Format::Vtp);
        assert!(message.contains("markup among the numbers"), "{message}");
    }
}
