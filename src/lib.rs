//! Inhabit puts people into rooms.
//!
//! ```text
//! files ─► assets ─► scene ─► generate ─┐
//!                      │     fit       ├─► evolve ─► document ─► render ─► app
//!                      │     motion  ──┘                │            └──► cli
//!                      └────────► inspect (what is wrong, where, against which limit)
//! ```
//!
//! Data flows one way. The modules stand below in layer order; a module names only those above it
//! (the exact table is held by `tests/layering.rs`). World frame everywhere: metres, right-handed, Y up.

pub mod math;

pub mod job;

pub mod assets;

pub mod scene;

pub mod body;

pub mod inspect;

pub mod nn;

pub mod generate;

pub mod fit;

pub mod motion;

pub mod evolve;

pub mod learn;

pub mod document;

pub mod render;

pub mod app;

pub mod cli;
