//! A picture strip of motions: two pictures a second, each following the people, from two opposite sides.

use std::sync::Arc;

use glam::Vec3;

use crate::assets;
use crate::body::Body;
use crate::cli::output::OutputFolder;
use crate::math::Aabb;
use crate::render::{
    Backend, BodySurface, Cutaway, Film, Painter, Picture, Quality, SceneDraw, frame_bounds,
};
use crate::scene::{Camera, Clip, Room, Scene};

/// Pictures a second: enough to see every sliding foot.
const PER_SECOND: f32 = 2.0;
/// Size of one picture.
const TILE: [u32; 2] = [256, 240];
/// Pictures side by side.
const COLUMNS: usize = 10;
/// Longer motions are shown with fewer pictures a second: more than these no image viewer opens.
const MOST: usize = 600;
/// Half of what a picture shows around the person, metres, and from where to where in height.
const AROUND_M: (f32, f32, f32) = (0.75, 0.0, 1.75);
/// Where the camera stands, from what it looks at, for each strip.
const FROM: [(&str, Vec3); 2] =
    [("strip.png", Vec3::new(0.66, 0.5, 0.75)), ("strip_behind.png", Vec3::new(-0.66, 0.5, -0.75))];
/// As report pictures of people: a 35 mm lens.
const FOV_Y: f32 = 0.66;

/// Draws and writes the strips; gives the name of what drew them.
///
/// # Errors
/// When a picture can't be drawn or written.
pub fn write(folder: &OutputFolder, room: &Arc<Room>, clips: &[Arc<Clip>]) -> anyhow::Result<String> {
    let painter = Painter::new(Backend::Auto)?;
    let mut scene = SceneDraw::of_room(&Scene { room: room.clone(), ..Scene::default() });
    scene.body = Some(Arc::new(BodySurface::of(Body::bundled())));
    scene.look.quality = Quality::Low;
    scene.look.cutaway = Cutaway::Outside;
    let seconds = clips.iter().map(|c| c.seconds()).fold(0.0, f32::max);
    let fps = PER_SECOND.min(MOST as f32 / seconds.max(1.0));
    for (file, direction) in FROM {
        let film =
            Film { scene: scene.clone(), clips: clips.to_vec(), camera: Camera::default(), size: TILE, fps };
        let strip = strip(film, direction, &painter)?;
        folder.write(file, &assets::encode_png(strip.width, strip.height, &strip.rgba)?)?;
    }
    Ok(painter.backend().to_owned())
}

fn strip(mut film: Film, direction: Vec3, painter: &Painter) -> anyhow::Result<Picture> {
    let count = film.pictures();
    let columns = COLUMNS.min(count);
    let [width, height] = TILE.map(|side| side as usize);
    let size = [columns * width, count.div_ceil(columns) * height];
    let mut sheet = vec![255; size[0] * size[1] * 4];
    for number in 0..count {
        film.camera = camera(&film.clips, number as f32 / film.fps, direction);
        let picture = film.draw(painter, number)?;
        let corner = [number % columns * width, number / columns * height];
        for (y, row) in picture.rgba.chunks_exact(4 * width).enumerate() {
            let at = 4 * ((corner[1] + y) * size[0] + corner[0]);
            sheet[at..at + row.len()].copy_from_slice(row);
        }
    }
    let backend = painter.backend().to_owned();
    Ok(Picture { width: size[0] as u32, height: size[1] as u32, rgba: sheet, backend })
}

/// Sees everybody who moves, from one direction.
fn camera(clips: &[Arc<Clip>], seconds: f32, direction: Vec3) -> Camera {
    let at = |clip: &Arc<Clip>| clip.frames.get(clip.frame_at(seconds)).map(|f| f.translation);
    let (half, low, high) = AROUND_M;
    let boxed = |p: Vec3| Aabb {
        min: Vec3::new(p.x - half, low, p.z - half),
        max: Vec3::new(p.x + half, high, p.z + half),
    };
    let bounds = clips.iter().filter_map(at).map(boxed).fold(Aabb::EMPTY, Aabb::union);
    frame_bounds(&bounds, direction, FOV_Y, TILE[0] as f32 / TILE[1] as f32)
}
