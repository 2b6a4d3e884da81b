//! A body for each sub-goal: on the seat or bed, or standing, at the point and in the direction that were asked for.

use glam::{Mat3, Vec2, Vec3};
use rayon::prelude::*;

use super::{Cast, GoalReport};
use crate::body::joints as j;
use crate::body::{Body, FrameJoints};
use crate::fit::{FitConfig, Fitter, Objective, Surroundings};
use crate::generate::{Place, all_places, seat_family, settle_person};
use crate::inspect::{Finding, Limits, Site, inspect_body};
use crate::job::{Cancelled, Seed, Ticker};
use crate::math::Aabb;
use crate::motion::gait;
use crate::motion::plan::{Blocked, PlanConfig, Planner, Seated, Spot, Station, Unreachable, stances};
use crate::scene::{
    BETAS, BodyParams, Category, Frame, GoalPose, PoseFamily, RoomGeometry, SubGoal, direction_of, facing_of,
};

/// Seats and beds farther from the point asked for than this don't come into question, metres.
const NEAR_M: f32 = 0.8;
/// Nor do those whose surface is this much higher or lower than the point, metres.
const HEIGHT_M: f32 = 0.35;
/// A point this near to a place is on the same seat: the body is tried at the very point, metres.
const SAME_SEAT_M: f32 = 0.4;
/// Turned farther than this from how a seat faces, nobody sits on it, radians.
const TURNED: f32 = 1.2;
/// Half a turn weighs as much as this distance, metres.
const HALF_TURN_M: f32 = 0.8;
/// Places of one seat that are tried, and ways to hold oneself at each.
const TRIES: (usize, u64) = (3, 2);
/// Ways to lie at a place that are tried before it is given up: on the back and on the side.
const WAYS_TO_LIE: usize = 2;
/// Weights of the place in a fit, per squared metre: a centimetre and a half off weighs as much as a gap of a centimetre,
/// and along the floor, where the point was asked for, a third of a centimetre does.
const PLACE: f32 = 80.0;
const OVER: f32 = 2000.0;
/// Points no higher than this above the floor are on the floor, metres.
const ON_FLOOR_M: f32 = 0.2;
/// A miss of this many centimetres, or degrees, is as bad as a finding that misses its limit by its own size: what was
/// asked for comes before how well it is done.
const MISS: (f32, f32) = (2.0, 4.0);
/// How often a body that ended beside what was asked for is aimed anew, the share of what is allowed that it is aimed
/// for, and by how much it is turned at most each time, radians.
const AIMS: usize = 3;
const HALF: f32 = 0.5;
const MOST_AIM: f32 = 0.35;
/// A body whose feet leave no room to get up is as bad as a finding that misses its limit five times.
const STUCK: f32 = 5.0;
/// A place this near to the point asked for is that point, metres.
const EXACTLY_M: f32 = 1e-3;
/// How much less one likes to lie face down or on the side, metres of distance.
const LIES_OTHERWISE_M: f32 = 0.15;
/// Height at which people look around, metres, and how far they care to see.
const EYES_M: (f32, f32) = (1.5, 4.0);
/// Sitting at a corner of a bed is worth half of this detour, metres.
const CORNER_M: f32 = 0.3;
/// Getting in over the side or the back of a sofa instead of from the front is worth this detour, metres.
const OVER_THE_SIDE_M: f32 = 0.5;
/// A back this high, metres, says which way a seat faces.
const BACK_M: f32 = 0.25;
/// Places on the edge of a bed that are tried, and how far these are apart, metres.
const EDGES: usize = 6;
const EDGES_APART_M: f32 = 0.09;
/// Free radius where one gets up from a bed's edge, metres.
const GET_UP_M: f32 = 0.15;
/// From below the pelvis of somebody on a bed's edge to where they stand once they got up, metres.
const GOT_UP_M: f32 = 0.65;

