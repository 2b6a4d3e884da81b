//! The body as gait sees it: a trunk that is placed, arms that are turned, and feet that stand somewhere; legs follow
//! by inverse kinematics.

use glam::{Quat, Vec3};

use crate::body::joints::{self as j, JOINTS};
use crate::body::{Body, BodyPose, FrameJoints, Limb};
use crate::scene::{BETAS, Frame, HANDS, direction_of, facing_of};

use super::model::GaitModel;

/// The body that walks: its proportions.
pub(super) struct Person {
    pub(super) rest: [Vec3; JOINTS],
    /// Hip to knee to ankle, metres.
    pub(super) leg_m: f32,
    pub(super) feet: [FootShape; 2],
    pub(super) model: &'static GaitModel,
}

/// Where a foot touches the floor, in the ankle's rest frame: metres from the ankle joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FootShape {
    /// What the foot rolls about when its toes are up.
    pub(super) heel: Vec3,
    /// The joint of the toes, which it rolls about when its heel is up: the toes under it stay.
    pub(super) ball: Vec3,
    /// The foremost point of the sole.
    pub(super) toe: Vec3,
}

impl FootShape {
    /// Ankle joint above the sole.
    pub(super) fn ankle_m(&self) -> f32 {
        -self.heel.y
    }

    /// Height of the lowest point of the sole, metres.
    pub(super) fn lowest_y(&self, pose: &FootPose) -> f32 {
        let toe = self.ball + pose.toes * (self.toe - self.ball);
        let under_ball = self.ball.with_y(self.heel.y);
        [self.heel, under_ball, toe].map(|p| pose.point(p).y).into_iter().fold(f32::MAX, f32::min)
    }

    fn of(body: &Body, betas: &[f32; BETAS], rest: &[Vec3; JOINTS], ankle: usize) -> Self {
        let model = &body.model;
        let is_foot =
            |v: &usize| matches!(model.dominant_joint(*v), joint if joint == ankle || joint == ankle + 3);
        let shaped = |v: usize| {
            let moved = model.shape_dirs[v].iter().zip(betas).map(|(dir, beta)| *dir * *beta).sum::<Vec3>();
            model.template[v] + moved - rest[ankle]
        };
        let skin: Vec<Vec3> = (0..model.template.len()).filter(is_foot).map(shaped).collect();
        let sole = skin.iter().map(|v| v.y).fold(0.0, f32::min);
        let near = skin.iter().filter(|v| v.y < sole + SOLE_M);
        let (back, front) = near.fold((0.0f32, 0.0f32), |(back, front), v| (back.min(v.z), front.max(v.z)));
        Self {
            heel: Vec3::new(0.0, sole, back),
            ball: rest[ankle + 3] - rest[ankle],
            toe: Vec3::new(0.0, sole, front),
        }
    }
}

/// Skin this near to the lowest point belongs to the sole.
const SOLE_M: f32 = 0.012;

impl Person {
    pub(super) fn new(body: &Body, betas: &[f32; BETAS]) -> Self {
        let rest = body.model.rest_joints(betas);
        let [thigh, shank] = Limb::LEGS[0].bones_m(&rest);
        Self {
            rest,
            leg_m: thigh + shank,
            feet: [j::LEFT_ANKLE, j::RIGHT_ANKLE].map(|ankle| FootShape::of(body, betas, &rest, ankle)),
            model: GaitModel::bundled(),
        }
    }

    /// Hip joints apart, metres.
    pub(super) fn hips_m(&self) -> f32 {
        self.rest[j::LEFT_HIP].distance(self.rest[j::RIGHT_HIP])
    }

    /// Pelvis before the middle between the flat ankles when a foot lands, metres: midway between what both feet then
    /// touch the floor with, the ball behind and the heel ahead.
    pub(super) fn lead_m(&self) -> f32 {
        0.5 * (self.feet[0].ball.z + self.feet[0].heel.z)
    }

    /// Pelvis joint above the hip joints, metres.
    pub(super) fn pelvis_above_hips_m(&self) -> f32 {
        self.rest[j::PELVIS].y - self.rest[j::LEFT_HIP].y
    }

    /// Ankle joint of a flat foot above the floor, metres.
    pub(super) fn ankle_m(&self) -> f32 {
        self.feet[0].ankle_m()
    }
}

