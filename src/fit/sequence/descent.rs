//! Adam over all frames of a window at once. Poses every frame, asks an energy for each frame's gradient while all of
//! them can be read, and steps.

use glam::{Quat, Vec3};
use rayon::prelude::*;

use super::config::{MotionObjective, Stage};
use super::variables::{self, CODES, NUMBERS, per_number};
use crate::body::{Body, Gradients, SkinMatrices, VertexSubset, Workspace};
use crate::fit::energy::{Energy, TERMS};
use crate::fit::surroundings::Intrusions;
use crate::fit::terms::Distances;
use crate::job::{Cancelled, Ticker};
use crate::math::{Adam, AdamConfig, Smoother};
use crate::scene::{BETAS, Frame, SignedDistanceField};

/// The weighted value of each of [`TERMS`], summed over frames.
pub type Terms = [f32; TERMS.len()];

/// Share of the first step size that our last step has.
const LAST_STEP: f32 = 0.1;

/// One frame while it is optimised.
#[derive(Default)]
pub struct FrameState {
    /// The posed body.
    pub workspace: Workspace,
    /// The room's surfaces inside it.
    pub intrusions: Intrusions,
}

/// All frames of a window, as an energy reads them.
pub struct View<'a> {
    /// The posed bodies.
    pub states: &'a [FrameState],
    /// [`NUMBERS`] numbers a frame.
    pub x: &'a [f32],
    /// The same numbers of the motion as it came in.
    pub input: &'a [f32],
    /// Number of the window's first frame in the motion.
    pub first: usize,
}

impl View<'_> {
    /// A frame's numbers less those that it came in with.
    pub fn change(&self, i: usize, k: usize) -> f32 {
        self.x[i * NUMBERS + k] - self.input[i * NUMBERS + k]
    }
}

/// Scratch memory of one thread: what an energy writes for one frame.
pub struct Scratch {
    /// Values, and gradients by vertices, joints and axis-angles.
    pub energy: Energy,
    /// The field at the frame's vertices, where the energy asks for it.
    pub distances: Distances,
    /// Gradient by the skinning matrices.
    pub skin: SkinMatrices,
    /// Gradient by the frame's numbers directly.
    pub direct: [f32; NUMBERS],
}

/// An energy of a motion, frame by frame.
pub trait MotionEnergy: Sync {
    /// Adds window frame `i`'s terms and their gradients by that frame. A term between frames adds its value at one of
    /// them and to each its gradient.
    fn add(&self, view: &View<'_>, i: usize, out: &mut Scratch);

    /// The field at a frame's vertices; where an energy doesn't ask, any distance outside of solids will do.
    fn sense(&self, field: &SignedDistanceField, vertices: &[Vec3], distances: &mut Distances) {
        let Distances { value, gradient } = distances;
        for (v, position) in vertices.iter().enumerate() {
            (value[v], gradient[v]) = field.sample_gradient(*position);
        }
    }

    /// Whether the room's surfaces inside the body are wanted, and how to find them.
    fn search(&self, _state: &mut FrameState) {}
}

/// Frames of a window.
pub struct Window<'a> {
    /// The frames, moved in place.
    pub frames: &'a mut [Frame],
    /// The same as they came in.
    pub input: &'a [Frame],
    /// Number of the first in the motion.
    pub first: usize,
    /// Which must not move.
    pub held: &'a [bool],
    /// Whether it goes on from a window before, whose changes end in the middle of this one.
    pub joins: bool,
}

/// What is posed and where.
pub struct Subject<'a> {
    /// The body.
    pub body: &'a Body,
    /// Its shape.
    pub betas: &'a [f32; BETAS],
    /// The vertices that the energy asks for.
    pub skin: &'a VertexSubset,
    /// The room.
    pub field: &'a SignedDistanceField,
}

/// Iterations between searches for the room's surfaces inside the bodies.
const SEARCH_EVERY: usize = 8;

