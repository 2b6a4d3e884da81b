use glam::Vec3;
use rayon::prelude::*;

use super::config::{MotionObjective, SequenceConfig, Stage};
use super::descent::{MotionEnergy, Subject, Terms, Window};
use super::lock::Lock;
use super::ours::OurEnergy;
use super::paper::{PaperEnergy, PaperScene};
use super::stance::{FootPlan, foot_of};
use crate::body::joints::{BODY_JOINTS, JOINTS};
use crate::body::{Body, Feet, FrameJoints, JointLimit, VertexSubset, Workspace, joint_limits};
use crate::fit::probe::Probe;
use crate::fit::surroundings::{Bins, Surroundings};
use crate::job::{Cancelled, Ticker};
use crate::math::Aabb;
use crate::scene::{BETAS, Frame, OpenBlocks, PoseFamily, RoomGeometry};

/// What is known of a motion besides its frames. Lists shorter than the motion say nothing of the frames beyond.
#[derive(Clone, Copy, Debug)]
pub struct SequenceTask<'a> {
    /// Body shape, the same in every frame.
    pub betas: &'a [f32; BETAS],
    /// Whether the left and the right foot is planted, for each frame.
    pub planted: &'a [[bool; 2]],
    /// The family of the pose in frames in which something carries the body besides its feet: it sits or lies.
    pub rests: &'a [Option<PoseFamily>],
    /// Frames at the beginning and at the end that stay byte for byte: two keep the place and the speed, so that a
    /// neighbouring motion joins without a jump.
    pub pinned: [usize; 2],
}

impl SequenceTask<'_> {
    /// What carries the body in frame `i` besides its feet.
    pub fn rest(&self, i: usize) -> Option<PoseFamily> {
        self.rests.get(i).copied().flatten()
    }

    /// Whether frame `i` of `total` must stay.
    pub fn is_pinned(&self, i: usize, total: usize) -> bool {
        i < self.pinned[0] || i + self.pinned[1] >= total
    }
}

/// How an optimisation went.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sequenced {
    /// The weighted value of each of [`crate::fit::TERMS`] at every iteration, summed over the frames. Frames that two
    /// windows share count in both.
    pub trace: Vec<Terms>,
    /// How often windows were gone through again because a body was found deep in something with all vertices.
    pub rounds: usize,
    /// By how much the worst leg is too short for its planted foot, metres: that foot is not quite where it should be.
    pub short_m: f32,
}

/// Optimises motions of one body model; holds what can be found once. Shared by threads, keeps nothing between motions.
pub struct SequenceFitter<'a> {
    body: &'a Body,
    probe: Probe,
    limits: [JointLimit; BODY_JOINTS],
}

/// One skin vertex is taken of each cube of this size, metres; contact regions give at most so many vertices each.
const SKIN_SAMPLE_M: f32 = 0.045;
const REGION_SAMPLE: usize = 40;
/// A frame with a vertex deeper than this after the feet are locked goes through another round, metres.
const DEEP_M: f32 = 0.02;
/// In this many frames before and after one with a fault ours may change a motion; farther off it stays as it came in.
const NEAR_FRAMES: usize = 24;
/// Faults: a vertex this deep in something, or a planted foot this far off its place, metres.
const TOUCHES_M: f32 = 0.004;
const STRAYS_M: f32 = 0.01;
/// Neighbours of a held frame that is deep in something can't be much better than that frame, metres.
const AS_DEEP_M: f32 = 0.003;
/// Skin is this near to some joint, and a body moves this far at most while it is optimised, both together, metres.
/// Where it goes farther, all is right and only slower.
const AROUND_M: f32 = 0.6;
/// A body reaches this far from its pelvis, metres, and moves a little.
const REACH_M: f32 = 1.3;

impl<'a> SequenceFitter<'a> {
    /// A fitter of `body`.
    pub fn new(body: &'a Body) -> Self {
        Self { body, probe: Probe::sparse(body, SKIN_SAMPLE_M, REGION_SAMPLE), limits: joint_limits() }
    }

