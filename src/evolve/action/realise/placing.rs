//! Whether a thing can be at a place and how it rests there: it runs into nothing (real triangles), something real is
//! under it, it does not tip, and it stays inside the room. What is cheap to tell is asked first.

use std::cell::{Cell, OnceCell};
use std::sync::Arc;

use glam::{Affine3A, Quat, Vec2, Vec3};

use super::shape::{Shape, UnderPoint};
use super::solid::{outlines_meet, outlines_part};
use super::world::{Ball, Held, Item, Lifted, Pose, Things, World, flat, outline_at, placed_bounds};
use crate::inspect::distance_to_hull;
use crate::math::Aabb;
use crate::scene::ObjectId;

/// Between a thing and what holds it, so that resting isn't running into: half a millimetre, which nobody sees.
pub const GAP_M: f32 = 0.0005;
/// A place is first asked about with the thing this far above where it would stand.
pub const TRIED_ABOVE_M: f32 = GAP_M + 0.004;
/// On a bowed surface a thing is lifted in such steps until it touches only.
const LIFTS_M: [f32; 3] = [0.0, 0.001, 0.002];
/// A point of the underside is over a surface when that lies at most this far below where the thing stands.
const BELOW_M: f32 = 0.012;
/// A contact carries when a surface, hard or soft, is this near below it; soft ones give way.
const CARRIES_M: [f32; 2] = [0.004, 0.025];
/// ADSE eq. 9: at least half of a thing is over what it stands on.
const LEAST_SHARE: f32 = 0.5;
/// The middle of its weight may be this far outside of what carries it: not at all, for the measure of what was placed
/// casts other rays and may see the edge some millimetres nearer.
const BALANCE_M: f32 = 0.0;
/// Things whose inner circles in plan overlap by this share run into each other.
pub const CORES: f32 = 0.8;
/// The middle of a thing may be inside of what stays by this much: the field is coarse and sheets are thin.
const DEEPEST_M: f32 = -0.04;
/// A thing that would rest this far below the usual height of a surface isn't on it.
const MOST_BELOW_M: f32 = 0.3;
/// What lies farther below is under nothing that rests on the surface, leaning or not: rays end there.
const LOWEST_M: f32 = MOST_BELOW_M + 0.25;
/// Rays start so far above a surface's usual height: its unevenness.
const UNEVEN_M: f32 = 0.03;
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
    /// It runs into the room, a thing or a person, or sticks out of the room.
    Collides,
    /// Less than half of it is over what would hold it, or it would tip.
    Overhangs,
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
    /// About how high it is.
    pub fn height_m(self) -> f32 {
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

/// What a placed thing must keep clear of beside the room and its things.
#[derive(Debug)]
pub struct Avoid<'a> {
    /// Things that are lifted for the moment: they don't count.
    pub lifted: &'a Lifted,
    /// People.
    pub balls: &'a [Ball],
    /// What the last place ran into: the next place is rather near to it, so it is looked at first. Tells how soon an
    /// answer is found, never which.
    met: Cell<Option<ObjectId>>,
}

impl<'a> Avoid<'a> {
    /// People, and things but for the lifted ones.
    pub fn new(lifted: &'a Lifted, balls: &'a [Ball]) -> Self {
        Self { lifted, balls, met: Cell::new(None) }
    }
}

/// What carries a thing is at most this far below it once it is put down, with the little that it is lifted to run into
/// nothing.
pub fn carries_m(soft: bool) -> f32 {
    CARRIES_M[usize::from(soft)] + LIFTS_M[LIFTS_M.len() - 1] + GAP_M
}

impl World {
    /// Whether a shape at a place runs into the room or a thing, or is wholly inside one.
    fn collides(&self, shape: &Shape, pose: &Pose, lifted: &Lifted) -> bool {
        let (world, outline) = (pose.matrix(), outline_at(shape, pose));
        let mut things = self.any_near(&placed_bounds(shape, pose)).filter(|i| !lifted.contains(&i.id));
        things.any(|item| {
            let item_from_shape = item.item_from_world() * world;
            !lie_apart(item, shape, &outline)
                && (item.shape.tree.meets(&shape.tree, &item_from_shape)
                    || encloses(item, shape, &item_from_shape))
        }) || self.stage.geometry.bvh.meets(&shape.tree, &world)
    }

    /// Whether a thing runs into one of `others`, or is wholly inside one.
    pub fn meets_any(&self, item: &Item, others: &Lifted) -> bool {
        self.any_near(&item.bounds).filter(|o| o.id != item.id && others.contains(&o.id)).any(|other| {
            let other_from_item = other.item_from_world() * item.world_from_item();
            !lie_apart(other, &item.shape, &item.outline)
                && (other.shape.tree.meets(&item.shape.tree, &other_from_item)
                    || encloses(other, &item.shape, &other_from_item))
        })
    }

