//! From a route to states: what the person is like at each sub-goal, and what lies between two of them.

use glam::Quat;

use super::others::Timing;
use super::resolve::Resolved;
use super::{Cast, JourneyRequest};
use crate::assets::ContentHasher;
use crate::job::Seed;
use crate::motion::gait;
use crate::motion::leg::{EndState, LegInput, PathPoint, Still};
use crate::motion::plan::{Role, Route, Stop};
use crate::scene::{CLIP_FPS, Clip, Frame, GoalPose, Leg, PoseFamily, SubGoal, SubGoalId};

/// Raised whenever the same inputs would give other frames than an earlier version of the program gave.
const MAKE: u64 = 1;
/// Sub-goals that the journey itself plans, beside those of the planner: the edges of beds.
const EDGE: u32 = 0x2000_0000;

/// A sub-goal, the state there, and the way on.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub goal: SubGoal,
    pub state: EndState,
    /// What the body rests on the room as, where anything but its feet carries it.
    pub family: Option<PoseFamily>,
    /// How long the person stays here, with waiting for others, seconds.
    pub stay_s: f32,
    /// The way to the next node; empty at the last.
    pub way: Vec<PathPoint>,
    /// The given sub-goal that this one belongs to or comes after.
    pub station: SubGoalId,
}

/// One thing to be made: the stay at a node, or the leg from it to the next.
#[derive(Clone, Debug)]
pub(super) enum Task {
    Stay { still: Still, seconds: f32, seed: Seed },
    Move(LegInput),
}

/// A leg that is to be made, and the digest of everything that it is made from.
#[derive(Clone, Debug)]
pub(super) struct Job {
    pub from: SubGoalId,
    pub to: SubGoalId,
    pub task: Task,
    /// What the body rests on the room as at the beginning and at the end.
    pub families: [Option<PoseFamily>; 2],
    pub key: u64,
}

/// The states along a route.
pub(super) fn nodes(
    cast: &Cast<'_>,
    resolved: &[Resolved],
    route: &Route,
    timing: &Timing,
    seed: Seed,
) -> Vec<Node> {
    let mut nodes: Vec<Node> = Vec::new();
    let mut station = SubGoalId(0);
    for (index, stop) in route.stops.iter().enumerate() {
        if let Role::Station(_) = stop.role {
            station = stop.goal.id;
        }
        let last = index + 1 == route.stops.len();
        match &stop.role {
            Role::Station(number) if resolved[*number].edge.is_some() => {
                nodes.extend(in_bed(&resolved[*number], stop, index == 0, last));
            }
            _ => nodes.push(node(cast, resolved, stop, station, seed)),
        }
    }
    for node in nodes.iter_mut().filter(|n| n.goal.id == n.station && matches!(n.state, EndState::Still(_))) {
        node.stay_s += timing.wait_s(node.station);
    }
    nodes
}

fn node(cast: &Cast<'_>, resolved: &[Resolved], stop: &Stop, station: SubGoalId, seed: Seed) -> Node {
    let betas = &cast.request.betas;
    let mut goal = stop.goal.clone();
    let mut family = None;
    let (state, stay_s) = match &stop.role {
        Role::Through(walking) => (EndState::Walking(*walking), 0.0),
        Role::Before { stance, .. } => {
            let feet =
                stance.feet.unwrap_or_else(|| gait::natural_feet(cast.body, betas, stance.at, stance.facing));
            let frame = gait::standing_frame(cast.body, betas, &feet, seed.child("stance", goal.id.0.into()));
            (EndState::Still(Still { frame, pose: GoalPose::Stand }), 0.0)
        }
        Role::Station(number) => {
            let known = &resolved[*number];
            goal = known.goal.clone();
            family = known.family;
            let frame = known.goal.body.clone().unwrap_or_default();
            (EndState::Still(Still { frame, pose: known.pose }), known.goal.stay_s)
        }
    };
    goal.body = Some(match &state {
        EndState::Still(still) => still.frame.clone(),
        EndState::Walking(walking) => gait::walking_frame(cast.body, betas, walking),
    });
    Node { goal, state, family, stay_s, way: stop.way.clone(), station }
}

