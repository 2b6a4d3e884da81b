//! Chooses among fitted candidates: good ones first, nobody inside somebody else, and not all alike.

use glam::Vec3;

use crate::body::Body;
use crate::fit::{BoneSphere, bone_spheres};
use crate::scene::{BodyParams, PoseFamily};

/// Skin and clothes between two people's bone spheres, beyond the spheres' own radii, which are those of the
/// thinnest flesh around each bone.
const APART_M: f32 = 0.05;
/// Cost of one more person of a pose group that is already there.
const SAME_GROUP: f32 = 0.5;
/// Cost of one more person of the very same family.
const SAME_FAMILY: f32 = 0.5;
/// Cost of one more person on the same thing.
const SAME_SUPPORT: f32 = 0.4;
/// People nearer than this crowd each other.
const CROWDED_M: f32 = 0.9;
/// Cost of crowding at distance zero.
const CROWDED: f32 = 0.8;

/// The space one person takes: spheres along the bones.
#[derive(Clone, Debug)]
pub struct Occupied {
    spheres: Vec<(Vec3, f32)>,
    middle: Vec3,
    reach_m: f32,
}

impl Occupied {
    /// The space of a body with these joints.
    pub fn new(bones: &[BoneSphere], joints: &[Vec3; crate::body::joints::JOINTS]) -> Self {
        let spheres: Vec<(Vec3, f32)> = bones.iter().map(|b| (b.center(joints), b.radius_m)).collect();
        let middle = joints[0];
        let reach_m = spheres.iter().map(|(c, r)| c.distance(middle) + r).fold(0.0, f32::max);
        Self { spheres, middle, reach_m }
    }

    /// Whether two people run into each other.
    pub fn meets(&self, other: &Self) -> bool {
        if self.middle.distance(other.middle) > self.reach_m + other.reach_m + APART_M {
            return false;
        }
        self.spheres.iter().any(|(a, ra)| {
            other.spheres.iter().any(|(b, rb)| a.distance_squared(*b) < (ra + rb + APART_M).powi(2))
        })
    }
}

/// Which of `bodies` keep clear of those `there` and of those before them that do.
pub fn clear_of_others(there: &[BodyParams], bodies: &[BodyParams]) -> Vec<bool> {
    let body = Body::bundled();
    let bones = bone_spheres(body);
    let space = |params: &BodyParams| Occupied::new(&bones, &body.joints(params));
    let mut taken: Vec<Occupied> = there.iter().map(space).collect();
    let mut clear = Vec::with_capacity(bodies.len());
    for params in bodies {
        let own = space(params);
        let free = !taken.iter().any(|other| own.meets(other));
        if free {
            taken.push(own);
        }
        clear.push(free);
    }
    clear
}

/// What the choice needs to know of a candidate or of somebody chosen.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Pose family.
    pub family: PoseFamily,
    /// What holds it; people on one thing are spread over others first.
    pub support: Option<usize>,
    /// Its space.
    pub occupied: Occupied,
    /// Own faults, 0 for none.
    pub cost: f32,
}

impl Entry {
    /// Own faults and likeness to those chosen; `None` when it runs into one of them.
    pub fn cost_beside(&self, chosen: &[Entry]) -> Option<f32> {
        let mut cost = self.cost;
        for other in chosen {
            if self.occupied.meets(&other.occupied) {
                return None;
            }
            if other.family.group() == self.family.group() {
                cost += SAME_GROUP;
            }
            if other.family == self.family {
                cost += SAME_FAMILY;
            }
            if self.support.is_some() && self.support == other.support {
                cost += SAME_SUPPORT;
            }
            let distance = self.occupied.middle.distance(other.occupied.middle);
            cost += CROWDED * (1.0 - distance / CROWDED_M).max(0.0);
        }
        Some(cost)
    }
}

/// The index of the best of `candidates` beside `chosen`; ties go to the first.
pub fn best(candidates: &[Option<Entry>], chosen: &[Entry]) -> Option<usize> {
    let costs = candidates.iter().enumerate().filter_map(|(i, candidate)| {
        candidate.as_ref().and_then(|c| c.cost_beside(chosen)).map(|cost| (i, cost))
    });
    costs.min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0))).map(|(i, _)| i)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(x: f32, family: PoseFamily, cost: f32) -> Entry {
        let middle = Vec3::new(x, 1.0, 0.0);
        Entry {
            family,
            support: None,
            occupied: Occupied { spheres: vec![(middle, 0.1)], middle, reach_m: 0.1 },
            cost,
        }
    }

    #[test]
    fn of_two_in_one_place_the_first_stays_and_whoever_is_there_stays_before_both() {
        let at = |x: f32| BodyParams { translation: Vec3::new(x, 0.9, 0.0), ..BodyParams::default() };
        assert_eq!(clear_of_others(&[], &[at(0.0), at(0.2), at(3.0)]), [true, false, true]);
        assert_eq!(clear_of_others(&[at(0.1)], &[at(0.0), at(3.0)]), [false, true]);
    }

    #[test]
    fn nobody_is_put_inside_somebody_else() {
        let chosen = [entry(0.0, PoseFamily::Stand, 0.0)];
        let candidates = [Some(entry(0.1, PoseFamily::LieUp, 0.0)), Some(entry(0.4, PoseFamily::Stand, 9.0))];
        assert_eq!(best(&candidates, &chosen), Some(1));
        assert_eq!(best(&candidates[..1], &chosen), None);
    }

    #[test]
    fn a_new_pose_comes_before_one_more_of_the_same() {
        let chosen = [entry(0.0, PoseFamily::Stand, 0.0)];
        let candidates =
            [Some(entry(3.0, PoseFamily::Stand, 0.0)), Some(entry(3.0, PoseFamily::SitSofa, 0.3))];
        assert_eq!(best(&candidates, &chosen), Some(1));
    }
}
