//! How the mouse and keys move the camera. Pure numbers: no window, so every move can be tested.

use glam::Vec3;

use crate::math::Aabb;
use crate::scene::Camera;

/// Radians per point of mouse travel: half a turn over 600 points, as Blender's turntable.
const TURN_PER_POINT: f32 = std::f32::consts::PI / 600.0;
/// Never quite straight down, so that "right" stays defined.
const MAX_PITCH: f32 = 89.9 * std::f32::consts::PI / 180.0;
/// Nearest and farthest the eye may be from the point it orbits, in metres.
const DISTANCE_M: (f32, f32) = (0.08, 150.0);
/// Share of the distance that one notch of the wheel keeps.
const NOTCH: f32 = 0.88;
/// Room left around what is framed.
const FRAME_MARGIN: f32 = 1.06;
/// Half the size in metres that the smallest thing is framed as.
const MIN_HALF_M: f32 = 0.12;
/// A glide covers all but a thousandth of its way in about a fifth of a second.
const GLIDE_PER_SECOND: f32 = 30.0;

/// A turntable camera: looks at `target` from a distance, Y always up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    /// The point it looks at and turns about, metres, world frame.
    pub target: Vec3,
    /// Turn about Y in radians; 0 looks along -Z.
    pub yaw: f32,
    /// Height angle in radians; positive looks down.
    pub pitch: f32,
    /// From the eye to the target in metres.
    pub distance_m: f32,
    /// Vertical field of view in radians.
    pub fov_y: f32,
    /// Parallel projection, as high as the perspective one at the target.
    pub ortho: bool,
    /// Metres per second while flying.
    pub fly_speed_m_s: f32,
    goal: Option<Goal>,
}

/// Where a glide ends.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Goal {
    target: Vec3,
    yaw: f32,
    pitch: f32,
    distance_m: f32,
}

/// A view along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxisView {
    /// From +Z, looking along -Z.
    Front,
    /// From -Z.
    Back,
    /// From +X.
    Right,
    /// From -X.
    Left,
    /// From above.
    Top,
    /// From below.
    Bottom,
}

impl Default for Orbit {
    fn default() -> Self {
        Self {
            target: Vec3::new(0.0, 0.9, 0.0),
            yaw: 0.7,
            pitch: 0.5,
            distance_m: 7.0,
            fov_y: 45f32.to_radians(),
            ortho: false,
            fly_speed_m_s: 2.0,
            goal: None,
        }
    }
}

impl Orbit {
    /// Unit vector from the target to the eye.
    fn backward(&self) -> Vec3 {
        let (sin_yaw, cos_yaw) = self.yaw.sin_cos();
        let (sin_pitch, cos_pitch) = self.pitch.sin_cos();
        Vec3::new(sin_yaw * cos_pitch, sin_pitch, cos_yaw * cos_pitch)
    }

    /// The camera it stands for.
    pub fn camera(&self) -> Camera {
        let height = 2.0 * self.distance_m * (self.fov_y * 0.5).tan();
        Camera {
            eye: self.target + self.backward() * self.distance_m,
            target: self.target,
            fov_y: self.fov_y,
            ortho_height_m: self.ortho.then_some(height),
        }
    }

    /// Turns about the target by mouse travel in points.
    pub fn turn(&mut self, right_points: f32, down_points: f32) {
        self.goal = None;
        self.yaw -= right_points * TURN_PER_POINT;
        self.pitch = (self.pitch + down_points * TURN_PER_POINT).clamp(-MAX_PITCH, MAX_PITCH);
    }

    /// Turns about the eye instead: looking around while flying.
    pub fn look(&mut self, right_points: f32, down_points: f32) {
        let eye = self.camera().eye;
        self.turn(right_points, down_points);
        self.target = eye - self.backward() * self.distance_m;
    }

    /// Moves eye and target in the picture's plane so that what lies at the target follows the mouse.
    pub fn pan(&mut self, right_points: f32, down_points: f32, view_height_points: f32) {
        self.goal = None;
        let metres_per_point = 2.0 * self.distance_m * (self.fov_y * 0.5).tan() / view_height_points.max(1.0);
        let (right, up) = self.camera().right_up();
        self.target += (up * down_points - right * right_points) * metres_per_point;
    }

