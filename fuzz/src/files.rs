//! Readers and writers of files.

use std::path::Path;

use isomend::LabelKind;
use isomend::Mesh;
use isomend::Volume;
use isomend::io::{
    Contents, FileDocument, Format, IoError, Loaded, Precision, WriteOptions, model_to_bytes,
    no_side_files, read_bytes, read_volume_bytes, volume_to_bytes,
};

/// Reads OBJ; what it names as its materials and textures are its own bytes.
pub fn obj(data: &[u8]) {
    mesh(data, Format::Obj);
    let itself = |_: &str, most: u64| Ok(data[..data.len().min(most as usize)].to_vec());
    let _ = read_bytes(data, Format::Obj, &itself);
}

/// Reads PLY.
pub fn ply(data: &[u8]) {
    mesh(data, Format::Ply);
}

/// Reads STL.
pub fn stl(data: &[u8]) {
    mesh(data, Format::Stl);
}

/// Reads GLB where the bytes begin as GLB does, else glTF.
pub fn gltf(data: &[u8]) {
    let binary = data.starts_with(b"glTF");
    mesh(data, if binary { Format::Glb } else { Format::Gltf });
}

/// Reads a VTK legacy file, as a mesh and as a volume.
pub fn vtk(data: &[u8]) {
    mesh(data, Format::Vtk);
    if data.trim_ascii_start().starts_with(b"#") {
        volume(data);
    }
}

/// Reads a VTK XML file, as a mesh and as a volume.
pub fn vtk_xml(data: &[u8]) {
    mesh(data, Format::Vtp);
    if !data.trim_ascii_start().starts_with(b"#") {
        volume(data);
    }
}

/// Reads OFF.
pub fn off(data: &[u8]) {
    mesh(data, Format::Off);
}

/// Reads 3MF: a package where the bytes begin as one does, else the markup of a model, which is packed first.
pub fn threemf(data: &[u8]) {
    if data.starts_with(b"PK") {
        return mesh(data, Format::ThreeMf);
    }
    mesh(&packed(b"3D/3dmodel.model", data), Format::ThreeMf);
}

/// Reads USD: a package or a binary layer where the bytes begin as one does, else a text, alone and as a package.
pub fn usd(data: &[u8]) {
    if data.starts_with(b"PK") {
        return mesh(data, Format::Usdz);
    }
    let itself = |_: &str, most: u64| Ok(data[..data.len().min(most as usize)].to_vec());
    match read_bytes(data, Format::Usda, &itself) {
        Ok(loaded) => check(&loaded),
        Err(error) => check_message(&error),
    }
    mesh(&packed(b"mesh.usd", data), Format::Usdz);
}

/// A package with one part, stored as it is.
fn packed(name: &[u8], model: &[u8]) -> Vec<u8> {
    let checksum = crc32(model).to_le_bytes();
    let size = (model.len() as u32).to_le_bytes();
    let length = (name.len() as u16).to_le_bytes();
    // Version, flags, method, time, date; checksum, sizes, length of the name, of more.
    let middle = [
        &[20, 0, 0, 0, 0, 0, 0, 0, 0x21, 0][..],
        &checksum,
        &size,
        &size,
        &length,
    ]
    .concat();
    let mut bytes = [b"PK\x03\x04", &middle[..], &[0; 2], name, model].concat();
    let start = (bytes.len() as u32).to_le_bytes();
    let entry = [b"PK\x01\x02\x14\0", &middle[..], &[0; 16], name].concat();
    bytes.extend(&entry);
    let room = (entry.len() as u32).to_le_bytes();
    bytes.extend(
        [
            b"PK\x05\x06\0\0\0\0\x01\0\x01\0",
            &room[..],
            &start,
            &[0; 2],
        ]
        .concat(),
    );
    bytes
}

/// The checksum of ZIP archives, bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    let step = |sum: u32| (sum >> 1) ^ (0xedb8_8320 & (sum & 1).wrapping_neg());
    let byte = |sum: u32, byte: &u8| (0..8).fold(sum ^ u32::from(*byte), |sum, _| step(sum));
    !bytes.iter().fold(!0, byte)
}

/// Reads a mesh of any format, writes it in every format, and reads that again.
pub fn rewrite(data: &[u8]) {
    let Ok(format) = Format::detect(data, Path::new("mesh.obj")) else {
        return;
    };
    let Ok(loaded) = read_bytes(data, format, &no_side_files) else {
        return;
    };
    for format in Format::ALL {
        for ascii in [false, true] {
            let options = WriteOptions {
                precision: Precision::of(&loaded.mesh),
                ascii,
            };
            write_and_read(&loaded, format, &options);
        }
    }
}

/// Reads a mesh of a format.
pub(crate) fn mesh(data: &[u8], format: Format) {
    match read_bytes(data, format, &no_side_files) {
        Ok(loaded) => check(&loaded),
        Err(error) => check_message(&error),
    }
}

