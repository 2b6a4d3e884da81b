//! Groups of furniture by what people do there, with the distances that furnishing handbooks give.

use glam::Vec2;

use super::dice::Dice;
use super::group::{Clutter, Group, Held, Thing};
use super::palette::{Palette, SHADE};
use super::plan::Rect;
use super::stock::{self, Stock};
use crate::scene::layout::{Item, Srgb};

/// From a sofa's front to its coffee table: room for shins, near enough to reach a cup.
const SOFA_TO_TABLE_M: (f32, f32) = (0.38, 0.5);
/// From a table's edge to the chair at it, the chair not pushed in.
const CHAIR_TO_TABLE_M: (f32, f32) = (0.02, 0.14);
/// Width that somebody takes at a table.
const PLACE_M: f32 = 0.62;
/// Free floor before cupboards and drawers.
const DOOR_SWING_M: f32 = 0.6;

/// A model, its size varied by some percent, its colour too where that looks right.
fn any_of(dice: &mut Dice, list: &[Stock], name: &str, category: &'static str, palette: &Palette) -> Thing {
    let stock = *dice.pick(list);
    let scale = dice.between(0.95, 1.05);
    let color = (stock.pale && dice.chance(50)).then_some(lighter(palette.fabric_2));
    Thing::model(&stock, name, category, scale).tinted(color)
}

/// Halfway to white: what multiplies a model's own colour.
fn lighter(c: Srgb) -> Srgb {
    let half = |v: u8| 128 + v / 2;
    Srgb(half(c.0), half(c.1), half(c.2))
}

/// A straight sofa: a model or one made to measure.
pub fn sofa(dice: &mut Dice, palette: &Palette, widest_m: f32) -> Thing {
    if dice.chance(60) {
        let thing = any_of(dice, stock::SOFAS, "Sofa", "couch", palette);
        if thing.size.x <= widest_m {
            return thing;
        }
    }
    let seats = dice.count(2, 3) as u8;
    let arm_m = *dice.pick(&[0.0, 0.12, 0.16, 0.22]);
    let wide = (f32::from(seats) * dice.between(0.58, 0.72) + 2.0 * arm_m).min(widest_m.max(1.3));
    let size = (wide, dice.between(0.7, 0.92), dice.between(0.8, 0.98));
    let seat_m = dice.between(0.38, 0.47);
    let item = Item::Sofa { size, seat_m, seats, arm_m, fabric: palette.fabric, wood: palette.wood };
    Thing::made(item, "Sofa", "couch", size)
}

pub fn armchair(dice: &mut Dice, palette: &Palette) -> Thing {
    if dice.chance(70) {
        return any_of(dice, stock::ARMCHAIRS, "Armchair", "chair", palette);
    }
    let arm_m = *dice.pick(&[0.1, 0.14, 0.18]);
    let size = (dice.between(0.56, 0.64) + 2.0 * arm_m, dice.between(0.72, 0.95), dice.between(0.76, 0.9));
    let seat_m = dice.between(0.38, 0.46);
    let item = Item::Sofa { size, seat_m, seats: 1, arm_m, fabric: palette.fabric_2, wood: palette.wood };
    Thing::made(item, "Armchair", "chair", size)
}

fn table(
    dice: &mut Dice,
    palette: &Palette,
    name: &str,
    category: &'static str,
    size: (f32, f32, f32),
) -> Thing {
    let legs = if dice.chance(50) { palette.wood_2 } else { palette.wood };
    Thing::made(Item::Table { size, top: palette.wood, legs }, name, category, size)
}

fn coffee_table(dice: &mut Dice, palette: &Palette) -> Thing {
    if dice.chance(60) {
        return any_of(dice, stock::COFFEE_TABLES, "Coffee table", "coffee table", palette);
    }
    let size = (dice.between(0.7, 1.2), dice.between(0.36, 0.5), dice.between(0.5, 0.75));
    table(dice, palette, "Coffee table", "coffee table", size)
}

fn side_table(dice: &mut Dice, palette: &Palette) -> Thing {
    let size = (dice.between(0.4, 0.5), dice.between(0.45, 0.58), dice.between(0.4, 0.5));
    table(dice, palette, "Side table", "table", size)
}

fn rug(dice: &mut Dice, palette: &Palette, size: (f32, f32)) -> Thing {
    let (color, border) =
        if dice.chance(50) { (palette.linen, palette.accent) } else { (palette.accent, palette.linen) };
    Thing::made(Item::Rug { size, color, border }, "Rug", "objects", (size.0, 0.009, size.1))
}

fn table_lamp(dice: &mut Dice, palette: &Palette) -> Thing {
    if dice.chance(35) {
        return any_of(dice, stock::DESK_LAMPS, "Lamp", "lighting", palette);
    }
    let height_m = dice.between(0.34, 0.52);
    let item = Item::Lamp { height_m, shade: SHADE, stand: palette.wood_2 };
    Thing::made(item, "Lamp", "lighting", (0.68 * height_m, height_m, 0.68 * height_m))
}

