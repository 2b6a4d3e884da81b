//! PROX-E's virtual cameras: many views of one body in its room, for training (PSI §4.1.1).

use glam::Vec3;
use rand::seq::SliceRandom as _;
use rand_distr::{Distribution as _, StandardNormal};

use super::MAX_DEPTH_M;
use super::capture::enclosing_box;
use super::view::{Intrinsics, View};
use crate::job::{Rng, Seed};
use crate::scene::RoomGeometry;

/// A camera keeps this far from every surface, in metres.
const CLEAR_M: f32 = 0.15;
/// Draws of the noise before a grid node is given up.
const NOISE_DRAWS: u32 = 6;
/// A point counts as seen when the first surface on its ray is at most this far before it, in metres: joints of
/// a sitting body lie about that deep in soft seats.
const COVER_M: f32 = 0.05;

/// Settings of [`virtual_cameras`]. The defaults are PROX-E's where these are known (algorithms 1.1); there the
/// noise was one number added to all three coordinates and the camera no longer looked at the body, here it is a
/// vector and the aim is taken anew.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VirtualCameraConfig {
    /// Lens and picture.
    pub intrinsics: Intrinsics,
    /// Nodes along x and z over the room less its margin; the outermost are not used.
    pub grid: [usize; 2],
    /// Levels between half the room's height and the ceiling.
    pub levels: usize,
    /// Distance of the grid from the box around the room, in metres.
    pub margin_m: f32,
    /// Least distance to the pelvis in metres.
    pub near_m: f32,
    /// Largest distance to the pelvis in metres; depth is cut at [`MAX_DEPTH_M`], so no more than that is used.
    pub far_m: f32,
    /// Standard deviation of each coordinate of the noise on the camera's position, in metres.
    pub noise_m: f32,
    /// How many views at most.
    pub most: usize,
    /// Share of the body's joints that must be seen.
    pub least_visible: f32,
}

impl Default for VirtualCameraConfig {
    fn default() -> Self {
        Self {
            intrinsics: Intrinsics::PROX_E,
            grid: [10, 10],
            levels: 3,
            margin_m: 0.7,
            near_m: 1.65,
            far_m: 6.5,
            noise_m: 0.1,
            most: 30,
            least_visible: 0.5,
        }
    }
}

/// Views of a body whose `joints` (world frame, metres) begin with the pelvis: grid nodes of the room's upper half
/// in a random order, each moved by noise, in free space, at the right distance, aimed at the pelvis, and
/// seeing enough of the body. Fewer than asked for where the room has no more, none without joints.
pub fn virtual_cameras(
    geometry: &RoomGeometry,
    joints: &[Vec3],
    config: &VirtualCameraConfig,
    seed: Seed,
) -> Vec<View> {
    let Some(pelvis) = joints.first().copied() else { return Vec::new() };
    let mut nodes = grid_nodes(geometry, config);
    let mut rng = seed.child("virtual cameras", 0).rng();
    nodes.shuffle(&mut rng);
    let stands = |node: Vec3, rng: &mut Rng| {
        let eye = (0..NOISE_DRAWS).map(|_| node + noise(rng) * config.noise_m);
        eye.into_iter().find(|eye| is_allowed(geometry, *eye, pelvis, config))
    };
    let views = nodes.into_iter().filter_map(|node| {
        let view = View::look_at(stands(node, &mut rng)?, pelvis, config.intrinsics);
        (visible_share(geometry, &view, joints) >= config.least_visible).then_some(view)
    });
    views.take(config.most).collect()
}

/// Share of `points` (world frame) that lie in the picture and have nothing of the room before them.
pub fn visible_share(geometry: &RoomGeometry, view: &View, points: &[Vec3]) -> f32 {
    let eye = view.eye();
    let sees = |p: &&Vec3| {
        let (to, distance_m) = ((**p - eye).normalize_or(view.forward()), p.distance(eye));
        view.project(**p).is_some_and(|(pixel, _)| view.holds(pixel))
            && !geometry.bvh.any_hit(eye, to, distance_m - COVER_M)
    };
    points.iter().filter(sees).count() as f32 / points.len().max(1) as f32
}

fn grid_nodes(geometry: &RoomGeometry, config: &VirtualCameraConfig) -> Vec<Vec3> {
    let around = enclosing_box(&geometry.bounds);
    let inset = around.grown(-config.margin_m);
    let along = |axis: usize, nodes: usize, node: usize| {
        let (low, high) = (inset.min[axis], inset.max[axis]);
        low + (high - low) * node as f32 / (nodes.max(2) - 1) as f32
    };
    let inner = |nodes: usize| 1..nodes.max(2) - 1;
    let height = |level: usize| {
        let share = 0.5 + 0.5 * (level + 1) as f32 / (config.levels + 1) as f32;
        around.min.y + around.size().y * share
    };
    let [nx, nz] = config.grid;
    let columns = inner(nx).flat_map(|i| inner(nz).map(move |j| (i, j)));
    let node = |(i, j)| (0..config.levels).map(move |k| (i, j, k));
    columns.flat_map(node).map(|(i, j, k)| Vec3::new(along(0, nx, i), height(k), along(2, nz, j))).collect()
}

