//! Names of the objects, parts and materials of a 3MF build.

use std::collections::{BTreeMap, BTreeSet};

use isomend_core::mesh::attributes::{LabelKind, Labels};

/// Labels, and the index of each name.
pub(super) struct Names {
    pub(super) labels: Labels,
    places: BTreeMap<String, u32>,
}

impl Names {
    pub(super) fn new(kind: LabelKind) -> Self {
        Self {
            labels: Labels::new(kind),
            places: BTreeMap::new(),
        }
    }

    /// The index of a name, and whether the name is new.
    pub(super) fn place(&mut self, name: &str) -> (u32, bool) {
        if let Some(place) = self.places.get(name) {
            return (*place, false);
        }
        let place = self.labels.names.len() as u32;
        self.labels.names.push(name.to_owned());
        self.places.insert(name.to_owned(), place);
        (place, true)
    }
}

/// Names that occur once each.
#[derive(Default)]
pub(super) struct UniqueNames {
    pub(super) taken: BTreeSet<String>,
    /// The last number appended to each name that occurs several times.
    counts: BTreeMap<String, usize>,
    /// Number of names to which a number was appended.
    pub(super) numbered: usize,
}

impl UniqueNames {
    /// The name, with a number appended if it is taken.
    pub(super) fn own(&mut self, name: String) -> String {
        if self.taken.insert(name.clone()) {
            return name;
        }
        self.numbered += 1;
        let count = self.counts.entry(name.clone()).or_insert(1);
        loop {
            *count += 1;
            let numbered = format!("{name}_{count}");
            if self.taken.insert(numbered.clone()) {
                return numbered;
            }
        }
    }
}
