use glam::Vec3;

use super::config::{FitConfig, Objective, PsiWeights, Weights};
use super::energy::{Energy, TERMS};
use super::goals::contact_goals;
use super::probe::Probe;
use super::set_down::set_down;
use super::surroundings::{Intrusions, Surroundings};
use super::terms::{self, Distances};
use crate::body::joints::BODY_JOINTS;
use crate::body::{Body, Gradients, JointLimit, VertexSubset, Workspace, joint_limits};
use crate::job::{Cancelled, Ticker};
use crate::math::Adam;
use crate::scene::{BodyParams, PARAMS, PoseFamily};

/// Iterations between searches for the room's surfaces inside the body: a body moves millimetres in these.
const INTRUSIONS_EVERY: usize = 8;
/// Share of the first step size that the last step has.
const LAST_STEP: f32 = 0.1;

/// The weighted value of each of [`TERMS`] at every iteration.
pub type Trace = Vec<[f32; TERMS.len()]>;

/// The result of a fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Fitted {
    /// The fitted body.
    pub params: BodyParams,
    /// The energies on the way.
    pub trace: Trace,
}

/// Fits bodies of one model; holds what can be found once. Shared by threads, keeps nothing between bodies.
pub struct Fitter<'a> {
    body: &'a Body,
    probe: Probe,
    psi_contact: Vec<u32>,
    limits: [JointLimit; BODY_JOINTS],
}

/// Scratch memory of one fit.
struct Scratch {
    workspace: Workspace,
    energy: Energy,
    distances: Distances,
    intrusions: Intrusions,
    search_intrusions: bool,
}

impl<'a> Fitter<'a> {
    /// A fitter of `body`.
    pub fn new(body: &'a Body) -> Self {
        Self {
            body,
            probe: Probe::new(body),
            psi_contact: body.regions.prox_sample(),
            limits: joint_limits(),
        }
    }

    /// Descends from `start`. `preview` gets the body every [`FitConfig::preview_every`] iterations.
    ///
    /// # Errors
    /// [`Cancelled`] once the user cancelled; it is asked at every iteration.
    pub fn fit(
        &self,
        around: &Surroundings<'_>,
        start: &BodyParams,
        family: PoseFamily,
        config: &FitConfig,
        ticker: &Ticker,
        preview: &mut dyn FnMut(&BodyParams),
    ) -> Result<Fitted, Cancelled> {
        let origin = start.to_vector();
        let mut x = origin;
        let mut adam = Adam::new(PARAMS, config.adam);
        let scale = step_scales(&config.objective);
        let mut scratch = self.scratch(&config.objective);
        let mut trace = Trace::with_capacity(config.iterations);
        for iteration in 0..config.iterations {
            ticker.check()?;
            scratch.search_intrusions = iteration % INTRUSIONS_EVERY == 0;
            let gradient = self.energy_at(&x, &origin, family, &config.objective, around, &mut scratch);
            trace.push(scratch.energy.terms);
            adam.set_learning_rate(
                config.adam.learning_rate * schedule(&config.objective, iteration, config),
            );
            adam.step(&mut x, &gradient, &scale);
            if config.preview_every > 0 && iteration % config.preview_every == 0 {
                preview(&BodyParams::from_vector(&x));
            }
        }
        let mut params = canonical(&x);
        if matches!(config.objective, Objective::Rescue(_)) {
            set_down(self.body, around.field, &mut params, &mut scratch.workspace);
        }
        Ok(Fitted { params, trace })
    }

    /// Energy terms and gradient of one body: what one iteration costs, for benchmarks and plots.
    pub fn evaluate(
        &self,
        around: &Surroundings<'_>,
        params: &BodyParams,
        start: &BodyParams,
        family: PoseFamily,
        objective: &Objective,
    ) -> ([f32; TERMS.len()], [f32; PARAMS]) {
        let mut scratch = self.scratch(objective);
        let (x, origin) = (params.to_vector(), start.to_vector());
        let gradient = self.energy_at(&x, &origin, family, objective, around, &mut scratch);
        (scratch.energy.terms, gradient)
    }

    fn subset(&self, objective: &Objective) -> &VertexSubset {
        match objective {
            Objective::Psi(_) => self.body.all_vertices(),
            Objective::Rescue(_) => &self.probe.subset,
        }
    }

    fn scratch(&self, objective: &Objective) -> Scratch {
        let vertices = self.subset(objective).len();
        Scratch {
            workspace: Workspace::default(),
            energy: Energy::new(vertices),
            distances: Distances { value: vec![0.0; vertices], gradient: vec![Vec3::ZERO; vertices] },
            intrusions: Intrusions::default(),
            search_intrusions: true,
        }
    }

