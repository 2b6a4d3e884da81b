//! The document: the scene, its revision and its undo history.

use std::collections::VecDeque;
use std::sync::Arc;

use super::change::{Change, NextIds, RoomVersion};
use super::command::{Command, Refused};
use super::decide::{State, decide};
use super::project::Project;
use crate::scene::Room;
use crate::scene::Scene;

/// Bytes that the history may keep alive before the oldest steps are forgotten; rooms share their meshes,
/// so this is tens of opened rooms and practically any number of edits.
const HISTORY_BYTES: usize = 1 << 30;

/// One undo step: facts that belong together, and the geometry's name on both sides.
#[derive(Debug)]
struct Step {
    serial: u64,
    label: String,
    changes: Vec<Change>,
    version_before: RoomVersion,
    version_after: RoomVersion,
}

impl Step {
    fn bytes(&self) -> usize {
        size_of::<Self>() + self.changes.iter().map(Change::bytes).sum::<usize>()
    }
}

/// A scene that changes by commands only, and every change of which can be taken back.
#[derive(Debug)]
pub struct Document {
    scene: Scene,
    revision: u64,
    version: RoomVersion,
    next_version: u64,
    next: NextIds,
    next_serial: u64,
    past: VecDeque<Step>,
    future: Vec<Step>,
    gesture: Option<Step>,
    /// The state before the oldest step that is remembered.
    base_serial: u64,
    saved_at: u64,
    history_bytes: usize,
}

impl Default for Document {
    fn default() -> Self {
        Self::new(Scene::default())
    }
}

impl Document {
    /// A document that begins with `scene` and an empty history.
    pub fn new(scene: Scene) -> Self {
        let mut document = Self {
            scene,
            revision: 0,
            version: RoomVersion(0),
            next_version: 1,
            next: NextIds::default(),
            next_serial: 1,
            past: VecDeque::new(),
            future: Vec::new(),
            gesture: None,
            base_serial: 0,
            saved_at: 0,
            history_bytes: HISTORY_BYTES,
        };
        document.raise_ids();
        document
    }

    /// A document over `room` without people.
    pub fn of_room(room: Arc<Room>) -> Self {
        Self::new(Scene { room, ..Scene::default() })
    }

    /// The same with another bound on what the history keeps alive.
    #[must_use]
    pub fn with_history_bytes(self, history_bytes: usize) -> Self {
        Self { history_bytes, ..self }
    }

    /// The scene as it is.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Rises with every change, undo and redo.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// Names the present state of the room's solid geometry.
    pub fn room_version(&self) -> RoomVersion {
        self.version
    }

    /// The id number that the next person will get; ids are never used again.
    pub fn next_person(&self) -> u32 {
        self.next.person
    }

    /// The same for objects.
    pub fn next_object(&self) -> u32 {
        self.next.object
    }

    /// The same for motions.
    pub fn next_clip(&self) -> u32 {
        self.next.clip
    }

    /// Keeps ids below these numbers from being given again: for a reopened project, whose removed people,
    /// objects and motions keep their ids.
    pub fn reserve_ids(&mut self, next: NextIds) {
        self.next = self.next.max(next);
    }

    /// What a file keeps of it.
    pub fn project(&self) -> Project {
        Project { scene: self.scene.clone(), next: self.next }
    }

    /// Does what `command` asks for, as one undo step (or as part of the open gesture).
    /// `None` means that everything was already so; no step is made then.
    ///
    /// # Errors
    /// [`Refused`] says why; nothing has changed then.
    pub fn apply(&mut self, command: Command) -> Result<Option<&Change>, Refused> {
        let label = command.label();
        let state = State { scene: &self.scene, version: self.version, next: self.next };
        let Some(change) = decide(&state, command)? else { return Ok(None) };
        let version_before = self.version;
        self.evolve(&change);
        if change.touches_geometry() {
            self.version = RoomVersion(self.next_version);
            self.next_version += 1;
        }
        self.future.clear();
        if let Some(step) = &mut self.gesture {
            step.version_after = self.version;
            add_merged(&mut step.changes, change);
            return Ok(self.gesture.as_ref().and_then(|step| step.changes.last()));
        }
        let mut step = self.new_step(label, version_before);
        step.version_after = self.version;
        step.changes.push(change);
        self.push(step);
        Ok(self.past.back().and_then(|step| step.changes.last()))
    }

    /// Takes the last step back and returns its label. An open gesture is taken back first.
    pub fn undo(&mut self) -> Option<String> {
        if self.gesture.is_some() {
            self.abort();
        }
        let step = self.past.pop_back()?;
        self.revert(&step);
        let label = step.label.clone();
        self.future.push(step);
        Some(label)
    }

