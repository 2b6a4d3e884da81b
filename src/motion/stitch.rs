//! Makes a motion meet the two bodies that it should lead from and to: what it misses them by fades out into it.

use glam::{Quat, Vec3};

use super::capture::{axis_angle, quat};
use crate::scene::{FRAME_JOINTS, Frame, HANDS};

/// Share of a motion over which the error at an end fades out.
const FADE: f32 = 0.35;

/// How much an error at one end (0 first, 1 last) counts in step `k` of `last`: 1 there, 0 from [`FADE`] on, smooth.
pub fn fade(k: usize, end: usize, last: usize) -> f32 {
    let steps = if end == 0 { k } else { last - k };
    let share = (1.0 - steps as f32 / (FADE * last as f32)).max(0.0);
    share * share * (3.0 - 2.0 * share)
}

/// What one body differs from another by.
struct Gap {
    translation: Vec3,
    turn: Quat,
    pose: [Quat; FRAME_JOINTS],
    hands: [f32; HANDS],
}

impl Gap {
    fn between(made: &Frame, wanted: &Frame) -> Self {
        Self {
            translation: wanted.translation - made.translation,
            turn: wanted.rotation * made.rotation.inverse(),
            pose: std::array::from_fn(|j| quat(made.pose[j]).inverse() * quat(wanted.pose[j])),
            hands: std::array::from_fn(|i| wanted.hands[i] - made.hands[i]),
        }
    }

    fn close(&self, frame: &mut Frame, share: f32) {
        if share <= 0.0 {
            return;
        }
        frame.translation += self.translation * share;
        frame.rotation = (Quat::IDENTITY.slerp(self.turn, share) * frame.rotation).normalize();
        frame.pose = std::array::from_fn(|j| {
            axis_angle(quat(frame.pose[j]) * Quat::IDENTITY.slerp(self.pose[j], share))
        });
        frame.hands.iter_mut().zip(self.hands).for_each(|(h, gap)| *h += gap * share);
    }
}

/// The motion with `from` as its first and `to` as its last frame, byte for byte.
pub fn stitched(mut frames: Vec<Frame>, from: &Frame, to: &Frame) -> Vec<Frame> {
    let Some(last) = frames.len().checked_sub(1).filter(|last| *last > 0) else {
        return vec![from.clone(), to.clone()];
    };
    let gaps = [Gap::between(&frames[0], from), Gap::between(&frames[last], to)];
    for (k, frame) in frames.iter_mut().enumerate() {
        gaps.iter().enumerate().for_each(|(end, gap)| gap.close(frame, fade(k, end, last)));
    }
    frames[0].clone_from(from);
    frames[last].clone_from(to);
    frames
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_are_met_and_the_middle_stays_without_a_jump() {
        let made: Vec<Frame> = (0..61)
            .map(|k| Frame { translation: Vec3::new(0.0, 0.9, k as f32 * 0.02), ..Frame::default() })
            .collect();
        let mut from = made[0].clone();
        from.translation.x += 0.1;
        from.pose[3].x = 0.5;
        let to = Frame { rotation: Quat::from_rotation_y(0.6), ..made[60].clone() };
        let met = stitched(made.clone(), &from, &to);
        assert!(met[0] == from && met[60] == to && met[30] == made[30]);
        for pair in met.windows(2) {
            assert!(pair[0].translation.distance(pair[1].translation) < 0.03);
            assert!(pair[0].rotation.angle_between(pair[1].rotation) < 0.06);
            assert!(pair[0].pose[3].distance(pair[1].pose[3]) < 0.05);
        }
    }
}
