//! What is chosen on a mesh of the session: what to do with each hole, between which crease ends sharp edges are continued, and which
//! faces are marked.

use std::collections::{BTreeMap, HashMap};

use serde::{Deserialize, Serialize};

use super::delta::{Numbers, rim_key};
use super::runs::Runs;
use super::state::{Origin, State};
use crate::mesh::{Hole, HoleId};

/// What is to be done with a hole.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Doing {
    /// It is filled.
    Fill,
    /// It stays open.
    Open,
    /// It gets a flat cap.
    Flat,
    /// It is filled in one region with the others of the same number.
    Bridge(u16),
}

impl TryFrom<String> for Doing {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        let bridge = text.strip_prefix("bridge ").map(str::parse);
        match (&text[..], bridge) {
            ("fill", _) => Ok(Self::Fill),
            ("open", _) => Ok(Self::Open),
            ("flat", _) => Ok(Self::Flat),
            (_, Some(Ok(number))) => Ok(Self::Bridge(number)),
            _ => Err(format!(
                "'{text}' cannot be done with a hole; fill, open, flat and bridge 1, 2, … can"
            )),
        }
    }
}

impl From<Doing> for String {
    fn from(doing: Doing) -> Self {
        match doing {
            Doing::Fill => "fill".to_owned(),
            Doing::Open => "open".to_owned(),
            Doing::Flat => "flat".to_owned(),
            Doing::Bridge(number) => format!("bridge {number}"),
        }
    }
}

impl Doing {
    /// What is done with a hole of which nothing was said: as the command line does.
    fn usual(hole: &Hole) -> Self {
        match hole.outer_border {
            true => Self::Open,
            false => Self::Fill,
        }
    }
}

/// A change of the choices on a mesh, as the page tells it.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Change {
    /// The mesh.
    pub id: u32,
    /// What is to be done with holes, by their numbers; the others stay as they are.
    #[serde(default)]
    pub holes: BTreeMap<HoleId, Doing>,
    /// All pairs of crease ends, by their numbers, between which sharp edges are continued, where those are others now.
    #[serde(default)]
    pub creases: Option<Vec<[usize; 2]>>,
    /// The marked faces, where those are others now.
    #[serde(default)]
    pub mask: Option<Runs>,
}

/// The choices on a mesh.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Choices {
    /// Rims and what is to be done with their holes, where that is not the usual. A rim is the numbers of its vertices in order.
    holes: Vec<(Vec<u32>, Doing)>,
    /// Pairs of vertices of rims between which sharp edges are continued.
    #[serde(default)]
    creases: Vec<[u32; 2]>,
    /// The marked faces.
    mask: Runs,
}

impl Choices {
    /// What is to be done with the holes of a mesh of which it is not the usual, by their numbers.
    pub fn doings(&self, state: &State) -> BTreeMap<HoleId, Doing> {
        let by_rim: HashMap<_, _> = self.holes.iter().map(|(rim, d)| (rim, *d)).collect();
        let holes = state.holes.iter();
        let chosen = holes.filter_map(|hole| Some((hole.id, *by_rim.get(&rim_key(&hole.rim))?)));
        chosen.collect()
    }

    /// Pairs of crease ends of a mesh, by their numbers, between which sharp edges are continued.
    pub fn creases(&self, state: &State) -> Vec<[usize; 2]> {
        let number = |v: u32| {
            let mut ends = state.crease_ends.iter();
            ends.find(|end| end.vertex == v).map(|end| end.id)
        };
        let pair = |&[a, b]: &[u32; 2]| number(a).zip(number(b)).map(|(a, b)| [a, b]);
        self.creases.iter().filter_map(pair).collect()
    }

    /// The marked faces.
    pub fn mask(&self) -> &Runs {
        &self.mask
    }

    /// Takes what the page tells.
    ///
    /// # Errors
    /// When the mesh has no such hole or face, and where in the request that stands. Nothing is changed then.
    pub fn change(&mut self, change: &Change, state: &State) -> Result<(), (String, &'static str)> {
        let mask = change.mask.as_ref().filter(|mask| !mask.0.is_empty());
        if let Some(mask) = mask {
            let checked = mask.check(state.loaded.mesh.faces.len());
            checked.map_err(|error| (error, "mask"))?;
        }
        let count = state.holes.len();
        let mut doings = self.doings(state);
        for (&id, &doing) in &change.holes {
            if !state.holes.iter().any(|hole| hole.id == id) {
                return Err((
                    format!("there is no hole {id}: the mesh has {count}"),
                    "holes",
                ));
            }
            doings.insert(id, doing);
        }
        if let Some(pairs) = &change.creases {
            self.creases = vertices_of(pairs, state).map_err(|error| (error, "creases"))?;
        }
        self.set(&doings, state);
        if let Some(mask) = &change.mask {
            self.mask = mask.clone();
        }
        Ok(())
    }

