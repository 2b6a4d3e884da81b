//! Where every movable thing is at one moment, what is near a place, and what stands on what. A change costs what the
//! changed thing costs, whatever the room holds.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use glam::{Affine3A, Quat, Vec2, Vec3};

use super::library::{KindId, Thing};
use super::placing::Rest;
use super::shape::Shape;
use super::squares::Squares;
use super::stage::{Found, Laid, Stage};
use crate::math::Aabb;
use crate::scene::ObjectId;

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
    /// Outline of what of it is surely filled, in the world's plan; empty where it leans or nothing is.
    pub solid: Vec<Vec2>,
    /// Its outline in the world's plan; empty where it leans.
    pub outline: Vec<Vec2>,
    /// How it lies once somebody moved it, for what leaned against something when it was found.
    laid: Option<Arc<Laid>>,
    /// From the frame that it was found in, about the middle of its underside, to its own.
    item_from_found: Affine3A,
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
            solid: Vec::new(),
            outline: Vec::new(),
            laid: found.laid.clone(),
            item_from_found: Affine3A::IDENTITY,
        };
        item.put(pose);
        item
    }

    fn put(&mut self, pose: Pose) {
        self.pose = pose;
        self.world = pose.matrix();
        self.inverse = self.world.inverse();
        self.bounds = placed_bounds(&self.shape, &pose);
        let upright = pose.lean == Quat::IDENTITY;
        let solid = self.shape.solid.as_ref().filter(|_| upright);
        self.solid = solid.map_or_else(Vec::new, |solid| solid.placed(&pose));
        self.outline = outline_at(&self.shape, &pose);
    }

    /// From its frame to the world.
    pub fn world_from_item(&self) -> Affine3A {
        self.world
    }

    /// From the world to its frame.
    pub fn item_from_world(&self) -> Affine3A {
        self.inverse
    }

    /// From where the thing was found, about the middle of its underside there, to the world now.
    pub fn world_from_found(&self) -> Affine3A {
        self.world * self.item_from_found
    }

    /// The thing as it is put down anywhere else: what leaned against something lies flat then.
    #[must_use]
    pub fn to_be_moved(&self) -> Self {
        let Some(laid) = &self.laid else { return self.clone() };
        Self { shape: laid.shape.clone(), item_from_found: laid.laid_from_found, laid: None, ..self.clone() }
    }
}

