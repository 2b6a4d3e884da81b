use crate::math::AdamConfig;

/// Weights of LTM §3.4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaperWeights {
    /// λ_cont of eq. 6, as a mean over frames and contact vertices (published code).
    pub contact: f32,
    /// λ_col of eq. 5.
    pub collision: f32,
    /// λ_smooth of eq. 7, as mean squared steps of all vertices and of each sole, summed over the frames.
    pub smooth: f32,
    /// λ_foot, as mean squared distances of the stable sole from its mean place, summed over the frames.
    pub foot: f32,
    /// c of the robust distance r/(r + c), metres.
    pub robust_c_m: f32,
}

/// Weights of our energy. Metres and radians; a squared centimetre is 1e-4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionWeights {
    /// Closes the gap of what carries the body: per squared metre of gap.
    pub gap: f32,
    /// Brings more of a region to the surface: per share of the region.
    pub spread: f32,
    /// Penetration: mean over the probe's vertices of squared depth.
    pub collision: f32,
    /// The room's surfaces inside the body: per point, squared depth under the skin.
    pub intrusion: f32,
    /// Bones nearer to a surface than the flesh around them is thick.
    pub bones: f32,
    /// Limbs in the own body, squared metres.
    pub self_collision: f32,
    /// Excess over joint limits, squared radians.
    pub joint_limits: f32,
    /// Ankles and balls of planted feet off their places: per squared metre.
    pub feet: f32,
    /// Deviation from the motion as it came in: per squared unit ([`super::variables::COSTS`]).
    pub stay: f32,
    /// Second difference of that deviation from frame to frame: what is changed changes smoothly.
    pub change: f32,
    /// Second difference of the joints' places: evens out what came in uneven.
    pub smooth: f32,
}

/// What is minimised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MotionObjective {
    /// LTM §3.4 over all vertices.
    Paper(PaperWeights),
    /// Our energy over a sample of the skin, then planted feet locked.
    Ours(MotionWeights),
}

/// Some iterations of one objective.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stage {
    /// What is minimised.
    pub objective: MotionObjective,
    /// Steps of Adam, which starts anew with each stage.
    pub iterations: usize,
    /// Adam's constants; for ours the step size falls to a tenth along a half cosine.
    pub adam: AdamConfig,
}

/// A whole optimisation.
#[derive(Clone, Debug, PartialEq)]
pub struct SequenceConfig {
    /// One after the other, for each window.
    pub stages: Vec<Stage>,
    /// Frames that are worked on at once.
    pub window: usize,
    /// Frames that a window shares with the one before.
    pub overlap: usize,
    /// Locks planted feet exactly at the end.
    pub lock_feet: bool,
    /// How often windows with frames that are still deep in something are gone through, collision weighing
    /// [`MotionWeights::AGAIN`] times more each time; 1 for never again.
    pub rounds: usize,
}

impl MotionWeights {
    /// Growth of the weights against entering things from round to round.
    pub const AGAIN: f32 = 4.0;
}

impl Stage {
    /// This stage in a later round: ours weighs what keeps bodies out of things more, the published one is the same.
    #[must_use]
    pub fn of_round(mut self, round: usize) -> Self {
        if let MotionObjective::Ours(weights) = &mut self.objective {
            let growth = MotionWeights::AGAIN.powi(round as i32);
            weights.collision *= growth;
            weights.intrusion *= growth;
            weights.bones *= growth;
        }
        self
    }
}

/// Named settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SequencePreset {
    /// LTM §3.4 with the published code's schedule: 20 iterations without the feet, then 50 with them.
    Paper,
    /// Our optimiser.
    Ours,
}

impl From<SequencePreset> for SequenceConfig {
    fn from(preset: SequencePreset) -> Self {
        match preset {
            SequencePreset::Paper => paper(),
            SequencePreset::Ours => ours(),
        }
    }
}

impl Default for SequenceConfig {
    fn default() -> Self {
        ours()
    }
}

/// The published code: Adam at 0.02, c = 1 m; contact 2, collision 2, smoothness 0.5, then 1, 1, 0.5 and the feet 1.
fn paper() -> SequenceConfig {
    let stage = |iterations, contact, collision, foot| Stage {
        objective: MotionObjective::Paper(PaperWeights {
            contact,
            collision,
            smooth: 0.5,
            foot,
            robust_c_m: 1.0,
        }),
        iterations,
        adam: AdamConfig { learning_rate: 0.02, ..AdamConfig::default() },
    };
    SequenceConfig {
        stages: vec![stage(20, 2.0, 2.0, 0.0), stage(50, 1.0, 1.0, 1.0)],
        window: 150,
        overlap: 30,
        lock_feet: false,
        rounds: 1,
    }
}

fn ours() -> SequenceConfig {
    let objective = MotionObjective::Ours(MotionWeights {
        gap: 200.0,
        spread: 0.02,
        collision: 60_000.0,
        intrusion: 30.0,
        bones: 400.0,
        self_collision: 20.0,
        joint_limits: 2.0,
        feet: 600.0,
        stay: 0.5,
        change: 100.0,
        smooth: 30.0,
    });
    // The second moment is shared by all frames and forgets within some twenty steps: the energy falls by orders of
    // magnitude, and steps must not stay scaled by how it began.
    let adam = AdamConfig { learning_rate: 0.02, beta2: 0.95, ..AdamConfig::default() };
    SequenceConfig {
        stages: vec![Stage { objective, iterations: 60, adam }],
        window: 180,
        overlap: 36,
        lock_feet: true,
        rounds: 3,
    }
}
