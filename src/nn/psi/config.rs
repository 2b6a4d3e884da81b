//! Sizes of the networks of PSI: as published, and compact ones that two processor cores train in minutes.

use serde::{Deserialize, Serialize};

use crate::math::AdamConfig;

/// Numbers of a body (PSI §3.1): t 3, R 6, betas 10, pose 32, hands 24.
pub const BODY: usize = 75;
/// Numbers of the global part x_h^g: the translation.
pub const GLOBAL: usize = 3;
/// Numbers of the local part x_h^l: all the rest.
pub const LOCAL: usize = BODY - GLOBAL;
/// Side of the pictures that the networks see.
pub const IMAGE: usize = 128;
/// Classes that a label can have: 0 nothing, 1 to 40 of Matterport3D, four kinds of table and counter, unlabelled.
pub const CLASSES: usize = 46;

/// Numbers of a floor's plane: unit normal 3, the camera's height in metres, 1 if there is one.
pub const FLOOR_PLANE: usize = 5;

/// Which network.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum PsiMethod {
    /// All of the body at once (PSI §3.2.1).
    S1,
    /// First where, then how (PSI §3.2.1).
    S2,
    /// The modified network of Li et al. 2019 (PSI §4.1.2).
    Baseline,
}

impl PsiMethod {
    /// Every method.
    pub const ALL: [Self; 3] = [Self::S1, Self::S2, Self::Baseline];

    /// Name on the command line and of weight files.
    pub fn label(self) -> &'static str {
        match self {
            Self::S1 => "s1",
            Self::S2 => "s2",
            Self::Baseline => "baseline",
        }
    }
}

/// How classes reach the network.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Semantics {
    /// The paper's: one channel, the label divided by the picture's largest label.
    Scalar,
    /// A learnt vector of this many numbers for each class.
    Embedding(usize),
}

/// The trunk's first layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Stem {
    /// ResNet18's: 7x7, every second pixel.
    Conv7,
    /// Squares of this many pixels a side, each mapped by one matrix: the same reach for a tenth of the work.
    Patches(usize),
}

/// The scene encoder: ResNet18 up to layer 2, or a narrow one of the same plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TrunkConfig {
    /// First layer.
    pub stem: Stem,
    /// Whether ResNet's pooling follows the stem.
    pub pool: bool,
    /// Channels of layer 1 and layer 2.
    pub channels: [usize; 2],
    /// Blocks of each layer.
    pub blocks: usize,
}

/// A whole network.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PsiConfig {
    /// Which network.
    pub method: PsiMethod,
    /// How classes are fed in.
    pub semantics: Semantics,
    /// Whether a channel says where the picture was padded.
    pub valid_mask: bool,
    /// Whether the camera's two numbers of π (largest depth, focal length) are given beside the picture, so
    /// that metres can be told from shares of the largest depth.
    pub camera_scale: bool,
    /// Whether the plane of the floor, found in the picture's own floor pixels, is given beside it: how the camera is
    /// tilted and how high it stands, which a trunk that never saw ImageNet learns only from far more rooms.
    #[serde(default)]
    pub floor_plane: bool,
    /// The scene encoder.
    pub trunk: TrunkConfig,
    /// Channels of the convolution after the trunk.
    pub head_channels: usize,
    /// The same for the second stage of S2.
    pub local_head_channels: usize,
    /// Width that bodies, scenes and codes are lifted to (256 in PSI).
    pub lift: usize,
    /// Size of the latent code, of each stage.
    pub latent: usize,
    /// Width of the decoder of S2's first stage (32 in the published code).
    pub global_decoder: usize,
    /// Width of the decoder of S2's second stage (128 in the published code).
    pub local_decoder: usize,
    /// Pose classes of the baseline (30 in Wang et al. 2017 and Li et al. 2019).
    pub pose_classes: usize,
}

impl PsiConfig {
    /// As published: depth and scalar semantics, ResNet18's trunk.
    pub fn published(method: PsiMethod) -> Self {
        Self {
            method,
            semantics: Semantics::Scalar,
            valid_mask: false,
            camera_scale: false,
            floor_plane: false,
            trunk: TrunkConfig { stem: Stem::Conv7, pool: true, channels: [64, 128], blocks: 2 },
            head_channels: 32,
            local_head_channels: 128,
            lift: 256,
            latent: 32,
            global_decoder: 32,
            local_decoder: 128,
            pose_classes: 30,
        }
    }

    /// The published sizes with classes embedded, padding marked, and the camera's numbers and the floor's plane given.
    pub fn paper(method: PsiMethod) -> Self {
        Self {
            semantics: Semantics::Embedding(8),
            valid_mask: true,
            camera_scale: true,
            floor_plane: true,
            ..Self::published(method)
        }
    }

    /// Trained in minutes on two cores: a narrow trunk on patches, and heads of half the width.
    pub fn compact(method: PsiMethod) -> Self {
        Self {
            semantics: Semantics::Embedding(4),
            trunk: TrunkConfig { stem: Stem::Patches(4), pool: true, channels: [16, 32], blocks: 2 },
            local_head_channels: 32,
            lift: 128,
            global_decoder: 64,
            ..Self::paper(method)
        }
    }

    /// So small that a test trains it in a second.
    pub fn mini(method: PsiMethod) -> Self {
        Self {
            semantics: Semantics::Embedding(2),
            trunk: TrunkConfig { stem: Stem::Patches(16), pool: false, channels: [8, 8], blocks: 1 },
            head_channels: 8,
            local_head_channels: 8,
            lift: 64,
            pose_classes: 4,
            ..Self::compact(method)
        }
    }

    /// Channels of a pixel before the stem.
    pub fn pixel_channels(&self) -> usize {
        let semantics = match self.semantics {
            Semantics::Scalar => 1,
            Semantics::Embedding(channels) => channels,
        };
        1 + usize::from(self.valid_mask) + semantics
    }

    /// Numbers beside the picture: those of π and the floor's plane.
    pub fn view_numbers(&self) -> usize {
        2 * usize::from(self.camera_scale) + FLOOR_PLANE * usize::from(self.floor_plane)
    }

    /// Side of the feature map after the trunk.
    pub fn feature_side(&self) -> usize {
        let stem = match self.trunk.stem {
            Stem::Conv7 => IMAGE / 2,
            Stem::Patches(side) => IMAGE / side,
        };
        let pooled = if self.trunk.pool { stem / 2 } else { stem };
        pooled / 2
    }

    /// How many standard normal numbers a sample takes.
    pub fn noise(&self) -> usize {
        match self.method {
            PsiMethod::S1 => self.latent,
            PsiMethod::S2 => 2 * self.latent,
            // The last number chooses the pose class.
            PsiMethod::Baseline => 2 * self.latent + 1,
        }
    }
}

/// PSI §3.4: Adam with a step of 3e-4; the other constants are PyTorch's defaults.
pub fn psi_adam() -> AdamConfig {
    AdamConfig { learning_rate: 3e-4, ..AdamConfig::default() }
}
