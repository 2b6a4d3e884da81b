//! From sub-goals to a motion: bodies at the sub-goals, a planned route, legs one by one, each fitted to the room
//! with its ends held, all of it measured (LTM §3.1: goals, then short motions between them, then optimisation).
//!
//! A leg is made from its two ends and the way between them alone: where these stay as they were in an earlier clip,
//! its frames are taken from there byte by byte. The same request and seed give the same bytes for any number of
//! threads. May not name the document or a front end; says what it could not do instead of doing something else.

mod by_memory;
mod legs;
mod others;
mod resolve;
mod states;
#[cfg(test)]
mod tests;
mod tour;

use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Instant;

use self::legs::assemble;
use self::others::{Planned, Timing};
use self::resolve::{Resolved, Resolver};
use self::states::nodes;
use crate::body::Body;
use crate::inspect::{MotionReport, inspect_motion};
use crate::job::{Cancelled, JobCtx, Seed, Stop, Ticker};
use crate::motion::gait;
use crate::motion::plan::{Blocked, PlanConfig, Planner, Route, Unreachable, route};
use crate::motion::retrieval::MotionMemory;
use crate::scene::{BETAS, Clip, ClipId, GoalPose, Room, RoomGeometry, SubGoal, SubGoalId};

pub use self::others::Meeting;
pub use self::tour::tour;

/// A requested position is met when the pelvis is this near, centimetres.
pub const GOAL_CM: f32 = 3.0;
/// A requested facing is met when the body is turned by at most this, degrees.
pub const GOAL_DEG: f32 = 5.0;

/// Who makes the legs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum MotionMethod {
    /// Steps by rule and by statistics of walks.
    #[default]
    Gait,
    /// RouteNet and PoseNet (LTM §3.3).
    Learned,
    /// RouteNet and a body from the sub-goal network in each frame (LTM §4.4).
    RouteCvae,
    /// Short clips from a memory, blended (after Xu et al. 2020).
    Retrieval,
}

impl MotionMethod {
    /// Name on the command line and in reports.
    pub fn label(self) -> &'static str {
        match self {
            Self::Gait => "gait",
            Self::Learned => "learned",
            Self::RouteCvae => "cvae",
            Self::Retrieval => "retrieval",
        }
    }
}

/// What is asked for.
#[derive(Clone, Debug)]
pub struct JourneyRequest {
    /// Name of the clip that is made.
    pub id: ClipId,
    /// Name for people.
    pub name: String,
    /// Chooses the clothes' colours.
    pub palette: u32,
    /// Body shape β.
    pub betas: [f32; BETAS],
    /// Where to be, in the order of time. Planned ones among them that are not locked are planned anew.
    pub goals: Vec<SubGoal>,
    /// Who makes the legs.
    pub method: MotionMethod,
    /// Clips to look legs up in, for [`MotionMethod::Retrieval`].
    pub memory: Option<Arc<MotionMemory>>,
    /// What walking people are held to.
    pub plan: PlanConfig,
    /// Whether the legs are fitted to the room; without, they are as they were made.
    pub optimise: bool,
    /// An earlier clip of the same person: its legs are kept where nothing that they were made from has changed.
    pub kept: Option<Arc<Clip>>,
    /// People who move already and go first; all clips begin at the same time.
    pub others: Vec<Arc<Clip>>,
}

impl Default for JourneyRequest {
    fn default() -> Self {
        Self {
            id: ClipId(0),
            name: "Motion 1".to_owned(),
            palette: 0,
            betas: [0.0; BETAS],
            goals: Vec::new(),
            method: MotionMethod::Gait,
            memory: None,
            plan: PlanConfig::default(),
            optimise: true,
            kept: None,
            others: Vec::new(),
        }
    }
}

/// How far a journey is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// The way, gone by a body that does not step.
    Route,
    /// The poses, not yet fitted to the room.
    Poses,
    /// Some legs are fitted.
    Optimised,
}

/// The motion as it is while the job runs; plays as it is.
#[derive(Clone, Debug)]
pub struct JourneyPreview {
    /// The motion.
    pub clip: Arc<Clip>,
    /// How far it is.
    pub stage: Stage,
}

