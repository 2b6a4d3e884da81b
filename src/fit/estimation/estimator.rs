use glam::Vec3;

use super::energy::{self, ESTIMATE_TERMS, Skin, Sum};
use super::initial::initial;
use super::landmarks::{Landmark, Landmarks};
use super::pinhole::Pinhole;
use crate::assets::PersonKeypoints;
use crate::body::joints as j;
use crate::body::joints::BODY_JOINTS;
use crate::body::{Body, Gradients, JointLimit, Region, VertexSubset, Workspace, joint_limits};
use crate::fit::probe::Probe;
use crate::job::{Cancelled, Ticker};
use crate::math::{LbfgsConfig, minimise};
use crate::scene::{BodyParams, PARAMS, POSE, SignedDistanceField};

/// Least keypoints that an estimate needs: fewer leave a body's turn open.
const LEAST_POINTS: usize = 4;
/// Turns about the vertical that are tried as starts: eight, 45 degrees apart.
const YAWS: usize = 8;
/// Starts that go on to the whole body.
const KEPT_STARTS: usize = 3;
/// Steps that place the torso.
const TORSO_STEPS: usize = 20;
/// Joints that place the body before it bends (SMPLify-X §3.3: shoulders and hips).
const TORSO: [usize; 6] =
    [j::LEFT_SHOULDER, j::RIGHT_SHOULDER, j::LEFT_HIP, j::RIGHT_HIP, j::NECK, j::PELVIS];
/// Weight of squared excess over joint limits, per squared radian: ten degrees cost as much as a keypoint that is
/// ten pixels of a thousand off three times over.
const LIMITS: f32 = 10_000.0;

/// Weights of PROX's terms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneWeights {
    /// Mean robust distance of contact vertices that face a surface.
    pub contact: f32,
    /// Sum of depths over all vertices, per metre.
    pub collision: f32,
}

/// One stage of the optimisation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stage {
    /// Most steps of L-BFGS.
    pub iterations: usize,
    /// Weight of the pose prior.
    pub pose: f32,
    /// Weight of the shape prior.
    pub shape: f32,
    /// Whether the scene's terms count, if the configuration has any.
    pub scene: bool,
}

/// An estimator: what is minimised, and in which order.
#[derive(Clone, Debug, PartialEq)]
pub struct EstimateConfig {
    /// Centre of the pose prior and start of the pose: zero as published by SMPLify-X and PROX, the scene's mean
    /// code `θ_s` for PSI §4.2.
    pub prior_center: [f32; POSE],
    /// PROX's terms; `None` for SMPLify-X.
    pub scene: Option<SceneWeights>,
    /// From stiff to soft.
    pub stages: Vec<Stage>,
}

impl EstimateConfig {
    /// SMPLify-X: keypoints and priors alone. Weights of its code: prior 404², 57.4², 4.78², shape 100², 10², 5².
    pub fn smplify_x() -> Self {
        let stage = |pose: f32, shape: f32, scene| Stage {
            iterations: 40,
            pose: pose * pose,
            shape: shape * shape,
            scene,
        };
        let stages = vec![
            stage(404.0, 100.0, false),
            stage(57.4, 10.0, false),
            stage(4.78, 5.0, false),
            stage(4.78, 5.0, true),
        ];
        Self { prior_center: [0.0; POSE], scene: None, stages }
    }

    /// PROX: SMPLify-X with contact and penetration in the last stage.
    pub fn prox() -> Self {
        let scene = Some(SceneWeights { contact: 1e4, collision: 1e3 });
        Self { scene, ..Self::smplify_x() }
    }

    /// PSI §4.2: PROX with the prior centred at, and started from, what people do in this scene.
    pub fn scene_aware(scene_mean_code: [f32; POSE]) -> Self {
        Self { prior_center: scene_mean_code, ..Self::prox() }
    }
}

