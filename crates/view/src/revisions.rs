//! Differences of documents and lists that a page fetches again and again: members and rows that the page has are not sent.

use std::collections::{BTreeMap, HashMap, VecDeque};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::time::{SystemTime, UNIX_EPOCH};

use serde_json::{Map, Value, json};

/// Number of revisions that are remembered. A page that has an older one gets the whole document.
const REMEMBERED: usize = 16;

/// A row of a list, without its content.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ListRow {
    /// Its number.
    pub id: u32,
    /// A hash of its content, without its number.
    pub hash: u64,
}

/// A list of a document. Each of its rows is an object with its number as `id`.
pub struct List<'a> {
    /// The name of the list.
    pub name: &'static str,
    /// Its rows.
    pub rows: Vec<ListRow>,
    /// Makes the object of the row with the given index.
    pub object: Box<dyn Fn(usize) -> Value + 'a>,
}

/// The last revisions of a document.
pub struct Revisions {
    /// The number of the last revision.
    last: u64,
    remembered: VecDeque<Revision>,
}

/// A revision of a document: the hashes of its members, and its rows.
struct Revision {
    number: u64,
    members: BTreeMap<String, u64>,
    lists: BTreeMap<&'static str, Vec<ListRow>>,
}

/// A part of a list, compared with an older list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ListPart {
    /// Rows of the older list, now numbered from `id`.
    Kept {
        /// Index of the first of them in the older list.
        first: usize,
        /// Index after the last of them.
        end: usize,
        /// The number of the first of them in the newer list.
        id: u32,
    },
    /// A new row: its index in the newer list.
    New(usize),
}

impl Revisions {
    /// No revisions yet. Numbers begin at a time in milliseconds: a page that outlives its program then has no number of the next one.
    pub fn new(begun: SystemTime) -> Self {
        let since = begun.duration_since(UNIX_EPOCH).unwrap_or_default();
        Self {
            last: since.as_millis() as u64,
            remembered: VecDeque::new(),
        }
    }

    /// The document with these members and lists, as it is sent to a page that has the revision `known`.
    ///
    /// It has the number of the revision as `revision`. If the known revision is not remembered any more, the document is whole.
    /// Otherwise it has the number of the known revision as `known`; unchanged members and lists are left out, and in a changed list
    /// `[first, end, id]` stands for the rows `first..end` of the known list, now numbered from `id`.
    pub fn answer(&mut self, known: Option<u64>, members: &Value, lists: &[List]) -> Value {
        let each = || members.as_object().into_iter().flatten();
        let number = self.remember(Revision {
            number: 0,
            members: each()
                .map(|(name, value)| (name.clone(), hash(&value.to_string())))
                .collect(),
            lists: lists.iter().map(|l| (l.name, l.rows.clone())).collect(),
        });
        let find = |wanted| self.remembered.iter().find(|r| Some(r.number) == wanted);
        let (old, now) = (find(known), find(Some(number)));
        let hash_in = |r: Option<&Revision>, name: &str| r?.members.get(name).copied();
        let mut answer: Map<String, Value> = each()
            .filter(|(name, _)| hash_in(old, name) != hash_in(now, name))
            .map(|(name, value)| (name.clone(), value.clone()))
            .collect();
        for list in lists {
            let before = old.and_then(|old| old.lists.get(list.name));
            if before != Some(&list.rows) {
                let rows = list.since(before.map_or(&[], Vec::as_slice));
                answer.insert(list.name.to_owned(), rows);
            }
        }
        answer.insert("revision".to_owned(), json!(number));
        if let Some(old) = old {
            answer.insert("known".to_owned(), json!(old.number));
        }
        Value::Object(answer)
    }

    /// Remembers a revision, unless the last one is the same; returns its number.
    fn remember(&mut self, revision: Revision) -> u64 {
        let is_same = |r: &Revision| r.members == revision.members && r.lists == revision.lists;
        if !self.remembered.back().is_some_and(is_same) {
            self.last += 1;
            let number = self.last;
            self.remembered.push_back(Revision { number, ..revision });
        }
        if self.remembered.len() > REMEMBERED {
            self.remembered.pop_front();
        }
        self.last
    }
}

