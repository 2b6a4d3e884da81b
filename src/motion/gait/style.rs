//! What a seed changes about a way of moving.

use rand::RngExt as _;

use crate::job::Seed;

/// One person's manner for one leg.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Style {
    /// Speed over the planner's.
    pub(super) tempo: f32,
    /// Step length over the natural one.
    pub(super) stride: f32,
    /// Swing of trunk and arms over the measured one, away from walking ends.
    pub(super) liveliness: f32,
    /// The foot that goes first where either may.
    pub(super) first_foot: usize,
    /// Lean of the trunk in sitting down and getting up over the usual one.
    pub(super) lean: f32,
    /// Whether sitting or lying down follows at once.
    pub(super) goes_on: bool,
    /// Whether hands go to the knees in sitting down and getting up.
    pub(super) hands_to_knees: bool,
}

impl Style {
    /// The measured manner itself.
    pub(super) fn plain() -> Self {
        Self {
            tempo: 1.0,
            stride: 1.0,
            liveliness: 1.0,
            first_foot: 0,
            lean: 1.0,
            goes_on: false,
            hands_to_knees: true,
        }
    }

    pub(super) fn of(seed: Seed) -> Self {
        let mut rng = seed.child("gait", 0).rng();
        Self {
            tempo: rng.random_range(0.94..1.05),
            stride: rng.random_range(0.95..1.05),
            liveliness: rng.random_range(0.85..1.2),
            first_foot: usize::from(rng.random::<bool>()),
            lean: rng.random_range(0.85..1.15),
            goes_on: false,
            hands_to_knees: rng.random_range(0.0..1.0) < 0.7,
        }
    }
}
