//! What stays where it is while a room is lived in: building, large furniture, and the surfaces they offer; and what
//! may be moved. Made once for a room (it bakes a distance field), shared by every evolution of it.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::sync::Arc;

use glam::{Affine3A, Quat, Vec2, Vec3};

use super::library::{Ground, KindId, Library};
use super::shape::Shape;
use crate::evolve::action::KeyObject;
use crate::generate::{Place, all_places};
use crate::inspect::distance_to_hull;
use crate::job::{Cancelled, Seed, Ticker};
use crate::math::Aabb;
use crate::scene::{Category, GeometryConfig, Object, ObjectId, Room, RoomGeometry, SupportSurface};

/// Chairs wider or deeper than this are armchairs and stay.
const WIDEST_CHAIR_M: f32 = 0.72;
/// Things larger than this stay unless they are chairs.
const LARGEST_THING_M: f32 = 0.9;
/// Flat things larger than this are rugs and mats.
const LARGEST_FLAT_M: f32 = 0.75;
/// A floor may lie this far from `y = 0`.
const FLOOR_RANGE_M: f32 = 0.12;
/// Nothing is put on the floor this near to a door.
const BEFORE_DOOR_M: f32 = 0.8;
/// Tops higher than this are out of reach.
const HIGHEST_TOP_M: f32 = 1.5;
/// A table without a better name serves as desk or dining table from this size of its top.
const LEAST_TABLE_M2: f32 = 0.4;
/// Smaller tops are no key objects.
const LEAST_TOP_M2: f32 = 0.12;
/// A surface with less room above is no place to work at.
const WORK_CLEARANCE_M: f32 = 0.3;

/// A thing whose weight is this far outside of what it touches the ground with leans against something.
const LEANS_M: f32 = 0.01;
/// Directions that are tried for laying something flat.
const WAYS: usize = 1024;
/// Golden angle, radians.
const GOLDEN_RAD: f32 = 2.399_963;

/// Somewhere things can stand: cells of a few centimetres at about one height.
#[derive(Clone, Debug)]
pub struct Surface {
    /// What it is.
    pub ground: Ground,
    /// Whose it is; `None` for the floor.
    pub owner: Option<ObjectId>,
    /// Points on it, with the free height above.
    pub cells: Vec<(Vec3, f32)>,
    /// Spacing of the cells.
    pub cell_m: f32,
    /// Mean height.
    pub height_m: f32,
    /// Whether it gives way: beds, couches.
    pub soft: bool,
}

/// A movable object of the room as it was found.
#[derive(Clone, Debug)]
pub struct Found {
    /// The object.
    pub id: ObjectId,
    /// What the library takes it for.
    pub kind: Option<KindId>,
    /// Its geometry, about the middle of its underside.
    pub shape: Arc<Shape>,
    /// Where the middle of its underside is.
    pub at: Vec3,
    /// How it lies anywhere else, when it leans against something here and would fall without it.
    pub laid: Option<Arc<Laid>>,
}

/// A thing turned so that it is as low as can be: what leaned against something, lying.
#[derive(Debug)]
pub struct Laid {
    /// Its geometry, about the middle of its underside.
    pub shape: Arc<Shape>,
    /// From the frame that it was found in.
    pub laid_from_found: Affine3A,
}

/// The fixed part of a room.
#[derive(Debug)]
pub struct Stage {
    /// The room as it was given.
    pub room: Arc<Room>,
    /// Geometry of what stays.
    pub geometry: RoomGeometry,
    /// Everything that things can stand on; the floor last.
    pub surfaces: Vec<Surface>,
    /// Objects that serve as each key object.
    pub keys: BTreeMap<KeyObject, Vec<ObjectId>>,
    /// Where people can sit and lie on what stays.
    pub places: Vec<Place>,
    /// What may be moved.
    pub movable: Vec<Found>,
    /// What is used where it is, such as a television on the wall: kind, object and middle.
    pub fixed: Vec<(KindId, ObjectId, Vec3)>,
    /// What a room's things are taken for.
    pub library: Arc<Library>,
}

