//! The day's person on the way: from where they are to the next action, which they do for a while.

use glam::{Quat, Vec2, Vec3};

use super::{CHANGE_S, Day, DayRequest};
use crate::body::{Body, FrameJoints, joints};
use crate::evolve::action::{Evolution, StepPerson};
use crate::evolve::journey::{JourneyPreview, JourneyRequest, journey, reach, tour};
use crate::job::{Cancelled, JobCtx, Stop};
use crate::motion::plan::PlanConfig;
use crate::scene::{
    BETAS, Clip, Frame, GeometryConfig, GoalPose, ObjectId, Person, Room, RoomGeometry, SubGoal, SubGoalId,
    direction_of, facing_of,
};

/// Who sits this near to the next action turns to it without getting up, metres.
const SAME_SEAT_M: f32 = 0.7;
/// Turning to it, or leaning to a counter and back, takes so long, seconds.
const TURN_S: f32 = 1.0;
/// Things begin to change once somebody is this near, metres.
const NEAR_M: f32 = 0.9;
/// Who stands at a counter walks up to the nearest place before it where a walker fits, this far off at most, metres.
const STEP_BACK_M: f32 = 0.4;
/// In such steps.
const STEPS: usize = 9;

/// Where somebody is and what they do there.
#[derive(Clone, Debug)]
pub(super) struct At {
    pose: GoalPose,
    /// The body there.
    frame: Frame,
    /// What carries it: the seat, the floor.
    under: Vec3,
    /// Which way they face; lying, from the pelvis to the feet.
    facing: f32,
    chair: Option<ObjectId>,
}

impl At {
    /// Of somebody fitted at an action.
    pub fn of(person: &Person, planned: &StepPerson) -> Self {
        let body = Body::bundled();
        let frame = Frame::of(&person.body, &body.pose_space.decode(&person.body.pose));
        let pose = match person.family.group() {
            "sit" => GoalPose::Sit,
            "lie" => GoalPose::Lie,
            _ => GoalPose::Stand,
        };
        let at = FrameJoints::of(&body.model.rest_joints(&person.body.betas), &frame).positions;
        let facing = match pose {
            GoalPose::Lie => {
                let feet = 0.5 * (at[joints::LEFT_ANKLE] + at[joints::RIGHT_ANKLE]);
                facing_of(flat(feet - at[joints::PELVIS]))
            }
            _ => facing_of(flat(frame.rotation * Vec3::Z)),
        };
        let pelvis = at[joints::PELVIS];
        let under = Vec3::new(pelvis.x, planned.place.under_pelvis.y, pelvis.z);
        Self { pose, frame, under, facing, chair: planned.chair }
    }

    fn goal(&self, id: u32, stay_s: f32) -> SubGoal {
        SubGoal {
            id: SubGoalId(id),
            at: self.under,
            facing: Some(self.facing),
            pose: self.pose,
            stay_s,
            planned: false,
            locked: true,
            body: Some(self.frame.clone()),
        }
    }
}

fn flat(v: Vec3) -> Vec2 {
    Vec2::new(v.x, v.z)
}

/// When what happened, seconds.
pub(super) struct Times {
    pub changes_s: f32,
    pub arrives_s: f32,
    pub leaves_s: f32,
    pub walked: bool,
}

/// The person and the motion so far.
pub(super) struct Walker<'a> {
    request: &'a DayRequest,
    clip: Clip,
    /// Where they are.
    here: At,
    /// Where they are in truth when they are done here: one step back from a counter.
    from: At,
}

