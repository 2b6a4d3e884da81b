//! Bodies at sub-goals by the sub-goal network (LTM §3.2): several ways of being at one place, in one direction.
//!
//! The network gives place and rotation of its own beside the pose; the request is what counts, so the body is put where
//! it was asked for, and how far the network's own place is from that is told: a large distance says that the pose was
//! made for somewhere else.

use glam::{Quat, Vec3};
use rand_distr::{Distribution as _, StandardNormal};

use super::bundled::bundled_networks;
use super::learned::{LearnedMotionError, sampler_of};
use super::local::{LegFrame, code_of};
use super::room_points::RoomPoints;
use crate::assets::Weights;
use crate::body::Body;
use crate::body::joints::PELVIS;
use crate::job::Seed;
use crate::nn::motion::{CONDITION, MotionKind, MotionSampler, PLACE};
use crate::scene::{BETAS, Frame, POSE};

/// LTM §3.2's {β, t, R}.
#[derive(Clone, Copy, Debug)]
pub struct SubGoalRequest<'a> {
    /// Body shape β.
    pub betas: &'a [f32; BETAS],
    /// Where the pelvis shall be, metres, world frame.
    pub pelvis: Vec3,
    /// World from body.
    pub rotation: Quat,
    /// Height of the floor, metres.
    pub floor_m: f32,
}

/// A body as asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct SubGoalBody {
    /// The body, at the place and with the rotation of the request.
    pub frame: Frame,
    /// How far from there the network had it, metres.
    pub off_m: f32,
    /// How much it had it turned from there, degrees.
    pub off_deg: f32,
}

/// The sub-goal network, ready to sample.
pub struct SubGoalBodies {
    net: MotionSampler,
}

impl SubGoalBodies {
    /// The network of a weight file.
    ///
    /// # Errors
    /// [`LearnedMotionError`] when the file holds another.
    pub fn from_weights(weights: &Weights) -> Result<Self, LearnedMotionError> {
        Ok(Self { net: sampler_of(weights, MotionKind::SubGoal)? })
    }

    /// The network that comes with the program.
    ///
    /// # Errors
    /// Never with the embedded file, which a test reads.
    pub fn bundled() -> Result<Self, LearnedMotionError> {
        let files = bundled_networks().collect::<Result<Vec<_>, _>>()?;
        Self::from_weights(&files[files.len() - 1])
    }

    pub(super) fn sampler(&self) -> &MotionSampler {
        &self.net
    }

    /// `count` bodies for one request in a room; another `seed`, other bodies.
    pub fn sample(
        &self,
        body: &Body,
        points: &RoomPoints,
        request: &SubGoalRequest<'_>,
        count: usize,
        seed: Seed,
    ) -> Vec<SubGoalBody> {
        let rest = body.model.rest_joints(request.betas)[PELVIS];
        let asked_for =
            Frame { translation: request.pelvis - rest, rotation: request.rotation, ..Frame::default() };
        let leg = LegFrame::of(&asked_for, rest, request.floor_m);
        let row = leg.row(&asked_for, &[0.0; POSE], rest);
        let mut asked = [0.0; CONDITION];
        asked[..PLACE].copy_from_slice(&row[..PLACE]);
        asked[PLACE..].copy_from_slice(request.betas);
        let config = self.net.config();
        let ends = [request.pelvis; 2];
        let cloud = points.around(&leg, ends, config.points.count, seed.child("cloud", 0)).0;
        let mut rng = seed.child("codes", 0).rng();
        let codes: Vec<f32> = (0..count * config.latent).map(|_| StandardNormal.sample(&mut rng)).collect();
        let made = self.net.bodies(&cloud, &asked, &codes);
        made.iter()
            .map(|row| {
                let own = leg.placed(row, rest);
                let off = own.rotation.angle_between(request.rotation).to_degrees();
                SubGoalBody {
                    frame: Frame {
                        hands: own.hands,
                        pose: body.pose_space.decode(&code_of(row)),
                        ..asked_for.clone()
                    },
                    off_m: own.translation.distance(asked_for.translation),
                    off_deg: off,
                }
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bodies_are_where_they_were_asked_for_and_differ_from_code_to_code() {
        let body = Body::bundled();
        let net = SubGoalBodies::bundled().expect("bundled");
        let request = SubGoalRequest {
            betas: &[0.0; BETAS],
            pelvis: Vec3::new(1.0, 0.9, -2.0),
            rotation: Quat::from_rotation_y(0.8),
            floor_m: 0.0,
        };
        let sample = |seed| net.sample(body, &RoomPoints::default(), &request, 3, Seed::root(seed));
        let bodies = sample(1);
        assert_eq!(bodies.len(), 3);
        let rest = body.model.joint_template[PELVIS];
        for made in &bodies {
            assert!((made.frame.translation + rest).distance(request.pelvis) < 0.05);
            assert!(made.frame.rotation.angle_between(request.rotation).to_degrees() < 10.0);
            assert!(made.off_m.is_finite() && made.off_deg.is_finite() && made.frame.is_finite());
        }
        assert_ne!(bodies[0].frame.pose, bodies[1].frame.pose);
        assert!(bodies == sample(1) && bodies != sample(2));
    }
}
