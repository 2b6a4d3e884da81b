//! A motion against the true one (LTM §4.3, table 1).

use rayon::prelude::*;
use serde::Serialize;

use crate::body::joints::BODY_JOINTS;
use crate::body::{Body, VertexSubset, Workspace};
use crate::inspect::mean_distance_mm;
use crate::scene::{BETAS, Frame};

/// The errors of LTM table 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct MotionErrors {
    /// Mean absolute difference of the three numbers of the translation, metres ×100.
    pub translation_l1_x100: f32,
    /// Of the six numbers of the orientation ([`crate::math::rotation::six_d_from_matrix`]), ×100.
    pub orientation_l1_x100: f32,
    /// Of the body joints' axis-angles, radians ×100. The paper's is of pose codes, whose unit is another.
    pub pose_l1_x100: f32,
    /// Mean distance of the pelvis and the 21 body joints, millimetres.
    pub mpjpe_mm: f32,
    /// Mean distance of all vertices, millimetres.
    pub mpvpe_mm: f32,
}

impl MotionErrors {
    /// Means over the frames of a motion and its truth, frame by frame; frames that only one has are left out.
    pub fn of(body: &Body, betas: &[f32; BETAS], motion: &[Frame], truth: &[Frame]) -> Self {
        let skin = VertexSubset::all_of_shape(&body.model, betas);
        let pairs: Vec<(&Frame, &Frame)> = motion.iter().zip(truth).collect();
        let one = |workspaces: &mut [Workspace; 2], (a, b): &(&Frame, &Frame)| {
            let [first, second] = workspaces;
            for (frame, workspace) in [(a, &mut *first), (b, &mut *second)] {
                body.forward_posed(&frame.params(betas), &frame.pose, &skin, workspace);
            }
            let joints = |w: &Workspace| w.joints()[..=BODY_JOINTS].to_vec();
            Self {
                mpjpe_mm: mean_distance_mm(&joints(first), &joints(second)),
                mpvpe_mm: mean_distance_mm(first.vertices(), second.vertices()),
                ..Self::of_numbers(betas, a, b)
            }
        };
        let each: Vec<Self> = pairs.par_iter().map_init(Default::default, one).collect();
        let mean = |of: &dyn Fn(&Self) -> f32| {
            (each.iter().map(|e| f64::from(of(e))).sum::<f64>() / each.len().max(1) as f64) as f32
        };
        Self {
            translation_l1_x100: mean(&|e| e.translation_l1_x100),
            orientation_l1_x100: mean(&|e| e.orientation_l1_x100),
            pose_l1_x100: mean(&|e| e.pose_l1_x100),
            mpjpe_mm: mean(&|e| e.mpjpe_mm),
            mpvpe_mm: mean(&|e| e.mpvpe_mm),
        }
    }

    fn of_numbers(betas: &[f32; BETAS], a: &Frame, b: &Frame) -> Self {
        let l1 = |a: &[f32], b: &[f32]| {
            100.0 * a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f32>() / a.len().max(1) as f32
        };
        let flat = |frame: &Frame| frame.pose.iter().flat_map(glam::Vec3::to_array).collect::<Vec<f32>>();
        Self {
            translation_l1_x100: l1(&a.translation.to_array(), &b.translation.to_array()),
            orientation_l1_x100: l1(&a.params(betas).rotation6, &b.params(betas).rotation6),
            pose_l1_x100: l1(&flat(a), &flat(b)),
            ..Self::default()
        }
    }
}
