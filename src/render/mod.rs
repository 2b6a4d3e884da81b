//! Draws a scene: wgpu in a window or headless, or a small ray caster on the processor where there is no
//! adapter at all. `&Scene` and camera in, texture or pixels out; and charts of numbers ([`plot`]).
//!
//! May name `math`, `assets`, `scene`, `body`, `inspect` and wgpu; never egui, never the document. Writes no
//! file: pictures are returned as pixels.

pub mod plot;

mod context;
mod cpu;
mod draw;
mod dress;
mod error;
mod film;
mod gpu;
mod heat;
mod legend;
mod light;
mod mips;
mod normals;
mod painter;
mod people_glb;
mod pick;
mod picture;
mod shell;
mod views;

pub use context::RenderContext;
pub use cpu::render_on_processor;
pub use draw::{Cutaway, DepthTest, Line, Look, PersonDraw, Point, Quality, SceneDraw, Shown};
pub use dress::{BodySurface, Hair, Outfit, SurfacePart};
pub use error::RenderError;
pub use film::Film;
pub use gpu::Viewport;
pub use heat::{CONTACT_M, DEEP_END_M, FREE_END_M, HeatTick, STOPS, TICKS, heat_color, heat_position};
pub use light::srgb_from_linear;
pub use painter::{Backend, Painter, picture};
pub use people_glb::{clips_glb, moving_room_glb, person_glb};
pub use pick::{Pick, Picked, Picker};
pub use picture::{MAX_SIDE, Picture, render_image};
pub use views::{frame_bounds, person_views, room_views};
