//! Captured clips made into motion of our body: 30 frames a second, feet on the floor, with the travel that the feet
//! show where a clip was made on the spot. Knows no room and no network.

use glam::{Mat3, Quat, Vec3};

use crate::assets::{CLIP_JOINTS, PoseClip};
use crate::body::joints::{
    LEFT_ELBOW, LEFT_HAND, LEFT_SHOULDER, PELVIS, RIGHT_ELBOW, RIGHT_HAND, RIGHT_SHOULDER, mirror_axis_angle,
};
use crate::body::{Body, BodyPose, HAND_CODE, VertexSubset, Workspace, mirrored};
use crate::math::rotation;
use crate::scene::{BETAS, CLIP_FPS, FRAME_JOINTS, Frame, HANDS};

/// Of the body's vertices every so-many-th is looked at for contact with the floor; soles are denser than that.
const STRIDE: usize = 16;
/// Skin this far above the lowest point bears a tenth of what the lowest bears, metres.
const BEARING_M: f32 = 0.012;
/// Skin this near to the lowest may be what stands on the floor, metres.
const NEAR_M: f32 = 0.06;
/// Some point of a captured figure's feet always stands still; where even the slowest moves faster than this half of the
/// time, metres a second, the clip was made on the spot and its travel is read from the feet.
const IN_PLACE_M_PER_S: f32 = 0.25;
/// Longest flight, seconds: a body without contact for longer is not jumping, its height is wrong.
const FLIGHT_S: f32 = 0.9;
/// Height over the floor from which on a body is not in contact, metres: what differs less is what carrying over a
/// figure's feet costs.
const ALOFT_M: f32 = 0.12;
/// Nobody moves faster indoors, metres a second: frames before such a leap are a capture's calibration.
const LEAP_M_PER_S: f32 = 12.0;
/// The same for a joint's turn, radians a second; an axis-angle that differs by more than [`FLIP`] has only changed sign.
const LEAP_PER_S: f32 = 40.0;
const FLIP: f32 = 4.0;
/// Frames at a capture's begin that may be such.
const CALIBRATION: usize = 12;
/// Whose joints turn slower than this on average and whose pelvis moves slower than a tenth of it in metres is at rest,
/// radians a second.
const REST_PER_S: f32 = 1.0;
/// Frames over which the floor's height under the feet is smoothed.
const SMOOTH: usize = 4;
/// Mean turn of a joint from the first to the last pose of a clip that can be repeated, radians.
const SAME_POSE: f32 = 0.16;
/// Shorter loops are repeated until they last this long, seconds.
const LEAST_S: f32 = 4.5;
/// Shorter clips that begin and end at rest are held at both ends until they last this long, seconds.
const HELD_S: f32 = 2.6;
/// Clips shorter than this are no motion, seconds.
const SHORTEST_S: f32 = 0.5;

/// A motion of the mean body over a floor at `y = 0`, [`CLIP_FPS`] frames a second.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// The clip that it comes from.
    pub name: String,
    /// Whether it is the mirror image.
    pub mirrored: bool,
    /// The motion.
    pub frames: Vec<Frame>,
}

/// Both arms held straight out: how many files begin, and nobody stands.
pub fn is_calibration(pose: &BodyPose) -> bool {
    let turned = [LEFT_SHOULDER, RIGHT_SHOULDER, LEFT_ELBOW, RIGHT_ELBOW].map(|j| pose[j - 1].length());
    turned.iter().all(|angle| *angle < 0.35)
}

/// The clip as a motion of the mean body; `None` when nothing of it is left.
pub fn record(clip: &PoseClip, body: &Body) -> Option<Recording> {
    let mut frames = at_thirty(clip, body);
    if (frames.len() as f32) < SHORTEST_S * CLIP_FPS {
        return None;
    }
    let contact = Contact::new(body);
    contact.set_down(body, &mut frames);
    contact.stand_still(body, &mut frames);
    if is_loop(&frames) {
        close(&mut frames);
        frames = repeated(&frames, body.model.joint_template[PELVIS]);
    } else {
        hold_ends(&mut frames);
    }
    Some(Recording { name: clip.name.clone(), mirrored: false, frames })
}

