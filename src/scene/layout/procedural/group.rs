//! Things that belong together, placed as one: a desk with its chair, a table with chairs around it.

use std::collections::BTreeMap;

use glam::{Vec2, Vec3};

use super::dice::{Dice, millimetres};
use super::plan::{AtWall, Plan, Rect};
use super::stock::Stock;
use crate::scene::layout::{Item, Placement, Srgb};

/// From the wall to the backs of what stands at it: skirting boards and air.
const WALL_GAP_M: f32 = 0.025;
/// Places tried for a group before it is left out.
const TRIES: usize = 60;

/// Something to be placed, looking along +z about its origin.
#[derive(Clone, Debug)]
pub struct Thing {
    pub item: Item,
    pub name: String,
    pub category: &'static str,
    /// Width, height, depth after scaling.
    pub size: Vec3,
    pub scale: f32,
    pub tint: Option<Srgb>,
}

impl Thing {
    pub fn made(item: Item, name: &str, category: &'static str, size: (f32, f32, f32)) -> Self {
        Self { item, name: name.into(), category, size: Vec3::from(size), scale: 1.0, tint: None }
    }

    /// A model, its size a little varied.
    pub fn model(stock: &Stock, name: &str, category: &'static str, scale: f32) -> Self {
        let size = Vec3::from(stock.size) * scale;
        let item = Item::Model(stock.file.into());
        Self { item, name: name.into(), category, size, scale, tint: None }
    }

    pub fn tinted(mut self, color: Option<Srgb>) -> Self {
        self.tint = color;
        self
    }
}

/// How a thing of a group is held.
#[derive(Clone, Debug, PartialEq)]
pub enum Held {
    /// It stands on the floor and takes it.
    Floor,
    /// It stands on the group's rug of this number and takes the floor.
    Rug(usize),
    /// It lies flat on the floor: a rug.
    Flat,
    /// It stands on the group's thing of this number.
    On(usize),
    /// It hangs, its lowest point at this height.
    Hung(f32),
}

impl Held {
    fn takes_floor(&self) -> bool {
        matches!(self, Self::Floor | Self::Rug(_))
    }
}

/// A thing in its group's frame.
#[derive(Clone, Debug)]
pub struct Member {
    pub thing: Thing,
    pub at: Vec2,
    pub yaw_deg: f32,
    pub held: Held,
}

impl Member {
    fn rect(&self) -> Rect {
        let (sin, cos) = f64::from(self.yaw_deg).to_radians().sin_cos();
        let (s, c) = (sin.abs() as f32, cos.abs() as f32);
        let size = self.thing.size;
        Rect::around(self.at, Vec2::new(size.x * c + size.z * s, size.x * s + size.z * c))
    }
}

/// Things that are placed together. Frame: x to the right, z to the front; at a wall, the wall is at z = 0.
#[derive(Clone, Debug, Default)]
pub struct Group {
    pub members: Vec<Member>,
    /// Floor that must stay free.
    pub clear: Vec<Rect>,
    /// Points that somebody must be able to walk to.
    pub reach: Vec<Vec2>,
    /// Tops of members that clutter may stand on: the member and what is put there.
    pub tops: Vec<(usize, Clutter)>,
}

/// What a top is used for, which says what lies on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clutter {
    Coffee,
    Dining,
    Round,
    Desk,
    Night,
    Chest,
    Kitchen,
    Children,
}

/// A top in the room.
#[derive(Clone, Debug)]
pub struct Top {
    pub name: String,
    pub rect: Rect,
    /// Which way its user looks at it, in degrees.
    pub yaw_deg: f32,
    pub clutter: Clutter,
    pub taken: Vec<Rect>,
}

/// Where a group goes: turned by quarters.
#[derive(Clone, Copy, Debug)]
pub struct Pose {
    pub at: Vec2,
    pub quarters: u8,
}

/// `v` turned about the vertical by quarters of a circle, as a yaw of 90 degrees turns +z to +x.
pub fn turned(v: Vec2, quarters: u8) -> Vec2 {
    match quarters % 4 {
        0 => v,
        1 => Vec2::new(v.y, -v.x),
        2 => -v,
        _ => Vec2::new(-v.y, v.x),
    }
}

/// The quarters that turn +z to a wall's inward direction.
pub fn quarters_of(inward: Vec2) -> u8 {
    if inward.y > 0.5 {
        0
    } else if inward.x > 0.5 {
        1
    } else if inward.y < -0.5 {
        2
    } else {
        3
    }
}

impl Pose {
    pub fn point(self, local: Vec2) -> Vec2 {
        self.at + turned(local, self.quarters)
    }

