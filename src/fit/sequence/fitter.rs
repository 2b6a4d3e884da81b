use glam::Vec3;
use rayon::prelude::*;

use super::config::{MotionObjective, SequenceConfig, Stage};
use super::descent::{MotionEnergy, Subject, Terms, Window};
use super::lock::Lock;
use super::ours::OurEnergy;
use super::paper::{PaperEnergy, PaperScene};
use super::stance::FootPlan;
use crate::body::joints::{BODY_JOINTS, JOINTS};
use crate::body::{Body, Feet, FrameJoints, JointLimit, VertexSubset, joint_limits};
use crate::fit::probe::Probe;
use crate::fit::surroundings::Surroundings;
use crate::job::{Cancelled, Ticker};
use crate::math::Aabb;
use crate::scene::{BETAS, Frame, PoseFamily, RoomGeometry};

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
/// A body reaches this far from its pelvis, metres, and moves a little.
const REACH_M: f32 = 1.3;

impl<'a> SequenceFitter<'a> {
    /// A fitter of `body`.
    pub fn new(body: &'a Body) -> Self {
        Self { body, probe: Probe::sparse(body, SKIN_SAMPLE_M, REGION_SAMPLE), limits: joint_limits() }
    }

    /// The room around a motion: all that [`SequenceFitter::optimise`] needs of it.
    pub fn surroundings<'g>(&self, geometry: &'g RoomGeometry, frames: &[Frame]) -> Surroundings<'g> {
        let pelvis = self.body.model.joint_template[0];
        let way = Aabb::of(frames.iter().map(|frame| frame.translation + pelvis).filter(|p| p.is_finite()));
        Surroundings::new(geometry, way.grown(REACH_M))
    }

    /// Optimises `frames` in place. `preview` gets all frames whenever some seconds of motion more are done.
    ///
    /// Our energy asks a sample of some 1,300 vertices; what remains is found by [`crate::inspect::inspect_motion`] with
    /// all of them.
    ///
    /// # Errors
    /// [`Cancelled`] once the user cancelled; it is asked at every iteration. The frames keep the best so far, their
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
        let run = Run::new(self, around, task, frames, config);
        let mut done = Sequenced { trace: vec![Terms::default(); run.iterations()], short_m: 0.0 };
        let descended = run.all_windows(frames, &mut done.trace, ticker, preview);
        if config.lock_feet {
            let lock = Lock { rest: &run.rest, feet: &run.feet, field: around.field, plan: &run.plan, task };
            done.short_m = lock.apply(frames);
        }
        descended.map(|()| done)
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
    sample: VertexSubset,
    paper: Option<(VertexSubset, PaperScene)>,
}

impl<'r> Run<'r> {
    pub fn new(
        fitter: &'r SequenceFitter<'r>,
        around: &'r Surroundings<'r>,
        task: &'r SequenceTask<'r>,
        frames: &[Frame],
        config: &'r SequenceConfig,
    ) -> Self {
        let (body, betas) = (fitter.body, task.betas);
        let rest = body.model.rest_joints(betas);
        let feet = Feet::of(body, betas);
        let figures: Vec<FrameJoints> = frames.par_iter().map(|f| FrameJoints::of(&rest, f)).collect();
        let plan = FootPlan::of(&feet, around.field, task, &figures);
        let is_paper = |stage: &Stage| matches!(stage.objective, MotionObjective::Paper(_));
        let paper = config.stages.iter().any(is_paper).then(|| {
            let all = (0..body.model.template.len() as u32).collect();
            let skin = VertexSubset::of_shape(&body.model, all, betas);
            let scene = PaperScene::of(&Subject { body, betas, skin: &skin, field: around.field }, frames);
            (skin, scene)
        });
        let sample = VertexSubset::of_shape(&body.model, fitter.probe.subset.ids().to_vec(), betas);
        Self { fitter, around, task, config, input: frames.to_vec(), rest, feet, plan, sample, paper }
    }

    fn iterations(&self) -> usize {
        self.config.stages.iter().map(|stage| stage.iterations).sum()
    }

    fn all_windows(
        &self,
        frames: &mut [Frame],
        trace: &mut [Terms],
        ticker: &Ticker,
        preview: &mut dyn FnMut(&[Frame]),
    ) -> Result<(), Cancelled> {
        for window in windows(frames.len(), self.config.window, self.config.overlap) {
            self.one_window(window, frames, trace, ticker)?;
            preview(frames);
        }
        Ok(())
    }

    /// Optimises `frames` of one window. The first half of what it shares with the window before is held: it was done
    /// with its future in sight, and the rest joins on to it.
    fn one_window(
        &self,
        range: std::ops::Range<usize>,
        frames: &mut [Frame],
        trace: &mut [Terms],
        ticker: &Ticker,
    ) -> Result<(), Cancelled> {
        let total = frames.len();
        let context = if range.start > 0 { self.config.overlap / 2 } else { 0 };
        let held: Vec<bool> =
            range.clone().map(|i| i < range.start + context || self.task.is_pinned(i, total)).collect();
        let mut first = 0;
        for stage in &self.config.stages {
            let mut window = Window {
                frames: &mut frames[range.clone()],
                input: &self.input[range.clone()],
                first: range.start,
                held: &held,
            };
            let trace = &mut trace[first..first + stage.iterations];
            self.one_stage(&mut window, stage, trace, ticker)?;
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
            (MotionObjective::Paper(weights), Some((skin, scene))) => {
                use_it(&subject(skin), &PaperEnergy { scene, weights });
            }
            (MotionObjective::Ours(weights), _) => {
                let energy = OurEnergy {
                    weights,
                    task: self.task,
                    around: self.around,
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