/// What every mesh that was read must be.
fn check(loaded: &Loaded) {
    let (mesh, attributes) = (&loaded.mesh, &loaded.attributes);
    let count = mesh.positions.len();
    assert!(!mesh.faces.is_empty(), "a mesh without faces");
    assert!(
        mesh.faces.iter().flatten().all(|v| (*v as usize) < count),
        "a face names a vertex that is not there"
    );
    assert!(
        mesh.positions.iter().all(|p| p.is_finite()),
        "a position is not finite"
    );
    assert_eq!(
        loaded.f32_exact,
        Precision::of(mesh) == Precision::F32,
        "the precision is not as it is said to be"
    );
    for attribute in &attributes.vertex {
        assert!(attribute.len() <= count, "'{}' is too long", attribute.name);
    }
    for attribute in &attributes.face {
        let faces = mesh.faces.len();
        assert!(attribute.len() <= faces, "'{}' is too long", attribute.name);
    }
    for attribute in &attributes.corner {
        let name = &attribute.pool.name;
        assert_eq!(attribute.corners.len(), mesh.faces.len(), "'{name}'");
    }
}

/// A message must say something, and in a few lines.
fn check_message(error: &IoError) {
    let length = error.to_string().len();
    assert!(
        (10..4000).contains(&length),
        "a message of {length} characters"
    );
}

fn write_and_read(loaded: &Loaded, format: Format, options: &WriteOptions) {
    let model = Contents {
        mesh: &loaded.mesh,
        attributes: &loaded.attributes,
        document: loaded.document.as_ref(),
    };
    let written = match model_to_bytes(&model, format, options) {
        Ok(written) => written,
        Err(error) => return check_message(&error),
    };
    let single = match format {
        Format::Gltf | Format::Glb | Format::Usda | Format::Usdz => true,
        Format::Stl => !options.ascii || options.precision == Precision::F32,
        Format::Obj | Format::Off | Format::ThreeMf => false,
        _ => options.precision == Precision::F32,
    };
    let back = match read_bytes(&written.bytes, format, &no_side_files) {
        Ok(back) => back,
        // Rounding may leave no face with an area.
        Err(_) if single && !loaded.f32_exact => return,
        Err(error) => panic!("{format} {options:?} that was written cannot be read: {error}"),
    };
    check(&back);
    let at = |mesh: &Mesh, vertex: u32| {
        let position = mesh.positions[vertex as usize];
        if single {
            position.as_vec3().as_dvec3()
        } else {
            position
        }
    };
    let (old, new) = (&loaded.mesh, &back.mesh);
    assert_eq!(new.faces.len(), old.faces.len(), "{format} {options:?}");
    // Zeros without a sign.
    let corners =
        |mesh: &Mesh, face: &[u32; 3]| face.map(|v| at(mesh, v).to_array().map(|x| x + 0.0));
    let ordered = order(loaded, format).into_iter();
    let mut wanted: Vec<[[f64; 3]; 3]> = ordered.map(|f| corners(old, &old.faces[f])).collect();
    let mut read: Vec<[[f64; 3]; 3]> = new.faces.iter().map(|f| corners(new, f)).collect();
    if is_new_scene(loaded, format) {
        // It has a primitive for each material, for patches, and for faces without some attributes.
        let key = |face: &[[f64; 3]; 3]| face.map(|p| p.map(f64::to_bits));
        wanted.sort_by_key(key);
        read.sort_by_key(key);
    }
    for (f, (a, b)) in wanted.iter().zip(&read).enumerate() {
        assert_eq!(
            a, b,
            "{format} {options:?}, face {f} in the order of the file"
        );
    }
    if format != Format::Stl && !has_objects(loaded, format) {
        let count = old.positions.len();
        let same = (0..count as u32).all(|v| at(old, v) == at(new, v));
        assert!(same, "{format} {options:?}: the vertices are not in order");
    }
    let renumbers = matches!(format, Format::Stl | Format::Gltf | Format::Glb);
    if !renumbers && !has_objects(loaded, format) {
        assert_eq!(new.faces, old.faces, "{format} {options:?}");
    }
}

/// Whether the format has objects that the mesh is divided into, each with its own vertices.
fn has_objects(loaded: &Loaded, format: Format) -> bool {
    let holds = matches!(format, Format::ThreeMf | Format::Usda | Format::Usdz);
    holds && loaded.attributes.labels_of(LabelKind::Object).is_some()
}

/// Whether a format is written as a new glTF scene.
fn is_new_scene(loaded: &Loaded, format: Format) -> bool {
    let document = loaded.document.as_ref();
    let images = document.and_then(FileDocument::images_of_faces);
    matches!(format, Format::Gltf | Format::Glb) && images.is_none()
}

/// The order in which the faces are written: 3MF and USD have objects.
fn order(loaded: &Loaded, format: Format) -> Vec<usize> {
    let mut order: Vec<usize> = (0..loaded.mesh.faces.len()).collect();
    if has_objects(loaded, format) {
        // Objects and their parts are in the order of their labels; faces without one come last.
        let labels = [LabelKind::Object, LabelKind::Part];
        let labels = labels.map(|kind| loaded.attributes.labels_of(kind));
        order.sort_by_key(|f| labels.map(|labels| labels.map(|labels| labels.of_face[*f])));
    }
    order
}

/// Reads a volume, writes it, and reads that again.
fn volume(data: &[u8]) {
    let volume = match read_volume_bytes(data, None) {
        Ok(volume) => volume,
        Err(error) => return check_message(&error),
    };
    let Ok(bytes) = volume_to_bytes(&volume, "values", Precision::F64) else {
        return;
    };
    let back = read_volume_bytes(&bytes, Some("values")).expect("it was written");
    let bits = |v: &Volume| v.values.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&back), bits(&volume));
}
