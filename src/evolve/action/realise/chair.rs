//! What of a chair is the seat, and which way it looks: the sitting relation between a person and what they sit on.

use glam::{Vec2, Vec3};

use super::shape::Shape;

/// Seats are found between these heights.
const SEATS_M: std::ops::Range<f32> = 0.3..0.9;
/// Heights of one seat differ by this much at most.
const LEVEL_M: f32 = 0.035;
/// What rises this far over the seat is back or arm.
const BACK_M: f32 = 0.15;
/// The mean of what rises lies at least this far from the middle where there is a back.
const BACK_OFF_M: f32 = 0.05;
/// Rays along each side of the plan.
const STEPS: usize = 14;

/// The seat of a chair or stool, in its own frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChairSeat {
    /// Over the chair's foot.
    pub height_m: f32,
    /// Where the pelvis goes, in plan.
    pub at: Vec2,
    /// Where somebody on it looks, in plan; `None` without a back.
    pub front: Option<Vec2>,
}

impl ChairSeat {
    /// The seat of a shape, if it has one.
    pub fn of(shape: &Shape) -> Option<Self> {
        let (low, size) = (shape.bounds.min, shape.bounds.size());
        let step = |i: usize| (i as f32 + 0.5) / STEPS as f32;
        let top = |at: Vec2| {
            let from = Vec3::new(at.x, shape.bounds.max.y + 0.01, at.y);
            let hit = shape.tree.cast(from, Vec3::NEG_Y, size.y + 0.02)?;
            Some((at, from.y - hit.distance_m - low.y))
        };
        let tops: Vec<(Vec2, f32)> = (0..STEPS)
            .flat_map(|i| (0..STEPS).map(move |j| Vec2::new(step(i), step(j))))
            .filter_map(|s| top(Vec2::new(low.x + s.x * size.x, low.z + s.y * size.z)))
            .collect();
        let at_level = |h: f32| tops.iter().filter(move |t| (t.1 - h).abs() < LEVEL_M);
        let levels = tops.iter().map(|t| t.1).filter(|h| SEATS_M.contains(h));
        let level =
            levels.max_by(|a, b| at_level(*a).count().cmp(&at_level(*b).count()).then(a.total_cmp(b)))?;
        let seat: Vec<Vec2> = at_level(level).map(|t| t.0).collect();
        if seat.len() < STEPS * STEPS / 8 {
            return None;
        }
        let mean = |points: &[Vec2]| points.iter().sum::<Vec2>() / points.len().max(1) as f32;
        let at = mean(&seat);
        let over: Vec<Vec2> = tops.iter().filter(|t| t.1 > level + BACK_M).map(|t| t.0).collect();
        let off = mean(&over) - at;
        let front = (over.len() >= 3 && off.length() > BACK_OFF_M).then(|| -off.normalize_or_zero());
        // Seats are level with their front half; behind, cushions rise.
        let height_m = at_level(level).map(|t| t.1).sum::<f32>() / seat.len() as f32;
        Some(Self { height_m, at, front })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evolve::action::realise::library::Library;

    #[test]
    fn chairs_of_the_library_look_along_plus_z_and_are_as_high_as_chairs() {
        let library = Library::bundled();
        for name in ["chair", "stool"] {
            let kind = library.named(name).expect("there");
            for look in 0..library.looks(kind) {
                let thing = library.thing(kind, look).expect("reads");
                let seat = ChairSeat::of(&thing.shape).unwrap_or_else(|| panic!("{} has a seat", thing.name));
                assert!((0.38..0.56).contains(&seat.height_m), "{}: {}", thing.name, seat.height_m);
                assert!(seat.at.length() < 0.12, "{}: {}", thing.name, seat.at);
                assert_eq!(seat.front.is_some(), name == "chair", "{}", thing.name);
                if let Some(front) = seat.front {
                    assert!(front.dot(Vec2::Y) > 0.95, "{} looks along {front}", thing.name);
                }
            }
        }
    }
}
