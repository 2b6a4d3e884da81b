//! The graphics card's side: pipelines, caches and the passes of one picture. Knows values of
//! [`super::draw`] only; never a window, never the document.

mod finish;
mod frame;
mod marks;
mod mesh;
mod people;
mod pipelines;
mod room;
mod shadow;
mod targets;
mod texture;
mod viewport;
mod workers;

pub(super) use people::PeopleCache;
pub(super) use pipelines::Pipelines;
pub(super) use room::RoomCache;
pub(super) use shadow::ShadowCache;
pub use viewport::Viewport;
