//! 3MF packages as slicers write them: PrusaSlicer (one mesh per object, volumes as ranges of triangles), and Bambu Studio and OrcaSlicer
//! (production extension, an object per part).

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::io::{Cursor, Read, Write};

use glam::DVec3;
use isomend::Mesh;
use zip::write::SimpleFileOptions;
use zip::{ZipArchive, ZipWriter};

use crate::desk::Desk;
use crate::shapes::{cut, joined, moved, polar, sphere};

const CORE: &str = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02";
const MODEL: &str = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel";
pub const VOLUMES: &str = "Metadata/Slic3r_PE_model.config";

pub const PARTS: &str = "Metadata/model_settings.config";

/// Writes a package of parts.
pub fn package(desk: &Desk, name: &str, parts: &[(&str, &[u8])]) {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in parts {
        zip.start_file(*name, SimpleFileOptions::default()).unwrap();
        zip.write_all(bytes).unwrap();
    }
    fs::write(desk.path(name), zip.finish().unwrap().into_inner()).unwrap();
}

/// Writes a package again with other parts.
pub fn repacked(desk: &Desk, name: &str, parts: &BTreeMap<String, Vec<u8>>) {
    let list: Vec<(&str, &[u8])> = parts.iter().map(|(k, v)| (&k[..], &v[..])).collect();
    package(desk, name, &list);
}

/// The parts of a package.
pub fn unpacked(desk: &Desk, name: &str) -> BTreeMap<String, Vec<u8>> {
    let mut zip = ZipArchive::new(Cursor::new(fs::read(desk.path(name)).unwrap())).unwrap();
    let mut parts = BTreeMap::new();
    for k in 0..zip.len() {
        let mut part = zip.by_index(k).unwrap();
        let mut bytes = Vec::new();
        part.read_to_end(&mut bytes).unwrap();
        parts.insert(part.name().unwrap().into_owned(), bytes);
    }
    parts
}

/// The mesh element of a mesh; `paint` gives the attributes of each face.
fn markup(mesh: &Mesh, paint: &dyn Fn(usize) -> String) -> String {
    let mut out = String::from("   <mesh>\n    <vertices>\n");
    for p in &mesh.positions {
        let _ = writeln!(
            out,
            "     <vertex x=\"{}\" y=\"{}\" z=\"{}\"/>",
            p.x, p.y, p.z
        );
    }
    out += "    </vertices>\n    <triangles>\n";
    for (f, [a, b, c]) in mesh.faces.iter().enumerate() {
        let _ = writeln!(
            out,
            "     <triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\"{}/>",
            paint(f)
        );
    }
    out + "    </triangles>\n   </mesh>\n"
}

/// A sphere of radius `scale` round a point, with a hole at its pole.
pub fn holed(scale: f64, at: DVec3) -> Mesh {
    moved(&cut(&sphere(6), |p| polar(p) < 30.0), scale, at)
}

fn paint(f: usize) -> String {
    match f % 4 {
        0 => " slic3rpe:custom_supports=\"4\"".to_owned(),
        1 => " slic3rpe:mmu_segmentation=\"0C\" slic3rpe:custom_seam=\"8\"".to_owned(),
        2 => " slic3rpe:mmu_segmentation=\"4C3\"".to_owned(),
        _ => String::new(),
    }
}

const RELATIONSHIPS: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\">\n \
    <Relationship Target=\"/3D/3dmodel.model\" Id=\"rel-1\" Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/>\n \
    <Relationship Target=\"/Metadata/thumbnail.png\" Id=\"rel-2\" Type=\"http://schemas.openxmlformats.org/package/2006/relationships/metadata/thumbnail\"/>\n</Relationships>";
const TYPES: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<Types xmlns=\"http://schemas.openxmlformats.org/package/2006/content-types\">\n \
    <Default Extension=\"rels\" ContentType=\"application/vnd.openxmlformats-package.relationships+xml\"/>\n \
    <Default Extension=\"model\" ContentType=\"application/vnd.ms-package.3dmanufacturing-3dmodel+xml\"/>\n <Default Extension=\"png\" ContentType=\"image/png\"/>\n</Types>";
