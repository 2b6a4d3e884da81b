//! Legs from a memory of short clips, after the search of HSNMS (Xu et al. 2020) that LTM §4.4 compares with: the piece
//! whose first and last pose, speed there and displacement suit best, laid from both ends and blended.
//!
//! The memory is made of clips that the user gives; none come with the program.

use glam::{Quat, Vec3};
use rayon::prelude::*;

use super::capture::{Recording, record};
use super::learned::{LegEnds, stretched};
use super::leg::{LegMotion, PathPoint};
use super::local::{LegFrame, heading_of};
use super::planted::planted_feet;
use super::stitch::stitched;
use crate::assets::PoseClip;
use crate::body::joints::{BODY_JOINTS, PELVIS};
use crate::body::{Body, VertexSubset, Workspace};
use crate::job::{Cancelled, Ticker};
use crate::scene::{BETAS, CLIP_FPS, Frame};

/// Lengths of pieces that are tried, as shares of the leg's.
const LENGTHS: [f32; 5] = [0.7, 0.85, 1.0, 1.2, 1.45];
/// Of the memory's frames every so-many-th begins a piece.
const STEP: usize = 2;
/// What a difference costs, each against one metre of mean joint distance: displacement per metre, turn per radian,
/// speed per metre a second, and the length of the piece per share.
const DISPLACEMENT: f32 = 0.6;
const TURN: f32 = 0.25;
const SPEED: f32 = 0.12;
const LENGTH: f32 = 0.1;
/// Frames looked at for a speed.
const SPEED_FRAMES: usize = 3;

/// What is known of one moment of a clip.
#[derive(Clone, Debug)]
struct Moment {
    /// Pelvis and body joints in the frame below the body.
    joints: Vec<Vec3>,
    /// Where that frame is.
    at: LegFrame,
    /// Speed of the pelvis along the floor, in that frame, metres a second.
    velocity: Vec3,
}

/// Clips that legs are looked for in.
#[derive(Debug, Default)]
pub struct MotionMemory {
    clips: Vec<(Recording, Vec<Moment>)>,
}

/// A piece of a clip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    clip: usize,
    first: usize,
    last: usize,
    /// What it costs; the least is the best.
    pub cost: f32,
}

impl MotionMemory {
    /// Remembers clips and their mirror images.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn new(clips: &[PoseClip], body: &Body, ticker: &Ticker) -> Result<Self, Cancelled> {
        ticker.stage("remembering clips", clips.len())?;
        let both = |clip: &PoseClip| {
            ticker.advance()?;
            let Some(recording) = record(clip, body) else { return Ok(Vec::new()) };
            let mirrored = recording.mirror_image(body);
            Ok([recording, mirrored].map(|r| (moments(body, &r.frames), r)).map(|(m, r)| (r, m)).to_vec())
        };
        let clips: Vec<Vec<(Recording, Vec<Moment>)>> =
            clips.par_iter().map(both).collect::<Result<_, Cancelled>>()?;
        Ok(Self { clips: clips.into_iter().flatten().collect() })
    }

    /// Remembers motions that are there already, as they are.
    pub fn of_recordings(recordings: Vec<Recording>, body: &Body) -> Self {
        Self {
            clips: recordings
                .into_iter()
                .map(|r| (moments(body, &r.frames), r))
                .map(|(m, r)| (r, m))
                .collect(),
        }
    }

    /// Whether there is nothing to look in.
    pub fn is_empty(&self) -> bool {
        self.clips.iter().all(|(r, _)| r.frames.len() < 2)
    }

    /// The piece that suits best; `velocities` of the pelvis at both ends where they are known, metres a second, world
    /// frame. `None` from an empty memory.
    pub fn find(
        &self,
        body: &Body,
        ends: &LegEnds<'_>,
        velocities: [Option<Vec3>; 2],
        count: usize,
    ) -> Option<Found> {
        let wanted = Wanted::new(body, ends, velocities, count);
        let of_clip = |(number, (_, moments)): (usize, &(Recording, Vec<Moment>))| {
            let lengths = LENGTHS.map(|share| ((count - 1) as f32 * share) as usize);
            let pieces = lengths.into_iter().filter(|l| *l > 0).flat_map(|length| {
                let starts = moments.len().saturating_sub(length);
                (0..starts).step_by(STEP).map(move |first| (first, first + length))
            });
            let found = pieces.map(|(first, last)| Found {
                clip: number,
                first,
                last,
                cost: wanted.cost(&moments[first], &moments[last], last - first),
            });
            found.min_by(|a, b| a.cost.total_cmp(&b.cost))
        };
        let best: Vec<Option<Found>> = self.clips.par_iter().enumerate().map(of_clip).collect();
        best.into_iter().flatten().min_by(|a, b| a.cost.total_cmp(&b.cost))
    }

    /// The leg between two bodies; `None` from an empty memory.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn leg(
        &self,
        body: &Body,
        ends: &LegEnds<'_>,
        velocities: [Option<Vec3>; 2],
        path: &[PathPoint],
        ticker: &Ticker,
    ) -> Result<Option<LegMotion>, Cancelled> {
        ticker.check()?;
        let count = ends.frame_count(path);
        let Some(found) = self.find(body, ends, velocities, count) else { return Ok(None) };
        ticker.check()?;
        let frames = self.laid(body, ends, &found, count);
        let planted = planted_feet(body, ends.betas, &frames, ends.floor_m);
        Ok(Some(LegMotion { frames, planted }))
    }

    /// Where a found piece comes from, for reports.
    pub fn name_of(&self, found: &Found) -> &str {
        self.clips.get(found.clip).map_or("", |(r, _)| &r.name)
    }

    /// The piece laid from the first body and from the last one, and blended from the one to the other.
    fn laid(&self, body: &Body, ends: &LegEnds<'_>, found: &Found, count: usize) -> Vec<Frame> {
        let rest = body.model.joint_template[PELVIS];
        let own_rest = body.model.rest_joints(ends.betas)[PELVIS];
        let piece = stretched(&self.clips[found.clip].0.frames[found.first..=found.last], count);
        let lay = |known: &Frame, anchor: &Frame| {
            let turn = Quat::from_rotation_y(heading_of(known.rotation) - heading_of(anchor.rotation));
            let (to, from) = (known.translation + own_rest, anchor.translation + rest);
            move |f: &Frame| (to + turn * (f.translation + rest - from) - own_rest, turn * f.rotation)
        };
        let (ahead, back) = (lay(ends.from, &piece[0]), lay(ends.to, &piece[piece.len() - 1]));
        let last = (piece.len() - 1) as f32;
        let blended = |(k, frame): (usize, &Frame)| {
            let share = k as f32 / last;
            let share = share * share * (3.0 - 2.0 * share);
            let ((a, turn_a), (b, turn_b)) = (ahead(frame), back(frame));
            Frame {
                translation: a.lerp(b, share),
                rotation: turn_a.slerp(turn_b, share).normalize(),
                ..frame.clone()
            }
        };
        stitched(piece.iter().enumerate().map(blended).collect(), ends.from, ends.to)
    }
}

