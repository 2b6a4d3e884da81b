//! The empty room: outline, height, doors, windows with curtains.

use std::collections::BTreeMap;

use glam::Vec2;

use super::dice::{Dice, millimetres};
use super::group::{Furnishing, quarters_of};
use super::palette::{PAINT, Palette};
use super::plan::{AtWall, Plan, Rect, WallLine};
use crate::scene::layout::{Door, Item, Layout, Outline, Placement, Skirting, Window};

/// Floor before a door that stays free: the door's own swing.
const DOOR_FREE_M: f32 = 0.9;
/// Nothing of a wall's openings comes nearer to its ends.
const TO_CORNER_M: f32 = 0.25;
/// How far a drawn curtain reaches to either side of its window.
const CURTAIN_M: f32 = 0.42;

/// Sizes that a kind of room comes in.
#[derive(Clone, Copy, Debug)]
pub struct Sizes {
    /// Least and most of the longer side.
    pub width_m: (f32, f32),
    /// Least and most of the shorter side.
    pub depth_m: (f32, f32),
    /// How many of a hundred are L-shaped where the size allows.
    pub l_shaped: u32,
    /// Most windows.
    pub windows: usize,
}

/// The shell as a layout without furniture, and what is left of its floor.
pub fn building(dice: &mut Dice, name: &str, sizes: &Sizes, palette: &Palette) -> (Layout, Furnishing) {
    let size = Vec2::new(
        dice.between(sizes.width_m.0, sizes.width_m.1),
        dice.between(sizes.depth_m.0, sizes.depth_m.1),
    );
    let size = if dice.chance(50) { size } else { Vec2::new(size.y, size.x) };
    let bounds = Rect::around(Vec2::ZERO, size);
    let cut = (size.min_element() > 3.9 && dice.chance(sizes.l_shaped)).then(|| cut_corner(dice, bounds));
    let corners = corners(bounds, cut);
    let plan = Plan::new(bounds, cut, &corners);
    let outline = match cut {
        None => Outline::Box(size.x, size.y),
        Some(_) => Outline::Polygon(corners.iter().map(|c| (millimetres(c.x), millimetres(c.y))).collect()),
    };
    let mut layout = Layout {
        name: name.to_owned(),
        outline,
        height_m: dice.between(2.4, 3.0),
        wall_thickness_m: 0.1,
        floor: palette.floor,
        walls: palette.walls,
        accent_walls: BTreeMap::new(),
        ceiling: PAINT,
        skirting: Some(Skirting { height_m: 0.08, depth_m: 0.015, color: PAINT }),
        windows: Vec::new(),
        doors: Vec::new(),
        furniture: Vec::new(),
    };
    if dice.chance(60) {
        layout.accent_walls.insert(dice.count(0, plan.walls.len() - 1), palette.accent);
    }
    let mut room = Furnishing::new(plan);
    doors(dice, &mut layout, &mut room);
    windows(dice, &mut layout, &mut room, sizes.windows, palette);
    (layout, room)
}

/// A quarter to two fifths of each side, at one of the four corners.
fn cut_corner(dice: &mut Dice, bounds: Rect) -> Rect {
    let size = bounds.size();
    let cut =
        Vec2::new(dice.between(size.x * 0.25, size.x * 0.42), dice.between(size.y * 0.25, size.y * 0.42));
    let corner = Vec2::new(
        if dice.chance(50) { bounds.min.x } else { bounds.max.x },
        if dice.chance(50) { bounds.min.y } else { bounds.max.y },
    );
    Rect::of(corner, corner - cut * corner.signum())
}

/// Clockwise seen from above.
fn corners(bounds: Rect, cut: Option<Rect>) -> Vec<Vec2> {
    let (a, b) = (bounds.min, bounds.max);
    let all = [a, Vec2::new(b.x, a.y), b, Vec2::new(a.x, b.y)];
    let Some(cut) = cut else { return all.to_vec() };
    let n = all.len();
    all.iter()
        .enumerate()
        .flat_map(|(i, corner)| {
            if !cut.contains(*corner) {
                return vec![*corner];
            }
            let inner = cut.min + cut.max - *corner;
            let along = |other: Vec2| {
                if other.x == corner.x { Vec2::new(corner.x, inner.y) } else { Vec2::new(inner.x, corner.y) }
            };
            vec![along(all[(i + n - 1) % n]), inner, along(all[(i + 1) % n])]
        })
        .collect()
}