pub fn floor_lamp(dice: &mut Dice, palette: &Palette) -> Group {
    let height_m = dice.between(1.4, 1.75);
    let item = Item::Lamp { height_m, shade: SHADE, stand: palette.wood_2 };
    let mut group = Group::default();
    group.stand(Thing::made(item, "Floor lamp", "lighting", (0.43, height_m, 0.43)), 0.0, 0.215, 0.0);
    group
}

pub fn plant(dice: &mut Dice) -> Group {
    let scale = dice.between(0.8, 1.6);
    let thing = Thing::model(dice.pick(stock::PLANTS), "Plant", "plant", scale);
    let mut group = Group::default();
    group.stand(thing.clone(), 0.0, thing.size.z * 0.5, 0.0);
    group
}

/// A sofa with coffee table, rug, and armchairs at its sides; its back at z = 0.
pub fn sofa_corner(dice: &mut Dice, palette: &Palette, widest_m: f32, roomy: bool) -> Group {
    let mut group = Group::default();
    let corner = roomy && widest_m > 2.8 && dice.chance(25);
    let sofa = if corner {
        let fitting: Vec<Stock> =
            stock::CORNER_SOFAS.iter().filter(|s| s.size.0 * 1.05 < widest_m).copied().collect();
        any_of(dice, &fitting, "Sofa", "couch", palette)
    } else {
        sofa(dice, palette, widest_m)
    };
    let size = sofa.size;
    group.stand(sofa, 0.0, size.z * 0.5, 0.0);
    let gap = dice.between(SOFA_TO_TABLE_M.0, SOFA_TO_TABLE_M.1);
    group.clear.push(Rect::of(Vec2::new(-size.x * 0.5, size.z), Vec2::new(size.x * 0.5, size.z + 0.3)));
    group.reach.push(Vec2::new(size.x * 0.5 - 0.2, size.z + 0.2));
    if corner || dice.chance(12) {
        return group;
    }
    let table = coffee_table(dice, palette);
    let (deep, wide) = (table.size.z, table.size.x);
    let middle = size.z + gap + deep * 0.5;
    let on_rug = dice.chance(65).then(|| {
        let rug = rug(dice, palette, (wide.max(size.x * 0.85) + 0.3, deep + gap + 0.5));
        group.add(rug, Vec2::new(0.0, middle), 0.0, Held::Flat)
    });
    let held = on_rug.map_or(Held::Floor, Held::Rug);
    let base = group.add(table, Vec2::new(0.0, middle), 0.0, held);
    group.tops.push((base, Clutter::Coffee));
    if roomy {
        armchairs_beside(dice, palette, &mut group, middle, wide);
    }
    if dice.chance(20) {
        let pouf = pouf_thing(dice, palette);
        let z = middle + deep * 0.5 + 0.35 + pouf.size.z * 0.5;
        group.stand(pouf, dice.between(-0.3, 0.3), z, 0.0);
    }
    group
}

/// One or two armchairs beside a coffee table, turned to it.
fn armchairs_beside(dice: &mut Dice, palette: &Palette, group: &mut Group, z: f32, table_wide: f32) {
    let both = [-1.0, 1.0];
    let sides: &[f32] = match dice.count(0, 3) {
        0 => &[],
        1 => &both[..1],
        2 => &both[1..],
        _ => &both,
    };
    let chair = armchair(dice, palette);
    for side in sides {
        let turn = dice.between(-12.0, 12.0);
        let x = table_wide * 0.5 + 0.42 + chair.size.z * 0.5 + 0.08;
        group.stand(chair.clone(), side * x, z + dice.between(-0.05, 0.2), -side * 90.0 + turn);
    }
}

fn pouf_thing(dice: &mut Dice, palette: &Palette) -> Thing {
    let side = dice.between(0.4, 0.6);
    let size = (side, dice.between(0.34, 0.46), side);
    Thing::made(Item::Pouf { size, fabric: palette.fabric_2 }, "Pouf", "stool", size)
}

/// A pouf, a low stool or a bench by itself.
pub fn extra_seat(dice: &mut Dice, palette: &Palette) -> Group {
    let thing = match dice.count(0, 3) {
        0 => any_of(dice, stock::LOW_STOOLS, "Stool", "stool", palette),
        1 => bench_thing(dice, palette),
        _ => pouf_thing(dice, palette),
    };
    let mut group = Group::default();
    group.stand(thing.clone(), 0.0, thing.size.z * 0.5 + 0.02, 0.0);
    group.reach.push(Vec2::new(0.0, thing.size.z + 0.3));
    group
}