impl Subject<'_> {
    /// Runs one stage over one window; `trace` gets each iteration's terms added. Cancelled, the frames keep what was
    /// reached.
    pub fn descend(
        &self,
        window: &mut Window<'_>,
        stage: &Stage,
        energy: &dyn MotionEnergy,
        trace: &mut [Terms],
        ticker: &Ticker,
    ) -> Result<(), Cancelled> {
        let from: Vec<Quat> = window.input.iter().map(|frame| frame.rotation).collect();
        let numbers = |frames: &[Frame]| -> Vec<f32> {
            frames.iter().zip(&from).flat_map(|(frame, from)| variables::numbers_of(frame, *from)).collect()
        };
        let (mut x, input) = (numbers(window.frames), numbers(window.input));
        if window.joins {
            join_on(&mut x, &input, window.held);
        }
        let mut states: Vec<FrameState> = (0..from.len()).map(|_| FrameState::default()).collect();
        let mut steps = Steps::new(stage, window.held);
        let mut result = Ok(());
        for iteration in 0..stage.iterations {
            result = ticker.check();
            if result.is_err() {
                break;
            }
            self.pose(&mut states, &x, &from, (iteration > 0).then_some(window.held));
            if iteration % SEARCH_EVERY == 0 {
                states.par_iter_mut().for_each(|state| energy.search(state));
            }
            let view = View { states: &states, x: &x, input: &input, first: window.first };
            let mut gradient = self.gradient(&view, &from, window.held, energy, &mut trace[iteration]);
            steps.step(&mut x, &mut gradient, iteration);
        }
        for (i, frame) in window.frames.iter_mut().enumerate().filter(|(i, _)| !window.held[*i]) {
            *frame = variables::frame_of(&x[i * NUMBERS..(i + 1) * NUMBERS], from[i]);
        }
        result
    }

    /// Poses every frame, or those that are not `held`.
    fn pose(&self, states: &mut [FrameState], x: &[f32], from: &[Quat], held: Option<&[bool]>) {
        states.par_iter_mut().enumerate().for_each(|(i, state)| {
            if held.is_some_and(|held| held[i]) {
                return;
            }
            let frame = variables::frame_of(&x[i * NUMBERS..(i + 1) * NUMBERS], from[i]);
            let workspace = &mut state.workspace;
            self.body.forward_posed(&frame.params(self.betas), &frame.pose, self.skin, workspace);
        });
    }

    /// The gradient of every frame that may move, zero for the others; sums in the order of the frames.
    fn gradient(
        &self,
        view: &View<'_>,
        from: &[Quat],
        held: &[bool],
        energy: &dyn MotionEnergy,
        terms: &mut Terms,
    ) -> Vec<f32> {
        let mut gradient = vec![0.0; view.x.len()];
        let rows = gradient.par_chunks_exact_mut(NUMBERS).enumerate();
        let values: Vec<Terms> = rows
            .map_init(
                || Scratch::new(self.skin.len()),
                |scratch, (i, row)| {
                    if !held[i] {
                        self.of_frame(view, i, from[i], energy, scratch, row);
                        return scratch.energy.terms;
                    }
                    Terms::default()
                },
            )
            .collect();
        for of_frame in values {
            terms.iter_mut().zip(of_frame).for_each(|(sum, value)| *sum += value);
        }
        gradient
    }

    fn of_frame(
        &self,
        view: &View<'_>,
        i: usize,
        from: Quat,
        energy: &dyn MotionEnergy,
        scratch: &mut Scratch,
        row: &mut [f32],
    ) {
        scratch.clear();
        let workspace = &view.states[i].workspace;
        energy.sense(self.field, workspace.vertices(), &mut scratch.distances);
        energy.add(view, i, scratch);
        let Energy { vertices, joints, local, .. } = &scratch.energy;
        let gradients = Gradients { vertices, joints, local_pose: local };
        let posed = self.body.backward_posed(self.skin, &gradients, &scratch.skin, workspace);
        let flat = variables::flatten(&posed, &view.x[i * NUMBERS..(i + 1) * NUMBERS], from);
        for k in 0..NUMBERS {
            row[k] = flat[k] + scratch.direct[k];
        }
    }

    /// Value and gradient of an energy at the motion that came in, for tests against finite differences.
    #[cfg(test)]
    pub fn evaluate(&self, x: &[f32], input: &[Frame], energy: &dyn MotionEnergy) -> (f64, Vec<f32>) {
        let from: Vec<Quat> = input.iter().map(|frame| frame.rotation).collect();
        let original: Vec<f32> = input.iter().flat_map(|f| variables::numbers_of(f, f.rotation)).collect();
        let mut states: Vec<FrameState> = from.iter().map(|_| FrameState::default()).collect();
        self.pose(&mut states, x, &from, None);
        let view = View { states: &states, x, input: &original, first: 0 };
        let held = vec![false; from.len()];
        let mut terms = Terms::default();
        let gradient = self.gradient(&view, &from, &held, energy, &mut terms);
        (terms.iter().map(|t| f64::from(*t)).sum(), gradient)
    }
}

