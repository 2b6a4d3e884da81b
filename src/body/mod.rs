//! The parametric body: 75 numbers to vertices and joints, and gradients back; pose space; contact regions.
//!
//! May name `math`, `assets`, `scene`. Pure: reads no file itself (the bundled model is embedded), optimises
//! nothing, knows no room.
