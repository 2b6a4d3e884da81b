//! What the networks of LTM learn from: windows of takes, bodies at sub-goals, points of staged rooms.

use glam::Vec3;
use rand::RngExt as _;
use rayon::prelude::*;

use super::staging::{StagedRoom, stage};
use super::takes::{Activity, Take, WINDOW, takes_of};
use crate::assets::{PoseClip, content_hash};
use crate::body::joints::PELVIS;
use crate::body::{Body, FamilyHints, VertexSubset, Workspace, sample_pose};
use crate::job::{Rng, Seed, Stop, Ticker};
use crate::learn::corpus::Split;
use crate::motion::local::{LegFrame, heading_of};
use crate::nn::motion::{CONDITION, Cloud, PLACE, ROW};
use crate::scene::{BETAS, Frame, POSE, PoseFamily};

/// LTM §4.2: what moves less from start to end is no walk.
const MOVED_M: f32 = 0.5;
/// Windows in which somebody gets lower or higher than this count as well, metres.
const RISEN_M: f32 = 0.12;
/// And those in which somebody turns further than this, radians.
const TURNED: f32 = 0.7;
/// Of the windows in which nothing of it happens every so-many-th is kept: people also stay.
const STAY_ONE_IN: usize = 6;
/// Frames from one window of a take to the next.
const STEP: usize = 2;
/// Frames from one window that is measured on to the next.
const MEASURED_STEP: usize = 4;
/// Frames from one body for the sub-goals to the next (the published code's 15).
const BODY_STEP: usize = 15;
/// How often each activity is drawn: there are many walks and few sits.
const SHARES: [(Activity, f32); 5] = [
    (Activity::Walk, 0.5),
    (Activity::Sit, 0.22),
    (Activity::Floor, 0.12),
    (Activity::Rest, 0.04),
    (Activity::Spot, 0.12),
];

/// What a corpus is made of.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct MotionDataConfig {
    /// Root of the seed tree: split, turns, rooms.
    pub seed: u64,
    /// One clip of so many is held out for the test, and as many for validation, of every activity.
    pub held_out_one_in: usize,
    /// Every clip is there as its mirror image too.
    pub mirror: bool,
    /// Bodies drawn from the program's pose families, staged, for the sub-goals.
    pub family_bodies: usize,
}

impl Default for MotionDataConfig {
    fn default() -> Self {
        Self { seed: 0, held_out_one_in: 6, mirror: true, family_bodies: 1600 }
    }
}

/// Two seconds of a take: a body, sixty more, and a last one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// Which take.
    pub take: usize,
    /// Its first frame.
    pub first: usize,
}

/// A body that was put into a staged room, for the sub-goals.
#[derive(Clone, Debug)]
pub struct StagedBody {
    /// What it is for.
    pub split: Split,
    /// The body.
    pub frame: Frame,
    /// Its pose's code.
    pub code: [f32; POSE],
    /// A take whose room it is in, or a room of its own.
    pub room: BodyRoom,
}

/// Where a [`StagedBody`] is.
#[derive(Clone, Debug)]
pub enum BodyRoom {
    /// In the room of a take.
    Take(usize),
    /// In a room of its own.
    Own(Box<StagedRoom>),
}

/// Everything that is learnt from.
#[derive(Clone, Debug, Default)]
pub struct MotionData {
    /// Names what it was made from: a resumed training must have the same.
    pub id: String,
    /// All takes.
    pub takes: Vec<Take>,
    /// Bodies for the sub-goals.
    pub bodies: Vec<StagedBody>,
}

/// One window as the networks take it, in its own frame.
#[derive(Clone, Debug)]
pub struct WindowRows {
    /// [`WINDOW`] bodies.
    pub rows: Vec<[f32; ROW]>,
    /// The room around.
    pub cloud: Cloud,
    /// Where it is in the take's room.
    pub leg: LegFrame,
}

/// A body with what the sub-goal network is asked for, in a frame below it.
#[derive(Clone, Debug)]
pub struct BodyRow {
    /// The body.
    pub row: [f32; ROW],
    /// Pelvis, rotation, betas.
    pub asked: [f32; CONDITION],
    /// The room around.
    pub cloud: Cloud,
}