impl Recording {
    /// Its mirror image, left and right exchanged.
    #[must_use]
    pub fn mirror_image(&self, body: &Body) -> Self {
        let rest = body.model.joint_template[PELVIS];
        Self {
            name: self.name.clone(),
            mirrored: !self.mirrored,
            frames: self.frames.iter().map(|frame| mirror_frame(frame, rest)).collect(),
        }
    }

    /// How long it lasts, seconds.
    pub fn seconds(&self) -> f32 {
        self.frames.len().saturating_sub(1) as f32 / CLIP_FPS
    }
}

/// A body mirrored at the plane x = 0, its pelvis resting at `rest_pelvis`.
pub fn mirror_frame(frame: &Frame, rest_pelvis: Vec3) -> Frame {
    let pelvis = frame.translation + rest_pelvis;
    let mut hands = [0.0; HANDS];
    hands[..HAND_CODE].copy_from_slice(&frame.hands[HAND_CODE..]);
    hands[HAND_CODE..].copy_from_slice(&frame.hands[..HAND_CODE]);
    let [x, y, z, w] = frame.rotation.to_array();
    Frame {
        translation: pelvis.with_x(-pelvis.x) - rest_pelvis,
        rotation: Quat::from_xyzw(x, -y, -z, w),
        pose: mirrored(&frame.pose),
        hands,
    }
}

/// The clip's frames at 30 a second, as they were captured.
fn at_thirty(clip: &PoseClip, body: &Body) -> Vec<Frame> {
    let leaps = |f: &usize| {
        let next = (f + 1).min(clip.frames.len() - 1);
        let turned = |j: usize| (clip.frames[*f][j] - clip.frames[next][j]).length();
        clip.pelvis_m[*f].distance(clip.pelvis_m[next]) > LEAP_M_PER_S * clip.frame_seconds
            || (0..=FRAME_JOINTS).any(|j| (LEAP_PER_S * clip.frame_seconds..FLIP).contains(&turned(j)))
    };
    let begin = (0..clip.frames.len().min(CALIBRATION)).filter(leaps).map(|f| f + 1).max().unwrap_or(0);
    let captured: Vec<usize> = (begin..clip.frames.len())
        .skip_while(|f| is_calibration(&std::array::from_fn(|j| clip.frames[*f][j + 1])))
        .collect();
    let Some((first, last)) = captured.first().copied().zip(captured.last().copied()) else {
        return Vec::new();
    };
    let seconds = (last - first) as f32 * clip.frame_seconds;
    let count = (seconds * CLIP_FPS + 1e-3) as usize + 1;
    let frame = |k: usize| {
        let at = first as f32 + k as f32 / (CLIP_FPS * clip.frame_seconds);
        let before = (at as usize).min(last);
        let after = (before + 1).min(last);
        blend(clip, [before, after], at - before as f32, body)
    };
    (0..count).map(frame).collect()
}

/// A turn as a quaternion.
pub(super) fn quat(axis_angle: Vec3) -> Quat {
    Quat::from_mat3(&rotation::matrix_from_axis_angle(axis_angle))
}

/// A turn as an axis-angle, radians.
pub(super) fn axis_angle(turn: Quat) -> Vec3 {
    rotation::axis_angle_from_matrix(Mat3::from_quat(turn.normalize()))
}

