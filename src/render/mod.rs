//! Draws a scene: wgpu in a window or headless, or a small ray caster on the processor where there is no
//! adapter at all. `&Scene` and camera in, texture or pixels out.
//!
//! May name `math`, `assets`, `scene`, `body`, `inspect` and wgpu; never egui, never the document.
