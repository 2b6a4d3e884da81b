//! LTM §3.4, eq. 5 to 7 and the stable foot, scaled as in the published code: contact is a mean over frames and
//! contact vertices, collision a sum over frames of means over penetrating vertices, smoothness and feet sums over
//! frames of mean squares. The nearest scene point is looked up in the distance field. The variables are joint
//! rotations instead of pose codes, for that is what frames hold; the height of the swinging foot, which is in the code
//! but not in the paper, is left out.

use glam::Vec3;
use rayon::prelude::*;

use super::config::PaperWeights;
use super::descent::{MotionEnergy, Scratch, Subject, View};
use super::stance::nearer_foot_runs;
use crate::body::joints::{LEFT_ANKLE, RIGHT_ANKLE};
use crate::body::{Region, VertexSubset, Workspace};
use crate::fit::energy::{Energy, Term};
use crate::fit::terms;
use crate::scene::Frame;

/// What is found once from the motion as it came in.
pub struct PaperScene {
    /// PROX's contact vertices.
    contact: Vec<u32>,
    /// Vertices of both soles.
    soles: [Vec<u32>; 2],
    /// For each frame the side of its stable foot and the mean place of that sole's vertices.
    stable: Vec<(usize, std::sync::Arc<Vec<Vec3>>)>,
    /// All vertices of the first and the last frame.
    ends: [Vec<Vec3>; 2],
}

/// The energy of a stage.
pub struct PaperEnergy<'a> {
    pub scene: &'a PaperScene,
    pub weights: PaperWeights,
}

impl PaperScene {
    /// From the motion as it came in; `subject` poses all vertices.
    pub fn of(subject: &Subject<'_>, frames: &[Frame]) -> Self {
        let body = subject.body;
        let soles = [Region::LeftLeg, Region::RightLeg].map(|region| body.regions.sample(region).to_vec());
        let both: Vec<u32> = soles.concat();
        let subset = VertexSubset::of_shape(&body.model, both, subject.betas);
        let posed: Vec<([Vec3; 2], Vec<Vec3>)> = frames
            .par_iter()
            .map_init(Workspace::default, |workspace, frame| {
                body.forward_posed(&frame.params(subject.betas), &frame.pose, &subset, workspace);
                let joints = workspace.joints();
                ([joints[LEFT_ANKLE], joints[RIGHT_ANKLE]], workspace.vertices().to_vec())
            })
            .collect();
        let ankles: Vec<[Vec3; 2]> = posed.iter().map(|(ankles, _)| *ankles).collect();
        let mut stable = Vec::with_capacity(frames.len());
        for run in nearer_foot_runs(&ankles) {
            let start = run.side * soles[0].len();
            let mean = |v: usize| {
                let sum: Vec3 = posed[run.frames.clone()].iter().map(|(_, sole)| sole[start + v]).sum();
                sum / run.frames.len() as f32
            };
            let mean = std::sync::Arc::new((0..soles[run.side].len()).map(mean).collect::<Vec<Vec3>>());
            stable.extend(run.frames.clone().map(|_| (run.side, mean.clone())));
        }
        let vertices = |frame: Option<&Frame>| {
            let mut workspace = Workspace::default();
            frame.map_or(Vec::new(), |frame| {
                body.forward_posed(&frame.params(subject.betas), &frame.pose, subject.skin, &mut workspace);
                workspace.vertices().to_vec()
            })
        };
        Self {
            contact: body.regions.prox_sample(),
            soles,
            stable,
            ends: [vertices(frames.first()), vertices(frames.last())],
        }
    }
}

impl MotionEnergy for PaperEnergy<'_> {
    fn add(&self, view: &View<'_>, i: usize, out: &mut Scratch) {
        let (scene, weights) = (self.scene, &self.weights);
        let Scratch { energy, distances, .. } = out;
        let frames = scene.stable.len().max(1) as f32;
        terms::psi_contact(energy, &scene.contact, distances, weights.robust_c_m, weights.contact / frames);
        terms::psi_collision(energy, distances, weights.collision);
        self.smooth(view, i, energy);
        self.ends(view, i, energy);
        let (side, mean) = &scene.stable[view.first + i];
        let sole = &scene.soles[*side];
        let scale = weights.foot / (3 * sole.len().max(1)) as f32;
        let vertices = view.states[i].workspace.vertices();
        for (v, place) in sole.iter().map(|v| *v as usize).zip(mean.iter()) {
            add_square(energy, Term::Feet, v, vertices[v] - *place, scale);
        }
    }
}

impl PaperEnergy<'_> {
    /// Eq. 7 over all vertices and again over each sole. A step's value counts at its first frame.
    fn smooth(&self, view: &View<'_>, i: usize, energy: &mut Energy) {
        let vertices = view.states[i].workspace.vertices();
        let mean_over = |count: usize| self.weights.smooth / (3 * count.max(1)) as f32;
        for (neighbour, counts) in [(i + 1, 1.0), (i.wrapping_sub(1), 0.0)] {
            let Some(beside) = view.states.get(neighbour).map(|state| state.workspace.vertices()) else {
                continue;
            };
            let all = mean_over(vertices.len());
            let mut sum = 0.0;
            for ((slope, here), there) in energy.vertices.iter_mut().zip(vertices).zip(beside) {
                let step = *here - *there;
                sum += step.length_squared();
                *slope += step * (2.0 * all);
            }
            energy.add(Term::Smoothness, counts * all * sum);
            for sole in &self.scene.soles {
                let scale = mean_over(sole.len());
                for v in sole.iter().map(|v| *v as usize) {
                    let step = vertices[v] - beside[v];
                    energy.add(Term::Smoothness, counts * scale * step.length_squared());
                    energy.vertices[v] += step * (2.0 * scale);
                }
            }
        }
    }

    /// The first and the last body stay near to what they were.
    fn ends(&self, view: &View<'_>, i: usize, energy: &mut Energy) {
        let frame = view.first + i;
        let last = self.scene.stable.len().saturating_sub(1);
        let [first_body, last_body] = &self.scene.ends;
        let vertices = view.states[i].workspace.vertices();
        let scale = self.weights.smooth / (3 * vertices.len().max(1)) as f32;
        for (at, body) in [(0, first_body), (last, last_body)] {
            if frame == at {
                for (v, place) in body.iter().enumerate() {
                    add_square(energy, Term::Start, v, vertices[v] - *place, scale);
                }
            }
        }
    }
}

fn add_square(energy: &mut Energy, term: Term, vertex: usize, offset: Vec3, scale: f32) {
    energy.add(term, scale * offset.length_squared());
    energy.vertices[vertex] += offset * (2.0 * scale);
}