/// A sub-goal with its body.
#[derive(Clone, Debug)]
pub(super) struct Resolved {
    /// As it was asked for; the body is put in.
    pub goal: SubGoal,
    /// What is done there; never `Any`.
    pub pose: GoalPose,
    /// Name of what holds the body.
    pub on: String,
    /// What the body rests on the room as, where anything but its feet carries it.
    pub family: Option<PoseFamily>,
    /// For lying: the body on the bed's edge, through which one lies down and gets up.
    pub edge: Option<Frame>,
    /// Where the seated body's feet and pelvis are: of the edge for lying.
    pub seated: Option<Seated>,
    /// Where the body is and faces.
    pub place: (Vec3, f32),
}

impl Resolved {
    /// The sub-goal as the planner knows it.
    pub fn station(&self, planner: &Planner<'_>) -> Station {
        let mut goal = self.goal.clone();
        goal.pose = self.pose;
        let stances = self.seated.as_ref().map_or_else(Vec::new, |seated| stances(planner, seated));
        Station { goal, stances }
    }

    /// How well the body meets what was asked for.
    pub fn report(&self) -> GoalReport {
        let (miss_cm, miss_deg) = miss(&self.goal, self.place);
        GoalReport { goal: self.goal.id, pose: self.pose, on: self.on.clone(), miss_cm, miss_deg }
    }
}

/// From what was asked for to where a body is: centimetres along the floor, degrees.
fn miss(goal: &SubGoal, (at, facing): (Vec3, f32)) -> (f32, f32) {
    let turn = goal.facing.map_or(0.0, |asked| turn_between(asked, facing).abs());
    (100.0 * flat(at - goal.at).length(), turn.to_degrees())
}

/// The turn from one facing angle to another, radians in (-π, π].
pub(super) fn turn_between(from: f32, to: f32) -> f32 {
    std::f32::consts::PI - (from - to + std::f32::consts::PI).rem_euclid(std::f32::consts::TAU)
}

pub(super) fn flat(v: Vec3) -> Vec2 {
    Vec2::new(v.x, v.z)
}

/// The direction along or across the edges of a place's surface that is nearest to the place's own, and how straight the
/// place itself is: 1 for that direction, -1 for one that halves a corner.
pub(super) fn along_edges(geometry: &RoomGeometry, place: &Place) -> (Vec2, f32) {
    let surface = place.support.and_then(|index| geometry.supports.get(index));
    // Four times an angle does not know which of the four sides is meant.
    let fourfold = |d: Vec2| Vec2::from_angle(4.0 * d.to_angle());
    let sum: Vec2 = surface.into_iter().flat_map(|s| &s.edges).map(|e| fourfold(flat(e.outward))).sum();
    let Some(edges) = sum.try_normalize() else { return (place.facing, 0.0) };
    let own = fourfold(place.facing);
    let turn = own.angle_to(edges) / 4.0;
    (Vec2::from_angle(turn).rotate(place.facing), own.dot(edges))
}

/// 1 for facing away from what rises highest behind a seat, -1 for facing it, 0 for a seat without a back.
pub(super) fn away_from_back(geometry: &RoomGeometry, place: &Place) -> f32 {
    let surface = place.support.and_then(|index| geometry.supports.get(index));
    let backs = surface.into_iter().flat_map(|s| &s.backs).filter(|b| b.height_m >= BACK_M);
    let back = backs.max_by(|a, b| (a.height_m * a.length_m).total_cmp(&(b.height_m * b.length_m)));
    back.map_or(0.0, |b| place.facing.dot(flat(-b.direction)))
}

/// What speaks against a place on an edge for lying down at a point from there, metres: how far it is, and sitting at a
/// corner or towards the back.
pub(super) fn edge_cost(geometry: &RoomGeometry, place: &Place, pelvis: Vec3) -> f32 {
    flat(place.under_pelvis - pelvis).length()
        - CORNER_M * along_edges(geometry, place).1
        - OVER_THE_SIDE_M * away_from_back(geometry, place)
}

/// Joints of a frame's body, world frame.
fn figure(body: &Body, betas: &[f32; BETAS], frame: &Frame) -> Vec<Vec3> {
    FrameJoints::of(&body.model.rest_joints(betas), frame).positions.to_vec()
}

