//! Where every movable thing is at one moment, and what that means: does a thing at a place run into another, what
//! holds it up. Looks at real triangles; a change costs what the changed thing costs, whatever the room holds.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::Arc;

use glam::{Affine3A, Quat, Vec2, Vec3};

use super::library::{KindId, Thing};
use super::shape::{Shape, UnderPoint};
use super::stage::{Found, Stage};
use crate::inspect::distance_to_hull;
use crate::math::Aabb;
use crate::scene::ObjectId;

/// Between a thing and what holds it, so that resting isn't running into: half a millimetre, which nobody sees.
pub const GAP_M: f32 = 0.0005;
/// On a bowed surface a thing is lifted in such steps until it touches only.
const LIFTS_M: [f32; 3] = [0.0, 0.001, 0.002];
/// A point of the underside is over a surface when that lies at most this far below where the thing stands.
const BELOW_M: f32 = 0.012;
/// A contact carries when the surface is this near below it; soft surfaces give way.
const CARRIES_M: [f32; 2] = [0.004, 0.025];
/// ADSE eq. 9: at least half of a thing is over what it stands on.
const LEAST_SHARE: f32 = 0.5;
/// The middle of its weight may be this far outside of what carries it: not at all, for the measure of what was placed
/// casts other rays and may see the edge some millimetres nearer.
const BALANCE_M: f32 = 0.0;
/// Things whose inner circles in plan overlap by this share run into each other.
const CORES: f32 = 0.8;
/// Rays start so far above a surface's usual height: its unevenness.
const UNEVEN_M: f32 = 0.03;
/// Side of a square of the plan that things are looked up by.
const SQUARE_M: f32 = 0.5;

/// A thing's place: the middle of its underside, its turn about the vertical and its lean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// World, metres.
    pub at: Vec3,
    /// Radians about +Y; 0 leaves the front at +z.
    pub yaw_rad: f32,
    /// How it leans with the soft surface that it lies on; turns it after `yaw_rad`.
    pub lean: Quat,
}

impl Pose {
    /// Upright.
    pub fn upright(at: Vec3, yaw_rad: f32) -> Self {
        Self { at, yaw_rad, lean: Quat::IDENTITY }
    }

    /// From the thing's frame to the world.
    pub fn matrix(&self) -> Affine3A {
        Affine3A::from_rotation_translation(self.lean * Quat::from_rotation_y(self.yaw_rad), self.at)
    }

    /// A point of the thing's plan in the world's plan, were it upright.
    pub fn plan(&self, local: Vec2) -> Vec2 {
        let (sin, cos) = self.yaw_rad.sin_cos();
        Vec2::new(local.x * cos + local.y * sin, local.y * cos - local.x * sin) + flat(self.at)
    }
}

/// (x, z).
pub fn flat(p: Vec3) -> Vec2 {
    Vec2::new(p.x, p.z)
}

/// What holds a thing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Held {
    /// A surface of the room, by its number.
    Surface(usize),
    /// Another thing.
    Item(ObjectId),
    /// As it was found; nobody looked.
    AsFound,
}

/// Where a thing comes from.
#[derive(Clone, Debug)]
pub enum Source {
    /// It was in the room.
    Found,
    /// An action brought it.
    Brought {
        /// What it looks like.
        thing: Arc<Thing>,
        /// The step that brought it, from 1.
        step: usize,
    },
}

/// A movable thing in the room.
#[derive(Clone, Debug)]
pub struct Item {
    /// Its name for as long as the room lives.
    pub id: ObjectId,
    /// Name for people.
    pub name: String,
    /// What it is.
    pub kind: Option<KindId>,
    /// Where it comes from.
    pub source: Source,
    /// Its geometry.
    pub shape: Arc<Shape>,
    /// Where it is.
    pub pose: Pose,
    /// What holds it.
    pub held: Held,
    /// Must not be moved.
    pub locked: bool,
    world: Affine3A,
    inverse: Affine3A,
    /// The box around it in the world.
    pub bounds: Aabb,
}

impl Item {
    fn new(found: &Found, name: String) -> Self {
        let pose = Pose::upright(found.at, 0.0);
        let mut item = Self {
            id: found.id,
            name,
            kind: found.kind,
            source: Source::Found,
            shape: found.shape.clone(),
            pose,
            held: Held::AsFound,
            locked: false,
            world: Affine3A::IDENTITY,
            inverse: Affine3A::IDENTITY,
            bounds: Aabb::EMPTY,
        };
        item.put(pose);
        item
    }

