//! A dictionary of poses by non-negative sparse coding (Hoyer 2002, with the updates of Mairal et al. 2009).

use glam::{Quat, Vec3};
use rand::RngExt as _;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{Joints3, coco, examples};
use crate::assets::photos::PHOTO_JOINTS;
use crate::inspect::Similarity;
use crate::job::{Cancelled, Seed, Ticker};
use crate::math::{LassoConfig, lasso};

/// Numbers of a pose.
const NUMBERS: usize = 3 * PHOTO_JOINTS;
/// The joints that say how a torso stands.
const TORSO: [usize; 4] = [coco::LEFT_SHOULDER, coco::RIGHT_SHOULDER, coco::LEFT_HIP, coco::RIGHT_HIP];

/// Bases whose sums with few non-negative weights are people's poses.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PoseDictionary {
    /// What it was learned from, and the command.
    pub note: String,
    /// Poses about the middle of their joints, torso upright and facing +Z, mean spread over the axes 1.
    pub bases: Vec<Joints3>,
}

/// Why a dictionary can't be used.
#[derive(Debug, thiserror::Error)]
pub enum PoseDictionaryError {
    /// Not the text it should be.
    #[error("pose dictionary: {0}; make the file again with `inhabit learn poses`")]
    Syntax(#[from] ron::error::SpannedError),
    /// Nothing or nonsense in it.
    #[error("pose dictionary: it holds no finite bases; make the file again with `inhabit learn poses`")]
    Empty,
}

impl PoseDictionary {
    /// Reads the RON text of a dictionary.
    ///
    /// # Errors
    /// [`PoseDictionaryError`].
    pub fn from_ron(text: &str) -> Result<Self, PoseDictionaryError> {
        let dictionary: Self = ron::from_str(text)?;
        let sound = dictionary.bases.iter().flatten().all(|p| p.is_finite());
        if sound && !dictionary.bases.is_empty() { Ok(dictionary) } else { Err(PoseDictionaryError::Empty) }
    }

    /// The RON text of a dictionary.
    ///
    /// # Errors
    /// What the serialiser says; it never fails on numbers.
    pub fn to_ron(&self) -> Result<String, ron::Error> {
        ron::ser::to_string_pretty(self, ron::ser::PrettyConfig::new().depth_limit(2))
    }
}

/// Settings of [`learn_dictionary`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DictionaryConfig {
    /// Bases; Zhou et al. use 64 to 128.
    pub bases: usize,
    /// Weight of the codes' sum: tuned so that a pose takes about ten bases.
    pub penalty: f32,
    /// Rounds of coding all poses and moving the bases.
    pub rounds: usize,
}

impl Default for DictionaryConfig {
    fn default() -> Self {
        Self { bases: 128, penalty: 0.04, rounds: 25 }
    }
}

/// How well a dictionary tells its own poses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DictionaryFit {
    /// Mean distance of a pose to its code's pose over the pose's size.
    pub relative_error: f32,
    /// Mean number of bases of a pose.
    pub active: f32,
}

/// Learns a dictionary from poses (of any place, size and facing) and their mirror images.
///
/// # Errors
/// [`Cancelled`] once the user cancelled.
pub fn learn_dictionary(
    poses: &[Joints3],
    config: &DictionaryConfig,
    seed: Seed,
    ticker: &Ticker,
) -> Result<(PoseDictionary, DictionaryFit), Cancelled> {
    let reference = poses.first().map_or([Vec3::ZERO; PHOTO_JOINTS], normalised);
    let both = poses.iter().flat_map(|p| [*p, examples::mirrored(p)]);
    let rows: Vec<[f32; NUMBERS]> =
        both.map(|p| flat(&upright(&normalised(&p), &reference))).filter(is_finite).collect();
    let mut bases = first_bases(&rows, config.bases, seed);
    let mut codes = vec![vec![0.0_f32; bases.len()]; rows.len()];
    ticker.stage("learning the pose dictionary", config.rounds)?;
    for round in 0..config.rounds {
        code(&rows, &bases, config.penalty, &mut codes);
        ticker.check()?;
        move_bases(&rows, &codes, &mut bases);
        ticker.step(round + 1, config.rounds)?;
    }
    code(&rows, &bases, config.penalty, &mut codes);
    let fit = fit_of(&rows, &bases, &codes);
    let unflat = |row: &[f32; NUMBERS]| std::array::from_fn(|j| Vec3::from_slice(&row[3 * j..]));
    let bases = bases.iter().map(unflat).map(|b: Joints3| rounded(&normalised(&b))).collect();
    Ok((PoseDictionary { note: String::new(), bases }, fit))
}

