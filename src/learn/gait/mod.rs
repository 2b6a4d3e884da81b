//! The gait model, measured on captured walks.
//!
//! Pure: takes clips, returns numbers. No clip's frame ends up in the model, only regressions over many strides.

mod strides;
mod track;

use std::f32::consts::PI;

use glam::{Quat, Vec3};

use crate::assets::PoseClip;
use crate::body::joints::{self as j, JOINTS};
use crate::job::{Stop, Ticker};
use crate::math::LeastSquares;
use crate::motion::gait::{Curve, GaitModel, HARMONICS, JointSeries, KNOTS, OfPace, Pace, Series};

use strides::{Stride, strides};
use track::Track;

/// Joints whose turning is kept: the trunk, head and arms; legs follow from the feet.
const TURNING: [usize; 14] = [
    j::PELVIS,
    j::SPINE1,
    j::SPINE2,
    j::SPINE3,
    j::NECK,
    j::HEAD,
    j::LEFT_COLLAR,
    j::RIGHT_COLLAR,
    j::LEFT_SHOULDER,
    j::RIGHT_SHOULDER,
    j::LEFT_ELBOW,
    j::RIGHT_ELBOW,
    j::LEFT_WRIST,
    j::RIGHT_WRIST,
];
/// Instants of a stride that are looked at.
const INSTANTS: usize = 40;
/// Numbers of one periodic quantity: mean, then cosine and sine of each overtone.
const PERIODIC: usize = 1 + 2 * HARMONICS;
/// Numbers of the pace.
const PACE: usize = 3;
/// How much is believed before the data speak: numbers per unit of speed and of turning are small.
const RIDGE: [f64; PACE] = [1e-6, 0.005, 5.0];

/// Why no model was measured: too few strides.
#[derive(Debug, thiserror::Error)]
#[error(
    "{found} strides of walking were found in {clips} clips; {LEAST_STRIDES} are needed: name clips that walk with travel"
)]
pub struct TooFewStrides {
    /// Strides found.
    pub found: usize,
    /// Clips looked at.
    pub clips: usize,
}

/// Fewer strides leave the numbers per unit of speed to chance.
const LEAST_STRIDES: usize = 40;

/// Measures the model on all strides of walking that the clips hold, each also as its mirror image. `rest` are the
/// rest joints of the body that the clips were carried over to.
///
/// # Errors
/// [`TooFewStrides`] as [`Stop::Failed`]; [`Stop::Cancelled`] once the user cancelled.
pub fn measure_gait(clips: &[PoseClip], rest: &[Vec3; JOINTS], ticker: &Ticker) -> Result<GaitModel, Stop> {
    ticker.stage("looking for strides", clips.len())?;
    let mut found = Vec::new();
    for clip in clips {
        let track = Track::of(clip, rest);
        found.extend(strides(&track));
        found.extend(strides(&track.mirrored()));
        ticker.advance()?;
    }
    if found.len() < 2 * LEAST_STRIDES {
        return Err(TooFewStrides { found: found.len() / 2, clips: clips.len() }.into());
    }
    let mut speeds: Vec<f32> = found.iter().map(|s| s.pace.speed).collect();
    speeds.sort_by(f32::total_cmp);
    let percentile = |share: f32| speeds[(share * (speeds.len() - 1) as f32) as usize];
    let rests = rest_rotations(&found);
    let (joints, height, sway) = periodic(&found, &rests);
    let scalar = |of: &dyn Fn(&Stride) -> f32| rounded(of_pace(&found, of));
    let curve = |of: &dyn Fn(&Stride) -> [f32; KNOTS]| curve(&found, of);
    Ok(GaitModel {
        strides: found.len() / 2,
        speeds: [percentile(0.05), percentile(0.95)].map(round),
        joints,
        height,
        sway,
        step_length: scalar(&|s| s.step_length),
        step_width: scalar(&|s| s.step_width),
        duty: scalar(&|s| s.duty),
        stance_pitch: curve(&|s| s.stance_pitch),
        swing_pitch: curve(&|s| s.swing_pitch),
        swing_way: curve(&|s| s.swing_way),
        swing_lift: curve(&|s| s.swing_lift),
    })
}

