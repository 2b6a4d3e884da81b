use serde::{Deserialize, Serialize};

use crate::nn::psi::{PsiConfig, PsiMethod};

/// How the KL weight grows to its full value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Annealing {
    /// PSI §3.4.
    Linear,
    /// The published code: the square of the linear factor.
    Squared,
}

/// How the step size changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum RateSchedule {
    /// PSI §3.4.
    Constant,
    /// Falls to a twentieth along half a cosine: gets further in few epochs.
    Cosine,
}

impl RateSchedule {
    /// Factor on the step size after this share of the training.
    pub fn factor(self, done: f32) -> f32 {
        match self {
            Self::Constant => 1.0,
            Self::Cosine => 0.05 + 0.95 * 0.5 * (1.0 + (std::f32::consts::PI * done.min(1.0)).cos()),
        }
    }
}

/// Named weights.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum LossPreset {
    /// PSI §3.4.
    Paper,
    /// What the published scripts pass.
    Code,
}

/// The α's of PSI eq. 1, and the baseline's own. All terms are means, as in the published code.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LossWeights {
    /// α_kl.
    pub kl: f32,
    /// How α_kl grows.
    pub annealing: Annealing,
    /// α_vp.
    pub pose_prior: f32,
    /// α_cont, from [`PsiTraining::late`] on and only with the scene loss.
    pub contact: f32,
    /// α_coll, likewise.
    pub collision: f32,
    /// c of the robust distance r/(r + c) in metres (1 in the published training).
    pub robust_c_m: f32,
    /// The baseline's cross-entropy of the pose class.
    pub class: f32,
    /// The baseline's discriminator; the weights of Li et al. are not public, this keeps it from ruling.
    pub adversarial: f32,
}

impl From<LossPreset> for LossWeights {
    fn from(preset: LossPreset) -> Self {
        let paper = Self {
            kl: 0.1,
            annealing: Annealing::Linear,
            pose_prior: 1e-3,
            contact: 1e-3,
            collision: 1e-2,
            robust_c_m: 1.0,
            class: 0.1,
            adversarial: 0.01,
        };
        match preset {
            LossPreset::Paper => paper,
            LossPreset::Code => {
                Self { kl: 0.01, annealing: Annealing::Squared, contact: 0.01, collision: 0.1, ..paper }
            }
        }
    }
}

/// Weights of L_HS on bodies of drawn codes.
///
/// The paper's L_HS sees reconstructions, whose codes know where the body is; what is sampled later comes from codes that
/// know nothing, and nothing in eq. 1 says that these bodies must stand on a floor. Ours says it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DrawnWeights {
    /// Eq. 7.
    pub contact: f32,
    /// Eq. 6.
    pub collision: f32,
    /// c of eq. 7's robust distance, metres: small, so that what is near a surface touches it and the rest stays.
    pub robust_c_m: f32,
}

impl Default for DrawnWeights {
    fn default() -> Self {
        Self { contact: 1.0, collision: 1.0, robust_c_m: 0.1 }
    }
}

/// A whole training.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PsiTraining {
    /// The network.
    pub network: PsiConfig,
    /// Root of the seed tree.
    pub seed: u64,
    /// Times that every body is seen, each time from one of its views.
    pub epochs: usize,
    /// Bodies of one step.
    pub batch: usize,
    /// Adam's step size.
    pub learning_rate: f32,
    /// How it changes.
    pub schedule: RateSchedule,
    /// Weights of the terms.
    pub weights: LossWeights,
    /// Whether L_HS (eq. 6, 7) joins in late.
    pub scene_loss: bool,
    /// With it, as late: L_HS on bodies of codes drawn from N(0, I), as many as are reconstructed.
    #[serde(default)]
    pub drawn: Option<DrawnWeights>,
    /// Share of the epochs after which the KL weight is full and L_HS begins (PSI §3.4: 75 %).
    pub late: f32,
    /// Half of the pictures are mirrored, with their bodies.
    pub mirror: bool,
    /// Largest turn of the camera to either side and up or down, degrees: virtual cameras aim at the body, which
    /// would else always be in the middle (the published code's noise on the camera moved it; algorithms 1.7).
    pub turn_deg: [f32; 2],
    /// Deviation of the noise on each pixel's depth, as a share of the depth.
    pub depth_noise: f32,
}

impl PsiTraining {
    /// The paper's settings (§3.4; batch 32 from the published code).
    pub fn paper(method: PsiMethod) -> Self {
        Self {
            network: PsiConfig::paper(method),
            seed: 0,
            epochs: 30,
            batch: 32,
            learning_rate: 3e-4,
            schedule: RateSchedule::Constant,
            weights: LossPreset::Paper.into(),
            scene_loss: false,
            drawn: None,
            late: 0.75,
            mirror: true,
            turn_deg: [20.0, 10.0],
            depth_noise: 0.005,
        }
    }

    /// The compact network with a larger, falling step: for minutes instead of hours.
    pub fn compact(method: PsiMethod) -> Self {
        Self {
            network: PsiConfig::compact(method),
            learning_rate: 1e-3,
            schedule: RateSchedule::Cosine,
            ..Self::paper(method)
        }
    }

    /// The first epoch in which the late terms count.
    pub fn late_epoch(&self) -> usize {
        (self.epochs as f32 * self.late).ceil() as usize
    }

    /// α_kl after `progress` epochs.
    pub fn kl_weight(&self, progress: f32) -> f32 {
        let share = (progress / (self.epochs as f32 * self.late).max(1e-6)).min(1.0);
        self.weights.kl
            * match self.weights.annealing {
                Annealing::Linear => share,
                Annealing::Squared => share * share,
            }
    }

    /// Factor on the step size after `progress` epochs.
    pub fn rate(&self, progress: f32) -> f32 {
        self.schedule.factor(progress / self.epochs.max(1) as f32)
    }

    /// Whether a run of these settings may go on from a state of `other` at the start of `epoch`: nothing that
    /// counted until then may differ. The scene loss counts from [`PsiTraining::late_epoch`] on only, so S1 and
    /// S1 + L_HS share their first three quarters.
    pub fn continues(&self, other: &Self, epoch: usize) -> bool {
        let same_until_late =
            Self { scene_loss: other.scene_loss, drawn: other.drawn, ..self.clone() } == *other;
        self == other || (same_until_late && epoch <= self.late_epoch())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kl_weight_grows_linearly_in_the_paper_and_squared_in_its_code() {
        let mut training = PsiTraining { epochs: 40, ..PsiTraining::paper(PsiMethod::S1) };
        assert_eq!([0.0, 15.0, 30.0, 39.0].map(|e| training.kl_weight(e)), [0.0, 0.05, 0.1, 0.1]);
        training.weights.annealing = Annealing::Squared;
        assert!((training.kl_weight(15.0) - 0.025).abs() < 1e-7);
    }

    #[test]
    fn a_run_with_the_scene_loss_may_branch_off_only_before_that_counts() {
        let plain = PsiTraining { epochs: 40, ..PsiTraining::paper(PsiMethod::S1) };
        let with = PsiTraining { scene_loss: true, ..plain.clone() };
        assert_eq!(plain.late_epoch(), 30);
        assert!(with.continues(&plain, 30) && !with.continues(&plain, 31) && plain.continues(&plain, 39));
        assert!(!PsiTraining { seed: 1, ..plain.clone() }.continues(&plain, 1));
    }
}
