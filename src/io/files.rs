//! Meshes from and to paths.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use super::{
    Format, IoError, Loaded, Model, Precision, WriteOptions, model_to_bytes, read_bytes,
    read_volume_bytes, volume_to_bytes,
};
use crate::grid::Volume;
use crate::mesh::{Attributes, Mesh};

/// Reads a mesh file. The format is told from the content, else from the extension, unless it is given.
///
/// # Errors
/// When the file cannot be read, its format is not supported, or its content is damaged or holds no surface. The message
/// begins with the path.
pub fn read_path(path: &Path, format: Option<Format>) -> Result<Loaded, IoError> {
    let bytes = fs::read(path).map_err(|cause| IoError::Read {
        path: path.to_path_buf(),
        cause,
    })?;
    let read = || {
        let told = match format {
            Some(format) => format,
            None => Format::detect(&bytes, path)?,
        };
        let mut loaded = read_bytes(&bytes, told, &|name| side_file(path, name))?;
        if format.is_none() && Format::from_extension(path).is_some_and(|named| named != told) {
            let extension = path.extension().unwrap_or_default();
            loaded.notes.push(format!(
                "the content is {told} in spite of the extension .{}",
                extension.display()
            ));
        }
        Ok(loaded)
    };
    read().map_err(|error: IoError| error.in_file(path))
}

/// Loads a file named inside another one, relative to the other's folder.
fn side_file(path: &Path, name: &str) -> Result<Vec<u8>, IoError> {
    let refuse = |what: String| IoError::Unsupported {
        format: Format::Gltf,
        what,
        advice: "put the buffer beside the file, or save the mesh as GLB",
    };
    if name.contains("://") || Path::new(name).is_absolute() {
        return Err(refuse(format!(
            "the buffer '{name}' is not beside the file"
        )));
    }
    let beside = path.parent().unwrap_or(Path::new("")).join(name);
    match fs::metadata(&beside) {
        Ok(about) if about.is_file() => fs::read(&beside).map_err(|cause| IoError::Read {
            path: beside,
            cause,
        }),
        Ok(_) => Err(refuse(format!("the buffer '{name}' is not a file"))),
        Err(cause) => Err(refuse(format!(
            "the buffer '{name}' cannot be read ({cause})"
        ))),
    }
}

/// Writes a mesh file and returns remarks for the user. The format is that of the extension unless it is given.
///
/// The file is written beside its target and then moved over it, so that a failure leaves the target as it was.
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
    let model = Model {
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
    model: &Model<'_>,
    format: Option<Format>,
    options: &WriteOptions,
) -> Result<Vec<String>, IoError> {
    let format = match format.or_else(|| Format::from_extension(path)) {
        Some(format) => format,
        None => {
            let what = "the extension does not tell a supported format to write".to_string();
            return Err(IoError::UnknownFormat { what }.in_file(path));
        }
    };
    let written = model_to_bytes(model, format, options).map_err(|error| error.in_file(path))?;
    save(path, &written.bytes).map_err(|cause| IoError::Write {
        path: path.to_path_buf(),
        cause,
    })?;
    Ok(written.notes)
}

/// Reads a volume file; see [`read_volume_bytes`].
///
/// # Errors
/// When the file cannot be read or holds no such volume. The message begins with the path.
pub fn read_volume_path(path: &Path, array: Option<&str>) -> Result<Volume, IoError> {
    let bytes = fs::read(path).map_err(|cause| IoError::Read {
        path: path.to_path_buf(),
        cause,
    })?;
    read_volume_bytes(&bytes, array).map_err(|error| error.in_file(path))
}

/// Writes a volume as a VTI file; see [`volume_to_bytes`]. The file is written beside its target and then moved over it.
///
/// # Errors
/// When the volume cannot be expressed or the file cannot be written.
pub fn write_volume_path(
    path: &Path,
    volume: &Volume,
    name: &str,
    precision: Precision,
) -> Result<(), IoError> {
    let bytes = volume_to_bytes(volume, name, precision).map_err(|error| error.in_file(path))?;
    save(path, &bytes).map_err(|cause| IoError::Write {
        path: path.to_path_buf(),
        cause,
    })
}

/// Writes bytes to a file beside the target and moves it over the target, so that a failure leaves the target as it was.
///
/// # Errors
/// When the target is a folder or may not be changed, or the file cannot be written.
pub fn save(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let old = match fs::metadata(path) {
        Ok(old) if old.is_dir() => {
            return Err(std::io::Error::other("it is a folder: name a file in it"));
        }
        Ok(old) if !old.is_file() => {
            return fs::OpenOptions::new()
                .write(true)
                .open(path)?
                .write_all(bytes);
        }
        Ok(old) if old.permissions().readonly() => {
            return Err(std::io::Error::other(
                "the file is there and may not be changed",
            ));
        }
        Ok(old) => Some(old),
        Err(_) => None,
    };
    let target = if old.is_some() {
        fs::canonicalize(path)?
    } else {
        path.to_path_buf()
    };
    let folder = match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_path_buf(),
        _ => PathBuf::from("."),
    };
    let create = |name: &Path| {
        fs::OpenOptions::new()
            .write(true)
            .create_new(true)
            .open(name)
    };
    let mut file = tempfile::Builder::new()
        .prefix(".isomend-")
        .suffix(".part")
        .make_in(folder, create)?;
    file.write_all(bytes)?;
    if let Some(old) = old {
        fs::set_permissions(file.path(), old.permissions())?;
    }
    file.persist(&target).map_err(|failed| failed.error)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::samples::open_tetrahedron;
    use super::*;

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
        let message = write_path(Path::new("mesh.off"), &mesh, None, &options)
            .unwrap_err()
            .to_string();
        assert!(
            message.contains("mesh.off") && message.contains(Format::LIST),
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

    #[cfg(unix)]
    #[test]
    fn permissions_of_the_target_are_kept_and_links_followed() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (path, link) = (
            folder.path().join("mesh.ply"),
            folder.path().join("link.ply"),
        );
        fs::write(&path, b"old").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
        std::os::unix::fs::symlink(&path, &link).unwrap();
        write_path(&link, &open_tetrahedron(), None, &WriteOptions::default()).unwrap();
        assert_eq!(
            fs::metadata(&path).unwrap().permissions().mode() & 0o777,
            0o640
        );
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert!(read_path(&path, None).is_ok());
        let fresh = folder.path().join("fresh.ply");
        write_path(&fresh, &open_tetrahedron(), None, &WriteOptions::default()).unwrap();
        let plain = folder.path().join("plain");
        fs::write(&plain, b"").unwrap();
        assert_eq!(
            fs::metadata(&fresh).unwrap().permissions(),
            fs::metadata(&plain).unwrap().permissions()
        );
    }
}
