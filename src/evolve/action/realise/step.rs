//! What one action did to the room: plain data for reports, provenance and overlays.

use glam::Vec3;

use super::figure::Spot;
use super::placing::Refused;
use super::world::Pose;
use super::zone::Zone;
use crate::evolve::action::{ActionKind, PersonFrame};
use crate::generate::Place;
use crate::scene::{BodyParams, ObjectId, PoseFamily};

/// Somebody at the action.
#[derive(Clone, Debug)]
pub struct StepPerson {
    /// Pose family.
    pub family: PoseFamily,
    /// The representative body, not fitted.
    pub body: BodyParams,
    /// Where the pelvis is and where they face.
    pub spot: Spot,
    /// Frame of the learned layouts.
    pub frame: PersonFrame,
    /// What holds them.
    pub on: String,
    /// Their chair, if they sit on one.
    pub chair: Option<ObjectId>,
    /// The place for whoever fits a body.
    pub place: Place,
}

/// Something new.
#[derive(Clone, Debug, PartialEq)]
pub struct Inserted {
    /// Its number in the room.
    pub id: ObjectId,
    /// Its name.
    pub name: String,
    /// Its kind in the library.
    pub kind: String,
    /// Where it is.
    pub pose: Pose,
    /// Name of what it stands on.
    pub on: String,
    /// Which person it is for; `None` for what a group shares.
    pub person: Option<usize>,
}

/// Why something was moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MoveReason {
    /// The action uses it.
    Used,
    /// Somebody sits on it.
    SatOn,
    /// It was in the way.
    InTheWay,
    /// It was in the way, and only on top of something was there room.
    Stacked,
    /// It was in the way, and no table had room but that which is used.
    Crowded,
    /// It was in the way, and only on the floor was there room.
    ToTheFloor,
}

impl MoveReason {
    /// For people: "chair moved 31 cm: somebody sits on it".
    pub fn label(self) -> &'static str {
        match self {
            Self::Used => "it is used",
            Self::SatOn => "somebody sits on it",
            Self::InTheWay => "it was in the way",
            Self::Stacked => "it was in the way and found room on a stack",
            Self::Crowded => "it was in the way and only here was room",
            Self::ToTheFloor => "it was in the way and found room on the floor",
        }
    }
}

/// Something that was there and was moved.
#[derive(Clone, Debug, PartialEq)]
pub struct Moved {
    /// Its number in the room.
    pub id: ObjectId,
    /// Its name.
    pub name: String,
    /// Where it was.
    pub from: Pose,
    /// Where it is.
    pub to: Pose,
    /// Why.
    pub why: MoveReason,
    /// Name of what it stands on now.
    pub on: String,
}

impl Moved {
    /// How far, metres.
    pub fn distance_m(&self) -> f32 {
        self.from.at.distance(self.to.at)
    }
}

/// Something that the action wanted and did not get.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failed {
    /// The kind or label.
    pub object: String,
    /// Why, for people.
    pub why: String,
}

/// What became of a place that was tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The thing is there now.
    Taken,
    /// It runs into something.
    Collides,
    /// Too little of it is supported.
    Overhangs,
    /// It is in the working zone of others' things.
    InTheZone,
    /// A better place was found before.
    NotTried,
}

impl From<Refused> for Verdict {
    fn from(refused: Refused) -> Self {
        match refused {
            Refused::Collides => Self::Collides,
            Refused::Overhangs => Self::Overhangs,
        }
    }
}

/// A place that was drawn for a thing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Where.
    pub at: Vec3,
    /// Value of eq. 10 (active things), or minus the distance in metres (things in the way).
    pub score: f32,
    /// What became of it.
    pub verdict: Verdict,
}

/// The places drawn for one thing: those that were tried, best first, and some that were not.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidates {
    /// The thing.
    pub object: String,
    /// Places.
    pub samples: Vec<Sample>,
    /// How many were drawn.
    pub drawn: usize,
}

/// What one action did.
#[derive(Clone, Debug)]
pub struct EvolutionStep {
    /// 1 for the first.
    pub number: usize,
    /// Number of the node in the action model.
    pub node: usize,
    /// Its type.
    pub kind: ActionKind,
    /// "use laptop on desk while sitting".
    pub action: String,
    /// Where it happened.
    pub key: ObjectId,
    /// Name of that.
    pub key_name: String,
    /// Who.
    pub people: Vec<StepPerson>,
    /// What is new.
    pub inserted: Vec<Inserted>,
    /// What was moved.
    pub moved: Vec<Moved>,
    /// Things that were used where they were.
    pub used: Vec<ObjectId>,
    /// What all of a group wants, wherever it stands.
    pub shared: Vec<ObjectId>,
    /// What the action wanted and did not get.
    pub failed: Vec<Failed>,
    /// The working zone.
    pub zone: Zone,
    /// Places that were drawn.
    pub candidates: Vec<Candidates>,
    /// Time for sampling and placing.
    pub seconds: f64,
}