/// Why a person can't be estimated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EstimateError {
    /// Too little is seen.
    #[error(
        "this person has {found} keypoints with any confidence, {LEAST_POINTS} are needed: choose another person of \
         the picture, or detect keypoints with a lower threshold"
    )]
    TooFewPoints {
        /// Keypoints with a confidence above zero.
        found: usize,
    },
}

/// The weighted value of each of [`ESTIMATE_TERMS`] at every accepted step of the start that was taken.
pub type EstimateTrace = Vec<[f32; ESTIMATE_TERMS.len()]>;

/// An estimated body.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// The body, world frame.
    pub params: BodyParams,
    /// The energies on the way.
    pub trace: EstimateTrace,
    /// Root mean square distance of its landmarks to the keypoints, weighted by confidence, in pixels.
    pub reprojection_px: f32,
}

/// Estimates bodies of one model. Shared by threads, keeps nothing between people.
pub struct Estimator<'a> {
    body: &'a Body,
    landmarks: Landmarks,
    probe: Probe,
    /// Landmarks' skin, then the probe's.
    with_skin: VertexSubset,
    /// Entries of the probe in PROX's contact segments.
    contact: Vec<u32>,
    limits: [JointLimit; BODY_JOINTS],
}

/// What one person is estimated from.
struct Problem<'p> {
    view: &'p Pinhole,
    seen: &'p PersonKeypoints,
    field: &'p SignedDistanceField,
    config: &'p EstimateConfig,
}

/// Scratch memory of one estimate.
struct Scratch {
    workspace: Workspace,
    sum: Sum,
    distances: Vec<f32>,
    gradients: Vec<Vec3>,
}

/// A start on its way.
struct Candidate {
    x: [f32; PARAMS],
    value: f32,
    trace: EstimateTrace,
}

impl<'a> Estimator<'a> {
    /// An estimator of `body`.
    pub fn new(body: &'a Body) -> Self {
        let landmarks = Landmarks::of(&body.model);
        let probe = Probe::new(body);
        let ids = landmarks.subset.ids().iter().chain(probe.subset.ids()).copied().collect();
        let mut contact: Vec<u32> = Region::PROX.iter().flat_map(|r| probe.regions[r].clone()).collect();
        contact.sort_unstable();
        contact.dedup();
        let with_skin = VertexSubset::new(&body.model, ids);
        Self { body, landmarks, probe, with_skin, contact, limits: joint_limits() }
    }

    /// The body whose landmarks are where `view` sees `seen`, in a room of distances `field`. `preview` gets the
    /// body at every step of the last stage.
    ///
    /// # Errors
    /// [`EstimateError`]; and inside, [`Cancelled`] once the user cancelled.
    pub fn estimate(
        &self,
        view: &Pinhole,
        seen: &PersonKeypoints,
        field: &SignedDistanceField,
        config: &EstimateConfig,
        ticker: &Ticker,
        preview: &mut dyn FnMut(&BodyParams),
    ) -> Result<Result<Estimate, Cancelled>, EstimateError> {
        let found = seen.points.iter().filter(|p| p.confidence > 0.0).count();
        if found < LEAST_POINTS {
            return Err(EstimateError::TooFewPoints { found });
        }
        let problem = Problem { view, seen, field, config };
        Ok(self.descend(&problem, ticker, preview))
    }

    fn descend(
        &self,
        problem: &Problem<'_>,
        ticker: &Ticker,
        preview: &mut dyn FnMut(&BodyParams),
    ) -> Result<Estimate, Cancelled> {
        let mut scratch = self.scratch();
        let mut candidates = self.torso_starts(problem, &mut scratch, ticker)?;
        let (soft, last) = problem.config.stages.split_at(problem.config.stages.len().saturating_sub(1));
        for stage in soft {
            for candidate in &mut candidates {
                self.run(problem, stage, candidate, &mut scratch, ticker, &mut |_| ())?;
            }
        }
        let best = candidates.into_iter().min_by(|a, b| a.value.total_cmp(&b.value));
        let mut best = best.unwrap_or_else(|| unreachable!("there are starts"));
        for stage in last {
            self.run(problem, stage, &mut best, &mut scratch, ticker, preview)?;
        }
        let mut params = BodyParams::from_vector(&best.x);
        let rotation = params.rotation();
        params.set_rotation(&rotation);
        let reprojection_px = self.reprojection_px(problem, &params, &mut scratch);
        Ok(Estimate { params, trace: best.trace, reprojection_px })
    }

