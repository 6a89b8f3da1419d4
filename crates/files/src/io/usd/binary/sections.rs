//! The tables of a binary USD layer: words, strings, fields, sets of fields, paths and specs.

use super::super::super::{IoError, Location};
use super::super::Budget;
use super::{DEEPEST, MAGIC, fault, integers};

/// A path: an element under its parent.
#[derive(Clone, Debug, Default)]
pub(super) struct PathEntry {
    pub(super) parent: Option<usize>,
    /// The word of its last element; `None` for the root.
    pub(super) name: Option<u32>,
    pub(super) is_property: bool,
    /// Whether the table has an entry for this number.
    pub(super) is_there: bool,
}

/// What a layer says of a path.
#[derive(Debug)]
pub(super) struct Spec {
    pub(super) path: usize,
    /// The start of its fields in the sets of fields.
    pub(super) fields: usize,
}

/// All tables.
#[derive(Default)]
pub(super) struct Sections {
    /// Minor version of the format; the major one is 0.
    pub(super) version: u8,
    pub(super) words: Vec<String>,
    /// Words by the numbers of strings.
    pub(super) strings: Vec<u32>,
    /// Name and representation of the value.
    pub(super) fields: Vec<(u32, u64)>,
    pub(super) field_sets: Vec<u32>,
    pub(super) paths: Vec<PathEntry>,
    pub(super) specs: Vec<Spec>,
}

impl Sections {
    /// A word; empty if there is none of that number.
    pub(super) fn word(&self, number: u32) -> &str {
        self.words.get(number as usize).map_or("", |word| word)
    }

    /// The text of a path, for example `/World/Chair.points`.
    pub(super) fn path(&self, number: usize) -> String {
        let mut names = Vec::new();
        let mut at = Some(number);
        while let Some(entry) = at.and_then(|at| self.paths.get(at))
            && names.len() <= DEEPEST
        {
            if let Some(name) = entry.name {
                let name = self.word(name);
                let mark = match (entry.is_property, name.starts_with('{')) {
                    (true, _) => ".",
                    (false, true) => "",
                    (false, false) => "/",
                };
                names.push([mark, name].concat());
            }
            at = entry.parent;
        }
        names.reverse();
        names.concat()
    }
}

/// Reads all tables.
pub(super) fn read(bytes: &[u8], budget: &mut Budget) -> Result<Sections, IoError> {
    let header = Cursor { bytes, at: 8 };
    let [major, minor] = *bytes
        .get(8..)
        .and_then(|b| b.first_chunk::<2>())
        .ok_or_else(|| fault(budget, 8, "the file ends inside its header"))?;
    if !bytes.starts_with(MAGIC) || major != 0 || minor < 4 {
        return Err(IoError::Unsupported {
            format: budget.format,
            what: format!("version {major}.{minor} of the binary format is not read"),
            advice: "save it anew with a current program, or as .usda: 'usdcat IN -o OUT.usda'",
        });
    }
    let mut toc = Cursor {
        bytes,
        at: header.at + 8,
    };
    toc.at = toc.size(budget)?;
    let count = toc.size(budget)?;
    let mut sections = Sections {
        version: minor,
        ..Sections::default()
    };
    let found = places(toc, count, budget)?;
    for (place, cursor) in found.into_iter().enumerate() {
        let Some(mut cursor) = cursor else {
            let what = format!(
                "the section {} is missing",
                String::from_utf8_lossy(NAMES[place])
            );
            return Err(IoError::malformed(budget.format, Location::File, what));
        };
        match place {
            0 => sections.words = words(&mut cursor, budget)?,
            1 => sections.strings = strings(&mut cursor, budget)?,
            2 => sections.fields = fields(&mut cursor, budget)?,
            3 => {
                let count = cursor.size(budget)?;
                let sets = cursor.integers(count, budget)?;
                sections.field_sets = sets.into_iter().map(|set| set as u32).collect();
            }
            4 => sections.paths = paths(&mut cursor, budget)?,
            _ => sections.specs = specs(&mut cursor, budget)?,
        }
    }
    Ok(sections)
}

