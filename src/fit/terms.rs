//! The terms of the energies. Each adds its weighted value and its exact gradient to an [`Energy`].

use glam::Vec3;

use super::energy::{Energy, Term};
use super::goals::ContactGoal;
use super::probe::Probe;
use crate::body::joints as j;
use crate::body::joints::JOINTS;
use crate::scene::{BodyParams, PARAMS};

/// Softness of "the nearest vertices of a region": the nearest few centimetres of skin share the pull.
const NEAREST_M: f32 = 0.008;
/// Where the nearest skin should come to rest: the last step sets the body down the rest of the way.
const REST_M: f32 = 0.0015;
/// Skin farther than this from a surface is not drawn to it by the spread term.
const SPREAD_M: f32 = 0.03;
/// Skin this near already counts as penetrating: leaves but the deepest vertices in free space.
const SKIN_MARGIN_M: f32 = 0.003;
/// Limbs that lie on each other press their flesh to this share of its thickness.
const SOFT_FLESH: f32 = 0.85;
/// Rounding of |d| in PSI's robust distance, in square metres (published code).
const PSI_ROUNDING_M2: f32 = 1e-4;
/// The weight may stand this far from the middle of the feet: about half a foot's length.
const BALANCE_RADIUS_M: f32 = 0.06;

/// Signed distance and gradient at each probe vertex, filled once per iteration.
pub struct Distances {
    /// Metres, positive in free space.
    pub value: Vec<f32>,
    /// Gradient of the field there.
    pub gradient: Vec<Vec3>,
}

/// PSI eq. 8, first term: mean |x - x0| over the 75 numbers.
pub fn psi_start(energy: &mut Energy, x: &[f32; PARAMS], start: &[f32; PARAMS], weight: f32) {
    let scale = weight / PARAMS as f32;
    for i in 0..PARAMS {
        let offset = x[i] - start[i];
        energy.add(Term::Start, scale * offset.abs());
        energy.params[i] += if offset == 0.0 { 0.0 } else { scale * offset.signum() };
    }
}

/// PSI eq. 5: mean squared pose code.
pub fn psi_pose_prior(energy: &mut Energy, x: &[f32; PARAMS], weight: f32) {
    let [_, _, _, pose, hands] = BodyParams::OFFSETS;
    let scale = weight / (hands - pose) as f32;
    for i in pose..hands {
        energy.add(Term::PosePrior, scale * x[i] * x[i]);
        energy.params[i] += 2.0 * scale * x[i];
    }
}

/// PSI eq. 7 as coded: mean over contact vertices of r/(r + c), r = sqrt(d² + 1e-4); the nearest scene point
/// is looked up in the distance field.
pub fn psi_contact(energy: &mut Energy, contact: &[u32], distances: &Distances, c: f32, weight: f32) {
    let scale = weight / contact.len().max(1) as f32;
    for v in contact.iter().map(|v| *v as usize) {
        let d = distances.value[v];
        let r = (d * d + PSI_ROUNDING_M2).sqrt();
        energy.add(Term::Contact, scale * r / (r + c));
        let slope = c / ((r + c) * (r + c)) * d / r;
        energy.vertices[v] += distances.gradient[v] * (scale * slope);
    }
}

/// PSI eq. 6 as coded: mean depth over the penetrating vertices only.
pub fn psi_collision(energy: &mut Energy, distances: &Distances, weight: f32) {
    let penetrating = distances.value.iter().filter(|d| **d < 0.0).count();
    let scale = weight / penetrating.max(1) as f32;
    for (v, d) in distances.value.iter().enumerate().filter(|(_, d)| **d < 0.0) {
        energy.add(Term::Collision, -scale * d);
        energy.vertices[v] -= distances.gradient[v] * scale;
    }
}

/// Squared distance of one block of the numbers to its start.
pub fn stay(
    energy: &mut Energy,
    x: &[f32; PARAMS],
    start: &[f32; PARAMS],
    block: std::ops::Range<usize>,
    weight: f32,
) {
    for i in block {
        let offset = x[i] - start[i];
        energy.add(Term::Start, weight * offset * offset);
        energy.params[i] += 2.0 * weight * offset;
    }
}

/// Closes the gap between a region's nearest skin and the room: `w g²/(1 + g²/reach²)` of the soft minimum g.
pub fn gap(energy: &mut Energy, region: &[u32], distances: &Distances, goal: &ContactGoal, weight: f32) {
    let nearest = region.iter().map(|v| distances.value[*v as usize]).fold(f32::INFINITY, f32::min);
    if !nearest.is_finite() {
        return;
    }
    let share = |d: f32| (-(d - nearest) / NEAREST_M).exp();
    let (mut total, mut sum) = (0.0, 0.0);
    for v in region {
        let d = distances.value[*v as usize];
        total += share(d);
        sum += share(d) * d;
    }
    let soft = sum / total;
    let gap = soft - REST_M;
    let rounding = 1.0 + gap * gap / (goal.reach_m * goal.reach_m);
    let scale = weight * goal.weight;
    energy.add(Term::Contact, scale * gap * gap / rounding);
    let slope = scale * 2.0 * gap / (rounding * rounding);
    for v in region.iter().map(|v| *v as usize) {
        let d = distances.value[v];
        let by_distance = share(d) / total * (1.0 - (d - soft) / NEAREST_M);
        energy.vertices[v] += distances.gradient[v] * (slope * by_distance);
    }
}