/// Where a body is and which way it faces: its front, or, where it lies, along the trunk towards the feet, however the
/// legs are drawn up.
fn place_of(joints: &[Vec3], frame: &Frame, pose: GoalPose) -> (Vec3, f32) {
    let direction = match pose {
        GoalPose::Lie => joints[j::PELVIS] - joints[j::NECK],
        _ => frame.rotation * Vec3::Z,
    };
    (joints[j::PELVIS], facing_of(flat(direction)))
}

/// Whether a miss is within a share of what is allowed.
fn is_near((cm, deg): (f32, f32), share: f32) -> bool {
    cm <= share * super::GOAL_CM && deg <= share * super::GOAL_DEG
}

/// A miss in units of what is allowed.
fn worse((cm, deg): (f32, f32)) -> f32 {
    (cm / super::GOAL_CM).max(deg / super::GOAL_DEG)
}

/// Finds bodies for the sub-goals of one journey.
pub(super) struct Resolver<'a> {
    cast: &'a Cast<'a>,
    places: Vec<Place>,
    fitter: Fitter<'a>,
    seed: Seed,
}

/// One fit: the body, how far it misses what was asked for, and where it is and faces.
struct Fit {
    params: BodyParams,
    miss: (f32, f32),
    at: (Vec3, f32),
}

/// A body at a place with what speaks against it.
struct Candidate {
    params: BodyParams,
    on: String,
    badness: f32,
    /// Whether place and facing are those asked for, and whether nothing at all speaks against it.
    met: bool,
    clean: bool,
}

impl<'a> Resolver<'a> {
    pub fn new(cast: &'a Cast<'a>, seed: Seed, ticker: &Ticker) -> Result<Self, Cancelled> {
        let needs = |g: &SubGoal| !matches!(g.pose, GoalPose::Walk | GoalPose::Stand);
        let places = if cast.request.goals.iter().any(needs) {
            // The places of a room don't depend on who asks, so neither does their seed.
            all_places(cast.room, cast.geometry, Seed::root(0), ticker)?
        } else {
            Vec::new()
        };
        Ok(Self::among(cast, places, seed))
    }

    /// Finds bodies at these places of the room.
    pub fn among(cast: &'a Cast<'a>, places: Vec<Place>, seed: Seed) -> Self {
        Self { cast, places, fitter: Fitter::new(cast.body), seed }
    }

    /// The places of the room.
    pub fn places(&self) -> &[Place] {
        &self.places
    }

    /// What speaks against a body at the very point of a sub-goal for who comes from somewhere: 0 for nothing, infinity
    /// where none is met there or nobody gets to it.
    pub fn fault(&self, goal: &SubGoal, from: &Spot, ticker: &Ticker) -> Result<f32, Cancelled> {
        let lies = goal.pose == GoalPose::Lie;
        let near = self.near_places(goal, if lies { "lie" } else { "sit" });
        let mut least = f32::INFINITY;
        let ways = near.iter().take(if lies { WAYS_TO_LIE } else { 1 });
        for (place, attempt) in ways.flat_map(|place| (0..TRIES.1).map(move |attempt| (place, attempt))) {
            let seed = self.seed.child("try", attempt);
            let found = self.candidate(goal, place, seed, false, ticker)?;
            let reached = lies || self.is_reached(&self.frame(&found.params), from);
            let fault = match (reached && found.met, found.clean) {
                (true, true) => 0.0,
                (true, false) => found.badness,
                (false, _) => f32::INFINITY,
            };
            least = least.min(fault);
            if least == 0.0 {
                break;
            }
        }
        Ok(least)
    }