impl Scratch {
    fn new(vertices: usize) -> Self {
        Self {
            energy: Energy::new(vertices),
            distances: Distances { value: vec![0.0; vertices], gradient: vec![Vec3::ZERO; vertices] },
            skin: SkinMatrices::ZERO,
            direct: [0.0; NUMBERS],
        }
    }

    fn clear(&mut self) {
        self.energy.clear();
        self.skin = SkinMatrices::ZERO;
        self.direct = [0.0; NUMBERS];
    }
}

/// Changes of a window before fade out within this many frames beyond what is held.
const JOIN_FRAMES: usize = 40;
/// What the window before left beyond that is smoothed to waves of some twenty frames.
const JOIN_SMOOTHING: f32 = 150.0;

/// Makes the start of a window continuous: frames that the window before did not reach came in unchanged, a step that
/// smoothed gradients would never take away. The change goes on from the last held frame with its speed and fades out;
/// what the window before found beyond is kept smoothly.
fn join_on(x: &mut [f32], input: &[f32], held: &[bool]) {
    let first = held.iter().take_while(|held| **held).count();
    let free = held[first..].iter().take_while(|held| !**held).count();
    if first < 2 || free == 0 {
        return;
    }
    let change = |x: &[f32], i: usize, k: usize| x[i * NUMBERS + k] - input[i * NUMBERS + k];
    let mut carried = vec![0.0; x.len()];
    let mut rest = vec![0.0; x.len()];
    for i in first..first + free {
        let after = (i + 1 - first) as f32;
        let way = (after / JOIN_FRAMES.min(free) as f32).min(1.0);
        let fade = 1.0 - way * way * (3.0 - 2.0 * way);
        for k in 0..NUMBERS {
            let at = change(x, first - 1, k);
            let speed = at - change(x, first - 2, k);
            carried[i * NUMBERS + k] = (at + speed * after) * fade;
            rest[i * NUMBERS + k] = change(x, i, k) - carried[i * NUMBERS + k];
        }
    }
    Smoother::new(JOIN_SMOOTHING, held).smooth(&mut rest, NUMBERS);
    for i in (first * NUMBERS)..((first + free) * NUMBERS) {
        x[i] = input[i] + carried[i] + rest[i];
    }
}

/// The update rule of a stage.
enum Steps {
    /// The published one: Adam on every number by itself.
    Plain { adam: Adam, scale: Vec<f32> },
    /// Ours.
    Shared(SharedAdam),
}

impl Steps {
    fn new(stage: &Stage, held: &[bool]) -> Self {
        match stage.objective {
            MotionObjective::Paper(_) => Self::Plain {
                adam: Adam::new(held.len() * NUMBERS, stage.adam),
                scale: held.iter().flat_map(|held| [if *held { 0.0 } else { 1.0 }; NUMBERS]).collect(),
            },
            MotionObjective::Ours(_) => Self::Shared(SharedAdam::new(stage, held)),
        }
    }