fn doors(dice: &mut Dice, layout: &mut Layout, room: &mut Furnishing) {
    let two = room.plan.area_m2() > 16.0 && dice.chance(35);
    let wanted = if two { 2 } else { 1 };
    for _ in 0..60 {
        if layout.doors.len() == wanted {
            break;
        }
        let wall = dice.count(0, room.plan.walls.len() - 1);
        let line = room.plan.walls[wall];
        let width_m = dice.between(0.8, 1.0);
        let to_end = TO_CORNER_M + width_m * 0.5;
        if line.length < 2.0 * to_end || layout.doors.iter().any(|d| d.wall == wall) {
            continue;
        }
        // Doors are near corners more often than not.
        let at_m = match dice.count(0, 3) {
            0 => to_end,
            1 => line.length - to_end,
            _ => dice.between(to_end, line.length - to_end),
        };
        let at_m = millimetres(at_m);
        let before = strip(line, at_m, width_m + 0.1, DOOR_FREE_M);
        if !room.plan.holds(before.grown(-0.001)) {
            continue;
        }
        room.plan.clear.push(before);
        room.plan.doors.push(line.from + line.along * at_m + line.inward * 0.45);
        let half = width_m * 0.5 + 0.1;
        room.plan.at_walls.push(AtWall { wall, from: at_m - half, to: at_m + half, bottom: 0.0, top: 2.2 });
        layout.doors.push(Door { wall, at_m, width_m, height_m: dice.between(2.0, 2.1), color: PAINT });
    }
}

/// The floor before a stretch of a wall.
fn strip(line: WallLine, at: f32, width: f32, depth: f32) -> Rect {
    let middle = line.from + line.along * at;
    let half = line.along * width * 0.5;
    Rect::of(middle - half, middle + half + line.inward * depth)
}

fn windows(dice: &mut Dice, layout: &mut Layout, room: &mut Furnishing, most: usize, palette: &Palette) {
    let wanted = dice.count(1, most);
    let sill_m = *dice.pick(&[0.1, 0.6, 0.75, 0.85, 0.9, 1.0]);
    let curtains = dice.chance(55);
    for _ in 0..40 {
        if layout.windows.len() >= wanted {
            break;
        }
        let wall = dice.count(0, room.plan.walls.len() - 1);
        let line = room.plan.walls[wall];
        let width_m = dice.between(0.8, 2.2);
        let side_m = if curtains { CURTAIN_M + 0.08 } else { 0.08 };
        let to_end = TO_CORNER_M + side_m + width_m * 0.5;
        if line.length < 2.0 * to_end {
            continue;
        }
        let at_m =
            millimetres(dice.between(to_end, line.length - to_end).clamp(to_end, line.length - to_end));
        let height_m = millimetres((layout.height_m - 0.3).min(2.25) - sill_m);
        let half = width_m * 0.5;
        let stretch = AtWall { wall, from: at_m - half, to: at_m + half, bottom: sill_m - 0.05, top: 2.35 };
        let wide = AtWall { from: stretch.from - side_m, to: stretch.to + side_m, bottom: 0.0, ..stretch };
        if room.is_behind(&wide, 0.05) {
            continue;
        }
        layout.windows.push(Window { wall, at_m, sill_m, width_m, height_m, color: PAINT });
        room.plan.at_walls.push(stretch);
        if curtains {
            hang_curtains(room, layout.height_m, line, &stretch, palette);
        }
    }
}

/// A rod over the window and a curtain on either side.
fn hang_curtains(room: &mut Furnishing, height_m: f32, line: WallLine, window: &AtWall, palette: &Palette) {
    let rod_m = millimetres((height_m - 0.06).min(2.36));
    let yaw_deg = (90.0 * f32::from(quarters_of(line.inward)) + 180.0).rem_euclid(360.0) - 180.0;
    let middle = (window.from + window.to) * 0.5;
    let wide = CURTAIN_M - 0.02;
    let mut hang = |name: &str, item: Item, along: f32, out: f32, y: f32| {
        let p = line.from + line.along * along + line.inward * out;
        let name = room.name(name);
        room.placements.push(Placement {
            item,
            name,
            category: "curtain".into(),
            at: (millimetres(p.x), y, millimetres(p.y)),
            yaw_deg,
            scale: 1.0,
            on: None,
            tint: None,
            finish: BTreeMap::new(),
        });
    };
    let length_m = millimetres(window.to - window.from + 2.0 * CURTAIN_M - 0.1);
    hang("Curtain rod", Item::Rod { length_m, color: palette.wood_2 }, middle, 0.0, rod_m - 0.04);
    let size = (wide, rod_m - 0.06);
    for at in [window.from - CURTAIN_M * 0.5, window.to + CURTAIN_M * 0.5] {
        hang("Curtain", Item::Curtain { size, color: palette.linen }, at, 0.03, 0.02);
    }
    for at in [window.from - CURTAIN_M * 0.5, window.to + CURTAIN_M * 0.5] {
        let (from, to) = (at - wide * 0.5, at + wide * 0.5);
        room.plan.solids.push(strip(line, at, wide, 0.1));
        room.plan.at_walls.push(AtWall { wall: window.wall, from, to, bottom: 0.0, top: 2.35 });
    }
    // Nothing as high as the rod stands under it.
    room.plan.at_walls.push(AtWall {
        from: window.from - CURTAIN_M,
        to: window.to + CURTAIN_M,
        bottom: rod_m - 0.1,
        top: rod_m + 0.1,
        ..*window
    });
}
