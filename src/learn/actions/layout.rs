//! Where things in a photo are on the floor plan around a person (ADSE fig. 5).

use glam::{Mat2, Vec2, Vec3};
use serde::{Deserialize, Serialize};

use super::pose::{Pose3d, coco, middle_of_hips, middle_of_shoulders};
use crate::evolve::action::Posture;

/// Middle of the hips to middle of the shoulders of people, metres (measured on motion capture).
pub const TORSO_M: f64 = 0.51;
/// How far the things that somebody standing handles lie below the middle of the torso, in torsos: a worktop of 0.9 m
/// under a torso's middle at 1.15 m. Somebody at a table has it at the height of the middle.
const WORKTOP_BELOW_STANDING: f32 = 0.5;
/// A torso that points at the camera is short in the photo; the unit is at least this share of its length in space, or
/// all places fly away.
const LEAST_FORESHORTENING: f32 = 0.4;

/// How the floor plan lies in a photo.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum LayoutFrame {
    /// The paper's: right and front of the torso in space as the photo shows them. Degenerates for upright people and
    /// level cameras, whose front points at the viewer.
    Raw,
    /// The person's facing is kept, lean and camera are replaced by a camera that looks down by a fixed angle.
    Pitched {
        /// Degrees below level.
        pitch_deg: f32,
        /// Whether the origin of somebody standing goes down to a worktop's height, where the things are.
        lowered: bool,
    },
}

impl Default for LayoutFrame {
    /// 20° is how photos of people indoors mostly look down; with it distances scatter half as much as in the raw
    /// frame.
    fn default() -> Self {
        Self::Pitched { pitch_deg: 20.0, lowered: true }
    }
}

impl LayoutFrame {
    /// Metres of one unit, the length of the torso in the photo.
    pub fn metres_per_unit(self) -> f64 {
        match self {
            Self::Raw => TORSO_M,
            Self::Pitched { pitch_deg, .. } => TORSO_M * f64::from(pitch_deg).to_radians().cos(),
        }
    }
}

/// A place on the floor plan in torso lengths and radians: 0 right, π/2 in front.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PolarUnits {
    /// Distance, torso lengths as the photo shows them.
    pub distance: f64,
    /// Direction.
    pub angle_rad: f64,
}

/// The floor plan around a person as a photo shows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhotoFrame {
    /// Middle of the torso, pixels, y up.
    origin_px: Vec2,
    /// Units (right, front) from pixels.
    units_from_px: Mat2,
}

impl PhotoFrame {
    /// The frame of somebody; `None` where it degenerates.
    pub fn of(pose: &Pose3d, posture: Posture, frame: LayoutFrame) -> Option<Self> {
        let (shoulders, hips) = (middle_of_shoulders(&pose.joints_px), middle_of_hips(&pose.joints_px));
        let torso = shoulders - hips;
        let unit_px = torso.truncate().length().max(LEAST_FORESHORTENING * torso.length());
        let right = pose.joints_px[coco::RIGHT_SHOULDER] - pose.joints_px[coco::LEFT_SHOULDER];
        let mut origin_px = ((shoulders + hips) * 0.5).truncate();
        let (right, front) = match frame {
            LayoutFrame::Raw => {
                let (up, right) = (torso.try_normalize()?, right.try_normalize()?);
                (right, up.cross(right).try_normalize()?)
            }
            LayoutFrame::Pitched { pitch_deg, lowered } => {
                let (sin, cos) = pitch_deg.to_radians().sin_cos();
                let up = Vec3::new(0.0, cos, sin);
                let right = (right - up * right.dot(up)).try_normalize()?;
                if lowered && posture == Posture::Stand {
                    origin_px.y -= WORKTOP_BELOW_STANDING * unit_px;
                }
                (right, up.cross(right))
            }
        };
        let px_from_units = Mat2::from_cols(right.truncate(), front.truncate()) * unit_px;
        let enough = px_from_units.determinant().abs() > LEAST_DETERMINANT * unit_px * unit_px;
        enough.then(|| Self { origin_px, units_from_px: px_from_units.inverse() })
    }

    /// The origin's pixel, y down.
    pub fn origin(&self) -> Vec2 {
        Vec2::new(self.origin_px.x, -self.origin_px.y)
    }