fn blend(clip: &PoseClip, [a, b]: [usize; 2], share: f32, body: &Body) -> Frame {
    let joints: [Quat; CLIP_JOINTS] =
        std::array::from_fn(|j| quat(clip.frames[a][j]).slerp(quat(clip.frames[b][j]), share));
    Frame {
        translation: clip.pelvis_m[a].lerp(clip.pelvis_m[b], share) - body.model.joint_template[PELVIS],
        rotation: joints[PELVIS].normalize(),
        pose: std::array::from_fn(|j| axis_angle(joints[j + 1])),
        hands: hand_codes(&joints, body),
    }
}

/// Codes of both hands; of hands that were not captured, those of relaxed ones.
fn hand_codes(joints: &[Quat; CLIP_JOINTS], body: &Body) -> [f32; HANDS] {
    let hand = |first: usize| std::array::from_fn(|j| axis_angle(joints[first + j]));
    let (left, right) = (hand(LEFT_HAND), hand(RIGHT_HAND).map(mirror_axis_angle));
    let captured = |pose: &[Vec3]| pose.iter().any(|v| v.length() > 1e-3);
    let mut codes = [0.0; HANDS];
    for (code, pose) in codes.chunks_exact_mut(HAND_CODE).zip([left, right]) {
        if captured(&pose) {
            // Fingers of game figures bend beyond what the hand space was made from.
            let found = body.hand_space.encode_left(&pose);
            code.iter_mut().zip(found).for_each(|(c, f)| *c = f.clamp(-3.0, 3.0));
        }
    }
    codes
}

/// A motion played `speed` times as fast.
pub fn resampled(frames: &[Frame], speed: f32) -> Vec<Frame> {
    let last = frames.len().saturating_sub(1);
    let count = (last as f32 / speed) as usize + 1;
    if speed == 1.0 || frames.is_empty() {
        return frames.to_vec();
    }
    let frame = |k: usize| {
        let at = (k as f32 * speed).min(last as f32);
        let before = at as usize;
        between(&frames[before], &frames[(before + 1).min(last)], at - before as f32)
    };
    (0..count).map(frame).collect()
}

/// A body between two others.
pub fn between(a: &Frame, b: &Frame, share: f32) -> Frame {
    Frame {
        translation: a.translation.lerp(b.translation, share),
        rotation: a.rotation.slerp(b.rotation, share).normalize(),
        pose: std::array::from_fn(|j| axis_angle(quat(a.pose[j]).slerp(quat(b.pose[j]), share))),
        hands: std::array::from_fn(|i| a.hands[i] + (b.hands[i] - a.hands[i]) * share),
    }
}

/// What of the body may bear it.
struct Contact {
    subset: VertexSubset,
}

impl Contact {
    fn new(body: &Body) -> Self {
        let ids = (0..body.model.template.len() as u32).step_by(STRIDE).collect();
        Self { subset: VertexSubset::new(&body.model, ids) }
    }