    /// Goes nearer (positive notches) to the target.
    pub fn dolly(&mut self, notches: f32) {
        self.goal = None;
        self.distance_m = (self.distance_m * NOTCH.powf(notches)).clamp(DISTANCE_M.0, DISTANCE_M.1);
    }

    /// Goes nearer to `point`, which stays where it is in the picture.
    pub fn zoom_to(&mut self, point: Vec3, notches: f32) {
        self.goal = None;
        let wanted = self.distance_m * NOTCH.powf(notches);
        let distance_m = wanted.clamp(DISTANCE_M.0, DISTANCE_M.1);
        let factor = distance_m / self.distance_m;
        self.target = point + (self.target - point) * factor;
        self.distance_m = distance_m;
    }

    /// Flies for `seconds` along the axes right, up and forward (each -1 to 1).
    pub fn fly(&mut self, right_up_forward: Vec3, pace: f32, seconds: f32) {
        self.goal = None;
        let camera = self.camera();
        let (right, _) = camera.right_up();
        let way =
            right * right_up_forward.x + Vec3::Y * right_up_forward.y + camera.forward() * right_up_forward.z;
        self.target += way.clamp_length_max(1.0) * self.fly_speed_m_s * pace * seconds;
    }

    /// Glides until `bounds` fills a picture `aspect` times as wide as high. An empty box changes nothing.
    pub fn frame(&mut self, bounds: &Aabb, aspect: f32) {
        if bounds.is_empty() {
            return;
        }
        let (right, up) = self.camera().right_up();
        let (half_x, half_y) = ((self.fov_y * 0.5).tan() * aspect.max(0.1), (self.fov_y * 0.5).tan());
        let half_size = (bounds.size() * 0.5).max(Vec3::splat(MIN_HALF_M));
        // A corner is in the picture when the eye is at least so far from the middle.
        let needed_m = |corner: Vec3| {
            let nearer_m = corner.dot(self.backward());
            (corner.dot(right).abs() / half_x).max(corner.dot(up).abs() / half_y) + nearer_m
        };
        let signs = [-1.0, 1.0];
        let corners = signs.iter().flat_map(|x| signs.iter().map(move |y| (*x, *y)));
        let corners = corners.flat_map(|(x, y)| signs.iter().map(move |z| half_size * Vec3::new(x, y, *z)));
        let distance_m = corners.map(needed_m).fold(0.0, f32::max) * FRAME_MARGIN;
        let distance_m = distance_m.clamp(DISTANCE_M.0, DISTANCE_M.1);
        self.goal = Some(Goal { target: bounds.center(), yaw: self.yaw, pitch: self.pitch, distance_m });
    }

    /// Glides to `point` as the new target, keeping distance and direction within reason.
    pub fn center_on(&mut self, point: Vec3) {
        let distance_m = self.distance_m.min(4.0);
        self.goal = Some(Goal { target: point, yaw: self.yaw, pitch: self.pitch, distance_m });
    }

    /// Glides to a view along an axis.
    pub fn view(&mut self, view: AxisView) {
        use std::f32::consts::{FRAC_PI_2, PI};
        let (yaw, pitch) = match view {
            AxisView::Front => (0.0, 0.0),
            AxisView::Back => (PI, 0.0),
            AxisView::Right => (FRAC_PI_2, 0.0),
            AxisView::Left => (-FRAC_PI_2, 0.0),
            AxisView::Top => (0.0, MAX_PITCH),
            AxisView::Bottom => (0.0, -MAX_PITCH),
        };
        let yaw = self.yaw + shortest_turn(yaw - self.yaw);
        self.goal = Some(Goal { target: self.target, yaw, pitch, distance_m: self.distance_m });
    }

    /// Goes on with a glide; whether another frame is needed.
    pub fn advance(&mut self, seconds: f32) -> bool {
        let Some(goal) = self.goal else { return false };
        let share = 1.0 - (-GLIDE_PER_SECOND * seconds.clamp(0.0, 0.1)).exp();
        self.target = self.target.lerp(goal.target, share);
        self.yaw += (goal.yaw - self.yaw) * share;
        self.pitch += (goal.pitch - self.pitch) * share;
        self.distance_m += (goal.distance_m - self.distance_m) * share;
        let left = self.target.distance(goal.target)
            + (goal.yaw - self.yaw).abs()
            + (goal.pitch - self.pitch).abs()
            + (goal.distance_m - self.distance_m).abs();
        if left < 2e-3 {
            self.arrive();
        }
        self.goal.is_some()
    }

