//! Where the person of an action goes (ADSE §5.2): on the key object, or around it on a chair or on their feet.
//! Drawn places are rejected until one is free.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{Vec2, Vec3};
use rand::RngExt as _;

use super::chair::ChairSeat;
use super::figure::{Figure, Spot};
use super::library::{KindId, Thing};
use super::placing::{Avoid, Onto, Rest};
use super::world::{Ball, Lifted, Pose, World, flat};
use crate::body::{Body, FamilyHints, LeanStyle};
use crate::evolve::action::{ActionNode, KeyObject, KeyRelation, PersonFrame, Posture};
use crate::generate::Place;
use crate::job::Rng;
use crate::scene::{BodyParams, EdgePoint, ObjectId, PoseFamily, direction_of, facing_of};

/// Places that are drawn before there is none.
const ATTEMPTS: usize = 160;
/// From a table's edge out to the pelvis of somebody who sits at it.
const SIT_OFF_M: std::ops::Range<f32> = 0.2..0.34;
/// The same at a coffee table, where knees and shins need the room.
const SIT_OFF_LOW_M: std::ops::Range<f32> = 0.42..0.6;
/// From a counter's edge out to the pelvis of somebody who stands at it.
const STAND_OFF_M: std::ops::Range<f32> = 0.17..0.26;
/// Free space that a body needs before an edge.
const BODY_FREE_M: f32 = 0.4;
/// Who sits or stands at an edge faces it up to this angle, radians.
const MOST_TURN: f32 = 0.6;
/// Chairs farther away than this stay where they are.
const CHAIR_REACH_M: f32 = 4.0;
/// A table suits a seat that is so much lower.
const TABLE_OVER_SEAT_M: std::ops::Range<f32> = 0.15..0.42;
/// Tables lower than this are sat at from sofas, or with the knees beside them.
const LOW_TABLE_M: f32 = 0.58;
/// From a seat's place to the coffee table in front of it.
const COFFEE_REACH_M: std::ops::Range<f32> = 0.2..1.15;
/// Weight sinks into a seat this far.
const SINK_M: f32 = 0.015;
/// Spots compared where something that stays put, such as a television, is to be seen.
const COMPARED: usize = 14;
/// Seat heights of new chairs: that of the library's.
const CHAIR_M: f32 = 0.46;

/// The chair of somebody who sits at a table.
#[derive(Clone, Debug)]
pub struct ChairUse {
    /// The chair; a new one's number is given when it is brought.
    pub chair: Chair,
    /// Where it stands.
    pub rest: Rest,
}

/// Which chair.
#[derive(Clone, Debug)]
pub enum Chair {
    /// One of the room's things.
    Item(ObjectId),
    /// A new one.
    New(KindId, Arc<Thing>),
}

/// Somebody placed for an action.
#[derive(Clone, Debug)]
pub struct PlacedPerson {
    /// Representative pose.
    pub figure: Arc<Figure>,
    /// Where.
    pub spot: Spot,
    /// Frame of the learned layouts.
    pub frame: PersonFrame,
    /// Their chair, if they sit on one.
    pub chair: Option<ChairUse>,
    /// Name of what holds them.
    pub on: String,
    /// The place for whoever fits a body: seat, facing, heights.
    pub place: Place,
}

impl PlacedPerson {
    /// The representative body.
    pub fn params(&self) -> BodyParams {
        self.figure.params_at(&self.spot, Body::bundled())
    }

    /// What must keep clear of them: torso, head and legs.
    pub fn trunk(&self) -> Vec<Ball> {
        self.figure.trunk_at(&self.spot)
    }
}

/// Looks for places in one room for one action.
pub struct SpotFinder<'a> {
    /// The room now.
    pub world: &'a World,
    /// The action.
    pub node: &'a ActionNode,
    /// Where it happens.
    pub key: ObjectId,
    /// Things that are lifted for the moment.
    pub lifted: &'a Lifted,
    /// People who are there already, of the same action.
    pub others: &'a [PlacedPerson],
    /// How far people are from each other, metres (eq. 7).
    pub apart_m: Option<[f32; 2]>,
    /// The person as drawn for each family: places are tried with one and the same body.
    pub figures: RefCell<BTreeMap<PoseFamily, Arc<Figure>>>,
}

