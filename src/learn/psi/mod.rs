//! Trains the networks of PSI on a corpus of people in rooms (PSI §3.2.2, §3.4, §4.1.2).
//!
//! Pure: takes and gives numbers and bytes; whoever calls reads and writes the files. The same corpus,
//! configuration and seed give the same bytes, whatever the number of threads, and a resumed run goes on
//! to the bit.

mod adversary;
pub(in crate::learn) mod checkpoint;
mod config;
mod data;
mod history;
pub(in crate::learn) mod loss;
mod scene_loss;
#[cfg(test)]
mod tests;
mod train;

pub use checkpoint::{TrainError, TrainingState};
pub use config::{Annealing, DrawnWeights, LossPreset, LossWeights, PsiTraining, RateSchedule};
pub use data::{Augment, Item, PsiBody, PsiData};
pub use history::{History, HistoryRow};
pub use scene_loss::{SceneLoss, SceneLossValue};
pub use train::{TrainingInput, evaluate_reconstruction, reconstruction_error, train};
