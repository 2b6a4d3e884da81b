//! Actions: what people do, where, how and with which objects (ADSE §3, §4), and which action follows which.
//!
//! [`ActionModel`] is what `learn` makes of annotated photos and what evolving a room reads. May not name `learn`;
//! reads no file (the learned default is embedded).
//!
//! # Frame and units
//! Everything is in metres and radians on the floor plan around a person ([`PersonFrame`]): the origin is the middle
//! of the torso, halfway between the middle of the hips and the middle of the shoulders; angles go from the person's
//! right hand (0) over the front (+90°) to the left (180°) and the back (-90°), as in ADSE fig. 5. *Front* is the
//! world's up × the horizontal line of the shoulders, for every posture: somebody on their back has the feet in
//! front, somebody on their belly the head. Heights are not learned: an object stands on the nearest support under
//! (or over) its place. Photos measure in projected torso lengths; the learner turns them into metres
//! ([`ActionModel::metres_per_unit`] says how many metres one was).
//!
//! # What an action node says to whoever realises it
//! 1. Put a person of [`ActionNode::posture`] on or around a [`KeyObject`]; around: the centre of the key object is
//!    seen at an angle drawn from [`ActionNode::key_angle`] in the person's frame.
//! 2. Draw how many of each object from [`ActionNode::occurrence`] (key objects and seats are not among them).
//! 3. Place each by the sum of eq. 10 over [`ActionNode::around_person`] and [`ActionNode::between`]. A relation
//!    (o, o') uses the *person's* axes with the origin moved to o' ([`PersonFrame::at`]).
//! 4. A group action has [`ActionNode::group`]: how many people, which objects they share (eq. 6 to 8).

mod bundled;
mod frame;
mod graph;
mod group;
mod model;
mod realise;

pub use frame::{PersonFrame, Polar};
pub use graph::{ActionGraph, correlation};
pub use group::{GroupModel, PEOPLE_APART_M, is_shared, shared_potential};
pub use model::{
    ActionKind, ActionModel, ActionModelError, ActionNode, Evidence, KeyObject, KeyRelation, Occurrence,
    PairPlacement, Placement, PolarDensity, Posture, Provenance,
};
pub use realise::{
    Candidates, Companion, Embodied, Evolution, EvolutionConfig, EvolutionStep, Faces, Failed, Found, Ground,
    GroupMode, Held, Inserted, Interpenetration, Item, Kind, KindId, Laid, Library, LibraryError, MoveReason,
    Moved, NotPossible, Off, PENETRATION_MM, Pose, RoomMeasures, Sample, Shape, Source, Spot, Stage,
    StepPerson, Suggestion, Surface, Thing, UnderPoint, Verdict, World, Zone, embody, embody_as, measure,
    scene_state,
};
