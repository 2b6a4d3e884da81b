//! What somebody wants, and why it may be refused.

use std::sync::Arc;

use glam::{Affine3A, Vec3};

use super::RoomVersion;
use crate::scene::BodyParams;
use crate::scene::Category;
use crate::scene::Clip;
use crate::scene::ClipId;
use crate::scene::ObjectId;
use crate::scene::Person;
use crate::scene::PersonId;
use crate::scene::Room;
use crate::scene::SubGoal;

/// An intent: from a click, a key or a finished job.
#[derive(Clone, Debug)]
pub enum Command {
    /// Opens `room` instead of the present one; people and motions leave with the old room.
    OpenRoom {
        /// The new room.
        room: Arc<Room>,
    },
    /// Puts the room as an action has left it in place of the present one: things came and moved, some people left
    /// and others came. Things that stay keep their ids; motions stay.
    ChangeRoom {
        /// What the history calls it.
        label: String,
        /// The room afterwards.
        room: Arc<Room>,
        /// Who leaves.
        leaving: Vec<PersonId>,
        /// Who comes. The document numbers them; their own ids are not looked at.
        arriving: Vec<Person>,
        /// The room that it was made from.
        made_for: Option<RoomVersion>,
    },
    /// Adds people. The document numbers them; their own ids are not looked at.
    AddPeople {
        /// Who comes.
        people: Vec<Person>,
        /// The room geometry that a job made them for; `None` when it doesn't matter.
        made_for: Option<RoomVersion>,
    },
    /// Puts new bodies in place of people with the same ids: the outcome of a re-roll or a new fit.
    ReplacePeople {
        /// The new ones.
        people: Vec<Person>,
        /// The room geometry that a job made them for; `None` when it doesn't matter.
        made_for: Option<RoomVersion>,
    },
    /// Removes people.
    RemovePeople(Vec<PersonId>),
    /// Changes one person's body by hand.
    SetBody(PersonId, BodyParams),
    /// Renames a person.
    RenamePerson(PersonId, String),
    /// Shows or hides people.
    SetPeopleVisible(Vec<PersonId>, bool),
    /// Locks or unlocks people.
    SetPeopleLocked(Vec<PersonId>, bool),
    /// Renames an object.
    RenameObject(ObjectId, String),
    /// Says what objects are.
    SetCategory(Vec<ObjectId>, Category),
    /// Shows or hides objects; hidden ones are no geometry.
    SetObjectsVisible(Vec<ObjectId>, bool),
    /// Locks or unlocks objects.
    SetObjectsLocked(Vec<ObjectId>, bool),
    /// Puts an object elsewhere.
    MoveObject(ObjectId, Affine3A),
    /// Removes objects.
    RemoveObjects(Vec<ObjectId>),
    /// Copies objects, the copies moved by some metres; meshes are shared.
    DuplicateObjects(Vec<ObjectId>, Vec3),
    /// Adds motions. The document numbers them; their own ids are not looked at.
    AddClips {
        /// The motions.
        clips: Vec<Clip>,
        /// The room geometry that a job made them for; `None` when it doesn't matter.
        made_for: Option<RoomVersion>,
    },
    /// Puts a motion in place of the one with its id: the outcome of a synthesis.
    ReplaceClip {
        /// The new one.
        clip: Clip,
        /// The room geometry that a job made it for; `None` when it doesn't matter.
        made_for: Option<RoomVersion>,
    },
    /// Removes motions.
    RemoveClips(Vec<ClipId>),
    /// Changes a motion's sub-goals by hand. Legs from or to a sub-goal that differs must be made again: their keys
    /// become 0.
    SetGoals(ClipId, Vec<SubGoal>),
    /// Renames a motion.
    RenameClip(ClipId, String),
    /// Shows or hides motions.
    SetClipsVisible(Vec<ClipId>, bool),
    /// Locks or unlocks motions.
    SetClipsLocked(Vec<ClipId>, bool),
}