    /// The room around a motion: all that [`SequenceFitter::optimise`] needs of it. A few tenths of a second for a
    /// finely tiled room, so the parts of one motion share it.
    pub fn surroundings<'g>(&self, geometry: &'g RoomGeometry, frames: &[Frame]) -> Surroundings<'g> {
        let pelvis = self.body.model.joint_template[0];
        let way = Aabb::of(frames.iter().map(|frame| frame.translation + pelvis).filter(|p| p.is_finite()));
        Surroundings::along(geometry, way.grown(REACH_M))
    }

    /// Optimises `frames` in place. `preview` gets all frames whenever some seconds of motion more are done.
    ///
    /// Our energy asks a sample of some 1,300 vertices. What it misses is found with all of them at the end of a round,
    /// and the windows that hold such frames go through another.
    ///
    /// # Errors
    /// [`Cancelled`] once the user cancelled; it is asked at every iteration and every frame that is measured. The frames keep the best so far, their
    /// planted feet locked.
    pub fn optimise(
        &self,
        around: &Surroundings<'_>,
        task: &SequenceTask<'_>,
        frames: &mut [Frame],
        config: &SequenceConfig,
        ticker: &Ticker,
        preview: &mut dyn FnMut(&[Frame]),
    ) -> Result<Sequenced, Cancelled> {
        let run = Run::new(self, around, task, frames, config, ticker)?;
        let mut done = Sequenced { trace: vec![Terms::default(); run.iterations()], ..Sequenced::default() };
        let mut windows = windows(frames.len(), config.window, config.overlap);
        windows.retain(|window| run.free[window.clone()].contains(&true));
        let mut result = Ok(());
        for round in 0..config.rounds.max(1) {
            result = run.descend(&windows, round, frames, &mut done.trace, ticker, preview);
            if config.lock_feet {
                done.short_m = run.lock(frames);
            }
            if result.is_err() || round + 1 >= config.rounds {
                break;
            }
            let deep = match run.deep_frames(frames, ticker) {
                Ok(deep) => deep,
                Err(cancelled) => {
                    result = Err(cancelled);
                    break;
                }
            };
            windows.retain(|window| deep.iter().any(|i| window.contains(i)));
            if windows.is_empty() {
                break;
            }
            done.rounds += 1;
        }
        result.map(|()| done)
    }
}

/// One optimisation: what is found once from the motion as it came in.
pub(super) struct Run<'r> {
    fitter: &'r SequenceFitter<'r>,
    around: &'r Surroundings<'r>,
    task: &'r SequenceTask<'r>,
    config: &'r SequenceConfig,
    input: Vec<Frame>,
    rest: [Vec3; JOINTS],
    feet: Feet,
    plan: FootPlan,
    bins: Bins,
    sample: VertexSubset,
    all: VertexSubset,
    paper: Option<PaperScene>,
    /// Where no vertex can be in a solid.
    open: OpenBlocks,
    /// Frames that may change.
    free: Vec<bool>,
}

impl<'r> Run<'r> {
    pub fn new(
        fitter: &'r SequenceFitter<'r>,
        around: &'r Surroundings<'r>,
        task: &'r SequenceTask<'r>,
        frames: &[Frame],
        config: &'r SequenceConfig,
        ticker: &Ticker,
    ) -> Result<Self, Cancelled> {
        let (body, betas) = (fitter.body, task.betas);
        let rest = body.model.rest_joints(betas);
        let feet = Feet::of(body, betas);
        let figures: Vec<FrameJoints> = frames.par_iter().map(|f| FrameJoints::of(&rest, f)).collect();
        let plan = FootPlan::of(&feet, around.field, task, &figures);
        let is_paper = |stage: &Stage| matches!(stage.objective, MotionObjective::Paper(_));
        let all = VertexSubset::all_of_shape(&body.model, betas);
        let subject = Subject { body, betas, skin: &all, field: around.field };
        let paper = config.stages.iter().any(is_paper).then(|| PaperScene::of(&subject, frames));
        let joints = figures.iter().flat_map(|figure| figure.positions).filter(|p| p.is_finite());
        let open = OpenBlocks::within(around.field, &Aabb::of(joints).grown(AROUND_M));
        let bins = Bins::new(&around.surface, &Aabb::of(around.surface.iter().copied()));
        let sample = VertexSubset::of_shape(&body.model, fitter.probe.subset.ids().to_vec(), betas);
        let input = frames.to_vec();
        let free = vec![true; frames.len()];
        let mut run = Self {
            fitter,
            around,
            task,
            config,
            input,
            rest,
            feet,
            plan,
            bins,
            sample,
            all,
            paper,
            open,
            free,
        };
        if run.paper.is_none() {
            run.free = run.near_faults(&figures, ticker)?;
        }
        for (i, free) in run.free.iter_mut().enumerate() {
            *free &= !task.is_pinned(i, frames.len());
        }
        Ok(run)
    }

    /// Frames near one with a fault. What came in without, walking over open floor mostly, is better than what a descent
    /// leaves of it.
    fn near_faults(&self, figures: &[FrameJoints], ticker: &Ticker) -> Result<Vec<bool>, Cancelled> {
        let depths = self.depths(&self.input, ticker)?;
        let strays = |i: usize| {
            (0..2).any(|side| {
                let place = self.plan.places[i][side];
                place.is_some_and(|p| p.ankle.distance(foot_of(&figures[i], side).ankle) > STRAYS_M)
            })
        };
        let faulty = |i: usize| depths[i] > TOUCHES_M || self.task.rest(i).is_some() || strays(i);
        let mut near = vec![false; self.input.len()];
        for i in (0..near.len()).filter(|i| faulty(*i)) {
            let last = (i + NEAR_FRAMES).min(near.len() - 1);
            near[i.saturating_sub(NEAR_FRAMES)..=last].fill(true);
        }
        Ok(near)
    }

    fn iterations(&self) -> usize {
        self.config.stages.iter().map(|stage| stage.iterations).sum()
    }