    /// Whether a box is inside the room: over its plan, not below it, and not inside of what stays. Scans have no
    /// ceiling, so there is no limit above.
    pub fn is_in_the_room(&self, bounds: &Aabb, tolerance_m: f32) -> bool {
        let geometry = &self.stage.geometry;
        let room = geometry.bounds.grown(tolerance_m);
        let within = bounds.min.cmpge(room.min).all() && flat(bounds.max).cmple(flat(room.max)).all();
        within && geometry.field.sample(bounds.center()) >= DEEPEST_M - tolerance_m
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
        if !rest_m.is_finite() || rest_m < on.height_m() - MOST_BELOW_M {
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
            Under { point, foot_m, top_m: self.top_within(at, from_m, LOWEST_M, &things).0 }
        };
        shape.under.iter().map(look).collect()
    }

    /// Whether a place is taken or outside of the room, as far as that can be told without triangles.
    pub fn is_plainly_taken(
        &self,
        shape: &Shape,
        at: Vec2,
        yaw_rad: f32,
        on: Onto,
        avoid: &Avoid<'_>,
    ) -> bool {
        let nominal = above(at, yaw_rad, on);
        !self.is_in_the_room(&placed_bounds(shape, &nominal), 0.0)
            || self.is_filled(shape, &nominal, on, avoid)
    }

    /// Whether what is surely filled of a shape at a place overlaps with what is of a thing, or their middles lie in
    /// each other: quickly told, and enough for most of what collides.
    fn is_filled(&self, shape: &Shape, pose: &Pose, on: Onto, avoid: &Avoid<'_>) -> bool {
        let (middle, outline) = (pose.plan(shape.middle), OnceCell::new());
        let overlaps = |item: &Item| {
            let apart_m = item.pose.plan(item.shape.middle).distance(middle);
            apart_m < CORES * (item.shape.core_m + shape.core_m) || {
                let solids = shape.solid.as_ref().zip(item.shape.solid.as_ref());
                solids.is_some_and(|(solid, theirs)| {
                    !item.solid.is_empty()
                        && solid.is_level_with(pose.at.y, theirs, item.pose.at.y)
                        && outlines_meet(outline.get_or_init(|| solid.placed(pose)), &item.solid)
                })
            }
        };
        let counts = |item: &Item| !avoid.lifted.contains(&item.id) && on.item() != Some(item.id);
        self.any_near(&placed_bounds(shape, pose)).any(|item| overlaps(item) && counts(item))
    }

    /// Things near a shape at a place, but for what it stands on and what is lifted.
    fn others_near(&self, shape: &Shape, pose: &Pose, on: Onto, avoid: &Avoid<'_>) -> Vec<&Arc<Item>> {
        let counts = |item: &&Arc<Item>| !avoid.lifted.contains(&item.id) && on.item() != Some(item.id);
        self.any_near(&placed_bounds(shape, pose)).filter(counts).collect()
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
        let nominal = above(at, yaw_rad, on);
        if !self.is_in_the_room(&placed_bounds(shape, &nominal), 0.0) {
            return Err(Refused::Collides);
        }
        match self.is_filled(shape, &nominal, on, avoid) {
            true => Err(Refused::Collides),
            false => self.place_among(shape, &nominal, on, avoid),
        }
    }

    /// As [`World::place`], where [`World::is_plainly_taken`] was asked already.
    ///
    /// # Errors
    /// [`Refused`].
    pub fn place_closely(
        &self,
        shape: &Shape,
        at: Vec2,
        yaw_rad: f32,
        on: Onto,
        avoid: &Avoid<'_>,
    ) -> Result<Rest, Refused> {
        self.place_among(shape, &above(at, yaw_rad, on), on, avoid)
    }

    /// Sets a thing down from a little above where it would stand, among the things near it.
    fn place_among(
        &self,
        shape: &Shape,
        nominal: &Pose,
        on: Onto,
        avoid: &Avoid<'_>,
    ) -> Result<Rest, Refused> {
        let near = self.others_near(shape, nominal, on, avoid);
        if Self::touches(shape, nominal, avoid.balls) || runs_into(&near, shape, nominal, avoid) {
            return Err(Refused::Collides);
        }
        let rest = self.set_down(shape, flat(nominal.at), nominal.yaw_rad, on)?;
        for lift_m in LIFTS_M {
            let pose = Pose { at: rest.pose.at + Vec3::Y * lift_m, ..rest.pose };
            // What leans reaches farther than what was asked about upright.
            if !self.is_in_the_room(&placed_bounds(shape, &pose), 0.0) {
                return Err(Refused::Collides);
            }
            if !self.collides(shape, &pose, avoid.lifted) {
                let clear = !Self::touches(shape, &pose, avoid.balls);
                return if clear { Ok(Rest { pose, ..rest }) } else { Err(Refused::Collides) };
            }
        }
        Err(Refused::Collides)
    }
}

