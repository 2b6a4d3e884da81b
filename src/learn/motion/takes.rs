//! Clips made into takes: pieces of motion some seconds long, each with its pose codes and a room staged around it.

use std::collections::BTreeMap;

use glam::Vec3;
use rayon::prelude::*;

use super::data::MotionDataConfig;
use super::staging::{StagedRoom, stage, turned};
use crate::assets::{ContentHasher, PoseClip, cache};
use crate::body::Body;
use crate::body::joints::PELVIS;
use crate::job::{Seed, Stop, Ticker};
use crate::learn::corpus::Split;
use crate::motion::capture::{Recording, record, resampled};
use crate::nn::motion::BETWEEN;
use crate::scene::{Frame, POSE};

/// Longest take, frames: seven seconds. Rooms of longer ones would be halls.
const LONGEST: usize = 210;
/// Frames of one window: both ends and what is between (LTM §4.1).
pub const WINDOW: usize = BETWEEN + 2;
/// Speeds at which sitting down and getting up is learnt, for there are few clips of it.
const SPEEDS: [f32; 3] = [1.0, 0.8, 1.25];
/// Faster clips are runs, which no room is large enough for, metres a second.
const FASTEST_M_PER_S: f32 = 2.3;
/// Changes whenever the same poses get other codes.
const CODES_VERSION: u32 = 1;

/// What somebody does in a clip, roughly: what the split and the draw are balanced over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
pub enum Activity {
    /// Walks.
    Walk,
    /// Sits down, crouches or kneels, or gets up from there.
    Sit,
    /// Lies down or gets up from the floor, or crawls.
    Floor,
    /// Stays as they sit, crouch or lie.
    Rest,
    /// Stands and does something on the spot, or jumps.
    Spot,
}

impl Activity {
    /// Every one.
    pub const ALL: [Self; 5] = [Self::Walk, Self::Sit, Self::Floor, Self::Rest, Self::Spot];

    /// Name in reports.
    pub fn label(self) -> &'static str {
        match self {
            Self::Walk => "walk",
            Self::Sit => "sit down and get up",
            Self::Floor => "lie down, get up, crawl",
            Self::Rest => "stay",
            Self::Spot => "on the spot",
        }
    }

    /// `None` for what nobody does indoors.
    fn of(recording: &Recording) -> Option<Self> {
        let heights = || recording.frames.iter().map(|f| f.translation.y);
        let (lowest, highest) = (heights().fold(f32::INFINITY, f32::min), heights().fold(0.0, f32::max));
        let flat = |f: &Frame| f.translation.with_y(0.0);
        let way_m: f32 = recording.frames.windows(2).map(|p| flat(&p[0]).distance(flat(&p[1]))).sum();
        let speed_m_per_s = way_m / recording.seconds().max(0.1);
        match (lowest, highest - lowest, speed_m_per_s) {
            (_, _, speed) if speed > FASTEST_M_PER_S => None,
            // Whoever rises above their own standing height jumps.
            _ if highest > 1.1 => Some(Self::Spot),
            (low, range, _) if low < 0.65 && range < 0.12 => Some(Self::Rest),
            (low, ..) if low < 0.4 => Some(Self::Floor),
            (low, ..) if low < 0.65 => Some(Self::Sit),
            (.., speed) if speed > 0.45 => Some(Self::Walk),
            _ => Some(Self::Spot),
        }
    }
}

/// A piece of a clip in a room.
#[derive(Clone, Debug)]
pub struct Take {
    /// The clip.
    pub clip: String,
    /// What it is for.
    pub split: Split,
    /// What is done.
    pub activity: Activity,
    /// The motion, 30 frames a second, floor at y = 0.
    pub frames: Vec<Frame>,
    /// The pose code of each frame.
    pub codes: Vec<[f32; POSE]>,
    /// The room.
    pub room: StagedRoom,
}

/// All clips as takes: mirrored, at several speeds, split by clip, coded, each in its own room.
///
/// # Errors
/// [`Stop::Cancelled`] once the user cancelled; [`Stop::Failed`] when a room doesn't compose.
pub fn takes_of(clips: &[PoseClip], config: &MotionDataConfig, ticker: &Ticker) -> Result<Vec<Take>, Stop> {
    let body = Body::bundled();
    ticker.stage("carrying clips over", clips.len())?;
    let recordings: Vec<Option<Recording>> = clips
        .par_iter()
        .map(|clip| {
            ticker.advance()?;
            Ok(record(clip, body))
        })
        .collect::<Result<_, Stop>>()?;
    let long_enough = |r: &Recording| r.frames.len() >= WINDOW && Activity::of(r).is_some();
    let recordings: Vec<Recording> = recordings.into_iter().flatten().filter(long_enough).collect();
    let splits = split_by_clip(&recordings, config);
    let mut pieces = Vec::new();
    for recording in &recordings {
        let (split, activity) = splits[&recording.name];
        pieces.extend(pieces_of(recording, split, activity, body, config));
    }
    ticker.stage("poses to codes", pieces.len())?;
    let mut takes: Vec<Take> = pieces
        .into_par_iter()
        .map(|mut take| {
            ticker.advance()?;
            take.codes = codes_of(body, &take.frames);
            Ok(take)
        })
        .collect::<Result<_, Stop>>()?;
    ticker.stage("staging rooms", takes.len())?;
    let seed = Seed::root(config.seed).child("rooms", 0);
    takes.par_iter_mut().enumerate().try_for_each(|(i, take)| -> Result<(), Stop> {
        ticker.advance()?;
        take.room = stage(body, &take.frames, seed.child(&take.clip, i as u64))?;
        Ok(())
    })?;
    Ok(takes)
}