/// Sits on the edge, lies, sits on the edge again; all on the spot. Whoever begins in bed lies, whoever ends there too.
fn in_bed(resolved: &Resolved, stop: &Stop, first: bool, last: bool) -> Vec<Node> {
    let (id, seat) = (resolved.goal.id, resolved.seated.as_ref());
    let spot = stop.way.first().copied().unwrap_or_else(|| spot_before(resolved));
    let node = |goal: SubGoal, frame: Frame, pose: GoalPose, stay_s: f32| Node {
        goal: SubGoal { body: Some(frame.clone()), ..goal },
        state: EndState::Still(Still { frame, pose }),
        family: if pose == GoalPose::Sit { Some(PoseFamily::SitEdge) } else { resolved.family },
        stay_s,
        way: vec![spot],
        station: id,
    };
    let edge = |leaving: bool| {
        let goal = SubGoal {
            id: SubGoalId(EDGE | ((id.0 << 1) & (EDGE - 1)) | u32::from(leaving)),
            at: seat?.pelvis,
            facing: Some(seat?.facing),
            pose: GoalPose::Sit,
            stay_s: 0.0,
            planned: true,
            ..resolved.goal.clone()
        };
        Some(node(goal, resolved.edge.clone()?, GoalPose::Sit, 0.0))
    };
    let lying = resolved.goal.body.clone().unwrap_or_default();
    let mut nodes: Vec<Node> = (!first).then(|| edge(false)).flatten().into_iter().collect();
    nodes.push(node(resolved.goal.clone(), lying, resolved.pose, resolved.goal.stay_s));
    nodes.extend((!last).then(|| edge(true)).flatten());
    if let (true, Some(end)) = (last, nodes.last_mut()) {
        end.way.clear();
    }
    nodes
}

/// Where the feet of somebody stand who sits on a bed's edge.
fn spot_before(resolved: &Resolved) -> PathPoint {
    let feet = resolved.seated.as_ref().map(|s| 0.5 * (s.feet[0].at + s.feet[1].at));
    PathPoint {
        at: feet.unwrap_or(resolved.goal.at),
        heading: resolved.seated.as_ref().map_or(0.0, |s| s.facing),
        clearance_m: 0.0,
        speed_m_per_s: 0.0,
    }
}

/// Everything that is to be made, in the order of time.
pub(super) fn jobs(request: &JourneyRequest, nodes: &[Node], seed: Seed) -> Vec<Job> {
    let mut jobs = Vec::new();
    for (index, node) in nodes.iter().enumerate() {
        let id = u64::from(node.goal.id.0);
        if let (EndState::Still(still), true) = (&node.state, node.stay_s > 0.0) {
            let seed = seed.child("stay", id);
            let task = Task::Stay { still: still.clone(), seconds: node.stay_s, seed };
            jobs.push(Job::new(request, node, node, task));
        }
        let Some(next) = nodes.get(index + 1) else { break };
        let input = LegInput {
            from: node.state.clone(),
            to: next.state.clone(),
            path: node.way.clone(),
            betas: request.betas,
            seconds: None,
            seed: seed.child("leg", id << 32 | u64::from(next.goal.id.0)),
        };
        jobs.push(Job::new(request, node, next, Task::Move(input)));
    }
    jobs
}

impl Job {
    fn new(request: &JourneyRequest, from: &Node, to: &Node, task: Task) -> Self {
        let mut digest = Digest::default();
        digest.0.write_number(MAKE);
        digest.0.write(request.method.label().as_bytes());
        digest.0.write_number(u64::from(request.optimise));
        request.betas.iter().for_each(|b| digest.number(*b));
        match &task {
            Task::Stay { still, seconds, seed } => {
                digest.still(still);
                digest.number(*seconds);
                digest.0.write_number(seed.value());
            }
            Task::Move(input) => {
                digest.state(&input.from);
                digest.state(&input.to);
                digest.path(&input.path);
                digest.0.write_number(input.seed.value());
            }
        }
        digest.0.write_number(family_number(from.family) << 8 | family_number(to.family));
        let families = [from.family, to.family];
        Self { from: from.goal.id, to: to.goal.id, task, families, key: digest.finish() }
    }
}

