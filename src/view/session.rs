//! The steps of a session: a line along which undo and redo go, and meshes beside it that are only looked at.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::SystemTime;

use super::choices::{Change, Choices};
use super::state::State;
use super::store::{Keep, KeptStep};
use crate::Cancel;

/// Most meshes that are kept to be looked at.
const PREVIEWS: usize = 4;

/// All meshes of a session, and what is being done.
pub struct Session {
    states: BTreeMap<u32, Arc<State>>,
    /// The numbers of the meshes from the file on.
    line: Vec<u32>,
    /// The place of the current one in it.
    at: usize,
    /// The meshes beside the line, the oldest first.
    previews: Vec<u32>,
    next_state: u32,
    next_job: u64,
    /// What is being done.
    pub busy: Option<Busy>,
    /// The mesh that was saved last; at first the file itself.
    saved: u32,
    /// Where meshes were saved last, and whether as text.
    outputs: BTreeMap<u32, (PathBuf, bool)>,
    /// What is chosen on each mesh.
    choices: BTreeMap<u32, Choices>,
    /// How often something was chosen, and how often when a mesh was saved last.
    chosen: [u64; 2],
}

/// A job that is being done.
pub struct Busy {
    /// Its number.
    pub job: u64,
    /// The name of the command.
    pub kind: &'static str,
    /// Since when.
    pub since: SystemTime,
    /// Stops it.
    pub cancel: Cancel,
}

impl Session {
    /// A session of a file.
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

    /// A mesh.
    pub fn state(&self, id: u32) -> Option<&Arc<State>> {
        self.states.get(&id)
    }

    /// The meshes of the line.
    pub fn line(&self) -> impl Iterator<Item = &Arc<State>> {
        self.line.iter().map(|id| &self.states[id])
    }

    /// The meshes beside it.
    pub fn previews(&self) -> impl Iterator<Item = &Arc<State>> {
        self.previews.iter().map(|id| &self.states[id])
    }

    /// Whether there are steps to undo and to redo.
    pub fn ways(&self) -> [bool; 2] {
        [self.at > 0, self.at + 1 < self.line.len()]
    }

    /// Begins a job, unless there is one.
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

    /// Goes one step back or forth.
    pub fn go(&mut self, forth: bool) -> bool {
        let [back, on] = self.ways();
        match forth {
            true if on => self.at += 1,
            false if back => self.at -= 1,
            _ => return false,
        }
        true
    }

    /// Goes to a mesh of the line.
    pub fn go_to(&mut self, id: u32) -> bool {
        let place = self.line.iter().position(|i| *i == id);
        self.at = place.unwrap_or(self.at);
        place.is_some()
    }

    /// Takes a mesh that was made of the current one: the next of the line, in the place of those that were, or a preview.
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

    /// Makes a preview the next mesh of the line.
    ///
    /// # Errors
    /// Why it cannot be.
    pub fn adopt(&mut self, id: u32) -> Result<(), &'static str> {
        let place = self.previews.iter().position(|i| *i == id);
        let place = place.ok_or("there is no such preview")?;
        let parent = self.states[&id].parent.as_ref().map(|p| p.id);
        if parent != Some(self.current().id) {
            return Err("the preview was made of another mesh than the current one");
        }
        self.previews.remove(place);
        // What was chosen since it was made counts too.
        self.carry(id);
        self.append(id);
        Ok(())
    }

    /// Drops a preview.
    pub fn discard(&mut self, id: u32) -> bool {
        let place = self.previews.iter().position(|i| *i == id);
        if let Some(place) = place {
            self.previews.remove(place);
            self.forget(id);
        }
        place.is_some()
    }

    /// Puts a mesh behind the current one.
    fn append(&mut self, id: u32) {
        for gone in self.line.split_off(self.at + 1) {
            self.forget(gone);
        }
        self.line.push(id);
        self.at = self.line.len() - 1;
    }

    /// Drops a mesh and what was chosen on it.
    fn forget(&mut self, id: u32) {
        self.states.remove(&id);
        self.choices.remove(&id);
    }

    /// Carries what is chosen on a mesh's parent to it.
    fn carry(&mut self, id: u32) {
        let state = &self.states[&id];
        if let Some(parent) = &state.parent {
            let carried = self.choices(parent.id).carried(parent, state);
            self.choices.insert(id, carried);
        }
    }

    /// What is chosen on a mesh.
    pub fn choices(&self, id: u32) -> Choices {
        self.choices.get(&id).cloned().unwrap_or_default()
    }

    /// Whether faces of any of its meshes are marked, or were for a step.
    pub fn was_masked(&self) -> bool {
        let by_step = |s: &Arc<State>| s.step.as_ref().is_some_and(|step| step.mask.is_some());
        let marked = self.choices.values().any(|c| !c.mask().0.is_empty());
        marked || self.states.values().any(by_step)
    }

    /// Takes what is chosen on a mesh.
    ///
    /// # Errors
    /// As [`Choices::change`]; none where the mesh is no more.
    pub fn choose(&mut self, change: &Change) -> Option<Result<(), (String, &'static str)>> {
        let state = self.states.get(&change.id)?.clone();
        let choices = self.choices.entry(change.id).or_default();
        self.chosen[0] += 1;
        Some(choices.change(change, &state))
    }

    /// Takes what was chosen on the current mesh in an earlier session.
    pub fn restore_choices(&mut self, choices: Choices) {
        let state = self.current().clone();
        // They are worth keeping on, also where no step follows.
        if choices != Choices::default() {
            self.chosen[0] += 1;
        }
        self.choices.insert(state.id, choices.checked(&state));
    }

    /// What a file of the session holds.
    pub fn kept(&self) -> Keep {
        let current = self.current();
        let step = |s: &super::state::StepDone| KeptStep {
            work: s.work.clone(),
            mask: s.mask.clone(),
        };
        let mut choices = Vec::new();
        let mut at = Some(current);
        while let Some(state) = at {
            choices.push(self.choices(state.id));
            at = state.parent.as_ref();
        }
        choices.reverse();
        Keep {
            of: (current.id, self.chosen[0]),
            steps: current.steps().into_iter().map(step).collect(),
            choices,
        }
    }

    /// Whether there is anything that a file of the session has to keep: steps that no saved file has, or choices made since.
    pub fn is_kept(&self) -> bool {
        self.is_unsaved() || self.chosen[0] != self.chosen[1]
    }

    /// A mesh was saved.
    pub fn was_saved(&mut self, id: u32, path: PathBuf, ascii: bool) {
        self.saved = id;
        self.chosen[1] = self.chosen[0];
        self.outputs.insert(id, (path, ascii));
    }

    /// Where a mesh was saved last.
    pub fn output(&self, id: u32) -> Option<&(PathBuf, bool)> {
        self.outputs.get(&id)
    }

    /// Whether there are steps that no saved file has.
    pub fn is_unsaved(&self) -> bool {
        self.current().id != self.saved
    }
}