    /// Ends a glide at once.
    pub fn arrive(&mut self) {
        if let Some(goal) = self.goal.take() {
            self.target = goal.target;
            self.yaw = goal.yaw;
            self.pitch = goal.pitch;
            self.distance_m = goal.distance_m;
        }
    }
}

/// The same turn, at most half a circle.
fn shortest_turn(angle: f32) -> f32 {
    use std::f32::consts::{PI, TAU};
    (angle + PI).rem_euclid(TAU) - PI
}

#[cfg(test)]
mod tests {
    use super::*;

    fn on_screen(orbit: &Orbit, point: Vec3) -> Vec3 {
        orbit.camera().clip_from_world(1.5).project_point3(point)
    }

    #[test]
    fn zooming_keeps_what_is_under_the_cursor_under_the_cursor() {
        for ortho in [false, true] {
            let mut orbit = Orbit { ortho, ..Orbit::default() };
            let point = Vec3::new(1.0, 0.3, -0.5);
            let before = on_screen(&orbit, point);
            orbit.zoom_to(point, 4.0);
            let after = on_screen(&orbit, point);
            assert!(before.truncate().distance(after.truncate()) < 1e-4, "{before} {after}");
            assert!(orbit.distance_m < Orbit::default().distance_m);
        }
    }

    #[test]
    fn panning_moves_the_target_with_the_mouse() {
        let mut orbit = Orbit::default();
        let held = orbit.target;
        orbit.pan(150.0, 50.0, 600.0);
        let now = on_screen(&orbit, held);
        assert!((now.x - 150.0 / 450.0).abs() < 1e-3, "{now}");
        assert!((now.y + 50.0 / 300.0).abs() < 1e-3, "{now}");
    }

    #[test]
    fn looking_around_leaves_the_eye_where_it_is() {
        let mut orbit = Orbit::default();
        let eye = orbit.camera().eye;
        orbit.look(120.0, -40.0);
        assert!(orbit.camera().eye.distance(eye) < 1e-4);
    }

    #[test]
    fn framing_shows_the_whole_box_in_wide_and_in_narrow_pictures() {
        let bounds = Aabb { min: Vec3::new(-3.0, 0.0, -2.0), max: Vec3::new(3.0, 2.6, 2.0) };
        for aspect in [0.5, 1.0, 2.0] {
            let mut orbit = Orbit::default();
            orbit.frame(&bounds, aspect);
            orbit.arrive();
            for i in 0..8 {
                let pick = |bit: usize, axis: usize| {
                    if i >> bit & 1 == 0 { bounds.min[axis] } else { bounds.max[axis] }
                };
                let corner = Vec3::new(pick(0, 0), pick(1, 1), pick(2, 2));
                let p = orbit.camera().clip_from_world(aspect).project_point3(corner);
                assert!(p.x.abs() <= 1.0 && p.y.abs() <= 1.0, "{corner} is outside at aspect {aspect}");
            }
        }
    }

    #[test]
    fn flying_forward_goes_where_the_camera_looks() {
        let mut orbit = Orbit::default();
        let (eye, forward) = (orbit.camera().eye, orbit.camera().forward());
        orbit.fly(Vec3::Z, 1.0, 0.5);
        assert!(orbit.camera().eye.distance(eye + forward) < 1e-4, "2 m/s for half a second is 1 m");
    }

    #[test]
    fn a_glide_ends_exactly_at_its_goal_and_takes_the_short_way_round() {
        let mut orbit = Orbit { yaw: 3.0, ..Orbit::default() };
        orbit.view(AxisView::Left);
        let mut frames = 0;
        while orbit.advance(1.0 / 60.0) {
            frames += 1;
            assert!(orbit.yaw >= 2.9, "went the long way round");
        }
        assert!(frames > 3 && frames < 60, "{frames}");
        assert!(orbit.camera().forward().distance(Vec3::X) < 1e-4);
    }

    #[test]
    fn the_top_view_looks_down_with_minus_z_up() {
        let mut orbit = Orbit::default();
        orbit.view(AxisView::Top);
        orbit.arrive();
        let (right, up) = orbit.camera().right_up();
        assert!(right.distance(Vec3::X) < 0.01 && up.distance(Vec3::NEG_Z) < 0.01);
    }
}