pub fn bench_thing(dice: &mut Dice, palette: &Palette) -> Thing {
    if dice.chance(35) {
        return any_of(dice, stock::BENCHES, "Bench", "seating", palette);
    }
    let size = (dice.between(0.9, 1.5), dice.between(0.42, 0.5), dice.between(0.36, 0.46));
    let item = Item::Bench { size, fabric: palette.fabric_2, wood: palette.wood };
    Thing::made(item, "Bench", "seating", size)
}

/// A screen over or on its stand, to be looked at from +z.
pub fn television(dice: &mut Dice, palette: &Palette) -> Group {
    let mut group = Group::default();
    let stand = if dice.chance(60) {
        any_of(dice, stock::TV_STANDS, "TV stand", "cabinet", palette)
    } else {
        let size = (dice.between(1.2, 1.8), dice.between(0.36, 0.55), dice.between(0.38, 0.45));
        let doors = dice.count(2, 4) as u8;
        let item = Item::Wardrobe { size, doors, case: palette.wood, front: palette.wood_2 };
        Thing::made(item, "TV stand", "cabinet", size)
    };
    let (deep, top) = (stand.size.z, stand.size.y);
    group.stand(stand, 0.0, deep * 0.5, 0.0);
    let scale = dice.between(0.9, 1.2);
    let tv = Thing::model(dice.pick(stock::TVS), "Television", "tv monitor", scale);
    let z = tv.size.z * 0.5 - 0.02;
    group.add(tv, Vec2::new(0.0, z), 0.0, Held::Hung(top + dice.between(0.12, 0.3)));
    group.clear.push(Rect::of(Vec2::new(-0.5, deep), Vec2::new(0.5, deep + 0.4)));
    group
}

/// An armchair with a small table, to read in.
pub fn reading_place(dice: &mut Dice, palette: &Palette) -> Group {
    let mut group = Group::default();
    let chair = armchair(dice, palette);
    let (half, deep) = (chair.size.x * 0.5, chair.size.z);
    group.stand(chair, 0.0, deep * 0.5 + 0.06, dice.between(-8.0, 8.0));
    group.clear.push(Rect::of(Vec2::new(-half, deep + 0.12), Vec2::new(half, deep + 0.4)));
    group.reach.push(Vec2::new(0.0, deep + 0.45));
    if dice.chance(55) {
        let side = if dice.chance(50) { 1.0 } else { -1.0 };
        let table = side_table(dice, palette);
        let x = half + 0.14 + table.size.x * 0.5;
        let base = group.stand(table.clone(), side * x, table.size.z * 0.5 + 0.05, 0.0);
        group.tops.push((base, Clutter::Night));
        if dice.chance(60) {
            let lamp = table_lamp(dice, palette);
            group.add(lamp, Vec2::new(side * x, table.size.z * 0.5 - 0.02), 0.0, Held::On(base));
        }
    }
    group
}

/// How a bed is made and where it stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BedKind {
    Double,
    Single,
    Child,
}

fn bed(dice: &mut Dice, palette: &Palette, kind: BedKind) -> Thing {
    if kind == BedKind::Double && dice.chance(40) {
        return any_of(dice, stock::BEDS, "Bed", "bed", palette);
    }
    let (wide, deep) = match kind {
        BedKind::Double => (dice.between(1.4, 1.85), dice.between(2.05, 2.15)),
        BedKind::Single => (dice.between(0.9, 1.15), dice.between(2.02, 2.12)),
        BedKind::Child => (dice.between(0.8, 0.9), dice.between(1.7, 2.0)),
    };
    let top = dice.between(0.4, 0.58);
    let size = (wide, top, deep);
    let headboard_m = *dice.pick(&[0.0, 0.85, 1.0, 1.15]);
    let item = Item::Bed { size, headboard_m, cover: palette.linen, wood: palette.wood };
    let mut thing = Thing::made(item, "Bed", "bed", size);
    thing.size.y = headboard_m.max(top);
    thing
}

