//! Where the person is, roughly, before any descent: as far as the torso looks small, upright, facing anywhere.

use glam::{Mat3, Vec2, Vec3};

use super::landmarks::{Landmark, Landmarks};
use super::pinhole::Pinhole;
use crate::assets::PersonKeypoints;
use crate::body::joints as j;
use crate::body::{Body, Workspace};
use crate::scene::{BodyParams, POSE};

/// Pairs of joints that give the scale: the torso first (SMPLify-X), limbs where it is hidden.
const TORSO: [(usize, usize); 4] = [
    (j::LEFT_SHOULDER, j::LEFT_HIP),
    (j::RIGHT_SHOULDER, j::RIGHT_HIP),
    (j::LEFT_SHOULDER, j::RIGHT_HIP),
    (j::RIGHT_SHOULDER, j::LEFT_HIP),
];
const LIMBS: [(usize, usize); 10] = [
    (j::LEFT_SHOULDER, j::RIGHT_SHOULDER),
    (j::LEFT_HIP, j::RIGHT_HIP),
    (j::LEFT_HIP, j::LEFT_KNEE),
    (j::RIGHT_HIP, j::RIGHT_KNEE),
    (j::LEFT_KNEE, j::LEFT_ANKLE),
    (j::RIGHT_KNEE, j::RIGHT_ANKLE),
    (j::LEFT_SHOULDER, j::LEFT_ELBOW),
    (j::RIGHT_SHOULDER, j::RIGHT_ELBOW),
    (j::LEFT_ELBOW, j::LEFT_WRIST),
    (j::RIGHT_ELBOW, j::RIGHT_WRIST),
];
/// Depth when no pair is seen, metres.
const USUAL_M: f32 = 3.0;
/// Nobody is nearer to the camera or farther off, metres.
const RANGE_M: std::ops::RangeInclusive<f32> = 0.6..=12.0;
/// Keypoints below this confidence say nothing about scale.
const CONFIDENT: f32 = 0.3;

/// The person of code `pose`, mean shape, upright, turned by `yaw` about the vertical, as far from the camera as the
/// torso's length in the picture says and where the confident keypoints lie.
pub fn initial(
    body: &Body,
    view: &Pinhole,
    seen: &PersonKeypoints,
    pose: &[f32; POSE],
    yaw: f32,
) -> BodyParams {
    let mut params = BodyParams { pose: *pose, ..BodyParams::default() };
    params.set_rotation(&Mat3::from_rotation_y(yaw));
    let mut workspace = Workspace::default();
    body.forward_joints(&params, &mut workspace);
    let joints = workspace.joints();
    let pixels = confident_joints(seen);
    let depth_m = depth(view, &pixels, joints).clamp(*RANGE_M.start(), *RANGE_M.end());
    let count = pixels.len().max(1) as f32;
    let pixel = pixels.iter().map(|(_, pixel)| *pixel).sum::<Vec2>() / count;
    let middle = pixels.iter().map(|(joint, _)| joints[*joint]).sum::<Vec3>() / count;
    params.translation = view.unproject(pixel, depth_m) - middle;
    params
}

/// Joints among the confident keypoints with their pixels; all that were found if none is confident.
fn confident_joints(seen: &PersonKeypoints) -> Vec<(usize, Vec2)> {
    let above = |least: f32| {
        let points = Landmarks::list(seen.set).iter().zip(&seen.points);
        let joint = |(landmark, point): (&Landmark, &crate::assets::Keypoint)| match landmark {
            Landmark::Joint(joint) if point.confidence > least => Some((*joint, point.pixel)),
            _ => None,
        };
        points.filter_map(joint).collect::<Vec<_>>()
    };
    let confident = above(CONFIDENT);
    if confident.len() < 2 { above(0.0) } else { confident }
}

/// Depth from the pair that looks longest for its length: foreshortening only makes things look farther away.
fn depth(view: &Pinhole, pixels: &[(usize, Vec2)], joints: &[Vec3; j::JOINTS]) -> f32 {
    let pixel = |joint: usize| pixels.iter().find(|(seen, _)| *seen == joint).map(|(_, pixel)| *pixel);
    let nearest = |pairs: &[(usize, usize)]| {
        let depth = |&(a, b): &(usize, usize)| {
            let length_px = pixel(a)?.distance(pixel(b)?);
            (length_px > 1.0).then(|| view.focal_px * joints[a].distance(joints[b]) / length_px)
        };
        pairs.iter().filter_map(depth).min_by(f32::total_cmp)
    };
    nearest(&TORSO).or_else(|| nearest(&LIMBS)).unwrap_or(USUAL_M)
}