    /// Turns and places the start's pose by the torso alone, from all sides; the best few.
    fn torso_starts(
        &self,
        problem: &Problem<'_>,
        scratch: &mut Scratch,
        ticker: &Ticker,
    ) -> Result<Vec<Candidate>, Cancelled> {
        let pose = &problem.config.prior_center;
        let steps = LbfgsConfig { iterations: TORSO_STEPS, ..LbfgsConfig::default() };
        let mut starts = Vec::with_capacity(YAWS);
        for turn in 0..YAWS {
            let yaw = std::f32::consts::TAU * turn as f32 / YAWS as f32;
            let mut x = initial(self.body, problem.view, problem.seen, pose, yaw).to_vector();
            let mut torso = |x: &[f32], gradient: &mut [f32]| {
                let on_torso = |l: Landmark| match l {
                    Landmark::Joint(joint) if TORSO.contains(&joint) => 1.0,
                    // A little of the rest tells front from back.
                    _ => 0.2,
                };
                let value = self.keypoints_alone(problem, x, &on_torso, scratch, gradient);
                gradient[BodyParams::OFFSETS[2]..].fill(0.0);
                value
            };
            let value = minimise(&mut x, &steps, &mut torso, &mut |_, _| ticker.check())?;
            starts.push(Candidate { x, value, trace: EstimateTrace::new() });
        }
        starts.sort_by(|a, b| a.value.total_cmp(&b.value));
        starts.truncate(KEPT_STARTS);
        Ok(starts)
    }

    fn run(
        &self,
        problem: &Problem<'_>,
        stage: &Stage,
        candidate: &mut Candidate,
        scratch: &mut Scratch,
        ticker: &Ticker,
        preview: &mut dyn FnMut(&BodyParams),
    ) -> Result<(), Cancelled> {
        let config = LbfgsConfig { iterations: stage.iterations, ..LbfgsConfig::default() };
        let mut x = candidate.x;
        let terms = std::cell::Cell::new([0.0; ESTIMATE_TERMS.len()]);
        let mut energy = |x: &[f32], gradient: &mut [f32]| {
            self.energy(problem, stage, x, scratch, gradient);
            terms.set(scratch.sum.terms);
            scratch.sum.terms.iter().sum()
        };
        let trace = &mut candidate.trace;
        let mut each = |x: &[f32], _: f32| {
            trace.push(terms.get());
            preview(&BodyParams::from_vector(&vector(x)));
            ticker.check()
        };
        candidate.value = minimise(&mut x, &config, &mut energy, &mut each)?;
        candidate.x = BodyParams::from_vector(&x).to_vector();
        Ok(())
    }

