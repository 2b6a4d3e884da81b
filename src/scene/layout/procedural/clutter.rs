//! What people leave on tables and shelves.

use std::collections::BTreeMap;

use glam::Vec2;

use super::dice::{Dice, millimetres};
use super::group::{Clutter, Furnishing, Thing};
use super::palette;
use super::plan::Rect;
use super::stock::{self, Stock};
use crate::scene::layout::Placement;

/// Nothing stands nearer to a table's edge.
const TO_EDGE_M: f32 = 0.04;
/// Places tried for each thing.
const TRIES: usize = 8;

/// Puts things on every top that takes them.
pub fn clutter(dice: &mut Dice, room: &mut Furnishing) {
    for index in 0..room.tops.len() {
        let kind = room.tops[index].clutter;
        let count = match kind {
            Clutter::Dining | Clutter::Round => dice.count(0, 6),
            Clutter::Desk | Clutter::Kitchen | Clutter::Coffee | Clutter::Chest => dice.count(0, 4),
            Clutter::Night => dice.count(0, 1),
            Clutter::Children => dice.count(0, 3),
        };
        for _ in 0..count {
            let thing = something(dice, kind);
            put(dice, room, index, thing);
        }
    }
}

fn of(dice: &mut Dice, list: &[Stock], category: &'static str) -> Thing {
    let stock = *dice.pick(list);
    let name = stock.file.split("__").next().unwrap_or("thing").replace('_', " ");
    let scale = dice.between(0.9, 1.15);
    Thing::model(&stock, &capital(&name), category, scale)
}

fn capital(name: &str) -> String {
    let mut letters = name.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

fn something(dice: &mut Dice, kind: Clutter) -> Thing {
    let pick = dice.count(0, 9);
    match (kind, pick) {
        (Clutter::Dining | Clutter::Round | Clutter::Kitchen, 0..=7) => of(dice, stock::TABLEWARE, "objects"),
        (Clutter::Chest, 0..=1) => of(dice, stock::LINEN, "objects"),
        (Clutter::Night | Clutter::Desk | Clutter::Children, 5..=9)
        | (Clutter::Coffee, 5..=7)
        | (Clutter::Chest, 2..=4) => books(dice),
        (Clutter::Coffee | Clutter::Night, 0..=4) | (Clutter::Desk | Clutter::Children, _) => {
            of(dice, stock::SMALL_THINGS, "objects")
        }
        _ => of(dice, stock::DECORATION, "objects"),
    }
}

fn books(dice: &mut Dice) -> Thing {
    // The lowest book is the largest: 25 by 18 cm, turned by up to 8 degrees in its stack.
    Thing::made(palette::books(dice), "Books", "objects", (0.28, 0.1, 0.22))
}

fn put(dice: &mut Dice, room: &mut Furnishing, index: usize, thing: Thing) {
    // Things are turned freely: the square about the circle about them.
    let side = Vec2::splat(thing.size.x.hypot(thing.size.z) * 1.02);
    let top = &room.tops[index];
    let free = top.rect.size() * 0.5 - side * 0.5 - TO_EDGE_M;
    if free.min_element() < 0.0 {
        return;
    }
    let spot = (0..TRIES).find_map(|_| {
        let mut away = Vec2::new(dice.between(-free.x, free.x), dice.between(-free.y, free.y));
        if top.clutter == Clutter::Round {
            away *= std::f32::consts::FRAC_1_SQRT_2;
        }
        let rect = Rect::around(top.rect.center() + away, side);
        (!top.taken.iter().any(|t| t.meets(rect))).then_some(rect)
    });
    let Some(rect) = spot else { return };
    let yaw_deg = (top.yaw_deg + dice.between(-40.0, 40.0) + 180.0).rem_euclid(360.0) - 180.0;
    let on = Some(top.name.clone());
    let name = room.name(&thing.name);
    let at = rect.center();
    room.tops[index].taken.push(rect);
    room.placements.push(Placement {
        item: thing.item,
        name,
        category: thing.category.into(),
        at: (millimetres(at.x), 0.0, millimetres(at.y)),
        yaw_deg,
        scale: thing.scale,
        on,
        tint: thing.tint,
        finish: BTreeMap::new(),
    });
}