/// Brings more of a region to rest: mean of d²/(d² + c²) over its skin in free space.
pub fn spread(energy: &mut Energy, region: &[u32], distances: &Distances, weight: f32) {
    let scale = weight / region.len().max(1) as f32;
    let c2 = SPREAD_M * SPREAD_M;
    for v in region.iter().map(|v| *v as usize).filter(|v| distances.value[*v] > 0.0) {
        let d = distances.value[v];
        let below = d * d + c2;
        energy.add(Term::Contact, scale * d * d / below);
        energy.vertices[v] += distances.gradient[v] * (scale * 2.0 * d * c2 / (below * below));
    }
}

/// Mean over all probe vertices of the squared depth below the skin margin: smooth when a vertex leaves.
pub fn collision(energy: &mut Energy, distances: &Distances, weight: f32) {
    let scale = weight / distances.value.len().max(1) as f32;
    for (v, d) in distances.value.iter().enumerate().filter(|(_, d)| **d < SKIN_MARGIN_M) {
        let depth = SKIN_MARGIN_M - d;
        energy.add(Term::Collision, scale * depth * depth);
        energy.vertices[v] -= distances.gradient[v] * (2.0 * scale * depth);
    }
}

/// Bones keep the thickness of their flesh from every surface: a limb through a thin sheet has all its skin
/// in free space, but not its bone.
pub fn bones(
    energy: &mut Energy,
    probe: &Probe,
    joints: &[Vec3; JOINTS],
    sample: &dyn Fn(Vec3) -> (f32, Vec3),
    weight: f32,
) {
    for bone in &probe.bones {
        let (d, gradient) = sample(bone.center(joints));
        let lack = bone.radius_m - d;
        if lack > 0.0 {
            energy.add(Term::Bones, weight * lack * lack);
            let pull = gradient * (-2.0 * weight * lack);
            energy.joints[bone.from] += pull * (1.0 - bone.along);
            energy.joints[bone.to] += pull * bone.along;
        }
    }
}

/// Spheres of limbs that can meet keep the sum of their radii apart.
pub fn self_collision(energy: &mut Energy, probe: &Probe, joints: &[Vec3; JOINTS], weight: f32) {
    for (a, b) in &probe.pairs {
        let (a, b) = (&probe.bones[usize::from(*a)], &probe.bones[usize::from(*b)]);
        let apart = a.center(joints) - b.center(joints);
        let lack = SOFT_FLESH * (a.radius_m + b.radius_m) - apart.length();
        if lack > 0.0 {
            energy.add(Term::SelfCollision, weight * lack * lack);
            let pull = apart.normalize_or(Vec3::Y) * (-2.0 * weight * lack);
            for (bone, pull) in [(a, pull), (b, -pull)] {
                energy.joints[bone.from] += pull * (1.0 - bone.along);
                energy.joints[bone.to] += pull * bone.along;
            }
        }
    }
}

/// Squared excess over the limits of each component of the body joints' axis-angles.
pub fn joint_limits(energy: &mut Energy, local: &[Vec3; JOINTS], limits: &[(Vec3, Vec3)], weight: f32) {
    for (i, (low, high)) in limits.iter().enumerate() {
        let joint = i + 1;
        let excess = (local[joint] - *high).max(Vec3::ZERO) + (local[joint] - *low).min(Vec3::ZERO);
        energy.add(Term::JointLimits, weight * excess.length_squared());
        energy.local[joint] += excess * (2.0 * weight);
    }
}

/// Joints that stand for the body's mass, with their shares (de Leva 1996: trunk and head about half, thighs
/// 14 %, shins 4 %, arms 5 % each).
const MASSES: [(usize, f32); 11] = [
    (j::PELVIS, 0.17),
    (j::SPINE2, 0.16),
    (j::SPINE3, 0.17),
    (j::HEAD, 0.07),
    (j::LEFT_KNEE, 0.11),
    (j::RIGHT_KNEE, 0.11),
    (j::LEFT_ANKLE, 0.055),
    (j::RIGHT_ANKLE, 0.055),
    (j::LEFT_ELBOW, 0.05),
    (j::RIGHT_ELBOW, 0.05),
    (j::NECK, 0.0),
];
/// Joints whose middle a standing body's weight stands over.
const FEET: [usize; 4] = [j::LEFT_ANKLE, j::RIGHT_ANKLE, j::LEFT_FOOT, j::RIGHT_FOOT];

/// A standing body's weight stays over its feet: squared horizontal distance beyond a small radius.
pub fn balance(energy: &mut Energy, joints: &[Vec3; JOINTS], weight: f32) {
    let mass: f32 = MASSES.iter().map(|(_, m)| m).sum();
    let center: Vec3 = MASSES.iter().map(|(joint, m)| joints[*joint] * (m / mass)).sum();
    let feet: Vec3 = FEET.iter().map(|joint| joints[*joint] * 0.25).sum();
    let offset = (center - feet) * Vec3::new(1.0, 0.0, 1.0);
    let excess = offset.length() - BALANCE_RADIUS_M;
    if excess > 0.0 {
        energy.add(Term::Balance, weight * excess * excess);
        let pull = offset.normalize_or_zero() * (2.0 * weight * excess);
        MASSES.iter().for_each(|(joint, m)| energy.joints[*joint] += pull * (m / mass));
        FEET.iter().for_each(|joint| energy.joints[*joint] -= pull * 0.25);
    }
}
