//! Hands and eyes on what somebody uses: the last thing that is done to a pose, over whatever its family drew.

use glam::{Mat3, Vec3};

use crate::body::hands::HandShape;
use crate::body::joints::{HEAD, LEFT_SHOULDER, PELVIS, SPINE1, SPINE2};

use super::arms::{self, HAND_HALF_THICKNESS_M, PALM_M};
use super::chance::Chance;
use super::figure::{Figure, Side, arm as arm_of};
use super::torso;

/// What hands and eyes are on. Points in the upright frame, metres: the pelvis at the origin, +Z ahead and +X to the
/// left of who stands or sits; who lies has the head towards -Z.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Attention {
    /// Of the left and of the right hand; `None` leaves it to the family.
    pub hands: [Option<HandOn>; 2],
    /// What is looked at; `None` leaves it to the family.
    pub look_at: Option<Vec3>,
}

/// Where a hand is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandOn {
    /// The point that the palm touches.
    pub at: Vec3,
    /// Which way the palm looks.
    pub palm: Vec3,
}

/// Who can't reach bends forward in so many steps, of so many radians in each of two joints of the spine.
const STEPS: usize = 6;
const STEP: f32 = 0.06;
/// An arm reaches this share of its length in comfort.
const COMFORT: f32 = 0.97;
/// A head turns and nods this far in comfort, radians.
const MOST_TURN: f32 = 1.0;
const NOD: std::ops::RangeInclusive<f32> = -0.35..=0.5;

/// Moves hands and head to where they are wanted, as far as arms and neck go.
pub(super) fn attend(
    figure: &mut Figure,
    attention: &Attention,
    hands: &mut [HandShape; 2],
    rng: &mut impl Chance,
) {
    let lies = figure.rotation(PELVIS).y_axis.y < 0.5;
    if !lies {
        bend_to_reach(figure, attention);
    }
    for (side, shape) in Side::BOTH.into_iter().zip(hands) {
        if let Some(on) = attention.hands[side as usize].filter(|on| is_in_reach(figure, side, on)) {
            *shape = lay(figure, side, &on, rng);
        }
    }
    if let Some(point) = attention.look_at {
        let way = point - figure.position(HEAD);
        let ahead = if lies { Mat3::from_rotation_y(std::f32::consts::PI) } else { Mat3::IDENTITY };
        let seen = ahead.transpose() * way;
        let turn = seen.x.atan2(seen.z).clamp(-MOST_TURN, MOST_TURN);
        let nod = (-seen.y).atan2(seen.with_y(0.0).length()).clamp(*NOD.start(), *NOD.end());
        torso::look(figure, turn + if lies { std::f32::consts::PI } else { 0.0 }, nod, 0.0);
    }
}

fn wrist_of(on: &HandOn, fingers: Vec3) -> Vec3 {
    on.at - fingers * PALM_M - on.palm * HAND_HALF_THICKNESS_M
}

/// Fingers point from the shoulder to the place, a little inwards, along what the palm lies on.
fn fingers_to(figure: &Figure, side: Side, on: &HandOn) -> Vec3 {
    let way = on.at - figure.position(side.joint(LEFT_SHOULDER)) + side.outward(-0.08, 0.0, 0.0);
    (way - on.palm * way.dot(on.palm)).normalize_or(Vec3::Z)
}

fn missing_m(figure: &Figure, side: Side, on: &HandOn) -> f32 {
    let arm = arm_of(side);
    let reach_m = (figure.bone(arm.lower) + figure.bone(arm.end)) * COMFORT;
    let wrist = wrist_of(on, fingers_to(figure, side, on));
    wrist.distance(figure.position(side.joint(LEFT_SHOULDER))) - reach_m
}

fn is_in_reach(figure: &Figure, side: Side, on: &HandOn) -> bool {
    missing_m(figure, side, on) <= 0.02
}

