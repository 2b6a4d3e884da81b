//! Shapes of hands, made from how far each finger curls.

use glam::Vec3;

use super::families::Chance;
use super::hand_space::HAND_JOINTS;

/// How a hand is shaped: curl of each finger, 0 straight to 1 closed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandShape {
    /// Index, middle, pinky, ring, thumb: the order of the joints.
    pub curls: [f32; 5],
    /// Radians that index and pinky spread from the middle finger.
    pub spread: f32,
}

/// Curl of a closed finger at its three joints, radians: 80, 95 and 60 degrees (AAOS flexion norms of MCP, PIP,
/// DIP are 90, 100 and 70).
const CLOSED: [f32; 3] = [1.4, 1.66, 1.05];
/// A closed thumb, axis-angles of its three joints on the left hand.
const CLOSED_THUMB: [Vec3; 3] =
    [Vec3::new(0.15, 0.3, -0.1), Vec3::new(0.25, 0.5, 0.0), Vec3::new(0.3, 0.75, 0.0)];

impl HandShape {
    /// Hanging or lying loosely: fingers curl more towards the pinky.
    pub(super) fn relaxed(rng: &mut impl Chance) -> Self {
        let base = rng.about(0.25, 0.05);
        Self::rising(base, rng.about(0.05, 0.015), rng.between(0.15, 0.4), rng.between(0.0, 0.06))
    }

    /// Laid on something soft: gently bent.
    pub(super) fn resting(rng: &mut impl Chance) -> Self {
        Self::rising(
            rng.about(0.15, 0.04),
            rng.about(0.015, 0.01),
            rng.between(0.05, 0.25),
            rng.between(0.02, 0.1),
        )
    }

    /// Pressed on something hard.
    pub(super) fn flat(rng: &mut impl Chance) -> Self {
        Self::rising(rng.about(0.04, 0.015), 0.0, rng.between(0.0, 0.15), rng.between(0.05, 0.18))
    }

    /// A fist.
    pub fn fist() -> Self {
        Self::rising(0.95, 0.0, 0.9, 0.0)
    }

    /// Points with the index finger.
    pub fn pointing() -> Self {
        Self { curls: [0.05, 0.8, 0.85, 0.85, 0.6], spread: 0.0 }
    }

    fn rising(index: f32, step: f32, thumb: f32, spread: f32) -> Self {
        Self { curls: [index, index + step, index + 3.0 * step, index + 2.0 * step, thumb], spread }
    }

    /// Axis-angles of the left hand; mirror them for the right.
    pub fn left_pose(&self) -> [Vec3; HAND_JOINTS] {
        // The pinky spreads backwards (-z), the index forwards; x runs along the fingers, palm down.
        let spread = [-1.0, 0.0, 1.0, 0.5];
        std::array::from_fn(|i| {
            let (finger, bone) = (i / 3, i % 3);
            if finger == 4 {
                return CLOSED_THUMB[bone] * self.curls[4];
            }
            let aside = if bone == 0 { spread[finger] * self.spread } else { 0.0 };
            Vec3::new(0.0, aside, -CLOSED[bone] * self.curls[finger])
        })
    }
}