impl MotionData {
    /// Takes and bodies of clips.
    ///
    /// # Errors
    /// As [`takes_of`].
    pub fn from_clips(clips: &[PoseClip], config: &MotionDataConfig, ticker: &Ticker) -> Result<Self, Stop> {
        let takes = takes_of(clips, config, ticker)?;
        let names: Vec<String> = clips.iter().map(|c| format!("{} {}", c.name, c.frames.len())).collect();
        let about = format!("{config:?} {}", names.join(","));
        let mut data =
            Self { id: format!("{:032x}", content_hash(about.as_bytes())), takes, bodies: Vec::new() };
        data.bodies = data.take_bodies();
        data.bodies.extend(family_bodies(config, ticker)?);
        Ok(data)
    }

    /// The windows of one part that are learnt from or measured, `step` frames apart.
    pub fn windows(&self, split: Split, step: usize) -> Vec<Window> {
        let mut windows = Vec::new();
        for (number, take) in self.takes.iter().enumerate().filter(|(_, t)| t.split == split) {
            let starts = (0..=take.frames.len().saturating_sub(WINDOW)).step_by(step);
            for (i, first) in starts.enumerate() {
                let ends = [&take.frames[first], &take.frames[first + WINDOW - 1]];
                if happens(ends) || i % STAY_ONE_IN == 0 {
                    windows.push(Window { take: number, first });
                }
            }
        }
        windows
    }

    /// The windows that are learnt from.
    pub fn training_windows(&self) -> Vec<Window> {
        self.windows(Split::Train, STEP)
    }

    /// About `most` windows of one part, of every activity alike, evenly spaced: what is measured on.
    pub fn measured(&self, split: Split, most: usize) -> Vec<Window> {
        let windows = self.windows(split, MEASURED_STEP);
        let each = most / Activity::ALL.len();
        let mut chosen = Vec::new();
        for activity in Activity::ALL {
            let of: Vec<Window> =
                windows.iter().filter(|w| self.takes[w.take].activity == activity).copied().collect();
            chosen.extend(of.iter().step_by(of.len().div_ceil(each.max(1)).max(1)));
        }
        chosen
    }

    /// `count` windows drawn with the shares of the activities.
    pub fn draw(&self, windows: &[Window], count: usize, rng: &mut Rng) -> Vec<Window> {
        let of = |activity: Activity| -> Vec<Window> {
            windows.iter().filter(|w| self.takes[w.take].activity == activity).copied().collect()
        };
        let groups: Vec<(Vec<Window>, f32)> =
            SHARES.iter().map(|(a, share)| (of(*a), *share)).filter(|(g, _)| !g.is_empty()).collect();
        let total: f32 = groups.iter().map(|(_, share)| share).sum();
        let draw_one = |rng: &mut Rng| {
            let mut left = rng.random_range(0.0..total.max(f32::MIN_POSITIVE));
            let chosen = groups.iter().find(|(_, share)| {
                left -= share;
                left <= 0.0
            });
            let (group, _) = chosen.or(groups.last())?;
            Some(group[rng.random_range(0..group.len())])
        };
        (0..count).filter_map(|_| draw_one(rng)).collect()
    }

    /// A window in its own frame with `points` of its room.
    pub fn rows(&self, window: Window, points: usize, seed: Seed) -> WindowRows {
        let take = &self.takes[window.take];
        let rest = rest_pelvis();
        let frames = &take.frames[window.first..window.first + WINDOW];
        let codes = &take.codes[window.first..window.first + WINDOW];
        let leg = LegFrame::of(&frames[0], rest, 0.0);
        let ends = [frames[0].translation, frames[WINDOW - 1].translation];
        WindowRows {
            rows: frames.iter().zip(codes).map(|(f, c)| leg.row(f, c, rest)).collect(),
            cloud: take.room.points.around(&leg, ends, points, seed).0,
            leg,
        }
    }

    /// The room that a body is in.
    pub fn room_of<'a>(&'a self, body: &'a StagedBody) -> &'a StagedRoom {
        match &body.room {
            BodyRoom::Take(take) => &self.takes[*take].room,
            BodyRoom::Own(room) => room,
        }
    }

    /// A body in a frame below it.
    pub fn body_row(&self, body: &StagedBody, points: usize, seed: Seed) -> BodyRow {
        let rest = rest_pelvis();
        let leg = LegFrame::of(&body.frame, rest, 0.0);
        let row = leg.row(&body.frame, &body.code, rest);
        let mut asked = [0.0; CONDITION];
        asked[..PLACE].copy_from_slice(&row[..PLACE]);
        let ends = [body.frame.translation; 2];
        let cloud = self.room_of(body).points.around(&leg, ends, points, seed).0;
        BodyRow { row, asked, cloud }
    }