impl Command {
    /// What the history calls it.
    pub fn label(&self) -> String {
        let many = |n: usize, one: &str, several: &str| {
            if n == 1 { one.to_owned() } else { format!("{n} {several}") }
        };
        let people = |n| many(n, "person", "people");
        let objects = |n| many(n, "object", "objects");
        let motions = |n| many(n, "motion", "motions");
        match self {
            Self::OpenRoom { room } => format!("Open {}", room.name),
            Self::ChangeRoom { label, .. } => label.clone(),
            Self::AddPeople { people: who, .. } => format!("Add {}", people(who.len())),
            Self::ReplacePeople { people: who, .. } => format!("Re-roll {}", people(who.len())),
            Self::RemovePeople(who) => format!("Remove {}", people(who.len())),
            Self::SetBody(..) => "Change body".to_owned(),
            Self::RenamePerson(..) => "Rename person".to_owned(),
            Self::SetPeopleVisible(who, shown) => {
                format!("{} {}", if *shown { "Show" } else { "Hide" }, people(who.len()))
            }
            Self::SetPeopleLocked(who, locked) => {
                format!("{} {}", if *locked { "Lock" } else { "Unlock" }, people(who.len()))
            }
            Self::RenameObject(..) => "Rename object".to_owned(),
            Self::SetCategory(_, category) => format!("Category: {}", category.label()),
            Self::SetObjectsVisible(what, shown) => {
                format!("{} {}", if *shown { "Show" } else { "Hide" }, objects(what.len()))
            }
            Self::SetObjectsLocked(what, locked) => {
                format!("{} {}", if *locked { "Lock" } else { "Unlock" }, objects(what.len()))
            }
            Self::MoveObject(..) => "Move object".to_owned(),
            Self::RemoveObjects(what) => format!("Remove {}", objects(what.len())),
            Self::DuplicateObjects(what, _) => format!("Duplicate {}", objects(what.len())),
            Self::AddClips { clips, .. } => format!("Add {}", motions(clips.len())),
            Self::ReplaceClip { .. } => "Synthesise motion".to_owned(),
            Self::RemoveClips(what) => format!("Remove {}", motions(what.len())),
            Self::SetGoals(..) => "Change sub-goals".to_owned(),
            Self::RenameClip(..) => "Rename motion".to_owned(),
            Self::SetClipsVisible(what, shown) => {
                format!("{} {}", if *shown { "Show" } else { "Hide" }, motions(what.len()))
            }
            Self::SetClipsLocked(what, locked) => {
                format!("{} {}", if *locked { "Lock" } else { "Unlock" }, motions(what.len()))
            }
        }
    }
}

/// Why a command was refused. Nothing has changed then.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Refused {
    /// The person was removed in the meantime; results never bring somebody back.
    #[error("Person {} is no longer in the room; nothing was changed.", .0.0)]
    NoSuchPerson(PersonId),
    /// The object was removed in the meantime.
    #[error("Object {} is no longer in the room; nothing was changed.", .0.0)]
    NoSuchObject(ObjectId),
    /// The motion was removed in the meantime.
    #[error("Motion {} is no longer there; nothing was changed.", .0.0)]
    NoSuchClip(ClipId),
    /// Two objects of a room have the same id.
    #[error("Two objects of the room have the number {}; it was not taken.", .0.0)]
    ObjectTwice(ObjectId),
    /// Two sub-goals of a motion have the same name, so that nobody could tell them apart.
    #[error("Two sub-goals of {0} have the same number; they were not taken.")]
    GoalTwice(String),
    /// Locked people stay as they are.
    #[error("{0} is locked. Unlock it first (L).")]
    Locked(String),
    /// The room has changed since the job that brings this result began.
    #[error(
        "The room was changed while this was being computed, so the result no longer fits it. Run it again."
    )]
    RoomChanged,
    /// A body or a motion holds a number that is not finite.
    #[error("{0} holds a number that is not finite; it was not taken.")]
    NotFinite(String),
    /// A transform that turns a thing into nothing or to infinity.
    #[error("This place or size of {0} is not finite or has no volume; it was not taken.")]
    BadTransform(String),
    /// A name must have at least one visible character.
    #[error("A name needs at least one character.")]
    EmptyName,
}