    pub fn rect(self, local: Rect) -> Rect {
        Rect::of(self.point(local.min), self.point(local.max))
    }
}

impl Group {
    /// Adds something; gives its number.
    pub fn add(&mut self, thing: Thing, at: Vec2, yaw_deg: f32, held: Held) -> usize {
        self.members.push(Member { thing, at, yaw_deg, held });
        self.members.len() - 1
    }

    /// Adds something that stands on the floor.
    pub fn stand(&mut self, thing: Thing, x: f32, z: f32, yaw_deg: f32) -> usize {
        self.add(thing, Vec2::new(x, z), yaw_deg, Held::Floor)
    }

    /// Adds something that stands on the floor, unless something of the group is there already.
    pub fn stand_if_free(&mut self, thing: Thing, at: Vec2, yaw_deg: f32) {
        let member = Member { thing, at, yaw_deg, held: Held::Floor };
        let rect = member.rect();
        let taken = self.members.iter().any(|m| m.held.takes_floor() && m.rect().grown(0.005).meets(rect));
        if !taken {
            self.members.push(member);
        }
    }

    /// Whether things of the group stand in each other.
    fn runs_into_itself(&self) -> bool {
        let rects: Vec<Rect> =
            self.members.iter().filter(|m| m.held.takes_floor()).map(|m| m.rect().grown(-0.001)).collect();
        (0..rects.len()).any(|i| rects[i + 1..].iter().any(|other| rects[i].meets(*other)))
    }

    /// What the group takes of the floor.
    pub fn bounds(&self) -> Rect {
        let solids = self.members.iter().filter(|m| m.held.takes_floor()).map(Member::rect);
        solids.reduce(Rect::joined).unwrap_or(Rect { min: Vec2::ZERO, max: Vec2::ZERO })
    }

    /// How high the group stands at the wall.
    fn height_at_wall(&self) -> f32 {
        let near = self.members.iter().filter(|m| m.rect().min.y < 0.3);
        near.map(|m| m.thing.size.y + if let Held::Hung(y) = m.held { y } else { 0.0 }).fold(0.0, f32::max)
    }
}

/// A room while it is furnished.
pub struct Furnishing {
    pub plan: Plan,
    pub placements: Vec<Placement>,
    pub tops: Vec<Top>,
    names: BTreeMap<String, usize>,
}

impl Furnishing {
    pub fn new(plan: Plan) -> Self {
        Self { plan, placements: Vec::new(), tops: Vec::new(), names: BTreeMap::new() }
    }

    /// A name that nothing has yet.
    pub fn name(&mut self, wanted: &str) -> String {
        let count = self.names.entry(wanted.to_owned()).or_insert(0);
        *count += 1;
        if *count == 1 { wanted.to_owned() } else { format!("{wanted} {count}") }
    }

    /// Places the group there if everything fits and one can still walk everywhere.
    pub fn place(&mut self, group: &Group, pose: Pose) -> bool {
        let rects: Vec<Rect> =
            group.members.iter().filter(|m| m.held.takes_floor()).map(|m| pose.rect(m.rect())).collect();
        let clear: Vec<Rect> = group.clear.iter().map(|c| pose.rect(*c)).collect();
        let held = group.members.iter().map(|m| pose.rect(m.rect())).all(|r| self.plan.holds(r));
        let free = rects.iter().all(|r| self.plan.is_free(*r));
        if !held || !free || group.runs_into_itself() || !clear.iter().all(|c| self.plan.can_stay_clear(*c)) {
            return false;
        }
        let before = (self.plan.solids.len(), self.plan.clear.len(), self.plan.reach.len());
        self.plan.solids.extend(&rects);
        self.plan.clear.extend(&clear);
        self.plan.reach.extend(group.reach.iter().map(|p| pose.point(*p)));
        if !self.plan.can_walk() {
            self.plan.solids.truncate(before.0);
            self.plan.clear.truncate(before.1);
            self.plan.reach.truncate(before.2);
            return false;
        }
        self.write(group, pose);
        true
    }

