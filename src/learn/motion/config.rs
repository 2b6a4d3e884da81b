use serde::{Deserialize, Serialize};

use super::data::MotionDataConfig;
use crate::learn::psi::RateSchedule;
use crate::nn::motion::{
    Between, HAND_COLUMNS, MotionConfig, MotionKind, POSE_COLUMNS, TURN_COLUMNS, WHERE_COLUMNS,
};

/// Named settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum MotionPreset {
    /// LTM §4.1 and the published sizes.
    Paper,
    /// Small networks for minutes on one core.
    Compact,
}

/// Weights of the terms; all are means over frames and numbers, as in the published code.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MotionWeights {
    /// λ_t of eq. 3: distance of the places.
    pub place: f32,
    /// λ_r of eq. 3: distance of the rotations' six numbers.
    pub turn: f32,
    /// λ_p of eq. 4: distance of the pose codes.
    pub pose: f32,
    /// λ_h of eq. 4: distance of the hand codes.
    pub hands: f32,
    /// KL divergence of the sub-goals' codes once it is annealed.
    pub kl: f32,
    /// Contact of the sub-goals' bodies (PSI eq. 7), late.
    pub contact: f32,
    /// Collision of the sub-goals' bodies (PSI eq. 6), late.
    pub collision: f32,
}

/// A whole training.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MotionTraining {
    /// The network.
    pub network: MotionConfig,
    /// What it learns from.
    pub data: MotionDataConfig,
    /// Root of the seed tree.
    pub seed: u64,
    /// Rounds over [`MotionTraining::drawn`] windows, each followed by a look at the validation clips.
    pub epochs: usize,
    /// Windows, bodies or clouds of one epoch, drawn with the shares of the activities.
    pub drawn: usize,
    /// Of one step.
    pub batch: usize,
    /// Adam's step size.
    pub learning_rate: f32,
    /// How it changes.
    pub schedule: RateSchedule,
    /// Weights of the terms.
    pub weights: MotionWeights,
    /// Share of the epochs after which the KL weight is full and contact and collision begin.
    pub late: f32,
    /// Deviation of the noise on the two ends' pose and hand codes, and ten times less on their places in metres: at use
    /// they come from elsewhere, and few clips are learnt by heart soon.
    pub end_noise: f32,
}

impl MotionTraining {
    /// The settings of LTM §4.1.
    pub fn paper(kind: MotionKind) -> Self {
        let (epochs, batch) = match kind {
            MotionKind::SubGoal => (40, 16),
            MotionKind::Between(Between::Route | Between::RouteWhere) => (20, 32),
            _ => (20, 16),
        };
        Self {
            network: MotionConfig::paper(kind),
            data: MotionDataConfig::default(),
            seed: 0,
            epochs,
            drawn: 10_000,
            batch,
            learning_rate: 1e-3,
            schedule: RateSchedule::Constant,
            weights: MotionWeights {
                place: 1.0,
                turn: 1.0,
                pose: 1.0,
                hands: 0.1,
                kl: 0.1,
                contact: 0.01,
                collision: 0.01,
            },
            late: 0.75,
            end_noise: 0.0,
        }
    }

    /// The compact network with a falling step.
    pub fn compact(kind: MotionKind) -> Self {
        let paper = Self::paper(kind);
        Self {
            network: MotionConfig::compact(kind),
            drawn: 2048,
            batch: 32,
            epochs: 40,
            learning_rate: 1.5e-3,
            schedule: RateSchedule::Cosine,
            end_noise: 0.15,
            ..paper
        }
    }

    /// Named settings for one network.
    pub fn of(preset: MotionPreset, kind: MotionKind) -> Self {
        match preset {
            MotionPreset::Paper => Self::paper(kind),
            MotionPreset::Compact => Self::compact(kind),
        }
    }

    /// The first epoch in which the late terms count.
    pub fn late_epoch(&self) -> usize {
        (self.epochs as f32 * self.late).ceil() as usize
    }

    /// The KL weight after `progress` epochs: rises linearly (PSI §3.4).
    pub fn kl_weight(&self, progress: f32) -> f32 {
        self.weights.kl * (progress / (self.epochs as f32 * self.late).max(1e-6)).min(1.0)
    }

    /// Factor on the step size after `progress` epochs.
    pub fn rate(&self, progress: f32) -> f32 {
        self.schedule.factor(progress / self.epochs.max(1) as f32)
    }

    /// The weight of each of a body's columns.
    pub fn column_weight(&self, column: usize) -> f32 {
        let MotionWeights { place, turn, pose, hands, .. } = self.weights;
        match column {
            c if WHERE_COLUMNS.contains(&c) => place,
            c if TURN_COLUMNS.contains(&c) => turn,
            c if POSE_COLUMNS.contains(&c) => pose,
            c if HAND_COLUMNS.contains(&c) => hands,
            _ => 0.0,
        }
    }
}
