//! The whole route: ways between stations, sub-goals on them, and what can't be reached.

use std::collections::BTreeSet;

use glam::Vec2;

use super::approach::Stance;
use super::split::between;
use super::{Blocked, Disc, Planner, Spot, Way, flat};
use crate::job::{Cancelled, Ticker};
use crate::motion::leg::{PathPoint, Walking};
use crate::scene::{GoalPose, SubGoal, SubGoalId};

/// Planned sub-goals are numbered from here: far from what anybody counts to, and far from overflow.
const PLANNED: u32 = 0x4000_0000;
/// Speed through a sub-goal that was put by hand, where nothing narrows it, metres per second.
const BY_HAND_M_PER_S: f32 = 1.0;
/// With this clearance nobody slows down, metres.
const ROOMY_M: f32 = 0.35;

/// A sub-goal that is given, and where one stands to do what it says.
#[derive(Clone, Debug, PartialEq)]
pub struct Station {
    /// The sub-goal.
    pub goal: SubGoal,
    /// For seats and beds where one may stand before, the best first; empty where one stands or walks at the goal.
    pub stances: Vec<Stance>,
}

impl Station {
    /// Somewhere to stand or walk through.
    pub fn on_floor(goal: SubGoal) -> Self {
        Self { goal, stances: Vec::new() }
    }

    /// Whether it is walked through.
    fn is_through(&self) -> bool {
        self.goal.pose == GoalPose::Walk && self.goal.facing.is_some()
    }

    fn spots(&self) -> Vec<Spot> {
        if self.stances.is_empty() {
            let heading = self.goal.facing.filter(|_| self.is_through());
            return vec![Spot { at: flat(self.goal.at), heading, beside: false }];
        }
        self.stances.iter().map(Stance::spot).collect()
    }
}

/// What somebody does at a stop.
#[derive(Clone, Debug, PartialEq)]
pub enum Role {
    /// What station number so says.
    Station(usize),
    /// Stands before the seat or bed of station number so, about to sit down (`leaving` false) or just got up.
    Before {
        /// Which station.
        station: usize,
        /// How one stands.
        stance: Stance,
        /// Whether one has got up.
        leaving: bool,
    },
    /// Walks through.
    Through(Walking),
}

/// A sub-goal of the route and how it goes on from there.
#[derive(Clone, Debug, PartialEq)]
pub struct Stop {
    /// The sub-goal, given or planned.
    pub goal: SubGoal,
    /// What is done.
    pub role: Role,
    /// The way to the next stop; a single point where the person stays on the spot, empty at the last stop.
    pub way: Vec<PathPoint>,
}

/// A station that can't be reached and is left out.
#[derive(Clone, Debug, PartialEq)]
pub struct Unreachable {
    /// Its sub-goal.
    pub goal: SubGoalId,
    /// Why.
    pub why: Blocked,
}

/// The route through all stations that can be reached.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Route {
    /// Every sub-goal in the order of time.
    pub stops: Vec<Stop>,
    /// Stations that are left out, with the reason.
    pub unreachable: Vec<Unreachable>,
    /// Where one squeezes through: the sub-goal before, where, and the clearance in metres.
    pub squeezes: Vec<(SubGoalId, glam::Vec3, f32)>,
}

/// Plans the route through `stations` in their order. `others` gives what is in the way of the way that leaves the
/// station of this number, for now.
///
/// # Errors
/// [`Cancelled`] once the user cancelled.
pub fn route(
    planner: &Planner<'_>,
    stations: &[Station],
    others: &dyn Fn(SubGoalId) -> Vec<Disc>,
    ticker: &Ticker,
) -> Result<Route, Cancelled> {
    let mut builder = Builder {
        planner,
        stations,
        taken: stations.iter().map(|s| s.goal.id).collect(),
        route: Route::default(),
    };
    let mut at: Option<(usize, Spot)> = None;
    for (index, station) in stations.iter().enumerate() {
        ticker.check()?;
        let discs = at.map(|(from, _)| others(stations[from].goal.id)).unwrap_or_default();
        match builder.arrive(at.map(|(_, spot)| spot), station, &discs) {
            Ok((spot, chosen, way)) => {
                if let Some((from, _)) = at {
                    builder.walk(from, index, &way);
                }
                builder.stand(index, chosen);
                at = Some((index, spot));
            }
            Err(why) => builder.route.unreachable.push(Unreachable { goal: station.goal.id, why }),
        }
    }
    builder.finish();
    Ok(builder.route)
}

struct Builder<'a> {
    planner: &'a Planner<'a>,
    stations: &'a [Station],
    taken: BTreeSet<SubGoalId>,
    route: Route,
}

