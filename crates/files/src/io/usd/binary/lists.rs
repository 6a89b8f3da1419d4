//! Lists of paths, references and payloads of the binary USD format, and the chosen variants.

use std::collections::BTreeMap;

use super::super::super::IoError;
use super::super::layer::Arc;
use super::sections::Cursor;
use super::values::{
    PATH_LIST, PATHS, PAYLOAD, PAYLOAD_LIST, REFERENCE_LIST, SELECTION, Values, kind,
};

/// The lists in the order in which they are stored: the bit of the header that tells of each, and whether its items are used.
const LISTS: [(u8, bool); 6] = [
    (2, true),
    (4, true),
    (32, true),
    (64, true),
    (8, false),
    (16, false),
];

impl Values<'_, '_> {
    /// The references of a prim to others: lists of references, payloads or paths.
    pub(super) fn arcs(&mut self, value: u64) -> Result<Vec<Arc>, IoError> {
        let mut cursor = self.cursor(value);
        match kind(value) {
            PAYLOAD => Ok(vec![self.arc(&mut cursor, PAYLOAD)?]),
            kind @ (REFERENCE_LIST | PAYLOAD_LIST | PATH_LIST) => {
                self.list(&mut cursor, |values, cursor| values.arc(cursor, kind))
            }
            _ => Ok(Vec::new()),
        }
    }

    /// The used items of the lists at a place.
    fn list<T>(
        &mut self,
        cursor: &mut Cursor<'_>,
        mut item: impl FnMut(&mut Self, &mut Cursor<'_>) -> Result<T, IoError>,
    ) -> Result<Vec<T>, IoError> {
        let header = cursor.take(1, self.budget)?[0];
        let mut all = Vec::new();
        for (bit, is_used) in LISTS {
            if header & bit == 0 {
                continue;
            }
            for _ in 0..cursor.size(self.budget)? {
                let item = item(self, cursor)?;
                self.budget.spend(size_of::<T>())?;
                all.extend(is_used.then_some(item));
            }
        }
        Ok(all)
    }

    /// A reference, a payload, or a path of this layer.
    fn arc(&mut self, cursor: &mut Cursor<'_>, kind: u8) -> Result<Arc, IoError> {
        if kind == PATH_LIST {
            let path = self.path(cursor)?;
            return Ok(Arc {
                asset: String::new(),
                path,
            });
        }
        let asset = cursor.short(self.budget)?;
        let arc = Arc {
            asset: self.string(asset),
            path: self.path(cursor)?,
        };
        self.budget.spend(arc.asset.len())?;
        // An offset and a factor of time.
        if kind == REFERENCE_LIST || self.sections.version >= 8 {
            cursor.take(16, self.budget)?;
        }
        if kind == REFERENCE_LIST {
            // A dictionary: names, and values behind offsets.
            for _ in 0..cursor.size(self.budget)? {
                cursor.short(self.budget)?;
                let before = cursor.at;
                self.jump(cursor)?;
                cursor.word(self.budget)?;
                if cursor.at <= before {
                    return Err(super::fault(
                        self.budget,
                        before,
                        "a dictionary leads backwards",
                    ));
                }
            }
        }
        Ok(arc)
    }

    fn path(&mut self, cursor: &mut Cursor<'_>) -> Result<String, IoError> {
        let path = cursor.short(self.budget)?;
        let path = self.sections.path(path as usize);
        self.budget.spend(size_of::<String>() + path.len())?;
        Ok(path)
    }

    /// The paths of a list.
    pub(super) fn paths(&mut self, value: u64) -> Result<Vec<String>, IoError> {
        let mut cursor = self.cursor(value);
        match kind(value) {
            PATH_LIST => self.list(&mut cursor, Self::path),
            PATHS => {
                let count = cursor.size(self.budget)?;
                (0..count).map(|_| self.path(&mut cursor)).collect()
            }
            _ => Ok(Vec::new()),
        }
    }

    /// The chosen variant of each set.
    pub(super) fn selection(&mut self, value: u64) -> Result<BTreeMap<String, String>, IoError> {
        let mut chosen = BTreeMap::new();
        if kind(value) != SELECTION {
            return Ok(chosen);
        }
        let mut cursor = self.cursor(value);
        for _ in 0..cursor.size(self.budget)? {
            let (set, name) = (cursor.short(self.budget)?, cursor.short(self.budget)?);
            let (set, name) = (self.string(set), self.string(name));
            self.budget.spend(64 + set.len() + name.len())?;
            chosen.insert(set, name);
        }
        Ok(chosen)
    }
}
