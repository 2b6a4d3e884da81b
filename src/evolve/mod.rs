//! The only composer of `generate`, `fit` and `motion`: populating a room; later, actions that evolve it.
