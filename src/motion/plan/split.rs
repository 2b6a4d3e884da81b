//! Where on a way sub-goals go: at most so many seconds of walking apart, on its straighter parts.

use super::{PlanConfig, Way};
use crate::motion::leg::{PathPoint, Walking};
use crate::scene::direction_of;

/// How fast people speed up and slow down, metres per second squared.
const RAMP: f32 = 1.0;
/// The first and last bit of a way is walked at least this fast, metres per second.
const FIRST_M_PER_S: f32 = 0.35;
/// A sub-goal may move this part of its leg's time to where the way bends less.
const LEEWAY: f32 = 0.15;

/// One more leg is worth strides that are stretched by this much less, as a logarithm.
const MORE_LEGS: f32 = 0.08;

/// A sub-goal on a way: which of its points, and how it is walked through.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct OnWay {
    pub index: usize,
    pub walking: Walking,
}

/// Walking time at each point since the way's beginning, seconds.
fn times(points: &[PathPoint], ramps: [bool; 2]) -> Vec<f32> {
    let step = |i: usize| points[i].at.distance(points[i + 1].at);
    let mut speed: Vec<f32> = points.iter().map(|p| p.speed_m_per_s).collect();
    let last = points.len() - 1;
    if ramps[0] {
        speed[0] = speed[0].min(FIRST_M_PER_S);
    }
    if ramps[1] {
        speed[last] = speed[last].min(FIRST_M_PER_S);
    }
    for i in 0..last {
        speed[i + 1] = speed[i + 1].min((speed[i] * speed[i] + 2.0 * RAMP * step(i)).sqrt());
    }
    for i in (0..last).rev() {
        speed[i] = speed[i].min((speed[i + 1] * speed[i + 1] + 2.0 * RAMP * step(i)).sqrt());
    }
    let mut time = vec![0.0; points.len()];
    for i in 0..last {
        time[i + 1] = time[i] + 2.0 * step(i) / (speed[i] + speed[i + 1]).max(1e-3);
    }
    time
}

/// Sub-goals between the ends of a way; `still` says which end somebody stands at.
pub(super) fn between(way: &Way, still: [bool; 2], config: &PlanConfig) -> Vec<OnWay> {
    let points = &way.points;
    if points.len() < 2 {
        return Vec::new();
    }
    let time = times(points, still);
    let total = time[points.len() - 1];
    if total <= config.apart_s {
        return Vec::new();
    }
    let legs = count_of_legs(total, way.length_m(), config);
    let each = total / legs as f32;
    let place = |k: usize| {
        let at = |t: f32| time.partition_point(|time| *time < t).min(points.len() - 1);
        let (low, middle, high) = ((k as f32 - LEEWAY) * each, k as f32 * each, (k as f32 + LEEWAY) * each);
        let bend = |i: usize| {
            let (a, b) = (&points[i.saturating_sub(4)], &points[(i + 4).min(points.len() - 1)]);
            direction_of(a.heading).angle_to(direction_of(b.heading)).abs()
        };
        // A degree of bend weighs as much as a hundredth of a second.
        let cost = |i: usize| bend(i).to_degrees() * 0.01 + (time[i] - middle).abs();
        (at(low)..=at(high)).min_by(|a, b| cost(*a).total_cmp(&cost(*b))).unwrap_or(at(middle))
    };
    let mut places: Vec<usize> = (1..legs).map(place).collect();
    if still == [true, true] {
        places = whole_strides(points, &time, &places, config).unwrap_or(places);
    }
    let on_way = |index: usize| {
        let point = &points[index];
        let walking = Walking { at: point.at, heading: point.heading, speed_m_per_s: point.speed_m_per_s };
        OnWay { index, walking }
    };
    places.into_iter().map(on_way).collect()
}

