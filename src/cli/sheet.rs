//! A contact sheet of a corpus: bodies from the views that show their place, beside what the networks see.

use std::path::Path;
use std::sync::Arc;

use anyhow::Context as _;

use super::corpus::{read_room, read_room_model};
use crate::body::Body;
use crate::generate::sensor::{MAX_DEPTH_M, SIDE};
use crate::job::Seed;
use crate::learn::corpus::{CorpusPerson, CorpusView, Manifest, RoomEntry};
use crate::render::{BodySurface, Cutaway, PersonDraw, Picture, Quality, SceneDraw, render_on_processor};
use crate::scene::{PersonId, Room, Scene};

use rand::RngExt as _;

/// Side of a body's picture; depth and labels beside it are half as large.
const PICTURE: usize = 2 * SIDE;
/// Width of one sample on the sheet.
const TILE: usize = PICTURE + SIDE;
/// Samples side by side.
const COLUMNS: usize = 6;

/// `count` samples drawn from the whole corpus, rooms evenly.
///
/// # Errors
/// When a room can't be read or drawn.
pub fn contact_sheet(folder: &Path, manifest: &Manifest, count: usize) -> anyhow::Result<Picture> {
    let shown: Vec<&RoomEntry> = manifest.rooms.iter().filter(|r| r.views > 0).collect();
    anyhow::ensure!(!shown.is_empty(), "the corpus has no views to draw");
    let rows = count.div_ceil(COLUMNS);
    let (width, height) = (COLUMNS.min(count) * TILE, rows * PICTURE);
    let mut sheet = Picture::blank([width, height]);
    let surface = Arc::new(BodySurface::of(Body::bundled()));
    let mut rng = Seed::root(manifest.seed).child("sheet", 0).rng();
    for number in 0..count {
        let entry = shown[number * shown.len() / count];
        let room = read_room(folder, entry)?;
        let view = &room.views[rng.random_range(0..room.views.len())];
        let person = room.people.get(view.body).context("a view of nobody")?;
        let scene = Arc::new(read_room_model(folder, entry)?);
        let picture = portrait(&scene, person, view, &surface)?;
        let corner = [number % COLUMNS * TILE, number / COLUMNS * PICTURE];
        paste(&mut sheet, corner, PICTURE, |x, y| pixel(&picture.rgba, y * PICTURE + x));
        let beside = [corner[0] + PICTURE, corner[1]];
        paste(&mut sheet, beside, SIDE, |x, y| grey(view.depth_mm[y * SIDE + x]));
        paste(&mut sheet, [beside[0], beside[1] + SIDE], SIDE, |x, y| hue(view.labels[y * SIDE + x]));
        sheet.backend = picture.backend;
    }
    Ok(sheet)
}

/// The body in its room from the view.
fn portrait(
    room: &Arc<Room>,
    person: &CorpusPerson,
    view: &CorpusView,
    surface: &Arc<BodySurface>,
) -> anyhow::Result<Picture> {
    let body = Body::bundled();
    let mut draw = SceneDraw::of_room(&Scene { room: room.clone(), ..Scene::default() });
    draw.body = Some(surface.clone());
    let vertices = body.pose(&person.params(body)).vertices;
    draw.people = vec![PersonDraw::new(PersonId(0), vertices.into(), view.body as u32)];
    draw.look.quality = Quality::Low;
    draw.look.cutaway = Cutaway::Off;
    Ok(render_on_processor(&draw, &view.view.to_camera(2.0), [PICTURE as u32; 2])?)
}

fn paste(sheet: &mut Picture, [left, top]: [usize; 2], side: usize, color: impl Fn(usize, usize) -> [u8; 4]) {
    for (x, y) in (0..side).flat_map(|y| (0..side).map(move |x| (x, y))) {
        let at = 4 * ((top + y) * sheet.width as usize + left + x);
        sheet.rgba[at..at + 4].copy_from_slice(&color(x, y));
    }
}

fn pixel(rgba: &[u8], at: usize) -> [u8; 4] {
    std::array::from_fn(|k| rgba[4 * at + k])
}

/// Near is light, nothing is black.
fn grey(depth_mm: u16) -> [u8; 4] {
    let share = f32::from(depth_mm) / (MAX_DEPTH_M * 1000.0);
    let light = if depth_mm == 0 { 0.0 } else { 255.0 * (1.0 - 0.85 * share.min(1.0)) };
    [light as u8, light as u8, light as u8, 255]
}

/// A colour for each label; black for none.
fn hue(label: u8) -> [u8; 4] {
    let mixed = u32::from(label).wrapping_mul(0x9E37_79B1);
    let part = |shift: u32| ((mixed >> shift) & 0x7f) as u8 + 96;
    if label == 0 { [0, 0, 0, 255] } else { [part(8), part(16), part(24), 255] }
}