    fn put(&mut self, pose: Pose) {
        self.pose = pose;
        self.world = pose.matrix();
        self.inverse = self.world.inverse();
        self.bounds = placed_bounds(&self.shape, &pose);
    }

    /// From its frame to the world.
    pub fn world_from_item(&self) -> Affine3A {
        self.world
    }
}

/// The box around a shape at a place.
pub fn placed_bounds(shape: &Shape, pose: &Pose) -> Aabb {
    let place = pose.matrix();
    let m = place.matrix3;
    let half = shape.bounds.size() * 0.5;
    let reach = Vec3::from(m.x_axis.abs() * half.x + m.y_axis.abs() * half.y + m.z_axis.abs() * half.z);
    let middle = place.transform_point3(shape.bounds.center());
    Aabb { min: middle - reach, max: middle + reach }
}

/// A point of a thing's underside over what is below it.
#[derive(Clone, Copy)]
struct Under {
    /// From the thing's origin, turned as the thing is.
    point: Vec3,
    /// Height of the thing's foot there, from its origin.
    foot_m: f32,
    /// Height of what is below, world.
    top_m: f32,
}

/// Surfaces that slope less than this are level; more than the most is no place to lie on.
const LEANS_RAD: std::ops::Range<f32> = 0.01..0.25;
/// Points this far below the highest are beside the surface.
const BESIDE_M: f32 = 0.08;

/// The lean that lays a thing flat on what is under it: that of the plane through its points (least squares).
fn lean_of(under: &[Under]) -> Option<Quat> {
    let highest = under.iter().map(|u| u.top_m).fold(f32::NEG_INFINITY, f32::max);
    let on: Vec<Vec3> =
        under.iter().filter(|u| u.top_m > highest - BESIDE_M).map(|u| u.point.with_y(u.top_m)).collect();
    let mean = on.iter().sum::<Vec3>() / on.len().max(1) as f32;
    let [mut xx, mut xz, mut zz, mut xy, mut zy] = [0.0_f32; 5];
    for d in on.iter().map(|p| *p - mean) {
        xx += d.x * d.x;
        xz += d.x * d.z;
        zz += d.z * d.z;
        xy += d.x * d.y;
        zy += d.z * d.y;
    }
    let determinant = xx * zz - xz * xz;
    if determinant.abs() < 1e-9 {
        return None;
    }
    let slope = Vec2::new((xy * zz - zy * xz) / determinant, (zy * xx - xy * xz) / determinant);
    let normal = Vec3::new(-slope.x, 1.0, -slope.y).normalize_or(Vec3::Y);
    LEANS_RAD.contains(&normal.angle_between(Vec3::Y)).then(|| Quat::from_rotation_arc(Vec3::Y, normal))
}

/// A part of a body: where it is and how thick.
pub type Ball = (Vec3, f32);

/// A thing that would rest here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rest {
    /// Where.
    pub pose: Pose,
    /// Share of its underside over what holds it.
    pub share: f32,
    /// What holds it.
    pub held: Held,
}

/// Why a thing can't be at a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refused {
    /// It runs into the room, a thing or a person.
    Collides,
    /// Less than half of it is over what would hold it, or it would tip.
    Overhangs,
}

/// What is looked past: things that are lifted for the moment.
pub type Lifted = BTreeSet<ObjectId>;

/// Every movable thing's place.
#[derive(Clone, Debug)]
pub struct World {
    /// What stays.
    pub stage: Arc<Stage>,
    items: BTreeMap<ObjectId, Arc<Item>>,
    squares: HashMap<[i32; 2], Vec<ObjectId>>,
    next_id: u32,
}

impl World {
    /// The room as it was found.
    pub fn new(stage: Arc<Stage>) -> Self {
        let next_id = stage.room.objects.iter().map(|o| o.id.0 + 1).max().unwrap_or(0);
        let mut world =
            Self { stage: stage.clone(), items: BTreeMap::new(), squares: HashMap::new(), next_id };
        for found in &stage.movable {
            world.enter(Item::new(found, stage.name_of(found.id)));
        }
        world.hold_as_found();
        world
    }

