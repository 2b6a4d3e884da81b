//! Pose families as distributions: what people's joints do when they stand, lean, sit and lie.
//!
//! A sample is built on a jointed figure of the mean body: torso and legs by angles drawn from ranges of
//! biomechanics, arms by what the hands do (two-bone inverse kinematics), then checked for limbs inside each
//! other and drawn again if they are. The same stream of random numbers gives the same pose.

mod arms;
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

pub(in crate::body) use chance::Chance;
use figure::{Figure, Side};

/// What the place says about the pose; `None` leaves it to the family.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FamilyHints {
    /// Seat above the floor that the feet reach for.
    pub seat_height_m: Option<f32>,
    /// Armrests above the seat.
    pub armrest_above_seat_m: Option<f32>,
    /// Table (sitting) or counter (leaning) in front, above the floor.
    pub table_height_m: Option<f32>,
    /// From the pelvis forward to where hands lie on that table or counter.
    pub table_reach_m: Option<f32>,
    /// How a leaning person leans; drawn when not said.
    pub lean: Option<LeanStyle>,
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
        PoseFamily::LieUp => lie::face_up(&mut figure, rng),
        PoseFamily::LieDown => lie::face_down(&mut figure, rng),
        PoseFamily::LieSide => lie::on_side(&mut figure, rng),
    };
    // People are not left-handed alike: half of all poses are mirrored.
    if rng.chance(0.5) { (figure.mirrored(), [hands[1], hands[0]]) } else { (figure, hands) }
}

/// Places both arms, left first.
fn place_arms(figure: &mut Figure, goals: [arms::ArmGoal; 2], rng: &mut impl Chance) -> [HandShape; 2] {
    let left = arms::place(figure, Side::Left, goals[0], rng);
    [left, arms::place(figure, Side::Right, goals[1], rng)]
}
