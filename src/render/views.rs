//! Cameras that show something well without anybody steering: for framing a selection and for the
//! pictures of reports.

use glam::Vec3;

use crate::math::Aabb;
use crate::scene::{Camera, Room, TriangleBvh};

/// Air around what is framed, as a share of its size.
const MARGIN: f32 = 1.08;

/// Field of view of report pictures: that of a 35 mm lens, natural for people in rooms.
const FOV_Y: f32 = 0.66;

/// Points of a body that have to be seen.
const SAMPLES: usize = 64;

/// A body's own depth: what is nearer than this to a point of it does not hide it.
const OWN_DEPTH_M: f32 = 0.04;

/// A camera stands at least this far from walls and furniture.
const ROOM_FOR_CAMERA_M: f32 = 0.12;

/// Views of one person differ by at least this angle, a little less than a right one (radians).
const MIN_TURN: f32 = 1.3;

/// The nearest camera that sees all of `bounds` from the side `direction` points to (from the middle to
/// the eye; need not be a unit vector), in a picture `aspect` times as wide as high.
pub fn frame_bounds(bounds: &Aabb, direction: Vec3, fov_y: f32, aspect: f32) -> Camera {
    let bounds = if bounds.is_empty() { Aabb { min: -Vec3::ONE, max: Vec3::ONE } } else { *bounds };
    let middle = bounds.center();
    let backward = direction.normalize_or(Vec3::new(0.6, 0.4, 0.7).normalize_or(Vec3::Z));
    let unit = Camera { eye: middle + backward, target: middle, fov_y, ortho_height_m: None };
    let (right, up) = unit.right_up();
    let half_y = (fov_y * 0.5).tan();
    let half_x = half_y * aspect;
    let away = |corner: Vec3| {
        let offset = (corner - middle) * MARGIN;
        offset.dot(backward) + (offset.dot(right).abs() / half_x).max(offset.dot(up).abs() / half_y)
    };
    let distance_m = corners(&bounds).map(away).into_iter().fold(0.1, f32::max);
    Camera { eye: middle + backward * distance_m, ..unit }
}

fn corners(b: &Aabb) -> [Vec3; 8] {
    std::array::from_fn(|i| {
        let pick = |axis: usize| if i >> axis & 1 == 0 { b.min[axis] } else { b.max[axis] };
        Vec3::new(pick(0), pick(1), pick(2))
    })
}

/// Two overviews from opposite corners, to be drawn with [`super::Cutaway::Outside`].
pub fn room_views(room: &Room, aspect: f32) -> [Camera; 2] {
    let bounds = room.bounds();
    [Vec3::new(0.66, 0.62, 0.75), Vec3::new(-0.66, 0.62, -0.75)]
        .map(|direction| frame_bounds(&bounds, direction, FOV_Y, aspect))
}

/// A place to look from and how much of the person it shows.
struct Candidate {
    camera: Camera,
    azimuth: f32,
    /// Share of the body that nothing hides, less a little for steep and close views.
    score: f32,
}

/// Up to `count` views of one person, from sides that lie about a right angle or more apart, the clearest
/// first. `vertices` are the body's, `room` the tree over the room without people: views that furniture
/// or walls hide lose to those that they leave free. At least one view comes back.
pub fn person_views(vertices: &[Vec3], room: &TriangleBvh, count: usize, aspect: f32) -> Vec<Camera> {
    let bounds = Aabb::of(vertices.iter().copied()).grown(0.15);
    let step = (vertices.len() / SAMPLES).max(1);
    let points: Vec<Vec3> = vertices.iter().copied().step_by(step).collect();
    let mut candidates: Vec<Candidate> = directions()
        .flat_map(|(azimuth, elevation)| [0.66f32, 0.9].map(|fov_y| (azimuth, elevation, fov_y)))
        .map(|(azimuth, elevation, fov_y)| {
            let (flat, up) = (elevation.cos(), elevation.sin());
            let direction = Vec3::new(azimuth.sin() * flat, up, azimuth.cos() * flat);
            let camera = frame_bounds(&bounds, direction, fov_y, aspect);
            let strain = 0.10 * elevation + 0.10 * (fov_y - FOV_Y);
            Candidate { score: visible_share(&camera, &points, room) - strain, camera, azimuth }
        })
        .collect();
    candidates.sort_by(|a, b| b.score.total_cmp(&a.score));
    let mut chosen: Vec<Candidate> = Vec::new();
    for candidate in candidates {
        let apart = |other: &Candidate| turn(candidate.azimuth, other.azimuth) >= MIN_TURN;
        if chosen.len() < count.max(1) && chosen.iter().all(apart) {
            chosen.push(candidate);
        }
    }
    chosen.into_iter().map(|c| c.camera).collect()
}