/// A bed with its head at the wall, nightstands, pillows and a rug.
pub fn bed_corner(dice: &mut Dice, palette: &Palette, kind: BedKind, stands: usize) -> Group {
    let mut group = Group::default();
    let bed = bed(dice, palette, kind);
    let (half, deep, made) = (bed.size.x * 0.5, bed.size.z, matches!(bed.item, Item::Bed { .. }));
    let base = group.stand(bed, 0.0, deep * 0.5, 0.0);
    pillows(dice, palette, &mut group, base, if made { 0.32 } else { 0.38 });
    let first = if dice.chance(50) { 1.0 } else { -1.0 };
    for side in [first, -first].into_iter().take(stands) {
        let stand = any_of(dice, stock::NIGHTSTANDS, "Nightstand", "cabinet", palette);
        let x = side * (half + 0.06 + stand.size.x * 0.5);
        let (z, wide) = (stand.size.z * 0.5, stand.size.x);
        let stand = group.stand(stand, x, z, 0.0);
        group.tops.push((stand, Clutter::Night));
        if dice.chance(75) {
            let lamp = table_lamp(dice, palette);
            group.add(lamp, Vec2::new(x, z - 0.03), 0.0, Held::On(stand));
        }
        let (near, far) = (side * half, side * (half + wide.max(0.5)));
        group.clear.push(Rect::of(Vec2::new(near, 0.6), Vec2::new(far, deep)));
        group.reach.push(Vec2::new(side * (half + 0.3), deep * 0.55));
    }
    if stands == 0 {
        group.clear.push(Rect::of(Vec2::new(first * half, 0.5), Vec2::new(first * (half + 0.5), deep)));
        group.reach.push(Vec2::new(first * (half + 0.3), deep * 0.55));
    }
    if dice.chance(40) && kind != BedKind::Child {
        let size = (2.0 * half - 0.1, dice.between(0.7, 1.0));
        group.add(rug(dice, palette, size), Vec2::new(0.0, deep + size.1 * 0.5 + 0.03), 0.0, Held::Flat);
    }
    if kind == BedKind::Double && dice.chance(25) {
        let bench = bench_thing(dice, palette);
        if bench.size.x < 2.0 * half {
            group.stand(bench.clone(), 0.0, deep + 0.05 + bench.size.z * 0.5, 0.0);
        }
    }
    group
}

/// A bed along the wall, like a sofa: its head to one side.
pub fn bed_along_wall(dice: &mut Dice, palette: &Palette, kind: BedKind) -> Group {
    let mut group = Group::default();
    let bed = bed(dice, palette, kind);
    let (half, deep) = (bed.size.z * 0.5, bed.size.x);
    let yaw = if dice.chance(50) { 90.0 } else { -90.0 };
    let base = group.stand(bed, 0.0, deep * 0.5, yaw);
    pillows(dice, palette, &mut group, base, 0.32);
    group.clear.push(Rect::of(Vec2::new(-half, deep), Vec2::new(half, deep + 0.5)));
    group.reach.push(Vec2::new(0.0, deep + 0.3));
    group
}

/// Pillows at the head of the bed, which looks along its own yaw.
fn pillows(dice: &mut Dice, palette: &Palette, group: &mut Group, bed: usize, from_head: f32) {
    let member = group.members[bed].clone();
    let size = member.thing.size;
    let (sin, cos) = f64::from(member.yaw_deg).to_radians().sin_cos();
    let turn = |v: Vec2| Vec2::new(v.x * cos as f32 + v.y * sin as f32, v.y * cos as f32 - v.x * sin as f32);
    let xs: &[f32] = if size.x > 1.3 { &[-0.25, 0.25] } else { &[0.0] };
    for x in xs {
        if dice.chance(15) {
            continue;
        }
        let cushion = (dice.between(0.5, 0.62).min(size.x * 0.62), dice.between(0.09, 0.14), 0.38);
        let item = Item::Cushion { size: cushion, color: palette.walls };
        let at = member.at + turn(Vec2::new(x * size.x, from_head - size.z * 0.5));
        let thing = Thing::made(item, "Pillow", "cushion", cushion);
        group.add(thing, at, member.yaw_deg, Held::On(bed));
    }
}

pub fn wardrobe(dice: &mut Dice, palette: &Palette) -> Group {
    let thing = if dice.chance(40) {
        any_of(dice, stock::WARDROBES, "Wardrobe", "cabinet", palette)
    } else {
        cupboard(dice, palette, "Wardrobe", [(0.42, 0.52), (1.9, 2.25), (0.55, 0.64)])
    };
    before_doors(thing)
}

/// A cupboard made to measure, of two to four doors: how wide a door, how high and how deep it may be, metres.
fn cupboard(dice: &mut Dice, palette: &Palette, name: &str, ranges: [(f32, f32); 3]) -> Thing {
    let doors = dice.count(2, 4);
    let [door_m, height_m, depth_m] = ranges.map(|(least, most)| dice.between(least, most));
    let size = (doors as f32 * door_m, height_m, depth_m);
    let item = Item::Wardrobe { size, doors: doors as u8, case: palette.wood, front: palette.wood_2 };
    let mut thing = Thing::made(item, name, "cabinet", size);
    // Handles stand out from the doors.
    thing.size.z += 0.05;
    thing
}

/// A cupboard with the floor before it kept free.
fn before_doors(thing: Thing) -> Group {
    let (half, deep) = (thing.size.x * 0.5, thing.size.z);
    let mut group = Group::default();
    group.stand(thing, 0.0, deep * 0.5, 0.0);
    group.clear.push(Rect::of(Vec2::new(-half, deep), Vec2::new(half, deep + DOOR_SWING_M)));
    group.reach.push(Vec2::new(0.0, deep + 0.4));
    group
}

