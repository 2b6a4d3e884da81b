//! Pose families as distributions: what people's joints do when they stand, lean, sit and lie.
//!
//! A sample is built on a jointed figure of the mean body: torso and legs by angles drawn from ranges of
//! biomechanics, arms by what the hands do (two-bone inverse kinematics), then checked for limbs inside each
//! other and drawn again if they are. The same stream of random numbers gives the same pose.

mod arms;
mod attention;
mod capsules;
mod chance;
mod figure;
mod lie;
mod sit;
mod stand;
mod torso;

use glam::{Mat3, Vec3};

use crate::scene::{BETAS, BodyParams, HANDS, PoseFamily};

use super::hand_space::HAND_CODE;
use super::hands::HandShape;
use super::joints::{self, JOINTS};
use super::pose_space::BodyPose;
use super::posed::Body;

pub use attention::{Attention, HandOn};
pub(in crate::body) use chance::Chance;
use figure::{Figure, Side};

/// What the place says about the pose; `None` leaves it to the family.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FamilyHints {
    /// Seat above the floor that the feet reach for.
    pub seat_height_m: Option<f32>,
    /// Armrests above the seat.
    pub armrest_above_seat_m: Option<f32>,
    /// From below the pelvis back to where the seat ends or its back rises.
    pub seat_behind_m: Option<f32>,
    /// Table (sitting) or counter (leaning) in front, above the floor.
    pub table_height_m: Option<f32>,
    /// From the pelvis forward to where hands lie on that table or counter.
    pub table_reach_m: Option<f32>,
    /// How a leaning person leans; drawn when not said.
    pub lean: Option<LeanStyle>,
    /// What hands and eyes are on.
    pub attention: Option<Attention>,
    /// Length from the crown to the toes that somebody who lies has; who is longer draws the legs up.
    pub lying_length_m: Option<f32>,
    /// Pillow or armrest under the head, above what the back lies on.
    pub pillow_m: Option<f32>,
    /// On which side somebody lies; drawn when not said.
    pub lies_on: Option<LyingSide>,
}

/// On which side somebody lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LyingSide {
    /// The left arm below.
    Left,
    /// The right arm below.
    Right,
}

/// How somebody leans.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum LeanStyle {
    /// Hands on a counter or table in front.
    HandsInFront,
    /// Back and hips against a wall behind.
    BackOnWall,
    /// Hips against a counter's edge behind.
    HipsOnCounter,
}

/// A drawn pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampledPose {
    /// Axis-angles of the body joints.
    pub pose: BodyPose,
    /// Turns the body into an upright frame (Y up): standing and sitting people face about +Z; lying people
    /// have their feet towards +Z and their head towards -Z.
    pub upright_from_body: Mat3,
    /// Shape of the left and the right hand.
    pub hands: [HandShape; 2],
}

impl SampledPose {
    /// The parameters of this pose on a body: pose and hands encoded, pelvis joint of the mean shape at
    /// `translation` zero, rotation `world_from_upright * upright_from_body`.
    pub fn params(&self, body: &Body, betas: [f32; BETAS], world_from_upright: &Mat3) -> BodyParams {
        let mut params =
            BodyParams { betas, pose: body.pose_space.encode(&self.pose), ..BodyParams::default() };
        params.set_rotation(&(*world_from_upright * self.upright_from_body));
        params.hands = self.hand_codes(body);
        params
    }

    fn hand_codes(&self, body: &Body) -> [f32; HANDS] {
        let codes = self.hands.map(|hand| body.hand_space.encode_left(&hand.left_pose()));
        std::array::from_fn(|i| codes[i / HAND_CODE][i % HAND_CODE])
    }
}

/// Redraws of a pose whose limbs are inside each other before the least bad one is taken.
const MAX_DRAWS: usize = 24;
/// Overlap of limbs that soft flesh takes.
const FLESH_M: f32 = 0.012;

