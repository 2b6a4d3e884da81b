//! How well any body is refined into a plausible one: people disturbed by as much as networks err, and people at
//! random places, before any network is there.

use glam::{Mat3, Vec3};
use rand::RngExt as _;
use serde::{Deserialize, Serialize};

use crate::body::{Body, FamilyHints, sample_pose};
use crate::evolve::Refined;
use crate::inspect::BodyMetrics;
use crate::job::Seed;
use crate::scene::{BETAS, BodyParams, PoseFamily, RoomGeometry};

/// By how much a body is disturbed; each number is drawn evenly between plus and minus this.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Disturbance {
    /// Along x and z, metres.
    pub sideways_m: f32,
    /// Along y, metres.
    pub vertical_m: f32,
    /// About the vertical, radians.
    pub yaw: f32,
    /// About both horizontal axes, radians.
    pub tilt: f32,
    /// Each number of the pose code.
    pub code: f32,
}

impl Default for Disturbance {
    /// Up to half a metre and twenty degrees off: a poor network.
    fn default() -> Self {
        Self { sideways_m: 0.5, vertical_m: 0.3, yaw: 0.6, tilt: 0.35, code: 0.6 }
    }
}

impl Disturbance {
    /// The bodies, disturbed.
    pub fn apply(&self, bodies: &[BodyParams], seed: Seed) -> Vec<BodyParams> {
        let mut rng = seed.child("disturbance", 0).rng();
        let disturbed = |body: &BodyParams| {
            let mut off = |most: f32| if most > 0.0 { rng.random_range(-most..most) } else { 0.0 };
            let mut body = body.clone();
            body.translation += Vec3::new(off(self.sideways_m), off(self.vertical_m), off(self.sideways_m));
            let tilt = Mat3::from_rotation_x(off(self.tilt)) * Mat3::from_rotation_z(off(self.tilt));
            body.set_rotation(&(Mat3::from_rotation_y(off(self.yaw)) * tilt * body.rotation()));
            body.pose.iter_mut().for_each(|z| *z += off(self.code));
            body
        };
        bodies.iter().map(disturbed).collect()
    }
}

/// Highest that the pelvis of a body placed at random is over the room's lowest point, metres.
const HIGHEST_M: f32 = 1.5;

/// People of all families in turn, upright as their family is, anywhere in the room's box up to 1.5 m high: the
/// placement without any knowledge that learned samples are compared with.
pub fn random_placements(geometry: &RoomGeometry, count: usize, seed: Seed) -> Vec<BodyParams> {
    let body = Body::bundled();
    let mut rng = seed.child("placement", 0).rng();
    let one = |i: usize| {
        let family = PoseFamily::ALL[i % PoseFamily::ALL.len()];
        let pose = sample_pose(&body.model.joint_template, family, &mut rng, &FamilyHints::default());
        let yaw = Mat3::from_rotation_y(rng.random_range(0.0..std::f32::consts::TAU));
        let mut params = pose.params(body, [0.0; BETAS], &yaw);
        let (low, high) = (geometry.bounds.min, geometry.bounds.max);
        let high = Vec3::new(high.x, high.y.min(low.y + HIGHEST_M), high.z);
        let share = Vec3::new(rng.random(), rng.random(), rng.random());
        params.translation = low + (high - low) * share;
        params
    };
    (0..count).map(one).collect()
}

/// Means over bodies, in the words of PSI table 3 and ours.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PlausibilityRow {
    /// What was measured.
    pub name: String,
    /// How many bodies.
    pub bodies: usize,
    /// Mean share of vertices in free space (PSI §4.1.4).
    pub psi_non_collision: f32,
    /// Share of bodies with a vertex in a surface (PSI §4.1.4).
    pub psi_contact: f32,
    /// Share of bodies with contact skin within 2 cm of a surface.
    pub contact_2cm: f32,
    /// Share of bodies whose weight stands over what carries it.
    pub supported: f32,
    /// Mean over bodies of the deepest penetration, millimetres.
    pub penetration_mm: f32,
    /// Share of bodies without any finding; 0 where findings were not asked for.
    pub clean: f32,
    /// Mean distance that the pelvis was moved, metres.
    pub moved_m: f32,
    /// Mean time a body took on its thread, seconds.
    pub seconds: f64,
}

impl PlausibilityRow {
    /// Of bodies as they are.
    pub fn of_metrics<'a>(name: &str, metrics: impl Iterator<Item = &'a BodyMetrics>) -> Self {
        let all: Vec<&BodyMetrics> = metrics.collect();
        let mean = |of: &dyn Fn(&BodyMetrics) -> f32| {
            all.iter().map(|m| of(m)).sum::<f32>() / all.len().max(1) as f32
        };
        let share = |b: bool| if b { 1.0 } else { 0.0 };
        Self {
            name: name.to_owned(),
            bodies: all.len(),
            psi_non_collision: mean(&|m| m.psi_non_collision),
            psi_contact: mean(&|m| share(m.psi_contact)),
            contact_2cm: mean(&|m| share(m.contact_2cm)),
            supported: mean(&|m| share(m.supported)),
            penetration_mm: mean(&|m| m.penetration_max_mm),
            ..Self::default()
        }
    }

    /// Of refined bodies.
    pub fn of_refined(name: &str, refined: &[Refined]) -> Self {
        let count = refined.len().max(1);
        let clean = refined.iter().filter(|r| r.findings.is_empty()).count();
        Self {
            clean: clean as f32 / count as f32,
            moved_m: refined.iter().map(|r| r.moved_m).sum::<f32>() / count as f32,
            seconds: refined.iter().map(|r| r.seconds).sum::<f64>() / count as f64,
            ..Self::of_metrics(name, refined.iter().map(|r| &r.report.metrics))
        }
    }
}