impl SpotFinder<'_> {
    /// A free place; where things that stay must be seen, the best of a few by `likes`.
    ///
    /// # Errors
    /// Why there is none, for people.
    pub fn find(
        &self,
        rng: &mut Rng,
        likes: Option<&dyn Fn(&PersonFrame) -> f64>,
    ) -> Result<PlacedPerson, String> {
        let mut best: Option<(f64, PlacedPerson)> = None;
        let (mut found, wanted) = (0, if likes.is_some() { COMPARED } else { 1 });
        for _ in 0..ATTEMPTS {
            let Some(person) = self.draw(rng) else { continue };
            let value = likes.map_or(0.0, |likes| likes(&person.frame));
            if best.as_ref().is_none_or(|(most, _)| value > *most) {
                best = Some((value, person));
            }
            found += 1;
            if found == wanted {
                break;
            }
        }
        best.map(|(_, person)| person).ok_or_else(|| {
            let name = self.world.stage.name_of(self.key);
            format!(
                "no free place for somebody {} at {name}: {ATTEMPTS} places ran into something",
                self.node.posture.label()
            )
        })
    }

    fn draw(&self, rng: &mut Rng) -> Option<PlacedPerson> {
        let low_table = self.is_table() && self.table_m() < LOW_TABLE_M;
        match (self.node.relation, self.node.posture) {
            (KeyRelation::Around, Posture::Sit | Posture::SitStraight) if self.is_table() => {
                let sofa = low_table.then(|| self.on_a_seat_before_it(rng)).flatten();
                sofa.or_else(|| self.on_a_chair(rng))
            }
            (KeyRelation::Around, Posture::Stand) => self.on_the_feet(rng),
            _ => self.on_it(rng),
        }
    }

    /// The person in a family, drawn at the first place that asks.
    fn figure(&self, family: PoseFamily, hints: &FamilyHints, rng: &mut Rng) -> Arc<Figure> {
        let mut figures = self.figures.borrow_mut();
        let drawn = || Arc::new(Figure::draw(Body::bundled(), family, hints, rng));
        figures.entry(family).or_insert_with(drawn).clone()
    }

    fn is_table(&self) -> bool {
        !matches!(self.node.key, KeyObject::Bed | KeyObject::Couch)
    }

    /// Height of the key object's work surface.
    fn table_m(&self) -> f32 {
        let stage = &self.world.stage;
        stage.work_surface(self.key).map_or(0.75, |i| stage.surfaces[i].height_m)
    }

    /// A free edge of the key object, and the pelvis of somebody `off` before it.
    fn before_an_edge(&self, off: std::ops::Range<f32>, rng: &mut Rng) -> Option<(EdgePoint, Vec2, f32)> {
        let table_m = self.table_m();
        let geometry = &self.world.stage.geometry;
        let of_key = geometry.supports.iter().filter(|s| s.object == Some(self.key));
        let level = of_key.filter(|s| (s.height_m - table_m).abs() < 0.03);
        let edges: Vec<&EdgePoint> =
            level.flat_map(|s| &s.edges).filter(|e| e.body_free_m > BODY_FREE_M).collect();
        let edge = **edges.get(rng.random_range(0..edges.len().max(1)))?;
        let outward = flat(edge.outward).normalize_or_zero();
        let pelvis = flat(edge.position) + outward * rng.random_range(off);
        let frame = PersonFrame { centre_m: Vec3::new(pelvis.x, 0.0, pelvis.y), facing_rad: 0.0 };
        let inward = facing_of(-outward);
        let seen = self.node.key_angle.map(|angle| {
            frame.turned_to_see(self.world.stage.centre_of(self.key), angle.sample(rng) as f32).facing_rad
        });
        let turn = seen.map_or(0.0, |facing| wrapped(facing - inward));
        // Who sees the middle of a table sidelong still turns towards its edge: half of the angle is the head's.
        (turn.abs() < 2.0 * MOST_TURN)
            .then(|| (edge, pelvis, inward + 0.5 * turn.clamp(-MOST_TURN, MOST_TURN)))
    }

    fn on_the_feet(&self, rng: &mut Rng) -> Option<PlacedPerson> {
        let (edge, pelvis, facing_rad) = self.before_an_edge(STAND_OFF_M, rng)?;
        let floor_m = edge.position.y - edge.drop_m;
        let reach_m = flat(edge.position).distance(pelvis) + 0.1;
        let hints = FamilyHints {
            table_height_m: Some(edge.drop_m),
            table_reach_m: Some(reach_m),
            lean: Some(LeanStyle::HandsInFront),
            ..FamilyHints::default()
        };
        let family = if (0.7..1.2).contains(&edge.drop_m) { PoseFamily::Lean } else { PoseFamily::Stand };
        let figure = self.figure(family, &hints, rng);
        let y = floor_m + figure.pelvis_over_soles_m();
        let spot = Spot { pelvis: Vec3::new(pelvis.x, y, pelvis.y), facing_rad };
        let under = Vec3::new(pelvis.x, floor_m, pelvis.y);
        let place = place_of(family, under, facing_rad, hints, "floor");
        self.free(figure, spot, None, place)
    }

    /// On a chair at a table: one of the room's that is near, else a new one.
    fn on_a_chair(&self, rng: &mut Rng) -> Option<PlacedPerson> {
        let low = self.table_m() < LOW_TABLE_M;
        let (edge, pelvis, facing_rad) =
            self.before_an_edge(if low { SIT_OFF_LOW_M } else { SIT_OFF_M }, rng)?;
        let floor_m = edge.position.y - edge.drop_m;
        let (chair, shape, seat) = self.nearest_chair(pelvis, edge.drop_m, rng)?;
        let front = seat.front.unwrap_or(direction_of(facing_rad));
        let yaw_rad = facing_rad - if seat.front.is_some() { facing_of(front) } else { facing_rad };
        let turned = Pose::upright(Vec3::ZERO, yaw_rad).plan(seat.at);
        let mut lifted = self.lifted.clone();
        if let Chair::Item(id) = &chair {
            lifted.insert(*id);
            lifted.extend(self.world.carried_by(*id));
        }
        let balls: Vec<Ball> = self.others.iter().flat_map(PlacedPerson::trunk).collect();
        let floor = self.world.stage.floor();
        let onto = Onto::Surface { number: floor, height_m: floor_m, soft: false };
        let avoid = Avoid::new(&lifted, &balls);
        let rest = self.world.place(&shape, pelvis - turned, yaw_rad, onto, &avoid).ok()?;
        if self
            .others
            .iter()
            .filter_map(|o| o.chair.as_ref())
            .any(|other| self.chairs_meet(other, &shape, &rest))
        {
            return None;
        }
        let seat_m = rest.pose.at.y + shape.bounds.min.y + seat.height_m;
        let hints = FamilyHints {
            seat_height_m: Some(seat_m - floor_m),
            table_height_m: (!low).then_some(edge.drop_m),
            table_reach_m: (!low).then(|| flat(edge.position).distance(pelvis) + 0.1),
            ..FamilyHints::default()
        };
        let family = if seat.front.is_some() { PoseFamily::SitChair } else { PoseFamily::SitStool };
        let figure = self.figure(family, &hints, rng);
        let y = seat_m + figure.pelvis_over_rest_m() - SINK_M;
        let spot = Spot { pelvis: Vec3::new(pelvis.x, y, pelvis.y), facing_rad };
        let under = Vec3::new(pelvis.x, seat_m, pelvis.y);
        let place = place_of(family, under, facing_rad, hints, "chair");
        self.free(figure, spot, Some(ChairUse { chair, rest }), place)
    }

    fn chairs_meet(&self, other: &ChairUse, shape: &super::shape::Shape, rest: &Rest) -> bool {
        let theirs = match &other.chair {
            Chair::Item(id) => self.world.item(*id).map(|i| i.shape.clone()),
            Chair::New(_, thing) => Some(thing.shape.clone()),
        };
        theirs.is_some_and(|theirs| {
            let place = other.rest.pose.matrix().inverse() * rest.pose.matrix();
            theirs.tree.meets(&shape.tree, &place)
        })
    }

    /// The nearest chair that nobody uses and that suits the table; a new one where the room takes more.
    fn nearest_chair(
        &self,
        pelvis: Vec2,
        table_m: f32,
        rng: &mut Rng,
    ) -> Option<(Chair, Arc<super::shape::Shape>, ChairSeat)> {
        let library = &self.world.stage.library;
        let kinds: Vec<KindId> = ["chair", "stool"].iter().filter_map(|k| library.named(k)).collect();
        let low = table_m < LOW_TABLE_M;
        let suits = |seat: &ChairSeat| low || TABLE_OVER_SEAT_M.contains(&(table_m - seat.height_m));
        let used = |id: ObjectId| {
            self.others
                .iter()
                .any(|o| matches!(&o.chair, Some(ChairUse { chair: Chair::Item(i), .. }) if *i == id))
        };
        let mut near: Vec<(f32, ObjectId)> = kinds
            .iter()
            .flat_map(|k| self.world.of_kind(*k))
            .filter(|i| !i.locked && !used(i.id))
            .map(|i| (flat(i.pose.at).distance(pelvis), i.id))
            .filter(|(d, _)| *d < CHAIR_REACH_M)
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let existing = near.into_iter().find_map(|(_, id)| {
            let shape = self.world.item(id)?.shape.clone();
            let seat = ChairSeat::of(&shape).filter(suits)?;
            Some((Chair::Item(id), shape, seat))
        });
        if existing.is_some() {
            return existing;
        }
        let chair = *kinds.first()?;
        let brought =
            self.others.iter().filter(|o| matches!(&o.chair, Some(ChairUse { chair: Chair::New(..), .. })));
        let there = self.world.of_kind(chair).count() + brought.count();
        let right_height = low || TABLE_OVER_SEAT_M.contains(&(table_m - CHAIR_M));
        if there >= library.kind(chair).most.max(self.others.len() + 1) || !right_height {
            return None;
        }
        let thing = library.thing(chair, rng.random_range(0..library.looks(chair))).ok()?;
        let seat = ChairSeat::of(&thing.shape).filter(suits)?;
        Some((Chair::New(chair, thing.clone()), thing.shape.clone(), seat))
    }

    /// On a couch or armchair that has the coffee table in front of it.
    fn on_a_seat_before_it(&self, rng: &mut Rng) -> Option<PlacedPerson> {
        let stage = &self.world.stage;
        let table = &stage.surfaces[stage.work_surface(self.key)?];
        let before = |place: &&Place| {
            let under = flat(place.under_pelvis);
            let nearest = table
                .cells
                .iter()
                .map(|c| flat(c.0))
                .min_by(|a, b| a.distance_squared(under).total_cmp(&b.distance_squared(under)));
            let sits =
                matches!(place.family, PoseFamily::SitSofa | PoseFamily::SitChair | PoseFamily::SitStool);
            sits && nearest.is_some_and(|n| {
                let ahead = (n - under).normalize_or_zero().dot(place.facing) > 0.5;
                ahead && COFFEE_REACH_M.contains(&n.distance(under))
            })
        };
        let places: Vec<&Place> = stage.places.iter().filter(before).collect();
        self.at_a_place(&places, rng)
    }

    /// On the key object: sitting, with straight legs or lying.
    fn on_it(&self, rng: &mut Rng) -> Option<PlacedPerson> {
        let stage = &self.world.stage;
        let fits = |family: PoseFamily| match self.node.posture {
            Posture::Stand => false,
            Posture::Sit => family.group() == "sit" && family != PoseFamily::SitStraight,
            Posture::SitStraight => family == PoseFamily::SitStraight,
            Posture::LieUp => family == PoseFamily::LieUp,
            Posture::LieDown => family == PoseFamily::LieDown,
        };
        let on_key = |place: &&Place| {
            let support = place.support.and_then(|i| stage.geometry.supports.get(i));
            fits(place.family) && support.is_some_and(|s| s.object == Some(self.key))
        };
        let places: Vec<&Place> = stage.places.iter().filter(on_key).collect();
        self.at_a_place(&places, rng)
    }

    fn at_a_place(&self, places: &[&Place], rng: &mut Rng) -> Option<PlacedPerson> {
        let total: f32 = places.iter().map(|p| p.weight).sum();
        let mut left = rng.random_range(0.0..1.0) * total;
        let place = (*places.iter().find(|p| {
            left -= p.weight;
            left <= 0.0
        })?)
        .clone();
        let figure = self.figure(place.family, &place.hints, rng);
        // A place for lying looks to where the head goes; on the back the front is the feet's end.
        let front = if place.family == PoseFamily::LieUp { -place.facing } else { place.facing };
        let y = place.under_pelvis.y + figure.pelvis_over_rest_m() - SINK_M;
        let spot = Spot { pelvis: place.under_pelvis.with_y(y), facing_rad: facing_of(front) };
        self.free(figure, spot, None, place)
    }

    /// The person, if they run into nothing that can't be moved out of their way and into nobody.
    fn free(
        &self,
        figure: Arc<Figure>,
        spot: Spot,
        chair: Option<ChairUse>,
        place: Place,
    ) -> Option<PlacedPerson> {
        let core = figure.core_at(&spot);
        let geometry = &self.world.stage.geometry;
        if !geometry.bounds.contains(spot.pelvis) || geometry.field.sample(spot.pelvis) < 0.0 {
            return None;
        }
        // A seat gives way to who sits on it; legs may not stand in anything.
        let upper = |at: &Vec3| chair.is_some() || place.support.is_none() || at.y > spot.pelvis.y + 0.1;
        let inside =
            core.iter().filter(|(at, _)| upper(at)).any(|(at, r)| geometry.bvh.closest(*at, *r).is_some());
        if inside {
            return None;
        }
        let own = chair.as_ref().and_then(|c| if let Chair::Item(id) = c.chair { Some(id) } else { None });
        let around = crate::math::Aabb::of(core.iter().map(|b| b.0)).grown(0.2);
        let blocked = self.world.near(&around).into_iter().any(|item| {
            let stays = Some(item.id) != own && !self.lifted.contains(&item.id);
            stays && World::touches(&item.shape, &item.pose, &core)
        });
        let crowded = self.others.iter().any(|other| {
            let theirs = other.trunk();
            core.iter().any(|(a, ra)| theirs.iter().any(|(b, rb)| a.distance(*b) < ra + rb))
        });
        let frame = figure.frame_at(&spot);
        let in_reach = |other: &PlacedPerson| {
            let distance_m = flat(other.frame.centre_m).distance(flat(frame.centre_m));
            self.apart_m.is_none_or(|[least, most]| (least..=most).contains(&distance_m))
        };
        if blocked || crowded || !self.others.iter().all(in_reach) {
            return None;
        }
        let on = chair.as_ref().map_or_else(|| place.on.clone(), |_| "chair".to_owned());
        Some(PlacedPerson { figure, spot, frame, chair, on, place })
    }
}

fn place_of(family: PoseFamily, under: Vec3, facing_rad: f32, hints: FamilyHints, on: &str) -> Place {
    Place {
        family,
        under_pelvis: under,
        facing: direction_of(facing_rad),
        support: None,
        hints,
        on: on.to_owned(),
        weight: 1.0,
    }
}

/// An angle as -π to π.
pub fn wrapped(angle: f32) -> f32 {
    let turn = std::f32::consts::TAU;
    (angle + 0.5 * turn).rem_euclid(turn) - 0.5 * turn
}