impl Stage {
    /// Understands a room: what stays, what may move, where things and people can be. Takes seconds for a room whose
    /// distance field isn't in the cache.
    ///
    /// # Errors
    /// [`Cancelled`] once the user cancelled.
    pub fn new(room: Arc<Room>, library: Arc<Library>, ticker: &Ticker) -> Result<Self, Cancelled> {
        let mut fixed = (*room).clone();
        let (mut movable, mut in_place) = (Vec::new(), Vec::new());
        for object in fixed.objects.iter_mut().filter(|o| o.visible) {
            if let Some(kind) = movable_kind(object, &library) {
                object.visible = false;
                movable.push(found(object, kind));
            } else if let Some(kind) = used_in_place(object, &library) {
                in_place.push((kind, object.id, object.world_bounds().center()));
            }
        }
        let step = |done: usize, total: usize| match ticker.step(done, total) {
            Ok(()) => ControlFlow::Continue(()),
            Err(Cancelled) => ControlFlow::Break(()),
        };
        ticker.stage("understanding what stays", 0)?;
        library.warm();
        let geometry =
            RoomGeometry::build(&fixed, &GeometryConfig::default(), &step).map_err(|_| Cancelled)?;
        let places = all_places(&fixed, &geometry, Seed::root(0), ticker)?;
        let mut surfaces: Vec<Surface> =
            geometry.supports.iter().filter_map(|s| surface_of(&fixed, s)).collect();
        surfaces.push(floor_of(&fixed, &geometry));
        let keys = key_objects(&fixed, &surfaces);
        Ok(Self { room, geometry, surfaces, keys, places, movable, fixed: in_place, library })
    }

    /// Number of the floor among the surfaces.
    pub fn floor(&self) -> usize {
        self.surfaces.len() - 1
    }

    /// Where somebody works at an object: the largest of its tops with room above.
    pub fn work_surface(&self, owner: ObjectId) -> Option<usize> {
        let of_owner = self.surfaces.iter().enumerate().filter(|(_, s)| s.owner == Some(owner));
        let clear = |s: &Surface| s.cells.iter().filter(|c| c.1 > WORK_CLEARANCE_M).count();
        of_owner.max_by_key(|(i, s)| (clear(s), std::cmp::Reverse(*i))).map(|(i, _)| i)
    }

    /// The middle of an object's work surface, or of its box.
    pub fn centre_of(&self, id: ObjectId) -> Vec3 {
        let surface = self.work_surface(id).map(|i| &self.surfaces[i]);
        let middle = surface.filter(|s| !s.cells.is_empty()).map(|s| {
            let bounds = Aabb::of(s.cells.iter().map(|c| c.0));
            bounds.center().with_y(s.height_m)
        });
        middle.unwrap_or_else(|| self.room.object(id).map_or(Vec3::ZERO, |o| o.world_bounds().center()))
    }

    /// Name of an object.
    pub fn name_of(&self, id: ObjectId) -> String {
        self.room.object(id).map_or_else(|| format!("object {}", id.0), |o| o.name.clone())
    }
}

/// What the library takes a movable object for; `None` for what stays, `Some(None)` for things without a kind.
#[expect(clippy::option_option, reason = "stays, or may move and is of no known kind")]
fn movable_kind(object: &Object, library: &Library) -> Option<Option<KindId>> {
    if object.locked || object.category.is_structure() || object.parts.is_empty() {
        return None;
    }
    let size = object.world_bounds().size();
    let longest = size.max_element();
    if matches!(object.category, Category::Chair | Category::Stool) {
        let fits = size.x.max(size.z) < WIDEST_CHAIR_M && size.y < 1.3;
        let kind = if object.category == Category::Chair { "chair" } else { "stool" };
        return fits.then(|| library.named(kind));
    }
    let is_loose = matches!(
        object.category,
        Category::Objects
            | Category::Cushion
            | Category::Plant
            | Category::TvMonitor
            | Category::Lighting
            | Category::Clothes
            | Category::Towel
            | Category::Appliances
    );
    let is_mat = size.y < 0.03 && size.x.max(size.z) > LARGEST_FLAT_M;
    if !is_loose || longest > LARGEST_THING_M || is_mat {
        return None;
    }
    let kind = match object.category {
        // A screen on a desk is a computer's; a television stays where it is.
        Category::TvMonitor if size.x.max(size.z) < LARGEST_FLAT_M => library.named("monitor"),
        Category::TvMonitor => return None,
        Category::Cushion => library.named("cushion"),
        _ => library.of_name(&object.name),
    };
    // Lamps and appliances without a kind hang on walls and ceilings or are built in.
    let hangs = matches!(object.category, Category::Lighting | Category::Appliances | Category::Towel);
    (kind.is_some() || !hangs).then_some(kind)
}

