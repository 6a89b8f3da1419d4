//! Reads the MTL material files that an OBJ file names: colour, opacity, diffuse texture, roughness and metallic
//! factor.
//!
//! Lines are checked before `tobj` parses them: it panics at a colour of fewer than three numbers, abandons a whole
//! file for one bad line, and stores every line that it does not know. No fault makes the OBJ file unreadable; a remark
//! names what is missing.

#[cfg(test)]
mod tests;

use std::collections::{HashMap, HashSet};

use super::super::{IoError, Resolve, text};
use super::Lines;
use isomend_core::mesh::attributes::Material;

/// Bytes. Largest material file that is read. Exporters write about 200 bytes per material.
const MOST_BYTES: u64 = 16 << 20;
/// Most material files that are read; the materials of others are known by name only.
const MOST_FILES: usize = 64;
/// Most materials that are read; each takes about 500 bytes while its file is read.
const MOST_MATERIALS: usize = 1 << 16;
/// Most textures that are named in the remarks.
const MOST_REMARKS: usize = 5;
/// Bytes of an image that suffice to recognise PNG and JPEG, the two kinds that glTF allows.
const IMAGE_HEAD: u64 = 8;

/// The materials with the given names, in the order of the names. If a material is described several times, the first
/// description applies. Remarks name what is missing.
pub(super) fn read(
    libraries: &[String],
    names: &[String],
    resolve: &Resolve<'_>,
    notes: &mut Vec<String>,
) -> Vec<Material> {
    let wanted: HashSet<&str> = names.iter().map(|n| n.trim()).collect();
    if wanted.is_empty() {
        return Vec::new();
    }
    let mut found: HashMap<String, Material> = HashMap::new();
    let mut files = Files::new(resolve);
    let mut remarks = Vec::new();
    for library in libraries {
        for (name, content) in files.of(library, notes) {
            let is_wanted = |n: &str| wanted.contains(n) && !found.contains_key(n);
            let (clean, bad) = cleaned(&content, is_wanted, MOST_MATERIALS - found.len());
            if bad > 0 {
                let name = text::shown(name.as_bytes());
                notes.push(format!(
                    "lines of the material file {name} that cannot be read: {bad}"
                ));
            }
            let mut reader = Reader {
                folder: folder(&name),
                resolve,
                remarks: &mut remarks,
                images: HashMap::new(),
            };
            let materials = tobj::load_mtl_buf(&mut clean.as_bytes()).map_or(Vec::new(), |m| m.0);
            for material in materials {
                let material = reader.material(material);
                found.entry(material.name.clone()).or_insert(material);
            }
        }
    }
    let more = remarks.len().saturating_sub(MOST_REMARKS);
    notes.extend(remarks.into_iter().take(MOST_REMARKS));
    if more > 0 {
        notes.push(format!("more textures left out: {more}"));
    }
    let mut seen = HashSet::new();
    let names = names.iter().map(|n| n.trim()).filter(|n| seen.insert(*n));
    names.filter_map(|name| found.remove(name)).collect()
}

/// The material files of an OBJ file; each is loaded only once.
struct Files<'a> {
    resolve: &'a Resolve<'a>,
    asked: HashSet<String>,
}

impl<'a> Files<'a> {
    fn new(resolve: &'a Resolve<'a>) -> Self {
        Self {
            resolve,
            asked: HashSet::new(),
        }
    }

    /// The files that an `mtllib` line names, with their contents. The line is one name, which may contain blanks, or
    /// several names.
    fn of(&mut self, library: &str, notes: &mut Vec<String>) -> Vec<(String, Vec<u8>)> {
        let why = match self.load(library) {
            Ok(file) => return file.into_iter().collect(),
            Err(why) => why,
        };
        let mut refuse = |name: &str, why: String| {
            notes.push(format!(
                "the material file {} {why}: its materials are known by name only",
                text::shown(name.as_bytes())
            ));
        };
        let words: Vec<&str> = library.split_whitespace().collect();
        if words.len() < 2 {
            refuse(library, why);
            return Vec::new();
        }
        let mut found = Vec::new();
        for word in words {
            match self.load(word) {
                Ok(file) => found.extend(file),
                Err(why) => refuse(word, why),
            }
        }
        found
    }

    /// Loads a file; `None` if it was loaded before or the limit of files is reached. The error is the end of a
    /// sentence that begins with the name.
    fn load(&mut self, name: &str) -> Result<Option<(String, Vec<u8>)>, String> {
        let name = name.replace('\\', "/");
        if self.asked.len() >= MOST_FILES || !self.asked.insert(name.clone()) {
            return Ok(None);
        }
        let bytes = (self.resolve)(&name, MOST_BYTES + 1).map_err(|error| reason(&error))?;
        if bytes.len() as u64 > MOST_BYTES {
            return Err(format!("is larger than {} MB", MOST_BYTES >> 20));
        }
        Ok(Some((name, bytes)))
    }
}

/// Why a file cannot be loaded, as the end of a sentence that begins with its name.
fn reason(error: &IoError) -> String {
    match error {
        IoError::Unsupported { what, .. } => {
            let name_ends = what.rfind("' ").map_or(0, |at| at + 2);
            what[name_ends..].to_owned()
        }
        error => format!("cannot be read ({error})"),
    }
}

/// The folder of a material file, relative to the OBJ file.
fn folder(name: &str) -> &str {
    name.rfind('/').map_or("", |slash| &name[..slash + 1])
}