    /// Says of the things that were found what holds them, where that is plain.
    fn hold_as_found(&mut self) {
        let ids: Vec<ObjectId> = self.items.keys().copied().collect();
        for id in ids {
            let Some(item) = self.items.get(&id) else { continue };
            let held = self.held_now(item);
            if held != item.held {
                let mut item = (**item).clone();
                item.held = held;
                self.items.insert(id, Arc::new(item));
            }
        }
    }

    /// What is right under a thing.
    fn held_now(&self, item: &Item) -> Held {
        let lifted = Lifted::from([item.id]);
        let from = flat(item.pose.at);
        let near = |y: f32| (y - item.pose.at.y).abs() < 0.02;
        let (y, on) = self.top_below(from, item.pose.at.y + 0.01, &Things::AllBut(&lifted));
        match on {
            Some(id) if near(y) => Held::Item(id),
            _ => self.surface_at(item.pose.at, 0.02).map_or(Held::AsFound, Held::Surface),
        }
    }

    /// The surface that a point lies on, up to a difference in height.
    fn surface_at(&self, point: Vec3, tolerance_m: f32) -> Option<usize> {
        let on = |surface: &super::stage::Surface| {
            surface.cells.iter().any(|(cell, _)| {
                (cell.y - point.y).abs() < tolerance_m
                    && (flat(*cell) - flat(point)).abs().max_element() < surface.cell_m * 1.5
            })
        };
        self.stage.surfaces.iter().position(on)
    }

    /// Every thing, by its number.
    pub fn items(&self) -> impl Iterator<Item = &Arc<Item>> {
        self.items.values()
    }

    /// How many things.
    pub fn len(&self) -> usize {
        self.items.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.items.is_empty()
    }

    /// The thing named `id`.
    pub fn item(&self, id: ObjectId) -> Option<&Arc<Item>> {
        self.items.get(&id)
    }

    /// Things of a kind.
    pub fn of_kind(&self, kind: KindId) -> impl Iterator<Item = &Arc<Item>> {
        self.items.values().filter(move |i| i.kind == Some(kind))
    }

    /// A number for a new thing.
    pub fn fresh_id(&mut self) -> ObjectId {
        self.next_id += 1;
        ObjectId(self.next_id - 1)
    }

    /// A new thing at a place.
    pub fn bring(
        &mut self,
        id: ObjectId,
        name: String,
        kind: KindId,
        thing: &Arc<Thing>,
        rest: &Rest,
        step: usize,
    ) {
        let found = Found { id, kind: Some(kind), shape: thing.shape.clone(), at: rest.pose.at };
        let mut item = Item::new(&found, name);
        item.source = Source::Brought { thing: thing.clone(), step };
        item.held = rest.held;
        item.put(rest.pose);
        self.enter(item);
    }

    /// Moves a thing.
    pub fn put(&mut self, id: ObjectId, rest: &Rest) {
        let Some(item) = self.leave(id) else { return };
        let mut item = (*item).clone();
        item.put(rest.pose);
        item.held = rest.held;
        self.enter(item);
    }

    /// Locks or frees a thing.
    pub fn lock(&mut self, id: ObjectId, locked: bool) {
        if let Some(item) = self.items.get(&id) {
            let mut item = (**item).clone();
            item.locked = locked;
            self.items.insert(id, Arc::new(item));
        }
    }

    fn enter(&mut self, item: Item) {
        for square in squares(&item.bounds) {
            self.squares.entry(square).or_default().push(item.id);
        }
        self.items.insert(item.id, Arc::new(item));
    }

    /// Takes a thing out.
    pub fn leave(&mut self, id: ObjectId) -> Option<Arc<Item>> {
        let item = self.items.remove(&id)?;
        for square in squares(&item.bounds) {
            if let Some(ids) = self.squares.get_mut(&square) {
                ids.retain(|other| *other != id);
            }
        }
        Some(item)
    }

    /// Things whose boxes touch `bounds`, each once, in the order of their numbers.
    pub fn near(&self, bounds: &Aabb) -> Vec<&Arc<Item>> {
        let mut ids: Vec<ObjectId> =
            squares(bounds).filter_map(|s| self.squares.get(&s)).flatten().copied().collect();
        ids.sort_unstable();
        ids.dedup();
        ids.iter().filter_map(|id| self.items.get(id)).filter(|i| i.bounds.intersects(bounds)).collect()
    }

