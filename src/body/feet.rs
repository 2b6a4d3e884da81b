//! Where feet tread: heel, ball and toe tip of each sole, as points carried by ankle and ball joint. What stands
//! still while a foot is planted is one of them, whichever the foot rolls over.

use glam::{Mat3, Quat, Vec3};

use super::joints::{self, JOINTS};
use super::posed::Body;
use super::regions::Region;
use crate::scene::BETAS;

/// Points of one sole: heel, ball, toe tip.
pub const TREADS: usize = 3;

/// The ball's height is that of the lowest skin this near to it, metres.
const BALL_REACH_M: f32 = 0.03;

#[derive(Clone, Copy, Debug, PartialEq)]
struct Tread {
    joint: usize,
    /// From the joint, in its frame at rest, metres.
    offset: Vec3,
}

/// The treads and soles of both feet of one body shape, left then right.
#[derive(Clone, Debug, PartialEq)]
pub struct Feet {
    rest: [Vec3; JOINTS],
    treads: [[Tread; TREADS]; 2],
    soles: [Vec<Tread>; 2],
}

/// One foot as a rigid body with toes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FootPose {
    /// Place of the ankle joint, metres.
    pub ankle: Vec3,
    /// World rotation of the ankle joint.
    pub foot: Quat,
    /// World rotation of the ball joint, which carries the toes.
    pub toes: Quat,
}

/// Ankle and ball joint of the left and the right foot.
const CARRIERS: [[usize; 2]; 2] =
    [[joints::LEFT_ANKLE, joints::LEFT_FOOT], [joints::RIGHT_ANKLE, joints::RIGHT_FOOT]];

impl Feet {
    /// Of a body of shape `betas`.
    pub fn of(body: &Body, betas: &[f32; BETAS]) -> Self {
        let rest = body.model.rest_joints(betas);
        let soles = [Region::LeftLeg, Region::RightLeg].map(|region| sole_at_rest(body, region, betas));
        let treads = std::array::from_fn(|side| treads(&soles[side], &rest, CARRIERS[side]));
        let soles = std::array::from_fn(|side| {
            let [ankle, ball] = CARRIERS[side];
            let carried = |p: &Vec3| if p.z > rest[ball].z { ball } else { ankle };
            soles[side].iter().map(|p| Tread { joint: carried(p), offset: *p - rest[carried(p)] }).collect()
        });
        Self { rest, treads, soles }
    }

    /// Heel, ball and toe tip of the left and the right foot of a posed body, world frame, metres.
    pub fn positions(&self, joints: &[Vec3; JOINTS], rotations: &[Mat3; JOINTS]) -> [[Vec3; TREADS]; 2] {
        self.treads.map(|foot| foot.map(|t| joints[t.joint] + rotations[t.joint] * t.offset))
    }

    /// Heel, ball and toe tip of foot `side` (0 left, 1 right), world frame, metres.
    pub fn treads(&self, side: usize, pose: &FootPose) -> [Vec3; TREADS] {
        self.treads[side].map(|t| self.place(side, pose, &t))
    }

    /// Points all over the sole of foot `side`, world frame, metres.
    pub fn sole(&self, side: usize, pose: &FootPose) -> impl Iterator<Item = Vec3> {
        self.soles[side].iter().map(move |t| self.place(side, pose, t))
    }

    /// Place of the ball joint of foot `side`, metres.
    pub fn ball(&self, side: usize, pose: &FootPose) -> Vec3 {
        let [ankle, ball] = CARRIERS[side];
        pose.ankle + pose.foot * (self.rest[ball] - self.rest[ankle])
    }

    fn place(&self, side: usize, pose: &FootPose, tread: &Tread) -> Vec3 {
        if tread.joint == CARRIERS[side][0] {
            pose.ankle + pose.foot * tread.offset
        } else {
            self.ball(side, pose) + pose.toes * tread.offset
        }
    }
}

fn sole_at_rest(body: &Body, region: Region, betas: &[f32; BETAS]) -> Vec<Vec3> {
    let model = &body.model;
    let at_rest = |v: usize| {
        let shaped = model.shape_dirs[v].iter().zip(betas).map(|(dir, beta)| *dir * *beta).sum::<Vec3>();
        model.template[v] + shaped
    };
    body.regions.sample(region).iter().map(|v| at_rest(*v as usize)).collect()
}

fn treads(sole: &[Vec3], rest: &[Vec3; JOINTS], [ankle, ball]: [usize; 2]) -> [Tread; TREADS] {
    let by_z = |a: &&Vec3, b: &&Vec3| a.z.total_cmp(&b.z);
    let heel = sole.iter().min_by(by_z).copied().unwrap_or(rest[ankle]);
    let toe = sole.iter().max_by(by_z).copied().unwrap_or(rest[ball]);
    let near = |p: &&Vec3| (**p - rest[ball]).with_y(0.0).length() < BALL_REACH_M;
    let lowest = sole.iter().filter(near).map(|p| p.y).fold(rest[ball].y, f32::min);
    let tread = |joint: usize, at: Vec3| Tread { joint, offset: at - rest[joint] };
    [tread(ankle, heel), tread(ankle, rest[ball].with_y(lowest)), tread(ball, toe)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::BodyParams;

    #[test]
    fn a_standing_body_treads_on_heel_ball_and_toes_at_one_height() {
        let body = Body::bundled();
        let posed = body.pose_axis_angles(&BodyParams::default(), &[Vec3::ZERO; joints::BODY_JOINTS]);
        let lowest = posed.vertices.iter().map(|v| v.y).fold(f32::INFINITY, f32::min);
        for foot in Feet::of(body, &[0.0; BETAS]).positions(&posed.joints, &posed.rotations) {
            let [heel, ball, toe] = foot;
            assert!(heel.z + 0.1 < ball.z && ball.z + 0.03 < toe.z, "{foot:?}");
            assert!(foot.iter().all(|p| (-0.01..0.04).contains(&(p.y - lowest))), "{foot:?} over {lowest}");
        }
    }
}