    /// Takes what is to be done with holes, and drops what is the usual.
    fn set(&mut self, doings: &BTreeMap<HoleId, Doing>, state: &State) {
        let holes = state.holes.iter();
        let chosen = holes.filter_map(|hole| {
            let doing = doings.get(&hole.id).copied()?;
            (doing != Doing::usual(hole)).then(|| (rim_key(&hole.rim), doing))
        });
        self.holes = chosen.collect();
    }

    /// The same for the mesh that a step made of `old`: for the rims that are still there, and the faces that are. What a step
    /// put in the place of marked faces is marked too.
    pub fn carried(&self, old: &State, new: &State) -> Self {
        let step = new.step.as_ref();
        let marked = step.and_then(|step| step.mask.as_ref());
        let mask = marked.unwrap_or(&self.mask);
        let Numbers { vertices, faces } =
            Numbers::new(&old.loaded.mesh, &new.loaded.mesh, new.delta.as_ref());
        let renumbered = |rim: &[u32]| {
            let rim = rim.iter().map(|&v| vertices.get(v as usize).copied()?);
            rim.collect::<Option<Vec<u32>>>().map(|rim| rim_key(&rim))
        };
        // Of all holes: what is the usual may be another after the step, as when a hole becomes the border of what is left.
        let chosen = self.doings(old);
        let doing = |hole: &Hole| chosen.get(&hole.id).copied();
        let kept: HashMap<Vec<u32>, Doing> = (old.holes.iter())
            .filter_map(|h| Some((renumbered(&h.rim)?, doing(h).unwrap_or(Doing::usual(h)))))
            .collect();
        let holes = new.holes.iter();
        let mut doings: BTreeMap<HoleId, Doing> = holes
            .filter_map(|hole| Some((hole.id, *kept.get(&rim_key(&hole.rim))?)))
            .collect();
        // A bridge needs two.
        let alone = |d: &Doing, all: &[Doing]| {
            matches!(d, Doing::Bridge(_)) && all.iter().filter(|other| *other == d).count() < 2
        };
        let all: Vec<Doing> = doings.values().copied().collect();
        doings.retain(|_, doing| !alone(doing, &all));
        let mut marks = vec![false; new.loaded.mesh.faces.len()];
        for face in mask.numbers() {
            if let Some(&Some(face)) = faces.get(face) {
                marks[face as usize] = true;
            }
        }
        if marked.is_some() {
            for (mark, origin) in marks.iter_mut().zip(&new.origin) {
                *mark |= *origin == Origin::New;
            }
        }
        let is_end = |v: &u32| new.crease_ends.iter().any(|end| end.vertex == *v);
        let renumbered_end = |v: u32| {
            let now = vertices.get(v as usize).copied().flatten();
            now.filter(is_end)
        };
        let creases = self.creases.iter();
        let mut carried = Self {
            creases: creases
                .filter_map(|&[a, b]| Some([renumbered_end(a)?, renumbered_end(b)?]))
                .collect(),
            ..Self::default()
        };
        carried.set(&doings, new);
        carried.mask = Runs::of_marks(marks);
        carried
    }

    /// The same without what a mesh does not have, as when it was written by another version.
    #[must_use]
    pub fn checked(mut self, state: &State) -> Self {
        let doings = self.doings(state);
        self.set(&doings, state);
        let is_end = |v: &u32| state.crease_ends.iter().any(|end| end.vertex == *v);
        self.creases.retain(|pair| pair.iter().all(is_end));
        if self.mask.check(state.loaded.mesh.faces.len()).is_err() {
            self.mask = Runs::default();
        }
        self
    }
}

/// The vertices of pairs of crease ends.
fn vertices_of(pairs: &[[usize; 2]], state: &State) -> Result<Vec<[u32; 2]>, String> {
    let count = state.crease_ends.len();
    let vertex = |id: usize| {
        let end = id.checked_sub(1).and_then(|at| state.crease_ends.get(at));
        end.map(|end| end.vertex)
            .ok_or_else(|| format!("there is no crease end {id}: the mesh has {count}"))
    };
    let pair = |&[a, b]: &[usize; 2]| Ok([vertex(a)?, vertex(b)?]);
    pairs.iter().map(pair).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rim_is_the_same_from_whichever_vertex() {
        assert_eq!(rim_key(&[5, 2, 9]), rim_key(&[9, 5, 2]));
        assert_ne!(rim_key(&[5, 2, 9]), rim_key(&[9, 2, 5]));
        // A rim that passes a vertex twice.
        assert_eq!(rim_key(&[1, 7, 1, 3, 4]), rim_key(&[1, 3, 4, 1, 7]));
        assert!(rim_key(&[]).is_empty());
    }

    #[test]
    fn doings_are_written_as_they_are_read() {
        for text in ["fill", "open", "flat", "bridge 3"] {
            let doing = Doing::try_from(text.to_owned()).unwrap();
            assert_eq!(String::from(doing), text);
        }
        assert!(Doing::try_from("bridge x".to_owned()).is_err());
    }
}
