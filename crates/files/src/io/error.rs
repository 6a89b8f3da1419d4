//! Errors of reading and writing mesh files.

use std::fmt::{self, Write};
use std::path::{Path, PathBuf};

use super::Format;

/// Where in a file something was found.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Location {
    /// The file as a whole.
    File,
    /// A line of a text file, counted from 1.
    Line(usize),
    /// A byte offset from the start of the file.
    Byte(usize),
    /// An item of a kind, such as a vertex or a face, counted from 0.
    Item(&'static str, usize),
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Location::File => Ok(()),
            Location::Line(line) => write!(f, ", line {line}"),
            Location::Byte(offset) => write!(f, ", byte {offset}"),
            Location::Item(kind, index) => write!(f, ", {kind} {index}"),
        }
    }
}

/// A message, part of which may come from a file: non-printable characters are escaped and the length is limited.
struct Printable<'a>(&'a str);

impl fmt::Display for Printable<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Characters.
        const LONGEST: usize = 400;
        for (i, c) in self.0.chars().enumerate() {
            match c {
                _ if i == LONGEST => return f.write_char('…'),
                c if c.is_control() => write!(f, "{}", c.escape_default())?,
                c => f.write_char(c)?,
            }
        }
        Ok(())
    }
}

/// Why a mesh file could not be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IoError {
    /// The operating system refused to read a file.
    #[error("cannot read {}: {cause}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's error.
        cause: std::io::Error,
    },
    /// The operating system refused to write a file.
    #[error("cannot write {}: {cause}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's error.
        cause: std::io::Error,
    },
    /// An error in a file that is known by its path.
    #[error("{}: {error}", path.display())]
    InFile {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        error: Box<IoError>,
    },
    /// The format is not known or not supported.
    #[error("{}; supported are {}", Printable(what), Format::LIST)]
    UnknownFormat {
        /// What the file or name is instead.
        what: String,
    },
    /// The file is well formed but uses a feature that is not supported.
    #[error("{format}: {}; {advice}", Printable(what))]
    Unsupported {
        /// The format of the file.
        format: Format,
        /// What is not supported, by name.
        what: String,
        /// What to do about it.
        advice: &'static str,
    },
    /// The file breaks the rules of its format.
    #[error("{format}{place}: {}; {advice}", Printable(what))]
    Malformed {
        /// The format of the file.
        format: Format,
        /// Where the fault is.
        place: Location,
        /// What is wrong.
        what: String,
        /// What to do about it.
        advice: &'static str,
    },
    /// The file holds no faces.
    #[error("{format}: {}", no_faces(*points, *omitted))]
    NoFaces {
        /// The format of the file.
        format: Format,
        /// How many points there are.
        points: usize,
        /// How many faces of one or two corners were left out.
        omitted: usize,
    },
    /// All faces are degenerate.
    #[error(
        "{format}: all {faces} faces are degenerate (they repeat a corner or have no area); check the export settings \
         of the program that wrote the file"
    )]
    AllDegenerate {
        /// The format of the file.
        format: Format,
        /// How many faces there are.
        faces: usize,
    },
    /// The mesh cannot be expressed in the format.
    #[error("{format}: {}; {advice}", Printable(what))]
    NotWritable {
        /// The format to be written.
        format: Format,
        /// What cannot be expressed.
        what: String,
        /// What to do about it.
        advice: &'static str,
    },
}

const DAMAGED: &str = "the file looks damaged or cut short, so export or copy it again";

fn no_faces(points: usize, omitted: usize) -> String {
    if omitted > 0 {
        return format!(
            "the file has no faces of three or more corners, only {omitted} of one or two; check the export settings of the program \
             that wrote the file"
        );
    }
    match points {
        0 => "the file has no faces and no points; export the mesh again".to_owned(),
        _ => format!(
            "the file has no faces, only {points} points; isomend needs a surface, so triangulate the points first"
        ),
    }
}

impl IoError {
    pub(super) fn malformed(format: Format, place: Location, what: impl Into<String>) -> Self {
        IoError::Malformed {
            format,
            place,
            what: what.into(),
            advice: DAMAGED,
        }
    }

    /// Replaces the advice at the end of a message.
    pub(super) fn advise(mut self, text: &'static str) -> Self {
        if let IoError::Malformed { advice, .. } | IoError::Unsupported { advice, .. } = &mut self {
            *advice = text;
        }
        self
    }

    /// Sets the format in the message, for formats that share a reader.
    pub(super) fn of_format(mut self, other: Format) -> Self {
        if let IoError::Malformed { format, .. } | IoError::Unsupported { format, .. } = &mut self {
            *format = other;
        }
        self
    }

    /// Adds the path of the file to the message.
    pub(crate) fn in_file(self, path: &Path) -> Self {
        match self {
            IoError::Read { .. } | IoError::Write { .. } | IoError::InFile { .. } => self,
            error => IoError::InFile {
                path: path.to_path_buf(),
                error: Box::new(error),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::samples::refusal;
    use super::*;

    #[test]
    fn points_are_to_be_triangulated_only_where_there_are_some() {
        let message = refusal(b"solid a\nendsolid a\n", Format::Stl);
        assert!(message.contains("no faces and no points"), "{message}");
        let message = refusal(b"OFF\n2 0 0\n0 0 0\n1 0 0\n", Format::Off);
        assert!(message.contains("only 2 points"), "{message}");
    }

    #[test]
    fn words_of_a_file_are_cut_and_made_printable() {
        let kind = format!("A\u{1b}[31m{}", "X".repeat(5000));
        let vtk = format!("# vtk DataFile Version 3.0\n\nASCII\nDATASET {kind}\n");
        let vtp = format!("<VTKFile type=\"{kind}\"></VTKFile>");
        for (file, format) in [(vtk, Format::Vtk), (vtp, Format::Vtp)] {
            let message = refusal(file.as_bytes(), format);
            assert!(message.contains("XXX…"), "{message}");
            assert!(message.len() < 1000 && !message.contains('\u{1b}'));
        }
    }
}