/// The mean rotation of every turning joint, by the mean of the quaternions.
fn rest_rotations(strides: &[Stride]) -> Vec<Quat> {
    let mean = |i: usize| {
        let all =
            strides.iter().flat_map(|s| s.turns.iter().flat_map(move |t| [t[i], flipped(t[across(i)])]));
        let sum = all.fold(glam::Vec4::ZERO, |sum, q| {
            let v = glam::Vec4::from(q);
            sum + if sum.dot(v) < 0.0 { -v } else { v }
        });
        Quat::from_vec4(sum).normalize()
    };
    (0..TURNING.len()).map(mean).collect()
}

fn periodic(strides: &[Stride], rests: &[Quat]) -> (Vec<JointSeries>, Series, Series) {
    let targets = 3 * TURNING.len() + 2;
    let mut fit = LeastSquares::new(PERIODIC * PACE, targets);
    for stride in strides {
        for instant in 0..INSTANTS {
            let phase = 2.0 * PI * instant as f32 / INSTANTS as f32;
            let weight = 1.0 / INSTANTS as f64;
            let (height, sway) = (stride.height[instant], stride.sway[instant]);
            let turns = &stride.turns[instant];
            fit.add(weight, &regressors(phase, stride.pace), &row(turns, rests, height, sway));
            // The same step seen in a mirror, half a stride later, so that left and right come out alike.
            let mirrored: [Quat; TURNING.len()] = std::array::from_fn(|i| flipped(turns[across(i)]));
            let pace = Pace { turn: -stride.pace.turn, ..stride.pace };
            fit.add(weight, &regressors(phase + PI, pace), &row(&mirrored, rests, height, -sway));
        }
    }
    let ridge: Vec<f64> = (0..PERIODIC * PACE).map(|i| RIDGE[i % PACE]).collect();
    let solved = fit.solve(&ridge).unwrap_or_else(|| vec![vec![0.0; PERIODIC * PACE]; targets]);
    let series = |target: usize| series(&solved[target]);
    let joint = |(i, joint): (usize, &usize)| JointSeries {
        joint: *joint,
        rest: logarithm(rests[i]).map(round),
        turn: std::array::from_fn(|axis| series(3 * i + axis)),
    };
    let joints = TURNING.iter().enumerate().map(joint).collect();
    (joints, series(targets - 2), series(targets - 1))
}

fn row(turns: &[Quat], rests: &[Quat], height: f32, sway: f32) -> Vec<f64> {
    let logs = turns.iter().zip(rests).map(|(q, rest)| logarithm(rest.inverse() * *q));
    logs.flat_map(|v| v.to_array()).chain([height, sway]).map(f64::from).collect()
}

/// A rotation in the mirror.
fn flipped(q: Quat) -> Quat {
    Quat::from_xyzw(q.x, -q.y, -q.z, q.w)
}

/// The index of the turning joint on the other side.
fn across(i: usize) -> usize {
    TURNING.iter().position(|joint| *joint == j::mirror(TURNING[i])).unwrap_or(i)
}

fn logarithm(q: Quat) -> Vec3 {
    let q = if q.w < 0.0 { -q } else { q };
    q.to_scaled_axis()
}

fn regressors(phase: f32, pace: Pace) -> [f64; PERIODIC * PACE] {
    std::array::from_fn(|i| {
        let (term, of) = (i / PACE, i % PACE);
        let angle = term.div_ceil(2) as f32 * phase;
        let wave = if term == 0 {
            1.0
        } else if term % 2 == 1 {
            angle.cos()
        } else {
            angle.sin()
        };
        f64::from(wave * [1.0, pace.speed, pace.turn][of])
    })
}

fn series(solved: &[f64]) -> Series {
    let pick = |term: usize| -> OfPace { std::array::from_fn(|of| round(solved[term * PACE + of] as f32)) };
    Series { mean: pick(0), harmonics: std::array::from_fn(|n| [pick(2 * n + 1), pick(2 * n + 2)]) }
}

fn of_pace(strides: &[Stride], of: &dyn Fn(&Stride) -> f32) -> OfPace {
    let mut fit = LeastSquares::new(2, 1);
    for stride in strides {
        fit.add(1.0, &[1.0, f64::from(stride.pace.speed)], &[f64::from(of(stride))]);
    }
    let solved = fit.solve(&RIDGE[..2]).unwrap_or_else(|| vec![vec![0.0; 2]]);
    [solved[0][0] as f32, solved[0][1] as f32, 0.0]
}

