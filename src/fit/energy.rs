//! The terms' names and the place where each adds its value and its gradients.

use glam::Vec3;

use crate::body::joints::JOINTS;
use crate::scene::PARAMS;

/// A term of an energy.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Term {
    /// Nearness to the proposal.
    Start,
    /// Likely pose.
    PosePrior,
    /// Contact with the room.
    Contact,
    /// Vertices in solid matter.
    Collision,
    /// The room's surfaces inside the body.
    Intrusion,
    /// Bones too near to a surface.
    Bones,
    /// Limbs in the own body.
    SelfCollision,
    /// Joints beyond their limits.
    JointLimits,
    /// Weight beside the feet.
    Balance,
    /// Uneven motion.
    Smoothness,
    /// Planted feet off their places.
    Feet,
}

/// Every term, in the order of [`Energy::terms`].
pub const TERMS: [Term; 11] = [
    Term::Start,
    Term::PosePrior,
    Term::Contact,
    Term::Collision,
    Term::Intrusion,
    Term::Bones,
    Term::SelfCollision,
    Term::JointLimits,
    Term::Balance,
    Term::Smoothness,
    Term::Feet,
];

impl Term {
    /// Name for plots.
    pub fn label(self) -> &'static str {
        match self {
            Self::Start => "start",
            Self::PosePrior => "pose prior",
            Self::Contact => "contact",
            Self::Collision => "collision",
            Self::Intrusion => "intrusion",
            Self::Bones => "bones",
            Self::SelfCollision => "self-collision",
            Self::JointLimits => "joint limits",
            Self::Balance => "balance",
            Self::Smoothness => "smoothness",
            Self::Feet => "planted feet",
        }
    }
}

/// An energy at one point with all its gradients, summed term by term.
pub struct Energy {
    /// Weighted value of each of [`TERMS`].
    pub terms: [f32; TERMS.len()],
    /// With respect to the probe's vertices.
    pub vertices: Vec<Vec3>,
    /// With respect to the joints.
    pub joints: [Vec3; JOINTS],
    /// With respect to the joints' own axis-angles.
    pub local: [Vec3; JOINTS],
    /// With respect to the 75 numbers directly.
    pub params: [f32; PARAMS],
}

impl Energy {
    /// No energy, for a probe of `vertices` vertices.
    pub fn new(vertices: usize) -> Self {
        Self {
            terms: [0.0; TERMS.len()],
            vertices: vec![Vec3::ZERO; vertices],
            joints: [Vec3::ZERO; JOINTS],
            local: [Vec3::ZERO; JOINTS],
            params: [0.0; PARAMS],
        }
    }

    /// Back to zero, keeping the memory.
    pub fn clear(&mut self) {
        self.terms = [0.0; TERMS.len()];
        self.vertices.fill(Vec3::ZERO);
        self.joints = [Vec3::ZERO; JOINTS];
        self.local = [Vec3::ZERO; JOINTS];
        self.params = [0.0; PARAMS];
    }

    /// Adds a term's weighted value.
    pub fn add(&mut self, term: Term, value: f32) {
        self.terms[term as usize] += value;
    }
}