    fn descend(
        &self,
        windows: &[std::ops::Range<usize>],
        round: usize,
        frames: &mut [Frame],
        trace: &mut [Terms],
        ticker: &Ticker,
        preview: &mut dyn FnMut(&[Frame]),
    ) -> Result<(), Cancelled> {
        // The trace is of the first round, which every frame goes through.
        let mut unseen = vec![Terms::default(); trace.len()];
        let trace = if round == 0 { trace } else { &mut unseen };
        for window in windows {
            self.one_window(window.clone(), round, frames, trace, ticker)?;
            preview(frames);
        }
        Ok(())
    }

    fn lock(&self, frames: &mut [Frame]) -> f32 {
        let (rest, feet, plan, task) = (&self.rest, &self.feet, &self.plan, self.task);
        Lock { rest, feet, field: self.around.field, plan, task }.apply(frames)
    }

    /// Frames that may change and have a vertex deeper than [`DEEP_M`] in something, by every vertex there is.
    fn deep_frames(&self, frames: &[Frame], ticker: &Ticker) -> Result<Vec<usize>, Cancelled> {
        let depths = self.depths(frames, ticker)?;
        let pinned = (0..frames.len()).filter(|i| self.task.is_pinned(*i, frames.len()));
        let deepest = pinned.map(|i| depths[i] + AS_DEEP_M).fold(DEEP_M, f32::max);
        Ok((0..frames.len()).filter(|i| self.free[*i] && depths[*i] > deepest).collect())
    }

    /// The deepest vertex of each frame in something solid, metres.
    fn depths(&self, frames: &[Frame], ticker: &Ticker) -> Result<Vec<f32>, Cancelled> {
        let (body, field, betas) = (self.fitter.body, self.around.field, self.task.betas);
        let deepest = |workspace: &mut Workspace, frame: &Frame| {
            ticker.check()?;
            body.forward_posed(&frame.params(betas), &frame.pose, &self.all, workspace);
            let near_solids = workspace.vertices().iter().filter(|v| !self.open.is_open(field, **v));
            Ok(near_solids.map(|v| -field.sample(*v)).fold(0.0, f32::max))
        };
        frames.par_iter().map_init(Workspace::default, deepest).collect()
    }

    /// Optimises `frames` of one window. The first half of what it shares with the window before is held: it was done
    /// with its future in sight, and the rest joins on to it.
    fn one_window(
        &self,
        range: std::ops::Range<usize>,
        round: usize,
        frames: &mut [Frame],
        trace: &mut [Terms],
        ticker: &Ticker,
    ) -> Result<(), Cancelled> {
        let total = frames.len();
        let half = self.config.overlap / 2;
        // In a later round the window behind may not be gone through again: join on to it as well.
        let behind = if round > 0 && range.end < total { half } else { 0 };
        let context = if range.start > 0 { half } else { 0 };
        let inner = range.start + context..range.end - behind;
        let held: Vec<bool> = range.clone().map(|i| !inner.contains(&i) || !self.free[i]).collect();
        let mut first = 0;
        for stage in &self.config.stages {
            let mut window = Window {
                frames: &mut frames[range.clone()],
                input: &self.input[range.clone()],
                first: range.start,
                held: &held,
                joins: round == 0 && first == 0 && range.start > 0,
            };
            let trace = &mut trace[first..first + stage.iterations];
            self.one_stage(&mut window, &stage.of_round(round), trace, ticker)?;
            first += stage.iterations;
        }
        Ok(())
    }

    fn one_stage(
        &self,
        window: &mut Window<'_>,
        stage: &Stage,
        trace: &mut [Terms],
        ticker: &Ticker,
    ) -> Result<(), Cancelled> {
        let mut result = Ok(());
        self.with_energy(stage, &mut |subject, energy| {
            result = subject.descend(window, stage, energy, trace, ticker);
        });
        result
    }

    /// Calls `use_it` with what a stage minimises.
    pub fn with_energy(&self, stage: &Stage, use_it: &mut dyn FnMut(&Subject<'_>, &dyn MotionEnergy)) {
        let subject =
            |skin| Subject { body: self.fitter.body, betas: self.task.betas, skin, field: self.around.field };
        match (stage.objective, &self.paper) {
            (MotionObjective::Paper(weights), Some(scene)) => {
                use_it(&subject(&self.all), &PaperEnergy { scene, weights, open: &self.open });
            }
            (MotionObjective::Ours(weights), _) => {
                let energy = OurEnergy {
                    weights,
                    task: self.task,
                    field: self.around.field,
                    surface: &self.around.surface,
                    bins: &self.bins,
                    probe: &self.fitter.probe,
                    limits: &self.fitter.limits,
                    feet: &self.feet,
                    plan: &self.plan,
                };
                use_it(&subject(&self.sample), &energy);
            }
            (MotionObjective::Paper(_), None) => {}
        }
    }
}

/// Overlapping windows over `total` frames; the last may be short.
fn windows(total: usize, window: usize, overlap: usize) -> Vec<std::ops::Range<usize>> {
    let window = window.max(overlap + 1);
    let mut found = Vec::new();
    let mut start = 0;
    loop {
        let end = (start + window).min(total);
        found.push(start..end);
        if end == total {
            return found;
        }
        start = end - overlap;
    }
}
