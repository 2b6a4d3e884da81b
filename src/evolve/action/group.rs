use serde::{Deserialize, Serialize};

use super::model::Occurrence;

/// ADSE eq. 7: people of a group stand or sit so far apart, each from each, metres.
pub const PEOPLE_APART_M: [f32; 2] = [0.6, 2.0];
/// ADSE eq. 6: a shared object's farthest person is nearer than this share of the two farthest people.
const MOST_OF_SPREAD: f32 = 2.0 / 3.0;
/// ADSE eq. 6: a shared object's farthest person is nearer than so many times its nearest.
const MOST_UNEVEN: f32 = 2.0;

/// What a group does together, beside what each of its people does alone (ADSE §4.4).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GroupModel {
    /// Probability of a group of (so many people), two to four.
    pub sizes: Vec<(usize, f64)>,
    /// How often how many of each shared object, C_s.
    pub shared: Vec<Occurrence>,
    /// How far people are from each other [`PEOPLE_APART_M`] (uniform between, eq. 7).
    pub people_apart_m: [f32; 2],
    /// Groups that were looked at.
    pub groups: usize,
}

impl GroupModel {
    /// Density per metre of the distance between two people (eq. 7).
    pub fn distance_density(&self, distance_m: f32) -> f32 {
        let [least, most] = self.people_apart_m;
        if (least..=most).contains(&distance_m) { 1.0 / (most - least) } else { 0.0 }
    }
}

/// Whether an object at these distances from all people of a group is shared by them (eq. 6): neither too far from
/// nor too near to anybody. `people_spread` is the largest distance between two of them, in the same unit.
pub fn is_shared(distances: &[f32], people_spread: f32) -> bool {
    let (nearest, farthest) = extent(distances);
    !distances.is_empty() && farthest < MOST_OF_SPREAD * people_spread && farthest < MOST_UNEVEN * nearest
}

/// How well a place suits a shared object, up to a factor (eq. 8): 1 over the distance of the farthest person.
pub fn shared_potential(distances: &[f32]) -> f32 {
    1.0 / extent(distances).1.max(f32::MIN_POSITIVE)
}

fn extent(distances: &[f32]) -> (f32, f32) {
    distances.iter().fold((f32::INFINITY, 0.0), |(low, high), d| (low.min(*d), high.max(*d)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_stands_between_people_is_shared_and_what_is_before_one_is_not() {
        assert!(is_shared(&[0.6, 0.7], 1.2));
        assert!(!is_shared(&[0.3, 0.9], 1.2), "farther than two thirds of the spread");
        assert!(!is_shared(&[0.3, 0.7], 1.2), "more than twice as far from one");
        assert!(!is_shared(&[], 1.0));
        assert!(shared_potential(&[0.6, 0.7]) > shared_potential(&[0.6, 0.8]));
    }

    #[test]
    fn distances_between_people_are_uniform_in_their_range() {
        let group = GroupModel { people_apart_m: PEOPLE_APART_M, ..GroupModel::default() };
        assert_eq!([0.5, 2.1].map(|d| group.distance_density(d)), [0.0, 0.0]);
        assert!((group.distance_density(1.0) - 1.0 / 1.4).abs() < 1e-6);
    }
}
