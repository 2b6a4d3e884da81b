//! Where feet tread: heel, ball and toe tip of each sole, as points carried by ankle and ball joint. What stands
//! still while a foot is planted is one of them, whichever the foot rolls over.

use glam::{Mat3, Vec3};

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

/// The treads of both feet of one body shape, left then right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Feet {
    treads: [[Tread; TREADS]; 2],
}

impl Feet {
    /// Of a body of shape `betas`.
    pub fn of(body: &Body, betas: &[f32; BETAS]) -> Self {
        let rest = body.model.rest_joints(betas);
        let sides = [
            (Region::LeftLeg, joints::LEFT_ANKLE, joints::LEFT_FOOT),
            (Region::RightLeg, joints::RIGHT_ANKLE, joints::RIGHT_FOOT),
        ];
        Self { treads: sides.map(|(sole, ankle, ball)| treads(&sole_at_rest(body, sole, betas), &rest, ankle, ball)) }
    }

    /// Heel, ball and toe tip of the left and the right foot of a posed body, world frame, metres.
    pub fn positions(&self, joints: &[Vec3; JOINTS], rotations: &[Mat3; JOINTS]) -> [[Vec3; TREADS]; 2] {
        self.treads.map(|foot| foot.map(|t| joints[t.joint] + rotations[t.joint] * t.offset))
    }

    /// Heel, ball and toe tip of foot `side` (0 left, 1 right) when its ankle stands at `ankle` and ankle and ball
    /// joint are turned by `rotations`; world frame, metres.
    pub fn around_ankle(&self, side: usize, ankle: Vec3, rest: &[Vec3; JOINTS], rotations: [Mat3; 2]) -> [Vec3; TREADS] {
        let [heel, _, toe] = self.treads[side];
        let ball_joint = ankle + rotations[0] * (rest[toe.joint] - rest[heel.joint]);
        self.treads[side].map(|t| match t.joint == heel.joint {
            true => ankle + rotations[0] * t.offset,
            false => ball_joint + rotations[1] * t.offset,
        })
    }

    /// The joint that carries tread `index` of foot `side`, and the tread's place in that joint's frame, metres.
    pub fn carrier(&self, side: usize, index: usize) -> (usize, Vec3) {
        let tread = self.treads[side][index];
        (tread.joint, tread.offset)
    }
}

fn sole_at_rest(body: &Body, region: Region, betas: &[f32; BETAS]) -> Vec<Vec3> {
    let model = &body.model;
    let at_rest = |v: usize| {
        let shaped = model.shape_dirs[v].iter().zip(betas).map(|(dir, beta)| *dir * *beta).sum::<Vec3>();
        model.template[v] + shaped
    };
    body.regions.vertices(region).iter().map(|v| at_rest(*v as usize)).collect()
}

fn treads(sole: &[Vec3], rest: &[Vec3; JOINTS], ankle: usize, ball: usize) -> [Tread; TREADS] {
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
        let posed = body.pose(&BodyParams::default());
        let lowest = posed.vertices.iter().map(|v| v.y).fold(f32::INFINITY, f32::min);
        let posed = body.pose_axis_angles(&BodyParams::default(), &[Vec3::ZERO; joints::BODY_JOINTS]);
        for foot in Feet::of(body, &[0.0; BETAS]).positions(&posed.joints, &posed.rotations) {
            let [heel, ball, toe] = foot;
            assert!(heel.z + 0.1 < ball.z && ball.z + 0.03 < toe.z, "{foot:?}");
            assert!(foot.iter().all(|p| (-0.01..0.04).contains(&(p.y - lowest))), "{foot:?} over {lowest}");
        }
    }
}
