//! Offline learning: clips and annotations in, statistics and weights out. May not be called from the
//! document, the renderer or the editor's frame; the command line and jobs run it.

pub mod actions;
pub mod corpus;
pub mod estimation;
pub mod evaluate_psi;
pub mod gait;
pub mod motion;
pub mod psi;
pub mod stage;

mod hand_space;
mod pose_corpus;
mod pose_loss;
mod pose_prior;
mod refine_study;

pub use hand_space::fit_hand_space;
pub use pose_corpus::{PoseCorpus, PoseCorpusConfig, PoseGroup};
pub use pose_loss::{PoseLoss, PoseLossTerms, PoseLossWeights};
pub use pose_prior::{
    PosePriorConfig, PosePriorPoint, ResumeError, SHIPPED_PRECISION, TrainedPosePrior, train_pose_prior,
};
pub use refine_study::{Disturbance, PlausibilityRow, random_placements};