/// About the middle of the joints, with a mean standard deviation over the axes of one.
fn normalised(joints: &Joints3) -> Joints3 {
    let count = PHOTO_JOINTS as f32;
    let middle = joints.iter().sum::<Vec3>() / count;
    let variance = joints.iter().map(|p| (*p - middle) * (*p - middle)).sum::<Vec3>() / count;
    let spread = variance.to_array().map(f32::sqrt).iter().sum::<f32>() / 3.0;
    joints.map(|p| (p - middle) / spread.max(f32::MIN_POSITIVE))
}

/// Turned so that the torso stands as the reference's.
fn upright(joints: &Joints3, reference: &Joints3) -> Joints3 {
    let torso = |j: &Joints3| TORSO.map(|t| j[t]);
    let turn = Similarity::between(&torso(joints), &torso(reference)).rotation;
    let turn: Quat = turn.as_quat();
    joints.map(|p| turn * p)
}

fn flat(joints: &Joints3) -> [f32; NUMBERS] {
    std::array::from_fn(|i| joints[i / 3][i % 3])
}

fn is_finite(row: &[f32; NUMBERS]) -> bool {
    row.iter().all(|x| x.is_finite())
}

/// Digits that matter, so that the file is short.
fn rounded(joints: &Joints3) -> Joints3 {
    joints.map(|p| (p * 1e4).round() / 1e4)
}

/// Poses far from one another: each next one drawn by its squared distance to the nearest before.
fn first_bases(rows: &[[f32; NUMBERS]], count: usize, seed: Seed) -> Vec<[f32; NUMBERS]> {
    let mut rng = seed.child("first bases", 0).rng();
    let squared = |a: &[f32; NUMBERS], b: &[f32; NUMBERS]| -> f32 {
        a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
    };
    let mut bases: Vec<[f32; NUMBERS]> = Vec::new();
    let mut nearest = vec![1.0_f32; rows.len()];
    while bases.len() < count.min(rows.len()) {
        let total: f64 = nearest.iter().map(|d| f64::from(*d)).sum();
        let mut left = rng.random::<f64>() * total;
        let chosen = nearest.iter().position(|d| {
            left -= f64::from(*d);
            left <= 0.0
        });
        let base = rows[chosen.unwrap_or(rows.len() - 1)];
        let is_first = bases.is_empty();
        nearest.iter_mut().zip(rows).for_each(|(near, row)| {
            let distance = squared(row, &base);
            *near = if is_first { distance } else { near.min(distance) };
        });
        bases.push(base);
    }
    bases
}

/// Bases of every pose, non-negative and few.
fn code(rows: &[[f32; NUMBERS]], bases: &[[f32; NUMBERS]], penalty: f32, codes: &mut [Vec<f32>]) {
    let dot = |a: &[f32; NUMBERS], b: &[f32; NUMBERS]| -> f32 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let gram: Vec<f32> = bases.iter().flat_map(|a| bases.iter().map(move |b| dot(a, b))).collect();
    // A pose has a squared length of about 3 times its joints; the penalty is per number of that.
    let config =
        LassoConfig { penalty: penalty * NUMBERS as f32, non_negative: true, sweeps: 30, tolerance: 1e-3 };
    rows.par_iter().zip(codes).for_each(|(row, code)| {
        let linear: Vec<f32> = bases.iter().map(|b| dot(b, row)).collect();
        lasso(&gram, &linear, &config, code);
    });
}