pub fn chest(dice: &mut Dice, palette: &Palette) -> Group {
    let thing = if dice.chance(45) {
        any_of(dice, stock::DRESSERS, "Chest of drawers", "chest of drawers", palette)
    } else {
        cupboard(dice, palette, "Sideboard", [(0.38, 0.5), (0.72, 0.95), (0.4, 0.48)])
    };
    let mut group = before_doors(thing);
    group.tops.push((0, Clutter::Chest));
    if dice.chance(50) {
        let lamp = table_lamp(dice, palette);
        let reach = group.members[0].thing.size.x * 0.5 - 0.25;
        let x = if dice.chance(50) { reach } else { -reach };
        group.add(lamp, Vec2::new(x, 0.22), 0.0, Held::On(0));
    }
    group
}

/// One to three shelves side by side.
pub fn shelves(dice: &mut Dice, palette: &Palette, most: usize) -> Group {
    let mut group = Group::default();
    let thing = match dice.count(0, 9) {
        0..=5 => any_of(dice, stock::BOOKCASES, "Bookcase", "shelving", palette),
        6 => any_of(dice, stock::LOW_SHELVES, "Shelf", "shelving", palette),
        _ => {
            let boards = dice.count(3, 6);
            let size = (dice.between(0.7, 1.2), boards as f32 * 0.34, dice.between(0.28, 0.36));
            let item = Item::Shelf { size, boards: boards as u8, color: palette.wood };
            Thing::made(item, "Shelf", "shelving", size)
        }
    };
    let count = dice.count(1, most);
    let wide = thing.size.x + 0.02;
    for k in 0..count {
        let x = (k as f32 - (count - 1) as f32 * 0.5) * wide;
        let base = group.stand(thing.clone(), x, thing.size.z * 0.5, 0.0);
        if thing.size.y < 1.2 {
            group.tops.push((base, Clutter::Chest));
        }
    }
    let half = wide * count as f32 * 0.5;
    group.clear.push(Rect::of(Vec2::new(-half, thing.size.z), Vec2::new(half, thing.size.z + 0.5)));
    group.reach.push(Vec2::new(0.0, thing.size.z + 0.4));
    group
}

/// Where a desk stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeskKind {
    /// At the wall.
    AtWall,
    /// Before the wall, its user looks into the room.
    FacingRoom,
    /// At the wall, now and then a small one.
    Child,
}

/// A desk with its chair and what is worked with.
pub fn desk(dice: &mut Dice, palette: &Palette, kind: DeskKind) -> Group {
    let mut group = Group::default();
    let facing_room = kind == DeskKind::FacingRoom;
    let desk = if kind == DeskKind::Child && dice.chance(60) {
        any_of(dice, stock::KIDS_DESKS, "Desk", "office desk", palette)
    } else if dice.chance(65) {
        any_of(dice, stock::DESKS, "Desk", "office desk", palette)
    } else {
        let size = (dice.between(1.1, 1.8), dice.between(0.71, 0.77), dice.between(0.6, 0.85));
        table(dice, palette, "Desk", "office desk", size)
    };
    let chair = desk_chair(dice, palette);
    let (deep, half) = (desk.size.z, desk.size.x * 0.5);
    let gap = dice.between(0.04, 0.18);
    let turn = dice.between(-15.0, 15.0);
    let aside = dice.between(-0.15, 0.15);
    let room_behind = chair.size.x.max(chair.size.z) * 1.15;
    let (desk_z, chair_z, user) = if facing_room {
        let chair_z = 0.35 + room_behind * 0.5;
        (chair_z + room_behind * 0.5 + gap + deep * 0.5, chair_z, 180.0)
    } else {
        (deep * 0.5, deep + gap + room_behind * 0.5, 0.0)
    };
    let base = group.stand(desk, 0.0, desk_z, user);
    group.stand(chair, aside, chair_z, user + 180.0 + turn);
    group.tops.push((base, Clutter::Desk));
    computer(dice, palette, &mut group, base, user);
    let behind = if facing_room {
        (0.0, 0.3)
    } else {
        (chair_z + room_behind * 0.5, chair_z + room_behind * 0.5 + 0.3)
    };
    group.clear.push(Rect::of(Vec2::new(-half * 0.6, behind.0), Vec2::new(half * 0.6, behind.1)));
    if facing_room {
        group.reach.push(Vec2::new(half + 0.35, chair_z));
    } else {
        group.reach.push(Vec2::new(0.0, behind.1));
    }
    group
}

fn desk_chair(dice: &mut Dice, palette: &Palette) -> Thing {
    if dice.chance(75) {
        any_of(dice, stock::OFFICE_CHAIRS, "Office chair", "chair", palette)
    } else {
        any_of(dice, stock::CHAIRS, "Chair", "chair", palette)
    }
}

