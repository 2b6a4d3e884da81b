//! A cheap check for limbs inside each other: capsules along the bones.

use glam::Vec3;

use crate::body::joints;

use super::figure::{Figure, Side};

struct Capsule {
    from: Vec3,
    to: Vec3,
    radius_m: f32,
}

/// How deep the worst pair of limbs that should not touch overlap, metres; 0 when none do.
pub(super) fn deepest_overlap_m(figure: &Figure) -> f32 {
    let at = |joint: usize| figure.position(joint);
    let bone = |a: usize, b: usize, radius_m: f32| Capsule { from: at(a), to: at(b), radius_m };
    let torso = torso_capsules(figure);
    let arms = Side::BOTH.map(|side| arm_capsules(figure, side));
    let thighs = [
        bone(joints::LEFT_HIP, joints::LEFT_KNEE, 0.055),
        bone(joints::RIGHT_HIP, joints::RIGHT_KNEE, 0.055),
    ];
    let shanks = [
        bone(joints::LEFT_KNEE, joints::LEFT_ANKLE, 0.042),
        bone(joints::RIGHT_KNEE, joints::RIGHT_ANKLE, 0.042),
    ];
    let mut worst = 0.0f32;
    let mut check = |a: &Capsule, b: &Capsule| worst = worst.max(overlap_m(a, b));
    for arm in arms.iter().flatten() {
        torso.iter().chain(&thighs).chain(&shanks).for_each(|body| check(arm, body));
    }
    for left in &arms[0] {
        arms[1].iter().for_each(|right| check(left, right));
    }
    check(&shanks[0], &shanks[1]);
    check(&shanks[0], &thighs[1]);
    check(&shanks[1], &thighs[0]);
    // Thighs meet at the top; only their lower halves may not.
    let lower = thighs.map(|t| Capsule { from: t.from.midpoint(t.to), ..t });
    check(&lower[0], &lower[1]);
    worst
}

/// Two columns of flesh left and right of the spine, and the head.
fn torso_capsules(figure: &Figure) -> Vec<Capsule> {
    let column = |x: f32| Capsule {
        from: figure.point(joints::PELVIS, Vec3::new(x, -0.02, 0.01)),
        to: figure.point(joints::SPINE3, Vec3::new(x, 0.15, 0.04)),
        radius_m: 0.1,
    };
    let head = Capsule {
        from: figure.point(joints::HEAD, Vec3::new(0.0, 0.0, 0.03)),
        to: figure.point(joints::HEAD, Vec3::new(0.0, 0.07, 0.0)),
        radius_m: 0.085,
    };
    vec![column(0.05), column(-0.05), head]
}

/// Forearm and hand; the upper arm starts at the chest anyway.
fn arm_capsules(figure: &Figure, side: Side) -> [Capsule; 2] {
    let elbow = figure.position(side.joint(joints::LEFT_ELBOW));
    let wrist_joint = side.joint(joints::LEFT_WRIST);
    let wrist = figure.position(wrist_joint);
    let knuckles = figure.point(wrist_joint, side.outward(0.1, 0.0, 0.0));
    [
        Capsule { from: elbow, to: wrist, radius_m: 0.032 },
        Capsule { from: wrist, to: knuckles, radius_m: 0.022 },
    ]
}

fn overlap_m(a: &Capsule, b: &Capsule) -> f32 {
    (a.radius_m + b.radius_m - segment_distance_m(a, b)).max(0.0)
}

/// Distance of two segments (Ericson 2005, Real-Time Collision Detection, §5.1.9).
fn segment_distance_m(a: &Capsule, b: &Capsule) -> f32 {
    let (d1, d2, r) = (a.to - a.from, b.to - b.from, a.from - b.from);
    let (aa, ee, f) = (d1.length_squared().max(1e-12), d2.length_squared().max(1e-12), d2.dot(r));
    let (c, bb) = (d1.dot(r), d1.dot(d2));
    let denominator = aa * ee - bb * bb;
    let s = if denominator > 1e-9 { ((bb * f - c * ee) / denominator).clamp(0.0, 1.0) } else { 0.0 };
    let t = (bb * s + f) / ee;
    let (s, t) = if t < 0.0 {
        ((-c / aa).clamp(0.0, 1.0), 0.0)
    } else if t > 1.0 {
        (((bb - c) / aa).clamp(0.0, 1.0), 1.0)
    } else {
        (s, t)
    };
    (a.from + d1 * s).distance(b.from + d2 * t)
}
