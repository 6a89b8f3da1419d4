//! Masks that the user stores under a name. They belong to the session: each mesh of the history has its own faces of each mask, carried
//! over from the mesh before or after the step.

use serde::{Deserialize, Serialize};

use super::delta::KeptNumbers;
use super::runs::Runs;
use super::state::State;

/// Upper bound of the number of named masks.
const MAX_MASKS: usize = 100;
/// Upper bound of the length of a name, in characters.
const LONGEST_NAME: usize = 60;

/// The name of the mask of the faces that the last step on marked faces made.
pub const LAST_REGION: &str = "last region";

/// A mask under a name, on one mesh.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NamedMask {
    /// The name.
    pub name: String,
    /// The faces.
    pub faces: Runs,
    /// Number of its faces that this mesh does not have any more.
    #[serde(default)]
    pub gone: usize,
}

/// The named masks of one mesh, in the order in which they were stored.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct NamedMasks(Vec<NamedMask>);

impl NamedMasks {
    /// The masks.
    pub fn iter(&self) -> impl Iterator<Item = &NamedMask> {
        self.0.iter()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The mask of a name.
    pub fn find(&self, name: &str) -> Option<&NamedMask> {
        self.0.iter().find(|mask| mask.name == name)
    }

    /// Stores a mask of a mesh with `faces` faces; it replaces the mask of the same name.
    ///
    /// # Errors
    /// When the name or the faces are invalid, or there are too many masks; the error names the part of the request.
    pub fn keep(&mut self, mask: NamedMask, faces: usize) -> Result<(), (String, &'static str)> {
        let length = mask.name.chars().count();
        let is_right = (1..=LONGEST_NAME).contains(&length)
            && !mask.name.chars().any(char::is_control)
            && mask.name.trim() == mask.name;
        if !is_right {
            let error = format!("the name of a mask has 1 to {LONGEST_NAME} printable characters");
            return Err((error, "name"));
        }
        mask.faces.check(faces).map_err(|error| (error, "mask"))?;
        if let Some(old) = self.0.iter_mut().find(|old| old.name == mask.name) {
            *old = mask;
        } else if self.0.len() < MAX_MASKS {
            self.0.push(mask);
        } else {
            let error = format!("there are {MAX_MASKS} named masks; remove one first");
            return Err((error, "name"));
        }
        Ok(())
    }

    /// Stores the region of the last step, of a mesh with `faces` faces, in place of the one before; an empty region is not stored.
    pub fn set_last_region(&mut self, runs: Runs, faces: usize) {
        self.remove(LAST_REGION);
        let region = NamedMask {
            name: LAST_REGION.to_owned(),
            faces: runs,
            gone: 0,
        };
        // If there are too many masks, the region is not stored: nothing depends on it.
        let _ = self.keep(region, faces);
    }

    /// Removes the mask of a name; false if there is none.
    pub fn remove(&mut self, name: &str) -> bool {
        let count = self.0.len();
        self.0.retain(|mask| mask.name != name);
        self.0.len() < count
    }

    /// Adds those masks of another mesh whose names this mesh does not have.
    pub fn add_missing(&mut self, other: &Self, way: &Way) {
        let missing = other.iter().filter(|mask| self.find(&mask.name).is_none());
        let missing = missing.map(|mask| way.carried(mask));
        // The region of a step does not exist before the step.
        let exists = |mask: &NamedMask| mask.name != LAST_REGION || !mask.faces.0.is_empty();
        let missing: Vec<NamedMask> = missing.filter(exists).collect();
        self.0.extend(missing);
    }

    /// Whether another mesh has masks whose names this mesh does not have.
    pub fn lacks_any(&self, other: &Self) -> bool {
        other.iter().any(|mask| self.find(&mask.name).is_none())
    }

    /// Keeps only masks whose faces a mesh with `faces` faces has.
    pub fn check(&mut self, faces: usize) {
        let fits = |runs: &Runs| runs.0.is_empty() || runs.check(faces).is_ok();
        self.0.retain(|mask| fits(&mask.faces));
    }
}

/// The way of faces between a mesh and the mesh that a step made from it, in either direction.
pub struct Way {
    /// Number of faces of the mesh from which, and to which the way leads.
    sizes: [usize; 2],
    /// Pairs of equal or replaced faces of both meshes.
    pairs: Vec<[u32; 2]>,
    /// Whether all faces that the step removed are replaced by new faces.
    is_whole: bool,
}

impl Way {
    /// The way from `old` to `new`, the mesh that a step made from it; `numbers` are the new numbers of the old faces.
    pub fn new(old: &State, new: &State, numbers: &[Option<u32>]) -> Self {
        let kept = (0..).zip(numbers);
        let mut pairs: Vec<[u32; 2]> = kept.filter_map(|(old, new)| Some([old, (*new)?])).collect();
        pairs.extend_from_slice(&new.replaced);
        Self {
            sizes: [old, new].map(|state| state.loaded.mesh.faces.len()),
            pairs,
            is_whole: !new.replaced.is_empty(),
        }
    }