/// A turn about the vertical.
pub(super) fn yaw(heading: f32) -> Quat {
    Quat::from_rotation_y(heading)
}

/// The horizontal unit vector of a heading.
pub(super) fn ahead(heading: f32) -> Vec3 {
    let d = direction_of(heading);
    Vec3::new(d.x, 0.0, d.y)
}

/// Which way a rotation faces, radians about +Y: where its front points, or, for somebody who lies, where the front
/// would point if the feet were put to the floor.
pub(super) fn facing(rotation: Quat) -> f32 {
    let front = rotation * Vec3::Z;
    let down = rotation * Vec3::NEG_Y;
    let level = if front.y.abs() < 0.8 { front } else { down * front.y.signum() };
    facing_of(glam::Vec2::new(level.x, level.z))
}

/// An angle within half a turn of zero.
pub(super) fn wrap(angle: f32) -> f32 {
    use std::f32::consts::{PI, TAU};
    (angle + PI).rem_euclid(TAU) - PI
}

/// The part of a rotation about the vertical taken out: what remains when it faces +Z.
pub(super) fn tilt(rotation: Quat) -> Quat {
    (yaw(facing(rotation)).inverse() * rotation).normalize()
}

/// A foot in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FootPose {
    /// Ankle joint, metres, world frame.
    pub(super) ankle: Vec3,
    /// World from the foot's rest frame.
    pub(super) rotation: Quat,
    /// Turn of the toes in the foot's frame.
    pub(super) toes: Quat,
}

impl FootPose {
    /// Between two poses, the ankle on the straight line.
    pub(super) fn lerp(&self, other: &Self, share: f32) -> Self {
        Self {
            ankle: self.ankle.lerp(other.ankle, share),
            rotation: self.rotation.slerp(near(self.rotation, other.rotation), share),
            toes: self.toes.slerp(near(self.toes, other.toes), share),
        }
    }

    /// A flat foot at a point of the floor.
    pub(super) fn flat(shape: &FootShape, floor: Vec3, heading: f32) -> Self {
        Self { ankle: floor + Vec3::Y * shape.ankle_m(), rotation: yaw(heading), toes: Quat::IDENTITY }
    }

    /// Which way the toes point.
    pub(super) fn heading(&self) -> f32 {
        facing(self.rotation)
    }

    /// Radians by which the sole is off the level.
    pub(super) fn tilt(&self) -> f32 {
        (self.rotation * Vec3::Y).angle_between(Vec3::Y)
    }

    /// A point of the foot given in the ankle's rest frame.
    pub(super) fn point(&self, in_foot: Vec3) -> Vec3 {
        self.ankle + self.rotation * in_foot
    }
}

/// The one of `±q` that is on the side of `to`.
pub(super) fn near(to: Quat, q: Quat) -> Quat {
    if to.dot(q) < 0.0 { -q } else { q }
}

/// A pose as gait works on it. [`Stick::of`] and [`Stick::frame`] are inverse to each other.
#[derive(Clone, Debug)]
pub(super) struct Stick {
    /// Pelvis joint, world frame.
    pub(super) pelvis: Vec3,
    /// World from body.
    pub(super) rotation: Quat,
    /// Turns of joints 1 to 21 in their parents' frames; those of the legs are not used.
    pub(super) turns: [Quat; 21],
    pub(super) feet: [FootPose; 2],
    /// Where the knees point, in the pelvis's frame.
    pub(super) poles: [Vec3; 2],
    /// What thighs and shanks turn beyond their hinges.
    pub(super) twists: [[Quat; 2]; 2],
    pub(super) hands: [f32; HANDS],
}