    /// A sub-goal where a body rests by itself, and what speaks against it there ([`Self::fault`]): at the very point, or,
    /// where the seat does not let one be there, where one comes to rest nearby.
    pub fn settled(&self, goal: &SubGoal, from: &Spot, ticker: &Ticker) -> Result<(f32, SubGoal), Cancelled> {
        let fault = self.fault(goal, from, ticker)?;
        let near = self.near_places(goal, if goal.pose == GoalPose::Lie { "lie" } else { "sit" });
        let (Some(place), true) = (near.first(), fault > 0.0) else { return Ok((fault, goal.clone())) };
        // Asked for nothing in particular, the fit is free to leave the point.
        let anywhere = SubGoal { at: goal.at + Vec3::X, ..goal.clone() };
        let found = self.candidate(&anywhere, place, self.seed, false, ticker)?;
        let frame = self.frame(&found.params);
        let joints = figure(self.cast.body, &self.cast.request.betas, &frame);
        let moved = SubGoal { at: joints[j::PELVIS].with_y(goal.at.y), ..goal.clone() };
        let again = self.fault(&moved, from, ticker)?;
        Ok(if again < fault { (again, moved) } else { (fault, goal.clone()) })
    }

    /// Whether one can walk to where one sits down into a body.
    fn is_reached(&self, sits: &Frame, from: &Spot) -> bool {
        let planner = Planner::new(self.cast.geometry, PlanConfig::default());
        let joints = figure(self.cast.body, &self.cast.request.betas, sits);
        let seated = self.seated(&planner, sits, place_of(&joints, sits, GoalPose::Sit));
        stances(&planner, &seated).iter().any(|s| planner.way(from, &s.spot(), &[]).is_ok())
    }

    /// Every sub-goal that has a place, and why the others have none. `quick` leaves bodies as they were settled.
    pub fn all(&self, quick: bool, ticker: &Ticker) -> Result<(Vec<Resolved>, Vec<Unreachable>), Cancelled> {
        let asked: Vec<SubGoal> =
            self.cast.request.goals.iter().filter(|g| !g.planned || g.locked).cloned().collect();
        let one = |(index, goal): (usize, &SubGoal)| {
            let towards = asked.get(index + 1).map(|next| flat(next.at - goal.at));
            let resolved = self.one(goal, towards, quick, ticker)?;
            if !quick {
                ticker.advance()?;
            }
            Ok(resolved.map_err(|why| Unreachable { goal: goal.id, why }))
        };
        let found: Result<Vec<_>, Cancelled> = asked.par_iter().enumerate().map(one).collect();
        let (mut resolved, mut unreachable) = (Vec::new(), Vec::new());
        for result in found? {
            match result {
                Ok(goal) => resolved.push(goal),
                Err(why) => unreachable.push(why),
            }
        }
        Ok((resolved, unreachable))
    }

    fn one(
        &self,
        goal: &SubGoal,
        towards: Option<Vec2>,
        quick: bool,
        ticker: &Ticker,
    ) -> Result<Result<Resolved, Blocked>, Cancelled> {
        let pose = self.pose_at(goal);
        match pose {
            GoalPose::Walk => Ok(Ok(walks(goal, towards))),
            GoalPose::Sit | GoalPose::Lie => self.rests(goal, pose, quick, ticker),
            GoalPose::Any | GoalPose::Stand => Ok(self.stands(goal)),
        }
    }

    /// What is done at a sub-goal: for `Any` what the place suits.
    fn pose_at(&self, goal: &SubGoal) -> GoalPose {
        if goal.pose != GoalPose::Any {
            return goal.pose;
        }
        let on_floor = goal.at.y < ON_FLOOR_M && self.cast.geometry.floor.is_walkable(flat(goal.at));
        let near = |p: &&Place| {
            flat(p.under_pelvis - goal.at).length() < NEAR_M
                && (p.under_pelvis.y - goal.at.y).abs() < HEIGHT_M
        };
        let nearest = |group: &str| {
            let of_group = self.places.iter().filter(|p| p.family.group() == group).filter(near);
            of_group.map(|p| flat(p.under_pelvis - goal.at).length()).fold(f32::INFINITY, f32::min)
        };
        let is_bed = |p: &Place| {
            let object = p.support.and_then(|s| self.cast.geometry.supports[s].object);
            object.and_then(|id| self.cast.room.object(id)).is_some_and(|o| o.category == Category::Bed)
        };
        let bed = self.places.iter().filter(near).any(is_bed);
        match (nearest("sit").is_finite(), nearest("lie").is_finite()) {
            _ if on_floor => GoalPose::Stand,
            (_, true) if bed => GoalPose::Lie,
            (true, _) => GoalPose::Sit,
            (false, true) => GoalPose::Lie,
            _ => GoalPose::Stand,
        }
    }