fn curve(strides: &[Stride], of: &dyn Fn(&Stride) -> [f32; KNOTS]) -> Curve {
    let knot = |k: usize| {
        let [constant, of_speed, _] = of_pace(strides, &|s| of(s)[k]);
        [round(constant), round(of_speed)]
    };
    Curve(std::array::from_fn(knot))
}

fn rounded(coefficients: OfPace) -> OfPace {
    coefficients.map(round)
}

/// Five decimals are a hundredth of a millimetre and less than a thousandth of a degree: the file stays small.
fn round(x: f32) -> f32 {
    (x * 1e5).round() / 1e5
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Body;

    /// Turn of a hip at a share of the stride: its ankle stays on the floor until 0.6, then swings back ahead.
    fn hip(share: f32, speed: f32) -> f32 {
        let share = share.rem_euclid(1.0);
        let reach = (speed * 0.36 / 0.81).asin();
        let stays = (speed * (0.36 - 1.2 * share) / 0.81).clamp(-1.0, 1.0).asin();
        if share < 0.6 { stays } else { -reach * (PI * (share - 0.6) / 0.4).cos() }
    }

    /// A figure that glides ahead at `speed` while its legs swing like pendulums, arms against them, at 60 Hz.
    fn pendulum(name: &str, speed: f32) -> PoseClip {
        let (rate, stride_s) = (60.0, 1.2);
        let frame = |i: usize| {
            let share = i as f32 / rate / stride_s;
            let phase = 2.0 * PI * share;
            let mut frame = [Vec3::ZERO; crate::assets::CLIP_JOINTS];
            frame[j::LEFT_HIP].x = -hip(share + 0.5, speed);
            frame[j::RIGHT_HIP].x = -hip(share, speed);
            // At rest the feet are far apart.
            (frame[j::LEFT_HIP].z, frame[j::RIGHT_HIP].z) = (-0.14, 0.14);
            frame[j::LEFT_ANKLE].x = -frame[j::LEFT_HIP].x;
            frame[j::RIGHT_ANKLE].x = -frame[j::RIGHT_HIP].x;
            frame[j::LEFT_SHOULDER] = Vec3::new(-0.3 * phase.cos(), 0.0, -1.3);
            frame[j::RIGHT_SHOULDER] = Vec3::new(0.3 * phase.cos(), 0.0, 1.3);
            frame
        };
        let frames: Vec<_> = (0..2400).map(frame).collect();
        let at = |i: usize| Vec3::new(0.0, 0.92, speed * i as f32 / rate);
        PoseClip {
            name: name.into(),
            pelvis_m: (0..2400).map(at).collect(),
            frames,
            frame_seconds: 1.0 / rate,
        }
    }

    #[test]
    fn a_pendulums_stride_is_measured_as_it_was_made() {
        let clips: Vec<PoseClip> = (0..8).map(|i| pendulum("p", 0.8 + 0.07 * i as f32)).collect();
        let rest = &Body::bundled().model.joint_template;
        let model = measure_gait(&clips, rest, &Ticker::silent()).expect("strides");
        let pace = Pace::new(1.0, 0.816, 0.0);
        let shoulder = model.joint(j::RIGHT_SHOULDER).expect("a shoulder");
        // The right foot lands at phase 0, when its leg is ahead and the right arm (+x is back) behind.
        let swing =
            |phase: f32| (Quat::from_rotation_z(1.3).inverse() * shoulder.at(phase, pace, 1.0)).x * 2.0;
        assert!(swing(0.0).abs() > 0.2 && swing(0.0) * swing(PI) < 0.0, "{} {}", swing(0.0), swing(PI));
        let seconds = model.step_length_share(pace) * 0.816 / 1.0;
        assert!((seconds - 0.6).abs() < 0.03, "a step of {seconds} s, 0.6 s were made");
    }

    #[test]
    fn clips_without_walks_are_refused() {
        let rest = &Body::bundled().model.joint_template;
        let still = [pendulum("still", 0.0)];
        let refused = measure_gait(&still, rest, &Ticker::silent());
        assert!(matches!(refused, Err(Stop::Failed(why)) if why.contains("0 strides")));
    }
}
