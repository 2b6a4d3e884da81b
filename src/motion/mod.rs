//! Long-term motion: sub-goals, route, pose, stitching. May not name `generate` or `fit`. Enters with motion synthesis.