    fn stands(&self, goal: &SubGoal) -> Result<Resolved, Blocked> {
        let planner = Planner::new(self.cast.geometry, PlanConfig::default());
        let at = planner.on_floor(flat(goal.at));
        let spot = Spot::open(at);
        planner.way(&spot, &spot, &[])?;
        let betas = &self.cast.request.betas;
        let frame = self.known_body(goal, GoalPose::Stand).unwrap_or_else(|| {
            let facing = goal.facing.unwrap_or_else(|| self.best_view(at));
            let feet = gait::natural_feet(self.cast.body, betas, at, facing);
            gait::standing_frame(self.cast.body, betas, &feet, self.seed.child("goal", goal.id.0.into()))
        });
        let joints = figure(self.cast.body, betas, &frame);
        let place = place_of(&joints, &frame, GoalPose::Stand);
        let goal = SubGoal { body: Some(frame), ..goal.clone() };
        let on = "floor".to_owned();
        Ok(Resolved { goal, pose: GoalPose::Stand, on, family: None, edge: None, seated: None, place })
    }

    /// The direction with the farthest view: it depends on the place alone, so nothing else changes when the way
    /// there does.
    fn best_view(&self, at: Vec3) -> f32 {
        let view = |k: i32| {
            let facing = k as f32 / 16.0 * std::f32::consts::TAU;
            let direction = direction_of(facing);
            let eyes = at + Vec3::Y * EYES_M.0;
            let hit = self.cast.geometry.bvh.cast(eyes, Vec3::new(direction.x, 0.0, direction.y), EYES_M.1);
            (facing, hit.map_or(EYES_M.1, |h| h.distance_m))
        };
        let best =
            (0..16).map(view).fold((0.0, -1.0), |best, next| if next.1 > best.1 { next } else { best });
        best.0
    }

    /// A body that is there already and still does what is asked for: the sub-goal's own, or the earlier clip's.
    fn known_body(&self, goal: &SubGoal, pose: GoalPose) -> Option<Frame> {
        let request = self.cast.request;
        let same_person = request.kept.as_ref().is_none_or(|clip| clip.betas == request.betas);
        let fits = |frame: &Frame| {
            let place = place_of(&figure(self.cast.body, &request.betas, frame), frame, pose);
            let (cm, deg) = miss(goal, place);
            cm <= super::GOAL_CM && deg <= super::GOAL_DEG
        };
        goal.body.clone().filter(|frame| goal.locked || (same_person && fits(frame)))
    }

    /// Sits or lies.
    fn rests(
        &self,
        goal: &SubGoal,
        pose: GoalPose,
        quick: bool,
        ticker: &Ticker,
    ) -> Result<Result<Resolved, Blocked>, Cancelled> {
        let lies = pose == GoalPose::Lie;
        let near = self.near_places(goal, if lies { "lie" } else { "sit" });
        let Some(first) = near.first() else {
            let wanted = if lies { "lie" } else { "sit" };
            return Ok(Err(Blocked::NoPlace { at: goal.at, wanted }));
        };
        let support = first.support;
        let seed = self.seed.child("goal", goal.id.0.into());
        let (frame, on) = match self.known_body(goal, pose) {
            Some(frame) => (frame, first.on.clone()),
            None => {
                let found = self.body_at(goal, &near, seed, quick, ticker)?;
                (self.frame(&found.params), found.on)
            }
        };
        let planner = Planner::new(self.cast.geometry, PlanConfig::default());
        let joints = figure(self.cast.body, &self.cast.request.betas, &frame);
        let place = place_of(&joints, &frame, pose);
        let (edge, sits) = if lies {
            match self.edge(goal, support, place.0, quick, ticker)? {
                Some((edge, sits)) => (Some(edge), sits),
                None => (None, self.seated(&planner, &frame, place)),
            }
        } else {
            (None, self.seated(&planner, &frame, place))
        };
        let family = if lies { lying_family(&frame) } else { self.seat_family(first) };
        let goal = SubGoal { body: Some(frame), ..goal.clone() };
        Ok(Ok(Resolved { goal, pose, on, family: Some(family), edge, seated: Some(sits), place }))
    }

