//! Where one stands before sitting down: in front of the seat with the feet where they stay, else beside it.

use glam::{Vec2, Vec3};

use super::{Planner, Spot, flat};
use crate::motion::leg::FootPlace;
use crate::scene::direction_of;

/// Steps forward tried where there is no room right before the seat, metres.
const AHEAD_M: [f32; 3] = [0.0, 0.1, 0.2];
/// Places tried beside the seat: forward and sideways from the pelvis, metres.
const BESIDE_M: [(f32, f32); 6] =
    [(0.3, 0.42), (0.2, 0.5), (0.35, 0.55), (0.1, 0.55), (0.0, 0.5), (0.0, 0.65)];
/// Somebody who stands before a seat with the calves at it needs this much on each side, metres.
const STANDING_M: f32 = 0.1;
/// Between the standing and the sitting chest nothing may be nearer than this, metres.
const CHEST_M: f32 = 0.06;
/// Height of the chest of somebody who sits down, over the seat, metres.
const CHEST_OVER_SEAT_M: f32 = 0.35;

/// Armrests rise above the thighs, whose top is so much above the seated pelvis joint, metres.
const HIPS_OVER_PELVIS_M: f32 = 0.05;
/// Getting in over an armrest is worth this much less room, metres.
const OVER_ARM_M: f32 = 10.0;

/// A seated body as the planner sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seated {
    /// Its pelvis joint, metres, world frame.
    pub pelvis: Vec3,
    /// Which way it faces, radians about +Y.
    pub facing: f32,
    /// Where its feet are, left then right, on the floor below the ankles.
    pub feet: [FootPlace; 2],
}

/// Where one stands relative to a seat.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// In front, the feet where they stay when one sits down.
    Front,
    /// A step in front.
    Ahead,
    /// At the sitter's left.
    Left,
    /// At the sitter's right.
    Right,
}

/// A place to stand before sitting down and after getting up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stance {
    /// Point of the floor below the pelvis, metres, world frame.
    pub at: Vec3,
    /// Which way one faces, radians about +Y.
    pub facing: f32,
    /// On which side of the seat.
    pub side: Side,
    /// The feet, where the seated body already says where they are.
    pub feet: Option<[FootPlace; 2]>,
}

impl Stance {
    /// The stance as an end of ways.
    pub fn spot(&self) -> Spot {
        Spot { at: flat(self.at), heading: None, beside: true }
    }
}

/// Every place to stand before the seat, the best first: in front, a step further, at the sides. Whether one can get
/// there is another question.
pub fn stances(planner: &Planner<'_>, seated: &Seated) -> Vec<Stance> {
    let ahead = direction_of(seated.facing);
    let left = direction_of(seated.facing + std::f32::consts::FRAC_PI_2);
    let feet = 0.5 * (flat(seated.feet[0].at) + flat(seated.feet[1].at));
    let stance = |at: Vec2, side: Side, feet: Option<[FootPlace; 2]>| {
        let free = planner.floor().clearance_at(at) >= STANDING_M && is_open(planner, at, seated.pelvis);
        free.then(|| Stance { at: planner.on_floor(at), facing: seated.facing, side, feet })
    };
    let mut found: Vec<Stance> = Vec::new();
    for step_m in AHEAD_M {
        let side = if step_m == 0.0 { Side::Front } else { Side::Ahead };
        found.extend(stance(feet + ahead * step_m, side, (step_m == 0.0).then_some(seated.feet)));
    }
    for (forward_m, aside_m) in BESIDE_M {
        let beside = |sign: f32| flat(seated.pelvis) + ahead * forward_m + left * (sign * aside_m);
        let pair =
            [(1.0, Side::Left), (-1.0, Side::Right)].map(|(sign, side)| stance(beside(sign), side, None));
        // The side without an armrest, then the roomier one, first.
        let room = |s: &Stance| {
            let over_arm = if is_level(planner, flat(s.at), seated.pelvis) { 0.0 } else { OVER_ARM_M };
            planner.floor().clearance_at(flat(s.at)) - over_arm
        };
        let mut pair: Vec<Stance> = pair.into_iter().flatten().collect();
        pair.sort_by(|a, b| room(b).total_cmp(&room(a)));
        found.extend(pair);
    }
    found
}

/// Whether the hips pass from the side of a seat onto it without an armrest in the way.
fn is_level(planner: &Planner<'_>, standing: Vec2, pelvis: Vec3) -> bool {
    (1..=6).all(|i| {
        let p = standing.lerp(flat(pelvis), i as f32 / 6.0 * 0.8);
        planner.geometry().field.sample(Vec3::new(p.x, pelvis.y + HIPS_OVER_PELVIS_M, p.y)) > 0.0
    })
}

/// Whether the chest passes from standing to sitting without going through something as high as a wall.
fn is_open(planner: &Planner<'_>, standing: Vec2, pelvis: Vec3) -> bool {
    let height_m = pelvis.y + CHEST_OVER_SEAT_M;
    (0..=6).all(|i| {
        let p = standing.lerp(flat(pelvis), i as f32 / 6.0 * 0.8);
        planner.geometry().field.sample(Vec3::new(p.x, height_m, p.y)) > CHEST_M
    })
}