    fn skin<'w>(&self, body: &Body, frame: &Frame, workspace: &'w mut Workspace) -> &'w [Vec3] {
        body.forward_posed(&frame.params(&[0.0; BETAS]), &frame.pose, &self.subset, workspace);
        workspace.vertices()
    }

    /// Puts the body on the floor: all frames at once where it jumps, else each by itself, smoothly.
    fn set_down(&self, body: &Body, frames: &mut [Frame]) {
        let mut workspace = Workspace::default();
        let lowest = |frame: &Frame, workspace: &mut Workspace| {
            self.skin(body, frame, workspace).iter().map(|v| v.y).fold(f32::INFINITY, f32::min)
        };
        let low: Vec<f32> = frames.iter().map(|frame| lowest(frame, &mut workspace)).collect();
        let mut sorted = low.clone();
        sorted.sort_by(f32::total_cmp);
        let floor_m = sorted[sorted.len() / 10];
        let above: Vec<f32> = low.iter().map(|l| l - floor_m).collect();
        let offsets = if jumps(&above) { vec![floor_m; low.len()] } else { smoothed(&low) };
        for (frame, offset) in frames.iter_mut().zip(offsets) {
            frame.translation.y -= offset;
        }
    }

    /// What bears the body stands still: gives a clip made on the spot the travel of its feet, and takes from others the
    /// slip that their lengths cost when they were carried over.
    fn stand_still(&self, body: &Body, frames: &mut [Frame]) {
        let mut workspace = Workspace::default();
        let skins: Vec<Vec<Vec3>> =
            frames.iter().map(|frame| self.skin(body, frame, &mut workspace).to_vec()).collect();
        let slowest: Vec<Option<Vec3>> = skins.windows(2).map(|pair| slowest(&pair[0], &pair[1])).collect();
        let mut speeds: Vec<f32> = slowest.iter().flatten().map(|s| s.length() * CLIP_FPS).collect();
        speeds.sort_by(f32::total_cmp);
        let in_place = speeds.get(speeds.len() / 2).is_some_and(|median| *median > IN_PLACE_M_PER_S);
        let slips =
            if in_place { skins.windows(2).map(|pair| slip(&pair[0], &pair[1])).collect() } else { slowest };
        let mut travelled = Vec3::ZERO;
        let mut last = Vec3::ZERO;
        for (frame, slip) in frames[1..].iter_mut().zip(slips) {
            // In flight a body on the spot goes on as it did; one that was captured on its way flies as captured.
            last = slip.unwrap_or(if in_place { last } else { Vec3::ZERO });
            travelled -= last;
            frame.translation += travelled;
        }
    }
}

/// Height of each of the skin's points above the lowest in the higher of two frames, metres; `None` in flight.
fn heights(before: &[Vec3], after: &[Vec3]) -> Option<Vec<f32>> {
    let high: Vec<f32> = before.iter().zip(after).map(|(a, b)| a.y.max(b.y)).collect();
    let lowest = high.iter().copied().fold(f32::INFINITY, f32::min);
    (lowest < ALOFT_M).then(|| high.into_iter().map(|h| h - lowest).collect())
}

/// Horizontal displacement of that point of the skin near the floor that moves least, metres: heel, ball or toe of
/// the planted foot, whichever it rolls over.
fn slowest(before: &[Vec3], after: &[Vec3]) -> Option<Vec3> {
    let near = heights(before, after)?;
    let moved = before.iter().zip(after).map(|(a, b)| (*b - *a).with_y(0.0));
    let near = moved.zip(near).filter(|(_, height)| *height < NEAR_M);
    near.map(|(moved, _)| moved).min_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))
}

/// Mean horizontal displacement of the skin that bears the body, the lower the more, metres.
fn slip(before: &[Vec3], after: &[Vec3]) -> Option<Vec3> {
    let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
    for ((a, b), height) in before.iter().zip(after).zip(heights(before, after)?) {
        let weight = 10f32.powf(-height / BEARING_M);
        sum += (*b - *a).with_y(0.0) * weight;
        weights += weight;
    }
    Some(sum / weights)
}

/// Whether the body leaves the floor and comes back soon, as who jumps or runs does.
fn jumps(above_floor_m: &[f32]) -> bool {
    let mut sorted = above_floor_m.to_vec();
    sorted.sort_by(f32::total_cmp);
    let on_the_floor = sorted[sorted.len() / 2] < 0.3 * ALOFT_M;
    let (mut longest, mut run) = (0, 0);
    for above in above_floor_m {
        run = if *above > ALOFT_M { run + 1 } else { 0 };
        longest = longest.max(run);
    }
    // Who is aloft at the end has not come back.
    on_the_floor && longest > 0 && run == 0 && longest as f32 <= FLIGHT_S * CLIP_FPS
}

fn smoothed(values: &[f32]) -> Vec<f32> {
    let mean = |i: usize| {
        let near = &values[i.saturating_sub(SMOOTH)..(i + SMOOTH + 1).min(values.len())];
        near.iter().sum::<f32>() / near.len() as f32
    };
    (0..values.len()).map(mean).collect()
}