impl Builder<'_> {
    /// The first of the station's spots that can be reached, which of its stances that is, and the way.
    fn arrive(
        &self,
        from: Option<Spot>,
        station: &Station,
        others: &[Disc],
    ) -> Result<(Spot, Option<Stance>, Way), Blocked> {
        let mut first: Option<Blocked> = None;
        for (number, spot) in station.spots().into_iter().enumerate() {
            let from = from.unwrap_or(spot);
            match self.planner.way(&from, &spot, others) {
                Ok(way) => return Ok((spot, station.stances.get(number).copied(), way)),
                Err(why) => first = first.or(Some(why)),
            }
        }
        Err(first.unwrap_or(Blocked::OffFloor { at: station.goal.at }))
    }

    /// Puts in the way from one station to another and the sub-goals on it.
    fn walk(&mut self, from: usize, to: usize, way: &Way) {
        let stations = self.stations;
        let (a, b) = (&stations[from], &stations[to]);
        let still = [!a.is_through(), !b.is_through()];
        let on_way = between(way, still, &self.planner.config);
        if let Some((at, clearance_m)) = way.squeeze {
            self.route.squeezes.push((a.goal.id, at, clearance_m));
        }
        let mut begin = 0;
        for (count, place) in on_way.iter().enumerate() {
            self.leave(way.points[begin..=place.index].to_vec());
            let id = self.planned_id(a.goal.id, 2 + count as u32);
            let goal = planned(id, place.walking.at, place.walking.heading, GoalPose::Walk);
            self.push(goal, Role::Through(place.walking));
            begin = place.index;
        }
        self.leave(way.points[begin..].to_vec());
    }

    /// Puts in the station itself, with its standing before and after.
    fn stand(&mut self, index: usize, stance: Option<Stance>) {
        let goal = self.stations[index].goal.clone();
        let Some(stance) = stance else {
            let role = match (self.stations[index].is_through(), goal.facing) {
                (true, Some(heading)) => Role::Through(self.by_hand(flat(goal.at), heading)),
                _ => Role::Station(index),
            };
            self.push(goal, role);
            return;
        };
        let spot = vec![PathPoint {
            at: stance.at,
            heading: stance.facing,
            clearance_m: self.planner.floor().clearance_at(flat(stance.at)),
            speed_m_per_s: 0.0,
        }];
        let id = goal.id;
        if !self.route.stops.is_empty() {
            self.stand_before(id, index, stance, false);
            self.leave(spot.clone());
        }
        self.push(goal, Role::Station(index));
        if index + 1 < self.stations.len() {
            self.leave(spot);
            self.stand_before(id, index, stance, true);
        }
    }

    fn stand_before(&mut self, id: SubGoalId, station: usize, stance: Stance, leaving: bool) {
        let name = self.planned_id(id, u32::from(leaving));
        let goal = planned(name, stance.at, stance.facing, GoalPose::Stand);
        self.push(goal, Role::Before { station, stance, leaving });
    }

    /// A sub-goal that somebody put by hand is walked through as fast as its place allows.
    fn by_hand(&self, at: Vec2, heading: f32) -> Walking {
        let narrow = (self.planner.floor().clearance_at(at) / ROOMY_M).clamp(0.6, 1.0);
        Walking { at: self.planner.on_floor(at), heading, speed_m_per_s: BY_HAND_M_PER_S * narrow }
    }

    fn push(&mut self, goal: SubGoal, role: Role) {
        self.route.stops.push(Stop { goal, role, way: Vec::new() });
    }

    /// Says how it goes on from the last stop.
    fn leave(&mut self, way: Vec<PathPoint>) {
        if let Some(stop) = self.route.stops.last_mut() {
            stop.way = way;
        }
    }

    /// The name of the planned sub-goal `number` after `from`: the same whatever becomes of the rest.
    fn planned_id(&mut self, from: SubGoalId, number: u32) -> SubGoalId {
        let mixed =
            from.0.wrapping_mul(0x9e37_79b1).rotate_left(13).wrapping_add(number.wrapping_mul(0x85eb_ca6b));
        let mut id = PLANNED | ((mixed ^ (mixed >> 15)) & (PLANNED - 1));
        while !self.taken.insert(SubGoalId(id)) {
            id = PLANNED | (id.wrapping_add(1) & (PLANNED - 1));
        }
        SubGoalId(id)
    }

    /// Nobody gets up from the last seat: what follows it could not be reached.
    fn finish(&mut self) {
        if let Some(Stop { role: Role::Before { leaving: true, .. }, .. }) = self.route.stops.last() {
            self.route.stops.pop();
            self.leave(Vec::new());
        }
    }
}

fn planned(id: SubGoalId, at: glam::Vec3, facing: f32, pose: GoalPose) -> SubGoal {
    SubGoal { id, at, facing: Some(facing), pose, stay_s: 0.0, planned: true, locked: false, body: None }
}