/// Azimuth and elevation of every candidate, in radians.
fn directions() -> impl Iterator<Item = (f32, f32)> {
    let azimuths = (0..24).map(|i| i as f32 / 24.0 * std::f32::consts::TAU);
    azimuths.flat_map(|azimuth| [0.15, 0.45, 0.8].map(|elevation| (azimuth, elevation)))
}

/// Angle between two azimuths, 0 to pi.
fn turn(a: f32, b: f32) -> f32 {
    let d = (a - b).rem_euclid(std::f32::consts::TAU);
    d.min(std::f32::consts::TAU - d)
}

/// Share of `points` that the camera sees past the room; 0 where no camera could stand.
fn visible_share(camera: &Camera, points: &[Vec3], room: &TriangleBvh) -> f32 {
    if room.closest(camera.eye, ROOM_FOR_CAMERA_M).is_some() {
        return 0.0;
    }
    let seen = points.iter().filter(|point| {
        let way = camera.eye - **point;
        let distance_m = way.length() - OWN_DEPTH_M;
        let direction = way.normalize_or(Vec3::Y);
        distance_m <= 0.0 || !room.any_hit(**point + direction * OWN_DEPTH_M, direction, distance_m)
    });
    seen.count() as f32 / points.len().max(1) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wall(x: f32) -> Vec<[Vec3; 3]> {
        let p = |y: f32, z: f32| Vec3::new(x, y, z);
        vec![[p(0.0, -5.0), p(0.0, 5.0), p(3.0, 5.0)], [p(0.0, -5.0), p(3.0, 5.0), p(3.0, -5.0)]]
    }

    fn person() -> Vec<Vec3> {
        let at =
            |i: usize| Vec3::new((i % 5) as f32 * 0.1 - 0.2, i as f32 * 0.017, (i % 3) as f32 * 0.1 - 0.1);
        (0..100).map(at).collect()
    }

    #[test]
    fn a_framed_box_fills_the_picture_and_stays_inside_it() {
        let bounds = Aabb { min: Vec3::new(-1.0, 0.0, -2.0), max: Vec3::new(3.0, 1.0, 0.5) };
        for direction in [Vec3::new(1.0, 0.5, 0.2), Vec3::Z, Vec3::new(-0.3, 2.0, 0.4)] {
            let camera = frame_bounds(&bounds, direction, 0.8, 1.5);
            let clip = camera.clip_from_world(1.5);
            let seen = corners(&bounds).map(|c| clip.project_point3(c));
            let reach = seen.iter().fold(0.0f32, |r, p| r.max(p.x.abs()).max(p.y.abs()));
            assert!(
                reach <= 1.0 && reach > 0.8,
                "corners reach {reach} of the picture's half from {direction}"
            );
        }
    }

    #[test]
    fn a_person_beside_a_wall_is_shown_from_two_sides_and_never_from_behind_the_wall() {
        let views = person_views(&person(), &TriangleBvh::new(wall(0.5)), 3, 1.33);
        assert!(views.len() >= 2);
        for view in &views {
            assert!(view.eye.x < 0.5, "the wall hides the person from {}", view.eye);
        }
        let sides: Vec<Vec3> =
            views.iter().map(|v| (v.eye - v.target).with_y(0.0).normalize_or(Vec3::X)).collect();
        assert!(sides[0].dot(sides[1]) < 0.35, "the first two views look from the same side");
    }
}