    /// Where a pixel (y down) is.
    pub fn polar(&self, pixel: Vec2) -> PolarUnits {
        self.polar_from(pixel, self.origin())
    }

    /// Where a pixel is seen from another (both y down), by this person's axes.
    pub fn polar_from(&self, pixel: Vec2, origin: Vec2) -> PolarUnits {
        let offset = pixel - origin;
        let units = self.units_from_px * Vec2::new(offset.x, -offset.y);
        PolarUnits { distance: f64::from(units.length()), angle_rad: f64::from(units.y.atan2(units.x)) }
    }
}

/// Below this the front points at the viewer within a degree.
const LEAST_DETERMINANT: f32 = 0.02;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assets::photos::PHOTO_JOINTS;
    use glam::Mat3;

    /// Somebody upright, turned by `yaw` about the vertical, seen by a camera that looks down by `pitch`; 100 pixels a
    /// torso.
    fn pose(yaw: f32, pitch: f32) -> (Pose3d, Mat3) {
        let mut joints = [Vec3::ZERO; PHOTO_JOINTS];
        joints[coco::LEFT_SHOULDER] = Vec3::new(0.35, 0.5, 0.0);
        joints[coco::RIGHT_SHOULDER] = Vec3::new(-0.35, 0.5, 0.0);
        joints[coco::LEFT_HIP] = Vec3::new(0.2, -0.5, 0.0);
        joints[coco::RIGHT_HIP] = Vec3::new(-0.2, -0.5, 0.0);
        let camera = Mat3::from_rotation_x(pitch) * Mat3::from_rotation_y(yaw) * 100.0;
        let pose = Pose3d {
            joints_px: joints.map(|p| camera * p),
            camera_from_pose: camera,
            marked: [true; PHOTO_JOINTS],
            misfit: 0.0,
        };
        (pose, camera)
    }

    #[test]
    fn things_are_where_they_are_from_every_side() {
        let frame = LayoutFrame::Pitched { pitch_deg: 20.0, lowered: false };
        let cos = 20.0_f32.to_radians().cos();
        for yaw in [-2.5, -1.0, 0.0, 0.7, 2.0] {
            let (pose, camera) = pose(yaw, 20.0_f32.to_radians());
            let photo = PhotoFrame::of(&pose, Posture::Sit, frame).expect("a frame");
            for (place, degrees) in [(Vec3::Z, 90.0), (-Vec3::X, 0.0), (Vec3::X, 180.0), (-Vec3::Z, -90.0)] {
                let seen = camera * (place * 0.8);
                let found = photo.polar(Vec2::new(seen.x, -seen.y));
                // One unit is a torso as it is seen: shorter by the cosine.
                assert!((found.distance - f64::from(0.8 / cos)).abs() < 1e-3, "{found:?} at yaw {yaw}");
                let agrees = (found.angle_rad - f64::to_radians(degrees)).cos();
                assert!(agrees > 0.999, "{found:?} for {degrees} at yaw {yaw}");
            }
        }
    }

    #[test]
    fn the_raw_frame_degenerates_for_a_level_camera_and_the_pitched_one_does_not() {
        let (pose, _) = pose(0.3, 0.0);
        assert!(PhotoFrame::of(&pose, Posture::Sit, LayoutFrame::Raw).is_none());
        assert!(PhotoFrame::of(&pose, Posture::Sit, LayoutFrame::default()).is_some());
    }

    #[test]
    fn things_on_a_worktop_come_nearer_when_the_origin_goes_down_to_it() {
        let pitch = 20.0_f32.to_radians();
        let (pose, camera) = pose(0.4, pitch);
        let distance = |lowered| {
            let frame = LayoutFrame::Pitched { pitch_deg: 20.0, lowered };
            let seen = camera * Vec3::new(0.0, -0.5, 0.6);
            PhotoFrame::of(&pose, Posture::Stand, frame)
                .expect("a frame")
                .polar(Vec2::new(seen.x, -seen.y))
                .distance
        };
        let truth = f64::from(0.6 / pitch.cos());
        assert!((distance(true) - truth).abs() < 0.12, "{}", distance(true));
        assert!(distance(false) > truth + 0.8);
    }
}
