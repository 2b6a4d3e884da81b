//! The terms of the estimators' energies; each adds its value and its exact gradient.

use glam::Vec3;

use super::landmarks::{Landmark, Landmarks};
use super::pinhole::Pinhole;
use crate::assets::PersonKeypoints;
use crate::body::joints::JOINTS;
use crate::body::{JointLimit, Workspace};
use crate::scene::{BodyParams, PARAMS, POSE};

/// Width of the robust distance to keypoints in pixels of a picture 1000 long (SMPLify-X, supplement: rho 100).
const KEYPOINT_RHO: f32 = 100.0;
/// Width of PROX's robust distance to the scene, metres (PROX §3.2: 5 cm).
const CONTACT_RHO_M: f32 = 0.05;
/// Body and scene face each other within 45 degrees where they touch (PROX's code).
const FACING_COSINE: f32 = std::f32::consts::FRAC_1_SQRT_2;
/// Vertices of SMPL-X, over which the published collision term sums.
const PUBLISHED_VERTICES: f32 = 10_475.0;

/// A term of the estimators' energy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EstimateTerm {
    /// Distance of projected landmarks to the keypoints.
    Keypoints,
    /// Likely pose, and relaxed hands.
    Pose,
    /// Likely shape.
    Shape,
    /// Joints beyond their limits.
    Limits,
    /// Contact with the room.
    Contact,
    /// Skin in solid matter.
    Collision,
}

/// Every term, in the order of traces.
pub const ESTIMATE_TERMS: [EstimateTerm; 6] = [
    EstimateTerm::Keypoints,
    EstimateTerm::Pose,
    EstimateTerm::Shape,
    EstimateTerm::Limits,
    EstimateTerm::Contact,
    EstimateTerm::Collision,
];

impl EstimateTerm {
    /// Name for plots.
    pub fn label(self) -> &'static str {
        match self {
            Self::Keypoints => "keypoints",
            Self::Pose => "pose prior",
            Self::Shape => "shape prior",
            Self::Limits => "joint limits",
            Self::Contact => "contact",
            Self::Collision => "collision",
        }
    }
}

/// An energy at one point with all its gradients.
pub struct Sum {
    /// Value of each of [`ESTIMATE_TERMS`].
    pub terms: [f32; ESTIMATE_TERMS.len()],
    /// With respect to the subset's vertices.
    pub vertices: Vec<Vec3>,
    /// With respect to the joints.
    pub joints: [Vec3; JOINTS],
    /// With respect to local axis-angles.
    pub local: [Vec3; JOINTS],
    /// With respect to the 75 numbers directly.
    pub params: [f32; PARAMS],
}

impl Sum {
    /// Nothing, for a subset of `vertices` vertices.
    pub fn new(vertices: usize) -> Self {
        Self {
            terms: [0.0; ESTIMATE_TERMS.len()],
            vertices: vec![Vec3::ZERO; vertices],
            joints: [Vec3::ZERO; JOINTS],
            local: [Vec3::ZERO; JOINTS],
            params: [0.0; PARAMS],
        }
    }

    fn add(&mut self, term: EstimateTerm, value: f32) {
        self.terms[term as usize] += value;
    }
}

/// `Σ (γ c)² ρ(Π(landmark) - keypoint)` with the Geman-McClure distance `ρ(e) = σ²e²/(σ² + e²)` and weights `γ` a
/// keypoint (SMPLify-X eq. 2).
pub fn keypoints(
    sum: &mut Sum,
    seen: &PersonKeypoints,
    view: &Pinhole,
    workspace: &Workspace,
    weight_of: &dyn Fn(Landmark) -> f32,
) {
    let rho2 = KEYPOINT_RHO * KEYPOINT_RHO;
    for (landmark, point) in Landmarks::list(seen.set).iter().zip(&seen.points) {
        let weight = (weight_of(*landmark) * point.confidence).powi(2);
        if weight == 0.0 {
            continue;
        }
        let at = match *landmark {
            Landmark::Joint(joint) => workspace.joints()[joint],
            Landmark::Skin(entry) => workspace.vertices()[entry],
        };
        let error = (view.project(at) - point.pixel) * view.per_px();
        let squared = error.length_squared();
        sum.add(EstimateTerm::Keypoints, weight * rho2 * squared / (rho2 + squared));
        let slope = weight * 2.0 * (rho2 / (rho2 + squared)).powi(2);
        let gradient = view.pull_back(at, error * (slope * view.per_px()));
        match *landmark {
            Landmark::Joint(joint) => sum.joints[joint] += gradient,
            Landmark::Skin(entry) => sum.vertices[entry] += gradient,
        }
    }
}