/// A screen with keyboard, or a laptop; `user_deg` is where its user looks from.
fn computer(dice: &mut Dice, palette: &Palette, group: &mut Group, desk: usize, user_deg: f32) {
    let size = group.members[desk].thing.size;
    let at = group.members[desk].at;
    let toward = if user_deg == 0.0 { 1.0 } else { -1.0 };
    let put = |group: &mut Group, thing: Thing, x: f32, z: f32| {
        group.add(thing, at + Vec2::new(x, z * toward), user_deg, Held::On(desk));
    };
    let taken_half_m;
    if dice.chance(55) {
        let width_m = dice.between(0.48, 0.64);
        let screens = if size.x > 1.5 && dice.chance(30) { 2 } else { 1 };
        for k in 0..screens {
            let x = (k as f32 - (screens - 1) as f32 * 0.5) * (width_m + 0.02);
            let monitor =
                Thing::made(Item::Monitor { width_m }, "Monitor", "tv monitor", (width_m, 0.45, 0.2));
            put(group, monitor, x, -size.z * 0.5 + 0.16);
        }
        taken_half_m = (screens as f32 * (width_m + 0.02)) * 0.5;
        let keyboard = Thing::made(Item::Keyboard, "Keyboard", "objects", (0.43, 0.02, 0.13));
        put(group, keyboard, 0.0, size.z * 0.5 - 0.24);
    } else {
        let laptop = Thing::made(Item::Laptop, "Laptop", "objects", (0.33, 0.23, 0.3));
        put(group, laptop, dice.between(-0.1, 0.1), 0.0);
        taken_half_m = 0.1 + 0.33 * 0.5;
    }
    if dice.chance(45) {
        let lamp = any_of(dice, stock::DESK_LAMPS, "Desk lamp", "lighting", palette);
        let side = if dice.chance(50) { 1.0 } else { -1.0 };
        let away_m = size.x * 0.5 - 0.22;
        // Small desks under wide screens have no place for a lamp.
        if away_m - lamp.size.x * 0.5 > taken_half_m {
            put(group, lamp, side * away_m, -size.z * 0.5 + 0.2);
        }
    }
}

/// A dining table with chairs around it, as many as it has places.
pub fn dining(dice: &mut Dice, palette: &Palette, largest_m: f32, height_m: f32) -> Group {
    let mut group = Group::default();
    let round = dice.chance(25);
    let table = if round {
        any_of(dice, stock::ROUND_TABLES, "Dining table", "dining table", palette)
    } else {
        rectangular_table(dice, palette, largest_m)
    };
    let size = table.size;
    let base = group.stand(table, 0.0, 0.0, 0.0);
    group.tops.push((base, if round { Clutter::Round } else { Clutter::Dining }));
    let chair = any_of(dice, stock::CHAIRS, "Chair", "chair", palette);
    if round {
        chairs_around(dice, &mut group, &chair, size.x * 0.5);
    } else {
        chairs_along(dice, palette, &mut group, &chair, Vec2::new(size.x, size.z));
    }
    let drop_m = height_m - dice.between(1.55, 1.75);
    if dice.chance(60) {
        let item = Item::Pendant { drop_m, shade: palette.accent };
        let lamp = Thing::made(item, "Pendant lamp", "lighting", (0.44, drop_m, 0.44));
        group.add(lamp, Vec2::ZERO, 0.0, Held::Hung(height_m - drop_m));
    }
    let bounds = group.bounds();
    group.reach.push(Vec2::new(bounds.max.x + 0.35, 0.0));
    group
}

fn rectangular_table(dice: &mut Dice, palette: &Palette, largest_m: f32) -> Thing {
    if dice.chance(60) {
        let thing = any_of(dice, stock::TABLES, "Dining table", "dining table", palette);
        if thing.size.x <= largest_m {
            return thing;
        }
    }
    let wide = dice.between(0.8, 2.2).min(largest_m.max(0.8));
    let size = (wide, dice.between(0.72, 0.77), dice.between(0.72, 0.98).min(wide));
    table(dice, palette, "Dining table", "dining table", size)
}

/// Chairs at both long sides, at the ends of some tables; a bench instead at one side of some.
fn chairs_along(dice: &mut Dice, palette: &Palette, group: &mut Group, chair: &Thing, table: Vec2) {
    let places = ((table.x - 0.1) / PLACE_M.max(chair.size.x + 0.06)).floor().max(1.0) as usize;
    let bench_side = dice.chance(18).then(|| bench_thing(dice, palette)).filter(|b| b.size.x < table.x + 0.2);
    for (side, yaw) in [(-1.0, 0.0), (1.0, 180.0)] {
        if let Some(bench) = bench_side.as_ref().filter(|_| side > 0.0) {
            let gap = dice.between(CHAIR_TO_TABLE_M.0, CHAIR_TO_TABLE_M.1);
            group.stand(bench.clone(), 0.0, side * (table.y * 0.5 + gap + bench.size.z * 0.5), yaw);
            continue;
        }
        for k in 0..places {
            let x = (k as f32 - (places - 1) as f32 * 0.5) * table.x / places as f32;
            chair_at(dice, group, chair, Vec2::new(x, side * table.y * 0.5), Vec2::Y * side, yaw);
        }
    }
    if table.y > 0.75 && dice.chance(40) {
        chair_at(dice, group, chair, Vec2::X * table.x * 0.5, Vec2::X, -90.0);
        chair_at(dice, group, chair, Vec2::NEG_X * table.x * 0.5, Vec2::NEG_X, 90.0);
    }
}