/// A few millimetres above where a thing would stand.
fn above(at: Vec2, yaw_rad: f32, on: Onto) -> Pose {
    Pose::upright(Vec3::new(at.x, on.height_m() + TRIED_ABOVE_M, at.y), yaw_rad)
}

fn runs_into(near: &[&Arc<Item>], shape: &Shape, pose: &Pose, avoid: &Avoid<'_>) -> bool {
    let (world, outline) = (pose.matrix(), outline_at(shape, pose));
    let meets = |item: &Item| {
        let item_from_shape = item.item_from_world() * world;
        !lie_apart(item, shape, &outline)
            && (shape.spine.pierces(&item.shape.tree, &item_from_shape)
                || item.shape.spine.pierces(&shape.tree, &item_from_shape.inverse())
                || item.shape.tree.meets(&shape.tree, &item_from_shape))
    };
    let last = avoid.met.get();
    let is_last = |item: &&&Arc<Item>| Some(item.id) == last;
    let first = near.iter().find(is_last).filter(|item| meets(item));
    let met = first.or_else(|| near.iter().find(|item| Some(item.id) != last && meets(item)));
    if let Some(item) = met {
        avoid.met.set(Some(item.id));
    }
    met.is_some()
}

/// Rounding in outlines, metres.
const OUTLINE_M: f32 = 1e-4;

/// Whether a thing and a shape with this outline lie beside each other, seen from above: they can't meet then. Not told
/// of what leans.
fn lie_apart(item: &Item, shape: &Shape, outline: &[Vec2]) -> bool {
    outlines_part(outline, &item.outline, shape.slack_m + item.shape.slack_m + OUTLINE_M)
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

#[cfg(test)]
mod tests {
    use super::super::shape::tests::block_triangles;
    use super::super::world::tests::world;
    use super::*;

    fn block(size: Vec3) -> Shape {
        Shape::new(block_triangles(size))
    }

    #[test]
    fn things_stand_on_the_table_hang_over_by_less_than_half_and_never_share_a_place() {
        let world = world();
        let top = world.stage.work_surface(ObjectId(1)).expect("the table has a top");
        let onto = Onto::Surface { number: top, height_m: 0.75, soft: false };
        let lifted = Lifted::new();
        let avoid = Avoid::new(&lifted, &[]);
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
        let beside = Avoid::new(&lifted, &person);
        assert_eq!(world.place(&book, Vec2::new(0.3, 0.2), 0.3, onto, &beside), Err(Refused::Collides));
    }

    #[test]
    fn what_would_stick_out_of_the_room_is_refused() {
        let world = world();
        let onto = Onto::Surface { number: world.stage.floor(), height_m: 0.0, soft: false };
        let lifted = Lifted::new();
        let avoid = Avoid::new(&lifted, &[]);
        let case = block(Vec3::new(0.4, 0.3, 0.4));
        let put = |x: f32| world.place(&case, Vec2::new(x, 0.0), 0.0, onto, &avoid);
        assert!(put(1.7).is_ok(), "the floor ends at two metres");
        assert_eq!(put(1.85), Err(Refused::Collides), "three quarters on the floor, the rest outside");
    }

    /// Looked at closely, what is told quickly holds: lines in something are a meeting, outlines apart are none.
    #[test]
    fn lines_and_outlines_never_say_what_triangles_deny() {
        let knife = block(Vec3::new(0.02, 0.004, 0.2));
        let world = world();
        let table = world.item(ObjectId(2)).expect("the box on the table");
        let (mut pierced, mut apart, mut met) = (0, 0, 0);
        for i in 0..600 {
            let angle = 0.37 * i as f32;
            let off = Vec2::from_angle(1.7 * i as f32) * 0.0003 * i as f32;
            let at = table.pose.at + Vec3::new(off.x, 0.004, off.y);
            let pose = Pose::upright(at, angle);
            let item_from_shape = table.item_from_world() * pose.matrix();
            let meets = table.shape.tree.meets(&knife.tree, &item_from_shape)
                || encloses(table, &knife, &item_from_shape);
            let by_lines = knife.spine.pierces(&table.shape.tree, &item_from_shape)
                || table.shape.spine.pierces(&knife.tree, &item_from_shape.inverse());
            let by_outline = lie_apart(table, &knife, &outline_at(&knife, &pose));
            assert!(meets || !by_lines, "a line meets and no triangle does, {pose:?}");
            assert!(!(meets && by_outline), "apart and meeting, {pose:?}");
            pierced += usize::from(by_lines);
            apart += usize::from(by_outline);
            met += usize::from(meets);
        }
        assert!(pierced > met / 2 && apart > (600 - met) / 2, "{pierced} of {met} met, {apart} of 600 apart");
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
