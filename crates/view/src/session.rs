//! A session: the history of meshes with undo and redo, previews, the running job, and the user's choices on each mesh.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

use super::choices::{Change, Choices};
use super::named::{NamedMask, Way};
use super::state::State;
use super::store::{Snapshot, StoredStep};
use isomend_core::cancel::Cancel;
use isomend_files::job::Deliverables;

/// Upper bound of the number of previews; the oldest is dropped.
const PREVIEWS: usize = 4;

/// All meshes of a session, and the running job.
pub struct Session {
    states: BTreeMap<u32, Arc<State>>,
    /// The numbers of the meshes of the history, from the input on.
    line: Vec<u32>,
    /// Index of the current mesh in `line`.
    at: usize,
    /// The numbers of the previews, the oldest first.
    previews: Vec<u32>,
    next_state: u32,
    next_job: u64,
    /// The running job.
    pub busy: Option<Busy>,
    /// The mesh that was saved last; at first the input.
    saved: u32,
    /// For each saved mesh the last file.
    outputs: BTreeMap<u32, SavedAs>,
    /// The choices on each mesh.
    choices: BTreeMap<u32, Choices>,
    /// Number of changes of choices: until now, and until the last save.
    chosen: [u64; 2],
}

/// A running job.
pub struct Busy {
    /// Its number.
    pub job: u64,
    /// The name of the command.
    pub kind: &'static str,
    /// Time of its start.
    pub since: SystemTime,
    /// Cancels it.
    pub cancel: Cancel,
}

/// The file of a mesh that was saved, and what was handed over with it.
#[derive(Clone, Debug)]
pub struct SavedAs {
    /// The file of the mesh.
    pub path: PathBuf,
    /// Whether it is text.
    pub ascii: bool,
    /// The deliverables that were written with it.
    pub deliverables: Deliverables,
    /// Whether all of them were written, and all patches are within the tolerance.
    pub delivered: bool,
}

impl Session {
    /// A session that starts with a mesh.
    pub fn new(first: State) -> Self {
        Self {
            states: BTreeMap::from([(0, Arc::new(first))]),
            line: vec![0],
            at: 0,
            previews: Vec::new(),
            next_state: 1,
            next_job: 1,
            busy: None,
            saved: 0,
            outputs: BTreeMap::new(),
            choices: BTreeMap::new(),
            chosen: [0, 0],
        }
    }

    /// The current mesh.
    pub fn current(&self) -> &Arc<State> {
        &self.states[&self.line[self.at]]
    }

    /// The mesh with the given number.
    pub fn state(&self, id: u32) -> Option<&Arc<State>> {
        self.states.get(&id)
    }

    /// The meshes of the history, from the input on.
    pub fn line(&self) -> impl Iterator<Item = &Arc<State>> {
        self.line.iter().map(|id| &self.states[id])
    }

    /// The previews, the oldest first.
    pub fn previews(&self) -> impl Iterator<Item = &Arc<State>> {
        self.previews.iter().map(|id| &self.states[id])
    }

    /// Whether there are steps to undo and to redo.
    pub fn can_undo_redo(&self) -> [bool; 2] {
        [self.at > 0, self.at + 1 < self.line.len()]
    }

    /// Starts a job; none if one is running.
    pub fn begin(&mut self, kind: &'static str) -> Option<(u64, Cancel)> {
        if self.busy.is_some() {
            return None;
        }
        let (job, cancel) = (self.next_job, Cancel::new());
        self.next_job += 1;
        self.busy = Some(Busy {
            job,
            kind,
            since: SystemTime::now(),
            cancel: cancel.clone(),
        });
        Some((job, cancel))
    }

    /// Undoes or, if `forward` is set, redoes one step; false if there is none.
    pub fn go(&mut self, forward: bool) -> bool {
        let [can_undo, can_redo] = self.can_undo_redo();
        let place = match forward {
            true if can_redo => self.at + 1,
            false if can_undo => self.at - 1,
            _ => return false,
        };
        self.move_to(place);
        true
    }

    /// Makes a mesh of the history the current one; false if it is not in the history.
    pub fn go_to(&mut self, id: u32) -> bool {
        let place = self.line.iter().position(|i| *i == id);
        self.move_to(place.unwrap_or(self.at));
        place.is_some()
    }

    /// Makes the mesh at an index of the history the current one. Named masks that a mesh on the way lacks are carried to it.
    fn move_to(&mut self, place: usize) {
        while self.at != place {
            let from = self.line[self.at];
            self.at = match self.at < place {
                true => self.at + 1,
                false => self.at - 1,
            };
            let to = self.line[self.at];
            let named = self.choices(from).named;
            if self.choices(to).named.lacks_any(&named)
                && let Some(way) = Way::between(&self.states[&from], &self.states[&to])
            {
                let choices = self.choices.entry(to).or_default();
                choices.named.add_missing(&named, &way);
                self.chosen[0] += 1;
            }
        }
    }

    /// Adds a mesh that was made from the current one, as a preview or as the next mesh of the history. The latter replaces undone steps.
    pub fn add(&mut self, mut state: State, preview: bool) -> u32 {
        let id = self.next_state;
        self.next_state += 1;
        state.id = id;
        self.states.insert(id, Arc::new(state));
        self.carry(id);
        if preview {
            self.previews.push(id);
            if self.previews.len() > PREVIEWS {
                let oldest = self.previews.remove(0);
                self.forget(oldest);
            }
        } else {
            self.append(id);
        }
        id
    }

