//! What stands in each kind of room, the most important first.

use std::collections::BTreeMap;

use glam::Vec2;

use super::building::Sizes;
use super::dice::{Dice, millimetres};
use super::group::{Furnishing, Group, quarters_of};
use super::kits::{self, BedKind, DeskKind};
use super::palette::{self, Palette};
use super::plan::AtWall;
use super::{RoomType, stock};
use crate::scene::layout::{Item, Placement};

/// Share of the floor that furniture takes in lived-in rooms: a quarter to a third and a little.
const FURNISHED_SHARE: (f32, f32) = (0.2, 0.36);
/// Tries to add something more: a room that is hard to furnish stays emptier.
const FILL_TRIES: usize = 16;

/// The sizes that a kind of room comes in.
pub fn sizes(kind: RoomType) -> Sizes {
    let sizes = |width_m, depth_m, l_shaped, windows| Sizes { width_m, depth_m, l_shaped, windows };
    match kind {
        RoomType::Living => sizes((4.4, 7.2), (3.8, 5.6), 25, 3),
        RoomType::Bedroom => sizes((3.6, 5.4), (3.2, 4.4), 12, 2),
        RoomType::Office => sizes((3.4, 6.6), (3.0, 5.2), 12, 3),
        RoomType::Dining => sizes((3.6, 6.4), (3.2, 4.8), 18, 3),
        RoomType::Studio => sizes((5.2, 7.6), (4.4, 6.0), 30, 3),
        RoomType::Lounge => sizes((4.2, 8.0), (3.6, 6.0), 20, 3),
        RoomType::Children => sizes((3.2, 4.6), (2.9, 4.0), 8, 2),
        RoomType::Guest => sizes((3.2, 4.4), (3.0, 4.0), 8, 2),
    }
}

/// A room while its recipe is followed.
pub struct Recipe<'a> {
    pub dice: &'a mut Dice,
    pub room: &'a mut Furnishing,
    pub palette: &'a Palette,
    pub height_m: f32,
}

/// Furnishes the room; `false` when what makes it this kind of room found no place.
pub fn furnish(kind: RoomType, recipe: &mut Recipe<'_>) -> bool {
    let essential = match kind {
        RoomType::Living => recipe.living(),
        RoomType::Bedroom => recipe.bedroom(),
        RoomType::Office => recipe.office(),
        RoomType::Dining => recipe.dining(),
        RoomType::Studio => recipe.studio(),
        RoomType::Lounge => recipe.lounge(),
        RoomType::Children => recipe.children(),
        RoomType::Guest => recipe.guest(),
    };
    if essential {
        recipe.fill_up(kind);
        recipe.finishing_touches();
        recipe.pictures();
        recipe.ceiling_lamp();
    }
    essential
}