    /// All terms of a stage at `x`, left in the scratch memory, and their gradient.
    fn energy(
        &self,
        problem: &Problem<'_>,
        stage: &Stage,
        x: &[f32],
        scratch: &mut Scratch,
        gradient: &mut [f32],
    ) {
        let x = vector(x);
        let scene = problem.config.scene.filter(|_| stage.scene);
        let subset = if scene.is_some() { &self.with_skin } else { &self.landmarks.subset };
        scratch.sum = Sum::new(subset.len());
        self.body.forward(&BodyParams::from_vector(&x), subset, &mut scratch.workspace);
        let Scratch { workspace, sum, distances, gradients } = scratch;
        energy::keypoints(sum, problem.seen, problem.view, workspace, &|_| 1.0);
        energy::pose_prior(sum, &x, &problem.config.prior_center, stage.pose);
        energy::shape_prior(sum, &x, stage.shape);
        energy::joint_limits(sum, workspace.local_pose(), &self.limits, LIMITS);
        if let Some(weights) = scene {
            let first = self.landmarks.subset.len();
            distances.clear();
            gradients.clear();
            for vertex in &workspace.vertices()[first..] {
                let (d, away) = problem.field.sample_gradient(*vertex);
                distances.push(d);
                gradients.push(away);
            }
            let skin = Skin { first, distances, gradients };
            let rotations = workspace.world_rotations();
            let normal = |v: u32| {
                let (joint, at_rest) = self.probe.rest_normals[v as usize];
                rotations[joint] * at_rest
            };
            energy::contact(sum, &skin, &self.contact, &normal, weights.contact);
            energy::collision(sum, &skin, weights.collision);
        }
        self.pull_back(subset, sum, workspace, gradient);
    }

    /// The keypoints' term alone with weights a landmark.
    fn keypoints_alone(
        &self,
        problem: &Problem<'_>,
        x: &[f32],
        weight_of: &dyn Fn(Landmark) -> f32,
        scratch: &mut Scratch,
        gradient: &mut [f32],
    ) -> f32 {
        let subset = &self.landmarks.subset;
        scratch.sum = Sum::new(subset.len());
        self.body.forward(&BodyParams::from_vector(&vector(x)), subset, &mut scratch.workspace);
        energy::keypoints(&mut scratch.sum, problem.seen, problem.view, &scratch.workspace, weight_of);
        self.pull_back(subset, &scratch.sum, &mut scratch.workspace, gradient);
        scratch.sum.terms.iter().sum()
    }

    fn pull_back(&self, subset: &VertexSubset, sum: &Sum, workspace: &mut Workspace, gradient: &mut [f32]) {
        let parts = Gradients { vertices: &sum.vertices, joints: &sum.joints, local_pose: &sum.local };
        let through_body = self.body.backward(subset, &parts, workspace);
        for (i, g) in gradient.iter_mut().enumerate() {
            *g = through_body[i] + sum.params[i];
        }
    }

    fn reprojection_px(&self, problem: &Problem<'_>, params: &BodyParams, scratch: &mut Scratch) -> f32 {
        self.body.forward(params, &self.landmarks.subset, &mut scratch.workspace);
        let positions = Landmarks::positions(problem.seen.set, &scratch.workspace);
        let (mut squared, mut weights) = (0.0, 0.0);
        for (position, point) in positions.iter().zip(&problem.seen.points) {
            squared += point.confidence * problem.view.project(*position).distance_squared(point.pixel);
            weights += point.confidence;
        }
        (squared / weights.max(f32::MIN_POSITIVE)).sqrt()
    }

    fn scratch(&self) -> Scratch {
        Scratch {
            workspace: Workspace::default(),
            sum: Sum::new(0),
            distances: Vec::new(),
            gradients: Vec::new(),
        }
    }
}

#[cfg(test)]
impl Estimator<'_> {
    /// Value and gradient of a configuration's last stage, for tests.
    pub(super) fn evaluate(
        &self,
        view: &Pinhole,
        seen: &PersonKeypoints,
        field: &SignedDistanceField,
        config: &EstimateConfig,
        x: &[f32; PARAMS],
    ) -> (f32, [f32; PARAMS]) {
        let (mut scratch, mut gradient) = (self.scratch(), [0.0; PARAMS]);
        let problem = Problem { view, seen, field, config };
        let stage = config.stages[config.stages.len() - 1];
        self.energy(&problem, &stage, x, &mut scratch, &mut gradient);
        (scratch.sum.terms.iter().sum(), gradient)
    }
}

/// The flat vector of a slice as long; zeros where it is shorter.
fn vector(x: &[f32]) -> [f32; PARAMS] {
    std::array::from_fn(|i| x.get(i).copied().unwrap_or(0.0))
}
