use glam::{Mat4, Vec3, Vec4};

use crate::math::Aabb;
use crate::render::draw::{Look, Quality};
use crate::render::light::LightRig;
use crate::scene::Camera;

/// How far from its centre the ground grid reaches, in metres, at least.
const GRID_RADIUS_M: f32 = 30.0;

/// The grid lies this far under the floor, so that a floor at its height hides it.
const GRID_SINK_M: f32 = 0.004;

/// What every pass of one picture shares; `shaders/frame.wgsl` mirrors it.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Frame {
    clip_from_world: Mat4,
    world_from_clip: Mat4,
    shadow_from_world: Mat4,
    eye: Vec4,
    backward: Vec4,
    to_key: Vec4,
    key: Vec4,
    sky: Vec4,
    ground: Vec4,
    viewport: Vec4,
    cut: Vec4,
    grid: Vec4,
}

impl Frame {
    /// The shared values of a picture of `size` pixels; `shadow` comes from [`ShadowFit::around`].
    pub fn new(camera: &Camera, size: [u32; 2], bounds: &Aabb, look: &Look, shadow: &ShadowFit) -> Self {
        let [width, height] = size.map(|s| s as f32);
        let clip_from_world = camera.clip_from_world(width / height);
        let rig = LightRig::default();
        let taps = match look.quality {
            Quality::Low => 2.0,
            Quality::High => 6.0,
        };
        let eye = Look::cut_eye(camera);
        let cut = f32::from(u8::from(look.cuts(camera, bounds)));
        let middle = if bounds.is_empty() { Vec3::ZERO } else { bounds.center() };
        let reach = if bounds.is_empty() { 0.0 } else { bounds.size().length() * 2.0 };
        let grid_y = if bounds.is_empty() { 0.0 } else { bounds.min.y.min(0.0) };
        Self {
            clip_from_world,
            world_from_clip: clip_from_world.inverse(),
            shadow_from_world: shadow.shadow_from_world,
            eye: eye.extend(0.0),
            backward: (-camera.forward()).extend(f32::from(u8::from(camera.ortho_height_m.is_some()))),
            to_key: rig.to_key.extend(shadow.texel_m),
            key: rig.key.extend(taps),
            sky: rig.sky.extend(rig.camera),
            ground: rig.ground.extend(rig.rim),
            viewport: Vec4::new(width, height, 1.0 / width, 1.0 / height),
            cut: eye.extend(cut),
            grid: Vec4::new(grid_y - GRID_SINK_M, reach.max(GRID_RADIUS_M), middle.x, middle.z),
        }
    }
}

/// The parallel view from the key light that holds everything.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowFit {
    shadow_from_world: Mat4,
    texel_m: f32,
}

impl ShadowFit {
    /// The view around `bounds` on a square map of `side` texels.
    pub fn around(bounds: &Aabb, side: u32) -> Self {
        let bounds = if bounds.is_empty() { Aabb { min: -Vec3::ONE, max: Vec3::ONE } } else { *bounds };
        let to_key = LightRig::default().to_key;
        let view = glam::camera::rh::view::look_to_mat4(bounds.center(), -to_key, Vec3::Z);
        let seen = Aabb::of(corners(&bounds).map(|c| view.transform_point3(c))).grown(0.1);
        let half = seen.max.x.max(-seen.min.x).max(seen.max.y).max(-seen.min.y);
        let projection =
            glam::camera::rh::proj::directx::orthographic(-half, half, -half, half, -seen.max.z, -seen.min.z);
        Self { shadow_from_world: projection * view, texel_m: 2.0 * half / side as f32 }
    }
}

fn corners(b: &Aabb) -> [Vec3; 8] {
    std::array::from_fn(|i| {
        let pick = |bit: usize, axis: usize| if i >> bit & 1 == 0 { b.min[axis] } else { b.max[axis] };
        Vec3::new(pick(0, 0), pick(1, 1), pick(2, 2))
    })
}