    /// How one sits at a place, told from its seat, so that it does not depend on who asks.
    fn seat_family(&self, place: &Place) -> PoseFamily {
        let surface = place.support.and_then(|index| self.cast.geometry.supports.get(index));
        match (place.family, surface) {
            (PoseFamily::SitStraight, _) | (_, None) => place.family,
            (_, Some(surface)) => seat_family(self.cast.room, surface),
        }
    }

    fn frame(&self, params: &BodyParams) -> Frame {
        Frame::of(params, &self.cast.body.pose_space.decode(&params.pose))
    }

    /// Places that a sub-goal may mean, the likeliest first: the very point on its seat, then the room's own.
    fn near_places(&self, goal: &SubGoal, group: &str) -> Vec<Place> {
        let facing = |p: &Place| match group {
            // Places of lying people tell where the head is, sub-goals where the feet are.
            "lie" => facing_of(-p.facing),
            _ => facing_of(p.facing),
        };
        let cost = |p: &Place| {
            let turn = goal.facing.map_or(0.0, |asked| turn_between(asked, facing(p)).abs());
            let otherwise = match p.family {
                PoseFamily::LieSide => LIES_OTHERWISE_M,
                PoseFamily::LieDown | PoseFamily::SitStraight => 2.0 * LIES_OTHERWISE_M,
                _ => 0.0,
            };
            let asked_less = 0.3 * (1.0 - p.weight.min(1.0));
            flat(p.under_pelvis - goal.at).length()
                + HALF_TURN_M * turn / std::f32::consts::PI
                + otherwise
                + asked_less
        };
        let near = |p: &&Place| {
            p.family.group() == group
                && flat(p.under_pelvis - goal.at).length() < NEAR_M
                && (p.under_pelvis.y - goal.at.y).abs() < HEIGHT_M
        };
        let mut found: Vec<Place> = self.places.iter().filter(near).cloned().collect();
        found.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
        found.dedup_by(|b, a| a.family == b.family && a.under_pelvis.distance(b.under_pelvis) < 0.08);
        let exact = |best: &Place| {
            let turned = goal.facing.is_some_and(|asked| turn_between(asked, facing(best)).abs() > TURNED);
            let same = flat(best.under_pelvis - goal.at).length() < SAME_SEAT_M && !turned;
            same.then(|| Place {
                under_pelvis: Vec3::new(goal.at.x, best.under_pelvis.y, goal.at.z),
                facing: goal.facing.map_or(best.facing, |asked| match group {
                    "lie" => -direction_of(asked),
                    _ => direction_of(asked),
                }),
                ..best.clone()
            })
        };
        // Each way to lie is tried at the very point, a seat's at its best place.
        let ways = found.iter().enumerate().filter(|(i, p)| match group {
            "lie" => found[..*i].iter().all(|q| q.family != p.family),
            _ => *i == 0,
        });
        let mut places: Vec<Place> = ways.filter_map(|(_, p)| exact(p)).collect();
        found.truncate(TRIES.0);
        places.append(&mut found);
        places
    }