impl Stick {
    /// Reads a frame.
    pub(super) fn of(person: &Person, frame: &Frame) -> Self {
        let posed = FrameJoints::of(&person.rest, frame);
        let foot = |side: usize| {
            let limb = &Limb::LEGS[side];
            FootPose {
                ankle: posed.positions[limb.end],
                rotation: posed.rotations[limb.end],
                toes: Quat::from_scaled_axis(frame.pose[limb.end + 2]),
            }
        };
        let mut stick = Self {
            pelvis: posed.positions[0],
            rotation: frame.rotation,
            turns: frame.pose.map(Quat::from_scaled_axis),
            feet: [foot(0), foot(1)],
            poles: [Vec3::Z; 2],
            twists: [[Quat::IDENTITY; 2]; 2],
            hands: frame.hands,
        };
        for side in 0..2 {
            let limb = &Limb::LEGS[side];
            // A knee that is pressed through still counts as pointing ahead: what is left goes to the twists.
            let natural = posed.rotations[limb.upper] * Vec3::Z;
            let pole = posed.pole(limb).filter(|p| p.dot(natural) > 0.0).unwrap_or(natural);
            stick.poles[side] = frame.rotation.inverse() * pole;
            let bent = stick.legs(person);
            stick.twists[side] = [limb.upper, limb.lower]
                .map(|joint| (bent.rotations[joint].inverse() * posed.rotations[joint]).normalize());
        }
        stick
    }

    /// Joints with legs bent to the feet, before the twists.
    fn legs(&self, person: &Person) -> FrameJoints {
        let frame = Frame {
            translation: self.pelvis - person.rest[0],
            rotation: self.rotation,
            pose: self.turns.map(Quat::to_scaled_axis),
            hands: self.hands,
        };
        let mut posed = FrameJoints::of(&person.rest, &frame);
        for side in 0..2 {
            let foot = &self.feet[side];
            let pole = self.rotation * self.poles[side];
            posed.reach(&person.rest, &Limb::LEGS[side], foot.ankle, foot.rotation, pole);
        }
        posed
    }

    /// The frame of this pose.
    pub(super) fn frame(&self, person: &Person) -> Frame {
        let mut posed = self.legs(person);
        for side in 0..2 {
            let limb = &Limb::LEGS[side];
            for (joint, twist) in [limb.upper, limb.lower].into_iter().zip(self.twists[side]) {
                posed.rotations[joint] = (posed.rotations[joint] * twist).normalize();
            }
            posed.rotations[limb.end + 3] = posed.rotations[limb.end] * self.feet[side].toes;
        }
        Frame {
            translation: self.pelvis - person.rest[0],
            rotation: self.rotation.normalize(),
            pose: self.pose(&posed),
            hands: self.hands,
        }
    }

    fn pose(&self, posed: &FrameJoints) -> BodyPose {
        let is_leg =
            |joint: usize| Limb::LEGS.iter().any(|l| [l.upper, l.lower, l.end, l.end + 3].contains(&joint));
        std::array::from_fn(|i| {
            if is_leg(i + 1) {
                posed.local(i + 1)
            } else {
                near(Quat::IDENTITY, self.turns[i]).to_scaled_axis()
            }
        })
    }

    /// Metres by which each hip is too high for its leg to reach its foot with `share` of its length.
    pub(super) fn overreach_m(&self, person: &Person, share: f32) -> [f32; 2] {
        std::array::from_fn(|side| {
            let hip = self.hip(person, side);
            let longest = person.leg_m * share;
            let to = self.feet[side].ankle - hip;
            let level = to.with_y(0.0).length_squared();
            // How far the hip has to come down for the leg to reach.
            let may = (longest * longest - level).max(0.0).sqrt();
            (-to.y - may).max(0.0)
        })
    }

    /// Keeps the knee of a swinging leg from snapping straight: a foot that is almost out of reach is drawn in by
    /// `weight` of what a smooth approach to the longest reach asks for.
    pub(super) fn soften(&mut self, person: &Person, side: usize, weight: f32) {
        let hip = self.hip(person, side);
        let to = self.feet[side].ankle - hip;
        let share = to.length() / person.leg_m;
        let over = share - SWING_SHARE[0];
        if over <= 0.0 || weight <= 0.0 {
            return;
        }
        let room = SWING_SHARE[1] - SWING_SHARE[0];
        let soft = SWING_SHARE[0] + room * (over / room).tanh();
        self.feet[side].ankle = hip + to * (1.0 + weight * (soft / share - 1.0));
    }

    /// Both knees, world frame.
    pub(super) fn knees(&self, person: &Person) -> [Vec3; 2] {
        let posed = self.legs(person);
        Limb::LEGS.map(|limb| posed.positions[limb.lower])
    }