/// What the library takes something for that stays where it is and is used there.
fn used_in_place(object: &Object, library: &Library) -> Option<KindId> {
    match object.category {
        Category::TvMonitor => library.named("tv"),
        Category::Appliances => library.of_name(&object.name).filter(|k| library.kind(*k).stays),
        _ => None,
    }
}

fn found(object: &Object, kind: Option<KindId>) -> Found {
    let bounds = object.world_bounds();
    let at = bounds.center().with_y(bounds.min.y);
    let own = Affine3A::from_translation(-at);
    let triangles = object.world_triangles().map(|t| t.map(|p| own.transform_point3(p))).collect();
    let shape = Shape::new(triangles);
    let is_seat = matches!(object.category, Category::Chair | Category::Stool);
    let laid = if is_seat { None } else { lying(&shape).map(Arc::new) };
    Found { id: object.id, kind, shape: Arc::new(shape), at, laid }
}

/// A thing that would fall over on an even floor, laid down.
fn lying(shape: &Shape) -> Option<Laid> {
    let contacts: Vec<Vec2> = shape.under.iter().filter(|p| p.contact).map(|p| p.at).collect();
    if distance_to_hull(&contacts, shape.middle) < LEANS_M {
        return None;
    }
    let corners = || shape.tree.triangles().iter().flatten();
    let height_m = |up: Vec3| {
        let (low, high) =
            corners().map(|p| p.dot(up)).fold((f32::MAX, f32::MIN), |(l, h), d| (l.min(d), h.max(d)));
        high - low
    };
    // Points of a spiral over half the sphere (Fibonacci's): four degrees apart.
    let way = |i: usize| {
        let y = (i as f32 + 0.5) / WAYS as f32;
        let (sin, cos) = (i as f32 * GOLDEN_RAD).sin_cos();
        Vec3::new(cos, 0.0, sin) * (1.0 - y * y).sqrt() + Vec3::Y * y
    };
    let lowest =
        (0..WAYS).map(|i| (height_m(way(i)), i)).min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let turn = Affine3A::from_quat(Quat::from_rotation_arc(way(lowest?.1), Vec3::Y));
    let bounds = Aabb::of(corners().map(|p| turn.transform_point3(*p)));
    let middle = bounds.center().with_y(bounds.min.y);
    let laid_from_found = Affine3A::from_translation(-middle) * turn;
    let laid = shape.tree.triangles().iter().map(|t| t.map(|p| laid_from_found.transform_point3(p)));
    Some(Laid { shape: Arc::new(Shape::new(laid.collect())), laid_from_found })
}

/// What a surface is to those who put things down; `None` for what nothing is put on.
fn ground_of(category: Category, surface: &SupportSurface) -> Option<Ground> {
    match category {
        c if c.is_table() => Some(Ground::Table),
        Category::Bed | Category::Sofa | Category::Chair | Category::Stool | Category::Seating => {
            Some(Ground::Seat)
        }
        Category::Cabinet
        | Category::ChestOfDrawers
        | Category::Shelving
        | Category::Furniture
        | Category::Fireplace => Some(Ground::Stand),
        // A scan's furniture has no names: a top of a table's height and size is one.
        Category::Unlabeled | Category::Misc | Category::Objects
            if (0.3..1.2).contains(&surface.height_m) && surface.area_m2 > 0.2 =>
        {
            Some(Ground::Table)
        }
        _ => None,
    }
}

