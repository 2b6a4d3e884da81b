use glam::{Affine3A, Mat3, Vec2, Vec3};
use serde::{Deserialize, Serialize};

use crate::body::BodyModel;
use crate::scene::{BodyParams, Camera};

/// A pinhole camera without distortion; the principal point is the middle of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Intrinsics {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Focal length in pixels, the same both ways.
    pub focal_px: f32,
}

impl Intrinsics {
    /// PROX-E's virtual cameras: 480 x 270 pixels, the Kinect's focal length of 1060 of 1920 columns (84° wide).
    pub const PROX_E: Self = Self { width: 480, height: 270, focal_px: 265.0 };

    /// From the vertical field of view in radians.
    pub fn from_fov_y(width: u32, height: u32, fov_y: f32) -> Self {
        Self { width, height, focal_px: 0.5 * height as f32 / (0.5 * fov_y).tan() }
    }

    /// Middle of the picture in pixels: half its columns and rows.
    pub fn center_px(&self) -> Vec2 {
        0.5 * Vec2::new(self.width as f32, self.height as f32)
    }
}

/// A camera that stands somewhere: x right, y down, z forward.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct View {
    /// Pose of the camera; rotation and translation only, T_c^w of PSI §3.1.
    pub world_from_camera: Affine3A,
    /// Its lens and picture.
    pub intrinsics: Intrinsics,
}

impl View {
    /// Looks from `eye` at `target`, upright. Straight up or down, +X is on the right.
    pub fn look_at(eye: Vec3, target: Vec3, intrinsics: Intrinsics) -> Self {
        let forward = (target - eye).normalize_or(Vec3::NEG_Z);
        let right = forward.cross(Vec3::Y).normalize_or(Vec3::X);
        let axes = Mat3::from_cols(right, forward.cross(right), forward);
        Self { world_from_camera: Affine3A::from_mat3_translation(axes, eye), intrinsics }
    }

    /// What the editor's camera sees, in a picture of `width` x `height`; an orthographic camera is taken as the
    /// perspective one at its eye.
    pub fn from_camera(camera: &Camera, width: u32, height: u32) -> Self {
        let intrinsics = Intrinsics::from_fov_y(width, height, camera.fov_y);
        Self::look_at(camera.eye, camera.eye + camera.forward(), intrinsics)
    }

    /// The camera for the editor and the renderers that sees the same, looking at the point `target_m` ahead.
    pub fn to_camera(&self, target_m: f32) -> Camera {
        let half = 0.5 * self.intrinsics.height as f32 / self.intrinsics.focal_px;
        let target = self.eye() + self.forward() * target_m;
        Camera { eye: self.eye(), target, fov_y: 2.0 * half.atan(), ortho_height_m: None }
    }

    /// Position in metres, world frame.
    pub fn eye(&self) -> Vec3 {
        self.world_from_camera.translation.into()
    }

    /// Unit vector of the optical axis, world frame.
    pub fn forward(&self) -> Vec3 {
        self.world_from_camera.matrix3.z_axis.into()
    }

    /// The inverse of `world_from_camera`, by transposing its rotation.
    pub fn camera_from_world(&self) -> Affine3A {
        let camera_from_world = self.world_from_camera.matrix3.transpose();
        let translation = camera_from_world * -self.world_from_camera.translation;
        Affine3A { matrix3: camera_from_world, translation }
    }

    /// A world point in the camera's frame, metres.
    pub fn point_in_camera(&self, in_world: Vec3) -> Vec3 {
        self.camera_from_world().transform_point3(in_world)
    }

    /// A camera point in the world frame, metres.
    pub fn point_in_world(&self, in_camera: Vec3) -> Vec3 {
        self.world_from_camera.transform_point3(in_camera)
    }

    /// Pixel (column, row; the top left pixel spans 0 to 1) and depth along the axis of a world point; `None`
    /// behind the camera. May lie outside the picture.
    pub fn project(&self, in_world: Vec3) -> Option<(Vec2, f32)> {
        let p = self.point_in_camera(in_world);
        let pixel = Vec2::new(p.x, p.y) * (self.intrinsics.focal_px / p.z) + self.intrinsics.center_px();
        (p.z > 1e-6).then_some((pixel, p.z))
    }

    /// World point at a pixel (column, row) and depth along the axis in metres.
    pub fn unproject(&self, pixel: Vec2, depth_m: f32) -> Vec3 {
        self.eye() + self.direction(pixel) * depth_m
    }

    /// World direction through a pixel (column, row) whose part along the optical axis is 1, so that multiples
    /// of it are depths.
    pub fn direction(&self, pixel: Vec2) -> Vec3 {
        let flat = (pixel - self.intrinsics.center_px()) / self.intrinsics.focal_px;
        self.world_from_camera.transform_vector3(flat.extend(1.0))
    }

