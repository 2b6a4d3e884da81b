use crate::math::AdamConfig;

/// Weights of PSI eq. 8. The paper gives α1 to α3; the start's weight is 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PsiWeights {
    /// Weight of |x - x0| (mean over the 75 numbers, as in the published code).
    pub start: f32,
    /// α1: contact.
    pub contact: f32,
    /// α2: collision.
    pub collision: f32,
    /// α3: pose prior.
    pub pose_prior: f32,
    /// c of the robust distance r/(r + c) in metres.
    pub robust_c_m: f32,
}

/// Weights of our energy. Lengths are in metres, so a squared centimetre is 1e-4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights {
    /// Keeps position and facing near the proposal: per squared metre.
    pub place: f32,
    /// Keeps the pelvis over the proposal's point of the floor, besides: per squared metre.
    pub over: f32,
    /// Keeps the pose near the proposal: per squared unit of the code.
    pub pose: f32,
    /// Keeps the pose likely: per squared unit of the code.
    pub pose_prior: f32,
    /// Closes the gap of each goal: per squared metre of gap.
    pub gap: f32,
    /// Brings more of a region to the surface: per share of the region.
    pub spread: f32,
    /// Penetration: mean over probe vertices of squared depth.
    pub collision: f32,
    /// The room's surfaces inside the body: per point, squared depth under the skin.
    pub intrusion: f32,
    /// Bones nearer to a surface than the flesh around them is thick: knows what lies behind a thin sheet.
    pub bones: f32,
    /// Limbs in the own body, squared metres.
    pub self_collision: f32,
    /// Excess over joint limits, squared radians.
    pub joint_limits: f32,
    /// Weight beside the feet, squared metres, for standing families.
    pub balance: f32,
}

/// What is minimised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Objective {
    /// PSI eq. 8 over all vertices.
    Psi(PsiWeights),
    /// Our energy over a sample of vertices that holds every contact vertex.
    Rescue(Weights),
}

/// A whole fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitConfig {
    /// What is minimised.
    pub objective: Objective,
    /// Steps of Adam.
    pub iterations: usize,
    /// Adam's constants; for ours the step size falls to a tenth along a half cosine.
    pub adam: AdamConfig,
    /// A preview every so many steps; 0 for none.
    pub preview_every: usize,
}

/// Named settings: the published ones and ours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FitPreset {
    /// `fitting_proxe`: 20 steps of 0.1, c = 1 cm.
    PsiProxe,
    /// `fitting_habitat`: 50 steps of 0.1, c = 1 m.
    PsiMatterport,
    /// The demonstration notebook: 50 steps of 0.05, c = 1 cm.
    PsiNotebook,
    /// Our fitter.
    Rescue,
}

impl From<FitPreset> for FitConfig {
    fn from(preset: FitPreset) -> Self {
        match preset {
            FitPreset::PsiProxe => psi(20, 0.1, 0.01),
            FitPreset::PsiMatterport => psi(50, 0.1, 1.0),
            FitPreset::PsiNotebook => psi(50, 0.05, 0.01),
            FitPreset::Rescue => rescue(),
        }
    }
}

impl Default for FitConfig {
    fn default() -> Self {
        rescue()
    }
}

/// PSI §3.4: α1 = 0.1, α2 = 0.5, α3 = 0.01 in all cases.
fn psi(iterations: usize, learning_rate: f32, robust_c_m: f32) -> FitConfig {
    FitConfig {
        objective: Objective::Psi(PsiWeights {
            start: 1.0,
            contact: 0.1,
            collision: 0.5,
            pose_prior: 0.01,
            robust_c_m,
        }),
        iterations,
        adam: AdamConfig { learning_rate, ..AdamConfig::default() },
        preview_every: 0,
    }
}

fn rescue() -> FitConfig {
    FitConfig {
        objective: Objective::Rescue(Weights {
            place: 0.5,
            over: 0.0,
            pose: 0.02,
            pose_prior: 0.001,
            gap: 200.0,
            spread: 0.05,
            collision: 60_000.0,
            intrusion: 60.0,
            bones: 1500.0,
            self_collision: 40.0,
            joint_limits: 2.0,
            balance: 10.0,
        }),
        iterations: 140,
        adam: AdamConfig { learning_rate: 0.02, ..AdamConfig::default() },
        preview_every: 0,
    }
}
