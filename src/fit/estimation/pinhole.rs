use glam::{Affine3A, Mat3, Vec2, Vec3};

/// Points nearer to the camera than this are taken as this far, so that nothing blows up, metres.
const NEAREST_M: f32 = 0.1;

/// A camera without distortion: x right, y down, z forward.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pinhole {
    /// Rotation and translation from the world to the camera, metres.
    pub camera_from_world: Affine3A,
    /// Focal length in pixels.
    pub focal_px: f32,
    /// Principal point in pixels.
    pub center_px: Vec2,
    /// The picture's longer side in pixels.
    pub longest_px: f32,
}

impl Pinhole {
    /// Pixel of a world point; points beside or behind the camera are taken [`NEAREST_M`] ahead of it.
    pub fn project(&self, in_world: Vec3) -> Vec2 {
        let p = self.camera_from_world.transform_point3(in_world);
        p.truncate() * (self.focal_px / p.z.max(NEAREST_M)) + self.center_px
    }

    /// Depth along the optical axis of a world point, metres.
    pub fn depth_m(&self, in_world: Vec3) -> f32 {
        self.camera_from_world.transform_point3(in_world).z
    }

    /// Gradient with respect to a world point of a function of its pixel, given that of the pixel.
    pub fn pull_back(&self, in_world: Vec3, at_pixel: Vec2) -> Vec3 {
        let p = self.camera_from_world.transform_point3(in_world);
        let z = p.z.max(NEAREST_M);
        let flat = at_pixel * (self.focal_px / z);
        let along = if p.z > NEAREST_M { -flat.dot(p.truncate()) / z } else { 0.0 };
        Mat3::from(self.camera_from_world.matrix3).transpose() * flat.extend(along)
    }

    /// The world point at a pixel and a depth along the optical axis, metres.
    pub fn unproject(&self, pixel: Vec2, depth_m: f32) -> Vec3 {
        let flat = (pixel - self.center_px) * (depth_m / self.focal_px);
        self.camera_from_world.inverse().transform_point3(flat.extend(depth_m))
    }

    /// Position of the camera, world frame.
    pub fn eye(&self) -> Vec3 {
        self.camera_from_world.inverse().translation.into()
    }

    /// Factor from pixels to the scale in which the published weights hold: a picture 1000 long.
    pub fn per_px(&self) -> f32 {
        1000.0 / self.longest_px.max(1.0)
    }
}
