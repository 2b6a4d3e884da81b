//! How evenly a body moves.

use super::frame::BodyJoints;

/// Below this speed a body counts as still, so that the breath of somebody who sits is no jump, m/s.
const STILL_M_PER_S: f32 = 0.1;
/// Steps on each side of a boundary that it is compared with.
const BESIDE: usize = 5;

/// Mean size of the third derivative of the joints' places by finite differences, over joints and frames, m/s³.
/// 0 for fewer than four frames.
pub fn jitter_m_per_s3(joints: &[BodyJoints], fps: f32) -> f32 {
    let mut sum = 0.0_f64;
    for four in joints.windows(4) {
        for j in 0..four[0].len() {
            let change = four[3][j] - 3.0 * four[2][j] + 3.0 * four[1][j] - four[0][j];
            // Frames that are no numbers are findings of their own.
            sum += f64::from(if change.is_finite() { change.length() } else { 0.0 });
        }
    }
    let terms = joints.len().saturating_sub(3) * joints.first().map_or(0, |j| j.len());
    (sum / terms.max(1) as f64) as f32 * fps.powi(3)
}

/// How much a boundary between legs stands out: the speed of the body joints (their mean) of the step into frame
/// `boundary` or out of it, whichever is faster, over the mean speed of the five steps before or after these,
/// whichever is faster. 1 is even motion; a speed below 10 cm/s counts as that.
pub fn pop_ratio(joints: &[BodyJoints], boundary: usize, fps: f32) -> f32 {
    let speed = |step: usize| {
        let (a, b) = (&joints[step], &joints[step + 1]);
        a.iter().zip(b).map(|(a, b)| a.distance(*b)).sum::<f32>() / a.len() as f32 * fps
    };
    if boundary == 0 || boundary + 1 >= joints.len() {
        return 1.0;
    }
    let at = speed(boundary - 1).max(speed(boundary)).max(STILL_M_PER_S);
    let mean = |steps: std::ops::Range<usize>| {
        let count = steps.len().max(1) as f32;
        steps.map(speed).sum::<f32>() / count
    };
    let before = mean((boundary - 1).saturating_sub(BESIDE)..boundary - 1);
    let after = mean(boundary + 1..(boundary + 1 + BESIDE).min(joints.len() - 1));
    at / before.max(after).max(STILL_M_PER_S)
}
