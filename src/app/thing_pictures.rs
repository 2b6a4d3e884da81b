//! Small pictures of things, drawn on the processor: the part of the engine behind the library of things. Runs in
//! jobs; may not touch the editor's state.

use std::sync::Arc;

use glam::{Affine3A, Vec3};

use super::engine::{ThingKind, ThingPicture};
use crate::assets::Model;
use crate::evolve::action::Library;
use crate::job::{Stop, Ticker};
use crate::render::SceneDraw;
use crate::render::Shown;
use crate::render::frame_bounds;
use crate::render::render_on_processor;
use crate::scene::Category;
use crate::scene::Object;
use crate::scene::ObjectId;
use crate::scene::ObjectPart;
use crate::scene::Room;
use crate::scene::Scene;

/// Side of the picture of a kind: sharp in a row on a dense screen.
const SMALL: u32 = 96;
/// Side of the picture of a thing that is being added.
const LARGE: u32 = 280;
/// Neither white plates nor black screens vanish before it, on a dark page or a light one.
const GROUND: [u8; 3] = [122, 127, 134];
/// From the front, a little from the right and above, as catalogues show things.
const SEEN_FROM: Vec3 = Vec3::new(0.45, 0.5, 0.9);
/// A lens that hardly distorts small things.
const FOV_Y: f32 = 0.5;

/// The kinds of the bundled library.
pub fn kinds() -> Vec<ThingKind> {
    let library = Library::bundled();
    let kind = |(_, kind): (_, &crate::evolve::action::Kind)| ThingKind {
        kind: kind.kind.clone(),
        most: kind.most,
        models: kind.models.len(),
    };
    library.kinds().map(kind).collect()
}

/// The first model of a kind, as it rests.
///
/// # Errors
/// Why it can't be drawn; or cancelled.
pub fn of_kind(kind: &str, ticker: &Ticker) -> Result<ThingPicture, Stop> {
    ticker.check()?;
    let library = Library::bundled();
    let unknown = || Stop::Failed(format!("the library has no kind \"{kind}\""));
    let thing = library.thing(library.named(kind).ok_or_else(unknown)?, 0)?;
    drawn(&thing.model, thing.thing_from_file, SMALL)
}

/// A model in metres, upright, front along +Z.
///
/// # Errors
/// Why it can't be drawn; or cancelled.
pub fn of_model(model: &Model, ticker: &Ticker) -> Result<ThingPicture, Stop> {
    ticker.check()?;
    drawn(model, Affine3A::IDENTITY, LARGE)
}

fn drawn(model: &Model, thing_from_file: Affine3A, side: u32) -> Result<ThingPicture, Stop> {
    let parts = model.parts.iter().map(|part| ObjectPart {
        mesh: part.mesh.clone(),
        material: part.material,
        object_from_mesh: thing_from_file * part.file_from_mesh,
    });
    let object = Object {
        id: ObjectId(0),
        name: model.name.clone(),
        category: Category::Objects,
        parts: parts.collect(),
        world_from_object: Affine3A::IDENTITY,
        visible: true,
        locked: false,
    };
    let bounds = object.world_bounds();
    let room = Room {
        objects: vec![object],
        materials: model.materials.clone(),
        textures: model.textures.clone(),
        ..Room::default()
    };
    let mut draw = SceneDraw::of_room(&Scene { room: Arc::new(room), ..Scene::default() });
    draw.look.grid = Shown::No;
    draw.look.background = GROUND;
    let camera = frame_bounds(&bounds, SEEN_FROM, FOV_Y, 1.0);
    let picture = render_on_processor(&draw, &camera, [side, side])?;
    Ok(ThingPicture { picture, size_m: bounds.size() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_that_actions_bring_has_a_picture_with_something_on_it() {
        for kind in kinds().iter().step_by(9) {
            let drawn = of_kind(&kind.kind, &Ticker::silent()).unwrap_or_else(|stop| panic!("{stop:?}"));
            let picture = &drawn.picture;
            let ground = picture.pixel(0, 0);
            let all = (0..SMALL).flat_map(|y| (0..SMALL).map(move |x| (x, y)));
            let covered = all.filter(|(x, y)| picture.pixel(*x, *y) != ground).count();
            assert!(covered > 300, "{}: {covered} pixels", kind.kind);
            assert!(drawn.size_m.max_element() < 3.0 && drawn.size_m.max_element() > 0.02, "{}", kind.kind);
        }
    }
}