impl<'a> Walker<'a> {
    /// Somebody who stands where one comes in.
    pub fn new(start: &Evolution, request: &'a DayRequest, cx: &JobCtx<Day>) -> Result<Self, Stop> {
        let room = start.room();
        let geometry = understand(&room, cx)?;
        let goals = tour(&room, &geometry, 10.0, cx.ticker())?;
        let Some(first) = goals.into_iter().next() else {
            return Err(Stop::Failed("there is no floor to stand on: nobody can come in".to_owned()));
        };
        let quiet = JobCtx::watched(cx.seed.child("begin", 0), cx.ticker().without_progress());
        let goal = SubGoal { id: SubGoalId(0), stay_s: 1.0, ..first };
        let asked = JourneyRequest { goals: vec![goal], optimise: false, ..JourneyRequest::default() };
        let clip = journey(&room, &geometry, Body::bundled(), &asked, &quiet)?.clip;
        let Some(frame) = clip.frames.last().cloned() else {
            return Err(Stop::Failed("nobody can stand where one comes in".to_owned()));
        };
        let (under, facing) = match clip.goals.first() {
            Some(goal) => (goal.at, facing_of(flat(frame.rotation * Vec3::Z))),
            None => (frame.translation.with_y(0.0), 0.0),
        };
        let here = At { pose: GoalPose::Stand, frame, under, facing, chair: None };
        let clip = Clip { name: "A day".to_owned(), goals: Vec::new(), legs: Vec::new(), ..clip };
        Ok(Self { request, clip, from: here.clone(), here })
    }

    /// The body's shape.
    pub fn betas(&self) -> &[f32; BETAS] {
        &self.clip.betas
    }

    /// The motion so far.
    pub fn clip(&self) -> Clip {
        self.clip.clone()
    }

    fn now_s(&self) -> f32 {
        self.clip.seconds()
    }

    /// Goes to the action of `state` and does it; nothing is changed where that can't be.
    pub fn go(
        &mut self,
        state: &Evolution,
        there: &At,
        cx: &JobCtx<JourneyPreview>,
    ) -> Result<Result<Times, String>, Stop> {
        let sits = |at: &At| at.pose == GoalPose::Sit;
        let near = self.here.frame.translation.distance(there.frame.translation) < SAME_SEAT_M;
        if near
            && (sits(&self.here) && sits(there)
                || self.here.pose == there.pose && there.pose == GoalPose::Lie)
        {
            return Ok(Ok(self.turn_to(there)));
        }
        let room = self.room_between(state);
        let geometry = understand(&room, cx)?;
        let Some(goal) = target(&geometry, there, self.request.stay_s) else {
            return Ok(Err("nobody can stand before it".to_owned()));
        };
        let asked = JourneyRequest {
            betas: self.clip.betas,
            palette: self.clip.palette,
            goals: vec![self.from.goal(0, 0.0), goal.clone()],
            optimise: self.request.optimise,
            ..JourneyRequest::default()
        };
        let made = match journey(&room, &geometry, Body::bundled(), &asked, cx) {
            Ok(made) => made,
            Err(Stop::Failed(why)) => return Ok(Err(why)),
            Err(other) => return Err(other),
        };
        if let Some(why) = made.unreachable.first() {
            return Ok(Err(why.why.in_words(&room)));
        }
        Ok(Ok(self.walk(made.clip, there, &goal)))
    }

    /// Turns to what is done at the same seat.
    fn turn_to(&mut self, there: &At) -> Times {
        let changes_s = self.now_s();
        self.blend(&there.frame);
        let arrives_s = self.now_s();
        self.hold(self.request.stay_s);
        (self.here, self.from) = (there.clone(), there.clone());
        Times { changes_s, arrives_s, leaves_s: self.now_s(), walked: false }
    }

    /// Appends the walk and what is done at its end.
    fn walk(&mut self, made: Clip, there: &At, goal: &SubGoal) -> Times {
        let begins_s = self.now_s();
        let stay = made.legs.iter().find(|leg| leg.from == goal.id && leg.to == goal.id);
        let arrival = stay.map_or(made.frames.len().saturating_sub(1), |leg| leg.first);
        let last = made.frames[arrival].translation;
        let is_far = |frame: &Frame| flat(frame.translation - last).length() > NEAR_M;
        let near = made.frames[..=arrival].iter().rposition(is_far).map_or(0, |far| far + 1);
        let latest_s = (arrival as f32 / made.fps - CHANGE_S).max(0.0);
        let changes_s = begins_s + (near as f32 / made.fps).min(latest_s);
        let stands = there.pose == GoalPose::Stand;
        let kept = if stands { arrival + 1 } else { made.frames.len() };
        self.clip.frames.extend(made.frames[1.min(kept)..kept].iter().cloned());
        self.clip.planted.extend(made.planted[1.min(kept)..kept].iter().copied());
        self.here = there.clone();
        if stands {
            // A step to the counter, the work, and a step back to where one can walk.
            let before = made.frames[arrival].clone();
            self.blend(&there.frame);
            let arrives_s = self.now_s();
            self.hold(self.request.stay_s);
            let leaves_s = self.now_s();
            self.blend(&before);
            self.from = At { frame: before, under: goal.at, facing: there.facing, ..there.clone() };
            return Times { changes_s, arrives_s, leaves_s, walked: true };
        }
        let frame = self.clip.frames.last().cloned().unwrap_or_default();
        self.from = At { frame, ..there.clone() };
        let arrives_s = begins_s + arrival as f32 / made.fps;
        Times { changes_s, arrives_s, leaves_s: self.now_s(), walked: true }
    }