fn is_loop(frames: &[Frame]) -> bool {
    let (Some(first), Some(last)) = (frames.first(), frames.last()) else { return false };
    let turned = |j: usize| quat(first.pose[j]).angle_between(quat(last.pose[j]));
    let mean = (0..FRAME_JOINTS).map(turned).sum::<f32>() / FRAME_JOINTS as f32;
    (frames.len() as f32) < LEAST_S * CLIP_FPS && mean < SAME_POSE
}

/// Spreads what the last pose differs from the first over the whole, so that repeating it shows no seam.
fn close(frames: &mut [Frame]) {
    let (Some(first), Some(last)) = (frames.first().cloned(), frames.last().cloned()) else { return };
    let back: [Quat; FRAME_JOINTS] =
        std::array::from_fn(|j| quat(last.pose[j]).inverse() * quat(first.pose[j]));
    let count = frames.len() - 1;
    for (k, frame) in frames.iter_mut().enumerate() {
        let share = k as f32 / count as f32;
        frame.pose =
            std::array::from_fn(|j| axis_angle(quat(frame.pose[j]) * Quat::IDENTITY.slerp(back[j], share)));
        frame.translation.y += (first.translation.y - last.translation.y) * share;
    }
}

/// The motion again and again, each time where the time before ended.
fn repeated(frames: &[Frame], rest_pelvis: Vec3) -> Vec<Frame> {
    let (Some(first), Some(last)) = (frames.first(), frames.last()) else { return Vec::new() };
    let pelvis = |frame: &Frame| frame.translation + rest_pelvis;
    let turn_of = |frame: &Frame| Quat::from_rotation_y(super::local::heading_of(frame.rotation));
    let turn = turn_of(last) * turn_of(first).inverse();
    let step = (pelvis(last) - turn * pelvis(first)).with_y(0.0);
    let times = (LEAST_S * CLIP_FPS / (frames.len() - 1) as f32).ceil() as usize;
    let mut out = frames.to_vec();
    let (mut turned, mut moved) = (turn, step);
    for _ in 1..times {
        let again = |frame: &Frame| Frame {
            translation: turned * pelvis(frame) + moved - rest_pelvis,
            rotation: (turned * frame.rotation).normalize(),
            ..frame.clone()
        };
        out.extend(frames[1..].iter().map(again));
        moved += turned * step;
        turned *= turn;
    }
    out
}

/// Short clips that begin or end at rest stay there for a while, as the people in them do.
fn hold_ends(frames: &mut Vec<Frame>) {
    let wanted = (HELD_S * CLIP_FPS) as usize;
    let missing = wanted.saturating_sub(frames.len());
    if missing == 0 || frames.len() < 2 {
        return;
    }
    let (first, last) = (frames[0].clone(), frames[frames.len() - 1].clone());
    let at_rest = [at_rest(&frames[0], &frames[1]), at_rest(&frames[frames.len() - 2], &last)];
    let before = match at_rest {
        [true, true] => missing / 2,
        [true, false] => missing,
        _ => 0,
    };
    frames.splice(0..0, std::iter::repeat_n(first, before));
    if at_rest[1] {
        frames.extend(std::iter::repeat_n(last, missing - before));
    }
}

