//! A leg of any duration between two known bodies, by RouteNet and PoseNet (LTM §3.3).
//!
//! The networks always give sixty frames for two seconds; these are stretched in time to the leg's own duration. They
//! work in the leg's own frame, so neither the place in the room nor the direction matters to them. Ends are met
//! exactly: what the networks miss them by fades out into the leg.

use glam::Vec3;

use super::capture::between;
use super::leg::{LegMotion, PathPoint};
use super::local::{LegFrame, code_of, heading_of};
use super::planted::planted_feet;
use super::room_points::RoomPoints;
use super::stitch::{fade, stitched};
use crate::assets::{Weights, WeightsError};
use crate::body::Body;
use crate::body::joints::PELVIS;
use crate::job::{Cancelled, Seed, Ticker};
use crate::math::rotation;
use crate::nn::motion::{
    BETWEEN, Between, Cloud, MotionKind, MotionSampler, PLACE, POSE_COLUMNS, ROW, TURN_COLUMNS,
};
use crate::scene::{BETAS, CLIP_FPS, Frame};

/// Frames of the networks' own clip, both ends with them.
pub const CLIP_FRAMES: usize = BETWEEN + 2;
/// Shortest leg, seconds: a change of posture in less looks like a jerk.
const SHORTEST_S: f32 = 0.6;
/// How fast people walk who don't think of it, metres a second.
const WALK_M_PER_S: f32 = 1.1;
/// How fast they turn on the spot, radians a second.
const TURN_PER_S: f32 = 1.6;
/// How fast the pelvis rises and sinks when they get up and sit down, metres a second.
const RISE_M_PER_S: f32 = 0.3;

/// Two known bodies and the way between them.
#[derive(Clone, Copy, Debug)]
pub struct LegEnds<'a> {
    /// Body shape β.
    pub betas: &'a [f32; BETAS],
    /// The first body.
    pub from: &'a Frame,
    /// The last body.
    pub to: &'a Frame,
    /// Height of the floor under the leg, metres.
    pub floor_m: f32,
    /// How long it should take, seconds; `None` for a natural pace.
    pub seconds: Option<f32>,
}

impl LegEnds<'_> {
    /// Both ends included.
    pub fn frame_count(&self, path: &[PathPoint]) -> usize {
        let seconds = self.seconds.unwrap_or_else(|| self.natural_s(path));
        (seconds.max(SHORTEST_S) * CLIP_FPS).round() as usize + 1
    }

    /// How long people take for it: the way at walking pace, or turning, or changing posture, whichever is longest.
    fn natural_s(&self, path: &[PathPoint]) -> f32 {
        let straight_m = (self.to.translation - self.from.translation).with_y(0.0).length();
        let along_m: f32 = path.windows(2).map(|p| p[0].at.distance(p[1].at)).sum();
        let turned = heading_of(self.to.rotation) - heading_of(self.from.rotation);
        let turned = turned.sin().atan2(turned.cos()).abs();
        let risen_m = (self.to.translation.y - self.from.translation.y).abs();
        (along_m.max(straight_m) / WALK_M_PER_S).max(turned / TURN_PER_S).max(risen_m / RISE_M_PER_S)
    }
}

/// Networks that together fill the time between two bodies.
pub struct LearnedMotion {
    route: MotionSampler,
    pose: MotionSampler,
}

/// Why networks of motion can't be used.
#[derive(Debug, thiserror::Error)]
pub enum LearnedMotionError {
    /// A file can't be read.
    #[error(transparent)]
    Weights(#[from] WeightsError),
    /// A file of another network.
    #[error(
        "{file} holds the network `{found}` where `{expected}` belongs; name the right file or train it anew"
    )]
    Other {
        /// The file.
        file: String,
        /// What it holds.
        found: &'static str,
        /// What was wanted.
        expected: &'static str,
    },
}

impl LearnedMotion {
    /// RouteNet and PoseNet of two weight files.
    ///
    /// # Errors
    /// [`LearnedMotionError`] when a file holds another network.
    pub fn from_weights(route: &Weights, pose: &Weights) -> Result<Self, LearnedMotionError> {
        Ok(Self {
            route: sampler_of(route, MotionKind::Between(Between::Route))?,
            pose: sampler_of(pose, MotionKind::Between(Between::Pose))?,
        })
    }

