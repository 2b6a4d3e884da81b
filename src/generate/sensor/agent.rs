//! MP3D-R's agent: somebody 1.8 m tall walks the room and looks down at it, for testing (PSI §4.1.1).

use glam::Vec3;
use rand::RngExt as _;
use rayon::prelude::*;

use super::cameras::is_free;
use super::capture::{Capture, Sensor};
use super::category_of;
use super::view::{Intrinsics, View};
use crate::job::{Rng, Seed};
use crate::scene::Category;

/// Views looked at for each one that is taken.
const CANDIDATES_PER_VIEW: usize = 24;
/// Fewest and most candidates in all.
const CANDIDATES: std::ops::RangeInclusive<usize> = 96..=4000;
/// Columns of the quick look that judges a candidate.
const GLANCE: u32 = 32;
/// What is nearer than this fills the picture and says nothing, in metres.
const TOO_NEAR_M: f32 = 0.8;
/// Two views whose eyes or whose looked-at points are this far apart, in metres, are different ones.
const OTHER_M: f32 = 0.8;

/// Settings of [`agent_views`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AgentConfig {
    /// Lens and picture.
    pub intrinsics: Intrinsics,
    /// Height of the sensor over the floor in metres (PSI §4.1.1).
    pub height_m: f32,
    /// Least and largest angle in degrees by which it looks down.
    pub down_deg: [f32; 2],
}

impl Default for AgentConfig {
    fn default() -> Self {
        Self { intrinsics: Intrinsics::PROX_E, height_m: 1.8, down_deg: [15.0, 35.0] }
    }
}

/// A view that might be taken.
struct Candidate {
    view: View,
    /// The point that the middle of the picture shows.
    looks_at: Vec3,
    /// How much it shows: 0 a wall before one's nose, 1 furniture only.
    worth: f32,
}

/// Views from walkable floor, the most telling first: many draws of place and direction, of which those are
/// taken that show much floor and furniture and differ from each other. Fewer than asked for only where nobody
/// can stand; the same seed gives the same views, whatever the number of threads.
pub fn agent_views(sensor: &Sensor<'_>, count: usize, config: &AgentConfig, seed: Seed) -> Vec<View> {
    let floor = &sensor.geometry().floor;
    let mut cells: Vec<usize> = floor.largest_area().collect();
    cells.retain(|&cell| is_free(sensor.geometry(), floor.position(cell) + Vec3::Y * config.height_m));
    if cells.is_empty() {
        return Vec::new();
    }
    let tries = (count * CANDIDATES_PER_VIEW).clamp(*CANDIDATES.start(), *CANDIDATES.end()).max(count);
    let draw = |index: usize| {
        let mut rng = seed.child("agent", index as u64).rng();
        let stand = floor.position(cells[rng.random_range(0..cells.len())]);
        judged(sensor, drawn_view(stand, config, &mut rng))
    };
    let mut candidates: Vec<Candidate> = (0..tries).into_par_iter().map(draw).collect();
    let mut views = Vec::new();
    while views.len() < count && !candidates.is_empty() {
        let best =
            (0..candidates.len()).fold(0, |best, i| match candidates[i].worth > candidates[best].worth {
                true => i,
                false => best,
            });
        let taken = candidates.swap_remove(best);
        candidates.iter_mut().for_each(|c| c.worth *= novelty(c, &taken));
        views.push(taken.view);
    }
    views
}

fn drawn_view(stand: Vec3, config: &AgentConfig, rng: &mut Rng) -> View {
    let yaw = rng.random_range(0.0..std::f32::consts::TAU);
    let [low, high] = config.down_deg;
    let down = rng.random_range(low..=high.max(low)).to_radians();
    let ahead = Vec3::new(yaw.sin() * down.cos(), -down.sin(), yaw.cos() * down.cos());
    let eye = stand + Vec3::Y * config.height_m;
    View::look_at(eye, eye + ahead, config.intrinsics)
}

fn judged(sensor: &Sensor<'_>, view: View) -> Candidate {
    let glance = sensor.thumbnail(&view, GLANCE);
    let middle = (glance.view.intrinsics.height / 2 * GLANCE + GLANCE / 2) as usize;
    let looks_at = view.eye() + view.forward() * glance.depth_m[middle].clamp(0.5, super::MAX_DEPTH_M);
    Candidate { worth: worth(&glance), looks_at, view }
}

/// Mean over the picture of what each pixel tells: furniture most, floor half, walls little.
fn worth(glance: &Capture) -> f32 {
    let pixel = |(depth_m, label): (&f32, &u8)| match category_of(*label) {
        _ if !(TOO_NEAR_M..super::MAX_DEPTH_M).contains(depth_m) => 0.0,
        Some(Category::Floor) => 0.5,
        Some(category) if !category.is_structure() => 1.0,
        _ => 0.1,
    };
    let total: f32 = glance.depth_m.iter().zip(&glance.labels).map(pixel).sum();
    total / glance.labels.len().max(1) as f32
}

/// 0 for the same view again to 1 for an unlike one.
fn novelty(candidate: &Candidate, taken: &Candidate) -> f32 {
    let eyes = candidate.view.eye().distance_squared(taken.view.eye());
    let looks = candidate.looks_at.distance_squared(taken.looks_at);
    1.0 - 0.98 * (-(eyes + looks) / (OTHER_M * OTHER_M)).exp()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::sensor::tests_room::furnished;
    use glam::Vec2;

    #[test]
    fn the_agent_stands_on_free_floor_and_looks_down_at_different_things() {
        let (room, geometry) = furnished();
        let sensor = Sensor::new(&room, geometry);
        let views = agent_views(&sensor, 8, &AgentConfig::default(), Seed::root(4));
        assert_eq!(views.len(), 8);
        for view in &views {
            let eye = view.eye();
            assert!((eye.y - 1.8).abs() < 0.1, "{eye}");
            assert!(geometry.floor.is_walkable(Vec2::new(eye.x, eye.z)));
            let down = (-view.forward().y).asin().to_degrees();
            assert!((15.0..=35.1).contains(&down), "{down}");
            assert!(worth(&sensor.thumbnail(view, 32)) > 0.2, "no view of a bare wall");
        }
        let alike =
            |a: &View, b: &View| a.eye().distance(b.eye()) < 0.3 && a.forward().dot(b.forward()) > 0.95;
        let twins =
            (0..8).flat_map(|i| (0..i).map(move |j| (i, j))).filter(|&(i, j)| alike(&views[i], &views[j]));
        assert_eq!(twins.count(), 0);
    }

    #[test]
    fn the_same_seed_gives_the_same_views_on_one_thread_and_on_two() {
        let (room, geometry) = furnished();
        let sensor = Sensor::new(&room, geometry);
        let on = |threads: usize, seed: u64| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            pool.install(|| agent_views(&sensor, 3, &AgentConfig::default(), Seed::root(seed)))
        };
        assert_eq!(on(1, 1), on(2, 1));
        assert_ne!(on(2, 1), on(2, 2));
    }
}
