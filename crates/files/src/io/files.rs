//! Reading and writing meshes and volumes by path, with the side files that a mesh file names.

use std::fs;
use std::io::Read;
use std::path::{Component, Path};

use super::paths::canonical;
use super::{
    Contents, Format, IoError, Loaded, Precision, Resolve, WriteOptions, model_to_bytes,
    read_bytes, read_volume_bytes, replace_file, volume_to_bytes,
};
use isomend_core::grid::Volume;
use isomend_core::mesh::{Attributes, Mesh};

/// Reads a mesh file. Unless `format` is given, it is detected from the content, or else from the extension.
///
/// # Errors
/// When the file cannot be read, its format is not supported, or its content is damaged or holds no surface. The message
/// begins with the path.
pub fn read_path(path: &Path, format: Option<Format>) -> Result<Loaded, IoError> {
    let bytes = bytes_of(path)?;
    read_as(path, &bytes, format, &beside(path))
}

/// Bytes. Largest stream that is read: 2 GiB, because the length of a stream is not known in advance.
pub const MAX_STREAM_BYTES: u64 = 2 << 30;

/// Reads a stream to its end.
///
/// # Errors
/// When it cannot be read, or is longer than `MAX_STREAM_BYTES`.
#[doc(hidden)]
pub fn read_stream(stream: impl Read) -> std::io::Result<Vec<u8>> {
    within(stream, MAX_STREAM_BYTES)
}

/// Reads a text file or pipe.
///
/// # Errors
/// When it cannot be read, is a device, or is not UTF-8.
pub fn read_text(path: &Path) -> Result<String, IoError> {
    String::from_utf8(bytes_of(path)?).map_err(|error| IoError::Read {
        path: path.to_path_buf(),
        cause: std::io::Error::new(std::io::ErrorKind::InvalidData, error.utf8_error()),
    })
}

/// Reads a stream to its end, or gives an error after `most` bytes.
fn within(stream: impl Read, most: u64) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    stream.take(most + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        let what = format!("it goes on after {most} bytes; save it as a file first");
        return Err(std::io::Error::other(what));
    }
    Ok(bytes)
}

/// Reads the bytes of a file or pipe. Devices are refused, because they may never end.
///
/// # Errors
/// When it cannot be read or is a device.
#[doc(hidden)]
pub fn bytes_of(path: &Path) -> Result<Vec<u8>, IoError> {
    let read = || {
        let file = fs::File::open(path)?;
        let kind = file.metadata()?.file_type();
        if kind.is_file() || kind.is_dir() {
            return fs::read(path);
        }
        if is_device(kind) {
            return Err(std::io::Error::other("it is a device, not a file"));
        }
        read_stream(file)
    };
    read().map_err(|cause| IoError::Read {
        path: path.to_path_buf(),
        cause,
    })
}

#[cfg(unix)]
fn is_device(kind: fs::FileType) -> bool {
    use std::os::unix::fs::FileTypeExt;
    kind.is_char_device() || kind.is_block_device()
}

#[cfg(not(unix))]
fn is_device(_: fs::FileType) -> bool {
    false
}

/// As [`read_path`], from bytes already in memory. `resolve` loads the side files; `path` serves for detection and
/// messages.
///
/// # Errors
/// As [`read_path`].
pub fn read_as(
    path: &Path,
    bytes: &[u8],
    format: Option<Format>,
    resolve: &Resolve<'_>,
) -> Result<Loaded, IoError> {
    let read = || {
        let detected = match format {
            Some(format) => format,
            None => Format::detect(bytes, path)?,
        };
        let mut loaded = read_bytes(bytes, detected, resolve)?;
        if format.is_none() && Format::from_extension(path).is_some_and(|named| named != detected) {
            let extension = path.extension().unwrap_or_default();
            loaded.notes.push(format!(
                "the content is {detected} although the extension is .{}",
                extension.display()
            ));
        }
        Ok(loaded)
    };
    read().map_err(|error: IoError| error.in_file(path))
}

/// A [`Resolve`] that loads side files from the folder of `path`. Names and links that lead outside are refused.
#[doc(hidden)]
pub fn beside(path: &Path) -> impl Fn(&str, u64) -> Result<Vec<u8>, IoError> + '_ {
    move |name, most| side_file(path, name, most)
}

/// Loads at most `most` bytes of a file that `path` names, relative to the folder of `path`. Names and links that lead
/// outside this folder are refused.
fn side_file(path: &Path, name: &str, most: u64) -> Result<Vec<u8>, IoError> {
    let refuse = |what: &str| IoError::Unsupported {
        format: Format::Gltf,
        what: format!("'{name}' {what}"),
        advice: "put the buffer beside the file, or save the mesh as GLB",
    };
    if name.contains("://") || Path::new(name).is_absolute() {
        return Err(refuse("is not beside the file"));
    }
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let unreadable = |cause: std::io::Error| refuse(&format!("cannot be read ({cause})"));
    let folder = canonical(folder).map_err(unreadable)?;
    // Names that lead outside are refused before the file system is asked about them.
    let mut depth = 0i64;
    for part in Path::new(name).components() {
        depth += match part {
            Component::ParentDir => -1,
            Component::Normal(_) => 1,
            _ => 0,
        };
        if depth < 0 || matches!(part, Component::Prefix(_) | Component::RootDir) {
            return Err(refuse("is outside the folder of the file"));
        }
    }
    let beside = canonical(&folder.join(name)).map_err(unreadable)?;
    if !beside.starts_with(&folder) {
        return Err(refuse("is outside the folder of the file"));
    }
    if !fs::metadata(&beside).map_err(unreadable)?.is_file() {
        return Err(refuse("is not a file"));
    }
    let mut bytes = Vec::new();
    fs::File::open(&beside)
        .and_then(|file| file.take(most).read_to_end(&mut bytes))
        .map_err(unreadable)?;
    Ok(bytes)
}

