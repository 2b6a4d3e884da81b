//! People who are there already go first: whoever comes after goes around them or waits.

use std::collections::BTreeMap;

use glam::Vec2;

use super::legs::{Legs, assemble};
use super::resolve::{Resolved, flat};
use super::states::{Node, jobs, nodes};
use super::{Cast, JourneyPreview, plan_route};
use crate::job::{JobCtx, Stop};
use crate::motion::plan::{Disc, Route};
use crate::scene::{Clip, SubGoalId};

/// People keep their middles at least this far apart, metres: two bodies' half widths and a hand's breadth.
const APART_M: f32 = 0.55;
/// Whoever is gone around takes this much room, half, metres: with one's own half width more than [`APART_M`].
const BODY_M: f32 = 0.48;
/// Where somebody is within this time of a meeting is kept free when going around, seconds.
const AROUND_S: f32 = 0.8;
/// One waits so long at a time, seconds.
const WAIT_S: f32 = 0.8;
/// And not longer than this at one place, seconds.
const LONGEST_WAIT_S: f32 = 24.0;
/// Times that a way is planned around where others turn out to be, before one waits.
const AROUND: usize = 4;
/// Attempts to get by each other before the meeting is reported.
const ATTEMPTS: usize = 60;

/// What is done to keep clear of others: where one waits, and what is gone around.
#[derive(Clone, Debug, Default)]
pub(super) struct Timing {
    wait_s: BTreeMap<SubGoalId, f32>,
    around: BTreeMap<SubGoalId, Vec<Disc>>,
    gone_around: BTreeMap<SubGoalId, usize>,
}

impl Timing {
    /// How long somebody waits at a sub-goal, beyond what was asked for.
    pub fn wait_s(&self, station: SubGoalId) -> f32 {
        self.wait_s.get(&station).copied().unwrap_or(0.0)
    }

    /// What the way that leaves a sub-goal goes around.
    pub fn around(&self, station: SubGoalId) -> Vec<Disc> {
        self.around.get(&station).cloned().unwrap_or_default()
    }
}

/// Two people too near to each other.
#[derive(Clone, Debug, PartialEq)]
pub struct Meeting {
    /// The frame of both clips.
    pub frame: usize,
    /// Name of the other motion.
    pub name: String,
    /// Between their middles, metres.
    pub distance_m: f32,
}

/// A route with its legs, clear of others as far as can be.
pub(super) struct Planned {
    pub nodes: Vec<Node>,
    pub legs: Legs,
    pub route: Route,
    pub meetings: Vec<Meeting>,
}

/// Plans and makes the legs; where they meet others, plans again.
pub(super) fn plan_in_time(
    cast: &Cast<'_>,
    resolved: &[Resolved],
    cx: &JobCtx<JourneyPreview>,
) -> Result<Planned, Stop> {
    let mut timing = Timing::default();
    let mut attempt = 0;
    loop {
        cx.stage("legs", 0)?;
        let route = plan_route(cast, resolved, &timing, cx.ticker())?;
        let nodes = nodes(cast, resolved, &route, &timing, cx.seed);
        let legs = Legs::make(cast, &jobs(cast.request, &nodes, cx.seed), cx.ticker())?;
        let clip = assemble(cast, &nodes, &legs, cx.seed);
        let meetings = meetings(&clip, cast);
        let Some(first) = meetings.first().filter(|_| attempt < ATTEMPTS) else {
            return Ok(Planned { nodes, legs, route, meetings });
        };
        attempt += 1;
        if !timing.avoid(cast, resolved, &nodes, &clip, first) {
            return Ok(Planned { nodes, legs, route, meetings });
        }
    }
}

impl Timing {
    /// Does something about a meeting: goes around at first, then waits longer and longer. Whether there was something
    /// left to do.
    fn avoid(
        &mut self,
        cast: &Cast<'_>,
        resolved: &[Resolved],
        nodes: &[Node],
        clip: &Clip,
        meeting: &Meeting,
    ) -> bool {
        let Some(station) = station_at(nodes, clip, meeting.frame) else { return false };
        let tried = self.gone_around.entry(station).or_insert(0);
        *tried += 1;
        if *tried <= AROUND {
            let discs = where_others_are(cast, clip, meeting.frame);
            self.around.entry(station).or_default().extend(discs);
            let reached = |timing: &Self| plan_route(cast, resolved, timing, &crate::job::Ticker::silent());
            let before = nodes.iter().filter(|n| !n.goal.planned).count();
            let all = |route: &Route| route.stops.iter().filter(|s| !s.goal.planned).count() == before;
            if reached(self).is_ok_and(|route| all(&route)) {
                return true;
            }
        }
        // Going around did not help, or could not be done: the straight way, later.
        self.gone_around.insert(station, AROUND);
        self.around.insert(station, Vec::new());
        let wait = self.wait_s.entry(station).or_insert(0.0);
        *wait += WAIT_S;
        *wait <= LONGEST_WAIT_S
    }
}

/// The given sub-goal that was left last before a frame, where that sub-goal is one of the clip's own.
fn station_at(nodes: &[Node], clip: &Clip, frame: usize) -> Option<SubGoalId> {
    let leg = clip.legs.iter().rev().find(|leg| leg.first <= frame && leg.from != leg.to)?;
    nodes.iter().find(|n| n.goal.id == leg.from).map(|n| n.station)
}

/// Where other people are around a frame.
fn where_others_are(cast: &Cast<'_>, clip: &Clip, frame: usize) -> Vec<Disc> {
    let reach = (AROUND_S * clip.fps) as usize;
    let step = reach.max(1);
    let frames = (frame.saturating_sub(reach)..=frame + reach).step_by(step);
    let others = &cast.request.others;
    let at = |f: usize| others.iter().filter_map(move |o| middle(o, f));
    let near = middle(clip, frame);
    let discs = frames.flat_map(at).filter(|at| near.is_none_or(|n| n.distance(*at) < 2.0));
    discs.map(|at| Disc { at, radius_m: BODY_M }).collect()
}

/// Where somebody is at a frame, seen from above; they stay where their clip ends.
fn middle(clip: &Clip, frame: usize) -> Option<Vec2> {
    clip.frames.get(frame).or_else(|| clip.frames.last()).map(|f| flat(f.translation))
}

/// The first moment of every approach that is too near.
fn meetings(clip: &Clip, cast: &Cast<'_>) -> Vec<Meeting> {
    let mut found = Vec::new();
    for other in &cast.request.others {
        let mut apart = true;
        for frame in 0..clip.frames.len() {
            let (Some(a), Some(b)) = (middle(clip, frame), middle(other, frame)) else { continue };
            let distance_m = a.distance(b);
            if apart && distance_m < APART_M {
                found.push(Meeting { frame, name: other.name.clone(), distance_m });
            }
            apart = distance_m >= APART_M;
        }
    }
    found.sort_by_key(|m| m.frame);
    found
}