    /// A hip joint, world frame.
    pub(super) fn hip(&self, person: &Person, side: usize) -> Vec3 {
        let limb = &Limb::LEGS[side];
        self.pelvis + self.rotation * (person.rest[limb.upper] - person.rest[0])
    }

    /// Between two poses; feet go straight.
    pub(super) fn lerp(&self, other: &Self, share: f32) -> Self {
        let q = |a: Quat, b: Quat| a.slerp(near(a, b), share);
        Self {
            pelvis: self.pelvis.lerp(other.pelvis, share),
            rotation: q(self.rotation, other.rotation),
            turns: std::array::from_fn(|i| q(self.turns[i], other.turns[i])),
            feet: std::array::from_fn(|i| self.feet[i].lerp(&other.feet[i], share)),
            poles: std::array::from_fn(|i| direction_between(self.poles[i], other.poles[i], share)),
            twists: std::array::from_fn(|i| {
                std::array::from_fn(|k| q(self.twists[i][k], other.twists[i][k]))
            }),
            hands: std::array::from_fn(|i| self.hands[i] + (other.hands[i] - self.hands[i]) * share),
        }
    }

    /// Brings a wrist to `target` by `weight`, the elbow towards `pole` (world frame), as far as the arm reaches; the
    /// hand keeps its turn in the forearm's frame.
    pub(super) fn reach_with_arm(
        &mut self,
        person: &Person,
        side: usize,
        target: Vec3,
        pole: Vec3,
        weight: f32,
    ) {
        if weight <= 0.0 {
            return;
        }
        let limb = &Limb::ARMS[side];
        let frame = Frame {
            translation: self.pelvis - person.rest[0],
            rotation: self.rotation,
            pose: self.turns.map(Quat::to_scaled_axis),
            hands: self.hands,
        };
        let mut posed = FrameJoints::of(&person.rest, &frame);
        posed.reach(&person.rest, limb, target, posed.rotations[limb.end], pole);
        for joint in [limb.upper, limb.lower] {
            let turned = near(self.turns[joint - 1], Quat::from_scaled_axis(posed.local(joint)));
            self.turns[joint - 1] = self.turns[joint - 1].slerp(turned, weight);
        }
    }
}

/// A swinging leg over its full length: freely stretched up to the first share, never beyond the second.
const SWING_SHARE: [f32; 2] = [0.94, 0.995];

/// A unit vector on the way from one to another.
pub(super) fn direction_between(a: Vec3, b: Vec3, share: f32) -> Vec3 {
    let turn = Quat::from_rotation_arc(a.normalize_or(Vec3::Z), b.normalize_or(Vec3::Z));
    Quat::IDENTITY.slerp(near(Quat::IDENTITY, turn), share) * a
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::{FamilyHints, sample_pose};
    use crate::scene::PoseFamily;
    use glam::Mat3;
    use rand::SeedableRng as _;

    #[test]
    fn every_pose_survives_being_read_and_written() {
        let body = Body::bundled();
        let betas = [0.3; BETAS];
        let person = Person::new(body, &betas);
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
        for family in PoseFamily::ALL {
            for _ in 0..20 {
                let sampled = sample_pose(&person.rest, family, &mut rng, &FamilyHints::default());
                let params = sampled.params(body, betas, &Mat3::from_rotation_y(2.0));
                let frame = Frame::of(&params, &body.pose_space.decode(&params.pose));
                let back = Stick::of(&person, &frame).frame(&person);
                let [a, b] = [&frame, &back].map(|f| FrameJoints::of(&person.rest, f));
                for joint in 0..22 {
                    let off = a.positions[joint].distance(b.positions[joint]);
                    assert!(off < 2e-3, "{} of {family:?} is {off} m off", j::NAMES[joint]);
                }
            }
        }
    }

    #[test]
    fn feet_touch_the_floor_with_their_soles() {
        let body = Body::bundled();
        let person = Person::new(body, &[0.0; BETAS]);
        let [left, right] = person.feet;
        assert!((left.ankle_m() - 0.0765).abs() < 2e-3 && (left.ankle_m() - right.ankle_m()).abs() < 1e-3);
        assert!(left.heel.z < -0.04 && left.ball.z > 0.1 && left.toe.z > left.ball.z + 0.03, "{left:?}");
    }
}
