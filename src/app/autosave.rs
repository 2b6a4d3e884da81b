//! Keeps unsaved people and motions in a file of the program's own, so that a crash or a power cut costs a minute at most.
//! The file goes when the project is saved or the window is closed on purpose.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use super::state::EditorState;
use crate::document::remove_leftover;
use crate::job::{Job, Outcome, Seed};

/// Work that may be lost. Saving takes a fraction of a second on a thread of its own.
const EVERY: Duration = Duration::from_secs(60);

/// The file, and what it holds.
pub struct Autosave {
    path: PathBuf,
    every: Duration,
    last: Instant,
    /// The document's revision that the file holds.
    holds: Option<u64>,
    saving: Option<(u64, Job<()>)>,
    complained: bool,
}

impl Autosave {
    /// Keeps unsaved people in `path`.
    pub fn new(path: PathBuf) -> Self {
        Self { path, every: EVERY, last: Instant::now(), holds: None, saving: None, complained: false }
    }

    /// The same with another interval, for tests.
    #[cfg(test)]
    pub fn with_interval(self, every: Duration) -> Self {
        Self { every, ..self }
    }

    /// Saves when it is time. Returns when to look again, if there is something to save.
    pub fn keep(&mut self, state: &mut EditorState) -> Option<Duration> {
        self.poll(state);
        if state.study.is_some() {
            // The user's work waits untouched, and so does what is kept of it.
            return None;
        }
        if !state.has_unsaved_work() {
            self.discard();
            return None;
        }
        let document = &state.document;
        if self.holds == Some(document.revision()) || self.saving.is_some() || document.in_gesture() {
            return None;
        }
        let left = self.every.saturating_sub(self.last.elapsed());
        if left > Duration::ZERO {
            return Some(left);
        }
        self.last = Instant::now();
        let project = document.project();
        let (engine, path) = (state.engine().clone(), self.path.clone());
        let work = move |cx: &crate::job::JobCtx| engine.save(&path, &project, cx.ticker());
        let job = Job::spawn("Autosave", Seed::root(0), state.waker(), work);
        self.saving = Some((document.revision(), job));
        None
    }

    fn poll(&mut self, state: &mut EditorState) {
        let Some((revision, job)) = &mut self.saving else { return };
        let Some(outcome) = job.poll() else { return };
        match outcome {
            Outcome::Done(()) => self.holds = Some(*revision),
            Outcome::Failed(why) | Outcome::Panicked(why) if !self.complained => {
                self.complained = true;
                state.notices.warning(format!("Your work can't be kept against a crash: {why}"));
            }
            _ => {}
        }
        self.saving = None;
    }

    /// Removes the file: what it holds is saved elsewhere or not wanted.
    pub fn discard(&mut self) {
        if self.holds.take().is_some() {
            remove_leftover(&self.path);
        }
    }
}
