use std::sync::OnceLock;

use glam::{Mat3, Vec2, Vec3};

use super::convex::{self, ConvexConfig, Seen};
use super::refine::{self, RefineConfig, Refined};
use super::{Joints3, PoseDictionary, middle_of_hips, middle_of_shoulders};
use crate::assets::Keypoint;
use crate::assets::photos::PHOTO_JOINTS;

const BUNDLED: &str = include_str!("../../../../assets/actions/pose_dictionary.ron");

/// With fewer marked joints a pose is not sought.
pub const SOLVED_JOINTS_LEAST: usize = 6;

/// Settings of [`PoseSolver`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseSolverConfig {
    /// λ of the relaxation and of the refinement, for points of unit spread.
    pub penalty: f32,
    /// Whether one rotation is refined after the relaxation.
    pub refine: bool,
    /// Whether shares below zero are left out in the refinement.
    pub non_negative: bool,
    /// Weight of nose, eyes and ears, of which there are five in one place.
    pub face_weight: f32,
    /// Most rounds of the relaxation.
    pub rounds: usize,
    /// Both residuals of the relaxation end below this share.
    pub tolerance: f32,
}

impl Default for PoseSolverConfig {
    fn default() -> Self {
        Self {
            penalty: 0.1,
            refine: true,
            non_negative: true,
            face_weight: 0.4,
            rounds: 400,
            tolerance: 1e-3,
        }
    }
}

/// A person's joints in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose3d {
    /// In the camera's frame, lengths in pixels of the photo: x and y are a pixel's (y up, so its sign is turned), z
    /// towards the viewer with an arbitrary origin. Joints that nobody marked are guesses.
    pub joints_px: Joints3,
    /// Turns the pose's own frame into the camera's.
    pub camera_from_pose: Mat3,
    /// Which joints were marked.
    pub marked: [bool; PHOTO_JOINTS],
    /// Root mean square distance of marked joints to where the pose is seen, over the torso's length.
    pub misfit: f32,
}

impl Pose3d {
    /// Length of the torso in space, pixels.
    pub fn torso_px(&self) -> f32 {
        middle_of_shoulders(&self.joints_px).distance(middle_of_hips(&self.joints_px))
    }
}

/// Finds poses in space with a dictionary.
pub struct PoseSolver<'a> {
    dictionary: &'a PoseDictionary,
    config: PoseSolverConfig,
}

impl PoseDictionary {
    /// The dictionary that ships with the program.
    ///
    /// # Panics
    /// Never with the embedded data, which a test reads.
    pub fn bundled() -> &'static Self {
        static DICTIONARY: OnceLock<PoseDictionary> = OnceLock::new();
        DICTIONARY.get_or_init(|| Self::from_ron(BUNDLED).expect("the bundled dictionary is sound"))
    }
}

/// Marked joints as the solver takes them.
struct Points {
    joints: Vec<usize>,
    weights: Vec<f32>,
    /// About their weighted middle, over their spread, times the root of the weight.
    normalised: Vec<[f32; 2]>,
    middle: Vec2,
    spread: f32,
}

impl<'a> PoseSolver<'a> {
    /// With a dictionary.
    pub fn new(dictionary: &'a PoseDictionary, config: PoseSolverConfig) -> Self {
        Self { dictionary, config }
    }

    /// The pose of somebody with these joints in a photo (pixels, y down); `None` with fewer than
    /// [`SOLVED_JOINTS_LEAST`] or all in one place.
    pub fn solve(&self, joints: &[Keypoint; PHOTO_JOINTS]) -> Option<Pose3d> {
        let points = self.points(joints)?;
        let seen = Seen::of(&self.dictionary.bases, &points.joints, &points.weights);
        let config = ConvexConfig {
            penalty: self.config.penalty,
            tolerance: self.config.tolerance,
            rounds: self.config.rounds,
        };
        let found = convex::solve(&seen, &points.normalised, &config);
        let (rows, few) = convex::common_rotation(&found)?;
        let mut shares = vec![0.0; self.dictionary.bases.len()];
        few.into_iter().for_each(|(i, share)| shares[i] = share);
        let rotation = refine::complete(&rows);
        let solved = if self.config.refine {
            let config = RefineConfig {
                penalty: self.config.penalty,
                non_negative: self.config.non_negative,
                tolerance: 1e-3,
                rounds: 25,
            };
            refine::refine(&seen, &points.normalised, rotation, shares, &config)
        } else {
            Refined { rotation, shares, objective: 0.0 }
        };
        Some(self.pose(&points, &seen, &solved))
    }

    fn points(&self, joints: &[Keypoint; PHOTO_JOINTS]) -> Option<Points> {
        let marked: Vec<usize> = (0..PHOTO_JOINTS).filter(|j| joints[*j].confidence > 0.0).collect();
        if marked.len() < SOLVED_JOINTS_LEAST {
            return None;
        }
        let face = |j: usize| if j < FACE_JOINTS { self.config.face_weight } else { 1.0 };
        let weights: Vec<f32> = marked.iter().map(|j| face(*j) * joints[*j].confidence).collect();
        let total: f32 = weights.iter().sum();
        let pixel = |j: usize| Vec2::new(joints[j].pixel.x, -joints[j].pixel.y);
        let middle = marked.iter().zip(&weights).map(|(j, w)| pixel(*j) * *w).sum::<Vec2>() / total;
        let variance = marked
            .iter()
            .zip(&weights)
            .map(|(j, w)| (pixel(*j) - middle) * (pixel(*j) - middle) * *w)
            .sum::<Vec2>()
            / total;
        let spread = 0.5 * (variance.x.sqrt() + variance.y.sqrt());
        if !(spread > 0.0 && spread.is_finite()) {
            return None;
        }
        let normal = |(j, w): (&usize, &f32)| ((pixel(*j) - middle) * (w.sqrt() / spread)).to_array();
        let normalised = marked.iter().zip(&weights).map(normal).collect();
        Some(Points { joints: marked, weights, normalised, middle, spread })
    }

    fn pose(&self, points: &Points, seen: &Seen, solved: &Refined) -> Pose3d {
        let mut joints_px = [Vec3::ZERO; PHOTO_JOINTS];
        for (i, share) in solved.shares.iter().enumerate().filter(|(_, s)| **s != 0.0) {
            let basis = &self.dictionary.bases[i];
            joints_px.iter_mut().zip(basis).for_each(|(sum, b)| *sum += (*b - seen.middles[i]) * *share);
        }
        let middle = points.middle.extend(0.0);
        let joints_px = joints_px.map(|p| middle + solved.rotation * p * points.spread);
        let mut marked = [false; PHOTO_JOINTS];
        points.joints.iter().for_each(|j| marked[*j] = true);
        let mut pose = Pose3d { joints_px, camera_from_pose: solved.rotation, marked, misfit: 0.0 };
        let off = |((j, w), n): ((&usize, &f32), &[f32; 2])| {
            let at = points.middle + Vec2::from_array(*n) * (points.spread / w.sqrt());
            at.distance_squared(joints_px[*j].truncate())
        };
        let squares = points.joints.iter().zip(&points.weights).zip(&points.normalised).map(off);
        let mean = squares.sum::<f32>() / points.joints.len() as f32;
        pose.misfit = mean.sqrt() / pose.torso_px().max(f32::MIN_POSITIVE);
        pose
    }
}

/// Nose, eyes and ears lead COCO's list.
const FACE_JOINTS: usize = 5;

#[cfg(test)]
mod tests;