/// Inside the walls, above half the room's height and below its ceiling, at the right distance, in free space.
fn is_allowed(geometry: &RoomGeometry, eye: Vec3, pelvis: Vec3, config: &VirtualCameraConfig) -> bool {
    let around = enclosing_box(&geometry.bounds);
    let distance_m = eye.distance(pelvis);
    around.contains(eye)
        && eye.y > around.center().y
        && (config.near_m..config.far_m.min(MAX_DEPTH_M)).contains(&distance_m)
        && is_free(geometry, eye)
}

/// Whether a camera fits there: nothing near, and not outside. Above the field's grid (open scans) only
/// what rays meet counts.
pub(super) fn is_free(geometry: &RoomGeometry, eye: Vec3) -> bool {
    match geometry.field.contains(eye) {
        true => geometry.field.sample(eye) > CLEAR_M,
        false => geometry.bvh.closest(eye, CLEAR_M).is_none(),
    }
}

fn noise(rng: &mut Rng) -> Vec3 {
    let mut normal = || StandardNormal.sample(rng);
    Vec3::new(normal(), normal(), normal())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::{Body, Workspace};
    use crate::generate::sensor::tests_room::furnished;
    use crate::scene::BodyParams;

    fn joints(pelvis: Vec3) -> Vec<Vec3> {
        let (mut params, mut workspace) = (BodyParams::default(), Workspace::default());
        params.translation = pelvis - Body::bundled().model.rest_joints(&params.betas)[0];
        Body::bundled().forward_joints(&params, &mut workspace);
        workspace.joints()[..22].to_vec()
    }

    #[test]
    fn virtual_cameras_look_at_the_body_from_the_rooms_upper_half() {
        let (_, geometry) = furnished();
        let (joints, config) = (joints(Vec3::new(-1.2, 0.95, -1.0)), VirtualCameraConfig::default());
        let views = virtual_cameras(geometry, &joints, &config, Seed::root(1));
        assert_eq!(views.len(), config.most);
        for view in &views {
            let (pixel, depth_m) = view.project(joints[0]).expect("in front");
            assert!(
                pixel.distance(config.intrinsics.center_px()) < 0.5,
                "the aim follows the noise: {pixel}"
            );
            assert!((1.65..6.0).contains(&depth_m), "{depth_m}");
            assert!(view.eye().y > 1.35 && view.eye().y < 2.7, "{}", view.eye());
            assert!(geometry.field.sample(view.eye()) > CLEAR_M);
            assert!(visible_share(geometry, view, &joints) >= 0.5);
        }
        assert_eq!(views, virtual_cameras(geometry, &joints, &config, Seed::root(1)));
        assert_ne!(views, virtual_cameras(geometry, &joints, &config, Seed::root(2)));
    }

    #[test]
    fn the_noise_is_independent_in_all_three_directions() {
        let mut rng = Seed::root(5).rng();
        let draws: Vec<Vec3> = (0..4000).map(|_| noise(&mut rng)).collect();
        let mean_of = |f: &dyn Fn(&Vec3) -> f32| draws.iter().map(f).sum::<f32>() / draws.len() as f32;
        assert!(mean_of(&|d| d.x * d.y).abs() < 0.06 && mean_of(&|d| d.y * d.z).abs() < 0.06);
        assert!((mean_of(&|d| d.x * d.x) - 1.0).abs() < 0.1);
    }

    #[test]
    fn nobody_is_looked_at_through_furniture() {
        let (_, geometry) = furnished();
        // Behind the wardrobe's side, seen from across the room: the wardrobe hides the body.
        let hidden = [Vec3::new(2.6, 1.0, -2.4)];
        let view = View::look_at(Vec3::new(2.6, 1.9, 2.0), hidden[0], Intrinsics::PROX_E);
        assert_eq!(visible_share(geometry, &view, &hidden), 0.0);
        let open = [Vec3::new(0.0, 1.0, -1.0)];
        assert_eq!(visible_share(geometry, &View::look_at(view.eye(), open[0], view.intrinsics), &open), 1.0);
        assert_eq!(visible_share(geometry, &view, &[view.eye() - view.forward()]), 0.0, "behind the camera");
    }
}