/// A chair at a table's edge; now and then it is missing or pulled out askew.
fn chair_at(dice: &mut Dice, group: &mut Group, chair: &Thing, edge: Vec2, outward: Vec2, yaw_deg: f32) {
    if dice.chance(7) {
        return;
    }
    let askew = dice.chance(25);
    let turn = if askew { dice.between(-14.0, 14.0) } else { 0.0 };
    let gap = dice.between(CHAIR_TO_TABLE_M.0, CHAIR_TO_TABLE_M.1) + if askew { 0.05 } else { 0.0 };
    // A turned chair reaches farther than a straight one.
    let reach = (chair.size.z + chair.size.x * (turn / 57.3).abs()) * 0.5;
    let at = edge + outward * (gap + reach);
    group.stand_if_free(chair.clone(), at, yaw_deg + turn);
}

/// Chairs in the four directions of a round table.
fn chairs_around(dice: &mut Dice, group: &mut Group, chair: &Thing, radius: f32) {
    for (outward, yaw) in [(Vec2::NEG_Y, 0.0), (Vec2::Y, 180.0), (Vec2::X, -90.0), (Vec2::NEG_X, 90.0)] {
        chair_at(dice, group, chair, outward * radius, outward, yaw);
    }
}

/// Kitchen counters in a row with sink and fridge, cupboards over them.
pub fn kitchen_row(dice: &mut Dice, palette: &Palette, longest_m: f32, height_m: f32) -> Group {
    const MODULE_M: f32 = 0.6;
    let mut group = Group::default();
    let fridge = Thing::model(dice.pick(stock::FRIDGES), "Fridge", "appliances", 1.0);
    let with_fridge = longest_m > 2.4 && dice.chance(80);
    let counter = *dice.pick(stock::COUNTERS);
    let left = longest_m - if with_fridge { fridge.size.x + 0.04 } else { 0.0 } - 0.06;
    let modules = ((left / (MODULE_M + 0.001)).floor() as usize).clamp(2, dice.count(3, 6));
    let sink = dice.count(0, modules - 1);
    for k in 0..modules {
        let (list, name) =
            if k == sink { (stock::SINKS, "Sink") } else { (std::slice::from_ref(&counter), "Counter") };
        let thing = Thing::model(&list[0], name, if k == sink { "sink" } else { "counter" }, 1.0);
        // A millimetre apart: modules touch but don't run into each other.
        let base = group.stand(thing.clone(), k as f32 * 0.601, thing.size.z * 0.5, 0.0);
        if k != sink {
            group.tops.push((base, Clutter::Kitchen));
        }
    }
    let run = 0.601 * modules as f32;
    let deep = 0.62;
    if with_fridge {
        let right = dice.chance(50);
        let half = fridge.size.x * 0.5 + 0.02;
        let x = if right { run - 0.3 + half } else { -0.3 - half };
        group.stand(fridge.clone(), x, fridge.size.z * 0.5, 0.0);
    }
    if dice.chance(65) {
        let cupboard = (run - 0.02, dice.between(0.5, 0.7).min(height_m - 1.5), 0.34);
        let doors = modules as u8;
        let item = Item::Wardrobe { size: cupboard, doors, case: palette.wood_2, front: palette.wood_2 };
        let thing = Thing::made(item, "Wall cupboard", "cabinet", cupboard);
        group.add(thing, Vec2::new((run - 0.601) * 0.5, 0.17 - 0.02), 0.0, Held::Hung(1.45));
    }
    group.clear.push(Rect::of(Vec2::new(-0.3, deep), Vec2::new(run - 0.3, deep + 0.75)));
    group.reach.push(Vec2::new(run * 0.5 - 0.3, deep + 0.45));
    group
}