    /// Things that stand on `id`, directly or on each other.
    pub fn carried_by(&self, id: ObjectId) -> Vec<ObjectId> {
        let mut found = vec![id];
        let mut next = 0;
        while next < found.len() {
            let below = found[next];
            next += 1;
            let Some(base) = self.items.get(&below) else { continue };
            let over = base.bounds.grown(0.02);
            let on = self.near(&over).into_iter().filter(|i| i.held == Held::Item(below)).map(|i| i.id);
            let new: Vec<ObjectId> = on.filter(|i| !found.contains(i)).collect();
            found.extend(new);
        }
        found.remove(0);
        found
    }

    /// The first thing that `shape` at `pose` runs into; `Err` for the room itself.
    pub fn collision(&self, shape: &Shape, pose: &Pose, lifted: &Lifted) -> Option<Option<ObjectId>> {
        let world = pose.matrix();
        let bounds = placed_bounds(shape, pose);
        let thing = self.near(&bounds).into_iter().filter(|i| !lifted.contains(&i.id)).find(|item| {
            let item_from_shape = item.inverse * world;
            item.shape.tree.meets(&shape.tree, &item_from_shape) || encloses(item, shape, &item_from_shape)
        });
        if let Some(item) = thing {
            return Some(Some(item.id));
        }
        self.stage.geometry.bvh.meets(&shape.tree, &world).then_some(None)
    }

    /// Whether a thing runs into one of `others`, or is wholly inside one.
    pub fn meets_any(&self, item: &Item, others: &Lifted) -> bool {
        self.near(&item.bounds).into_iter().filter(|o| o.id != item.id && others.contains(&o.id)).any(
            |other| {
                let other_from_item = other.inverse * item.world;
                other.shape.tree.meets(&item.shape.tree, &other_from_item)
                    || encloses(other, &item.shape, &other_from_item)
            },
        )
    }

    /// Whether a shape at a place touches one of these balls.
    pub fn touches(shape: &Shape, pose: &Pose, balls: &[Ball]) -> bool {
        let bounds = placed_bounds(shape, pose);
        let inverse = pose.matrix().inverse();
        balls.iter().filter(|(at, radius)| bounds.distance(*at) < *radius).any(|(at, radius)| {
            let local = inverse.transform_point3(*at);
            shape.tree.closest(local, *radius).is_some() || shape.tree.is_inside(local)
        })
    }

    /// The highest point below `from_m` at a place of the plan, and whose it is: the room's or one of `things`.
    pub fn top_below(&self, at: Vec2, from_m: f32, things: &Things<'_>) -> (f32, Option<ObjectId>) {
        let from = Vec3::new(at.x, from_m, at.y);
        let cast = self.stage.geometry.bvh.cast(from, Vec3::NEG_Y, 4.0);
        let mut best = (cast.map_or(f32::NEG_INFINITY, |h| from_m - h.distance_m), None);
        if matches!(things, Things::None) {
            return best;
        }
        let column = Aabb { min: from.with_y(best.0.max(from_m - 4.0)), max: from };
        for item in self.near(&column).into_iter().filter(|i| things.count(i.id)) {
            let local = item.inverse.transform_point3(from);
            let down = item.inverse.transform_vector3(Vec3::NEG_Y);
            if let Some(hit) = item.shape.tree.cast(local, down, 4.0)
                && from_m - hit.distance_m > best.0
            {
                best = (from_m - hit.distance_m, Some(item.id));
            }
        }
        best
    }

