//! How people walk, as numbers measured from captured walks: periodic curves of the trunk and the arms, how feet roll,
//! and how step length and width go with speed. Pure data and its evaluation.

use std::sync::OnceLock;

use glam::{Quat, Vec3};
use serde::{Deserialize, Serialize};

/// Overtones of the stride that are kept: the third already is below a degree in every joint.
pub const HARMONICS: usize = 3;
/// Points of a foot's roll over one stance or swing.
pub const KNOTS: usize = 17;
/// Gravity, metres per second squared.
const GRAVITY: f32 = 9.81;

/// How fast somebody walks, free of the body's size.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pace {
    /// Speed over `sqrt(g · leg length)` (the root of the Froude number): 1.3 m/s of a mean body are 0.46.
    pub speed: f32,
    /// Turning to the left (about +Y), radians per second.
    pub turn: f32,
}

impl Pace {
    /// Of a walk at `speed_m_per_s` on legs of `leg_m`, turning by `turn` radians per second.
    pub fn new(speed_m_per_s: f32, leg_m: f32, turn: f32) -> Self {
        Self { speed: speed_m_per_s / (GRAVITY * leg_m).sqrt(), turn }
    }

    /// The speed in metres per second on legs of `leg_m`.
    pub fn speed_m_per_s(&self, leg_m: f32) -> f32 {
        self.speed * (GRAVITY * leg_m).sqrt()
    }
}

/// A number that depends on the pace: constant, per unit of speed, per radian a second of turning.
pub type OfPace = [f32; 3];

fn at(coefficients: &OfPace, pace: Pace) -> f32 {
    coefficients[0] + coefficients[1] * pace.speed + coefficients[2] * pace.turn
}

/// A quantity over the stride.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Series {
    /// Its mean.
    pub mean: OfPace,
    /// Cosine and sine part of each overtone of the phase.
    pub harmonics: [[OfPace; 2]; HARMONICS],
}

impl Series {
    /// The value at a phase (radians, 0 = the right foot lands, π = the left one), the swing about the mean scaled by
    /// `liveliness`.
    pub fn at(&self, phase: f32, pace: Pace, liveliness: f32) -> f32 {
        let swing: f32 = (1u8..)
            .zip(&self.harmonics)
            .map(|(n, [cos, sin])| {
                let angle = f32::from(n) * phase;
                at(cos, pace) * angle.cos() + at(sin, pace) * angle.sin()
            })
            .sum();
        at(&self.mean, pace) + liveliness * swing
    }
}

/// How one joint turns over the stride: `exp(rest) · exp(turn)`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointSeries {
    /// Joint of the body; 0 stands for the pelvis in the frame of the way (+Z ahead).
    pub joint: usize,
    /// Mean rotation, axis-angle.
    pub rest: Vec3,
    /// Axis-angle from the mean.
    pub turn: [Series; 3],
}

impl JointSeries {
    /// The joint's rotation at a phase.
    pub fn at(&self, phase: f32, pace: Pace, liveliness: f32) -> Quat {
        let turn = Vec3::from_array(std::array::from_fn(|i| self.turn[i].at(phase, pace, liveliness)));
        Quat::from_scaled_axis(self.rest) * Quat::from_scaled_axis(turn)
    }
}

/// A curve over a stance or a swing (0 to 1) that depends on speed: constant and per unit of speed at each knot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Curve(pub [[f32; 2]; KNOTS]);

impl Curve {
    /// The value at `share` of the curve, cubic between the knots.
    pub fn at(&self, share: f32, pace: Pace) -> f32 {
        let x = share.clamp(0.0, 1.0) * (KNOTS - 1) as f32;
        let i = (x as usize).min(KNOTS - 2);
        let knot = |k: usize| self.0[k][0] + self.0[k][1] * pace.speed;
        let (a, b) = (knot(i), knot(i + 1));
        let slope_a = if i == 0 { b - a } else { 0.5 * (b - knot(i - 1)) };
        let slope_b = if i + 2 == KNOTS { b - a } else { 0.5 * (knot(i + 2) - a) };
        let t = x - i as f32;
        let (t2, t3) = (t * t, t * t * t);
        a * (2.0 * t3 - 3.0 * t2 + 1.0)
            + slope_a * (t3 - 2.0 * t2 + t)
            + b * (3.0 * t2 - 2.0 * t3)
            + slope_b * (t3 - t2)
    }
}

