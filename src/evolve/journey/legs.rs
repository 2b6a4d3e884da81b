//! Makes the legs, takes those that did not change from the earlier clip, fits them to the room one by one with their
//! ends held, and joins them.

use std::sync::Arc;

use rayon::prelude::*;

use super::resolve::flat;
use super::states::{Job, Node, Task, empty_clip};
use super::{Cast, JourneyPreview, MotionMethod, Stage, by_memory};
use crate::fit::sequence::{SequenceConfig, SequenceFitter, SequenceTask};
use crate::job::{JobCtx, Seed, Stop, Ticker};
use crate::motion::gait;
use crate::motion::learned::LearnedMotion;
use crate::motion::leg::LegMotion;
use crate::motion::networks;
use crate::motion::plan::Planner;
use crate::motion::subgoal::SubGoalBodies;
use crate::scene::{Clip, Leg, PoseFamily, SubGoalId};

/// Frames at both ends of a leg that stay as they were made: two hold the place and the speed.
const PINNED: usize = 2;
/// While sitting down or getting up the seat carries for this part of the time.
const CARRIED: f32 = 0.3;

/// A leg as far as it is.
#[derive(Clone, Debug)]
struct Part {
    from: SubGoalId,
    to: SubGoalId,
    key: u64,
    motion: LegMotion,
    /// What the body rests on the room as, for each frame.
    rests: Vec<Option<PoseFamily>>,
    /// Whether it came from the earlier clip.
    kept: bool,
    /// Whether nothing more is to be done about it.
    done: bool,
}

/// All legs of a journey.
#[derive(Clone, Debug, Default)]
pub(super) struct Legs(Vec<Part>);

impl Legs {
    /// Makes every leg, on all threads.
    pub fn make(cast: &Cast<'_>, jobs: &[Job], ticker: &Ticker) -> Result<Self, Stop> {
        let one = |job: &Job| {
            let kept = kept_motion(cast.request.kept.as_deref(), job);
            let is_kept = kept.is_some();
            let motion = match kept {
                Some(motion) => motion,
                None => make(cast, job, ticker)?,
            };
            // Who stays is in a body that is fitted already, and breathing moves it by millimetres.
            let stays = matches!(job.task, Task::Stay { .. });
            let done = is_kept || stays || !cast.request.optimise;
            let rests = rests(job.families, motion.frames.len(), job.from == job.to);
            Ok(Part { from: job.from, to: job.to, key: job.key, motion, rests, kept: is_kept, done })
        };
        let parts: Result<Vec<Part>, Stop> = jobs.par_iter().map(one).collect();
        Ok(Self(parts?))
    }

    /// Legs that came from the earlier clip.
    pub fn kept(&self) -> usize {
        self.0.iter().filter(|part| part.kept).count()
    }

    /// Fits the legs to the room, those that are not done.
    pub fn fit(&mut self, cast: &Cast<'_>, nodes: &[Node], cx: &JobCtx<JourneyPreview>) -> Result<(), Stop> {
        cx.stage("fitting the motion to the room", self.0.len())?;
        let fitter = SequenceFitter::new(cast.body);
        for index in 0..self.0.len() {
            if !self.0[index].done {
                self.0[index].fit(cast, &fitter, &cx.ticker().without_progress())?;
                let clip = Arc::new(assemble(cast, nodes, self, cx.seed));
                cx.preview(JourneyPreview { clip, stage: Stage::Optimised });
            }
            cx.advance()?;
        }
        Ok(())
    }
}

impl Part {
    fn fit(&mut self, cast: &Cast<'_>, fitter: &SequenceFitter<'_>, ticker: &Ticker) -> Result<(), Stop> {
        let LegMotion { frames, planted } = &mut self.motion;
        let around = fitter.surroundings(cast.geometry, frames);
        let task = SequenceTask {
            betas: &cast.request.betas,
            planted,
            rests: &self.rests,
            pinned: [PINNED, PINNED],
        };
        fitter.optimise(&around, &task, frames, &SequenceConfig::default(), ticker, &mut |_| ())?;
        self.done = true;
        Ok(())
    }
}