impl List<'_> {
    /// The list, as it is sent to a page that has these rows.
    fn since(&self, old: &[ListRow]) -> Value {
        let sent = |part| match part {
            ListPart::Kept { first, end, id } => json!([first, end, id]),
            ListPart::New(index) => (self.object)(index),
        };
        parts(old, &self.rows).into_iter().map(sent).collect()
    }
}

/// The parts of a list, compared with an older list. Rows with the same content are the same, also if their numbers differ.
pub fn parts(old: &[ListRow], new: &[ListRow]) -> Vec<ListPart> {
    let mut places: HashMap<u64, usize> = HashMap::new();
    for (place, row) in old.iter().enumerate() {
        places.entry(row.hash).or_insert(place);
    }
    let mut parts: Vec<ListPart> = Vec::new();
    for (index, row) in new.iter().enumerate() {
        // The next row of the older list continues the last part, if the numbers are consecutive.
        if let Some(ListPart::Kept { first, end, id }) = parts.last_mut()
            && old.get(*end).is_some_and(|next| next.hash == row.hash)
            && *id + (*end - *first) as u32 == row.id
        {
            *end += 1;
            continue;
        }
        parts.push(match places.get(&row.hash) {
            Some(&first) => ListPart::Kept {
                first,
                end: first + 1,
                id: row.id,
            },
            None => ListPart::New(index),
        });
    }
    parts
}

/// A hash for comparison within one run of the program.
pub fn hash(content: &(impl Hash + ?Sized)) -> u64 {
    let mut hasher = DefaultHasher::new();
    content.hash(&mut hasher);
    hasher.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(id: u32, hash: u64) -> ListRow {
        ListRow { id, hash }
    }

    fn document(
        revisions: &mut Revisions,
        known: Option<u64>,
        busy: bool,
        rows: &[ListRow],
    ) -> Value {
        let list = List {
            name: "rows",
            rows: rows.to_vec(),
            object: Box::new(|i| json!({ "id": rows[i].id, "is": rows[i].hash })),
        };
        revisions.answer(known, &json!({ "busy": busy, "name": "ball" }), &[list])
    }

    #[test]
    fn rows_that_move_are_kept_with_their_new_numbers() {
        let old = [row(1, 10), row(2, 20), row(3, 30), row(4, 40)];
        let new = [row(1, 10), row(2, 30), row(3, 40), row(4, 50), row(6, 20)];
        let kept = |first, end, id| ListPart::Kept { first, end, id };
        let wanted = [
            kept(0, 1, 1),
            kept(2, 4, 2),
            ListPart::New(3),
            kept(1, 2, 6),
        ];
        assert_eq!(parts(&old, &new), wanted);
        assert_eq!(parts(&old, &old), [kept(0, 4, 1)]);
        assert_eq!(parts(&[], &new[..1]), [ListPart::New(0)]);
        assert_eq!(parts(&old, &[]), []);
    }

    #[test]
    fn only_changes_since_the_known_revision_are_sent() {
        let revisions = &mut Revisions::new(UNIX_EPOCH);
        let rows = [row(1, 10), row(2, 20)];
        let whole = document(revisions, None, false, &rows);
        let objects = json!([{ "id": 1, "is": 10 }, { "id": 2, "is": 20 }]);
        let wanted = json!({ "revision": 1, "busy": false, "name": "ball", "rows": objects });
        assert_eq!(whole, wanted);
        let same = document(revisions, Some(1), false, &rows);
        assert_eq!(same, json!({ "revision": 1, "known": 1 }));
        let other = document(revisions, Some(1), true, &[row(1, 20)]);
        let wanted = json!({ "revision": 2, "known": 1, "busy": true, "rows": [[1, 2, 1]] });
        assert_eq!(other, wanted);
        // A second page may be at another revision, and gets the changes since then.
        let second = document(revisions, Some(1), true, &[row(1, 20)]);
        assert_eq!(second, other);
    }

    #[test]
    fn a_revision_that_is_forgotten_or_of_the_future_gives_the_whole_document() {
        let revisions = &mut Revisions::new(UNIX_EPOCH);
        let whole = document(revisions, None, false, &[]);
        assert_eq!(document(revisions, Some(2), false, &[]), whole);
        for i in 0..REMEMBERED as u64 {
            document(revisions, None, false, &[row(1, i)]);
        }
        let late = document(revisions, Some(1), false, &[]);
        assert_eq!(late["known"], Value::Null);
        assert_eq!(late["name"], "ball");
    }
}