    fn write(&mut self, group: &Group, pose: Pose) {
        let names: Vec<String> = group.members.iter().map(|m| self.name(&m.thing.name)).collect();
        for (member, name) in group.members.iter().zip(&names) {
            let at = pose.point(member.at);
            let (y, on) = match member.held {
                Held::Floor | Held::Flat => (0.0, None),
                Held::On(base) | Held::Rug(base) => (0.0, Some(names[base].clone())),
                Held::Hung(y) => (y, None),
            };
            self.placements.push(Placement {
                item: member.thing.item.clone(),
                name: name.clone(),
                category: member.thing.category.into(),
                at: (millimetres(at.x), millimetres(y), millimetres(at.y)),
                yaw_deg: (90.0 * f32::from(pose.quarters) + member.yaw_deg + 180.0).rem_euclid(360.0) - 180.0,
                scale: member.thing.scale,
                on,
                tint: member.thing.tint,
                finish: BTreeMap::new(),
            });
        }
        for (base, clutter) in &group.tops {
            let member = &group.members[*base];
            let rect = pose.rect(member.rect());
            let yaw_deg = 90.0 * f32::from(pose.quarters) + member.yaw_deg;
            let on_it = group.members.iter().filter(|m| m.held == Held::On(*base));
            let taken = on_it.map(|m| pose.rect(m.rect()).grown(0.01)).collect();
            self.tops.push(Top { name: names[*base].clone(), rect, yaw_deg, clutter: *clutter, taken });
        }
    }

    /// Places the group with its back at some wall.
    pub fn at_wall(&mut self, dice: &mut Dice, group: &Group) -> bool {
        (0..TRIES).any(|_| {
            let wall = self.any_wall(dice);
            self.at_this_wall(dice, group, wall)
        })
    }

    /// Places the group with its back at one wall: in a corner, in the middle or anywhere.
    pub fn at_this_wall(&mut self, dice: &mut Dice, group: &Group, wall: usize) -> bool {
        let bounds = group.bounds();
        let (width, line) = (bounds.size().x, self.plan.walls[wall]);
        let (first, last) = (width * 0.5 + WALL_GAP_M, line.length - width * 0.5 - WALL_GAP_M);
        if last < first {
            return false;
        }
        let middle = match dice.count(0, 9) {
            0..=2 => first,
            3..=5 => last,
            6 => (first + last) * 0.5,
            _ => dice.between(first, last).clamp(first, last),
        };
        self.at_this_spot(group, wall, middle)
    }

    /// Places the group with its back at a wall, its middle this far along it.
    pub fn at_this_spot(&mut self, group: &Group, wall: usize, middle: f32) -> bool {
        let bounds = group.bounds();
        let line = self.plan.walls[wall];
        let half = bounds.size().x * 0.5;
        let stretch =
            AtWall { wall, from: middle - half, to: middle + half, bottom: 0.0, top: group.height_at_wall() };
        if self.is_behind(&stretch, 0.0) {
            return false;
        }
        let quarters = quarters_of(line.inward);
        let on_wall = line.from + line.along * middle + line.inward * WALL_GAP_M;
        let pose = Pose { at: on_wall - turned(Vec2::X * bounds.center().x, quarters), quarters };
        let placed = self.place(group, pose);
        if placed {
            self.plan.at_walls.push(stretch);
        }
        placed
    }

    /// Whether something at the wall already takes some of the stretch.
    pub fn is_behind(&self, stretch: &AtWall, air_m: f32) -> bool {
        self.plan.at_walls.iter().any(|other| {
            other.wall == stretch.wall
                && other.from < stretch.to + air_m
                && stretch.from < other.to + air_m
                && other.bottom < stretch.top
                && stretch.bottom < other.top
        })
    }

    /// Places the group somewhere in the room, away from walls.
    pub fn in_the_open(&mut self, dice: &mut Dice, group: &Group) -> bool {
        let bounds = group.bounds();
        (0..TRIES).any(|k| {
            let quarters = dice.count(0, 3) as u8;
            let room = self.plan.bounds;
            let spread = room.size() * (0.1 + 0.9 * k as f32 / TRIES as f32) * 0.5;
            let near = Vec2::new(dice.between(-spread.x, spread.x), dice.between(-spread.y, spread.y));
            let at = room.center() + near - turned(bounds.center(), quarters);
            self.place(group, Pose { at, quarters })
        })
    }

    /// Places the group in a corner of two walls, looking into the room diagonally when its things do.
    pub fn in_a_corner(&mut self, dice: &mut Dice, group: &Group) -> bool {
        let bounds = group.bounds();
        (0..TRIES / 3).any(|_| {
            let wall = self.any_wall(dice);
            let line = self.plan.walls[wall];
            let half = bounds.size().x * 0.5 + WALL_GAP_M;
            let middle = if dice.chance(50) { half } else { line.length - half };
            middle >= half && self.at_this_spot(group, wall, middle)
        })
    }

    /// Longer walls are likelier.
    fn any_wall(&self, dice: &mut Dice) -> usize {
        let total: f32 = self.plan.walls.iter().map(|w| w.length).sum();
        let mut left = dice.between(0.0, total);
        let last = self.plan.walls.len() - 1;
        (0..last)
            .find(|i| {
                left -= self.plan.walls[*i].length;
                left <= 0.0
            })
            .unwrap_or(last)
    }
}