    /// The first body without findings that meets the sub-goal, else the best of all.
    fn body_at(
        &self,
        goal: &SubGoal,
        places: &[Place],
        seed: Seed,
        quick: bool,
        ticker: &Ticker,
    ) -> Result<Candidate, Cancelled> {
        let mut best: Option<Candidate> = None;
        for (number, place) in places.iter().enumerate() {
            for attempt in 0..TRIES.1 {
                ticker.check()?;
                let seed = seed.child("place", number as u64).child("try", attempt);
                let found = self.candidate(goal, place, seed, quick, ticker)?;
                let clean = found.clean;
                if best.as_ref().is_none_or(|b| found.badness < b.badness) {
                    best = Some(found);
                }
                if clean || quick {
                    break;
                }
            }
            if quick || best.as_ref().is_some_and(|b| b.clean) {
                break;
            }
        }
        best.map_or_else(|| Err(Cancelled), Ok)
    }

    fn candidate(
        &self,
        goal: &SubGoal,
        place: &Place,
        seed: Seed,
        quick: bool,
        ticker: &Ticker,
    ) -> Result<Candidate, Cancelled> {
        let (body, geometry) = (self.cast.body, self.cast.geometry);
        let exactly = flat(place.under_pelvis - goal.at).length() < EXACTLY_M;
        let proposal = settle_person(body, geometry, place, &self.cast.request.betas, exactly, seed);
        ticker.check()?;
        let on = proposal.on;
        if quick {
            return Ok(Candidate { params: proposal.params, on, badness: 0.0, met: true, clean: true });
        }
        let around = Surroundings::new(geometry, Aabb::of(body.pose(&proposal.params).vertices));
        let pose = if place.family.group() == "lie" { GoalPose::Lie } else { GoalPose::Sit };
        let fit = |start: &BodyParams| -> Result<Fit, Cancelled> {
            let quiet = ticker.without_progress();
            let fitted =
                self.fitter.fit(&around, start, proposal.family, &held_config(), &quiet, &mut |_| ())?;
            let frame = self.frame(&fitted.params);
            let at = place_of(&figure(body, &self.cast.request.betas, &frame), &frame, pose);
            Ok(Fit { params: fitted.params, miss: miss(goal, at), at })
        };
        let mut start = proposal.params;
        let mut best = fit(&start)?;
        for _ in 0..AIMS {
            if !exactly || is_near(best.miss, HALF) {
                break;
            }
            start = self.aimed(&start, goal, best.at);
            let again = fit(&start)?;
            if worse(again.miss) < worse(best.miss) {
                best = again;
            }
        }
        let Fit { params, miss: (cm, deg), .. } = best;
        ticker.check()?;
        let metrics = inspect_body(geometry, body, &params).metrics;
        let findings = Limits::default().findings(Site { body: 0, frame: None }, &metrics);
        let met = is_near((cm, deg), 1.0);
        let faults: f32 = findings.iter().map(Finding::severity).sum();
        let stuck = pose == GoalPose::Sit && !self.can_get_up(&params);
        let badness = faults + cm / MISS.0 + deg / MISS.1 + if stuck { STUCK } else { 0.0 };
        Ok(Candidate { params, on, badness, met, clean: findings.is_empty() && met && !stuck })
    }

    /// Whether there is anywhere to stand before a seated body: its feet may be where nobody could put them standing.
    fn can_get_up(&self, params: &BodyParams) -> bool {
        let planner = Planner::new(self.cast.geometry, PlanConfig::default());
        let frame = self.frame(params);
        let joints = figure(self.cast.body, &self.cast.request.betas, &frame);
        let seated = self.seated(&planner, &frame, place_of(&joints, &frame, GoalPose::Sit));
        !stances(&planner, &seated).is_empty()
    }

    /// A start that is off the other way from where the fit of `start` ended: seats and backs push bodies aside, and the
    /// next fit ends nearer to what was asked for.
    fn aimed(&self, start: &BodyParams, goal: &SubGoal, (at, facing): (Vec3, f32)) -> BodyParams {
        let turn = goal.facing.map_or(0.0, |asked| turn_between(facing, asked)).clamp(-MOST_AIM, MOST_AIM);
        let rest = self.cast.body.model.rest_joints(&self.cast.request.betas)[j::PELVIS];
        let mut params = start.clone();
        params.set_rotation(&(Mat3::from_rotation_y(turn) * start.rotation()));
        // The pelvis joint is where it is put, whatever the rotation about it.
        let pelvis = start.translation + rest;
        params.translation = pelvis + (goal.at - at).with_y(0.0) - rest;
        params
    }

