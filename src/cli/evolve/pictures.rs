//! Pictures of an evolution: the whole room from two corners and the action from near by, after chosen steps, and all of
//! them on one sheet.

use std::sync::Arc;

use super::{Shown, views};
use crate::assets::encode_png;
use crate::body::Body;
use crate::cli::output::OutputFolder;
use crate::evolve::action::Evolution;
use crate::render::plot::{Captioned, captioned_sheet};
use crate::render::{Backend, BodySurface, Cutaway, Painter, PersonDraw, Picture, SceneDraw, room_views};
use crate::scene::{Camera, Room, Scene};

/// Size of a picture.
const SIZE: [u32; 2] = [1280, 800];
/// Pictures of the action, from different sides.
const VIEWS: usize = 2;
/// The gallery has the room and the action of each shown state side by side.
const COLUMNS: usize = 2;

/// Draws states of an evolution.
pub struct Photographer {
    painter: Painter,
    surface: Arc<BodySurface>,
}

impl Photographer {
    /// With whatever draws here.
    ///
    /// # Errors
    /// None with the default backend: without an adapter the processor draws.
    pub fn new() -> anyhow::Result<Self> {
        Ok(Self {
            painter: Painter::new(Backend::Auto)?,
            surface: Arc::new(BodySurface::of(Body::bundled())),
        })
    }

    /// The name of what draws, and why it had to stand in.
    pub fn made_by(&self) -> String {
        match self.painter.fallback_reason() {
            Some(reason) => format!("{}, because {reason}", self.painter.backend()),
            None => self.painter.backend().to_owned(),
        }
    }

    /// The room of a state with its people.
    fn scene(&self, room: &Arc<Room>, shown: &Shown) -> SceneDraw {
        let body = Body::bundled();
        let mut draw = SceneDraw::of_room(&Scene { room: room.clone(), ..Scene::default() });
        draw.body = Some(self.surface.clone());
        let dressed = shown.people.iter().map(|p| {
            PersonDraw::new(p.person.id, body.pose(&p.person.body).vertices.into(), p.person.palette)
        });
        draw.people = dressed.collect();
        draw.look.cutaway = Cutaway::Outside;
        draw
    }

    /// The room from two corners.
    ///
    /// # Errors
    /// When it can't be drawn.
    fn rooms(&self, draw: &SceneDraw) -> anyhow::Result<Vec<Picture>> {
        room_views(&draw.room, aspect()).iter().map(|camera| self.picture(draw, camera)).collect()
    }

    /// The last action, from where it is seen best.
    ///
    /// # Errors
    /// When it can't be drawn.
    fn action(&self, shown: &Shown, count: usize) -> anyhow::Result<Vec<Picture>> {
        self.from(shown, &views_of(shown, count))
    }

    /// A state from these cameras.
    ///
    /// # Errors
    /// When it can't be drawn.
    pub fn from(&self, shown: &Shown, cameras: &[Camera]) -> anyhow::Result<Vec<Picture>> {
        let draw = self.scene(&Arc::new(shown.evolution.room()), shown);
        cameras.iter().map(|camera| self.picture(&draw, camera)).collect()
    }

    fn picture(&self, draw: &SceneDraw, camera: &Camera) -> anyhow::Result<Picture> {
        Ok(self.painter.picture(draw, camera, SIZE)?)
    }
}

/// Cameras that see the last action of a state best.
pub fn views_of(shown: &Shown, count: usize) -> Vec<Camera> {
    views::action_views(&shown.evolution, &shown.evolution.room(), &shown.people, aspect(), count)
}

fn aspect() -> f32 {
    SIZE[0] as f32 / SIZE[1] as f32
}

/// Writes a picture.
///
/// # Errors
/// When the file can't be written.
pub fn save(folder: &OutputFolder, name: &str, picture: &Picture) -> anyhow::Result<()> {
    let png = encode_png(picture.width, picture.height, &picture.rgba)?;
    folder.write(&format!("pictures/{name}.png"), &png)?;
    Ok(())
}

/// Draws every shown state into the folder; gives the name of what drew.
pub fn take(folder: &OutputFolder, shown: &[Shown]) -> anyhow::Result<String> {
    let photographer = Photographer::new()?;
    let mut gallery = Vec::new();
    for state in shown {
        let number = state.evolution.steps().len();
        let draw = photographer.scene(&Arc::new(state.evolution.room()), state);
        let rooms = photographer.rooms(&draw)?;
        let actions = photographer.action(state, VIEWS)?;
        for (kind, pictures) in [("room", &rooms), ("action", &actions)] {
            for (i, picture) in pictures.iter().enumerate() {
                save(folder, &format!("{number:03}_{kind}_{i}"), picture)?;
            }
        }
        gallery.extend(rooms.first().map(|picture| tile(after(number), picture)));
        gallery.extend(actions.first().map(|picture| tile(last_action(&state.evolution), picture)));
    }
    if !gallery.is_empty() {
        save(folder, "gallery", &captioned_sheet(&gallery, COLUMNS)?)?;
    }
    Ok(photographer.made_by())
}

fn after(actions: usize) -> String {
    if actions == 1 { "after 1 action".to_owned() } else { format!("after {actions} actions") }
}

fn last_action(evolution: &Evolution) -> String {
    evolution.steps().last().map_or_else(String::new, |step| step.action.clone())
}

/// A picture of half the size.
fn tile(caption: String, picture: &Picture) -> Captioned {
    Captioned { caption, picture: picture.halved() }
}
