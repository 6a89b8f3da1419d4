//! Lists of paths, references and payloads of the binary USD format, and the chosen variants.

use std::collections::BTreeMap;

use super::super::super::IoError;
use super::super::layer::{Arc, ArcKind, ArcList, ListOp};
use super::sections::Cursor;
use super::values::{
    PATH_LIST, PATHS, PAYLOAD, PAYLOAD_LIST, REFERENCE_LIST, SELECTION, Values, kind,
};

/// The lists in the order in which they are stored: the bit of the header that tells of each, and what its items do. The last one is an
/// order, which is not used.
const LISTS: [(u8, Option<ListOp>); 6] = [
    (2, Some(ListOp::Explicit)),
    (4, Some(ListOp::Append)),
    (32, Some(ListOp::Prepend)),
    (64, Some(ListOp::Append)),
    (8, Some(ListOp::Delete)),
    (16, None),
];
/// The bit of a header of lists that take the place of the lists of weaker layers, even if they are empty.
const EXPLICIT: u8 = 1;

impl Values<'_, '_> {
    /// The references of a prim to others: lists of references, payloads or paths.
    pub(super) fn arcs(&mut self, value: u64, of: ArcKind) -> Result<Vec<ArcList>, IoError> {
        let mut cursor = self.cursor(value);
        let made = |(op, items)| ArcList {
            kind: of,
            op,
            items,
        };
        match kind(value) {
            PAYLOAD => {
                let payload = self.arc(&mut cursor, PAYLOAD)?;
                Ok(vec![made((ListOp::Explicit, vec![payload]))])
            }
            kind @ (REFERENCE_LIST | PAYLOAD_LIST | PATH_LIST) => {
                let lists = self.lists(&mut cursor, |values, cursor| values.arc(cursor, kind))?;
                Ok(lists.into_iter().map(made).collect())
            }
            _ => Ok(Vec::new()),
        }
    }

    /// The used lists at a place.
    fn lists<T>(
        &mut self,
        cursor: &mut Cursor<'_>,
        mut item: impl FnMut(&mut Self, &mut Cursor<'_>) -> Result<T, IoError>,
    ) -> Result<Vec<(ListOp, Vec<T>)>, IoError> {
        let header = cursor.take(1, self.budget)?[0];
        let mut all = Vec::new();
        if header & EXPLICIT != 0 {
            all.push((ListOp::Explicit, Vec::new()));
        }
        for (bit, op) in LISTS {
            if header & bit == 0 {
                continue;
            }
            let mut items = Vec::new();
            for _ in 0..cursor.size(self.budget)? {
                let item = item(self, cursor)?;
                self.budget.spend(size_of::<T>())?;
                items.push(item);
            }
            all.extend(op.map(|op| (op, items)));
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
            PATH_LIST => {
                let lists = self.lists(&mut cursor, Self::path)?;
                let used = lists.into_iter().filter(|(op, _)| *op != ListOp::Delete);
                Ok(used.flat_map(|(_, items)| items).collect())
            }
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
