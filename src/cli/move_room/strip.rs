//! A picture strip of motions: two pictures a second, each following the people, from two opposite sides.

use std::sync::Arc;

use glam::{Quat, Vec3};

use crate::assets;
use crate::body::Body;
use crate::cli::output::OutputFolder;
use crate::cli::screens::Screens;
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
/// Where walls or furniture are in the way the camera goes around the person in such steps, at most so many to either
/// side: the two strips stay on their own sides.
const TURN: f32 = 0.35;
const TURNS: i32 = 4;
/// And looks down more steeply in the end.
const STEEP: f32 = 1.6;
/// It stays where it is while it sees this share of the person.
const ENOUGH: f32 = 0.6;
/// Heights over and under the pelvis that should be seen, metres.
const SEEN_M: [f32; 3] = [-0.3, 0.15, 0.5];

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
    let screens = Screens::of(room);
    for (file, direction) in FROM {
        let film =
            Film { scene: scene.clone(), clips: clips.to_vec(), camera: Camera::default(), size: TILE, fps };
        let strip = strip(film, direction, &screens, &painter)?;
        folder.write(file, &assets::encode_png(strip.width, strip.height, &strip.rgba)?)?;
    }
    Ok(painter.backend().to_owned())
}

fn strip(mut film: Film, side: Vec3, screens: &Screens, painter: &Painter) -> anyhow::Result<Picture> {
    let mut direction = side;
    let count = film.pictures();
    let columns = COLUMNS.min(count);
    let [width, height] = TILE.map(|side| side as usize);
    let mut sheet = Picture::blank([columns * width, count.div_ceil(columns) * height]);
    for number in 0..count {
        let seconds = number as f32 / film.fps;
        direction = clear_direction(&film.clips, seconds, side, direction, screens);
        film.camera = camera(&film.clips, seconds, direction);
        let picture = film.draw(painter, number)?;
        sheet.paste([number % columns * width, number / columns * height], &picture);
    }
    sheet.backend = painter.backend().to_owned();
    Ok(sheet)
}

/// Where everybody is who moves at a time.
fn pelves(clips: &[Arc<Clip>], seconds: f32) -> impl Iterator<Item = Vec3> {
    clips.iter().filter_map(move |clip| clip.frames.get(clip.frame_at(seconds)).map(|f| f.translation))
}

/// The last direction while people are seen from there, else the best one on this side of them.
fn clear_direction(clips: &[Arc<Clip>], seconds: f32, side: Vec3, last: Vec3, screens: &Screens) -> Vec3 {
    let points: Vec<Vec3> = pelves(clips, seconds).flat_map(|p| SEEN_M.map(|up| p + Vec3::Y * up)).collect();
    let seen = |direction: Vec3| screens.seen(&camera(clips, seconds, direction), &points);
    let turned = |(steps, steep): (i32, f32)| {
        let way = Quat::from_rotation_y(steps as f32 * TURN) * side;
        Vec3::new(way.x, way.y * steep, way.z)
    };
    let near_first = (0..=TURNS).flat_map(|k| [k, -k]);
    let others = [1.0, STEEP].into_iter().flat_map(|steep| near_first.clone().map(move |k| (k, steep)));
    let mut best = (last, seen(last));
    for direction in others.map(turned) {
        if best.1 >= ENOUGH {
            break;
        }
        let share = seen(direction);
        if share > best.1 {
            best = (direction, share);
        }
    }
    best.0
}

/// Sees everybody who moves, from one direction.
fn camera(clips: &[Arc<Clip>], seconds: f32, direction: Vec3) -> Camera {
    let (half, low, high) = AROUND_M;
    let boxed = |p: Vec3| Aabb {
        min: Vec3::new(p.x - half, low, p.z - half),
        max: Vec3::new(p.x + half, high, p.z + half),
    };
    let bounds = pelves(clips, seconds).map(boxed).fold(Aabb::EMPTY, Aabb::union);
    frame_bounds(&bounds, direction, FOV_Y, TILE[0] as f32 / TILE[1] as f32)
}