    /// Sets a thing down at a place of the plan on something about `height_m` high: on the room alone, or (`on`) on
    /// that thing. On soft surfaces it leans as they do. Says why where it can't.
    ///
    /// # Errors
    /// [`Refused::Overhangs`] without enough under it.
    pub fn set_down(&self, shape: &Shape, at: Vec2, yaw_rad: f32, on: Onto) -> Result<Rest, Refused> {
        let upright = Pose::upright(Vec3::new(at.x, 0.0, at.y), yaw_rad);
        let mut under = self.under(shape, &upright, on);
        let mut pose = upright;
        if on.is_soft()
            && let Some(lean) = lean_of(&under)
        {
            pose.lean = lean;
            under = self.under(shape, &pose, on);
        }
        let rest_m = under.iter().map(|u| u.top_m - u.point.y).fold(f32::NEG_INFINITY, f32::max);
        if !rest_m.is_finite() || rest_m < on.height_m() - 0.3 {
            return Err(Refused::Overhangs);
        }
        let carries_m = CARRIES_M[usize::from(on.is_soft())];
        let over = |u: &&Under| u.top_m >= rest_m + u.foot_m - BELOW_M.max(carries_m);
        let area = || under.iter().zip(&shape.under).filter(|(_, p)| p.area).map(|(u, _)| u);
        let share = area().filter(over).count() as f32 / area().count().max(1) as f32;
        let carried: Vec<Vec2> = under
            .iter()
            .zip(&shape.under)
            .filter(|(u, p)| p.lift_m < carries_m && u.top_m - u.point.y >= rest_m - carries_m)
            .map(|(_, p)| p.at)
            .collect();
        if share < LEAST_SHARE || distance_to_hull(&carried, shape.middle) > BALANCE_M {
            return Err(Refused::Overhangs);
        }
        let held = match on {
            Onto::Surface { number, .. } => Held::Surface(number),
            Onto::Item { id, .. } => Held::Item(id),
        };
        pose.at.y = rest_m - shape.bounds.min.y + GAP_M;
        Ok(Rest { pose, share, held })
    }

    /// What is under every point of a thing's underside. The pose's height does not count.
    fn under(&self, shape: &Shape, pose: &Pose, on: Onto) -> Vec<Under> {
        let turn = pose.lean * Quat::from_rotation_y(pose.yaw_rad);
        // On a stack only what is below counts: what lies beside it may be gone tomorrow.
        let things = on.item().map_or(Things::None, Things::Only);
        let from_m = on.height_m() + if on.item().is_some() { 0.01 } else { UNEVEN_M };
        let look = |p: &UnderPoint| {
            let point = turn * Vec3::new(p.at.x, p.lift_m, p.at.y);
            let foot_m = (turn * Vec3::new(p.at.x, 0.0, p.at.y)).y;
            let at = flat(pose.at) + flat(point);
            Under { point, foot_m, top_m: self.top_below(at, from_m, &things).0 }
        };
        shape.under.iter().map(look).collect()
    }

    /// Sets a thing down as [`World::set_down`] and makes sure that it runs into nothing.
    ///
    /// # Errors
    /// [`Refused`].
    pub fn place(
        &self,
        shape: &Shape,
        at: Vec2,
        yaw_rad: f32,
        on: Onto,
        avoid: &Avoid<'_>,
    ) -> Result<Rest, Refused> {
        // Most places in a crowd are taken by another thing: that is known soonest.
        let nominal = Pose::upright(Vec3::new(at.x, on.height_m() + GAP_M + 0.004, at.y), yaw_rad);
        let taken = self.overlaps_a_core(shape, &nominal, on, avoid)
            || self.runs_into_things(shape, &nominal, on, avoid)
            || Self::touches(shape, &nominal, avoid.balls);
        if taken {
            return Err(Refused::Collides);
        }
        let rest = self.set_down(shape, at, yaw_rad, on)?;
        for lift_m in LIFTS_M {
            let pose = Pose { at: rest.pose.at + Vec3::Y * lift_m, ..rest.pose };
            if self.collision(shape, &pose, avoid.lifted).is_none() {
                let clear = !Self::touches(shape, &pose, avoid.balls);
                return if clear { Ok(Rest { pose, ..rest }) } else { Err(Refused::Collides) };
            }
        }
        Err(Refused::Collides)
    }

    /// Whether the middle of a thing is where the middle of another is, seen from above: quickly told, and enough for
    /// most of what collides.
    fn overlaps_a_core(&self, shape: &Shape, pose: &Pose, on: Onto, avoid: &Avoid<'_>) -> bool {
        let bounds = placed_bounds(shape, pose);
        let middle = pose.plan(shape.middle);
        self.near(&bounds).into_iter().any(|item| {
            let apart_m = item.pose.plan(item.shape.middle).distance(middle);
            let counts = !avoid.lifted.contains(&item.id) && on.item() != Some(item.id);
            counts && apart_m < CORES * (item.shape.core_m + shape.core_m)
        })
    }

    fn runs_into_things(&self, shape: &Shape, pose: &Pose, on: Onto, avoid: &Avoid<'_>) -> bool {
        let world = pose.matrix();
        self.near(&placed_bounds(shape, pose)).into_iter().any(|item| {
            let counts = !avoid.lifted.contains(&item.id) && on.item() != Some(item.id);
            counts && item.shape.tree.meets(&shape.tree, &(item.inverse * world))
        })
    }
}