/// By clip, within each activity: no clip is in two parts, and every part sees every activity that has clips enough.
fn split_by_clip(recordings: &[Recording], config: &MotionDataConfig) -> BTreeMap<String, (Split, Activity)> {
    let mut of_activity: BTreeMap<Activity, Vec<&str>> = BTreeMap::new();
    for recording in recordings {
        if let Some(activity) = Activity::of(recording) {
            of_activity.entry(activity).or_default().push(&recording.name);
        }
    }
    let seed = Seed::root(config.seed).child("split", 0);
    let mut splits = BTreeMap::new();
    for (activity, mut names) in of_activity {
        names.sort_by_key(|name| (seed.child(name, 0).value(), name.to_owned()));
        let held_out = if names.len() < 3 { 0 } else { (names.len() / config.held_out_one_in).max(1) };
        for (i, name) in names.iter().enumerate() {
            let split = match i {
                i if i < held_out => Split::Test,
                i if i < 2 * held_out => Split::Validation,
                _ => Split::Train,
            };
            splits.insert((*name).to_owned(), (split, activity));
        }
    }
    splits
}

fn pieces_of(
    recording: &Recording,
    split: Split,
    activity: Activity,
    body: &Body,
    config: &MotionDataConfig,
) -> Vec<Take> {
    let rest = body.model.joint_template[PELVIS];
    let seed = Seed::root(config.seed).child("turn", 0).child(&recording.name, 0);
    let scarce = matches!(activity, Activity::Sit | Activity::Floor);
    // Held-out clips are measured as they are.
    let speeds = if scarce && split == Split::Train { &SPEEDS[..] } else { &SPEEDS[..1] };
    let images = if config.mirror { 2 } else { 1 };
    let mut takes = Vec::new();
    for speed in speeds {
        for image in 0..images {
            let plain = resampled(&recording.frames, *speed);
            let plain = Recording { frames: plain, ..recording.clone() };
            let source = if image == 0 { plain } else { plain.mirror_image(body) };
            // Walls and clips of a database tend to run along the same axes.
            let number = seed.child("image", image + 2 * (*speed * 100.0) as u64).value();
            let turn = (number % 6283) as f32 * 1e-3;
            for first in (0..source.frames.len().saturating_sub(WINDOW - 1)).step_by(LONGEST - WINDOW) {
                let end = (first + LONGEST).min(source.frames.len());
                if end - first < WINDOW {
                    break;
                }
                let piece = &source.frames[first..end];
                let origin = piece[0].translation.with_y(0.0);
                let frame = |f: &Frame| {
                    let at_origin = Frame { translation: f.translation - origin, ..f.clone() };
                    turned(&at_origin, turn, rest)
                };
                takes.push(Take {
                    clip: recording.name.clone(),
                    split,
                    activity,
                    frames: piece.iter().map(frame).collect(),
                    codes: Vec::new(),
                    room: StagedRoom::default(),
                });
            }
        }
    }
    takes
}

/// The code of each frame's pose; from the disk cache where the same poses were coded before.
fn codes_of(body: &Body, frames: &[Frame]) -> Vec<[f32; POSE]> {
    let key = codes_key(body, frames);
    let kept = cache::get(&key).filter(|bytes| bytes.len() == frames.len() * POSE * 4);
    if let Some(bytes) = kept {
        let numbers: Vec<f32> =
            bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
        return numbers.chunks_exact(POSE).map(|code| std::array::from_fn(|i| code[i])).collect();
    }
    let mut codes: Vec<[f32; POSE]> = Vec::with_capacity(frames.len());
    for (i, frame) in frames.iter().enumerate() {
        // Loops and held ends repeat themselves.
        let same = (i > 0 && frames[i - 1].pose == frame.pose).then(|| codes[i - 1]);
        codes.push(same.unwrap_or_else(|| body.pose_space.encode(&frame.pose)));
    }
    let bytes: Vec<u8> = codes.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    cache::put(&key, &bytes);
    codes
}

fn codes_key(body: &Body, frames: &[Frame]) -> String {
    let mut hasher = ContentHasher::default();
    let mut write = |v: &Vec3| v.to_array().iter().for_each(|x| hasher.write(&x.to_le_bytes()));
    frames.iter().flat_map(|f| &f.pose).for_each(&mut write);
    // Another prior decodes the same code to another pose.
    body.pose_space.decode(&[0.4; POSE]).iter().for_each(&mut write);
    format!("pose codes {CODES_VERSION} {:032x}", hasher.finish())
}
