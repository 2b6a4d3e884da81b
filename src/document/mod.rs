//! The only writer of the scene: [`Command`] (intent) is decided into [`Change`] (fact) or [`Refused`];
//! facts are kept with their inverse for undo and redo; projects are saved and reopened bit by bit; studies with human
//! raters are planned and their scores kept; the user's own things are kept from session to session.
//!
//! May name `math`, `assets`, `scene`, `body`, `inspect`. Knows no job, no window and no generator, and
//! never changes anything but through a fact that it can take back.

mod change;
mod clips;
mod command;
mod decide;
mod decide_clips;
mod files;
mod history;
mod project;
mod settings;
mod study;
#[cfg(test)]
mod tests;
mod things;

pub use change::{Change, NextIds, Numbered, ObjectState, RoomState, RoomVersion};
pub use command::{Command, Refused};
pub use files::{LoadedProject, ProjectError, load_project, save_project, write_folder};
pub use history::Document;
pub use project::{Project, WriteProblem};
pub use settings::{Settings, autosave_path, is_leftover, remove_leftover};
pub use study::{Exhibit, MethodScores, Study, StudyKind, Trial, find_exhibits, save_scores, summarise};
pub use things::{OwnThing, ThingError, keep_thing, read_things, things_folder};
