//! The room and who is in it: plain data. Room, objects, categories, persons, cameras; and what a room's
//! geometry says: ray tree, signed distance field, support surfaces, walkable floor.
//!
//! May name `math` and `assets`. May not change a document, run an optimiser or draw. Everything is in the
//! world frame: metres, right-handed, Y up, the floor at about `y = 0`.

pub mod layout;

mod bvh;
mod camera;
mod category;
mod clip;
mod columns;
mod export;
mod field;
mod floor;
mod geometry;
mod import;
mod person;
mod room;
mod step;
mod support;
mod tree;

pub use bvh::{Closest, Hit, PACKET, PacketCaster, PacketHits, TriangleBvh, closest_on_triangle};
pub use camera::Camera;
pub use category::Category;
pub use clip::{
    CLIP_FPS, Clip, ClipId, FRAME_JOINTS, Frame, GoalPose, Leg, SubGoal, SubGoalId, direction_of, facing_of,
};
pub use export::model_from_room;
pub use field::{FieldConfig, OpenBlocks, Resolution, SignedDistanceField, bake, bake_cached};
pub use floor::{WalkableFloor, Walker};
pub use geometry::{GeometryConfig, RoomGeometry};
pub use import::{ImportOptions, ImportReport, Imported, UpAxis, room_from_model, understand};
pub use person::{BETAS, BodyParams, HANDS, PARAMS, POSE, Person, PersonId, PoseFamily};
pub use room::{Object, ObjectId, ObjectPart, Room, Scene};
pub use step::{Step, Stopped};
pub use support::{Back, EdgePoint, FREE_LIMIT_M, SupportCell, SupportSurface, find_supports};