    /// The body that sits on the edge of the bed `support` nearest to a lying person's pelvis, where there is floor to
    /// get up to.
    fn edge(
        &self,
        goal: &SubGoal,
        support: Option<usize>,
        pelvis: Vec3,
        quick: bool,
        ticker: &Ticker,
    ) -> Result<Option<(Frame, Seated)>, Cancelled> {
        let floor = &self.cast.geometry.floor;
        let feet = |p: &Place| flat(p.under_pelvis) + p.facing * GOT_UP_M;
        let usable = |p: &&Place| {
            p.support == support
                && support.is_some()
                && p.family.group() == "sit"
                && p.family != PoseFamily::SitStraight
                && floor.clearance_at(feet(p)) > GET_UP_M
        };
        let mut places: Vec<Place> = self.places.iter().filter(usable).cloned().collect();
        let cost = |p: &Place| edge_cost(self.cast.geometry, p, pelvis);
        places.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
        // Places a hand's breadth apart are one seat: what does not hold a body at one holds none at the next.
        let mut apart: Vec<Place> = Vec::new();
        for place in places {
            if apart.iter().all(|p| p.under_pelvis.distance(place.under_pelvis) > EDGES_APART_M) {
                apart.push(place);
            }
        }
        let mut places = apart;
        places.truncate(EDGES);
        // Nobody leans back where they sit for a moment.
        places.iter_mut().for_each(|p| p.family = PoseFamily::SitEdge);
        let Some(first) = places.first() else { return Ok(None) };
        let at =
            SubGoal { at: first.under_pelvis, facing: None, pose: GoalPose::Sit, body: None, ..goal.clone() };
        let seed = self.seed.child("edge", goal.id.0.into());
        let found = self.body_at(&at, &places, seed, quick, ticker)?;
        let frame = self.frame(&found.params);
        let joints = figure(self.cast.body, &self.cast.request.betas, &frame);
        let planner = Planner::new(self.cast.geometry, PlanConfig::default());
        let place = place_of(&joints, &frame, GoalPose::Sit);
        let sits = self.seated(&planner, &frame, place);
        Ok(Some((frame, sits)))
    }

    /// A seated body as the planner sees it, its feet where they stand when it gets up.
    fn seated(&self, planner: &Planner<'_>, frame: &Frame, (pelvis, facing): (Vec3, f32)) -> Seated {
        let floor_y = planner.on_floor(flat(pelvis)).y;
        let mut feet = gait::feet_before(self.cast.body, &self.cast.request.betas, frame, floor_y);
        feet.iter_mut().for_each(|foot| foot.at = planner.on_floor(flat(foot.at)));
        Seated { pelvis, facing, feet }
    }
}

/// Our fit, held to where the body was asked to be.
fn held_config() -> FitConfig {
    let mut config = FitConfig::default();
    if let Objective::Rescue(weights) = &mut config.objective {
        weights.place = PLACE;
        weights.over = OVER;
    }
    config
}

/// On which side somebody lies: on the back when the front is up.
fn lying_family(frame: &Frame) -> PoseFamily {
    match (frame.rotation * Vec3::Z).y {
        up if up > 0.5 => PoseFamily::LieUp,
        up if up < -0.5 => PoseFamily::LieDown,
        _ => PoseFamily::LieSide,
    }
}

/// Walked through, towards the next sub-goal where nobody says otherwise.
fn walks(goal: &SubGoal, towards: Option<Vec2>) -> Resolved {
    let heading = goal.facing.or(towards.filter(|d| d.length() > 0.01).map(facing_of)).unwrap_or(0.0);
    Resolved {
        goal: SubGoal { facing: Some(heading), body: None, ..goal.clone() },
        pose: GoalPose::Walk,
        on: "floor".to_owned(),
        family: None,
        edge: None,
        seated: None,
        place: (goal.at, heading),
    }
}