/// The names of the sections that are needed.
const NAMES: [&[u8]; 6] = [
    b"TOKENS",
    b"STRINGS",
    b"FIELDS",
    b"FIELDSETS",
    b"PATHS",
    b"SPECS",
];

/// The starts of the sections, each with the bytes up to its end, from the table of contents.
fn places<'a>(
    mut toc: Cursor<'a>,
    count: usize,
    budget: &Budget,
) -> Result<[Option<Cursor<'a>>; 6], IoError> {
    let bytes = toc.bytes;
    let mut found = [None; 6];
    for _ in 0..count.min(64) {
        let name = toc.take(16, budget)?;
        let name = name.split(|b| *b == 0).next().unwrap_or_default();
        let (start, size) = (toc.size(budget)?, toc.size(budget)?);
        let end = start.checked_add(size).filter(|end| *end <= bytes.len());
        if let Some(place) = NAMES.iter().position(|known| *known == name) {
            let end = end
                .ok_or_else(|| fault(budget, toc.at, "a section is beyond the end of the file"))?;
            found[place] = Some(Cursor {
                bytes: &bytes[..end],
                at: start,
            });
        }
    }
    Ok(found)
}

/// A place in the file.
#[derive(Clone, Copy)]
pub(super) struct Cursor<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) at: usize,
}

impl<'a> Cursor<'a> {
    pub(super) fn take(&mut self, count: usize, budget: &Budget) -> Result<&'a [u8], IoError> {
        let end = self.at.checked_add(count);
        let taken = end.and_then(|end| self.bytes.get(self.at..end));
        let taken =
            taken.ok_or_else(|| fault(budget, self.at, format!("{count} bytes are missing")))?;
        self.at += count;
        Ok(taken)
    }

    pub(super) fn word(&mut self, budget: &Budget) -> Result<u64, IoError> {
        let bytes = self.take(8, budget)?;
        Ok(bytes
            .first_chunk::<8>()
            .map_or(0, |bytes| u64::from_le_bytes(*bytes)))
    }

    pub(super) fn short(&mut self, budget: &Budget) -> Result<u32, IoError> {
        let bytes = self.take(4, budget)?;
        Ok(bytes
            .first_chunk::<4>()
            .map_or(0, |bytes| u32::from_le_bytes(*bytes)))
    }

    pub(super) fn size(&mut self, budget: &Budget) -> Result<usize, IoError> {
        let at = self.at;
        usize::try_from(self.word(budget)?).map_err(|_| fault(budget, at, "a size is too large"))
    }

    /// Compressed 32-bit integers behind the size of their block.
    pub(super) fn integers(
        &mut self,
        count: usize,
        budget: &mut Budget,
    ) -> Result<Vec<i64>, IoError> {
        self.wide_integers(count, 4, budget)
    }

    /// Compressed integers of 4 or 8 bytes behind the size of their block.
    pub(super) fn wide_integers(
        &mut self,
        count: usize,
        size: usize,
        budget: &mut Budget,
    ) -> Result<Vec<i64>, IoError> {
        let at = self.at;
        let length = self.size(budget)?;
        let packed = self.take(length, budget)?;
        budget.spend(
            count
                .saturating_mul(8)
                .saturating_add(integers::working_size(count, size)),
        )?;
        let decoded = integers::decoded(packed, count, size);
        decoded.ok_or_else(|| {
            fault(
                budget,
                at,
                format!("{count} compressed integers are damaged"),
            )
        })
    }

    /// A compressed block of a known size, behind the size that it has in the file.
    fn block(&mut self, unpacked: usize, budget: &mut Budget) -> Result<Vec<u8>, IoError> {
        let at = self.at;
        let length = self.size(budget)?;
        let packed = self.take(length, budget)?;
        budget.spend(unpacked)?;
        let block = integers::block(packed, unpacked).filter(|block| block.len() == unpacked);
        block.ok_or_else(|| fault(budget, at, "a compressed block is damaged"))
    }
}