/// Moves each base to where it serves its poses best, none longer than a pose (Mairal et al. 2009, algorithm 2).
fn move_bases(rows: &[[f32; NUMBERS]], codes: &[Vec<f32>], bases: &mut [[f32; NUMBERS]]) {
    let n = bases.len();
    let (mut both, mut pulled) = (vec![0.0_f64; n * n], vec![[0.0_f64; NUMBERS]; n]);
    for (row, code) in rows.iter().zip(codes) {
        for i in (0..n).filter(|i| code[*i] > 0.0) {
            let weight = f64::from(code[i]);
            (0..n).for_each(|j| both[i * n + j] += weight * f64::from(code[j]));
            pulled[i].iter_mut().zip(row).for_each(|(p, x)| *p += weight * f64::from(*x));
        }
    }
    let longest = (NUMBERS as f64).sqrt();
    for i in (0..n).filter(|i| both[i * n + i] > 1e-9) {
        let mut next = [0.0_f64; NUMBERS];
        for (k, x) in next.iter_mut().enumerate() {
            let told: f64 = (0..n).map(|j| both[i * n + j] * f64::from(bases[j][k])).sum();
            *x = f64::from(bases[i][k]) + (pulled[i][k] - told) / both[i * n + i];
        }
        let length = next.iter().map(|x| x * x).sum::<f64>().sqrt();
        let scale = (longest / length.max(1e-9)).min(1.0);
        bases[i].iter_mut().zip(next).for_each(|(b, x)| *b = (x * scale) as f32);
    }
}

fn fit_of(rows: &[[f32; NUMBERS]], bases: &[[f32; NUMBERS]], codes: &[Vec<f32>]) -> DictionaryFit {
    let (mut error, mut active) = (0.0, 0.0);
    for (row, code) in rows.iter().zip(codes) {
        let told = |k: usize| -> f32 { bases.iter().zip(code).map(|(b, c)| b[k] * c).sum() };
        let off: f32 = row.iter().enumerate().map(|(k, x)| (x - told(k)).powi(2)).sum();
        let size: f32 = row.iter().map(|x| x * x).sum();
        error += (off / size.max(f32::MIN_POSITIVE)).sqrt();
        active += code.iter().filter(|c| **c > 0.0).count() as f32;
    }
    let count = rows.len().max(1) as f32;
    DictionaryFit { relative_error: error / count, active: active / count }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Body;

    fn poses(count: usize) -> Vec<Joints3> {
        let body = Body::bundled();
        let drawn = examples::family_poses(body, count, Seed::root(3), &Ticker::silent()).expect("drawn");
        let mut placer = examples::JointPlacer::new(body);
        drawn.iter().map(|pose| placer.joints(pose)).collect()
    }

    #[test]
    fn sums_of_few_bases_tell_poses_and_more_bases_tell_them_better() {
        let poses = poses(30);
        let error = |bases: usize| {
            let config = DictionaryConfig { bases, rounds: 6, ..DictionaryConfig::default() };
            let (dictionary, fit) =
                learn_dictionary(&poses, &config, Seed::root(1), &Ticker::silent()).expect("learned");
            assert_eq!(dictionary.bases.len(), bases);
            assert!(fit.active < 20.0, "{fit:?}");
            fit.relative_error
        };
        let (few, many) = (error(8), error(48));
        assert!(many < 0.25 && many < 0.8 * few, "{many} with 48, {few} with 8");
    }

    #[test]
    fn a_dictionary_survives_a_round_trip_and_an_empty_one_is_refused() {
        let dictionary = PoseDictionary { note: "test".into(), bases: poses(1) };
        let text = dictionary.to_ron().expect("text");
        assert_eq!(PoseDictionary::from_ron(&text).expect("sound"), dictionary);
        assert!(matches!(PoseDictionary::from_ron("(note:\"\",bases:[])"), Err(PoseDictionaryError::Empty)));
    }

    #[test]
    fn mirror_images_exchange_left_and_right() {
        let pose = poses(1)[0];
        let mirrored = examples::mirrored(&pose);
        let wrist = pose[coco::LEFT_WRIST];
        assert_eq!(mirrored[coco::RIGHT_WRIST], Vec3::new(-wrist.x, wrist.y, wrist.z));
        assert_eq!(examples::mirrored(&mirrored), pose);
    }
}