/// What carries the body in each frame: seats and beds at the ends that rest on them, nothing but the feet in between;
/// whoever goes from a bed's edge to the bed is carried all along.
fn rests(ends: [Option<PoseFamily>; 2], count: usize, stays: bool) -> Vec<Option<PoseFamily>> {
    let share = |i: usize| i as f32 / count.saturating_sub(1).max(1) as f32;
    let at = |i: usize| match ends {
        [family, _] if stays => family,
        [Some(from), Some(to)] => Some(if share(i) < 0.5 { from } else { to }),
        [Some(from), None] => (share(i) < CARRIED).then_some(from),
        [None, Some(to)] => (share(i) > 1.0 - CARRIED).then_some(to),
        [None, None] => None,
    };
    (0..count).map(at).collect()
}

/// The leg's frames in an earlier clip, if it was made from the same there.
fn kept_motion(clip: Option<&Clip>, job: &Job) -> Option<LegMotion> {
    let clip = clip?;
    let leg = clip.legs.iter().find(|leg| leg.key == job.key && (leg.from, leg.to) == (job.from, job.to))?;
    let frames = clip.frames.get(leg.first..=leg.last)?.to_vec();
    let planted = clip.planted.get(leg.first..=leg.last)?.to_vec();
    Some(LegMotion { frames, planted })
}

fn make(cast: &Cast<'_>, job: &Job, ticker: &Ticker) -> Result<LegMotion, Stop> {
    match (&job.task, cast.request.method) {
        (Task::Stay { still, seconds, seed }, _) => {
            let floor_y =
                Planner::new(cast.geometry, cast.request.plan).on_floor(flat(still.frame.translation)).y;
            Ok(gait::idle(cast.body, &cast.request.betas, still, floor_y, *seconds, *seed))
        }
        (Task::Move(input), MotionMethod::Gait) => Ok(gait::synthesise_leg(cast.body, input, ticker)?),
        (Task::Move(input), MotionMethod::Learned) => {
            let points = networks::points_of(cast.geometry);
            Ok(networks::learned_leg(LearnedMotion::bundled()?, cast.body, &points, input, ticker)?)
        }
        (Task::Move(input), MotionMethod::RouteCvae) => {
            let points = networks::points_of(cast.geometry);
            let (nets, bodies) = (LearnedMotion::bundled()?, SubGoalBodies::bundled()?);
            Ok(networks::route_cvae_leg(nets, &bodies, cast.body, &points, input, ticker)?)
        }
        (Task::Move(input), MotionMethod::Retrieval) => by_memory::leg(cast, input, ticker),
    }
}

/// The clip of all legs, one after the other; neighbours share the frame where they meet.
pub(super) fn assemble(cast: &Cast<'_>, nodes: &[Node], legs: &Legs, seed: Seed) -> Clip {
    let mut clip = Clip { seed: seed.value(), ..empty_clip(cast.request, nodes) };
    if legs.0.is_empty() {
        clip.frames.extend(nodes.iter().take(1).filter_map(|n| n.goal.body.clone()));
    }
    for part in &legs.0 {
        let skip = usize::from(!clip.frames.is_empty());
        let first = clip.frames.len() - skip;
        clip.frames.extend(part.motion.frames.iter().skip(skip).cloned());
        clip.planted.extend(part.motion.planted.iter().skip(skip));
        let last = clip.frames.len().saturating_sub(1);
        // A leg that is not yet done must be made again by whoever goes on from here.
        let key = if part.done { part.key } else { 0 };
        clip.legs.push(Leg { from: part.from, to: part.to, first, last, key });
    }
    clip.planted.resize(clip.frames.len(), [true; 2]);
    clip
}