    fn energy_at(
        &self,
        x: &[f32; PARAMS],
        start: &[f32; PARAMS],
        family: PoseFamily,
        objective: &Objective,
        around: &Surroundings<'_>,
        scratch: &mut Scratch,
    ) -> [f32; PARAMS] {
        let subset = self.subset(objective);
        scratch.energy.clear();
        self.body.forward(&BodyParams::from_vector(x), subset, &mut scratch.workspace);
        for (v, position) in scratch.workspace.vertices().iter().enumerate() {
            (scratch.distances.value[v], scratch.distances.gradient[v]) =
                around.field.sample_gradient(*position);
        }
        match objective {
            Objective::Psi(weights) => self.psi(weights, x, start, scratch),
            Objective::Rescue(weights) => self.rescue(weights, x, start, family, around, scratch),
        }
        let energy = &scratch.energy;
        let gradients =
            Gradients { vertices: &energy.vertices, joints: &energy.joints, local_pose: &energy.local };
        let mut gradient = self.body.backward(subset, &gradients, &mut scratch.workspace);
        gradient.iter_mut().zip(&energy.params).for_each(|(g, direct)| *g += direct);
        gradient
    }

    fn psi(&self, weights: &PsiWeights, x: &[f32; PARAMS], start: &[f32; PARAMS], scratch: &mut Scratch) {
        let Scratch { energy, distances, .. } = scratch;
        terms::psi_start(energy, x, start, weights.start);
        terms::psi_pose_prior(energy, x, weights.pose_prior);
        terms::psi_contact(energy, &self.psi_contact, distances, weights.robust_c_m, weights.contact);
        terms::psi_collision(energy, distances, weights.collision);
    }

    fn rescue(
        &self,
        weights: &Weights,
        x: &[f32; PARAMS],
        start: &[f32; PARAMS],
        family: PoseFamily,
        around: &Surroundings<'_>,
        scratch: &mut Scratch,
    ) {
        let Scratch { energy, distances, workspace, intrusions, search_intrusions } = scratch;
        let [t, _, betas, pose, hands] = BodyParams::OFFSETS;
        terms::stay(energy, x, start, t..betas, weights.place);
        for across in [t, t + 2] {
            terms::stay(energy, x, start, across..across + 1, weights.over);
        }
        terms::stay(energy, x, start, pose..PARAMS, weights.pose);
        terms::stay(energy, x, &[0.0; PARAMS], pose..hands, weights.pose_prior);
        for goal in contact_goals(family) {
            let region = &self.probe.regions[&goal.region];
            terms::gap(energy, region, distances, goal, weights.gap);
            terms::spread(energy, region, distances, weights.spread * goal.weight);
        }
        terms::collision(energy, distances, weights.collision);
        if *search_intrusions {
            intrusions.update(
                &around.surface,
                &self.probe,
                workspace.vertices(),
                workspace.world_rotations(),
            );
        }
        intrusions.add_energy(energy, workspace.vertices(), weights.intrusion);
        let joints = workspace.joints();
        terms::bones(energy, &self.probe, joints, &|p| around.field.sample_gradient(p), weights.bones);
        terms::self_collision(energy, &self.probe, joints, weights.self_collision);
        terms::joint_limits(energy, workspace.local_pose(), &self.limits, weights.joint_limits);
        if matches!(family, PoseFamily::Stand) {
            terms::balance(energy, joints, weights.balance);
        }
    }
}

/// Step size of each number relative to the learning rate. The published code moves all alike; ours keeps
/// the shape (it is the person), turns the root slowly and the fingers hardly.
fn step_scales(objective: &Objective) -> [f32; PARAMS] {
    let mut scale = [1.0; PARAMS];
    if let Objective::Rescue(_) = objective {
        let [t, r, betas, pose, hands] = BodyParams::OFFSETS;
        scale[t..r].fill(0.3);
        scale[r..betas].fill(0.3);
        scale[betas..pose].fill(0.0);
        scale[hands..].fill(0.3);
    }
    scale
}

/// Share of the learning rate at an iteration: constant as published, a falling half cosine for ours.
fn schedule(objective: &Objective, iteration: usize, config: &FitConfig) -> f32 {
    match objective {
        Objective::Psi(_) => 1.0,
        Objective::Rescue(_) => {
            let done = iteration as f32 / config.iterations.max(1) as f32;
            LAST_STEP + (1.0 - LAST_STEP) * 0.5 * (1.0 + (std::f32::consts::PI * done).cos())
        }
    }
}

/// The body with its rotation re-orthonormalised, as every reader expects.
fn canonical(x: &[f32; PARAMS]) -> BodyParams {
    let mut params = BodyParams::from_vector(x);
    let rotation = params.rotation();
    params.set_rotation(&rotation);
    params
}