/// Draws a pose of a family for a body whose mean rest joints are `rest`.
pub fn sample_pose(
    rest: &[Vec3; JOINTS],
    family: PoseFamily,
    rng: &mut impl rand::Rng,
    hints: &FamilyHints,
) -> SampledPose {
    let mut best: Option<(f32, SampledPose)> = None;
    for _ in 0..MAX_DRAWS {
        let (figure, hands) = draw(rest, family, rng, hints);
        let overlap = capsules::deepest_overlap_m(&figure);
        if best.as_ref().is_none_or(|(least, _)| overlap < *least) {
            let sampled =
                SampledPose { pose: figure.pose(), upright_from_body: figure.local[joints::PELVIS], hands };
            best = Some((overlap, sampled));
        }
        if overlap < FLESH_M {
            break;
        }
    }
    best.map_or_else(|| unreachable!("MAX_DRAWS is positive"), |(_, sampled)| sampled)
}

fn draw(
    rest: &[Vec3; JOINTS],
    family: PoseFamily,
    rng: &mut impl Chance,
    hints: &FamilyHints,
) -> (Figure, [HandShape; 2]) {
    let mut figure = Figure::new(rest);
    let hands = match family {
        PoseFamily::Stand => stand::stand(&mut figure, rng),
        PoseFamily::Lean => stand::lean(&mut figure, rng, hints),
        PoseFamily::SitChair
        | PoseFamily::SitSofa
        | PoseFamily::SitStool
        | PoseFamily::SitEdge
        | PoseFamily::SitStraight => sit::sit(&mut figure, family, rng, hints),
        PoseFamily::LieUp => lie::face_up(&mut figure, rng, hints),
        PoseFamily::LieDown => lie::face_down(&mut figure, rng),
        PoseFamily::LieSide => lie::on_side(&mut figure, rng, hints),
    };
    // People are not left-handed alike: half of all poses are mirrored.
    let mirrored = rng.chance(0.5);
    let mirrored = match (family, hints.lies_on) {
        (PoseFamily::LieSide, Some(side)) => side == LyingSide::Left,
        _ => mirrored,
    };
    let (mut figure, mut hands) =
        if mirrored { (figure.mirrored(), [hands[1], hands[0]]) } else { (figure, hands) };
    if let Some(attention) = &hints.attention {
        attention::attend(&mut figure, attention, &mut hands, rng);
    }
    (figure, hands)
}

