//! The numbers of a frame that the optimiser moves.

use glam::{Mat3, Quat, Vec3};

use crate::body::{BodyPose, PosedGradient};
use crate::math::rotation;
use crate::scene::{FRAME_JOINTS, Frame, HANDS};

/// First number of the turn.
pub const TURN: usize = 3;
/// First number of the pose.
pub const POSE: usize = 6;
/// First number of the hands.
pub const CODES: usize = POSE + 3 * FRAME_JOINTS;
/// Numbers of a frame: `t 3 | turn 3 | axis-angles 63 | hand codes 24`. The turn is a rotation vector about the frame's
/// first rotation, world axes, so it starts at zero and never comes near to its far end.
pub const NUMBERS: usize = CODES + HANDS;

/// What one squared unit of each number's change costs relative to a radian of a joint: a metre is ten, the turn of
/// the whole body three, a standard deviation of a hand code a tenth.
pub const COSTS: [f32; NUMBERS] = per_number(10.0, 3.0, 1.0, 0.1);

/// An array with one value for each block of numbers.
pub const fn per_number(translation: f32, turn: f32, pose: f32, hands: f32) -> [f32; NUMBERS] {
    let mut all = [translation; NUMBERS];
    let mut i = TURN;
    while i < NUMBERS {
        all[i] = if i < POSE {
            turn
        } else if i < CODES {
            pose
        } else {
            hands
        };
        i += 1;
    }
    all
}

/// The numbers of a frame, its turn counted from `from`.
pub fn numbers_of(frame: &Frame, from: Quat) -> [f32; NUMBERS] {
    let mut x = [0.0; NUMBERS];
    x[..TURN].copy_from_slice(&frame.translation.to_array());
    let turn = frame.rotation * from.inverse();
    let turn = if turn.w < 0.0 { -turn } else { turn };
    x[TURN..POSE].copy_from_slice(&turn.to_scaled_axis().to_array());
    for (slot, joint) in x[POSE..CODES].chunks_exact_mut(3).zip(&frame.pose) {
        slot.copy_from_slice(&joint.to_array());
    }
    x[CODES..].copy_from_slice(&frame.hands);
    x
}

fn turn_of(x: &[f32]) -> Vec3 {
    Vec3::from_slice(&x[TURN..POSE])
}

/// The frame of numbers `x` whose turn counts from `from`.
pub fn frame_of(x: &[f32], from: Quat) -> Frame {
    let pose: BodyPose = std::array::from_fn(|j| Vec3::from_slice(&x[POSE + 3 * j..]));
    let mut hands = [0.0; HANDS];
    hands.copy_from_slice(&x[CODES..NUMBERS]);
    Frame {
        translation: Vec3::from_slice(x),
        rotation: (Quat::from_scaled_axis(turn_of(x)) * from).normalize(),
        pose,
        hands,
    }
}

/// The gradient by the numbers.
pub fn flatten(gradient: &PosedGradient, x: &[f32], from: Quat) -> [f32; NUMBERS] {
    let mut flat = [0.0; NUMBERS];
    flat[..TURN].copy_from_slice(&gradient.translation.to_array());
    let turn = turn_of(x);
    let by_turn_matrix = gradient.rotation * Mat3::from_quat(from).transpose();
    let turned =
        rotation::pull_back_axis_angle(turn, &rotation::matrix_from_axis_angle(turn), &by_turn_matrix);
    flat[TURN..POSE].copy_from_slice(&turned.to_array());
    for (slot, joint) in flat[POSE..CODES].chunks_exact_mut(3).zip(&gradient.pose) {
        slot.copy_from_slice(&joint.to_array());
    }
    flat[CODES..].copy_from_slice(&gradient.hands);
    flat
}
