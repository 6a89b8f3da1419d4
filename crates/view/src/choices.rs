//! The user's choices on a mesh of the session: an action for each hole, pairs of crease ends between which sharp edges are continued,
//! the marked faces, and the named masks.

use std::collections::{BTreeMap, HashMap};

use serde::{Deserialize, Serialize};

use super::delta::{KeptNumbers, rim_key};
use super::named::{NamedMasks, Way};
use super::runs::Runs;
use super::state::{Origin, State};
use isomend_core::mesh::{Hole, HoleId};

/// The action for a hole.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum HoleAction {
    /// Fill the hole.
    Fill,
    /// Leave the hole open.
    Open,
    /// Close the hole by a flat cap.
    Flat,
    /// Fill the hole in one region with the other holes of the same bridge number.
    Bridge(u16),
}

impl TryFrom<String> for HoleAction {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        let bridge = text.strip_prefix("bridge ").map(str::parse);
        match (&text[..], bridge) {
            ("fill", _) => Ok(Self::Fill),
            ("open", _) => Ok(Self::Open),
            ("flat", _) => Ok(Self::Flat),
            (_, Some(Ok(number))) => Ok(Self::Bridge(number)),
            _ => Err(format!(
                "'{text}' is no action for a hole; the actions are fill, open, flat and bridge 1, 2, …"
            )),
        }
    }
}

impl From<HoleAction> for String {
    fn from(action: HoleAction) -> Self {
        match action {
            HoleAction::Fill => "fill".to_owned(),
            HoleAction::Open => "open".to_owned(),
            HoleAction::Flat => "flat".to_owned(),
            HoleAction::Bridge(number) => format!("bridge {number}"),
        }
    }
}

impl HoleAction {
    /// The default action for a hole, as on the command line.
    fn default_for(hole: &Hole, state: &State) -> Self {
        match state.stays_open(hole.id) {
            true => Self::Open,
            false => Self::Fill,
        }
    }
}

/// A change of the choices on a mesh, as the page sends it.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Change {
    /// The mesh.
    pub id: u32,
    /// New actions, by the numbers of the holes; the other holes are unchanged.
    #[serde(default)]
    pub holes: BTreeMap<HoleId, HoleAction>,
    /// All pairs of crease ends, by their numbers, between which sharp edges are continued; none for no change.
    #[serde(default)]
    pub creases: Option<Vec<[usize; 2]>>,
    /// All marked faces; none for no change.
    #[serde(default)]
    pub mask: Option<Runs>,
}

/// The choices on a mesh.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Choices {
    /// Rims and the actions for their holes, if not the default ones. A rim is given by its [`rim_key`].
    holes: Vec<(Vec<u32>, HoleAction)>,
    /// Pairs of rim vertices between which sharp edges are continued.
    #[serde(default)]
    creases: Vec<[u32; 2]>,
    /// The marked faces.
    mask: Runs,
    /// The named masks.
    #[serde(default, skip_serializing_if = "NamedMasks::is_empty")]
    pub named: NamedMasks,
}

impl Choices {
    /// The actions for the holes of a mesh that are not the default ones, by the numbers of the holes.
    pub fn actions(&self, state: &State) -> BTreeMap<HoleId, HoleAction> {
        let by_rim: HashMap<_, _> = self.holes.iter().map(|(rim, a)| (rim, *a)).collect();
        let holes = state.holes.iter();
        let chosen = holes.filter_map(|hole| Some((hole.id, *by_rim.get(&rim_key(&hole.rim))?)));
        chosen.collect()
    }

    /// The pairs of crease ends of a mesh, by their numbers, between which sharp edges are continued.
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

    /// Applies a change from the page.
    ///
    /// # Errors
    /// When the mesh has no hole, crease end or face of a given number; the error names the part of the request.
    pub fn change(&mut self, change: &Change, state: &State) -> Result<(), (String, &'static str)> {
        let mask = change.mask.as_ref().filter(|mask| !mask.0.is_empty());
        if let Some(mask) = mask {
            let checked = mask.check(state.loaded.mesh.faces.len());
            checked.map_err(|error| (error, "mask"))?;
        }
        let count = state.holes.len();
        let mut actions = self.actions(state);
        for (&id, &action) in &change.holes {
            if !state.holes.iter().any(|hole| hole.id == id) {
                return Err((
                    format!("there is no hole {id}: the mesh has {count} holes"),
                    "holes",
                ));
            }
            actions.insert(id, action);
        }
        if let Some(pairs) = &change.creases {
            self.creases = vertices_of(pairs, state).map_err(|error| (error, "creases"))?;
        }
        self.set(&actions, state);
        if let Some(mask) = &change.mask {
            self.mask = mask.clone();
        }
        Ok(())
    }