/// Writes a mesh file and returns remarks for the user. Unless `format` is given, the extension decides it.
///
/// The bytes go to a temporary file in the same folder, which then replaces the target, so that a failure leaves the
/// target unchanged.
///
/// # Errors
/// When the format is not supported, cannot hold the mesh, or the file cannot be written.
pub fn write_path(
    path: &Path,
    mesh: &Mesh,
    format: Option<Format>,
    options: &WriteOptions,
) -> Result<Vec<String>, IoError> {
    let attributes = &Attributes::default();
    let model = Contents {
        mesh,
        attributes,
        document: None,
    };
    write_model(path, &model, format, options)
}

/// As [`write_path`], with attributes.
///
/// # Errors
/// As [`write_path`].
pub fn write_model(
    path: &Path,
    model: &Contents<'_>,
    format: Option<Format>,
    options: &WriteOptions,
) -> Result<Vec<String>, IoError> {
    let format = match format.or_else(|| Format::from_extension(path)) {
        Some(format) => format,
        None => {
            let what = "the extension is of no supported format".to_string();
            return Err(IoError::UnknownFormat { what }.in_file(path));
        }
    };
    let written = model_to_bytes(model, format, options).map_err(|error| error.in_file(path))?;
    replace_file(path, &written.bytes).map_err(|cause| IoError::Write {
        path: path.to_path_buf(),
        cause,
    })?;
    Ok(written.notes)
}

/// Reads a volume file; see [`read_volume_bytes`].
///
/// # Errors
/// When the file cannot be read or does not hold the volume. The message begins with the path.
pub fn read_volume_path(path: &Path, array: Option<&str>) -> Result<Volume, IoError> {
    let bytes = bytes_of(path)?;
    read_volume_bytes(&bytes, array).map_err(|error| error.in_file(path))
}

/// Writes a volume as a VTI file; see [`volume_to_bytes`]. A temporary file replaces the target, as in [`write_path`].
///
/// # Errors
/// When the volume cannot be written as VTI or the file cannot be written.
pub fn write_volume_path(
    path: &Path,
    volume: &Volume,
    name: &str,
    precision: Precision,
) -> Result<(), IoError> {
    let bytes = volume_to_bytes(volume, name, precision).map_err(|error| error.in_file(path))?;
    replace_file(path, &bytes).map_err(|cause| IoError::Write {
        path: path.to_path_buf(),
        cause,
    })
}

#[cfg(test)]
mod tests {
    use super::super::samples::open_tetrahedron;
    use super::*;

    #[test]
    #[cfg(unix)]
    fn what_has_no_end_is_refused() {
        for name in ["/dev/zero", "/dev/urandom"] {
            let error = read_path(Path::new(name), None).unwrap_err();
            assert!(error.to_string().contains("device"), "{error}");
        }
        assert_eq!(within(&b"1234"[..], 4).unwrap(), b"1234");
        assert!(within(std::io::repeat(0), 1000).is_err());
    }

    #[test]
    fn every_format_goes_through_a_file() {
        let folder = tempfile::tempdir().unwrap();
        let mesh = open_tetrahedron();
        for format in Format::ALL {
            let path = folder
                .path()
                .join("mesh")
                .with_extension(format.extension());
            for _ in 0..2 {
                write_path(&path, &mesh, None, &WriteOptions::default()).unwrap();
            }
            let loaded = read_path(&path, None).unwrap();
            assert_eq!(loaded.format, format);
            assert_eq!(loaded.mesh.faces.len(), mesh.faces.len());
            assert!(loaded.notes.is_empty(), "{:?}", loaded.notes);
        }
        assert_eq!(
            fs::read_dir(folder.path()).unwrap().count(),
            Format::ALL.len()
        );
    }

