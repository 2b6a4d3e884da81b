//! Pictures of a run: the whole room from opposite corners and everybody from at least two sides.

use std::sync::Arc;

use crate::assets;
use crate::body::Body;
use crate::evolve::Populated;
use crate::render::{self, PersonDraw, SceneDraw};
use crate::scene::{Camera, RoomGeometry, Scene};

use super::output::OutputFolder;

/// Size of the overview pictures.
const ROOM_SIZE: (u32, u32) = (1280, 800);
/// Size of the pictures of one person.
const PERSON_SIZE: (u32, u32) = (640, 640);

/// What was drawn, and by what.
#[derive(Default)]
pub struct Pictures {
    /// The adapter's name, or the ray caster's; empty when nothing was drawn.
    pub made_by: String,
}