/// How a sub-goal that was asked for is met by its body.
#[derive(Clone, Debug, PartialEq)]
pub struct GoalReport {
    /// Which sub-goal.
    pub goal: SubGoalId,
    /// What is done there.
    pub pose: GoalPose,
    /// Name of what holds the body.
    pub on: String,
    /// From the point asked for to the pelvis, along the floor, centimetres.
    pub miss_cm: f32,
    /// Between the facing asked for and the body's, degrees; 0 where none was asked for.
    pub miss_deg: f32,
}

impl GoalReport {
    /// Whether position and facing are as near as they should be.
    pub fn is_met(&self) -> bool {
        self.miss_cm <= GOAL_CM && self.miss_deg <= GOAL_DEG
    }
}

/// The result.
#[derive(Clone, Debug)]
pub struct Journey {
    /// The motion.
    pub clip: Clip,
    /// Every sub-goal that was asked for and reached.
    pub goals: Vec<GoalReport>,
    /// Those that can't be reached, and why.
    pub unreachable: Vec<Unreachable>,
    /// Where the person squeezes through: the sub-goal before, where, and the free radius in metres.
    pub squeezes: Vec<(SubGoalId, glam::Vec3, f32)>,
    /// Where, after all waiting and going around, people still come too near to each other.
    pub meetings: Vec<Meeting>,
    /// What was measured of every frame and of the whole.
    pub motion: MotionReport,
    /// Legs that were taken from the earlier clip.
    pub legs_kept: usize,
    /// Where the time went.
    pub seconds: JourneySeconds,
}

/// Wall-clock seconds of the stages of a journey.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct JourneySeconds {
    /// Until something played.
    pub first_preview: f64,
    /// Bodies at the sub-goals.
    pub bodies: f64,
    /// Routes and poses, with keeping clear of others.
    pub poses: f64,
    /// Fitting the legs to the room.
    pub fit: f64,
    /// Measuring every frame.
    pub measure: f64,
}

impl Journey {
    /// What could not be done as asked, in words for people.
    pub fn complaints(&self, room: &Room) -> Vec<String> {
        // People count sub-goals from 1.
        let number = |goal: SubGoalId| goal.0 + 1;
        let unreachable =
            self.unreachable.iter().map(|u| format!("sub-goal {}: {}", number(u.goal), u.why.in_words(room)));
        let missed = self.goals.iter().filter(|g| !g.is_met()).map(|g| {
            format!(
                "sub-goal {}: the body on {} is {:.0} cm and {:.0} degrees from what was asked for; nothing nearer holds \
                 it",
                number(g.goal),
                g.on,
                g.miss_cm,
                g.miss_deg
            )
        });
        let meets = self
            .meetings
            .iter()
            .map(|m| format!("frame {}: comes within {:.0} cm of {}", m.frame, 100.0 * m.distance_m, m.name));
        unreachable.chain(missed).chain(meets).collect()
    }
}

/// The seed of one of a scene's motions under the user's: two motions of the same sub-goals are two people's, and
/// whoever makes a motion, with a window or without, makes the same.
pub fn seed_of(root: Seed, clip: ClipId) -> Seed {
    root.child("person", u64::from(clip.0))
}

/// Everything that the parts of one journey share.
struct Cast<'a> {
    room: &'a Room,
    geometry: &'a RoomGeometry,
    body: &'a Body,
    request: &'a JourneyRequest,
}

