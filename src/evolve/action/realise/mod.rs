//! Actions happen in a room (ADSE §5): things are brought, moved and used, step by step.
//!
//! [`Stage`] is what stays of a room, [`Library`] what things there are, [`Evolution`] a room's state after some
//! actions. Suggestions, applying one, undoing and branching are by value:
//!
//! ```text
//! let stage = Arc::new(Stage::new(room, Library::bundled(), ticker)?);      // once per room, seconds
//! let start = Evolution::new(stage, model, EvolutionConfig::usual(), seed); // cheap
//! let next  = start.apply(start.suggestions()[0].node, 0)?;                 // milliseconds; `start` is the undo
//! let other = start.apply(node, 1)?;                                        // another future of the same room
//! next.steps()                                                              // who, what came, what moved and why
//! next.room()                                                               // the room to draw and to save
//! ```

mod active;
mod attend;
mod away;
mod chair;
mod crowd;
mod embody;
mod evolution;
mod figure;
mod furnish;
mod library;
mod measure;
mod perform;
mod placing;
mod scene_state;
mod shape;
mod solid;
mod spine;
mod spot;
mod squares;
mod stage;
mod step;
#[cfg(test)]
mod tests;
mod wanted;
mod world;
mod zone;

pub use embody::{Embodied, embody, embody_as};
pub use evolution::{Evolution, EvolutionConfig, GroupMode, NotPossible, Off, Suggestion};
pub use figure::Spot;
pub use library::{Companion, Faces, Ground, Kind, KindId, Library, LibraryError, Thing};
pub use measure::{Interpenetration, PENETRATION_MM, RoomMeasures, measure};
pub use scene_state::scene_state;
pub use shape::{Shape, UnderPoint};
pub use stage::{Found, Laid, Stage, Surface};
pub use step::{Candidates, EvolutionStep, Failed, Inserted, MoveReason, Moved, Sample, StepPerson, Verdict};
pub use world::{Held, Item, Pose, Source, World};
pub use zone::Zone;