/// What a leg looks for.
struct Wanted {
    ends: [Moment; 2],
    known: [bool; 2],
    /// The last frame's origin in the first one's.
    displacement: Vec3,
    turn: f32,
    length: f32,
}

impl Wanted {
    fn new(body: &Body, ends: &LegEnds<'_>, velocities: [Option<Vec3>; 2], count: usize) -> Self {
        let mut workspace = Workspace::default();
        let none = VertexSubset::new(&body.model, Vec::new());
        let moment = |frame: &Frame, velocity: Option<Vec3>, workspace: &mut Workspace| {
            let mut moment = moment(body, ends.betas, frame, ends.floor_m, &none, workspace);
            moment.velocity = moment.at.turn.inverse() * velocity.unwrap_or_default().with_y(0.0);
            moment
        };
        let both = [
            moment(ends.from, velocities[0], &mut workspace),
            moment(ends.to, velocities[1], &mut workspace),
        ];
        let (displacement, turn) = between_frames(&both[0].at, &both[1].at);
        Self {
            ends: both,
            known: velocities.map(|v| v.is_some()),
            displacement,
            turn,
            length: (count - 1) as f32,
        }
    }

    fn cost(&self, first: &Moment, last: &Moment, length: usize) -> f32 {
        let mut cost = 0.0;
        for ((wanted, found), known) in self.ends.iter().zip([first, last]).zip(self.known) {
            let apart = wanted.joints.iter().zip(&found.joints).map(|(a, b)| a.distance(*b)).sum::<f32>();
            cost += apart / wanted.joints.len() as f32;
            if known {
                cost += SPEED * wanted.velocity.distance(found.velocity);
            }
        }
        let (displacement, turn) = between_frames(&first.at, &last.at);
        let off = turn - self.turn;
        cost + DISPLACEMENT * displacement.distance(self.displacement)
            + TURN * off.sin().atan2(off.cos()).abs()
            + LENGTH * (length as f32 / self.length).ln().abs()
    }
}

fn between_frames(from: &LegFrame, to: &LegFrame) -> (Vec3, f32) {
    (from.point(to.origin), heading_of(from.turn.inverse() * to.turn))
}