    /// Whether a pixel lies in the picture.
    pub fn holds(&self, pixel: Vec2) -> bool {
        let size = Vec2::new(self.intrinsics.width as f32, self.intrinsics.height as f32);
        pixel.cmpge(Vec2::ZERO).all() && pixel.cmplt(size).all()
    }

    /// The body in this camera's frame (PSI §3.1): its vertices there are those of `in_world` transformed. The
    /// pelvis joint `rest_pelvis(betas) + t` is what moves; `R` turns about it.
    pub fn body_in_camera(&self, in_world: &BodyParams, model: &BodyModel) -> BodyParams {
        moved(&self.camera_from_world(), in_world, model)
    }

    /// The body in the world frame; inverse of [`View::body_in_camera`].
    pub fn body_in_world(&self, in_camera: &BodyParams, model: &BodyModel) -> BodyParams {
        moved(&self.world_from_camera, in_camera, model)
    }
}

fn moved(to_from: &Affine3A, body: &BodyParams, model: &BodyModel) -> BodyParams {
    let pelvis = model.rest_joints(&body.betas)[0];
    let mut out = body.clone();
    out.translation = to_from.transform_point3(pelvis + body.translation) - pelvis;
    out.set_rotation(&(Mat3::from(to_from.matrix3) * body.rotation()));
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Body;

    fn view() -> View {
        View::look_at(Vec3::new(1.5, 1.8, -0.7), Vec3::new(-0.4, 0.6, 1.1), Intrinsics::PROX_E)
    }

    #[test]
    fn the_camera_has_x_right_y_down_z_forward() {
        let view = View::look_at(Vec3::ZERO, Vec3::Z, Intrinsics::PROX_E);
        assert!(view.point_in_camera(Vec3::Z * 2.0).abs_diff_eq(Vec3::Z * 2.0, 1e-6));
        assert!(view.point_in_camera(Vec3::Y).abs_diff_eq(Vec3::NEG_Y, 1e-6), "up is minus y");
        assert!(
            view.point_in_camera(Vec3::NEG_X).abs_diff_eq(Vec3::X, 1e-6),
            "looking along +z, -x is right"
        );
        assert!((view.world_from_camera.matrix3.determinant() - 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_point_survives_projecting_and_unprojecting() {
        let view = view();
        for p in [Vec3::new(0.1, 0.3, 0.9), Vec3::new(-1.0, 2.0, 1.5)] {
            let (pixel, depth_m) = view.project(p).expect("in front");
            assert!(view.unproject(pixel, depth_m).abs_diff_eq(p, 1e-4));
        }
        assert!(view.project(view.eye() - view.forward()).is_none());
        let (middle, _) = view.project(view.eye() + view.forward()).expect("in front");
        assert!(middle.abs_diff_eq(Vec2::new(240.0, 135.0), 1e-2), "{middle}");
    }

    #[test]
    fn the_editors_camera_and_its_view_see_a_point_at_the_same_pixel() {
        let camera = Camera { eye: Vec3::new(3.0, 2.0, 1.0), ..Camera::default() };
        let view = View::from_camera(&camera, 300, 200);
        let p = Vec3::new(0.5, 0.2, -0.3);
        let ndc = camera.clip_from_world(1.5).project_point3(p);
        let expected = Vec2::new((ndc.x + 1.0) * 150.0, (1.0 - ndc.y) * 100.0);
        let (pixel, _) = view.project(p).expect("in front");
        assert!(pixel.abs_diff_eq(expected, 0.05), "{pixel} is {expected}");
        assert!((view.to_camera(2.0).fov_y - camera.fov_y).abs() < 1e-5);
    }

    #[test]
    fn a_body_in_the_camera_frame_is_the_same_body() {
        let (body, view) = (Body::bundled(), view());
        let mut params = BodyParams { translation: Vec3::new(0.3, 0.9, 0.4), ..BodyParams::default() };
        params.betas[0] = 1.5;
        params.set_rotation(&Mat3::from_rotation_y(0.8));
        let in_camera = view.body_in_camera(&params, &body.model);
        let (world, camera) = (body.pose(&params).vertices, body.pose(&in_camera).vertices);
        for (w, c) in world.iter().zip(&camera).step_by(500) {
            assert!(view.point_in_camera(*w).abs_diff_eq(*c, 1e-4));
        }
        let back = view.body_in_world(&in_camera, &body.model);
        for (a, b) in back.to_vector().iter().zip(params.to_vector()) {
            assert!((a - b).abs() < 1e-5);
        }
    }
}