/// `w |θ - θ_s|²` (PSI §4.2; `θ_s` is zero for SMPLify-X and PROX) and `w |hands|²`.
pub fn pose_prior(sum: &mut Sum, x: &[f32; PARAMS], center: &[f32; POSE], weight: f32) {
    let [_, _, _, pose, hands] = BodyParams::OFFSETS;
    for i in pose..PARAMS {
        let offset = if i < hands { x[i] - center[i - pose] } else { x[i] };
        sum.add(EstimateTerm::Pose, weight * offset * offset);
        sum.params[i] += 2.0 * weight * offset;
    }
}

/// `w |β|²`.
pub fn shape_prior(sum: &mut Sum, x: &[f32; PARAMS], weight: f32) {
    let [_, _, betas, pose, _] = BodyParams::OFFSETS;
    for i in betas..pose {
        sum.add(EstimateTerm::Shape, weight * x[i] * x[i]);
        sum.params[i] += 2.0 * weight * x[i];
    }
}

/// Squared excess over the limits of the body joints: in place of SMPLify-X's exponential at knees and elbows.
pub fn joint_limits(sum: &mut Sum, local: &[Vec3; JOINTS], limits: &[JointLimit], weight: f32) {
    for (i, limit) in limits.iter().enumerate() {
        let excess = limit.excess(local[i + 1]);
        sum.add(EstimateTerm::Limits, weight * excess.length_squared());
        sum.local[i + 1] += excess * (2.0 * weight);
    }
}

/// Skin with its distances to the room, filled once per evaluation.
pub struct Skin<'a> {
    /// Where in the subset the probe's vertices begin.
    pub first: usize,
    /// Metres, positive in free space.
    pub distances: &'a [f32],
    /// Gradients of the field there.
    pub gradients: &'a [Vec3],
}

/// PROX's contact: mean over contact vertices that face the surface of `d²/(d² + 0.05²)`; the nearest point of the
/// scene is looked up in the distance field.
pub fn contact(sum: &mut Sum, skin: &Skin<'_>, vertices: &[u32], normals: &dyn Fn(u32) -> Vec3, weight: f32) {
    let faces = |v: &&u32| {
        let away = skin.gradients[**v as usize].normalize_or_zero();
        -normals(**v).dot(away) > FACING_COSINE
    };
    let facing: Vec<u32> = vertices.iter().filter(faces).copied().collect();
    let scale = weight / facing.len().max(1) as f32;
    let c2 = CONTACT_RHO_M * CONTACT_RHO_M;
    for v in facing.into_iter().map(|v| v as usize) {
        let d = skin.distances[v];
        let below = d * d + c2;
        sum.add(EstimateTerm::Contact, scale * d * d / below);
        sum.vertices[skin.first + v] += skin.gradients[v] * (scale * 2.0 * d * c2 / (below * below));
    }
}

/// PROX's penetration: sum of the depths of all vertices, from the probe's share of them.
pub fn collision(sum: &mut Sum, skin: &Skin<'_>, weight: f32) {
    let scale = weight * PUBLISHED_VERTICES / skin.distances.len().max(1) as f32;
    for (v, d) in skin.distances.iter().enumerate().filter(|(_, d)| **d < 0.0) {
        sum.add(EstimateTerm::Collision, -scale * d);
        sum.vertices[skin.first + v] -= skin.gradients[v] * scale;
    }
}