/// Bends the back forward until the hands get there; not at all where that does not help.
fn bend_to_reach(figure: &mut Figure, attention: &Attention) {
    let before = figure.clone();
    for _ in 0..STEPS {
        let short =
            |side: Side| attention.hands[side as usize].is_some_and(|on| missing_m(figure, side, &on) > 0.0);
        if !Side::BOTH.into_iter().any(short) {
            return;
        }
        for joint in [SPINE1, SPINE2] {
            figure.local[joint] *= Mat3::from_rotation_x(STEP);
        }
    }
    let reached =
        |side: Side| attention.hands[side as usize].is_some_and(|on| is_in_reach(figure, side, &on));
    if !Side::BOTH.into_iter().any(reached) {
        *figure = before;
    }
}

fn lay(figure: &mut Figure, side: Side, on: &HandOn, rng: &mut impl Chance) -> HandShape {
    let fingers = fingers_to(figure, side, on);
    let pole = side.outward(1.0, -0.9, -0.4);
    figure.reach(arm_of(side), wrist_of(on, fingers), pole);
    figure.aim_hand(side, fingers, on.palm);
    arms::resting(rng)
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng as _;
    use rand_chacha::ChaCha8Rng;

    use super::super::{FamilyHints, sample_pose};
    use super::*;
    use crate::body::Body;
    use crate::body::joints::{LEFT_WRIST, NECK, RIGHT_WRIST, SPINE3};
    use crate::math::rotation::matrix_from_axis_angle;
    use crate::scene::{BETAS, PoseFamily};

    #[test]
    fn who_sits_at_a_keyboard_has_both_hands_on_it_and_looks_there() {
        let body = Body::bundled();
        let on = |x: f32| Some(HandOn { at: Vec3::new(x, 0.17, 0.42), palm: Vec3::NEG_Y });
        let look_at = Vec3::new(0.0, 0.25, 0.55);
        let attention = Attention { hands: [on(0.09), on(-0.09)], look_at: Some(look_at) };
        let hints = FamilyHints {
            seat_height_m: Some(0.45),
            table_height_m: Some(0.72),
            attention: Some(attention),
            ..FamilyHints::default()
        };
        for seed in 0..12 {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let sampled = sample_pose(&body.model.joint_template, PoseFamily::SitChair, &mut rng, &hints);
            let params = sampled.params(body, [0.0; BETAS], &Mat3::IDENTITY);
            let posed = body.pose(&params);
            let pelvis = posed.joints[PELVIS];
            for (wrist, x) in [(LEFT_WRIST, 0.09), (RIGHT_WRIST, -0.09)] {
                let palm = Vec3::new(x, 0.17, 0.42);
                let apart = (posed.joints[wrist] - pelvis).distance(palm);
                assert!(apart < PALM_M + 0.06, "seed {seed}: the wrist is {apart} m from its key");
            }
            let turned = |turn: Mat3, joint: &usize| turn * matrix_from_axis_angle(sampled.pose[joint - 1]);
            let chain = [SPINE1, SPINE2, SPINE3, NECK, HEAD];
            let ahead = chain.iter().fold(sampled.upright_from_body, turned) * Vec3::Z;
            let wanted = (look_at - (posed.joints[HEAD] - pelvis)).normalize();
            assert!(ahead.dot(wanted) > 0.8, "seed {seed}: looks along {ahead} instead of {wanted}");
        }
    }

    #[test]
    fn what_is_out_of_reach_changes_no_hand() {
        let body = Body::bundled();
        let far = Some(HandOn { at: Vec3::new(0.1, 0.2, 2.0), palm: Vec3::NEG_Y });
        let attention = Attention { hands: [far, far], look_at: None };
        let drawn = |attention| {
            let hints = FamilyHints { attention, ..FamilyHints::default() };
            let mut rng = ChaCha8Rng::seed_from_u64(4);
            sample_pose(&body.model.joint_template, PoseFamily::SitSofa, &mut rng, &hints)
        };
        assert_eq!(drawn(Some(attention)), drawn(None));
    }
}
