use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::view::Intrinsics;

/// Keeps the division by depth finite, in metres (PSI-release; algorithms 1.1).
const EPSILON_M: f32 = 1e-6;

/// PSI's normalising projection π (§3.1): camera points to `[-1, 1]³` of what the image shows.
///
/// `z_n = 2 z / max_depth - 1`, `x_n = s f x / (z + 1e-6)` and `y_n` alike, with `s = 1 / max(px, py)` for the
/// principal point `(px, py)`: the long side of the picture spans -1 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Projection {
    /// `s f`: focal length over half the picture's long side.
    pub scale: f32,
    /// The image's largest depth in metres, after cutting at [`super::MAX_DEPTH_M`].
    pub max_depth_m: f32,
}

impl Projection {
    /// Of a camera and the largest depth that it sees.
    pub fn new(intrinsics: &Intrinsics, max_depth_m: f32) -> Self {
        Self { scale: intrinsics.focal_px / intrinsics.center_px().max_element(), max_depth_m }
    }

    /// π: a camera point in metres to normalised coordinates.
    pub fn normalize(&self, in_camera_m: Vec3) -> Vec3 {
        let per_m = self.scale / (in_camera_m.z + EPSILON_M);
        let depth = 2.0 * in_camera_m.z / self.max_depth_m - 1.0;
        Vec3::new(in_camera_m.x * per_m, in_camera_m.y * per_m, depth)
    }

    /// π⁻¹: normalised coordinates to a camera point in metres.
    pub fn denormalize(&self, normalized: Vec3) -> Vec3 {
        let z = 0.5 * (normalized.z + 1.0) * self.max_depth_m;
        let m_per = (z + EPSILON_M) / self.scale;
        Vec3::new(normalized.x * m_per, normalized.y * m_per, z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_of_what_the_camera_sees_become_plus_and_minus_one() {
        let projection = Projection::new(&Intrinsics::PROX_E, 4.0);
        // At depth 4 m the right border of the picture is 4 * 240 / 265 m to the right.
        let right = projection.normalize(Vec3::new(4.0 * 240.0 / 265.0, 0.0, 4.0));
        assert!(right.abs_diff_eq(Vec3::new(1.0, 0.0, 1.0), 1e-5), "{right}");
        let near = projection.normalize(Vec3::new(0.0, -2.0 * 135.0 / 265.0, 2.0));
        assert!(near.abs_diff_eq(Vec3::new(0.0, -135.0 / 240.0, 0.0), 1e-5), "{near}");
    }

    #[test]
    fn points_survive_the_round_trip_both_ways() {
        let projection = Projection { scale: 1.1, max_depth_m: 5.3 };
        for p in [Vec3::new(0.4, -0.9, 2.2), Vec3::new(-2.0, 1.0, 6.4), Vec3::new(0.01, 0.0, 0.05)] {
            assert!(projection.denormalize(projection.normalize(p)).abs_diff_eq(p, 1e-4));
            let n = p / 7.0;
            assert!(projection.normalize(projection.denormalize(n)).abs_diff_eq(n, 1e-4));
        }
    }
}
