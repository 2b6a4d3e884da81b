use glam::{Mat3, Vec3};
use serde::{Deserialize, Serialize};

use crate::math::rotation;

/// Numbers of body shape.
pub const BETAS: usize = 10;
/// Numbers of the body pose code (θ_b, PSI §3.1).
pub const POSE: usize = 32;
/// Numbers of the hand pose code (θ_h): 12 left, 12 right.
pub const HANDS: usize = 24;
/// Numbers of a whole body (x_h).
pub const PARAMS: usize = 3 + 6 + BETAS + POSE + HANDS;

/// A body as 75 numbers (PSI §3.1): `t 3 | R 6 | betas 10 | pose 32 | hands 24`, in the world frame.
///
/// As in SMPL-X the rotation turns the body about its pelvis joint and `translation` is added afterwards,
/// so the pelvis joint stands at `pelvis_rest(betas) + translation`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BodyParams {
    /// Global translation `t` in metres.
    pub translation: Vec3,
    /// Global rotation `R`, 6-D row-major 3x2.
    pub rotation6: [f32; 6],
    /// Body shape β, unit variance.
    pub betas: [f32; BETAS],
    /// Body pose code, unit variance under the pose space's prior.
    pub pose: [f32; POSE],
    /// Hand pose codes, left then right.
    pub hands: [f32; HANDS],
}

impl Default for BodyParams {
    fn default() -> Self {
        Self {
            translation: Vec3::ZERO,
            rotation6: [1.0, 0.0, 0.0, 1.0, 0.0, 0.0],
            betas: [0.0; BETAS],
            pose: [0.0; POSE],
            hands: [0.0; HANDS],
        }
    }
}

impl BodyParams {
    /// Where each block starts in the flat vector: t, R, betas, pose, hands.
    pub const OFFSETS: [usize; 5] = [0, 3, 9, 9 + BETAS, 9 + BETAS + POSE];

    /// The flat vector x_h.
    pub fn to_vector(&self) -> [f32; PARAMS] {
        let mut x = [0.0; PARAMS];
        let [t, r, b, p, h] = Self::OFFSETS;
        x[t..r].copy_from_slice(&self.translation.to_array());
        x[r..b].copy_from_slice(&self.rotation6);
        x[b..p].copy_from_slice(&self.betas);
        x[p..h].copy_from_slice(&self.pose);
        x[h..].copy_from_slice(&self.hands);
        x
    }

    /// The body of a flat vector x_h.
    pub fn from_vector(x: &[f32; PARAMS]) -> Self {
        let [_, r, b, p, h] = Self::OFFSETS;
        let mut body = Self { translation: Vec3::from_slice(x), ..Self::default() };
        body.rotation6.copy_from_slice(&x[r..b]);
        body.betas.copy_from_slice(&x[b..p]);
        body.pose.copy_from_slice(&x[p..h]);
        body.hands.copy_from_slice(&x[h..]);
        body
    }

    /// The global rotation as a matrix, world from body.
    pub fn rotation(&self) -> Mat3 {
        rotation::matrix_from_6d(&self.rotation6)
    }

    /// Sets the global rotation.
    pub fn set_rotation(&mut self, world_from_body: &Mat3) {
        self.rotation6 = rotation::six_d_from_matrix(world_from_body);
    }
}

/// What a body does with the room; the affordance it was generated for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum PoseFamily {
    /// Stands free on the floor.
    Stand,
    /// Stands with hands or hips against a counter, table or wall.
    Lean,
    /// Sits on a chair or armchair, back near the backrest, feet on the floor.
    SitChair,
    /// Sits on a couch.
    SitSofa,
    /// Sits on a stool: no backrest.
    SitStool,
    /// Sits on the edge of a bed, table or other surface.
    SitEdge,
    /// Sits with straight legs on a bed, couch or floor.
    SitStraight,
    /// Lies on the back.
    LieUp,
    /// Lies on the belly.
    LieDown,
    /// Lies on one side.
    LieSide,
}

impl PoseFamily {
    /// Every family.
    pub const ALL: [Self; 10] = [
        Self::Stand,
        Self::Lean,
        Self::SitChair,
        Self::SitSofa,
        Self::SitStool,
        Self::SitEdge,
        Self::SitStraight,
        Self::LieUp,
        Self::LieDown,
        Self::LieSide,
    ];

    /// The group that reports and the command line speak of: `stand`, `lean`, `sit` or `lie`.
    pub fn group(self) -> &'static str {
        match self {
            Self::Stand => "stand",
            Self::Lean => "lean",
            Self::SitChair | Self::SitSofa | Self::SitStool | Self::SitEdge | Self::SitStraight => "sit",
            Self::LieUp | Self::LieDown | Self::LieSide => "lie",
        }
    }

    /// Name for people.
    pub fn label(self) -> &'static str {
        match self {
            Self::Stand => "stand",
            Self::Lean => "lean",
            Self::SitChair => "sit on chair",
            Self::SitSofa => "sit on sofa",
            Self::SitStool => "sit on stool",
            Self::SitEdge => "sit on edge",
            Self::SitStraight => "sit with straight legs",
            Self::LieUp => "lie face up",
            Self::LieDown => "lie face down",
            Self::LieSide => "lie on the side",
        }
    }
}

/// Names a person for as long as the project lives; never used again after a removal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct PersonId(pub u32);

/// Somebody in the room.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Person {
    /// Stable name.
    pub id: PersonId,
    /// Name for people.
    pub name: String,
    /// The body.
    pub body: BodyParams,
    /// What it was generated to do.
    pub family: PoseFamily,
    /// Name of what holds it (an object's category or "floor").
    pub on: String,
    /// Seed of the body, for re-rolls and reports.
    pub seed: u64,
    /// Chooses the clothes' colours.
    pub palette: u32,
    /// Shown.
    pub visible: bool,
    /// Protected from re-rolls and removal by jobs.
    pub locked: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_flat_vector_has_75_numbers_and_survives_a_round_trip() {
        let x: [f32; PARAMS] = std::array::from_fn(|i| i as f32);
        assert_eq!(PARAMS, 75);
        assert_eq!(BodyParams::from_vector(&x).to_vector(), x);
        assert_eq!(BodyParams::from_vector(&x).betas[0], 9.0);
        assert_eq!(BodyParams::from_vector(&x).hands[0], 51.0);
    }
}