    /// The leg between two bodies in a room, along `path` as far as its length goes.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn leg(
        &self,
        body: &Body,
        points: &RoomPoints,
        ends: &LegEnds<'_>,
        path: &[PathPoint],
        seed: Seed,
        ticker: &Ticker,
    ) -> Result<LegMotion, Cancelled> {
        ticker.check()?;
        let clip = self.clip(body, points, ends, seed);
        ticker.check()?;
        let frames = stretched(&clip, ends.frame_count(path));
        let planted = planted_feet(body, ends.betas, &frames, ends.floor_m);
        Ok(LegMotion { frames, planted })
    }

    /// The networks' own clip of two seconds between two bodies, which are its ends.
    pub fn clip(&self, body: &Body, points: &RoomPoints, ends: &LegEnds<'_>, seed: Seed) -> Vec<Frame> {
        let scene = LegScene::new(
            body,
            points,
            ends,
            [self.route.config().points.count, self.pose.config().points.count],
            seed,
        );
        let [start, end] = scene.rows;
        let route = self.route_of(&scene);
        let poses = self.pose.between(&[&scene.clouds[1]], &[start], &[end], &route);
        let width = ROW - PLACE;
        let row = |k: usize| -> [f32; ROW] {
            std::array::from_fn(|c| match c {
                c if c < PLACE => route[0][k * PLACE + c],
                c => poses[0][k * width + c - PLACE],
            })
        };
        let rows: Vec<[f32; ROW]> = (0..BETWEEN).map(row).collect();
        scene.frames(body, ends, &rows)
    }

    /// Points of a cloud that RouteNet takes.
    pub(super) fn route_points(&self) -> usize {
        self.route.config().points.count
    }

    fn route_of(&self, scene: &LegScene) -> Vec<Vec<f32>> {
        let [start, end] = scene.rows;
        self.route.between(&[&scene.clouds[0]], &[start], &[end], &[])
    }

    /// RouteNet's places and rotations in rows, poses and hands zero.
    pub(super) fn route_rows(&self, scene: &LegScene) -> Vec<[f32; ROW]> {
        let route = self.route_of(scene);
        let row = |place: &[f32]| std::array::from_fn(|c| place.get(c).copied().unwrap_or(0.0));
        route.iter().flat_map(|r| r.chunks_exact(PLACE)).map(row).collect()
    }
}

/// The sampler of a weight file that must hold this network.
pub(super) fn sampler_of(
    weights: &Weights,
    expected: MotionKind,
) -> Result<MotionSampler, LearnedMotionError> {
    let sampler = MotionSampler::from_weights(weights)?;
    let found = sampler.config().kind;
    if found == expected {
        return Ok(sampler);
    }
    Err(LearnedMotionError::Other {
        file: weights.file.clone(),
        found: found.label(),
        expected: expected.label(),
    })
}

/// A leg as the networks see it.
pub struct LegScene {
    /// Where the leg's frame is.
    pub leg: LegFrame,
    /// The two ends.
    pub rows: [[f32; ROW]; 2],
    /// The room, as many points as each of two networks takes.
    pub clouds: [Cloud; 2],
}

impl LegScene {
    /// Two bodies with the room around them.
    pub fn new(body: &Body, points: &RoomPoints, ends: &LegEnds<'_>, counts: [usize; 2], seed: Seed) -> Self {
        let rest = rest_pelvis(body, ends.betas);
        let leg = LegFrame::of(ends.from, rest, ends.floor_m);
        let rows =
            [ends.from, ends.to].map(|frame| leg.row(frame, &body.pose_space.encode(&frame.pose), rest));
        let places = [ends.from, ends.to].map(|frame| frame.translation + rest);
        let clouds = [0, 1].map(|i| points.around(&leg, places, counts[i], seed.child("cloud", i as u64)).0);
        Self { leg, rows, clouds }
    }

    /// The bodies of rows, between the two ends, which are met exactly.
    pub fn frames(&self, body: &Body, ends: &LegEnds<'_>, rows: &[[f32; ROW]]) -> Vec<Frame> {
        let rest = rest_pelvis(body, ends.betas);
        let [first, last] = self.rows;
        let rows = met(rows, &self.rows);
        // What the pose space can't hold of the ends fades out like all else that is missed.
        let decode = |row: &[f32; ROW]| Frame {
            pose: body.pose_space.decode(&code_of(row)),
            ..self.leg.placed(row, rest)
        };
        let all = std::iter::once(&first).chain(&rows).chain(std::iter::once(&last));
        stitched(all.map(decode).collect(), ends.from, ends.to)
    }
}

fn rest_pelvis(body: &Body, betas: &[f32; BETAS]) -> Vec3 {
    body.model.rest_joints(betas)[PELVIS]
}

/// Rows corrected so that they lead from the first end to the last: the gap between an end and where the rows' own
/// course would have it fades out smoothly.
fn met(rows: &[[f32; ROW]], ends: &[[f32; ROW]; 2]) -> Vec<[f32; ROW]> {
    let count = rows.len();
    if count < 2 {
        return rows.to_vec();
    }
    let onward = |near: &[f32; ROW], next: &[f32; ROW], end: &[f32; ROW]| -> [f32; ROW] {
        std::array::from_fn(|c| end[c] - (2.0 * near[c] - next[c]))
    };
    let gaps = [onward(&rows[0], &rows[1], &ends[0]), onward(&rows[count - 1], &rows[count - 2], &ends[1])];
    let corrected = |(k, row): (usize, &[f32; ROW])| -> [f32; ROW] {
        let shares = [0, 1].map(|end| fade(k + 1, end, count + 1));
        let mut out: [f32; ROW] =
            std::array::from_fn(|c| row[c] + gaps[0][c] * shares[0] + gaps[1][c] * shares[1]);
        keep_square(&mut out);
        out
    };
    rows.iter().enumerate().map(corrected).collect()
}

