//! The person of an action before anybody fits them: a representative pose, where its centre is, and balls along its
//! bones for what must keep clear of it.

use std::sync::LazyLock;

use glam::{Affine3A, Mat3, Vec3};

use super::world::Ball;
use crate::body::{Body, FamilyHints, Region, joints, sample_pose};
use crate::evolve::action::PersonFrame;
use crate::fit::{BoneSphere, Limb, bone_spheres};
use crate::job::Rng;
use crate::scene::{BETAS, BodyParams, PoseFamily};

/// Balls are this much thinner than the flesh where they are tested against furniture: cushions and clothes give way.
const SOFT: f32 = 0.75;

/// A posed body with the pelvis joint at the origin, facing +z (lying: the person's front, [`PersonFrame`]).
#[derive(Clone, Debug)]
pub struct Figure {
    /// What it does.
    pub family: PoseFamily,
    /// The pose, pelvis joint at the origin.
    pub params: BodyParams,
    /// Torso, legs, head and upper arms; forearms and hands lie on what people use.
    trunk: Vec<Ball>,
    /// Middle of the torso.
    centre: Vec3,
    /// Lowest point of what the person rests on: the seat of the trousers, the soles, the back.
    low_m: f32,
    /// Where the soles are.
    soles_m: f32,
}

/// Where somebody does something.
#[derive(Clone, Debug)]
pub struct Spot {
    /// The pelvis joint, world.
    pub pelvis: Vec3,
    /// Which way the person's front looks, radians about +Y.
    pub facing_rad: f32,
}

impl Figure {
    /// Draws a person of a family.
    pub fn draw(body: &Body, family: PoseFamily, hints: &FamilyHints, rng: &mut Rng) -> Self {
        let sample = sample_pose(&body.model.joint_template, family, rng, hints);
        let betas = [0.0; BETAS];
        let mut params = sample.params(body, betas, &Mat3::IDENTITY);
        params.translation = -body.model.rest_joints(&betas)[joints::PELVIS];
        let frame = PersonFrame::of_joints(body.joints(&params).as_slice());
        params = turned(&params, -frame.facing_rad, &body.model.rest_joints(&betas)[joints::PELVIS]);
        let posed = body.pose(&params);
        let lowest = |region: Region| {
            let heights = body.regions.sample(region).iter().map(|v| posed.vertices[*v as usize].y);
            heights.fold(f32::INFINITY, f32::min)
        };
        let soles_m = lowest(Region::LeftLeg).min(lowest(Region::RightLeg));
        let low_m = match family.group() {
            "sit" => lowest(Region::Butt),
            "lie" => posed.vertices.iter().map(|v| v.y).fold(f32::INFINITY, f32::min),
            _ => soles_m,
        };
        let is_trunk = |bone: &BoneSphere| !matches!(bone.limb, Limb::LeftArm | Limb::RightArm);
        let ball = |bone: &BoneSphere| (bone.center(&posed.joints), bone.radius_m);
        let trunk = bones().iter().filter(|b| is_trunk(b)).map(ball).collect();
        let centre = PersonFrame::of_joints(posed.joints.as_slice()).centre_m;
        Self { family, params, trunk, centre, low_m, soles_m }
    }

    /// The pelvis joint's height over what the person rests on.
    pub fn pelvis_over_rest_m(&self) -> f32 {
        -self.low_m
    }

    /// The pelvis joint's height over the soles.
    pub fn pelvis_over_soles_m(&self) -> f32 {
        -self.soles_m
    }

    /// The body's parameters there.
    pub fn params_at(&self, spot: &Spot, body: &Body) -> BodyParams {
        let rest = body.model.rest_joints(&self.params.betas)[joints::PELVIS];
        let mut params = turned(&self.params, spot.facing_rad, &rest);
        params.translation += spot.pelvis;
        params
    }

    /// Torso, head and legs there.
    pub fn trunk_at(&self, spot: &Spot) -> Vec<Ball> {
        let place = placed(spot);
        self.trunk.iter().map(|(at, r)| (place.transform_point3(*at), *r)).collect()
    }

    /// The same, thinner: what must not be inside furniture.
    pub fn core_at(&self, spot: &Spot) -> Vec<Ball> {
        self.trunk_at(spot).into_iter().map(|(at, r)| (at, r * SOFT)).collect()
    }

    /// The frame of the learned layouts there.
    pub fn frame_at(&self, spot: &Spot) -> PersonFrame {
        PersonFrame { centre_m: placed(spot).transform_point3(self.centre), facing_rad: spot.facing_rad }
    }
}

/// Balls along the bones of the bundled body.
fn bones() -> &'static [BoneSphere] {
    static BONES: LazyLock<Vec<BoneSphere>> = LazyLock::new(|| bone_spheres(Body::bundled()));
    &BONES
}

fn placed(spot: &Spot) -> Affine3A {
    Affine3A::from_translation(spot.pelvis) * Affine3A::from_rotation_y(spot.facing_rad)
}

/// A body whose pelvis joint is at the origin, turned about it.
fn turned(params: &BodyParams, yaw_rad: f32, rest: &Vec3) -> BodyParams {
    let mut params = params.clone();
    params.set_rotation(&(Mat3::from_rotation_y(yaw_rad) * params.rotation()));
    params.translation = -*rest;
    params
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::Seed;

    #[test]
    fn a_figure_stands_sits_and_lies_where_it_is_put_and_faces_where_it_is_told() {
        let body = Body::bundled();
        for family in [PoseFamily::Stand, PoseFamily::SitChair, PoseFamily::LieUp, PoseFamily::LieDown] {
            let figure = Figure::draw(body, family, &FamilyHints::default(), &mut Seed::root(3).rng());
            let spot = Spot { pelvis: Vec3::new(1.0, figure.pelvis_over_rest_m(), -2.0), facing_rad: 0.8 };
            let params = figure.params_at(&spot, body);
            let posed = body.pose(&params);
            assert!(posed.joints[joints::PELVIS].distance(spot.pelvis) < 1e-4, "{}", family.label());
            let frame = PersonFrame::of_joints(posed.joints.as_slice());
            assert!((frame.facing_rad - 0.8).abs() < 0.02, "{}: {}", family.label(), frame.facing_rad);
            assert!(frame.centre_m.distance(figure.frame_at(&spot).centre_m) < 1e-3);
            let lowest = posed.vertices.iter().map(|v| v.y).fold(f32::INFINITY, f32::min);
            if family.group() != "sit" {
                assert!(lowest.abs() < 0.02, "{} stands at {lowest}", family.label());
            }
        }
    }
}