/// Measured walking. Lengths are shares of the leg's length (hip to knee to ankle).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GaitModel {
    /// Strides that it was measured from.
    pub strides: usize,
    /// Slowest and fastest of them (of 100, the 5th and the 95th), as [`Pace::speed`]; slower walks take the slowest one's numbers.
    pub speeds: [f32; 2],
    /// Pelvis (joint 0), spine, neck, head, collar bones, arms.
    pub joints: Vec<JointSeries>,
    /// Pelvis joint above the ankles of flat feet.
    pub height: Series,
    /// Pelvis joint sideways from its mean way, to the left.
    pub sway: Series,
    /// From one foot's landing to the other's.
    pub step_length: OfPace,
    /// Ankles apart, square to the way.
    pub step_width: OfPace,
    /// Share of the stride for which a foot is on the floor.
    pub duty: OfPace,
    /// Pitch of a foot on the floor, radians, toes down positive, from landing to taking off.
    pub stance_pitch: Curve,
    /// Pitch of a foot in the air, from taking off to landing.
    pub swing_pitch: Curve,
    /// Way of the ankle in the air, 0 to 1.
    pub swing_way: Curve,
    /// Ankle above that of a flat foot, in the air.
    pub swing_lift: Curve,
}

/// Why a gait model can't be used.
#[derive(Debug, thiserror::Error)]
pub enum GaitModelError {
    /// Not the text it should be.
    #[error("gait model: {0}; make the file again with `inhabit train gait`")]
    Syntax(#[from] ron::error::SpannedError),
    /// Numbers without sense.
    #[error("gait model: {what}; make the file again with `inhabit train gait`")]
    Senseless {
        /// What is wrong.
        what: String,
    },
}

const BUNDLED: &str = include_str!("../../../assets/motion/gait.ron");

impl GaitModel {
    /// The model that ships with the program. Read once.
    ///
    /// # Panics
    /// Never with the embedded data, which a test reads.
    pub fn bundled() -> &'static Self {
        static MODEL: OnceLock<GaitModel> = OnceLock::new();
        MODEL.get_or_init(|| Self::from_ron(BUNDLED).expect("the bundled gait model is sound"))
    }

    /// Reads the RON text of a model.
    ///
    /// # Errors
    /// [`GaitModelError`].
    pub fn from_ron(text: &str) -> Result<Self, GaitModelError> {
        let model: Self = ron::from_str(text)?;
        let senseless = |what: &str| Err(GaitModelError::Senseless { what: what.to_owned() });
        let [slow, fast] = model.speeds;
        if !(slow > 0.0 && fast > slow && fast < 1.5) {
            return senseless("its speeds are no walk's");
        }
        if model.joints.iter().any(|j| j.joint >= crate::body::POSE_TREE) {
            return senseless("it turns a joint that the body does not have");
        }
        for speed in model.speeds {
            let pace = Pace { speed, turn: 0.0 };
            let step = model.step_length_share(pace);
            if !(0.2..1.5).contains(&step) || !(0.5..0.9).contains(&model.duty(pace)) {
                return senseless("its steps are no walk's");
            }
        }
        Ok(model)
    }

    /// The RON text of the model.
    ///
    /// # Errors
    /// What the serialiser says; it never fails on numbers.
    pub fn to_ron(&self) -> Result<String, ron::Error> {
        ron::ser::to_string_pretty(self, ron::ser::PrettyConfig::new().depth_limit(3))
    }

    /// The pace within the measured speeds.
    pub fn measured(&self, pace: Pace) -> Pace {
        Pace { speed: pace.speed.clamp(self.speeds[0], self.speeds[1]), turn: pace.turn.clamp(-1.2, 1.2) }
    }

    /// One step over the leg's length. Below the measured speeds steps get shorter as they get slower.
    pub fn step_length_share(&self, pace: Pace) -> f32 {
        let within = self.measured(pace);
        let slower = (pace.speed / within.speed).min(1.0);
        at(&self.step_length, within) * slower.sqrt()
    }

    /// Seconds from one foot's landing to the other's.
    pub fn step_seconds(&self, pace: Pace, leg_m: f32) -> f32 {
        let speed = pace.speed_m_per_s(leg_m).max(0.05);
        self.step_length_share(pace) * leg_m / speed
    }

    /// The pace whose natural step is `length_m` long.
    pub fn pace_of_step(&self, length_m: f32, leg_m: f32) -> Pace {
        let (mut low, mut high) = (0.0, self.speeds[1]);
        for _ in 0..24 {
            let middle = 0.5 * (low + high);
            let shorter = self.step_length_share(Pace { speed: middle, turn: 0.0 }) * leg_m < length_m;
            if shorter { low = middle } else { high = middle }
        }
        Pace { speed: 0.5 * (low + high), turn: 0.0 }
    }

    /// Ankles apart over the leg's length.
    pub fn step_width_share(&self, pace: Pace) -> f32 {
        at(&self.step_width, self.measured(Pace { turn: 0.0, ..pace }))
    }

    /// Share of the stride for which a foot is on the floor.
    pub fn duty(&self, pace: Pace) -> f32 {
        at(&self.duty, self.measured(Pace { turn: 0.0, ..pace }))
    }

    /// The series of a joint, if the model has one.
    pub fn joint(&self, joint: usize) -> Option<&JointSeries> {
        self.joints.iter().find(|series| series.joint == joint)
    }
}