    /// Points of a random take of one part with their classes, about a random body of it.
    pub fn labelled(&self, split: Split, points: usize, rng: &mut Rng) -> Option<(Cloud, Vec<u8>)> {
        let takes: Vec<&Take> = self.takes.iter().filter(|t| t.split == split).collect();
        let take = takes.get(rng.random_range(0..takes.len().max(1)))?;
        let frame = &take.frames[rng.random_range(0..take.frames.len())];
        let leg = LegFrame::of(frame, rest_pelvis(), 0.0);
        let seed = Seed::root(rng.random_range(0..u64::MAX));
        Some(take.room.points.around(&leg, [frame.translation; 2], points, seed))
    }

    /// The bodies of one part.
    pub fn bodies_of(&self, split: Split) -> Vec<&StagedBody> {
        self.bodies.iter().filter(|b| b.split == split).collect()
    }

    fn take_bodies(&self) -> Vec<StagedBody> {
        let of_take = |(number, take): (usize, &Take)| {
            let body = move |i: usize, take: &Take| StagedBody {
                split: take.split,
                frame: take.frames[i].clone(),
                code: take.codes[i],
                room: BodyRoom::Take(number),
            };
            (0..take.frames.len()).step_by(BODY_STEP).map(|i| body(i, take)).collect::<Vec<_>>()
        };
        self.takes.iter().enumerate().flat_map(of_take).collect()
    }
}

fn rest_pelvis() -> Vec3 {
    Body::bundled().model.joint_template[PELVIS]
}

fn happens([start, end]: [&Frame; 2]) -> bool {
    let moved = (end.translation - start.translation).with_y(0.0).length();
    let risen = (end.translation.y - start.translation.y).abs();
    let turned = heading_of(end.rotation) - heading_of(start.rotation);
    let turned = turned.sin().atan2(turned.cos()).abs();
    moved > MOVED_M || risen > RISEN_M || turned > TURNED
}

/// Bodies of the program's own families, each put down by itself and furnished: captured sitting and lying are scarce.
fn family_bodies(config: &MotionDataConfig, ticker: &Ticker) -> Result<Vec<StagedBody>, Stop> {
    let families: Vec<PoseFamily> = PoseFamily::ALL.into_iter().filter(|f| f.group() != "lean").collect();
    ticker.stage("drawing and staging bodies", config.family_bodies)?;
    let seed = Seed::root(config.seed).child("family bodies", 0);
    (0..config.family_bodies)
        .into_par_iter()
        .map(|i| {
            ticker.advance()?;
            family_body(families[i % families.len()], i, seed.child("body", i as u64))
        })
        .collect()
}

fn family_body(family: PoseFamily, number: usize, seed: Seed) -> Result<StagedBody, Stop> {
    let body = Body::bundled();
    let mut rng = seed.rng();
    let seat_m = rng.random_range(0.38..0.52);
    let hints =
        FamilyHints { seat_height_m: (family.group() == "sit").then_some(seat_m), ..FamilyHints::default() };
    let drawn = sample_pose(&body.model.joint_template, family, &mut rng, &hints);
    let turn = glam::Mat3::from_rotation_y(rng.random_range(0.0..std::f32::consts::TAU));
    let params = drawn.params(body, [0.0; BETAS], &turn);
    let mut frame = Frame::of(&params, &drawn.pose);
    let on_bed = family.group() == "lie" || family == PoseFamily::SitStraight;
    let support_m = if on_bed { rng.random_range(0.35..0.6) } else { 0.0 };
    frame.translation.y += support_m - lowest_m(body, &frame);
    // One in ten is held out, as of clips.
    let split = match number % 10 {
        0 => Split::Test,
        1 => Split::Validation,
        _ => Split::Train,
    };
    let room = stage(body, std::slice::from_ref(&frame), seed.child("room", 0))?;
    Ok(StagedBody { split, frame, code: params.pose, room: BodyRoom::Own(Box::new(room)) })
}

fn lowest_m(body: &Body, frame: &Frame) -> f32 {
    let ids = (0..body.model.template.len() as u32).step_by(8).collect();
    let subset = VertexSubset::new(&body.model, ids);
    let mut workspace = Workspace::default();
    body.forward_posed(&frame.params(&[0.0; BETAS]), &frame.pose, &subset, &mut workspace);
    workspace.vertices().iter().map(|v| v.y).fold(f32::INFINITY, f32::min)
}
