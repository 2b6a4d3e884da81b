//! What a body seems to do: its pose group from its joints and from how high it is above what lies below.

use glam::{Mat3, Vec3};

use crate::body::joints as j;
use crate::body::joints::JOINTS;
use crate::scene::PoseFamily;

/// A torso farther from the vertical than this lies (or bends over its legs).
const LYING: f32 = 62.0;
/// Between this and [`LYING`] the height above the support decides.
const INCLINED: f32 = 42.0;
/// Hips bent farther than this sit.
const SITTING: f32 = 58.0;
/// Between this and [`SITTING`] the height of the pelvis decides.
const BENT: f32 = 32.0;
/// Knees straighter than this, on bent hips, are stretched out in front.
const STRAIGHT_KNEES: f32 = 42.0;
/// Pelvis joints of lying people are lower than this above what they lie on.
const LYING_PELVIS_M: f32 = 0.4;
/// Pelvis joints of standing people are higher than this share of their legs above the floor.
const STANDING_PELVIS: f32 = 0.8;
/// Cosine beyond which the front of a lying person faces up or down; between, they lie on a side.
const FACING: f32 = 0.5;

/// What the joints say, in degrees and metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Posture {
    /// From the vertical to the line from pelvis to neck.
    pub torso_deg: f32,
    /// Mean angle between thighs and the torso's own downward direction.
    pub hips_deg: f32,
    /// Mean angle between thighs and shanks.
    pub knees_deg: f32,
    /// Height part of the unit vector out of the chest.
    pub front_up: f32,
    /// From the ankles' middle up to the hips' middle.
    pub legs_rise_m: f32,
    /// Length of a straight leg, hip to ankle.
    pub leg_m: f32,
}

impl Posture {
    /// Measures posed joints and the pelvis' rotation, world frame.
    pub fn of(joints: &[Vec3; JOINTS], world_from_pelvis: &Mat3) -> Self {
        let torso = joints[j::NECK] - joints[j::PELVIS];
        let legs =
            [(j::LEFT_HIP, j::LEFT_KNEE, j::LEFT_ANKLE), (j::RIGHT_HIP, j::RIGHT_KNEE, j::RIGHT_ANKLE)];
        let mean = |of: &dyn Fn(usize, usize, usize) -> f32| {
            0.5 * legs.iter().map(|&(hip, knee, ankle)| of(hip, knee, ankle)).sum::<f32>()
        };
        let thigh = |hip: usize, knee: usize| joints[knee] - joints[hip];
        Self {
            torso_deg: degrees(torso, Vec3::Y),
            hips_deg: mean(&|hip, knee, _| degrees(thigh(hip, knee), -torso)),
            knees_deg: mean(&|hip, knee, ankle| degrees(thigh(hip, knee), joints[ankle] - joints[knee])),
            front_up: (*world_from_pelvis * Vec3::Z).y,
            legs_rise_m: mean(&|hip, _, ankle| joints[hip].y - joints[ankle].y),
            leg_m: mean(&|hip, knee, ankle| thigh(hip, knee).length() + joints[ankle].distance(joints[knee])),
        }
    }

    /// The family of this posture with the pelvis `pelvis_m` above the nearest surface below it.
    ///
    /// Gives [`PoseFamily::SitChair`] for every seated posture with bent knees and [`PoseFamily::Stand`] for every
    /// upright one: what it sits or leans on is found later.
    pub fn family(&self, pelvis_m: f32) -> PoseFamily {
        let bends_over = self.legs_rise_m > STANDING_PELVIS * self.leg_m;
        let low = pelvis_m < LYING_PELVIS_M;
        // A raised upper body on a bed sits; a flat one lies, however its knees are drawn up.
        let lies = self.torso_deg > LYING || (self.torso_deg > INCLINED && low && self.hips_deg < SITTING);
        if lies && !bends_over {
            return self.lying();
        }
        let sits = self.hips_deg > SITTING
            || (self.hips_deg > BENT && pelvis_m < STANDING_PELVIS * self.leg_m && !bends_over);
        match (sits && !bends_over, self.knees_deg < STRAIGHT_KNEES && self.hips_deg > SITTING) {
            (true, true) => PoseFamily::SitStraight,
            (true, false) => PoseFamily::SitChair,
            (false, _) => PoseFamily::Stand,
        }
    }

    fn lying(&self) -> PoseFamily {
        if self.front_up > FACING {
            PoseFamily::LieUp
        } else if self.front_up < -FACING {
            PoseFamily::LieDown
        } else {
            PoseFamily::LieSide
        }
    }
}

fn degrees(a: Vec3, b: Vec3) -> f32 {
    let cosine = a.normalize_or_zero().dot(b.normalize_or_zero());
    cosine.clamp(-1.0, 1.0).acos().to_degrees()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::{Body, FamilyHints, sample_pose};
    use crate::job::Seed;
    use rand::RngExt as _;

    /// Share of drawn people of each group that are taken for their own, tilted by up to `tilt_deg`.
    fn hits(tilt_deg: f32) -> Vec<(PoseFamily, f32)> {
        let body = Body::bundled();
        let mut rng = Seed::root(5).rng();
        let share = |family: PoseFamily| {
            let hit = |_: &i32| {
                let drawn =
                    sample_pose(&body.model.joint_template, family, &mut rng, &FamilyHints::default());
                let axis = Vec3::new(rng.random_range(-1.0..1.0), 0.0, rng.random_range(-1.0..1.0));
                let tilt = Mat3::from_axis_angle(axis.normalize_or(Vec3::X), tilt_deg.to_radians());
                let params = drawn.params(body, [0.0; 10], &tilt);
                let posture = Posture::of(&body.pose(&params).joints, &params.rotation());
                let pelvis_m = match family.group() {
                    "lie" => 0.15,
                    "sit" => 0.12,
                    _ => 0.92,
                };
                let guess = posture.family(pelvis_m);
                let sides = matches!(family, PoseFamily::LieSide) && guess.group() == "lie";
                let lies = family.group() == "lie" && !sides;
                let upright = family.group() == "lean" && guess == PoseFamily::Stand;
                upright || sides || if lies { guess == family } else { guess.group() == family.group() }
            };
            (0..30).filter(hit).count() as f32 / 30.0
        };
        PoseFamily::ALL.into_iter().map(share).zip(PoseFamily::ALL).map(|(s, f)| (f, s)).collect()
    }

    #[test]
    fn people_are_taken_for_what_they_do() {
        for (family, share) in hits(0.0) {
            assert!(share > 0.9, "{}: {share}", family.label());
        }
    }

    #[test]
    fn a_tilt_of_20_degrees_rarely_deceives() {
        for (family, share) in hits(20.0) {
            assert!(share > 0.7, "{}: {share}", family.label());
        }
    }
}