/// What a thing is set down on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Onto {
    /// A surface of the room.
    Surface {
        /// Its number.
        number: usize,
        /// Its height there.
        height_m: f32,
        /// Whether it gives way.
        soft: bool,
    },
    /// A thing.
    Item {
        /// Which.
        id: ObjectId,
        /// Its highest point.
        top_m: f32,
    },
}

impl Onto {
    fn height_m(self) -> f32 {
        match self {
            Self::Surface { height_m, .. } => height_m,
            Self::Item { top_m, .. } => top_m,
        }
    }

    fn is_soft(self) -> bool {
        matches!(self, Self::Surface { soft: true, .. })
    }

    fn item(self) -> Option<ObjectId> {
        match self {
            Self::Surface { .. } => None,
            Self::Item { id, .. } => Some(id),
        }
    }
}

/// Which things count as something to stand on.
#[derive(Clone, Copy, Debug)]
pub enum Things<'a> {
    /// None: only the room.
    None,
    /// This one, and the room.
    Only(ObjectId),
    /// All but these, and the room.
    AllBut(&'a Lifted),
}

impl Things<'_> {
    fn count(&self, id: ObjectId) -> bool {
        match self {
            Self::None => false,
            Self::Only(one) => *one == id,
            Self::AllBut(lifted) => !lifted.contains(&id),
        }
    }
}

/// What a placed thing must keep clear of beside the room and its things.
#[derive(Clone, Copy, Debug)]
pub struct Avoid<'a> {
    /// Things that are lifted for the moment: they don't count.
    pub lifted: &'a Lifted,
    /// People.
    pub balls: &'a [Ball],
}

/// Whether one is wholly inside the other.
fn encloses(item: &Item, shape: &Shape, item_from_shape: &Affine3A) -> bool {
    let inside = item_from_shape.transform_point3(shape.bounds.center());
    let (mine, theirs) = (&item.shape.bounds, &shape.bounds);
    if mine.contains(inside) && theirs.size().max_element() < mine.size().max_element() {
        return item.shape.tree.is_inside(inside);
    }
    let inside = item_from_shape.inverse().transform_point3(mine.center());
    theirs.contains(inside)
        && mine.size().max_element() < theirs.size().max_element()
        && shape.tree.is_inside(inside)
}

fn squares(bounds: &Aabb) -> impl Iterator<Item = [i32; 2]> + use<> {
    let cell = |v: f32| (v / SQUARE_M).floor() as i32;
    let (x0, x1, z0, z1) = (cell(bounds.min.x), cell(bounds.max.x), cell(bounds.min.z), cell(bounds.max.z));
    (x0..=x1).flat_map(move |x| (z0..=z1).map(move |z| [x, z]))
}

#[cfg(test)]
mod tests {
    use super::super::library::Library;
    use super::super::shape::tests::block_triangles;
    use super::*;
    use crate::assets::{Material, Mesh};
    use crate::job::Ticker;
    use crate::scene::{Category, Object, ObjectPart, Room};

