//! Writes motions as AMASS archives do: SMPL+H, world Z up, floor in the plane of X and Y.

use glam::{Quat, Vec3};

use super::npz_write::NpzWriter;

/// Joints of a frame: the root, 21 of the body, 15 of each hand.
pub const AMASS_JOINTS: usize = 52;
/// Shape numbers of an archive.
const BETAS: usize = 16;

/// A motion in this program's frame (Y up), on SMPL+H's joints.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AmassMotion {
    /// Frames in a second.
    pub fps: f32,
    /// Shape numbers, at most 16.
    pub betas: Vec<f32>,
    /// Where the pelvis joint stands in the body of this shape before it is moved, metres.
    pub pelvis_rest_m: Vec3,
    /// For each frame what is added to every vertex, metres.
    pub translations_m: Vec<Vec3>,
    /// For each frame the root's rotation, world from body.
    pub roots: Vec<Quat>,
    /// For each frame the axis-angles of the other 51 joints: body, left hand, right hand.
    pub poses: Vec<[Vec3; AMASS_JOINTS - 1]>,
}

impl AmassMotion {
    /// The archive: `poses (T, 156)`, `trans (T, 3)`, `betas (16,)`, `gender` and `mocap_framerate`; doubles, as
    /// AMASS has them. Hands are whole axis-angles (flat mean).
    ///
    /// The world is turned so that Z is up. Rotations of the root are about the pelvis joint `J`, so the translation
    /// becomes `R (J + t) - J`.
    ///
    /// # Errors
    /// What the zip writer says; never in memory.
    pub fn to_npz(&self) -> std::io::Result<Vec<u8>> {
        let frames = self.roots.len().min(self.translations_m.len()).min(self.poses.len());
        let z_up_from_y_up = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
        let mut poses: Vec<f64> = Vec::with_capacity(frames * AMASS_JOINTS * 3);
        let mut translations: Vec<f64> = Vec::with_capacity(frames * 3);
        for frame in 0..frames {
            let root = (z_up_from_y_up * self.roots[frame]).normalize();
            let joints = std::iter::once(root.to_scaled_axis()).chain(self.poses[frame]);
            poses.extend(joints.flat_map(|joint| joint.to_array()).map(f64::from));
            let pelvis = z_up_from_y_up * (self.pelvis_rest_m + self.translations_m[frame]);
            translations.extend((pelvis - self.pelvis_rest_m).to_array().map(f64::from));
        }
        let mut betas = [0.0f64; BETAS];
        for (slot, beta) in betas.iter_mut().zip(&self.betas) {
            *slot = f64::from(*beta);
        }
        let mut archive = NpzWriter::default();
        archive.add("poses", &[frames, AMASS_JOINTS * 3], &poses)?;
        archive.add("trans", &[frames, 3], &translations)?;
        archive.add("betas", &[BETAS], &betas)?;
        archive.add_text("gender", "neutral")?;
        archive.add("mocap_framerate", &[], &[f64::from(self.fps)])?;
        archive.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assets::npz::Npz;

    #[test]
    fn an_archive_reads_back_with_z_up_and_the_pelvis_where_it_was() {
        let pelvis_rest_m = Vec3::new(0.0, -0.3, 0.02);
        let motion = AmassMotion {
            fps: 30.0,
            betas: vec![0.5, -1.0],
            pelvis_rest_m,
            translations_m: vec![Vec3::new(1.0, 1.2, -2.0), Vec3::new(1.5, 1.2, -2.0)],
            roots: vec![Quat::IDENTITY, Quat::from_rotation_y(1.0)],
            poses: vec![[Vec3::X * 0.1; AMASS_JOINTS - 1]; 2],
        };
        let npz = Npz::from_bytes("clip.npz", &motion.to_npz().expect("writes")).expect("reads");
        let (_, poses) = npz.floats("poses", &[Some(2), Some(156)]).expect("poses");
        let (_, trans) = npz.floats("trans", &[Some(2), Some(3)]).expect("trans");
        let (_, betas) = npz.floats("betas", &[Some(16)]).expect("betas");
        assert_eq!(betas[..3], [0.5, -1.0, 0.0]);
        assert_eq!(npz.floats("mocap_framerate", &[]).expect("rate").1, [30.0]);
        assert_eq!(poses[3..6], [0.1, 0.0, 0.0]);
        // Somebody who stands in a world with Z up carries a quarter turn about X.
        assert!((poses[0] - std::f32::consts::FRAC_PI_2).abs() < 1e-6 && poses[1].abs() < 1e-6);
        let pelvis = Vec3::from_slice(&trans[3..]) + pelvis_rest_m;
        let ours = motion.translations_m[1] + pelvis_rest_m;
        assert!(pelvis.distance(Vec3::new(ours.x, -ours.z, ours.y)) < 1e-5, "{pelvis}");
        // Facing +Z turned by 1 rad about the vertical there as here.
        let root = Quat::from_scaled_axis(Vec3::from_slice(&poses[156..]));
        let facing = root * Vec3::Z;
        assert!(facing.distance(Vec3::new(1f32.sin(), -1f32.cos(), 0.0)) < 1e-5, "{facing}");
    }
}
