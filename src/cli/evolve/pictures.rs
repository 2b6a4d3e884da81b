//! Pictures of an evolution: the whole room from two corners and the action from near by, after chosen steps.

use std::sync::Arc;

use glam::Vec3;

use super::Shown;
use crate::assets::encode_png;
use crate::body::Body;
use crate::cli::output::OutputFolder;
use crate::evolve::action::{Evolution, StepPerson};
use crate::render::{Backend, BodySurface, Cutaway, Painter, PersonDraw, SceneDraw, room_views};
use crate::scene::{Camera, Scene};

/// Size of the overview pictures.
const ROOM_SIZE: [u32; 2] = [1280, 800];
/// Size of the pictures of the action.
const ACTION_SIZE: [u32; 2] = [960, 720];
/// From what people do to the eye: metres ahead of them, aside, and above the place. Faces are seen best from ahead.
const EYES_M: [[f32; 3]; 3] = [[1.5, 1.0, 0.95], [1.5, -1.0, 0.95], [-0.7, 1.1, 1.0]];
/// Vertical field of view, radians.
const FOV_Y: f32 = 0.95;

/// Draws every shown state into the folder; gives the name of what drew.
pub fn take(folder: &OutputFolder, shown: &[Shown]) -> anyhow::Result<String> {
    let painter = Painter::new(Backend::Auto)?;
    let body = Body::bundled();
    let surface = Arc::new(BodySurface::of(body));
    for state in shown {
        let number = state.evolution.steps().len();
        let scene = Scene { room: Arc::new(state.evolution.room()), ..Scene::default() };
        let mut draw = SceneDraw::of_room(&scene);
        draw.body = Some(surface.clone());
        let dressed = state.people.iter().map(|p| {
            PersonDraw::new(p.person.id, body.pose(&p.person.body).vertices.into(), p.person.palette)
        });
        draw.people = dressed.collect();
        draw.look.cutaway = Cutaway::Outside;
        let save = |name: &str, camera: &Camera, size: [u32; 2]| -> anyhow::Result<()> {
            let picture = painter.picture(&draw, camera, size)?;
            let png = encode_png(picture.width, picture.height, &picture.rgba)?;
            folder.write(&format!("pictures/{number:03}_{name}.png"), &png)?;
            Ok(())
        };
        let aspect = ROOM_SIZE[0] as f32 / ROOM_SIZE[1] as f32;
        for (i, camera) in room_views(&draw.room, aspect).iter().enumerate() {
            save(&format!("room_{i}"), camera, ROOM_SIZE)?;
        }
        for (i, camera) in action_views(&state.evolution).iter().enumerate() {
            save(&format!("action_{i}"), camera, ACTION_SIZE)?;
        }
    }
    Ok(match painter.fallback_reason() {
        Some(reason) => format!("{}, because {reason}", painter.backend()),
        None => painter.backend().to_owned(),
    })
}

/// The action from the two places with the freest view.
fn action_views(evolution: &Evolution) -> Vec<Camera> {
    let Some(person) = evolution.steps().last().and_then(|s| s.people.first()) else { return Vec::new() };
    let mut views: Vec<(f32, Camera)> = EYES_M.iter().map(|eye| view(evolution, person, *eye)).collect();
    // From behind only where the others are blocked.
    views.iter_mut().take(2).for_each(|v| v.0 += 0.5);
    views.sort_by(|a, b| b.0.total_cmp(&a.0));
    views.truncate(2);
    views.into_iter().map(|(_, camera)| camera).collect()
}

/// A view of what somebody does, pulled nearer until nothing of the room stands between; how far it can see.
fn view(evolution: &Evolution, person: &StepPerson, [ahead, aside, above]: [f32; 3]) -> (f32, Camera) {
    let (front, right) = (person.frame.front(), person.frame.right());
    let flat = |v: glam::Vec2| Vec3::new(v.x, 0.0, v.y);
    let target = person.frame.centre_m + flat(front) * 0.35;
    let offset = flat(front) * (ahead - 0.35) + flat(right) * aside + Vec3::Y * above;
    let reach_m = offset.length();
    let direction = offset / reach_m;
    let free_m = evolution
        .stage()
        .geometry
        .bvh
        .cast(target, direction, reach_m)
        .map_or(reach_m, |h| h.distance_m - 0.1);
    let eye = target + direction * free_m.max(0.6);
    (free_m, Camera { eye, target, fov_y: FOV_Y, ortho_height_m: None })
}