/// Makes the motion that the request asks for.
///
/// # Errors
/// [`Stop::Cancelled`] when the user cancelled; [`Stop::Failed`] when not even the first sub-goal can be reached, or
/// there is none. Single sub-goals that can't be reached are left out and told in [`Journey::unreachable`].
pub fn journey(
    room: &Room,
    geometry: &RoomGeometry,
    body: &Body,
    request: &JourneyRequest,
    cx: &JobCtx<JourneyPreview>,
) -> Result<Journey, Stop> {
    let cast = Cast { room, geometry, body, request };
    let mut clock = Clock(Instant::now());
    let mut seconds = JourneySeconds::default();
    cx.stage("looking for places", 0)?;
    let resolver = Resolver::new(&cast, cx.seed, cx.ticker())?;
    show_route(&cast, &resolver, cx)?;
    seconds.first_preview = clock.lap();
    cx.stage("bodies at the sub-goals", request.goals.len())?;
    let (resolved, mut unreachable) = resolver.all(false, cx.ticker())?;
    if resolved.is_empty() {
        return Err(Stop::Failed(nowhere(room, &unreachable)));
    }
    seconds.bodies = clock.lap();
    let Planned { nodes, mut legs, route, meetings } = others::plan_in_time(&cast, &resolved, cx)?;
    let poses = assemble(&cast, &nodes, &legs, cx.seed);
    cx.preview(JourneyPreview { clip: Arc::new(poses), stage: Stage::Poses });
    seconds.poses = clock.lap();
    legs.fit(&cast, &nodes, cx)?;
    let clip = assemble(&cast, &nodes, &legs, cx.seed);
    seconds.fit = clock.lap();
    let motion = measure(&cast, &clip, cx)?;
    seconds.measure = clock.lap();
    unreachable.extend(route.unreachable);
    if clip.frames.is_empty() {
        return Err(Stop::Failed(nowhere(room, &unreachable)));
    }
    Ok(Journey {
        goals: reports(&resolved, &clip),
        clip,
        unreachable,
        squeezes: route.squeezes,
        meetings,
        motion,
        legs_kept: legs.kept(),
        seconds,
    })
}

/// Times one stage after the other.
struct Clock(Instant);

impl Clock {
    /// Seconds since the last lap.
    fn lap(&mut self) -> f64 {
        std::mem::replace(&mut self.0, Instant::now()).elapsed().as_secs_f64()
    }
}

/// Shows the route, gone by bodies that are settled but not fitted: the first thing to be seen.
fn show_route(cast: &Cast<'_>, resolver: &Resolver<'_>, cx: &JobCtx<JourneyPreview>) -> Result<(), Stop> {
    let (quick, _) = resolver.all(true, cx.ticker())?;
    let timing = Timing::default();
    let route = plan_route(cast, &quick, &timing, cx.ticker())?;
    let clip = states::glide(cast, &nodes(cast, &quick, &route, &timing, cx.seed));
    cx.preview(JourneyPreview { clip: Arc::new(clip), stage: Stage::Route });
    Ok(())
}

fn measure(cast: &Cast<'_>, clip: &Clip, cx: &JobCtx<JourneyPreview>) -> Result<MotionReport, Cancelled> {
    cx.stage("measuring", clip.frames.len())?;
    let go_on = |_, _| match cx.advance() {
        Ok(()) => ControlFlow::Continue(()),
        Err(Cancelled) => ControlFlow::Break(()),
    };
    inspect_motion(&cast.geometry.field, cast.body, clip, &go_on).map_err(|_| Cancelled)
}

fn nowhere(room: &Room, unreachable: &[Unreachable]) -> String {
    match unreachable.first() {
        Some(first) => format!("no sub-goal can be reached: {}", first.why.in_words(room)),
        None => "there is no sub-goal: say where to be".to_owned(),
    }
}

fn plan_route(
    cast: &Cast<'_>,
    resolved: &[Resolved],
    timing: &Timing,
    ticker: &Ticker,
) -> Result<Route, Stop> {
    let plan = &cast.request.plan;
    let stride_m = gait::stride_m(cast.body, &cast.request.betas, plan.speed_m_per_s);
    let planner = Planner::new(cast.geometry, PlanConfig { stride_m, ..*plan });
    let stations: Vec<_> = resolved.iter().map(|r| r.station(&planner)).collect();
    Ok(route(&planner, &stations, &|from| timing.around(from), ticker)?)
}

/// The reports of sub-goals that were asked for and stand in the clip.
fn reports(resolved: &[Resolved], clip: &Clip) -> Vec<GoalReport> {
    let there = |r: &&Resolved| !r.goal.planned && clip.goal(r.goal.id).is_some();
    resolved.iter().filter(there).map(|r| r.report()).collect()
}

/// Whether a goal can be reached from a point of the floor, for a ghost that is being dragged.
///
/// # Errors
/// [`Blocked`] says what is in the way.
pub fn reach(
    geometry: &RoomGeometry,
    from: glam::Vec3,
    to: glam::Vec3,
    config: PlanConfig,
) -> Result<crate::motion::plan::Way, Blocked> {
    use crate::motion::plan::Spot;
    Planner::new(geometry, config).way(&Spot::open(from), &Spot::open(to), &[])
}