/// The outline of an upright shape at a place; empty where it leans.
pub fn outline_at(shape: &Shape, pose: &Pose) -> Vec<Vec2> {
    if pose.lean == Quat::IDENTITY { shape.plan.iter().map(|p| pose.plan(*p)).collect() } else { Vec::new() }
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

/// A part of a body: where it is and how thick.
pub type Ball = (Vec3, f32);

/// What is looked past: things that are lifted for the moment.
pub type Lifted = BTreeSet<ObjectId>;

/// Every movable thing's place.
#[derive(Clone, Debug)]
pub struct World {
    /// What stays.
    pub stage: Arc<Stage>,
    items: BTreeMap<ObjectId, Arc<Item>>,
    squares: Squares,
    next_id: u32,
}

impl World {
    /// The room as it was found.
    pub fn new(stage: Arc<Stage>) -> Self {
        let next_id = stage.room.objects.iter().map(|o| o.id.0 + 1).max().unwrap_or(0);
        let squares = Squares::over(&stage.geometry.bounds);
        let mut world = Self { stage: stage.clone(), items: BTreeMap::new(), squares, next_id };
        for found in &stage.movable {
            world.restore(Arc::new(Item::new(found, stage.name_of(found.id))));
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
                let item = Item { held, ..(**item).clone() };
                self.restore(Arc::new(item));
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
        let found = Found { id, kind: Some(kind), shape: thing.shape.clone(), at: rest.pose.at, laid: None };
        let mut item = Item::new(&found, name);
        item.source = Source::Brought { thing: thing.clone(), step };
        item.held = rest.held;
        item.put(rest.pose);
        self.restore(Arc::new(item));
    }

    /// Moves a thing.
    pub fn put(&mut self, id: ObjectId, rest: &Rest) {
        let Some(item) = self.items.get(&id) else { return };
        let mut item = item.to_be_moved();
        item.put(rest.pose);
        item.held = rest.held;
        self.restore(Arc::new(item));
    }

    /// A thing is again as it was.
    pub fn restore(&mut self, item: Arc<Item>) {
        self.leave(item.id);
        self.squares.enter(&item);
        self.items.insert(item.id, item);
    }

    /// Locks or frees a thing.
    pub fn lock(&mut self, id: ObjectId, locked: bool) {
        if let Some(item) = self.items.get(&id) {
            let item = Item { locked, ..(**item).clone() };
            self.restore(Arc::new(item));
        }
    }

    /// Takes a thing out.
    pub fn leave(&mut self, id: ObjectId) -> Option<Arc<Item>> {
        let item = self.items.remove(&id)?;
        self.squares.leave(&item);
        Some(item)
    }

    /// Things whose boxes touch `bounds`, each once, in the order of their numbers.
    pub fn near(&self, bounds: &Aabb) -> Vec<&Arc<Item>> {
        let mut items: Vec<&Arc<Item>> = self.any_near(bounds).collect();
        items.sort_unstable_by_key(|i| i.id);
        items
    }

    /// The same in any order.
    pub fn any_near<'a>(&'a self, bounds: &Aabb) -> impl Iterator<Item = &'a Arc<Item>> + use<'a> {
        self.squares.near(bounds)
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

    /// The highest point below `from_m` at a place of the plan, and whose it is: the room's or one of `things`.
    pub fn top_below(&self, at: Vec2, from_m: f32, things: &Things<'_>) -> (f32, Option<ObjectId>) {
        self.top_within(at, from_m, 4.0, things)
    }

    /// The same down to `reach_m` below `from_m` only: soon told where that is not far.
    pub fn top_within(
        &self,
        at: Vec2,
        from_m: f32,
        reach_m: f32,
        things: &Things<'_>,
    ) -> (f32, Option<ObjectId>) {
        let from = Vec3::new(at.x, from_m, at.y);
        let cast = self.stage.geometry.bvh.cast(from, Vec3::NEG_Y, reach_m);
        let mut best = (cast.map_or(f32::NEG_INFINITY, |h| from_m - h.distance_m), None);
        if matches!(things, Things::None) {
            return best;
        }
        let column = Aabb { min: from.with_y(best.0.max(from_m - reach_m)), max: from };
        for item in self.any_near(&column).filter(|i| things.count(i.id)) {
            let local = item.inverse.transform_point3(from);
            let down = item.inverse.transform_vector3(Vec3::NEG_Y);
            if let Some(hit) = item.shape.tree.cast(local, down, reach_m)
                && from_m - hit.distance_m > best.0
            {
                best = (from_m - hit.distance_m, Some(item.id));
            }
        }
        best
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
    /// Whether this one counts.
    pub fn count(&self, id: ObjectId) -> bool {
        match self {
            Self::None => false,
            Self::Only(one) => *one == id,
            Self::AllBut(lifted) => !lifted.contains(&id),
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::library::Library;
    use super::super::placing::{Avoid, Onto};
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
    pub fn world() -> World {
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

    #[test]
    fn what_stands_on_something_is_known_and_moves_are_by_value() {
        let mut world = world();
        let before = world.clone();
        let id = ObjectId(2);
        let base = world.item(id).expect("there").clone();
        assert!(matches!(base.held, Held::Surface(_)), "{:?}", base.held);
        let lifted = Lifted::new();
        let avoid = Avoid::new(&lifted, &[]);
        let coin = Shape::new(block_triangles(Vec3::new(0.03, 0.005, 0.03)));
        let onto = Onto::Item { id, top_m: base.bounds.max.y };
        let rest = world.place(&coin, Vec2::new(0.01, 0.0), 0.0, onto, &avoid).expect("on the box");
        assert!((rest.pose.at.y - 0.85).abs() < 0.002, "{rest:?}");
        let found =
            Found { id: ObjectId(9), kind: None, shape: Arc::new(coin), at: rest.pose.at, laid: None };
        let mut coin = Item::new(&found, "Coin".to_owned());
        coin.held = rest.held;
        world.restore(Arc::new(coin));
        assert_eq!(world.carried_by(id), [ObjectId(9)]);
        world.put(id, &Rest { pose: Pose::upright(Vec3::new(0.4, 0.75, 0.2), 1.0), ..rest });
        assert_eq!(before.item(id).map(|i| i.pose), Some(base.pose), "the copy is untouched");
        assert!(world.near(&Aabb::of([Vec3::new(0.4, 0.8, 0.2)])).iter().any(|i| i.id == id));
        assert!(world.near(&base.bounds).iter().all(|i| i.id != id));
    }
}
