//! How planted feet slide. A foot that rolls from heel to toes stands still at one point of its sole at a time, so
//! each step is judged by the slowest of heel, ball and toe tip.

use glam::Vec3;

use super::SKATES_CM_PER_S;
use super::frame::Measured;
use crate::body::TREADS;

/// Movement along the floor from one frame to the next of the tread that moves least, metres.
fn slowest_step(from: &[Vec3; TREADS], to: &[Vec3; TREADS]) -> Vec3 {
    let steps = from.iter().zip(to).map(|(a, b)| (*b - *a).with_y(0.0));
    steps.min_by(|a, b| a.length_squared().total_cmp(&b.length_squared())).unwrap_or(Vec3::ZERO)
}

/// Speed of a foot along the floor between two frames, by its slowest tread, m/s.
pub fn tread_speed_m_per_s(from: &[Vec3; TREADS], to: &[Vec3; TREADS], fps: f32) -> f32 {
    slowest_step(from, to).length() * fps
}

/// How far a foot wanders from where it was put down over one stance: the greatest length of the sum of its slowest
/// treads' steps so far, metres. A foot that slides to and fro is as bad as its farthest point.
pub fn stance_drift_m(stance: &[[Vec3; TREADS]]) -> f32 {
    let mut wandered = Vec3::ZERO;
    let mut drift = 0.0_f32;
    for pair in stance.windows(2) {
        wandered += slowest_step(&pair[0], &pair[1]);
        drift = drift.max(wandered.length());
    }
    drift
}

/// Sliding of the planted feet of a clip.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Skate {
    /// Mean speed of planted feet, cm/s.
    pub mean_cm_per_s: f32,
    /// Share of planted feet's frames that slide visibly.
    pub frame_share: f32,
    /// The worst stance's drift, cm.
    pub drift_cm: f32,
    /// Speed of each planted foot in each frame, cm/s; that of the step into the frame.
    per_frame: Vec<[f32; 2]>,
}

impl Skate {
    pub fn of(measured: &[Measured], fps: f32) -> Self {
        let mut skate = Self { per_frame: vec![[0.0; 2]; measured.len()], ..Self::default() };
        let (mut steps, mut sliding, mut sum) = (0_usize, 0_usize, 0.0_f64);
        for side in 0..2 {
            let mut stance: Vec<[Vec3; TREADS]> = Vec::new();
            for (i, frame) in measured.iter().enumerate() {
                if !frame.is_planted(side) {
                    stance.clear();
                    continue;
                }
                if let Some(before) = stance.last() {
                    let speed = tread_speed_m_per_s(before, &frame.treads[side], fps) * 100.0;
                    skate.per_frame[i][side] = speed;
                    steps += 1;
                    sliding += usize::from(speed > SKATES_CM_PER_S);
                    sum += f64::from(speed);
                }
                stance.push(frame.treads[side]);
                let ends = measured.get(i + 1).is_none_or(|next| !next.is_planted(side));
                if ends {
                    skate.drift_cm = skate.drift_cm.max(stance_drift_m(&stance) * 100.0);
                }
            }
        }
        skate.mean_cm_per_s = (sum / steps.max(1) as f64) as f32;
        skate.frame_share = sliding as f32 / steps.max(1) as f32;
        skate
    }

    /// Writes each frame's speeds into its record.
    pub fn mark(&self, measured: &mut [Measured]) {
        for (frame, speeds) in measured.iter_mut().zip(&self.per_frame) {
            frame.record.skate_cm_per_s = *speeds;
        }
    }
}