fn family_number(family: Option<PoseFamily>) -> u64 {
    family.and_then(|f| PoseFamily::ALL.iter().position(|g| *g == f)).map_or(0, |index| 1 + index as u64)
}

/// A digest of numbers, to the last bit.
#[derive(Default)]
struct Digest(ContentHasher);

impl Digest {
    fn number(&mut self, value: f32) {
        self.0.write_number(value.to_bits().into());
    }

    fn frame(&mut self, frame: &Frame) {
        frame.translation.to_array().into_iter().for_each(|v| self.number(v));
        frame.rotation.to_array().into_iter().for_each(|v| self.number(v));
        frame.pose.iter().flat_map(|p| p.to_array()).for_each(|v| self.number(v));
        frame.hands.iter().for_each(|v| self.number(*v));
    }

    fn still(&mut self, still: &Still) {
        self.frame(&still.frame);
        self.0.write_number(still.pose as u64);
    }

    fn state(&mut self, state: &EndState) {
        match state {
            EndState::Still(still) => self.still(still),
            EndState::Walking(walking) => {
                walking.at.to_array().into_iter().for_each(|v| self.number(v));
                self.number(walking.heading);
                self.number(walking.speed_m_per_s);
            }
        }
    }

    fn path(&mut self, path: &[PathPoint]) {
        self.0.write_number(path.len() as u64);
        for p in path {
            p.at.to_array().into_iter().for_each(|v| self.number(v));
            [p.heading, p.clearance_m, p.speed_m_per_s].into_iter().for_each(|v| self.number(v));
        }
    }

    /// Never 0, which says that a leg must be made again.
    fn finish(self) -> u64 {
        ((self.0.finish() >> 64) as u64).max(1)
    }
}

/// The route gone by bodies that do not step: the first thing to be seen.
pub(super) fn glide(cast: &Cast<'_>, nodes: &[Node]) -> Clip {
    let mut clip = Clip { frames: Vec::new(), ..empty_clip(cast.request, nodes) };
    for (index, node) in nodes.iter().enumerate() {
        let Some(body) = &node.goal.body else { continue };
        let next = nodes.get(index + 1).and_then(|n| n.goal.body.as_ref());
        let first = clip.frames.len();
        let hold = (node.stay_s * CLIP_FPS) as usize;
        clip.frames.extend(std::iter::repeat_n(body.clone(), hold.max(1)));
        let Some(next) = next else { continue };
        clip.frames.extend(glide_leg(body, next, &node.way));
        let leg =
            Leg { from: node.goal.id, to: nodes[index + 1].goal.id, first, last: clip.frames.len(), key: 0 };
        clip.legs.push(leg);
    }
    clip.planted = vec![[false; 2]; clip.frames.len()];
    clip
}

fn glide_leg(from: &Frame, to: &Frame, way: &[PathPoint]) -> Vec<Frame> {
    let seconds: f32 = way.windows(2).map(|p| p[0].at.distance(p[1].at) / p[0].speed_m_per_s.max(0.3)).sum();
    let count = (seconds.max(1.0) * CLIP_FPS) as usize;
    let along = |share: f32| {
        let mut frame = if share < 0.5 { from.clone() } else { to.clone() };
        let moved = from.translation.lerp(to.translation, share);
        frame.translation = moved;
        frame.rotation = from.rotation.slerp(to.rotation, share);
        if way.len() > 1 {
            let at = share * (way.len() - 1) as f32;
            let (a, b) = (&way[at as usize], &way[(at as usize + 1).min(way.len() - 1)]);
            let p = a.at.lerp(b.at, at.fract());
            (frame.translation.x, frame.translation.z) = (p.x, p.z);
            if (0.1..0.9).contains(&share) {
                frame.rotation = Quat::from_rotation_y(a.heading);
            }
        }
        frame
    };
    (1..count).map(|k| along(k as f32 / count as f32)).collect()
}

/// The clip of these nodes without frames: a plan.
pub(super) fn empty_clip(request: &JourneyRequest, nodes: &[Node]) -> Clip {
    Clip {
        id: request.id,
        name: request.name.clone(),
        betas: request.betas,
        palette: request.palette,
        fps: CLIP_FPS,
        goals: nodes.iter().map(|n| n.goal.clone()).collect(),
        ..Clip::default()
    }
}
