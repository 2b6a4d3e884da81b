//! Sizes of the networks of LTM: as published, and compact ones that one processor core trains in minutes.

use std::ops::Range;

use serde::{Deserialize, Serialize};

/// Bodies between the two ends of a clip: with both ends k + 1 = 62, two seconds at 30 frames a second (LTM §4.1).
pub const BETWEEN: usize = 60;
/// Numbers of a body (LTM §3.1 without β): pelvis 3, rotation 6, pose code 32, hand codes 24.
pub const ROW: usize = 65;
/// Numbers of a body's place: pelvis and rotation.
pub const PLACE: usize = 9;
/// Where the pelvis is.
pub const WHERE_COLUMNS: Range<usize> = 0..3;
/// The rotation.
pub const TURN_COLUMNS: Range<usize> = 3..PLACE;
/// The pose code.
pub const POSE_COLUMNS: Range<usize> = PLACE..41;
/// The hand codes.
pub const HAND_COLUMNS: Range<usize> = 41..ROW;
/// Numbers that a sub-goal asks for (LTM §3.2): pelvis 3, rotation 6, betas 10.
pub const CONDITION: usize = PLACE + 10;
/// Classes that PointNet is taught to tell apart first, as many as S3DIS has.
pub const POINT_CLASSES: usize = 13;

/// What a network is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum MotionKind {
    /// PointNet with a head that labels points: what PointNet is pre-trained by (LTM §3.2).
    Points,
    /// Bodies at sub-goals (LTM §3.2).
    SubGoal,
    /// What comes between two bodies (LTM §3.3).
    Between(Between),
}

/// Which of the networks that fill the time between two bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Between {
    /// RouteNet: places and rotations.
    Route,
    /// RouteNet(t) of Table 1: places alone.
    RouteWhere,
    /// PoseNet: poses and hands along a given route.
    Pose,
    /// PoseNet of Table 1 without the route.
    PoseAlone,
    /// PoseNet of Table 1 beside RouteNet(t): rotations too, without the route.
    PoseTurning,
    /// BaseNet of Table 1: everything at once.
    Base,
}

impl Between {
    /// Every one.
    pub const ALL: [Self; 6] =
        [Self::Route, Self::RouteWhere, Self::Pose, Self::PoseAlone, Self::PoseTurning, Self::Base];

    /// Columns of a body that the two tokens hold.
    pub fn token(self) -> Range<usize> {
        match self {
            Self::Route | Self::RouteWhere => 0..PLACE,
            _ => self.outputs(),
        }
    }

    /// Columns of a body that come out for each frame.
    pub fn outputs(self) -> Range<usize> {
        match self {
            Self::Route => 0..PLACE,
            Self::RouteWhere => WHERE_COLUMNS,
            Self::Pose | Self::PoseAlone => PLACE..ROW,
            Self::PoseTurning => TURN_COLUMNS.start..ROW,
            Self::Base => 0..ROW,
        }
    }

    /// Whether it is given the route, 60 x 9 numbers.
    pub fn takes_route(self) -> bool {
        self == Self::Pose
    }
}

impl MotionKind {
    /// Every one.
    pub fn all() -> impl Iterator<Item = Self> {
        [Self::Points, Self::SubGoal].into_iter().chain(Between::ALL.map(Self::Between))
    }

    /// Name on the command line and of weight files.
    pub fn label(self) -> &'static str {
        match self {
            Self::Points => "points",
            Self::SubGoal => "subgoal",
            Self::Between(Between::Route) => "route",
            Self::Between(Between::RouteWhere) => "route-t",
            Self::Between(Between::Pose) => "pose",
            Self::Between(Between::PoseAlone) => "pose-alone",
            Self::Between(Between::PoseTurning) => "pose-turning",
            Self::Between(Between::Base) => "base",
        }
    }
}

/// Sizes of PointNet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PointNetConfig {
    /// Outputs of its three layers; the last is the size of the scene's feature.
    pub channels: [usize; 3],
    /// Points of a cloud.
    pub count: usize,
}

/// A whole network.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MotionConfig {
    /// Which network.
    pub kind: MotionKind,
    /// Whether it sees the room (the ticks of Table 1).
    pub scene: bool,
    /// PointNet.
    pub points: PointNetConfig,
    /// Hidden numbers of each direction of the LSTM.
    pub hidden: usize,
    /// What the scene's feature is narrowed to beside the LSTM's.
    pub scene_lift: usize,
    /// What the route is narrowed to.
    pub route_lift: usize,
    /// Width of the layer before the last.
    pub wide: usize,
    /// Whether what comes out is added to the straight line between the two bodies. The published networks give the
    /// frames themselves; with some thousands of windows instead of ten the line is worth a lot.
    pub from_line: bool,
    /// What body and condition of a sub-goal are lifted to.
    pub lift: usize,
    /// Size of a sub-goal's latent code.
    pub latent: usize,
}

impl MotionConfig {
    /// The published sizes: 0.30 M numbers for RouteNet, 5.3 M for PoseNet, 9.0 M for the sub-goals.
    pub fn paper(kind: MotionKind) -> Self {
        let (hidden, wide) = match kind {
            MotionKind::Between(Between::Route | Between::RouteWhere) => (64, 256),
            _ => (256, 1024),
        };
        Self {
            kind,
            scene: true,
            points: PointNetConfig { channels: [64, 128, 256], count: 1024 },
            hidden,
            scene_lift: 32,
            route_lift: 64,
            wide,
            from_line: false,
            lift: 512,
            latent: 32,
        }
    }

    /// Trained in minutes on one core: a narrow PointNet on fewer points, half of the hidden numbers.
    pub fn compact(kind: MotionKind) -> Self {
        let paper = Self::paper(kind);
        Self {
            points: PointNetConfig { channels: [32, 64, 128], count: 256 },
            hidden: paper.hidden.min(128),
            wide: paper.wide.min(384),
            from_line: true,
            lift: 192,
            ..paper
        }
    }

    /// So small that a test trains it in a second.
    pub fn mini(kind: MotionKind) -> Self {
        Self {
            points: PointNetConfig { channels: [8, 8, 16], count: 32 },
            hidden: 16,
            wide: 48,
            lift: 32,
            latent: 8,
            ..Self::compact(kind)
        }
    }

    /// The same network that sees no room.
    #[must_use]
    pub fn blind(self) -> Self {
        Self { scene: false, ..self }
    }
}