fn at_rest(a: &Frame, b: &Frame) -> bool {
    let turned: f32 = (0..FRAME_JOINTS).map(|j| quat(a.pose[j]).angle_between(quat(b.pose[j]))).sum();
    let slow = turned / FRAME_JOINTS as f32 * CLIP_FPS < REST_PER_S;
    slow && a.translation.distance(b.translation) * CLIP_FPS < 0.3 * REST_PER_S
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::joints::{LEFT_ANKLE, LEFT_HIP, LEFT_KNEE, RIGHT_ANKLE, RIGHT_HIP, RIGHT_KNEE};

    /// Somebody who walks on the spot: legs swing as on a treadmill, one step in 0.5 s.
    fn treadmill(frames: usize) -> PoseClip {
        let swing = |k: usize, side: f32| 0.45 * side * (std::f32::consts::PI * k as f32 / 15.0).cos();
        let frame = |k: usize| {
            let mut joints = [Vec3::ZERO; CLIP_JOINTS];
            for (side, hip, knee, ankle) in
                [(1.0, LEFT_HIP, LEFT_KNEE, LEFT_ANKLE), (-1.0, RIGHT_HIP, RIGHT_KNEE, RIGHT_ANKLE)]
            {
                let (now, next) = (swing(k, side), swing(k + 1, side));
                // The leg that swings forward is bent.
                let bent = if next < now { 0.5 } else { 0.0 };
                joints[hip].x = now - bent * 0.5;
                joints[knee].x = bent;
                joints[ankle].x = -now - bent * 0.5;
            }
            joints[LEFT_SHOULDER].z = -1.2;
            joints[RIGHT_SHOULDER].z = 1.2;
            joints
        };
        PoseClip {
            name: "made/treadmill".into(),
            frames: (0..frames).map(frame).collect(),
            pelvis_m: vec![Vec3::new(0.0, 1.4, 0.0); frames],
            frame_seconds: 1.0 / 30.0,
        }
    }

    #[test]
    fn loops_in_place_get_travel_from_their_feet_and_stand_on_the_floor() {
        let body = Body::bundled();
        let recording = record(&treadmill(31), body).expect("a motion");
        assert!(recording.seconds() >= LEAST_S, "repeated");
        let moved = recording.frames[120].translation - recording.frames[0].translation;
        // Legs of 0.85 m through 0.9 radians, eight steps in four seconds.
        assert!((3.5..8.0).contains(&moved.z) && moved.x.abs() < 0.3, "{moved}");
        let contact = Contact::new(body);
        let mut workspace = Workspace::default();
        for frame in &recording.frames {
            let low =
                contact.skin(body, frame, &mut workspace).iter().map(|v| v.y).fold(f32::INFINITY, f32::min);
            // Stiff legs: the figure rises over the standing one.
            assert!((-0.03..0.1).contains(&low), "{low}");
        }
    }

    #[test]
    fn somebody_who_stands_stays_where_they_are_and_calibration_is_cut_off() {
        let body = Body::bundled();
        let mut clip = treadmill(40);
        clip.frames = vec![clip.frames[4]; 40];
        let last = record(&clip, body).expect("a motion").frames;
        assert!(last[last.len() - 1].translation.distance(last[0].translation) < 1e-3);
        clip.frames[..30].fill([Vec3::ZERO; CLIP_JOINTS]);
        assert!(record(&clip, body).is_none(), "a third of a second is left");
    }

    #[test]
    fn twice_mirrored_is_as_before_and_the_pelvis_changes_sides() {
        let body = Body::bundled();
        let mut recording = record(&treadmill(31), body).expect("a motion");
        recording.frames.iter_mut().for_each(|f| f.translation.x += 0.4);
        let mirrored = recording.mirror_image(body);
        let rest = body.model.joint_template[PELVIS];
        let joints = |f: &Frame| body.pose_axis_angles(&f.params(&[0.0; BETAS]), &f.pose).joints;
        let (a, b) = (joints(&recording.frames[7]), joints(&mirrored.frames[7]));
        assert!(a[LEFT_ANKLE].distance(b[RIGHT_ANKLE] * Vec3::new(-1.0, 1.0, 1.0)) < 0.01);
        assert!(
            (recording.frames[7].translation + rest).x > 0.3
                && (mirrored.frames[7].translation + rest).x < -0.3
        );
        let again = mirrored.mirror_image(body);
        for (a, b) in recording.frames.iter().zip(&again.frames) {
            assert!(a.translation.distance(b.translation) < 1e-5 && a.pose == b.pose);
        }
    }
}