fn words(cursor: &mut Cursor<'_>, budget: &mut Budget) -> Result<Vec<String>, IoError> {
    let (count, size) = (cursor.size(budget)?, cursor.size(budget)?);
    let text = cursor.block(size, budget)?;
    budget.spend(count.min(size).saturating_mul(32))?;
    let words = text.split(|b| *b == 0).take(count.min(size));
    Ok(words
        .map(|word| String::from_utf8_lossy(word).into_owned())
        .collect())
}

fn strings(cursor: &mut Cursor<'_>, budget: &Budget) -> Result<Vec<u32>, IoError> {
    let count = cursor.size(budget)?;
    let bytes = cursor.take(count.saturating_mul(4), budget)?;
    Ok(bytes
        .as_chunks()
        .0
        .iter()
        .map(|b| u32::from_le_bytes(*b))
        .collect())
}

fn fields(cursor: &mut Cursor<'_>, budget: &mut Budget) -> Result<Vec<(u32, u64)>, IoError> {
    let count = cursor.size(budget)?;
    let names = cursor.integers(count, budget)?;
    let values = cursor.block(count.saturating_mul(8), budget)?;
    let values = values.as_chunks().0.iter().map(|b| u64::from_le_bytes(*b));
    Ok(names
        .into_iter()
        .map(|name| name as u32)
        .zip(values)
        .collect())
}

fn specs(cursor: &mut Cursor<'_>, budget: &mut Budget) -> Result<Vec<Spec>, IoError> {
    let count = cursor.size(budget)?;
    let paths = cursor.integers(count, budget)?;
    let fields = cursor.integers(count, budget)?;
    let pairs = paths.into_iter().zip(fields);
    // The third list is the type of each, which follows from the path.
    Ok(pairs
        .map(|(path, fields)| Spec {
            path: path as u32 as usize,
            fields: fields as u32 as usize,
        })
        .collect())
}

/// The tree of paths, in the order of a walk through it: for each the number of the path, the word of its element (negative for a
/// property), and where the walk goes on: −2 no child and no sibling, −1 a child next, 0 a sibling next, else a child next and a sibling
/// as many entries ahead.
fn paths(cursor: &mut Cursor<'_>, budget: &mut Budget) -> Result<Vec<PathEntry>, IoError> {
    let (count, encoded) = (cursor.size(budget)?, cursor.size(budget)?);
    let numbers = cursor.integers(encoded, budget)?;
    let names = cursor.integers(encoded, budget)?;
    let jumps = cursor.integers(encoded, budget)?;
    budget.spend(count.saturating_mul(size_of::<PathEntry>() + 64))?;
    let mut paths = vec![PathEntry::default(); count];
    let mut stack: Vec<(usize, Option<usize>)> = if encoded > 0 {
        vec![(0, None)]
    } else {
        Vec::new()
    };
    let damaged = |budget: &Budget| fault(budget, cursor.at, "the tree of paths is damaged");
    while let Some((at, parent)) = stack.pop() {
        let (Some(number), Some(jump)) = (numbers.get(at), jumps.get(at)) else {
            return Err(damaged(budget));
        };
        let number = *number as u32 as usize;
        // Each path is there once, which ends every walk.
        let entry = paths.get_mut(number).filter(|entry| !entry.is_there);
        let Some(entry) = entry else {
            return Err(damaged(budget));
        };
        *entry = PathEntry {
            parent,
            name: parent.map(|_| names[at].unsigned_abs() as u32),
            is_property: names[at] < 0,
            is_there: true,
        };
        if *jump >= 0 {
            let ahead = if *jump == 0 { 1 } else { *jump as usize };
            stack.push((at.saturating_add(ahead), parent));
        }
        if *jump > 0 || *jump == -1 {
            stack.push((at + 1, Some(number)));
        }
    }
    Ok(paths)
}