    fn object(id: u32, name: &str, category: Category, size: Vec3, at: Vec3) -> Object {
        let triangles = block_triangles(size);
        let mesh = Mesh {
            positions: triangles.iter().flatten().copied().collect(),
            triangles: (0..triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
            ..Mesh::default()
        };
        let part = ObjectPart { mesh: Arc::new(mesh), material: 0, object_from_mesh: Affine3A::IDENTITY };
        Object {
            id: ObjectId(id),
            name: name.to_owned(),
            category,
            parts: vec![part],
            world_from_object: Affine3A::from_translation(at),
            visible: true,
            locked: category.is_structure(),
        }
    }

    /// A floor with a table of 1.2 by 0.8 m, 75 cm high, and a box of 10 cm on its middle.
    fn world() -> World {
        let table = Vec3::new(1.2, 0.75, 0.8);
        let room = Room {
            objects: vec![
                object(0, "Floor", Category::Floor, Vec3::new(4.0, 0.1, 4.0), Vec3::Y * -0.1),
                object(1, "Table", Category::DiningTable, table, Vec3::ZERO),
                object(2, "Box", Category::Objects, Vec3::splat(0.1), Vec3::Y * 0.75),
            ],
            materials: vec![Material::default()],
            ..Room::default()
        };
        let stage = Stage::new(Arc::new(room), Library::bundled(), &Ticker::silent()).expect("not cancelled");
        World::new(Arc::new(stage))
    }

    fn block(size: Vec3) -> Shape {
        Shape::new(block_triangles(size))
    }

    #[test]
    fn things_stand_on_the_table_hang_over_by_less_than_half_and_never_share_a_place() {
        let world = world();
        let top = world.stage.work_surface(ObjectId(1)).expect("the table has a top");
        let onto = Onto::Surface { number: top, height_m: 0.75, soft: false };
        let lifted = Lifted::new();
        let avoid = Avoid { lifted: &lifted, balls: &[] };
        let book = block(Vec3::new(0.2, 0.03, 0.2));
        let put = |x: f32, z: f32| world.place(&book, Vec2::new(x, z), 0.3, onto, &avoid);
        let rest = put(0.3, 0.2).expect("free");
        assert!((rest.pose.at.y - 0.75).abs() < 0.002 && rest.share > 0.99, "{rest:?}");
        assert_eq!(rest.held, Held::Surface(top));
        let over = put(0.56, 0.0).expect("a third hangs over");
        assert!((0.5..0.9).contains(&over.share), "{}", over.share);
        assert_eq!(put(0.62, 0.0), Err(Refused::Overhangs), "more than half would hang over");
        assert_eq!(put(0.1, 0.0), Err(Refused::Collides), "the box is there");
        let hidden = block(Vec3::new(0.04, 0.04, 0.04));
        let inside = world.place(&hidden, Vec2::ZERO, 0.0, onto, &avoid);
        assert_eq!(
            inside,
            Err(Refused::Collides),
            "inside the box no surface is touched, and yet it is taken"
        );
        let person = [(Vec3::new(0.3, 0.85, 0.2), 0.1)];
        let beside = Avoid { lifted: &lifted, balls: &person };
        assert_eq!(world.place(&book, Vec2::new(0.3, 0.2), 0.3, onto, &beside), Err(Refused::Collides));
    }

    #[test]
    fn what_stands_on_something_is_known_and_moves_are_by_value() {
        let mut world = world();
        let before = world.clone();
        let id = ObjectId(2);
        let base = world.item(id).expect("there").clone();
        assert!(matches!(base.held, Held::Surface(_)), "{:?}", base.held);
        let lifted = Lifted::new();
        let avoid = Avoid { lifted: &lifted, balls: &[] };
        let coin = block(Vec3::new(0.03, 0.005, 0.03));
        let onto = Onto::Item { id, top_m: base.bounds.max.y };
        let rest = world.place(&coin, Vec2::new(0.01, 0.0), 0.0, onto, &avoid).expect("on the box");
        assert!((rest.pose.at.y - 0.85).abs() < 0.002, "{rest:?}");
        let found = Found { id: ObjectId(9), kind: None, shape: Arc::new(coin), at: rest.pose.at };
        let mut coin = Item::new(&found, "Coin".to_owned());
        coin.held = rest.held;
        world.enter(coin);
        assert_eq!(world.carried_by(id), [ObjectId(9)]);
        world.put(id, &Rest { pose: Pose::upright(Vec3::new(0.4, 0.75, 0.2), 1.0), ..rest });
        assert_eq!(before.item(id).map(|i| i.pose), Some(base.pose), "the copy is untouched");
        assert!(world.near(&Aabb::of([Vec3::new(0.4, 0.8, 0.2)])).iter().any(|i| i.id == id));
        assert!(world.near(&base.bounds).iter().all(|i| i.id != id));
    }

    #[test]
    fn on_a_slope_things_lean_with_it() {
        let under: Vec<Under> = [(-0.1, -0.1), (0.1, -0.1), (0.1, 0.1), (-0.1, 0.1)]
            .map(|(x, z)| Under { point: Vec3::new(x, 0.0, z), foot_m: 0.0, top_m: 0.4 + 0.1 * x - 0.05 * z })
            .to_vec();
        let lean = lean_of(&under).expect("it slopes by six degrees");
        let normal = lean * Vec3::Y;
        assert!(normal.distance(Vec3::new(-0.1, 1.0, 0.05).normalize_or(Vec3::Y)) < 1e-4, "{normal}");
        let level: Vec<Under> = under.iter().map(|u| Under { top_m: 0.4, ..*u }).collect();
        assert_eq!(lean_of(&level), None);
    }
}