    fn step(&mut self, x: &mut [f32], gradient: &mut [f32], iteration: usize) {
        match self {
            Self::Plain { adam, scale } => adam.step(x, gradient, scale),
            Self::Shared(adam) => adam.step(x, gradient, iteration),
        }
    }
}

/// Step size of each number relative to the learning rate: the whole body goes and turns slowly, fingers hardly move.
const SCALES: [f32; NUMBERS] = per_number(0.3, 0.3, 1.0, 0.3);
/// A wave of some ten frames is halved in the gradient.
const SMOOTHING: f32 = 6.0;
/// No number moves by more than this many learning rates in a step.
const STEP_LIMIT: f32 = 3.0;

/// Adam that keeps a motion smooth: the gradient is smoothed over time, so that corrections come and go gently and
/// vanish with zero slope at held frames (the covariant step of CHOMP, Ratliff et al. 2009), and the second moment is
/// shared by all frames and by the numbers of a joint, so that frames without trouble stay as they are.
struct SharedAdam {
    config: AdamConfig,
    smoother: Smoother,
    free: Vec<bool>,
    first: Vec<f32>,
    second: Vec<f64>,
    iterations: usize,
}

impl SharedAdam {
    fn new(stage: &Stage, held: &[bool]) -> Self {
        Self {
            config: stage.adam,
            smoother: Smoother::new(SMOOTHING, held),
            free: held.iter().map(|held| !held).collect(),
            first: vec![0.0; held.len() * NUMBERS],
            second: vec![0.0; group_of(NUMBERS - 1) + 1],
            iterations: stage.iterations,
        }
    }

    fn step(&mut self, x: &mut [f32], gradient: &mut [f32], iteration: usize) {
        self.smoother.smooth(gradient, NUMBERS);
        let AdamConfig { learning_rate, beta1, beta2, epsilon } = self.config;
        let squares = self.mean_squares(gradient);
        for (second, square) in self.second.iter_mut().zip(squares) {
            *second = f64::from(beta2) * *second + f64::from(1.0 - beta2) * square;
        }
        let steps = iteration as i32 + 1;
        let (first_share, second_share) = (1.0 - beta1.powi(steps), 1.0 - beta2.powi(steps));
        let roots: Vec<f32> =
            self.second.iter().map(|s| (*s as f32 / second_share).sqrt() + epsilon).collect();
        let rate = learning_rate * falling(iteration, self.iterations);
        for (i, (value, slope)) in x.iter_mut().zip(gradient).enumerate() {
            let (frame, k) = (i / NUMBERS, i % NUMBERS);
            if self.free[frame] {
                let first = &mut self.first[i];
                *first = beta1 * *first + (1.0 - beta1) * *slope;
                let step = (*first / first_share / roots[group_of(k)]).clamp(-STEP_LIMIT, STEP_LIMIT);
                *value -= rate * SCALES[k] * step;
            }
        }
    }

    /// Mean squared gradient of each group of numbers over the frames that may move.
    fn mean_squares(&self, gradient: &[f32]) -> Vec<f64> {
        let mut sums = vec![(0.0_f64, 0_usize); self.second.len()];
        for (i, g) in gradient.iter().enumerate().filter(|(i, _)| self.free[*i / NUMBERS]) {
            let (sum, count) = &mut sums[group_of(i % NUMBERS)];
            *sum += f64::from(*g) * f64::from(*g);
            *count += 1;
        }
        sums.into_iter().map(|(sum, count)| sum / count.max(1) as f64).collect()
    }
}

/// The numbers that share a second moment: three of a joint, twelve of a hand.
fn group_of(k: usize) -> usize {
    if k < CODES { k / 3 } else { CODES / 3 + (k - CODES) / 12 }
}

/// Share of the learning rate at an iteration: a falling half cosine.
fn falling(iteration: usize, iterations: usize) -> f32 {
    let done = iteration as f32 / iterations.max(1) as f32;
    LAST_STEP + (1.0 - LAST_STEP) * 0.5 * (1.0 + (std::f32::consts::PI * done).cos())
}