    /// Sets the actions for holes; default actions are not stored.
    fn set(&mut self, actions: &BTreeMap<HoleId, HoleAction>, state: &State) {
        let holes = state.holes.iter();
        let chosen = holes.filter_map(|hole| {
            let action = actions.get(&hole.id).copied()?;
            (action != HoleAction::default_for(hole, state)).then(|| (rim_key(&hole.rim), action))
        });
        self.holes = chosen.collect();
    }

    /// The choices carried over to the mesh that a step made from `old`: for rims, crease ends and faces that still exist. After a step on
    /// marked faces no face is marked: what replaced them becomes the named mask [`LAST_REGION`](super::named::LAST_REGION), unless the mesh keeps its own marks.
    pub fn carried(&self, old: &State, new: &State) -> Self {
        let step = new.step.as_ref().filter(|step| !step.keep_marks);
        let marked = step.and_then(|step| step.mask.as_ref());
        let mask = marked.unwrap_or(&self.mask);
        let KeptNumbers { vertices, faces } =
            KeptNumbers::new(&old.loaded.mesh, &new.loaded.mesh, new.delta.as_ref());
        let renumbered = |rim: &[u32]| {
            let rim = rim.iter().map(|&v| vertices.get(v as usize).copied()?);
            rim.collect::<Option<Vec<u32>>>().map(|rim| rim_key(&rim))
        };
        // Carry the actions of all holes, also the default ones: a hole's default may change, for example when it becomes the outer
        // border of the remaining component.
        let chosen = self.actions(old);
        let action = |hole: &Hole| chosen.get(&hole.id).copied();
        let kept: HashMap<Vec<u32>, HoleAction> = (old.holes.iter())
            .filter_map(|h| {
                let action = action(h).unwrap_or(HoleAction::default_for(h, old));
                Some((renumbered(&h.rim)?, action))
            })
            .collect();
        let holes = new.holes.iter();
        let mut actions: BTreeMap<HoleId, HoleAction> = holes
            .filter_map(|hole| Some((hole.id, *kept.get(&rim_key(&hole.rim))?)))
            .collect();
        // Drop bridges with fewer than two holes.
        let alone = |a: &HoleAction, all: &[HoleAction]| {
            matches!(a, HoleAction::Bridge(_)) && all.iter().filter(|other| *other == a).count() < 2
        };
        let all: Vec<HoleAction> = actions.values().copied().collect();
        actions.retain(|_, action| !alone(action, &all));
        // Carry the marks; the region of a step contains its new faces.
        let way = Way::new(old, new, &faces);
        let (mut marks, _) = way.marks(mask);
        if marked.is_some() {
            for (mark, origin) in marks.iter_mut().zip(&new.origin) {
                *mark |= *origin == Origin::New;
            }
        }
        // Carry the pairs of crease ends that still exist.
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
        carried.set(&actions, new);
        carried.named.add_missing(&self.named, &way);
        let marks = Runs::of_marks(marks);
        match marked {
            None => carried.mask = marks,
            Some(_) => carried
                .named
                .set_last_region(marks, new.loaded.mesh.faces.len()),
        }
        carried
    }

    /// Removes choices on rims, crease ends or faces that the mesh does not have; a file of another version may contain some.
    #[must_use]
    pub fn checked(mut self, state: &State) -> Self {
        let actions = self.actions(state);
        self.set(&actions, state);
        let is_end = |v: &u32| state.crease_ends.iter().any(|end| end.vertex == *v);
        self.creases.retain(|pair| pair.iter().all(is_end));
        let faces = state.loaded.mesh.faces.len();
        if self.mask.check(faces).is_err() {
            self.mask = Runs::default();
        }
        self.named.check(faces);
        self
    }
}

/// The vertices of pairs of crease ends.
fn vertices_of(pairs: &[[usize; 2]], state: &State) -> Result<Vec<[u32; 2]>, String> {
    let count = state.crease_ends.len();
    let vertex = |id: usize| {
        let end = id.checked_sub(1).and_then(|at| state.crease_ends.get(at));
        end.map(|end| end.vertex)
            .ok_or_else(|| format!("there is no crease end {id}: the mesh has {count} crease ends"))
    };
    let pair = |&[a, b]: &[usize; 2]| Ok([vertex(a)?, vertex(b)?]);
    pairs.iter().map(pair).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rim_key_does_not_depend_on_the_first_vertex() {
        assert_eq!(rim_key(&[5, 2, 9]), rim_key(&[9, 5, 2]));
        assert_ne!(rim_key(&[5, 2, 9]), rim_key(&[9, 2, 5]));
        // A rim that passes a vertex twice.
        assert_eq!(rim_key(&[1, 7, 1, 3, 4]), rim_key(&[1, 3, 4, 1, 7]));
        assert!(rim_key(&[]).is_empty());
    }

    #[test]
    fn actions_are_written_as_they_are_read() {
        for text in ["fill", "open", "flat", "bridge 3"] {
            let action = HoleAction::try_from(text.to_owned()).unwrap();
            assert_eq!(String::from(action), text);
        }
        assert!(HoleAction::try_from("bridge x".to_owned()).is_err());
    }
}