impl Recipe<'_> {
    fn longest_wall(&self) -> f32 {
        self.room.plan.walls.iter().map(|w| w.length).fold(0.0, f32::max)
    }

    fn at_wall(&mut self, group: &Group) -> bool {
        self.room.at_wall(self.dice, group)
    }

    /// Tries a group that is made afresh each time, until one fits.
    fn until_placed(&mut self, tries: usize, make: impl Fn(&mut Dice, &Palette) -> Group) -> bool {
        (0..tries).any(|_| {
            let group = make(self.dice, self.palette);
            self.at_wall(&group)
        })
    }

    fn maybe(&mut self, percent: u32, make: impl Fn(&mut Dice, &Palette) -> Group) -> bool {
        self.dice.chance(percent) && self.until_placed(2, make)
    }

    fn open_until_placed(&mut self, tries: usize, make: impl Fn(&mut Dice, &Palette) -> Group) -> bool {
        (0..tries).any(|_| {
            let group = make(self.dice, self.palette);
            self.room.in_the_open(self.dice, &group)
        })
    }

    fn living(&mut self) -> bool {
        let sofa = self.sofa_and_television();
        let height_m = self.height_m;
        if self.room.plan.area_m2() > 22.0 && self.dice.chance(65) {
            self.open_until_placed(3, |dice, palette| kits::dining(dice, palette, 1.8, height_m));
        }
        self.maybe(70, |dice, palette| kits::shelves(dice, palette, 3));
        self.maybe(55, kits::reading_place);
        self.maybe(50, kits::chest);
        self.maybe(25, |dice, palette| kits::desk(dice, palette, DeskKind::AtWall));
        sofa
    }

    /// The sofa at a wall or in the room, the screen where it looks.
    fn sofa_and_television(&mut self) -> bool {
        let widest = self.longest_wall() - 0.2;
        let area = self.room.plan.area_m2();
        for attempt in 0..12 {
            let roomy = area > 15.0 && attempt < 7;
            let group = kits::sofa_corner(self.dice, self.palette, widest, roomy);
            let before = self.room.placements.len();
            let free = roomy && area > 20.0 && self.dice.chance(25);
            let placed = if free { self.room.in_the_open(self.dice, &group) } else { self.at_wall(&group) };
            if placed {
                self.television_before(before);
                return true;
            }
        }
        false
    }

    /// Puts a television at the wall that the thing placed as `index` looks at, as near to its line of sight as can be.
    fn television_before(&mut self, index: usize) {
        let sofa = &self.room.placements[index];
        let (sin, cos) = f64::from(sofa.yaw_deg).to_radians().sin_cos();
        let facing = Vec2::new(sin as f32, cos as f32);
        let from = Vec2::new(sofa.at.0, sofa.at.2);
        if !self.dice.chance(85) {
            return;
        }
        let group = kits::television(self.dice, self.palette);
        let opposite: Vec<usize> = (0..self.room.plan.walls.len())
            .filter(|i| self.room.plan.walls[*i].inward.dot(facing) < -0.9)
            .collect();
        for aside in [0.0, 0.2, -0.2, 0.4, -0.4, 0.7, -0.7, 1.0, -1.0] {
            for wall in &opposite {
                let line = self.room.plan.walls[*wall];
                let middle = (from - line.from).dot(line.along) + aside;
                let half = group.bounds().size().x * 0.5 + 0.03;
                if middle > half
                    && middle < line.length - half
                    && self.room.at_this_spot(&group, *wall, middle)
                {
                    return;
                }
            }
        }
    }

    fn bedroom(&mut self) -> bool {
        let bed = self.bed(BedKind::Double);
        self.until_placed(4, kits::wardrobe);
        self.maybe(60, kits::chest);
        self.maybe(45, kits::reading_place);
        self.maybe(35, |dice, palette| kits::desk(dice, palette, DeskKind::AtWall));
        self.maybe(20, |dice, palette| {
            kits::single(dice, palette, stock::VANITIES, "Dressing table", "table")
        });
        self.maybe(25, |dice, palette| kits::shelves(dice, palette, 1));
        self.maybe(25, kits::extra_seat);
        bed
    }

    fn bed(&mut self, kind: BedKind) -> bool {
        (0..14).any(|k| {
            let stands = if k < 6 { 2 } else { usize::from(k < 10) };
            let along = kind != BedKind::Double && self.dice.chance(45);
            let group = if along {
                kits::bed_along_wall(self.dice, self.palette, kind)
            } else {
                let stands = if kind == BedKind::Double { stands } else { stands.min(1) };
                kits::bed_corner(self.dice, self.palette, kind, stands)
            };
            self.at_wall(&group)
        })
    }

    fn office(&mut self) -> bool {
        let area = self.room.plan.area_m2();
        let desks = ((area / 6.5) as usize).clamp(1, 4);
        let wanted = self.dice.count(1, desks);
        let mut placed = 0;
        for _ in 0..wanted + 4 {
            if placed == wanted {
                break;
            }
            let facing = area > 11.0 && self.dice.chance(35);
            let kind = if facing { DeskKind::FacingRoom } else { DeskKind::AtWall };
            placed += usize::from(self.until_placed(2, |dice, palette| kits::desk(dice, palette, kind)));
        }
        let height_m = self.height_m;
        if area > 20.0 && self.dice.chance(50) {
            self.open_until_placed(3, |dice, palette| kits::dining(dice, palette, 2.2, height_m));
        }
        self.maybe(70, |dice, palette| kits::shelves(dice, palette, 3));
        self.maybe(45, |dice, palette| {
            kits::single(dice, palette, stock::FILING, "Filing cabinet", "cabinet")
        });
        if area > 14.0 {
            self.maybe(45, |dice, palette| kits::sofa_corner(dice, palette, 2.0, false));
        }
        self.maybe(30, kits::reading_place);
        self.maybe(25, kits::chest);
        placed > 0
    }

    fn dining(&mut self) -> bool {
        let longest = self.longest_wall();
        let height_m = self.height_m;
        let kitchen = self.dice.chance(60);
        if kitchen {
            let longest = longest.min(5.0);
            let row = |dice: &mut Dice, palette: &Palette| {
                let share = dice.between(0.6, 1.0);
                kits::kitchen_row(dice, palette, longest * share, height_m)
            };
            self.until_placed(8, row);
        }
        let largest = if self.room.plan.area_m2() > 16.0 { 2.4 } else { 1.6 };
        let table = self.open_until_placed(8, |dice, palette| kits::dining(dice, palette, largest, height_m))
            || self.open_until_placed(6, |dice, palette| kits::dining(dice, palette, 1.1, height_m));
        if kitchen && self.dice.chance(45) {
            self.open_until_placed(3, kits::island);
        }
        self.maybe(60, kits::chest);
        self.maybe(35, |dice, palette| kits::shelves(dice, palette, 2));
        self.maybe(35, kits::extra_seat);
        self.maybe(30, kits::reading_place);
        table
    }

    fn studio(&mut self) -> bool {
        let kind = if self.dice.chance(60) { BedKind::Double } else { BedKind::Single };
        let bed = self.bed(kind);
        let sofa = self.sofa_and_television();
        let (longest, height_m) = (self.longest_wall().min(3.2), self.height_m);
        if self.dice.chance(75) {
            self.until_placed(4, |dice, palette| kits::kitchen_row(dice, palette, longest, height_m));
        }
        self.open_until_placed(3, |dice, palette| kits::dining(dice, palette, 1.3, height_m));
        self.maybe(70, |dice, palette| kits::desk(dice, palette, DeskKind::AtWall));
        self.maybe(80, kits::wardrobe);
        self.maybe(40, |dice, palette| kits::shelves(dice, palette, 2));
        bed && sofa
    }

    fn lounge(&mut self) -> bool {
        let area = self.room.plan.area_m2();
        let rows = self.dice.count(1, if area > 22.0 { 4 } else { 2 });
        let mut seats = 0;
        for _ in 0..rows {
            let longest = self.dice.between(1.4, 3.4);
            let row = |dice: &mut Dice, palette: &Palette| kits::row_of_seats(dice, palette, longest);
            seats += usize::from(self.until_placed(3, row));
        }
        let sofas = self.dice.count(0, 2);
        for _ in 0..sofas {
            seats += usize::from(self.until_placed(2, |d, p| kits::sofa_corner(d, p, 2.6, area > 16.0)));
        }
        self.maybe(45, kits::reception);
        if self.dice.chance(60) {
            self.open_until_placed(2, kits::magazine_table);
        }
        if area > 22.0 && self.dice.chance(40) {
            self.open_until_placed(2, kits::island);
        }
        self.maybe(35, kits::extra_seat);
        self.maybe(45, |dice, palette| kits::shelves(dice, palette, 2));
        seats > 0
    }

    fn children(&mut self) -> bool {
        let kind = if self.dice.chance(70) { BedKind::Child } else { BedKind::Single };
        let bed = self.bed(kind);
        self.maybe(70, |dice, palette| kits::single(dice, palette, stock::KIDS_SHELVES, "Shelf", "shelving"));
        self.maybe(60, |dice, palette| kits::desk(dice, palette, DeskKind::Child));
        self.maybe(60, kits::wardrobe);
        if self.dice.chance(70) {
            self.open_until_placed(2, kits::play_table);
        }
        self.maybe(60, kits::extra_seat);
        self.maybe(55, |dice, palette| kits::single(dice, palette, stock::TOYS, "Doll's house", "objects"));
        self.maybe(45, kits::chest);
        if self.dice.chance(60) {
            self.open_until_placed(2, kits::open_rug);
        }
        bed
    }

    fn guest(&mut self) -> bool {
        let kind = if self.dice.chance(60) { BedKind::Single } else { BedKind::Double };
        let bed = self.bed(kind);
        self.maybe(60, kits::reading_place);
        self.maybe(60, kits::wardrobe);
        self.maybe(45, kits::chest);
        self.maybe(40, |dice, palette| kits::desk(dice, palette, DeskKind::AtWall));
        self.maybe(40, kits::extra_seat);
        self.maybe(35, |dice, palette| kits::shelves(dice, palette, 1));
        bed
    }

    /// Adds what belongs into such a room until a usual share of the floor is taken or nothing more fits.
    fn fill_up(&mut self, kind: RoomType) {
        let wanted = self.dice.between(FURNISHED_SHARE.0, FURNISHED_SHARE.1);
        for _ in 0..FILL_TRIES {
            let taken: f32 = self.room.plan.solids.iter().map(|s| s.size().element_product()).sum();
            if taken > wanted * self.room.plan.area_m2() {
                break;
            }
            self.something_more(kind);
        }
    }

    fn something_more(&mut self, kind: RoomType) -> bool {
        let height_m = self.height_m;
        let seats = |dice: &mut Dice, palette: &Palette| kits::row_of_seats(dice, palette, 2.6);
        match (kind, self.dice.count(0, 9)) {
            (RoomType::Lounge, 0..=2) => self.until_placed(1, seats),
            (RoomType::Lounge, n) if (3..5).contains(&n) => {
                self.until_placed(1, |d, p| kits::sofa_corner(d, p, 2.6, true))
            }
            (RoomType::Office, 0..=2) => self.until_placed(1, |d, p| kits::desk(d, p, DeskKind::AtWall)),
            (RoomType::Living, 0..=1) => self.until_placed(1, |d, p| kits::sofa_corner(d, p, 2.2, false)),
            (RoomType::Living | RoomType::Studio, 2) => {
                self.open_until_placed(1, |d, p| kits::dining(d, p, 1.5, height_m))
            }
            (RoomType::Bedroom | RoomType::Guest, 0..=1) => self.until_placed(1, kits::wardrobe),
            (RoomType::Lounge, 5) | (RoomType::Dining, 0..=1) => self.open_until_placed(1, kits::island),
            (RoomType::Children, 0..=1) => self.open_until_placed(1, kits::play_table),
            (_, n) if n < 4 => self.until_placed(1, kits::reading_place),
            (_, n) if n < 6 => self.until_placed(1, |dice, palette| kits::shelves(dice, palette, 2)),
            (_, n) if n < 8 => self.until_placed(1, kits::chest),
            _ => self.until_placed(1, kits::extra_seat),
        }
    }

    /// Plants, lamps and shoes where there is still room.
    fn finishing_touches(&mut self) {
        for _ in 0..self.dice.count(0, 2) {
            let group = kits::plant(self.dice);
            self.room.in_a_corner(self.dice, &group);
        }
        if self.dice.chance(55) {
            let group = kits::floor_lamp(self.dice, self.palette);
            self.room.in_a_corner(self.dice, &group);
        }
        self.maybe(25, |dice, palette| kits::single(dice, palette, stock::SHOES, "Shoes", "clothes"));
    }

    /// Pictures where a wall is free at eye height.
    fn pictures(&mut self) {
        for _ in 0..self.dice.count(0, 4) {
            let size = (self.dice.between(0.4, 1.1), self.dice.between(0.4, 0.8));
            let bottom = self.dice.between(1.25, 1.5);
            let wall = self.dice.count(0, self.room.plan.walls.len() - 1);
            let line = self.room.plan.walls[wall];
            let half = size.0 * 0.5 + 0.1;
            if line.length < 2.0 * half || bottom + size.1 > self.height_m - 0.1 {
                continue;
            }
            let at = self.dice.between(half, line.length - half);
            let stretch = AtWall {
                wall,
                from: at - size.0 * 0.5,
                to: at + size.0 * 0.5,
                bottom: bottom - 0.08,
                top: bottom + size.1 + 0.05,
            };
            if self.room.is_behind(&stretch, 0.12) {
                continue;
            }
            self.room.plan.at_walls.push(stretch);
            let item = palette::picture(self.dice, size, self.palette);
            let p = line.from + line.along * at;
            let yaw_deg = (90.0 * f32::from(quarters_of(line.inward)) + 180.0).rem_euclid(360.0) - 180.0;
            self.hang("Picture", "picture", item, p, bottom, yaw_deg);
        }
    }

    fn hang(&mut self, name: &str, category: &str, item: Item, p: Vec2, y: f32, yaw_deg: f32) {
        let name = self.room.name(name);
        self.room.placements.push(Placement {
            item,
            name,
            category: category.into(),
            at: (millimetres(p.x), millimetres(y), millimetres(p.y)),
            yaw_deg,
            scale: 1.0,
            on: None,
            tint: None,
            finish: BTreeMap::new(),
        });
    }

    /// A lamp under the ceiling, in the middle of the larger part of the room.
    fn ceiling_lamp(&mut self) {
        let hangs = self.room.placements.iter().any(|p| p.name == "Pendant lamp");
        if hangs || self.dice.chance(40) {
            return;
        }
        let drop_m = self.dice.between(0.4, 0.5).min(self.height_m - 2.05);
        let bounds = self.room.plan.bounds;
        let mut at = bounds.center();
        if let Some(cut) = self.room.plan.cut {
            at += (bounds.center() - cut.center()) * 0.35;
        }
        let item = Item::Pendant { drop_m, shade: self.palette.accent };
        self.hang("Ceiling lamp", "lighting", item, at, self.height_m - drop_m, 0.0);
    }
}
