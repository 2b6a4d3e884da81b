//! Pictures of a run: the whole room from opposite corners and everybody from at least two sides.

use std::sync::Arc;

use super::output::OutputFolder;
use crate::assets;
use crate::body::Body;
use crate::evolve::Populated;
use crate::render::{BodySurface, PersonDraw, Picture, RenderContext, SceneDraw, render_image};
use crate::scene::{Camera, RoomGeometry, Scene};
use glam::Vec3;

/// Size of the overview pictures.
const ROOM_SIZE: [u32; 2] = [1280, 800];
/// Size of the pictures of one person.
const PERSON_SIZE: [u32; 2] = [640, 640];

/// What was drawn, and by what.
#[derive(Default)]
pub struct Pictures {
    /// The adapter's name, or the ray caster's; empty when nothing was drawn.
    pub made_by: String,
}

/// Draws and writes every picture of a run.
///
/// # Errors
/// When a file can't be written or a picture can't be drawn by any means.
pub fn write(
    folder: &OutputFolder,
    scene: &Scene,
    geometry: &RoomGeometry,
    populated: &Populated,
    sides: usize,
) -> anyhow::Result<Pictures> {
    let maker = RenderContext::headless()?;
    let draw = scene_draw(scene);
    for (i, camera) in room_views(&draw).iter().enumerate() {
        let picture = render_image(&maker, &draw, camera, ROOM_SIZE)?;
        save(folder, &format!("pictures/room_{i}.png"), &picture)?;
    }
    for person in &populated.people {
        let mut draw = draw.clone();
        let Some(index) = draw.people.iter().position(|p| p.id == person.person.id) else { continue };
        let vertices = draw.people[index].vertices.clone();
        let views = person_views(&vertices, geometry, sides);
        let name = |what: &str, i: usize| format!("pictures/person_{:03}_{what}{i}.png", person.person.id.0);
        for (i, camera) in views.iter().enumerate() {
            save(folder, &name("side", i), &render_image(&maker, &draw, camera, PERSON_SIZE)?)?;
        }
        draw.people[index].heat = Some(person.report.signed_distances_m.clone().into());
        if let Some(camera) = views.first() {
            save(folder, &name("heat", 0), &render_image(&maker, &draw, camera, PERSON_SIZE)?)?;
        }
    }
    Ok(Pictures { made_by: maker.adapter().to_owned() })
}

/// The room with everybody in it, dressed.
fn scene_draw(scene: &Scene) -> SceneDraw {
    let body = Body::bundled();
    let mut draw = SceneDraw::of_room(scene);
    draw.body = Some(Arc::new(BodySurface::of(body)));
    let dressed = |person: &crate::scene::Person| {
        PersonDraw::new(person.id, body.pose(&person.body).vertices.into(), person.palette)
    };
    draw.people = scene.people.iter().filter(|p| p.visible).map(dressed).collect();
    draw
}

fn save(folder: &OutputFolder, name: &str, picture: &Picture) -> anyhow::Result<()> {
    let png = assets::encode_png(picture.width, picture.height, &picture.rgba)?;
    folder.write(name, &png)?;
    Ok(())
}

fn room_views(draw: &SceneDraw) -> Vec<Camera> {
    let bounds = draw.bounds();
    let (center, size) = (bounds.center(), bounds.size());
    [Vec3::new(1.0, 1.1, 1.0), Vec3::new(-1.0, 1.1, -1.0)]
        .iter()
        .map(|d| Camera { eye: center + *d * size.max_element() * 0.75, target: center, ..Camera::default() })
        .collect()
}

fn person_views(vertices: &[Vec3], geometry: &RoomGeometry, sides: usize) -> Vec<Camera> {
    let bounds = crate::math::Aabb::of(vertices.iter().copied());
    let target = bounds.center();
    let view = |i: usize| {
        let angle = i as f32 * std::f32::consts::TAU / 16.0;
        let direction = Vec3::new(angle.cos(), 0.45, angle.sin()).normalize_or(Vec3::X);
        let eye = target + direction * (1.2 + 0.8 * bounds.size().length());
        let seen = vertices.iter().step_by(97).filter(|v| {
            let ray = eye - **v;
            !geometry.bvh.any_hit(**v + ray.normalize_or_zero() * 0.05, ray.normalize_or_zero(), ray.length())
        });
        (seen.count(), i, Camera { eye, target, ..Camera::default() })
    };
    let views: Vec<_> = (0..16).map(view).collect();
    let Some(best) = views.iter().max_by_key(|v| v.0) else { return Vec::new() };
    let turned = |k: usize| {
        let from = best.1 + 3 + 16 * k / sides.max(1);
        (from..from + 3).map(|i| &views[i % 16]).max_by_key(|v| v.0).map(|v| v.2)
    };
    std::iter::once(best.2).chain((1..sides).filter_map(turned)).collect()
}