/// A kitchen island or high table with bar stools.
pub fn island(dice: &mut Dice, palette: &Palette) -> Group {
    let mut group = Group::default();
    let stool = any_of(dice, stock::BAR_STOOLS, "Bar stool", "stool", palette);
    let table = match dice.count(0, 2) {
        0 => any_of(dice, stock::ISLANDS, "Island", "kitchen island", palette),
        1 => any_of(dice, stock::BAR_TABLES, "Bar table", "table", palette),
        _ => {
            let size = (dice.between(1.0, 1.7), dice.between(0.88, 1.05), dice.between(0.5, 0.7));
            table(dice, palette, "Bar", "counter", size)
        }
    };
    let size = table.size;
    let base = group.stand(table, 0.0, 0.0, 0.0);
    group.tops.push((base, Clutter::Kitchen));
    let places = ((size.x - 0.05) / (stool.size.x + 0.12)).floor().max(1.0) as usize;
    for k in 0..places {
        let x = (k as f32 - (places - 1) as f32 * 0.5) * size.x / places as f32;
        chair_at(dice, &mut group, &stool, Vec2::new(x, size.z * 0.5), Vec2::Y, 180.0);
    }
    group.reach.push(Vec2::new(0.0, -size.z * 0.5 - 0.4));
    group
}

/// Chairs or armchairs side by side with their backs at the wall, as in a waiting room.
pub fn row_of_seats(dice: &mut Dice, palette: &Palette, longest_m: f32) -> Group {
    let mut group = Group::default();
    let seat = match dice.count(0, 3) {
        0 => armchair(dice, palette),
        1 => bench_thing(dice, palette),
        _ => any_of(dice, stock::CHAIRS, "Chair", "chair", palette),
    };
    let air = dice.between(0.04, 0.22);
    let most = ((longest_m + air) / (seat.size.x + air)).floor() as usize;
    let count = dice.count(2, 5).min(most).max(1);
    for k in 0..count {
        let x = (k as f32 - (count - 1) as f32 * 0.5) * (seat.size.x + air);
        group.stand(seat.clone(), x, seat.size.z * 0.5 + 0.03, 0.0);
    }
    let half = (seat.size.x + air) * count as f32 * 0.5;
    let deep = seat.size.z + 0.06;
    group.clear.push(Rect::of(Vec2::new(-half, deep), Vec2::new(half, deep + 0.55)));
    group.reach.push(Vec2::new(0.0, deep + 0.4));
    group
}

/// A low table alone, with something to read.
pub fn magazine_table(dice: &mut Dice, palette: &Palette) -> Group {
    let mut group = Group::default();
    let table = coffee_table(dice, palette);
    let base = group.stand(table, 0.0, 0.0, 0.0);
    group.tops.push((base, Clutter::Coffee));
    group
}

/// A reception desk to lean on, with a chair behind it.
pub fn reception(dice: &mut Dice, palette: &Palette) -> Group {
    let mut group = Group::default();
    let size = (dice.between(1.3, 2.0), dice.between(0.98, 1.1), dice.between(0.5, 0.65));
    let item = Item::Block { size, color: palette.wood };
    let chair = any_of(dice, stock::OFFICE_CHAIRS, "Office chair", "chair", palette);
    let chair_z = 0.3 + chair.size.z * 0.5;
    group.stand(chair.clone(), 0.0, chair_z, 0.0);
    let z = chair_z + chair.size.z * 0.5 + 0.15 + size.2 * 0.5;
    let base = group.stand(Thing::made(item, "Reception desk", "counter", size), 0.0, z, 180.0);
    group.tops.push((base, Clutter::Kitchen));
    group.reach.push(Vec2::new(0.0, z + size.2 * 0.5 + 0.4));
    group.reach.push(Vec2::new(size.0 * 0.5 + 0.35, chair_z));
    group
}

/// A low table with low chairs.
pub fn play_table(dice: &mut Dice, palette: &Palette) -> Group {
    let mut group = Group::default();
    let table = any_of(dice, stock::KIDS_TABLES, "Play table", "table", palette);
    let chair = any_of(dice, stock::KIDS_CHAIRS, "Child's chair", "chair", palette);
    let size = table.size;
    let base = group.stand(table, 0.0, 0.0, 0.0);
    group.tops.push((base, Clutter::Children));
    for (side, yaw) in [(-1.0, 0.0), (1.0, 180.0)] {
        chair_at(dice, &mut group, &chair, Vec2::Y * side * size.z * 0.5, Vec2::Y * side, yaw);
    }
    group
}

/// A single thing at the wall: toys, shoes, a filing cabinet, a dressing table, a child's desk.
pub fn single(
    dice: &mut Dice,
    palette: &Palette,
    list: &[Stock],
    name: &str,
    category: &'static str,
) -> Group {
    let thing = any_of(dice, list, name, category, palette);
    let mut group = Group::default();
    let deep = thing.size.z;
    group.stand(thing, 0.0, deep * 0.5, 0.0);
    group
}

/// A rug in the open.
pub fn open_rug(dice: &mut Dice, palette: &Palette) -> Group {
    let size = (dice.between(1.2, 2.2), dice.between(0.9, 1.5));
    let mut group = Group::default();
    group.add(rug(dice, palette, size), Vec2::ZERO, 0.0, Held::Flat);
    group
}
