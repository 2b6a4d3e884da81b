//! The light that both renderers share, so that a picture from the processor looks like one from the card.

use glam::Vec3;

/// Key light from above, hemisphere from sky and ground, and a weak light from the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightRig {
    /// Unit vector towards the key light, world frame.
    pub to_key: Vec3,
    /// Linear RGB of the key light on a surface that faces it.
    pub key: Vec3,
    /// Linear RGB of the hemisphere seen by a surface that faces up.
    pub sky: Vec3,
    /// Linear RGB of the hemisphere seen by a surface that faces down.
    pub ground: Vec3,
    /// Linear grey of the light at the camera: keeps folds readable in full shadow.
    pub camera: f32,
    /// Linear grey of the rim that sets people off against furniture.
    pub rim: f32,
}

impl Default for LightRig {
    /// A bright day indoors. Steep, so that the shadows lie under things and show what touches what.
    fn default() -> Self {
        Self {
            to_key: Vec3::new(0.42, 0.86, 0.29).normalize_or(Vec3::Y),
            key: Vec3::new(1.0, 0.95, 0.88) * 0.62,
            sky: Vec3::new(0.93, 0.97, 1.0) * 0.50,
            ground: Vec3::new(1.0, 0.93, 0.85) * 0.30,
            camera: 0.12,
            rim: 0.10,
        }
    }
}

/// sRGB byte to linear light (IEC 61966-2-1).
pub fn linear_from_srgb(byte: u8) -> f32 {
    let c = f32::from(byte) / 255.0;
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

/// Linear light to an sRGB byte, clamped.
pub fn srgb_from_linear(linear: f32) -> u8 {
    let l = linear.clamp(0.0, 1.0);
    let c = if l <= 0.003_130_8 { l * 12.92 } else { 1.055 * l.powf(1.0 / 2.4) - 0.055 };
    (c * 255.0).round() as u8
}

/// Linear RGB of an sRGB colour.
pub fn linear_rgb(srgb: [u8; 3]) -> Vec3 {
    Vec3::from_array(srgb.map(linear_from_srgb))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_srgb_byte_survives_the_way_to_linear_light_and_back() {
        for byte in 0..=255 {
            assert_eq!(srgb_from_linear(linear_from_srgb(byte)), byte);
        }
    }
}