/// Places both arms, left first.
fn place_arms(figure: &mut Figure, goals: [arms::ArmGoal; 2], rng: &mut impl Chance) -> [HandShape; 2] {
    let left = arms::place(figure, Side::Left, goals[0], rng);
    [left, arms::place(figure, Side::Right, goals[1], rng)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::joints::{LEFT_ANKLE, LEFT_HIP, LEFT_KNEE, LEFT_WRIST, RIGHT_ANKLE};
    use crate::body::{Posed, Region, worst_excess};
    use crate::math::Aabb;
    use rand::SeedableRng as _;
    use rand_chacha::ChaCha8Rng;

    fn draws(family: PoseFamily, count: usize, hints: &FamilyHints) -> Vec<SampledPose> {
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let rest = &Body::bundled().model.joint_template;
        (0..count).map(|_| sample_pose(rest, family, &mut rng, hints)).collect()
    }

    fn posed(sample: &SampledPose) -> Posed {
        let body = Body::bundled();
        body.pose(&sample.params(body, [0.0; BETAS], &Mat3::IDENTITY))
    }

    #[test]
    fn nobody_bends_a_joint_farther_than_people_can() {
        for family in PoseFamily::ALL {
            for sample in draws(family, 60, &FamilyHints::default()) {
                let (excess, joint) = worst_excess(&sample.pose);
                assert!(excess < 0.1, "{}: {} by {excess}", family.label(), joints::NAMES[joint]);
            }
        }
    }

    #[test]
    fn the_seats_height_sets_the_knees() {
        let knee = |height: f32| {
            let hints = FamilyHints { seat_height_m: Some(height), ..FamilyHints::default() };
            let people = draws(PoseFamily::SitChair, 60, &hints);
            let bent = people.iter().map(|sample| {
                let joints = posed(sample).joints;
                let thigh = joints[LEFT_KNEE] - joints[LEFT_HIP];
                thigh.angle_between(joints[LEFT_ANKLE] - joints[LEFT_KNEE]).to_degrees()
            });
            bent.sum::<f32>() / 60.0
        };
        let (low, usual, high) = (knee(0.35), knee(0.45), knee(0.62));
        assert!((75.0..105.0).contains(&usual), "a chair of 45 cm bends knees by {usual} degrees");
        // On a seat that is too high the feet hang, so the knees open little further.
        assert!(low > usual + 5.0 && high < usual - 1.0, "{low}, {usual}, {high}");
    }

    #[test]
    fn lying_people_are_flat() {
        for family in [PoseFamily::LieUp, PoseFamily::LieDown, PoseFamily::LieSide] {
            for sample in draws(family, 20, &FamilyHints::default()) {
                let size = Aabb::of(posed(&sample).vertices).size();
                let highest = if family == PoseFamily::LieSide { 0.6 } else { 0.48 };
                assert!(size.y < highest && size.z > 1.1, "{}: {size}", family.label());
            }
        }
    }

    #[test]
    fn who_has_little_length_to_lie_draws_the_legs_up_to_fit() {
        let long_m = |family: PoseFamily, hints: &FamilyHints| {
            let longest = |sample: &SampledPose| Aabb::of(posed(sample).vertices).size().z;
            draws(family, 20, hints).iter().map(longest).fold(0.0, f32::max)
        };
        for family in [PoseFamily::LieUp, PoseFamily::LieSide] {
            let short = FamilyHints { lying_length_m: Some(1.4), ..FamilyHints::default() };
            let (free, fitted) = (long_m(family, &FamilyHints::default()), long_m(family, &short));
            assert!(fitted < 1.48, "{}: {fitted} m for a length of 1.4 m", family.label());
            assert!(free > fitted + 0.1, "{}: {free} m without being told", family.label());
        }
    }

    #[test]
    fn people_lie_on_the_side_that_is_asked_for() {
        use crate::body::joints::{LEFT_SHOULDER, RIGHT_SHOULDER};
        for (side, below, above) in [
            (LyingSide::Left, LEFT_SHOULDER, RIGHT_SHOULDER),
            (LyingSide::Right, RIGHT_SHOULDER, LEFT_SHOULDER),
        ] {
            let hints = FamilyHints { lies_on: Some(side), ..FamilyHints::default() };
            for sample in draws(PoseFamily::LieSide, 10, &hints) {
                let joints = posed(&sample).joints;
                assert!(joints[above].y > joints[below].y + 0.15, "{side:?}");
            }
        }
    }

    #[test]
    fn a_pillow_lifts_the_head() {
        let head_m = |pillow_m: Option<f32>| {
            let hints = FamilyHints { pillow_m, ..FamilyHints::default() };
            let heads = draws(PoseFamily::LieUp, 30, &hints);
            heads.iter().map(|sample| posed(sample).joints[joints::HEAD].y).sum::<f32>() / 30.0
        };
        let (flat, lifted) = (head_m(None), head_m(Some(0.18)));
        assert!(lifted > flat + 0.06, "{flat} m without, {lifted} m with a pillow of 18 cm");
    }

    #[test]
    fn nobody_lays_an_arm_along_a_back_that_is_far_behind() {
        let hints = FamilyHints { seat_behind_m: Some(0.5), ..FamilyHints::default() };
        for sample in draws(PoseFamily::SitSofa, 80, &hints) {
            let joints = posed(&sample).joints;
            for (shoulder, wrist) in [
                (joints::LEFT_SHOULDER, LEFT_WRIST),
                (joints::mirror(joints::LEFT_SHOULDER), joints::mirror(LEFT_WRIST)),
            ] {
                let out = (joints[wrist] - joints[shoulder]).x.abs();
                let level = (joints[wrist] - joints[shoulder]).y > -0.15;
                assert!(!(level && out > 0.3), "an arm is held out to the side");
            }
        }
    }

    #[test]
    fn people_lie_on_what_their_family_says_with_the_head_towards_minus_z() {
        let body = Body::bundled();
        for (family, below) in [(PoseFamily::LieUp, Region::Back), (PoseFamily::LieDown, Region::Front)] {
            for sample in draws(family, 10, &FamilyHints::default()) {
                let person = posed(&sample);
                let ids = body.regions.sample(below);
                let mean = ids.iter().map(|v| person.vertices[*v as usize].y).sum::<f32>() / ids.len() as f32;
                assert!(mean < -0.02, "{}: {mean}", family.label());
                assert!(person.joints[joints::HEAD].z < -0.4);
            }
        }
    }

    #[test]
    fn standing_people_have_both_feet_flat_on_one_floor() {
        for sample in draws(PoseFamily::Stand, 30, &FamilyHints::default()) {
            let person = posed(&sample);
            let (left, right) = (person.joints[LEFT_ANKLE], person.joints[RIGHT_ANKLE]);
            assert!((left.y - right.y).abs() < 0.03 && left.y < -0.8, "{left} {right}");
        }
    }

    #[test]
    fn seated_hands_rest_on_something_of_the_body_or_near_it() {
        let hints = FamilyHints { seat_height_m: Some(0.45), ..FamilyHints::default() };
        let people = draws(PoseFamily::SitChair, 60, &hints);
        let near = people.iter().filter(|sample| {
            let joints = posed(sample).joints;
            let (hip, knee) = (joints[LEFT_HIP], joints[LEFT_KNEE]);
            let along =
                ((joints[LEFT_WRIST] - hip).dot(knee - hip) / (knee - hip).length_squared()).clamp(0.0, 1.0);
            joints[LEFT_WRIST].distance(hip.lerp(knee, along)) < 0.17
        });
        assert!(near.count() > 30, "most hands of people on chairs rest on the thighs or in the lap");
    }

    #[test]
    fn two_people_on_one_sofa_are_not_clones_and_the_same_seed_gives_the_same_person() {
        let first = draws(PoseFamily::SitSofa, 12, &FamilyHints::default());
        assert_eq!(first, draws(PoseFamily::SitSofa, 12, &FamilyHints::default()));
        for (i, a) in first.iter().enumerate() {
            for b in &first[..i] {
                let apart: f32 = a.pose.iter().zip(&b.pose).map(|(a, b)| a.distance(*b)).sum();
                assert!(apart > 0.8, "{apart} radians of difference over all joints");
            }
        }
    }

    #[test]
    fn the_pose_space_holds_every_family_within_four_degrees_a_joint() {
        let body = Body::bundled();
        for family in PoseFamily::ALL {
            let (mut degrees, mut squared) = (0.0, 0.0);
            for sample in draws(family, 40, &FamilyHints::default()) {
                let code = body.pose_space.encode(&sample.pose);
                let back = body.pose_space.decode(&code);
                let error: f32 = back.iter().zip(&sample.pose).map(|(a, b)| a.distance(*b)).sum();
                degrees += error.to_degrees() / 21.0 / 40.0;
                squared += 2.0 * body.pose_space.prior_energy(&code) / 40.0;
            }
            assert!(degrees < 4.0, "{}: {degrees} degrees", family.label());
            assert!(squared < 64.0, "{}: |code|² of {squared}, 32 is the prior's mean", family.label());
        }
    }
}