    /// Makes a preview the next mesh of the history.
    ///
    /// # Errors
    /// When there is no preview of this number, or it was made from another mesh than the current one.
    pub fn adopt(&mut self, id: u32) -> Result<(), &'static str> {
        let place = self.previews.iter().position(|i| *i == id);
        let place = place.ok_or("there is no preview with this number")?;
        let parent = self.states[&id].parent.as_ref().map(|p| p.id);
        if parent != Some(self.current().id) {
            return Err(
                "the preview was made from another mesh than the current one; make it again",
            );
        }
        self.previews.remove(place);
        // Carry the choices once more, since they may have changed after the preview was made.
        self.carry(id);
        self.append(id);
        Ok(())
    }

    /// Deletes a preview; false if there is none of this number.
    pub fn discard(&mut self, id: u32) -> bool {
        let place = self.previews.iter().position(|i| *i == id);
        if let Some(place) = place {
            self.previews.remove(place);
            self.forget(id);
        }
        place.is_some()
    }

    /// Appends a mesh to the history after the current one, and deletes the undone ones.
    fn append(&mut self, id: u32) {
        for gone in self.line.split_off(self.at + 1) {
            self.forget(gone);
        }
        self.line.push(id);
        self.at = self.line.len() - 1;
    }

    /// Deletes a mesh and the choices on it.
    fn forget(&mut self, id: u32) {
        self.states.remove(&id);
        self.choices.remove(&id);
    }

    /// Carries the choices on a mesh's parent over to the mesh.
    fn carry(&mut self, id: u32) {
        let state = &self.states[&id];
        if let Some(parent) = &state.parent {
            let carried = self.choices(parent.id).carried(parent, state);
            self.choices.insert(id, carried);
        }
    }

    /// The choices on a mesh.
    pub fn choices(&self, id: u32) -> Choices {
        self.choices.get(&id).cloned().unwrap_or_default()
    }

    /// Whether faces of any mesh are marked, or were marked for a step.
    pub fn was_masked(&self) -> bool {
        let by_step = |s: &Arc<State>| {
            let step = s.step.as_ref();
            step.is_some_and(|step| step.mask.is_some() && !step.keep_marks)
        };
        let marked = self.choices.values().any(|c| !c.mask().0.is_empty());
        marked || self.states.values().any(by_step)
    }

    /// Changes the choices on a mesh; none if the mesh does not exist any more.
    ///
    /// # Errors
    /// As [`Choices::change`].
    pub fn choose(&mut self, change: &Change) -> Option<Result<(), (String, &'static str)>> {
        let state = self.states.get(&change.id)?.clone();
        let choices = self.choices.entry(change.id).or_default();
        self.chosen[0] += 1;
        Some(choices.change(change, &state))
    }

    /// Stores a mask of a mesh under a name; none if the mesh does not exist any more.
    ///
    /// # Errors
    /// As [`NamedMasks::keep`](super::named::NamedMasks::keep).
    pub fn keep_mask(
        &mut self,
        id: u32,
        mask: NamedMask,
    ) -> Option<Result<(), (String, &'static str)>> {
        let faces = self.states.get(&id)?.loaded.mesh.faces.len();
        self.chosen[0] += 1;
        let choices = self.choices.entry(id).or_default();
        Some(choices.named.keep(mask, faces))
    }

    /// Removes the mask of a name from all meshes; false if there is none.
    pub fn drop_mask(&mut self, name: &str) -> bool {
        let mut is_found = false;
        for choices in self.choices.values_mut() {
            is_found |= choices.named.remove(name);
        }
        self.chosen[0] += 1;
        is_found
    }

    /// Restores the choices on the current mesh from an earlier session.
    pub fn restore_choices(&mut self, choices: Choices) {
        let state = self.current().clone();
        // Count them as a change, so that they are stored again even if no step follows.
        if choices != Choices::default() {
            self.chosen[0] += 1;
        }
        self.choices.insert(state.id, choices.checked(&state));
    }

    /// The content of the recovery file: the steps to the current mesh and the choices on each mesh.
    pub fn snapshot(&self) -> Snapshot {
        let current = self.current();
        let step = |s: &super::state::StepDone| StoredStep {
            work: s.work.clone(),
            mask: s.mask.clone(),
            no_texture: s.no_texture,
        };
        let mut choices = Vec::new();
        let mut at = Some(current);
        while let Some(state) = at {
            choices.push(self.choices(state.id));
            at = state.parent.as_ref();
        }
        choices.reverse();
        Snapshot {
            of: (current.id, self.chosen[0]),
            steps: current.steps().into_iter().map(step).collect(),
            choices,
        }
    }

    /// Whether the recovery file is needed: there are unsaved steps, or choices changed since the last save.
    pub fn needs_storing(&self) -> bool {
        self.is_unsaved() || self.chosen[0] != self.chosen[1]
    }

    /// Records that a mesh was saved.
    pub fn was_saved(&mut self, id: u32, saved: SavedAs) {
        self.saved = id;
        self.chosen[1] = self.chosen[0];
        self.outputs.insert(id, saved);
    }

    /// The file that a mesh was last saved to.
    pub fn output(&self, id: u32) -> Option<&SavedAs> {
        self.outputs.get(&id)
    }

    /// Whether the current mesh differs from the one saved last, and from the input, which is never replaced.
    pub fn is_unsaved(&self) -> bool {
        ![self.saved, 0].contains(&self.current().id)
    }

    /// Whether a mesh of this session, its patches or its missing piece were saved to a path.
    pub fn wrote(&self, path: &Path) -> bool {
        self.outputs.values().any(|saved| {
            let wanted = &saved.deliverables;
            let files = [&wanted.patches, &wanted.piece].into_iter().flatten();
            saved.path == path
                || files
                    .into_iter()
                    .any(|file| file.place.path() == Some(path))
        })
    }
}