    /// Does the step that was taken back last again and returns its label.
    pub fn redo(&mut self) -> Option<String> {
        if self.gesture.is_some() {
            return None;
        }
        let step = self.future.pop()?;
        for change in &step.changes {
            change.evolve(&mut self.scene);
        }
        self.revision += 1;
        self.version = step.version_after;
        let label = step.label.clone();
        self.past.push_back(step);
        Some(label)
    }

    /// Whether there is something to undo.
    pub fn can_undo(&self) -> bool {
        !self.past.is_empty() || self.gesture.is_some()
    }

    /// Whether there is something to redo.
    pub fn can_redo(&self) -> bool {
        !self.future.is_empty() && self.gesture.is_none()
    }

    /// What can be undone, the newest last.
    pub fn past_labels(&self) -> impl DoubleEndedIterator<Item = &str> + '_ {
        self.past.iter().map(|step| step.label.as_str())
    }

    /// What can be redone, the next one first.
    pub fn future_labels(&self) -> impl Iterator<Item = &str> + '_ {
        self.future.iter().rev().map(|step| step.label.as_str())
    }

    /// Opens a gesture: everything until [`Document::commit`] is one undo step called `label`.
    /// A gesture that is still open is committed first.
    pub fn begin(&mut self, label: impl Into<String>) {
        self.commit();
        self.gesture = Some(self.new_step(label.into(), self.version));
    }

    /// Closes the gesture. One that changed nothing in the end leaves no step.
    pub fn commit(&mut self) {
        if let Some(step) = self.gesture.take()
            && !step.changes.is_empty()
        {
            self.push(step);
        }
    }

    /// Closes the gesture and takes everything in it back.
    pub fn abort(&mut self) {
        if let Some(step) = self.gesture.take() {
            self.revert(&step);
        }
    }

    /// Whether a gesture is open.
    pub fn in_gesture(&self) -> bool {
        self.gesture.is_some()
    }

    /// Whether there are changes that no file holds. Undoing back to the saved state makes it clean again.
    pub fn is_dirty(&self) -> bool {
        self.gesture.is_some() || self.saved_at != self.state_serial()
    }

    /// Notes that the present state has been written to a file.
    pub fn mark_saved(&mut self) {
        self.commit();
        self.saved_at = self.state_serial();
    }

    /// Names the present state among all states of the history.
    fn state_serial(&self) -> u64 {
        self.past.back().map_or(self.base_serial, |step| step.serial)
    }

    fn new_step(&mut self, label: String, version: RoomVersion) -> Step {
        let serial = self.next_serial;
        self.next_serial += 1;
        Step { serial, label, changes: Vec::new(), version_before: version, version_after: version }
    }

    fn evolve(&mut self, change: &Change) {
        change.evolve(&mut self.scene);
        self.revision += 1;
        self.raise_ids();
    }

    fn revert(&mut self, step: &Step) {
        for change in step.changes.iter().rev() {
            change.inverse().evolve(&mut self.scene);
        }
        self.revision += 1;
        self.version = step.version_before;
    }

    fn raise_ids(&mut self) {
        self.reserve_ids(NextIds::after(&self.scene));
    }

    /// Appends a step and forgets the oldest ones beyond the bound, never the new one.
    fn push(&mut self, step: Step) {
        self.past.push_back(step);
        let mut kept: usize = self.past.iter().map(Step::bytes).sum();
        while kept > self.history_bytes && self.past.len() > 1 {
            let Some(oldest) = self.past.pop_front() else { break };
            kept -= oldest.bytes();
            self.base_serial = oldest.serial;
        }
    }
}

/// Appends `change`, melting it into the last one when both edit the same things, so that a drag of a
/// thousand moves is one fact.
fn add_merged(changes: &mut Vec<Change>, change: Change) {
    let melted = match (changes.last_mut(), &change) {
        (
            Some(Change::PeopleReplaced { before: first, after: last }),
            Change::PeopleReplaced { before, after },
        ) if last == before => {
            last.clone_from(after);
            Some(first == last)
        }
        (
            Some(Change::ObjectsEdited { before: first, after: last }),
            Change::ObjectsEdited { before, after },
        ) if last == before => {
            last.clone_from(after);
            Some(first == last)
        }
        (
            Some(Change::ClipsReplaced { before: first, after: last }),
            Change::ClipsReplaced { before, after },
        ) if last == before => {
            last.clone_from(after);
            Some(first == last)
        }
        _ => None,
    };
    match melted {
        None => changes.push(change),
        Some(true) => {
            changes.pop();
        }
        Some(false) => {}
    }
}
