//! LTM §3.4, eq. 5 to 7 and the stable foot, scaled as in the published code: contact is a mean over frames and
//! contact vertices, collision a sum over frames of means over penetrating vertices, smoothness and feet sums over
//! frames of mean squares. The nearest scene point is looked up in the distance field. The variables are joint
//! rotations instead of pose codes, for that is what frames hold; the height of the swinging foot, which is in the code
//! but not in the paper, is left out.

use std::sync::Arc;

use glam::Vec3;
use rayon::prelude::*;

use super::config::PaperWeights;
use super::descent::{MotionEnergy, Scratch, Subject, View};
use super::stance::nearer_foot_runs;
use crate::body::joints::{LEFT_ANKLE, RIGHT_ANKLE};
use crate::body::{Region, SkinForm, SkinMatrices, VertexSubset, Workspace};
use crate::fit::energy::Term;
use crate::fit::terms::{self, Distances};
use crate::scene::{Frame, OpenBlocks, SignedDistanceField};

/// What is found once from the motion as it came in.
///
/// The squares of eq. 7, of the ends and of the stable foot are all between poses of one shape, so they are forms of
/// the skinning matrices ([`SkinForm`]); no vertex is asked.
pub struct PaperScene {
    /// PROX's contact vertices.
    contact: Vec<u32>,
    /// Eq. 7: the mean over all vertices and that over each sole.
    steps: SkinForm,
    /// The mean over all vertices.
    skin: SkinForm,
    /// The mean over each sole.
    soles: [SkinForm; 2],
    /// For each frame the side of its stable foot and the mean of that stance, whose sole it keeps to.
    stable: Vec<(usize, Arc<SkinMatrices>)>,
    /// The first and the last frame.
    ends: [SkinMatrices; 2],
}

/// The energy of a stage.
pub struct PaperEnergy<'a> {
    pub scene: &'a PaperScene,
    pub weights: PaperWeights,
    /// Where no vertex can be in a solid.
    pub open: &'a OpenBlocks,
}

impl PaperScene {
    /// From the motion as it came in; `subject` poses all vertices.
    pub fn of(subject: &Subject<'_>, frames: &[Frame]) -> Self {
        let body = subject.body;
        let no_skin = VertexSubset::of_shape(&body.model, Vec::new(), subject.betas);
        let posed: Vec<([Vec3; 2], SkinMatrices)> = frames
            .par_iter()
            .map_init(Workspace::default, |workspace, frame| {
                body.forward_posed(&frame.params(subject.betas), &frame.pose, &no_skin, workspace);
                let joints = workspace.joints();
                ([joints[LEFT_ANKLE], joints[RIGHT_ANKLE]], workspace.skin_matrices())
            })
            .collect();
        let ankles: Vec<[Vec3; 2]> = posed.iter().map(|(ankles, _)| *ankles).collect();
        let mut stable = Vec::with_capacity(frames.len());
        for run in nearer_foot_runs(&ankles) {
            let mean = SkinMatrices::mean(posed[run.frames.clone()].iter().map(|(_, skin)| skin));
            let mean = Arc::new(mean);
            stable.extend(run.frames.clone().map(|_| (run.side, mean.clone())));
        }
        let matrices = |i: Option<usize>| {
            i.and_then(|i| posed.get(i)).map_or(SkinMatrices::ZERO, |(_, skin)| skin.clone())
        };
        let [left, right] =
            [Region::LeftLeg, Region::RightLeg].map(|region| body.regions.sample(region).to_vec());
        let all = || mean_over((0..subject.skin.len()).collect::<Vec<_>>());
        let sole = |ids: &[u32]| mean_over(ids.iter().map(|v| *v as usize).collect::<Vec<_>>());
        let of = |weighted: Vec<(usize, f32)>| SkinForm::new(subject.skin, weighted.into_iter());
        Self {
            contact: body.regions.prox_sample(),
            steps: of([all(), sole(&left), sole(&right)].concat()),
            skin: of(all()),
            soles: [of(sole(&left)), of(sole(&right))],
            stable,
            ends: [matrices(Some(0)), matrices(frames.len().checked_sub(1))],
        }
    }
}

/// Each of these vertices with its share of a mean over their coordinates.
fn mean_over(vertices: Vec<usize>) -> Vec<(usize, f32)> {
    let share = 1.0 / (3 * vertices.len().max(1)) as f32;
    vertices.into_iter().map(|v| (v, share)).collect()
}

impl MotionEnergy for PaperEnergy<'_> {
    fn add(&self, view: &View<'_>, i: usize, out: &mut Scratch) {
        let (scene, weights) = (self.scene, &self.weights);
        let frames = scene.stable.len().max(1) as f32;
        let Scratch { energy, distances, skin, .. } = out;
        terms::psi_contact(energy, &scene.contact, distances, weights.robust_c_m, weights.contact / frames);
        terms::psi_collision(energy, distances, weights.collision);
        let matrices = view.states[i].workspace.skin_matrices();
        // A step's value counts at its first frame.
        for (neighbour, counts) in [(i + 1, 1.0), (i.wrapping_sub(1), 0.0)] {
            let Some(beside) = view.states.get(neighbour) else { continue };
            let step = matrices.less(&beside.workspace.skin_matrices());
            energy.add(Term::Smoothness, counts * scene.steps.add_square(&step, weights.smooth, skin));
        }
        let frame = view.first + i;
        let last = scene.stable.len().saturating_sub(1);
        for (at, end) in [(0, &scene.ends[0]), (last, &scene.ends[1])] {
            if frame == at {
                let off = matrices.less(end);
                energy.add(Term::Start, scene.skin.add_square(&off, weights.smooth, skin));
            }
        }
        let (side, mean) = &scene.stable[frame];
        let off = matrices.less(mean);
        energy.add(Term::Feet, scene.soles[*side].add_square(&off, weights.foot, skin));
    }

    /// Contact asks its vertices only, collision those that may be in a solid.
    fn sense(&self, field: &SignedDistanceField, vertices: &[Vec3], distances: &mut Distances) {
        let Distances { value, gradient } = distances;
        for (v, position) in vertices.iter().enumerate() {
            if self.open.is_open(field, *position) {
                value[v] = f32::INFINITY;
            } else {
                (value[v], gradient[v]) = field.sample_gradient(*position);
            }
        }
        for v in self.scene.contact.iter().map(|v| *v as usize) {
            (value[v], gradient[v]) = field.sample_gradient(vertices[v]);
        }
    }
}