    /// From the last frame to another, slow at both ends.
    fn blend(&mut self, to: &Frame) {
        let Some(from) = self.clip.frames.last().cloned() else { return };
        let count = (TURN_S * self.clip.fps) as usize;
        for i in 1..=count {
            let t = i as f32 / count as f32;
            self.clip.frames.push(between(&from, to, t * t * (3.0 - 2.0 * t)));
        }
        self.clip.planted.resize(self.clip.frames.len(), [true; 2]);
    }

    fn hold(&mut self, seconds: f32) {
        let Some(frame) = self.clip.frames.last().cloned() else { return };
        let count = self.clip.frames.len() + (seconds * self.clip.fps) as usize;
        self.clip.frames.resize(count, frame);
        self.clip.planted.resize(count, [true; 2]);
    }

    /// The room of a state, for walking: somebody who sits on a chair gets up from where it stands now, even where the
    /// action takes that chair elsewhere.
    fn room_between(&self, state: &Evolution) -> Room {
        let mut room = state.room();
        let moved = |id: &ObjectId| {
            let before = state.steps().last().and_then(|s| s.moved.iter().find(|m| m.id == *id))?;
            let object = room.object(*id)?.clone();
            let item = state.world().item(*id)?;
            let back = before.from.matrix() * item.world_from_item().inverse();
            let name = format!("{} before", object.name);
            let fresh = ObjectId(room.objects.iter().map(|o| o.id.0 + 1).max()?);
            Some(crate::scene::Object {
                id: fresh,
                name,
                world_from_object: back * object.world_from_object,
                ..object
            })
        };
        if let Some(before) = self.here.chair.as_ref().and_then(moved) {
            room.objects.push(before);
        }
        room
    }
}

/// The sub-goal of an action: at seats and beds the body itself, at counters a place before it where a walker fits.
fn target(geometry: &RoomGeometry, there: &At, stay_s: f32) -> Option<SubGoal> {
    if there.pose != GoalPose::Stand {
        return Some(there.goal(1, stay_s));
    }
    let back = -direction_of(there.facing);
    let free = (0..STEPS).map(|i| STEP_BACK_M * i as f32 / (STEPS - 1) as f32).find_map(|off_m| {
        let at = there.under + Vec3::new(back.x, 0.0, back.y) * off_m;
        reach(geometry, at, at, PlanConfig::default()).is_ok().then_some(at)
    });
    Some(SubGoal { at: free?, locked: false, body: None, ..there.goal(1, 0.0) })
}

/// A body between two: joints by themselves, the shorter way.
fn between(from: &Frame, to: &Frame, t: f32) -> Frame {
    let turn =
        |a: Vec3, b: Vec3| Quat::from_scaled_axis(a).slerp(Quat::from_scaled_axis(b), t).to_scaled_axis();
    Frame {
        translation: from.translation.lerp(to.translation, t),
        rotation: from.rotation.slerp(to.rotation, t),
        pose: std::array::from_fn(|joint| turn(from.pose[joint], to.pose[joint])),
        hands: std::array::from_fn(|i| from.hands[i] + (to.hands[i] - from.hands[i]) * t),
    }
}

fn understand<P: 'static>(room: &Room, cx: &JobCtx<P>) -> Result<RoomGeometry, Stop> {
    let step = |_, _| match cx.ticker().check() {
        Ok(()) => std::ops::ControlFlow::Continue(()),
        Err(Cancelled) => std::ops::ControlFlow::Break(()),
    };
    RoomGeometry::build(room, &GeometryConfig::default(), &step).map_err(|_| Stop::Cancelled)
}