/// Six numbers that were added to are a rotation's again.
fn keep_square(row: &mut [f32; ROW]) {
    let six: [f32; 6] = std::array::from_fn(|i| row[TURN_COLUMNS.start + i]);
    let six = rotation::six_d_from_matrix(&rotation::matrix_from_6d(&six));
    row[TURN_COLUMNS].copy_from_slice(&six);
    debug_assert_eq!(POSE_COLUMNS.start, TURN_COLUMNS.end);
}

/// A clip in another number of frames, its ends kept as they are.
pub fn stretched(clip: &[Frame], count: usize) -> Vec<Frame> {
    let last = clip.len().saturating_sub(1);
    let frame = |k: usize| {
        let at = k as f32 * last as f32 / (count.max(2) - 1) as f32;
        let before = (at as usize).min(last);
        match at - before as f32 {
            share if share < 1e-5 || before == last => clip[before].clone(),
            share => between(&clip[before], &clip[before + 1], share),
        }
    };
    let mut frames: Vec<Frame> = (0..count.max(2)).map(frame).collect();
    if let (Some(end), Some(known)) = (frames.last_mut(), clip.last()) {
        end.clone_from(known);
    }
    frames
}

#[cfg(test)]
mod tests {
    use glam::Quat;

    use super::*;
    use crate::nn::motion::{MotionConfig, MotionNetwork};

    fn untrained() -> LearnedMotion {
        let sampler = |which| {
            let (network, params) =
                MotionNetwork::declare(&MotionConfig::mini(MotionKind::Between(which)), 4);
            MotionSampler::new(network, &params)
        };
        LearnedMotion { route: sampler(Between::Route), pose: sampler(Between::Pose) }
    }

    fn standing(at: Vec3, turn: f32, bow: f32) -> Frame {
        let mut frame = Frame { translation: at, rotation: Quat::from_rotation_y(turn), ..Frame::default() };
        frame.pose[2].x = bow;
        frame
    }

    #[test]
    fn a_leg_meets_its_ends_to_the_byte_and_takes_as_long_as_asked() {
        let body = Body::bundled();
        let (from, to) =
            (standing(Vec3::new(2.0, 0.9, 1.0), 0.3, 0.2), standing(Vec3::new(3.5, 0.9, 2.0), 1.0, 0.0));
        for (seconds, count) in [(Some(2.0), 61), (Some(1.0), 31), (None, 50)] {
            let ends = LegEnds { betas: &[0.0; BETAS], from: &from, to: &to, floor_m: 0.0, seconds };
            let made = untrained()
                .leg(body, &RoomPoints::default(), &ends, &[], Seed::root(1), &Ticker::silent())
                .expect("a leg");
            assert_eq!((made.frames.len(), made.planted.len()), (count, count), "{seconds:?}");
            assert!(made.frames[0] == from && made.frames[count - 1] == to);
            assert!(made.frames.iter().all(Frame::is_finite));
        }
    }

    #[test]
    fn a_leg_is_the_same_anywhere_in_the_room() {
        let body = Body::bundled();
        let (from, to) =
            (standing(Vec3::new(0.0, 0.9, 0.0), 0.0, 0.2), standing(Vec3::new(0.3, 0.9, 1.5), 0.4, 0.0));
        let rest = body.model.joint_template[PELVIS];
        let turn = Quat::from_rotation_y(2.0);
        let moved = |f: &Frame| Frame {
            translation: turn * (f.translation + rest) + Vec3::new(5.0, 0.0, -3.0) - rest,
            rotation: turn * f.rotation,
            ..f.clone()
        };
        let leg = |from: &Frame, to: &Frame| {
            let ends = LegEnds { betas: &[0.0; BETAS], from, to, floor_m: 0.0, seconds: Some(2.0) };
            // An empty room: its points are drawn along the way, in the world.
            untrained().clip(body, &RoomPoints::default(), &ends, Seed::root(1))
        };
        let (here, there) = (leg(&from, &to), leg(&moved(&from), &moved(&to)));
        for (a, b) in here.iter().zip(&there) {
            assert!(moved(a).translation.distance(b.translation) < 1e-3);
        }
    }

    #[test]
    fn a_file_of_another_network_is_refused() {
        let (network, params) =
            MotionNetwork::declare(&MotionConfig::mini(MotionKind::Between(Between::Base)), 4);
        let mut file = Weights::new("base.safetensors");
        network.store(&params, &mut file);
        let why = LearnedMotion::from_weights(&file, &file).err().map(|e| e.to_string()).unwrap_or_default();
        assert!(why.contains("base") && why.contains("route"), "{why}");
    }
}