/// The well-formed statements of wanted materials, spelled as `tobj` expects, and the number of malformed lines. Holds
/// at most `room` materials.
fn cleaned(content: &[u8], wanted: impl Fn(&str) -> bool, room: usize) -> (String, usize) {
    let decoded = text::decode(content);
    let (mut clean, mut bad, mut count, mut inside) = (String::new(), 0, 0, false);
    let mut lines = Lines::new(&decoded);
    while let Some((_, line)) = lines.next_line() {
        let line = String::from_utf8_lossy(&line);
        let line = line.trim();
        let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let rest = rest.trim();
        let is_number = |token: &str| token.parse::<f32>().is_ok_and(f32::is_finite);
        let numbers = rest.split_whitespace().take_while(|t| is_number(t)).count();
        let (word, needed) = match word.to_ascii_lowercase().as_str() {
            "newmtl" => {
                inside = wanted(rest) && count < room;
                count += usize::from(inside);
                ("newmtl", 0)
            }
            "kd" => ("Kd", 3),
            "ns" => ("Ns", 1),
            "d" => ("d", 1),
            "tr" => ("Tr", 1),
            "pr" => ("Pr", 1),
            "pm" => ("Pm", 1),
            "map_kd" => ("map_Kd", 0),
            _ => continue,
        };
        if rest.is_empty() || numbers < needed {
            bad += 1;
        } else if inside {
            clean.extend([word, " ", rest, "\n"]);
        }
    }
    (clean, bad)
}

/// Converts the materials of one file.
struct Reader<'a> {
    folder: &'a str,
    resolve: &'a Resolve<'a>,
    /// Remarks on textures that cannot be used.
    remarks: &'a mut Vec<String>,
    /// For each image that was checked, whether it can be used.
    images: HashMap<String, bool>,
}

impl Reader<'_> {
    fn material(&mut self, from: tobj::Material) -> Material {
        let number = |key: &str| {
            let value: f32 = from
                .unknown_param
                .get(key)?
                .split_whitespace()
                .next()?
                .parse()
                .ok()?;
            Some(value.clamp(0.0, 1.0))
        };
        let texture = from
            .diffuse_texture
            .as_deref()
            .and_then(|t| self.texture(&from.name, t));
        let opacity = from.dissolve.or_else(|| number("Tr").map(|t| 1.0 - t));
        // Exporters write black beside a texture, although it would multiply the texture, and an opacity of 0 where
        // they mean 1.
        let is_black = from.diffuse == Some([0.0; 3]) && texture.is_some();
        Material {
            colour: from
                .diffuse
                .filter(|_| !is_black)
                .map(|c| c.map(|v| v.clamp(0.0, 1.0))),
            opacity: opacity.map(|d| d.clamp(0.0, 1.0)).filter(|d| *d > 0.0),
            texture,
            roughness: number("Pr").or_else(|| from.shininess.map(roughness)),
            metallic: number("Pm"),
            name: from.name,
        }
    }

    /// The path of an image relative to the OBJ file, if the image exists and is PNG or JPEG.
    fn texture(&mut self, material: &str, statement: &str) -> Option<String> {
        let name = without_options(statement).replace('\\', "/");
        let path = normalised(&format!("{}{name}", self.folder));
        let refuse = |why: &str| {
            format!(
                "the texture {} of the material {} is left out: it {why}",
                text::shown(name.as_bytes()),
                text::shown(material.as_bytes())
            )
        };
        let Some(path) = path.filter(|_| !name.starts_with('/')) else {
            self.remarks
                .push(refuse("is outside the folder of the file"));
            return None;
        };
        if let Some(usable) = self.images.get(&path) {
            return usable.then_some(path);
        }
        let why = match (self.resolve)(&path, IMAGE_HEAD) {
            Ok(head) if is_image(&head) => None,
            Ok(_) => Some("is neither PNG nor JPEG".to_owned()),
            Err(error) => Some(reason(&error)),
        };
        self.images.insert(path.clone(), why.is_none());
        match why {
            None => Some(path),
            Some(why) => {
                self.remarks.push(refuse(&why));
                None
            }
        }
    }
}

fn is_image(head: &[u8]) -> bool {
    head.starts_with(b"\x89PNG\r\n\x1a\n") || head.starts_with(&[0xff, 0xd8, 0xff])
}

/// The roughness whose microfacet highlight is as wide as the highlight of a specular exponent n: α² = 2 / (n + 2), where α is
/// the square of the roughness (Karis, "Specular BRDF reference", 2013).
fn roughness(exponent: f32) -> f32 {
    (2.0 / (exponent.max(0.0) + 2.0)).powf(0.25)
}

/// The file name of a texture statement, after options such as `-s 1 1 1`.
fn without_options(statement: &str) -> &str {
    let mut rest = statement.trim();
    while rest.starts_with('-') {
        let (option, behind) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
        let (least, most) = match option.to_ascii_lowercase().as_str() {
            "-o" | "-s" | "-t" => (1, 3),
            "-mm" => (2, 2),
            "-blendu" | "-blendv" | "-boost" | "-bm" | "-cc" | "-clamp" | "-colorspace"
            | "-imfchan" | "-texres" | "-type" => (1, 1),
            _ => return rest,
        };
        rest = behind.trim_start();
        for argument in 0..most {
            let (value, behind) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
            if argument >= least && value.parse::<f64>().is_err() {
                break;
            }
            rest = behind.trim_start();
        }
    }
    rest
}

/// A relative path without `.` and `..`; `None` if it leads out of the folder or is empty.
fn normalised(path: &str) -> Option<String> {
    let mut parts: Vec<&str> = Vec::new();
    for part in path.split('/') {
        match part {
            "" | "." => {}
            ".." => _ = parts.pop()?,
            part => parts.push(part),
        }
    }
    (!parts.is_empty()).then(|| parts.join("/"))
}