fn moments(body: &Body, frames: &[Frame]) -> Vec<Moment> {
    let mut workspace = Workspace::default();
    let none = VertexSubset::new(&body.model, Vec::new());
    let mut moments: Vec<Moment> =
        frames.iter().map(|frame| moment(body, &[0.0; BETAS], frame, 0.0, &none, &mut workspace)).collect();
    let origins: Vec<Vec3> = moments.iter().map(|m| m.at.origin).collect();
    for (i, moment) in moments.iter_mut().enumerate() {
        let (a, b) = (i.saturating_sub(SPEED_FRAMES), (i + SPEED_FRAMES).min(origins.len() - 1));
        let seconds = (b - a).max(1) as f32 / CLIP_FPS;
        moment.velocity = moment.at.turn.inverse() * ((origins[b] - origins[a]) / seconds);
    }
    moments
}

fn moment(
    body: &Body,
    betas: &[f32; BETAS],
    frame: &Frame,
    floor_m: f32,
    none: &VertexSubset,
    workspace: &mut Workspace,
) -> Moment {
    body.forward_posed(&frame.params(betas), &frame.pose, none, workspace);
    let at = LegFrame::of(frame, body.model.rest_joints(betas)[PELVIS], floor_m);
    let joints = workspace.joints()[..=BODY_JOINTS].iter().map(|j| at.point(*j)).collect();
    Moment { joints, at, velocity: Vec3::ZERO }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::joints::{LEFT_HIP, RIGHT_HIP};

    /// Somebody who walks along `heading` with swinging legs.
    fn walk(name: &str, heading: f32, speed_m_per_s: f32) -> Recording {
        let turn = Quat::from_rotation_y(heading);
        let frame = |k: usize| {
            let mut frame = Frame {
                translation: turn * Vec3::new(0.0, 0.0, k as f32 * speed_m_per_s / 30.0) + Vec3::Y * 0.9,
                rotation: turn,
                ..Frame::default()
            };
            frame.pose[LEFT_HIP - 1].x = 0.4 * (k as f32 * 0.2).sin();
            frame.pose[RIGHT_HIP - 1].x = -0.4 * (k as f32 * 0.2).sin();
            frame
        };
        Recording { name: name.into(), mirrored: false, frames: (0..150).map(frame).collect() }
    }

    #[test]
    fn a_piece_that_is_in_the_memory_is_found_again_wherever_the_leg_is() {
        let body = Body::bundled();
        let memory = MotionMemory::of_recordings(vec![walk("slow", 0.0, 0.6), walk("fast", 1.0, 1.4)], body);
        let truth = walk("elsewhere", -2.0, 1.4);
        let piece = &truth.frames[40..101];
        let ends = LegEnds {
            betas: &[0.0; BETAS],
            from: &piece[0],
            to: &piece[60],
            floor_m: 0.0,
            seconds: Some(2.0),
        };
        let found = memory.find(body, &ends, [None; 2], 61).expect("a piece");
        assert_eq!((memory.name_of(&found), found.first, found.last), ("fast", 40, 100));
        let leg = memory.leg(body, &ends, [None; 2], &[], &Ticker::silent()).expect("made").expect("a leg");
        assert!(leg.frames[0] == piece[0] && leg.frames[60] == piece[60]);
        for (made, truth) in leg.frames.iter().zip(piece) {
            assert!(made.translation.distance(truth.translation) < 0.01);
        }
        assert!(
            MotionMemory::default()
                .leg(body, &ends, [None; 2], &[], &Ticker::silent())
                .expect("made")
                .is_none()
        );
    }

    #[test]
    fn who_stands_at_both_ends_gets_another_piece_than_who_walks_through() {
        let body = Body::bundled();
        let mut start_stop = walk("start and stop", 0.0, 1.0);
        for (k, frame) in start_stop.frames.iter_mut().enumerate() {
            let t = ((k as f32 - 40.0) / 60.0).clamp(0.0, 1.0);
            frame.translation.z = 2.0 * t * t * (3.0 - 2.0 * t);
            frame.pose = [Vec3::ZERO; 21];
        }
        let mut steady = walk("steady", 0.0, 1.0);
        steady.frames.iter_mut().for_each(|f| f.pose = [Vec3::ZERO; 21]);
        let (from, to) = (steady.frames[0].clone(), steady.frames[60].clone());
        let memory = MotionMemory::of_recordings(vec![start_stop, steady], body);
        let ends = LegEnds { betas: &[0.0; BETAS], from: &from, to: &to, floor_m: 0.0, seconds: Some(2.0) };
        let name = |v: Vec3| {
            let found = memory.find(body, &ends, [Some(v); 2], 61).expect("a piece");
            memory.name_of(&found).to_owned()
        };
        assert_eq!((name(Vec3::ZERO), name(Vec3::Z)), ("start and stop".into(), "steady".into()));
    }
}
