//! Where the layers of a USD stage are, and stacks of them: a layer with its sublayers.

use std::rc::Rc;

use super::layer::PrimSpec;

/// Where a layer is: a file named relative to the main file, or a file of a package.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Place {
    /// The file of the package; an empty name for the main file.
    pub(super) package: Option<String>,
    pub(super) name: String,
}

/// A layer.
pub(super) struct LayerFile {
    pub(super) place: Place,
    pub(super) root: Rc<PrimSpec>,
}

/// A layer and its sublayers, the strongest first.
pub(super) struct Stack {
    pub(super) layers: Vec<Rc<LayerFile>>,
}

impl Place {
    /// The place of a file that a layer at this place refers to. The name is empty for the first layer of a package.
    pub(super) fn joined(&self, asset: &str) -> Self {
        let name = joined(&self.name, asset);
        if self.package.is_some() {
            let package = self.package.clone();
            return Self { package, name };
        }
        let inner = asset.strip_suffix(']').and_then(|a| a.split_once('['));
        let is_package = |name: &str| {
            let extension = name.rsplit_once('.').map(|(_, extension)| extension);
            extension.is_some_and(|e| e.eq_ignore_ascii_case("usdz"))
        };
        match inner {
            Some((package, inner)) => Self {
                package: Some(joined(&self.name, package)),
                name: joined("", inner),
            },
            None if is_package(asset) => Self {
                package: Some(name),
                name: String::new(),
            },
            None => Self {
                package: None,
                name,
            },
        }
    }
}

/// The name of a file that a layer refers to, relative to the main file.
fn joined(from: &str, asset: &str) -> String {
    let folder = from.rsplit_once('/').map_or("", |(folder, _)| folder);
    let mut parts: Vec<&str> = folder.split('/').filter(|part| !part.is_empty()).collect();
    if asset.starts_with('/') {
        return asset.to_owned();
    }
    for part in asset.split('/') {
        match part {
            "" | "." => {}
            ".." if parts.last().is_some_and(|part| *part != "..") => _ = parts.pop(),
            part => parts.push(part),
        }
    }
    parts.join("/")
}
