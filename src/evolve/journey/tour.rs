//! A tour of a room for who has no sub-goals yet: from the door to a desk chair, a sofa, a window, the bed and back to
//! the door, whatever of it the room has and can be reached.

use std::collections::BTreeMap;
use std::f32::consts::FRAC_PI_2;

use glam::{Vec2, Vec3};

use super::resolve::{Resolver, along_edges, away_from_back, edge_cost, flat};
use super::{Cast, JourneyRequest};
use crate::body::Body;
use crate::generate::{Place, all_places};
use crate::job::{Cancelled, Seed, Ticker};
use crate::motion::leg::FootPlace;
use crate::motion::plan::{PlanConfig, Planner, Seated, Side, Spot, Stance, stances};
use crate::scene::{Category, GoalPose, PoseFamily, Room, RoomGeometry, SubGoal, SubGoalId, facing_of};

/// Somebody who stands somewhere without a reason has this much room, metres.
const ROOM_M: f32 = 0.32;
/// A thing is looked at from at most this far, metres.
const LOOK_M: f32 = 1.6;
/// Sitting down and getting up, and lying down besides, take about so long, seconds.
const SIT_S: f32 = 5.5;
const LIE_S: f32 = 9.0;
/// Walking speed with starts, turns and stops, metres per second.
const SPEED_M_PER_S: f32 = 0.6;
/// Nobody stays shorter than this on a seat, seconds, nor stands longer than that.
const LEAST_STAY_S: f32 = 2.0;
const STANDING_S: f32 = 2.5;
/// Places of a kind that are tried before the tour goes on without.
const TRIES: usize = 24;
/// Places of one thing that can't be reached before the thing is given up.
const GIVE_UP: usize = 8;
/// Places that can be reached at which a body is tried before the tour goes on without.
const BODIES: usize = 6;
/// What facing away from the back, lying or sitting along the edges, and coming in from the front rather than squeezing
/// in at a table, are worth against a place's own weight.
const AWAY: f32 = 1.0;
const STRAIGHT: f32 = 0.4;
const IN_FRONT: f32 = 0.3;
/// What squeezing through on the way to a seat costs.
const SQUEEZE: f32 = 0.8;
/// Who faces away from the back within 60 degrees sits at the front of a sofa.
const FRONT: f32 = 0.5;
/// Directions are the same when their cosine is above this: within six degrees.
const SAME: f32 = 0.9945;
/// Farther than this from a border nobody cares how far, metres.
const INSIDE_M: f32 = 0.4;
/// From below the pelvis of a seated person to between the feet, metres, and the pelvis over the seat.
const SHINS_M: (f32, f32) = (0.42, 0.09);

/// One stop of a tour.
struct Visit {
    at: Vec3,
    facing: f32,
    pose: GoalPose,
    /// Where one stands there or before it.
    spot: Spot,
    support: Option<usize>,
}

struct Guide<'a> {
    room: &'a Room,
    geometry: &'a RoomGeometry,
    planner: Planner<'a>,
    bodies: &'a Resolver<'a>,
    ticker: &'a Ticker,
}

/// Sub-goals of a tour that takes about `seconds`; fewer than two where nobody can walk.
///
/// # Errors
/// [`Cancelled`] once the user cancelled.
pub fn tour(
    room: &Room,
    geometry: &RoomGeometry,
    seconds: f32,
    ticker: &Ticker,
) -> Result<Vec<SubGoal>, Cancelled> {
    let places = all_places(room, geometry, Seed::root(0), ticker)?;
    let request = JourneyRequest::default();
    let cast = Cast { room, geometry, body: Body::bundled(), request: &request };
    let bodies = Resolver::among(&cast, places, Seed::root(0));
    let planner = Planner::new(geometry, PlanConfig::default());
    let guide = Guide { room, geometry, planner, bodies: &bodies, ticker };
    let Some(door) = guide.door() else { return Ok(Vec::new()) };
    let from = door.spot;
    let (chair, sofa) = guide.seats(&from)?;
    let view = guide.view(&from, &[Category::Window, Category::Picture, Category::Shelving]);
    let bed = guide.bed(&from)?;
    let back = Visit { facing: door.facing + 2.0 * FRAC_PI_2, ..guide.copy(&door) };
    let at_view = 1 + usize::from(chair.is_some()) + usize::from(sofa.is_some());
    let views = view.is_some();
    let object = |visit: &Option<Visit>| geometry.supports.get(visit.as_ref()?.support?)?.object;
    // Nobody gets up from a sofa to lie down on it: something else is done in between.
    let same = object(&sofa).is_some() && object(&sofa) == object(&bed);
    let (first, second) = if same && chair.is_some() { (sofa, chair) } else { (chair, sofa) };
    let mut visits: Vec<Visit> =
        [Some(door), first, second, view, bed, Some(back)].into_iter().flatten().collect();
    if views && guide.busy_s(&visits) + LEAST_STAY_S * rests(&visits) as f32 > seconds {
        visits.remove(at_view);
    }
    Ok(guide.timed(&visits, seconds))
}

