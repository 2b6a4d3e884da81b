use glam::{Mat4, Vec3};
use serde::{Deserialize, Serialize};

/// A perspective camera that looks from `eye` at `target`, Y up.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Camera {
    /// Position in metres, world frame.
    pub eye: Vec3,
    /// The point it looks at and orbits about.
    pub target: Vec3,
    /// Vertical field of view in radians.
    pub fov_y: f32,
    /// When set, an orthographic view this many metres high.
    pub ortho_height_m: Option<f32>,
}

impl Default for Camera {
    fn default() -> Self {
        Self {
            eye: Vec3::new(4.0, 3.0, 5.0),
            target: Vec3::Y,
            fov_y: 45f32.to_radians(),
            ortho_height_m: None,
        }
    }
}

impl Camera {
    /// Unit vector of the view direction; -Z when eye and target coincide.
    pub fn forward(&self) -> Vec3 {
        (self.target - self.eye).normalize_or(Vec3::NEG_Z)
    }

    /// Unit vectors right and up of the picture.
    pub fn right_up(&self) -> (Vec3, Vec3) {
        let forward = self.forward();
        let right = forward.cross(Vec3::Y).normalize_or(Vec3::X);
        (right, right.cross(forward))
    }

    /// World to view: x right, y up, looking along -z.
    pub fn view_from_world(&self) -> Mat4 {
        let (_, up) = self.right_up();
        glam::camera::rh::view::look_to_mat4(self.eye, self.forward(), up)
    }

    /// World to clip space with depth 0 to 1 (wgpu), for a picture `aspect` times as wide as high.
    pub fn clip_from_world(&self, aspect: f32) -> Mat4 {
        let (near, far) = (0.02, 200.0);
        let projection = match self.ortho_height_m {
            None => glam::camera::rh::proj::directx::perspective(self.fov_y, aspect, near, far),
            Some(height) => {
                let (h, w) = (height * 0.5, height * 0.5 * aspect);
                glam::camera::rh::proj::directx::orthographic(-w, w, -h, h, -far, far)
            }
        };
        projection * self.view_from_world()
    }

    /// Ray through the picture at `(x, y)`, each 0 to 1 from the top left: origin and unit direction.
    pub fn ray(&self, x: f32, y: f32, aspect: f32) -> (Vec3, Vec3) {
        let (right, up) = self.right_up();
        let (u, v) = ((2.0 * x - 1.0) * aspect, 1.0 - 2.0 * y);
        match self.ortho_height_m {
            None => {
                let half = (self.fov_y * 0.5).tan();
                let direction = self.forward() + right * (u * half) + up * (v * half);
                (self.eye, direction.normalize_or(self.forward()))
            }
            Some(height) => {
                let half = height * 0.5;
                let origin = self.eye + right * (u * half) + up * (v * half) - self.forward() * 100.0;
                (origin, self.forward())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_goes_through_the_pixel_that_its_points_project_to() {
        let camera = Camera { eye: Vec3::new(3.0, 2.0, 1.0), ..Camera::default() };
        for ortho in [None, Some(4.0)] {
            let camera = Camera { ortho_height_m: ortho, ..camera };
            let (origin, direction) = camera.ray(0.3, 0.8, 1.5);
            let distance = if ortho.is_some() { 103.0 } else { 3.0 };
            let ndc = camera.clip_from_world(1.5).project_point3(origin + direction * distance);
            assert!((ndc.x - -0.4).abs() < 1e-3 && (ndc.y - -0.6).abs() < 1e-3, "{ndc}");
        }
    }
}