/// The same sub-goals moved so that whole strides of natural length lie between any two: only the first and the last
/// leg, which set off and arrive, can take any number of steps. `None` where that would be a leg of too long a time.
fn whole_strides(
    points: &[PathPoint],
    time: &[f32],
    places: &[usize],
    config: &PlanConfig,
) -> Option<Vec<usize>> {
    let (first, last) = (*places.first()?, *places.last()?);
    let mut along = vec![0.0; points.len()];
    for i in 1..points.len() {
        along[i] = along[i - 1] + points[i].at.distance(points[i - 1].at);
    }
    let inner = places.len().checked_sub(1).filter(|inner| *inner > 0)? as f32;
    let length_m = (along[last] - along[first]) / inner;
    // Steps grow about as the root of the speed (Grieve 1968).
    let speed = (along[last] - along[first]) / (time[last] - time[first]).max(1e-3);
    let stride_m = config.stride_m * (speed / config.speed_m_per_s).sqrt();
    let wanted_m = stride_m * (length_m / stride_m).round().max(1.0);
    let middle_m = 0.5 * (along[first] + along[last]);
    let moved = places.iter().enumerate().map(|(k, _)| {
        let at_m = middle_m + (k as f32 - 0.5 * inner) * wanted_m;
        along.partition_point(|a| *a < at_m)
    });
    let moved: Vec<usize> = moved.collect();
    let ends = std::iter::once(0).chain(moved.iter().copied()).chain([points.len() - 1]);
    let ends: Vec<usize> = ends.collect();
    let fits = |leg: &[usize]| {
        leg[1] > leg[0] + 4 && leg[1] < points.len() && time[leg[1]] - time[leg[0]] <= config.apart_s
    };
    ends.windows(2).all(fits).then_some(moved)
}

/// Into how many legs a way is cut: few, and so long that strides need little stretching.
fn count_of_legs(total_s: f32, length_m: f32, config: &PlanConfig) -> usize {
    // Moved towards each other's far sides, two sub-goals are still no farther apart than allowed.
    let least = (total_s * (1.0 + 2.0 * LEEWAY) / config.apart_s).ceil().max(2.0) as usize;
    let cost = |legs: usize| {
        let strides = length_m / legs as f32 / config.stride_m;
        let stretch = (strides / strides.round().max(1.0)).ln().abs();
        stretch + MORE_LEGS * (legs - least) as f32
    };
    (least..least + 3).min_by(|a, b| cost(*a).total_cmp(&cost(*b))).unwrap_or(least)
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    fn straight(length_m: f32) -> Way {
        let count = (length_m / 0.05) as usize;
        let point = |i: usize| PathPoint {
            at: Vec3::Z * (i as f32 * 0.05),
            heading: 0.0,
            clearance_m: 1.0,
            speed_m_per_s: 1.2,
        };
        Way { points: (0..=count).map(point).collect(), squeeze: None }
    }

    #[test]
    fn sub_goals_are_never_more_than_two_seconds_of_walking_apart() {
        let config = PlanConfig::default();
        for length_m in [0.5, 1.5, 2.5, 4.0, 7.3, 15.0] {
            let way = straight(length_m);
            let time = times(&way.points, [true, true]);
            let mut marks = vec![0.0];
            marks.extend(between(&way, [true, true], &config).iter().map(|g| time[g.index]));
            marks.push(time[time.len() - 1]);
            let longest = marks.windows(2).map(|m| m[1] - m[0]).fold(0.0, f32::max);
            assert!(longest <= config.apart_s + 1e-3, "{length_m} m: {longest} s between sub-goals");
            assert!(marks.windows(2).all(|m| m[1] > m[0]));
        }
    }

    #[test]
    fn between_two_moments_of_a_walk_lie_whole_strides() {
        let config = PlanConfig::default();
        for length_m in [3.7, 4.4, 5.1, 6.0] {
            let goals = between(&straight(length_m), [true, true], &config);
            for pair in goals.windows(2) {
                let strides = pair[0].walking.at.distance(pair[1].walking.at) / config.stride_m;
                let off = strides / strides.round().max(1.0);
                assert!((0.9..1.1).contains(&off), "{strides} strides on a way of {length_m} m");
            }
        }
    }

    #[test]
    fn six_metres_take_about_as_long_as_a_person_needs() {
        let way = straight(6.0);
        let time = times(&way.points, [true, true]);
        let total = time[time.len() - 1];
        assert!((5.3..6.6).contains(&total), "{total} s for 6 m with a start and a stop");
    }
}
