//! The outline of one posed body around its pelvis, and what it costs to have it somewhere in a room.

use std::collections::BTreeSet;

use glam::{Mat3, Vec3};

use crate::body::joints::JOINTS;
use crate::body::{Body, Region, VertexSubset, Workspace};
use crate::fit::{BoneSphere, bone_spheres};
use crate::scene::{BodyParams, PoseFamily, SignedDistanceField};

/// Every so many vertices of the mesh stand for the skin.
const SKIN_STRIDE: usize = 32;
/// Every so many vertices of a contact region's sample ask for contact.
const ANCHOR_STRIDE: usize = 3;
/// A root mean square depth of this much over the skin costs 1, metres.
const DEPTH_M: f32 = 0.01;
/// A root mean square lack of room around the bones of this much costs 1, metres.
const LACK_M: f32 = 0.015;
/// A gap of this much under what the body rests on costs 1, metres.
const GAP_M: f32 = 0.04;
/// Dangling feet cost at most this much.
const DANGLING: f32 = 0.4;
/// Feet this far above everything dangle wholly, metres.
const DANGLING_M: f32 = 0.25;

/// Makes shapes of one body model; holds what can be found once.
pub struct Shaper<'a> {
    body: &'a Body,
    skin: VertexSubset,
    bones: Vec<BoneSphere>,
}

/// Points of one posed body relative to its pelvis joint.
#[derive(Clone, Debug)]
pub struct Shape {
    /// What it rests on, then soles, then the rest of the skin.
    points: Vec<Vec3>,
    /// Points before this one belong to what the body rests on.
    anchors: usize,
    /// Points from `anchors` to this one are soles, where these are not anchors.
    soles: usize,
    bones: Vec<(Vec3, f32)>,
    /// Height of the lowest anchor over the pelvis, negative, metres.
    pub lowest_m: f32,
}

impl<'a> Shaper<'a> {
    /// For bodies of this model.
    pub fn new(body: &'a Body) -> Self {
        let ids = (0..body.model.template.len() as u32).step_by(SKIN_STRIDE).collect();
        Self { body, skin: VertexSubset::new(&body.model, ids), bones: bone_spheres(body) }
    }

    /// Joints of a body, world frame.
    pub fn joints(&self, params: &BodyParams) -> [Vec3; JOINTS] {
        self.body.joints(params)
    }

    /// The shape of a body that rests as its family does.
    pub fn shape(&self, params: &BodyParams, family: PoseFamily) -> Shape {
        let mut workspace = Workspace::default();
        let [anchors, soles] = [anchor_regions(family), sole_regions(family)].map(|r| self.sparse(r));
        let ids: Vec<u32> = anchors.iter().chain(&soles).copied().collect();
        self.body.forward(params, &VertexSubset::new(&self.body.model, ids), &mut workspace);
        let pelvis = workspace.joints()[0];
        let mut points: Vec<Vec3> = workspace.vertices().iter().map(|v| *v - pelvis).collect();
        let lowest_m = points[..anchors.len()].iter().map(|p| p.y).fold(f32::INFINITY, f32::min);
        self.body.forward(params, &self.skin, &mut workspace);
        points.extend(workspace.vertices().iter().map(|v| *v - pelvis));
        let joints = workspace.joints();
        let bones = self.bones.iter().map(|b| (b.center(joints) - pelvis, b.radius_m)).collect();
        Shape { points, anchors: anchors.len(), soles: anchors.len() + soles.len(), bones, lowest_m }
    }

    fn sparse(&self, regions: &[Region]) -> Vec<u32> {
        let sample = |r: &Region| self.body.regions.sample(*r).iter().copied().step_by(ANCHOR_STRIDE);
        let unique: BTreeSet<u32> = regions.iter().flat_map(sample).collect();
        unique.into_iter().collect()
    }
}

/// What carries a body of the family.
fn anchor_regions(family: PoseFamily) -> &'static [Region] {
    match family.group() {
        "sit" => &[Region::Butt, Region::Thighs],
        "lie" => &[Region::Back, Region::Butt, Region::Front, Region::LeftSide, Region::RightSide],
        _ => &[Region::LeftLeg, Region::RightLeg],
    }
}

/// Feet that should find a floor besides.
fn sole_regions(family: PoseFamily) -> &'static [Region] {
    let hang = family.group() == "sit" && family != PoseFamily::SitStraight;
    if hang { &[Region::LeftLeg, Region::RightLeg] } else { &[] }
}

impl Shape {
    /// Writes this shape turned about the vertical into `turned`, a copy of it.
    pub fn turn_into(&self, yaw: f32, turned: &mut Self) {
        let turn = Mat3::from_rotation_y(yaw);
        turned.points.iter_mut().zip(&self.points).for_each(|(t, p)| *t = turn * *p);
        turned.bones.iter_mut().zip(&self.bones).for_each(|(t, b)| t.0 = turn * b.0);
    }

    /// Cost of the body with its pelvis here: skin in solid matter, bones too near to surfaces, a gap under what
    /// it rests on, dangling feet. Infinite once it is beyond `limit`.
    pub fn cost(&self, field: &SignedDistanceField, pelvis: Vec3, limit: f32) -> f32 {
        let lack = self.bones.iter().map(|(center, radius_m)| {
            let lack = (radius_m - field.sample(*center + pelvis)).max(0.0);
            lack * lack
        });
        let bones = (lack.sum::<f32>() / self.bones.len() as f32).sqrt() / LACK_M;
        let most = (limit - bones).max(0.0);
        let most = most * most * DEPTH_M * DEPTH_M * self.points.len() as f32;
        let (mut depth2, mut gap_m, mut feet_m) = (0.0, f32::INFINITY, f32::INFINITY);
        for (i, point) in self.points.iter().enumerate() {
            let d = field.sample(*point + pelvis);
            if i < self.anchors {
                gap_m = gap_m.min(d);
            } else if i < self.soles {
                feet_m = feet_m.min(d);
            }
            depth2 += d.min(0.0) * d.min(0.0);
            if depth2 > most {
                return f32::INFINITY;
            }
        }
        let depth = (depth2 / self.points.len() as f32).sqrt() / DEPTH_M;
        let gap = gap_m.max(0.0) / GAP_M;
        let dangling = if self.soles > self.anchors { (feet_m / DANGLING_M).clamp(0.0, 1.0) } else { 0.0 };
        bones + depth + gap * gap + DANGLING * dangling
    }
}