fn surface_of(room: &Room, surface: &SupportSurface) -> Option<Surface> {
    if surface.height_m > HIGHEST_TOP_M {
        return None;
    }
    let category = surface.object.and_then(|id| room.object(id)).map_or(Category::Unlabeled, |o| o.category);
    let ground = ground_of(category, surface)?;
    Some(Surface {
        ground,
        owner: surface.object,
        cells: surface.cells.iter().map(|c| (c.position, c.clearance_m)).collect(),
        cell_m: surface.cell_m,
        height_m: surface.height_m,
        soft: ground == Ground::Seat,
    })
}

/// The floor where things can be put: in the open, not before doors.
fn floor_of(room: &Room, geometry: &RoomGeometry) -> Surface {
    let doors: Vec<Aabb> = room
        .objects
        .iter()
        .filter(|o| o.visible && o.category == Category::Door)
        .map(Object::world_bounds)
        .collect();
    let floor = &geometry.floor;
    let point = |cell: usize| {
        let at = floor.position(cell);
        let hit =
            geometry.bvh.cast(at.with_y(FLOOR_RANGE_M + 0.02), Vec3::NEG_Y, 2.0 * FLOOR_RANGE_M + 0.02)?;
        let on = at.with_y(FLOOR_RANGE_M + 0.02 - hit.distance_m);
        let near_door = doors.iter().any(|d| {
            let to = Vec2::new(on.x, on.z).clamp(Vec2::new(d.min.x, d.min.z), Vec2::new(d.max.x, d.max.z));
            to.distance(Vec2::new(on.x, on.z)) < BEFORE_DOOR_M
        });
        let open = geometry.field.sample(on + Vec3::Y * 0.06) > 0.02;
        let up = geometry.bvh.cast(on + Vec3::Y * 0.01, Vec3::Y, 3.0).map_or(3.0, |h| h.distance_m);
        (open && !near_door).then_some((on, up))
    };
    let cells: Vec<(Vec3, f32)> = (0..floor.height_m.len()).filter_map(point).collect();
    Surface { ground: Ground::Floor, owner: None, cells, cell_m: floor.cell_m, height_m: 0.0, soft: false }
}

/// Which objects serve as which key object: those of the best category that is there. They need a surface.
fn key_objects(room: &Room, surfaces: &[Surface]) -> BTreeMap<KeyObject, Vec<ObjectId>> {
    let top_m2 = |id: ObjectId| {
        let tops = surfaces.iter().filter(|s| s.owner == Some(id));
        tops.map(|s| s.cells.len() as f32 * s.cell_m * s.cell_m).fold(0.0, f32::max)
    };
    let of = |category: Category| -> Vec<ObjectId> {
        // What is only called a table may be a nightstand.
        let least_m2 = if category == Category::Table { LEAST_TABLE_M2 } else { LEAST_TOP_M2 };
        let same =
            room.objects.iter().filter(|o| o.visible && o.category == category && top_m2(o.id) > least_m2);
        same.map(|o| o.id).collect()
    };
    let serving = |key: KeyObject| key.categories().iter().map(|c| of(*c)).find(|found| !found.is_empty());
    KeyObject::ALL.into_iter().map(|key| (key, serving(key).unwrap_or_default())).collect()
}

#[cfg(test)]
mod tests {
    use super::super::shape::tests::block_triangles;
    use super::*;

    #[test]
    fn what_leaned_against_something_lies_flat_once_it_is_moved() {
        let cushion = block_triangles(Vec3::new(0.4, 0.1, 0.4));
        let tilted = Affine3A::from_rotation_x(1.0);
        let leaning: Vec<_> = cushion.iter().map(|t| t.map(|p| tilted.transform_point3(p))).collect();
        let laid = lying(&Shape::new(leaning)).expect("it stands on an edge: it would fall");
        let size = laid.shape.bounds.size();
        assert!(size.y < 0.13, "{size}: about as high as the cushion is thick");
        assert!(laid.shape.bounds.min.y.abs() < 1e-4, "about the middle of its underside");
        assert!(lying(&Shape::new(cushion)).is_none(), "what lies stays as it is");
    }
}