    /// The way between two meshes, one of which was made from the other; none if that is not so.
    pub fn between(from: &State, to: &State) -> Option<Self> {
        let is_parent = |a: &State, b: &State| b.parent.as_ref().is_some_and(|p| p.id == a.id);
        let numbered = |old: &State, new: &State| {
            let (before, after) = (&old.loaded.mesh, &new.loaded.mesh);
            let numbers = KeptNumbers::new(before, after, new.delta.as_ref());
            Self::new(old, new, &numbers.faces)
        };
        match (is_parent(from, to), is_parent(to, from)) {
            (true, _) => Some(numbered(from, to)),
            (_, true) => Some(numbered(to, from).back()),
            _ => None,
        }
    }

    /// The way back.
    fn back(mut self) -> Self {
        self.sizes.reverse();
        self.pairs.iter_mut().for_each(|pair| pair.reverse());
        self
    }

    /// For each face at the end of the way, whether it is or replaces a face of `mask`; and the number of faces of `mask` that are gone.
    pub fn marks(&self, mask: &Runs) -> (Vec<bool>, usize) {
        let [mut before, mut after] = self.sizes.map(|size| vec![false; size]);
        for face in mask.numbers().filter(|face| *face < self.sizes[0]) {
            before[face] = true;
        }
        let mut is_found = vec![false; self.sizes[0]];
        for &[from, to] in &self.pairs {
            after[to as usize] |= before[from as usize];
            is_found[from as usize] = true;
        }
        let faces = before.iter().zip(is_found);
        let gone = faces.filter(|(marked, found)| **marked && !found).count();
        (after, if self.is_whole { 0 } else { gone })
    }

    fn carried(&self, mask: &NamedMask) -> NamedMask {
        let (marks, gone) = self.marks(&mask.faces);
        NamedMask {
            name: mask.name.clone(),
            faces: Runs::of_marks(marks),
            gone: mask.gone + gone,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(name: &str, faces: &[[u32; 2]]) -> NamedMask {
        NamedMask {
            name: name.to_owned(),
            faces: Runs(faces.to_vec()),
            gone: 0,
        }
    }

    #[test]
    fn masks_are_carried_both_ways() {
        // Faces 0 and 1 are kept, face 2 is replaced by faces 2 and 3.
        let way = Way {
            sizes: [3, 4],
            pairs: vec![[0, 0], [1, 1], [2, 2], [2, 3]],
            is_whole: true,
        };
        let mut masks = NamedMasks::default();
        masks.keep(named("a", &[[1, 3]]), 3).unwrap();
        let mut after = NamedMasks::default();
        after.add_missing(&masks, &way);
        assert_eq!(after.find("a"), Some(&named("a", &[[1, 4]])));
        let mut before = NamedMasks::default();
        before.add_missing(&after, &way.back());
        assert_eq!(before, masks);
    }

    #[test]
    fn faces_that_are_gone_are_counted() {
        let way = Way {
            sizes: [4, 2],
            pairs: vec![[0, 0], [3, 1]],
            is_whole: false,
        };
        let (marks, gone) = way.marks(&Runs(vec![[1, 4]]));
        assert_eq!((marks, gone), (vec![false, true], 2));
    }

    #[test]
    fn wrong_names_and_faces_are_refused() {
        let mut masks = NamedMasks::default();
        for name in ["", " a", "a\nb", &"a".repeat(61)] {
            assert_eq!(masks.keep(named(name, &[[0, 1]]), 3).unwrap_err().1, "name");
        }
        assert_eq!(masks.keep(named("a", &[[0, 4]]), 3).unwrap_err().1, "mask");
        assert!(masks.is_empty());
        masks.keep(named("a", &[[0, 1]]), 3).unwrap();
        masks.keep(named("a", &[[1, 2]]), 3).unwrap();
        assert_eq!(masks.iter().count(), 1);
        assert!(masks.remove("a") && !masks.remove("a"));
    }
}
