//! Which feet are planted when, read from a motion that does not say: for what networks and memories of clips give.

use glam::{Mat3, Vec3};

use crate::body::joints::JOINTS;
use crate::body::{Body, Feet, VertexSubset, Workspace};
use crate::scene::{BETAS, CLIP_FPS, Frame};

/// A sole is on the ground when its lowest point is at most this far above it, metres.
const NEAR_M: f32 = 0.045;
/// A planted foot's slowest point moves at most this fast: networks slide a little, metres a second.
const SLOW_M_PER_S: f32 = 0.45;
/// Shorter stances are flickers, frames.
const SHORTEST: usize = 3;

/// Whether the left and the right foot is planted in each frame, for feet that tread on the ground at `floor_m`.
pub fn planted_feet(body: &Body, betas: &[f32; BETAS], frames: &[Frame], floor_m: f32) -> Vec<[bool; 2]> {
    let feet = Feet::of(body, betas);
    let none = VertexSubset::new(&body.model, Vec::new());
    let mut workspace = Workspace::default();
    let treads: Vec<[[Vec3; 3]; 2]> = frames
        .iter()
        .map(|frame| {
            body.forward_posed(&frame.params(betas), &frame.pose, &none, &mut workspace);
            let (joints, rotations): (&[Vec3; JOINTS], &[Mat3; JOINTS]) =
                (workspace.joints(), workspace.world_rotations());
            feet.positions(joints, rotations)
        })
        .collect();
    let mut planted = vec![[false; 2]; frames.len()];
    for side in 0..2 {
        let own: Vec<bool> = (0..frames.len()).map(|i| stands(&treads, side, i, floor_m)).collect();
        for (flags, is_planted) in planted.iter_mut().zip(without_flicker(own)) {
            flags[side] = is_planted;
        }
    }
    planted
}

fn stands(treads: &[[[Vec3; 3]; 2]], side: usize, i: usize, floor_m: f32) -> bool {
    let here = treads[i][side];
    let low_m = here.iter().map(|t| t.y).fold(f32::INFINITY, f32::min) - floor_m;
    let beside = treads[(i + 1).min(treads.len() - 1)][side];
    let before = treads[i.saturating_sub(1)][side];
    let slowest = (0..3)
        .map(|k| (beside[k] - before[k]).with_y(0.0).length() * CLIP_FPS * 0.5)
        .fold(f32::INFINITY, f32::min);
    low_m < NEAR_M && slowest < SLOW_M_PER_S
}

fn without_flicker(mut flags: Vec<bool>) -> Vec<bool> {
    for wanted in [true, false] {
        let mut i = 0;
        while i < flags.len() {
            let end = (i..flags.len()).find(|k| flags[*k] != flags[i]).unwrap_or(flags.len());
            let inner = i > 0 && end < flags.len();
            if inner && flags[i] == wanted && end - i < SHORTEST {
                flags[i..end].fill(!wanted);
            }
            i = end;
        }
    }
    flags
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::joints::{LEFT_HIP, LEFT_KNEE};

    #[test]
    fn a_foot_that_stands_is_planted_and_a_lifted_one_is_not() {
        let body = Body::bundled();
        let lowest = body.model.template.iter().map(|v| v.y).fold(f32::INFINITY, f32::min);
        let frame = |k: usize| {
            let mut frame = Frame { translation: Vec3::new(0.0, -lowest, 0.0), ..Frame::default() };
            if (10..20).contains(&k) {
                frame.pose[LEFT_HIP - 1].x = -0.8;
                frame.pose[LEFT_KNEE - 1].x = 1.0;
            }
            frame
        };
        let frames: Vec<Frame> = (0..30).map(frame).collect();
        let planted = planted_feet(body, &[0.0; BETAS], &frames, 0.0);
        assert!(planted.iter().all(|p| p[1]), "the right foot never moves");
        assert!(planted[2][0] && !planted[15][0] && planted[27][0]);
    }

    #[test]
    fn flickers_are_ironed_out() {
        let flags = [true, true, true, true, false, true, true, true, true];
        assert_eq!(without_flicker(flags.to_vec()), [true; 9]);
    }
}