/// A project of PrusaSlicer: an object of the given volumes, placed twice if `twice`. The second instance is an object that consists of the
/// first, turned by a quarter.
pub fn prusa(desk: &Desk, name: &str, volumes: &[(&str, Mesh)], twice: bool) {
    let (mut whole, mut ranges) = (Mesh::default(), String::new());
    for (name, mesh) in volumes {
        let first = whole.faces.len();
        whole = joined(&whole, mesh);
        let last = whole.faces.len() - 1;
        let _ = write!(
            ranges,
            "  <volume firstid=\"{first}\" lastid=\"{last}\">\n   <metadata type=\"volume\" key=\"name\" value=\"{name}\"/>\n   \
             <mesh edges_fixed=\"0\" degenerate_facets=\"0\"/>\n  </volume>\n"
        );
    }
    let again = match twice {
        true => {
            "  <object id=\"2\" type=\"model\">\n   <components>\n    <component objectid=\"1\"/>\n   </components>\n  </object>\n"
        }
        false => "",
    };
    let item = match twice {
        true => {
            "  <item objectid=\"2\" transform=\"0 1 0 -1 0 0 0 0 1 60.5 50 5\" printable=\"0\"/>\n"
        }
        false => "",
    };
    let model = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model unit=\"millimeter\" xml:lang=\"en-US\" xmlns=\"{CORE}\" \
         xmlns:slic3rpe=\"http://schemas.slic3r.org/3mf/2017/06\">\n <metadata name=\"slic3rpe:MmPaintingVersion\">1</metadata>\n \
         <metadata name=\"Application\">PrusaSlicer-2.7.4</metadata>\n <resources>\n  <object id=\"1\" type=\"model\">\n{}  </object>\n{again} \
         </resources>\n <build>\n  <item objectid=\"1\" transform=\"1 0 0 0 1 0 0 0 1 125.25 105.1 5\" printable=\"1\"/>\n{item} </build>\n</model>\n",
        markup(&whole, &paint)
    );
    let config = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<config>\n <object id=\"1\" instances_count=\"1\">\n  <metadata type=\"object\" \
         key=\"name\" value=\"Body\"/>\n  <metadata type=\"object\" key=\"layer_height\" value=\"0.1\"/>\n{ranges} </object>\n</config>\n"
    );
    package(
        desk,
        name,
        &[
            ("[Content_Types].xml", TYPES.as_bytes()),
            ("Metadata/thumbnail.png", &[0, 1, 2, 255]),
            ("_rels/.rels", RELATIONSHIPS.as_bytes()),
            ("3D/3dmodel.model", model.as_bytes()),
            ("Metadata/Slic3r_PE.config", b"; generated\n"),
            (VOLUMES, config.as_bytes()),
        ],
    );
}

/// A project of Bambu Studio: two parts in a model of their own; the second is enlarged and mirrored.
pub fn bambu(desk: &Desk, name: &str) {
    let head = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model unit=\"millimeter\" xmlns=\"{CORE}\" \
         xmlns:BambuStudio=\"http://schemas.bambulab.com/package/2021\" \
         xmlns:p=\"http://schemas.microsoft.com/3dmanufacturing/production/2015/06\" requiredextensions=\"p\">\n"
    );
    let mesh = holed(5.0, DVec3::ZERO);
    let paint = |f: usize| match f % 3 {
        0 => " paint_color=\"8\" paint_supports=\"4\"".to_owned(),
        1 => " paint_color=\"4C3\" face_property=\"2\"".to_owned(),
        _ => String::new(),
    };
    let object = |id: u32, kind: &str| {
        format!(
            "  <object id=\"{id}\" p:UUID=\"0001000{id}-81cb\" type=\"{kind}\">\n{}  </object>\n",
            markup(&mesh, &paint)
        )
    };
    let inner = format!(
        "{head} <resources>\n{}{} </resources>\n <build/>\n</model>\n",
        object(1, "model"),
        object(2, "other")
    );
    let component = |id: u32, transform: &str| {
        format!(
            "    <component p:path=\"/3D/Objects/object_1.model\" objectid=\"{id}\" p:UUID=\"b206-{id}\" transform=\"{transform}\"/>\n"
        )
    };
    let main = format!(
        "{head} <metadata name=\"Application\">BambuStudio-01.09</metadata>\n <resources>\n  <object id=\"3\" p:UUID=\"61cb\" type=\"model\">\n   \
         <components>\n{}{}   </components>\n  </object>\n </resources>\n <build p:UUID=\"2c7c17d8\">\n  <item objectid=\"3\" p:UUID=\"b1ec\" \
         transform=\"1 0 0 0 1 0 0 0 1 128 128 5\" printable=\"1\"/>\n </build>\n</model>\n",
        component(1, "1 0 0 0 1 0 0 0 1 0 0 0"),
        component(2, "1.5 0 0 0 1.5 0 0 0 -1.5 14 0 0")
    );
    let count = mesh.faces.len();
    let part = |id: u32, name: &str| {
        format!(
            "    <part id=\"{id}\" subtype=\"normal_part\">\n      <metadata key=\"name\" value=\"{name}\"/>\n      \
             <mesh_stat face_count=\"{count}\" edges_fixed=\"0\"/>\n    </part>\n"
        )
    };
    let config = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<config>\n  <object id=\"3\">\n    <metadata key=\"name\" value=\"Bracket\"/>\n    \
         <metadata face_count=\"{}\"/>\n{}{}  </object>\n  <plate>\n    <metadata key=\"plater_id\" value=\"1\"/>\n  </plate>\n</config>\n",
        2 * count,
        part(1, "body"),
        part(2, "lid")
    );
    let models = format!(
        "<Relationships><Relationship Target=\"/3D/Objects/object_1.model\" Id=\"rel-1\" Type=\"{MODEL}\"/></Relationships>"
    );
    package(
        desk,
        name,
        &[
            ("[Content_Types].xml", TYPES.as_bytes()),
            ("Metadata/plate_1.png", &[7; 300]),
            ("3D/3dmodel.model", main.as_bytes()),
            ("3D/_rels/3dmodel.model.rels", models.as_bytes()),
            ("3D/Objects/object_1.model", inner.as_bytes()),
            (
                "Metadata/project_settings.config",
                b"{\"layer_height\":\"0.2\"}",
            ),
            (PARTS, config.as_bytes()),
            ("Metadata/plate_1.gcode", b";G1"),
            ("_rels/.rels", RELATIONSHIPS.as_bytes()),
        ],
    );
}