    #[test]
    fn a_given_format_overrides_the_name_and_a_wrong_name_is_noted() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mesh.obj");
        write_path(
            &path,
            &open_tetrahedron(),
            Some(Format::Stl),
            &WriteOptions::default(),
        )
        .unwrap();
        let loaded = read_path(&path, None).unwrap();
        assert_eq!(loaded.format, Format::Stl);
        assert!(loaded.notes.iter().any(|note| note.contains(".obj")));
        assert!(
            read_path(&path, Some(Format::Ply))
                .unwrap_err()
                .to_string()
                .contains("mesh.obj: PLY")
        );
    }

    #[test]
    fn paths_that_cannot_be_used_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let mesh = open_tetrahedron();
        let options = WriteOptions::default();
        let message = read_path(&folder.path().join("none.ply"), None)
            .unwrap_err()
            .to_string();
        assert!(message.contains("none.ply"), "{message}");
        let message = write_path(folder.path(), &mesh, Some(Format::Ply), &options)
            .unwrap_err()
            .to_string();
        assert!(message.contains("folder"), "{message}");
        let message = write_path(Path::new("mesh.xyz"), &mesh, None, &options)
            .unwrap_err()
            .to_string();
        assert!(
            message.contains("mesh.xyz") && message.contains(Format::LIST),
            "{message}"
        );
        assert!(write_path(&folder.path().join("no/mesh.ply"), &mesh, None, &options).is_err());
    }

    #[test]
    fn buffers_beside_a_gltf_file_are_found_and_others_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mesh.gltf");
        let text = |name: &str| {
            format!(
                r#"{{"asset":{{"version":"2.0"}},"nodes":[{{"mesh":0}}],"buffers":[{{"byteLength":36,"uri":"{name}"}}],
                "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
                "bufferViews":[{{"buffer":0,"byteLength":36}}],
                "accessors":[{{"bufferView":0,"count":3,"componentType":5126,"type":"VEC3"}}]}}"#
            )
        };
        let points: Vec<u8> = [0f32, 0., 0., 1., 0., 0., 0., 1., 0.]
            .iter()
            .flat_map(|v| v.to_le_bytes())
            .collect();
        fs::write(folder.path().join("my points.bin"), points).unwrap();
        fs::write(&path, text("my%20points.bin")).unwrap();
        assert_eq!(read_path(&path, None).unwrap().mesh.faces, [[0, 1, 2]]);
        for (name, expected) in [
            ("none.bin", "none.bin"),
            (".", "not a file"),
            ("http://a/b", "not beside"),
        ] {
            fs::write(&path, text(name)).unwrap();
            let message = read_path(&path, None).unwrap_err().to_string();
            assert!(
                message.contains(expected) && message.contains("mesh.gltf"),
                "{message}"
            );
        }
    }

    /// A glTF file of one triangle with its points in the named buffer.
    fn gltf(name: &str, length: u64) -> String {
        format!(
            r#"{{"asset":{{"version":"2.0"}},"nodes":[{{"mesh":0}}],"buffers":[{{"byteLength":{length},"uri":"{name}"}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
            "bufferViews":[{{"buffer":0,"byteLength":36}}],
            "accessors":[{{"bufferView":0,"count":3,"componentType":5126,"type":"VEC3"}}]}}"#
        )
    }

    fn points() -> Vec<u8> {
        let points = [0f32, 0., 0., 1., 0., 0., 0., 1., 0.];
        points.iter().flat_map(|v| v.to_le_bytes()).collect()
    }

    #[test]
    fn buffers_outside_the_folder_of_a_gltf_file_are_not_read() {
        let folder = tempfile::tempdir().unwrap();
        let inner = folder.path().join("inner");
        fs::create_dir_all(inner.join("deep")).unwrap();
        fs::write(folder.path().join("out.bin"), points()).unwrap();
        fs::write(inner.join("in.bin"), points()).unwrap();
        let path = inner.join("mesh.gltf");
        let read = |name: &str| {
            fs::write(&path, gltf(name, 36)).unwrap();
            read_path(&path, None)
        };
        for name in ["in.bin", "deep/../in.bin", "./in.bin", "deep/%2e%2e/in.bin"] {
            assert_eq!(read(name).unwrap().mesh.faces.len(), 1, "{name}");
        }
        let absolute = folder.path().join("out.bin").display().to_string();
        let mut refused = vec![
            "../out.bin",
            "%2e%2e/out.bin",
            "..%2Fout.bin",
            "../inner/in.bin",
        ];
        refused.push(&absolute);
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink("../out.bin", inner.join("link.bin")).unwrap();
            std::os::unix::fs::symlink("in.bin", inner.join("near.bin")).unwrap();
            refused.push("link.bin");
            assert!(read("near.bin").is_ok());
        }
        for name in refused {
            let message = read(name).unwrap_err().to_string();
            let expected = ["outside the folder", "not beside"];
            assert!(
                expected.iter().any(|e| message.contains(e)),
                "{name}: {message}"
            );
            assert!(message.contains("mesh.gltf"), "{message}");
        }
    }

    #[test]
    fn no_more_of_a_buffer_is_read_than_it_claims() {
        let folder = tempfile::tempdir().unwrap();
        let beside = folder.path().join("points.bin");
        fs::write(&beside, [points(), vec![7; 1000]].concat()).unwrap();
        let path = folder.path().join("mesh.gltf");
        assert_eq!(side_file(&path, "points.bin", 36).unwrap(), points());
        fs::write(&path, gltf("points.bin", 2000)).unwrap();
        let message = read_path(&path, None).unwrap_err().to_string();
        assert!(
            message.contains("2000") && message.contains("1036"),
            "{message}"
        );
    }
}