impl Guide<'_> {
    fn copy(&self, visit: &Visit) -> Visit {
        Visit { spot: visit.spot, ..*visit }
    }

    /// Inside the door, facing the room; the edge of the floor where there is none.
    fn door(&self) -> Option<Visit> {
        let middle = flat(self.geometry.bounds.center());
        let doors = self.room.objects.iter().filter(|o| o.category == Category::Door && o.visible);
        let at = doors.map(|o| flat(o.world_bounds().center())).next();
        let floor = &self.geometry.floor;
        let free = floor.largest_area().filter(|&cell| floor.clearance_m[cell] >= ROOM_M);
        let far = |cell: usize| match at {
            Some(door) => flat(floor.position(cell)).distance(door),
            None => -flat(floor.position(cell)).distance(middle),
        };
        let cell = free.min_by(|&a, &b| far(a).total_cmp(&far(b)))?;
        let at = floor.position(cell);
        let facing = facing_of(middle - flat(at));
        Some(Visit { at, facing, pose: GoalPose::Stand, spot: Spot::open(at), support: None })
    }

    /// A desk chair, else another, and a sofa, else another soft seat that is no bed.
    fn seats(&self, from: &Spot) -> Result<(Option<Visit>, Option<Visit>), Cancelled> {
        let at_table = |p: &Place| p.family == PoseFamily::SitChair && p.hints.table_height_m.is_some();
        let mut chair = self.seat(from, None, at_table)?;
        if chair.is_none() {
            chair = self.seat(from, None, |p| p.family == PoseFamily::SitChair)?;
        }
        let taken = chair.as_ref().and_then(|c| c.support);
        let mut sofa = self.seat(from, taken, |p| p.family == PoseFamily::SitSofa)?;
        if sofa.is_none() {
            use PoseFamily::{SitChair, SitEdge, SitStool};
            let soft = |p: &Place| {
                matches!(p.family, SitChair | SitStool | SitEdge) && self.category(p) != Some(Category::Bed)
            };
            sofa = self.seat(from, taken, soft)?;
        }
        Ok((chair, sofa))
    }

    fn category(&self, place: &Place) -> Option<Category> {
        let object = place.support.and_then(|s| self.geometry.supports[s].object);
        object.and_then(|id| self.room.object(id)).map(|o| o.category)
    }

    /// The first of the visits against whose body nothing speaks, else that with the least faults among those whose body
    /// is where it should be.
    fn held(&self, visits: Vec<Visit>, from: &Spot) -> Result<Option<Visit>, Cancelled> {
        let mut best: Option<(f32, Visit)> = None;
        for visit in visits.into_iter().take(BODIES) {
            let goal = sub_goal(SubGoalId(0), &visit, 0.0);
            let (fault, settled) = self.bodies.settled(&goal, from, self.ticker)?;
            if fault < best.as_ref().map_or(f32::INFINITY, |b| b.0) {
                best = Some((fault, Visit { at: settled.at, ..visit }));
            }
            if fault == 0.0 {
                break;
            }
        }
        Ok(best.map(|(_, visit)| visit))
    }

    /// The most inviting seat of a kind that can be reached.
    fn seat(
        &self,
        from: &Spot,
        except: Option<usize>,
        kind: impl Fn(&Place) -> bool,
    ) -> Result<Option<Visit>, Cancelled> {
        let other = |p: &&Place| {
            let object = |s: Option<usize>| s.and_then(|s| self.geometry.supports[s].object);
            p.family.group() == "sit" && (except.is_none() || object(p.support) != object(except))
        };
        let mut found: Vec<&Place> = self.bodies.places().iter().filter(other).filter(|p| kind(p)).collect();
        let rank = |p: &Place| {
            p.weight
                + self.between_m(p)
                + AWAY * away_from_back(self.geometry, p)
                + STRAIGHT * along_edges(self.geometry, p).1
        };
        found.sort_by(|a, b| rank(b).total_cmp(&rank(a)));
        spread(&mut found);
        let reached = |place: &Place| {
            let (stance, squeezes) = self.stance(place, from)?;
            let in_front = matches!(stance.side, Side::Front | Side::Ahead);
            let room_m = self.planner.floor().clearance_at(flat(stance.at)).min(INSIDE_M);
            let way = if in_front { IN_FRONT } else { 0.0 } - if squeezes { SQUEEZE } else { 0.0 };
            let rank = rank(place) + room_m + way;
            Some((rank, self.visit(place, GoalPose::Sit, facing_of(place.facing), stance.spot())))
        };
        let mut visits: Vec<(f32, Visit)> = self.reachable(&found, reached);
        visits.sort_by(|a, b| b.0.total_cmp(&a.0));
        self.held(visits.into_iter().map(|(_, visit)| visit).collect(), from)
    }

    /// How far a place is from the border of what it is on, at most [`INSIDE_M`], metres.
    fn inside_m(&self, place: &Place) -> f32 {
        let surface = place.support.and_then(|index| self.geometry.supports.get(index));
        let edges = surface.into_iter().flat_map(|s| &s.edges);
        edges.map(|e| flat(e.position - place.under_pelvis).length()).fold(INSIDE_M, f32::min)
    }

    /// How much seat there is at both sides of a place, at most [`INSIDE_M`], metres.
    fn between_m(&self, place: &Place) -> f32 {
        let Some(surface) = place.support.and_then(|index| self.geometry.supports.get(index)) else {
            return 0.0;
        };
        let aside = place.facing.perp();
        let reach = |sign: f32| {
            let along = surface.cells.iter().map(|c| flat(c.position - place.under_pelvis));
            let row = along.filter(|d| d.dot(place.facing).abs() < surface.cell_m);
            row.map(|d| sign * d.dot(aside)).fold(0.0, f32::max)
        };
        reach(1.0).min(reach(-1.0)).min(INSIDE_M)
    }

    fn visit(&self, place: &Place, pose: GoalPose, facing: f32, spot: Spot) -> Visit {
        Visit { at: place.under_pelvis, facing, pose, spot, support: place.support }
    }

    /// Where one stands before a seat, if one can get there, and whether one squeezes through on the way.
    fn stance(&self, place: &Place, from: &Spot) -> Option<(Stance, bool)> {
        let feet = flat(place.under_pelvis) + place.facing * SHINS_M.0;
        let foot = FootPlace { at: self.planner.on_floor(feet), heading: facing_of(place.facing) };
        let seated = Seated {
            pelvis: place.under_pelvis + Vec3::Y * SHINS_M.1,
            facing: facing_of(place.facing),
            feet: [foot, foot],
        };
        let reached = |s: Stance| {
            let way = self.planner.way(from, &s.spot(), &[]).ok()?;
            Some((s, way.squeeze.is_some()))
        };
        stances(&self.planner, &seated).into_iter().find_map(reached)
    }

    /// The best place to lie on the back where one can sit on the edge first: a bed, else whatever is long enough.
    fn bed(&self, from: &Spot) -> Result<Option<Visit>, Cancelled> {
        let places = self.bodies.places();
        let mut found: Vec<&Place> = places.iter().filter(|p| p.family == PoseFamily::LieUp).collect();
        let rank = |p: &Place| {
            let bed = self.category(p) == Some(Category::Bed);
            p.weight
                + self.inside_m(p)
                + STRAIGHT * along_edges(self.geometry, p).1
                + if bed { 2.0 } else { 0.0 }
        };
        found.sort_by(|a, b| rank(b).total_cmp(&rank(a)));
        spread(&mut found);
        let reached = |lie: &Place| {
            // Onto a sofa one gets from its front alone.
            let sofa = self.category(lie) != Some(Category::Bed);
            let edges = places.iter().filter(|p| {
                p.support == lie.support
                    && p.family.group() == "sit"
                    && p.family != PoseFamily::SitStraight
                    && (!sofa || away_from_back(self.geometry, p) > FRONT)
            });
            let cost = |p: &Place| edge_cost(self.geometry, p, lie.under_pelvis);
            let mut edges: Vec<&Place> = edges.collect();
            edges.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
            spread(&mut edges);
            let (stance, _) = edges.into_iter().take(4).find_map(|edge| self.stance(edge, from))?;
            // One lies along the bed, wherever its middle axis leads, else as the place says.
            let along = along_edges(self.geometry, lie).0;
            let visit = |head: Vec2| self.visit(lie, GoalPose::Lie, facing_of(-head), stance.spot());
            Some(if along.dot(lie.facing) > SAME {
                vec![visit(along)]
            } else {
                vec![visit(along), visit(lie.facing)]
            })
        };
        let visits = self.reachable(&found, reached).into_iter().flatten().take(BODIES).collect();
        self.held(visits, from)
    }

    /// What `reached` says of the first places that can be reached; things of which no place can are soon given up, so
    /// that a bed behind a closed door does not hide the sofa.
    fn reachable<T>(&self, places: &[&Place], reached: impl Fn(&Place) -> Option<T>) -> Vec<T> {
        let mut failed: BTreeMap<Option<usize>, usize> = BTreeMap::new();
        let mut found = Vec::new();
        for place in places {
            let failures = failed.entry(place.support).or_default();
            if found.len() >= TRIES || *failures >= GIVE_UP {
                continue;
            }
            match reached(place) {
                Some(one) => found.push(one),
                None => *failures += 1,
            }
        }
        found
    }

    /// Somewhere to stand and look at something on a wall.
    fn view(&self, from: &Spot, of: &[Category]) -> Option<Visit> {
        let floor = &self.geometry.floor;
        let things = self.room.objects.iter().filter(|o| of.contains(&o.category) && o.visible);
        things.filter(|o| o.world_bounds().max.y > 1.2).find_map(|object| {
            let thing = flat(object.world_bounds().center());
            let near = |cell: usize| flat(floor.position(cell)).distance(thing);
            let free = floor.largest_area().filter(|&c| floor.clearance_m[c] >= ROOM_M && near(c) < LOOK_M);
            let cell = free.min_by(|&a, &b| near(a).total_cmp(&near(b)))?;
            let at = floor.position(cell);
            let spot = Spot::open(at);
            self.planner.way(from, &spot, &[]).ok()?;
            let facing = facing_of(thing - flat(at));
            Some(Visit { at, facing, pose: GoalPose::Stand, spot, support: None })
        })
    }

    /// What a tour takes besides its stays on seats and beds, seconds.
    fn busy_s(&self, visits: &[Visit]) -> f32 {
        let way = |pair: &[Visit]| {
            let way = self.planner.way(&pair[0].spot, &pair[1].spot, &[]);
            way.map_or(0.0, |w| w.length_m()) / SPEED_M_PER_S
        };
        let doing = |v: &Visit| match v.pose {
            GoalPose::Sit => SIT_S,
            GoalPose::Lie => SIT_S + LIE_S,
            _ => STANDING_S + 1.0,
        };
        visits.windows(2).map(way).sum::<f32>() + visits.iter().map(doing).sum::<f32>()
    }

    /// The visits as sub-goals, stays on seats and beds chosen so that the whole takes about `seconds`.
    fn timed(&self, visits: &[Visit], seconds: f32) -> Vec<SubGoal> {
        let left_s = seconds - self.busy_s(visits);
        let stay_s = (left_s / rests(visits).max(1) as f32).max(LEAST_STAY_S);
        let numbered = visits.iter().enumerate();
        numbered.map(|(index, v)| sub_goal(SubGoalId(index as u32), v, stay_s)).collect()
    }
}

/// A visit as a sub-goal; `stay_s` counts on seats and beds.
fn sub_goal(id: SubGoalId, v: &Visit, stay_s: f32) -> SubGoal {
    SubGoal {
        id,
        at: v.at,
        facing: Some(v.facing),
        pose: v.pose,
        stay_s: if v.pose == GoalPose::Stand { STANDING_S } else { stay_s },
        planned: false,
        locked: false,
        body: None,
    }
}

/// How many of the visits are on seats and beds.
fn rests(visits: &[Visit]) -> usize {
    visits.iter().filter(|v| v.pose != GoalPose::Stand).count()
}

/// Leaves one of places that are nearly the same.
fn spread(places: &mut Vec<&Place>) {
    let mut kept: Vec<&Place> = Vec::new();
    for place in places.iter() {
        let same = |k: &&Place| {
            k.under_pelvis.distance(place.under_pelvis) < 0.12 && k.facing.dot(place.facing) > 0.7
        };
        if !kept.iter().any(same) {
            kept.push(place);
        }
    }
    *places = kept;
}
