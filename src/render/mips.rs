//! Smaller and smaller copies of a texture, so that what is far away does not flicker. Shared by both
//! renderers.

use rayon::prelude::*;

use super::light::{linear_from_srgb, srgb_from_linear};
use crate::assets::Texture;

/// One size of a picture, sRGB with straight alpha.
pub struct Level {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Four bytes a texel.
    pub rgba: Vec<u8>,
}

impl Level {
    /// A picture at its full size; an empty one becomes a white texel.
    pub fn full(texture: &Texture) -> Self {
        let (width, height) = (texture.width.max(1), texture.height.max(1));
        let mut rgba = texture.rgba.clone();
        rgba.resize(width as usize * height as usize * 4, 255);
        Self { width, height, rgba }
    }

    /// This size and every smaller one down to one texel.
    pub fn chain(self) -> Vec<Self> {
        let mut levels = vec![self];
        while levels[levels.len() - 1].width.max(levels[levels.len() - 1].height) > 1 {
            levels.push(levels[levels.len() - 1].halved());
        }
        levels
    }

    /// Half the size (at least 1), averaged in linear light, colours weighted by alpha.
    pub fn halved(&self) -> Self {
        let linear: [f32; 256] = std::array::from_fn(|b| linear_from_srgb(b as u8));
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let mut rgba = vec![0; width as usize * height as usize * 4];
        rgba.par_chunks_mut(width as usize * 4).enumerate().for_each(|(y, row)| {
            for (x, pixel) in row.chunks_exact_mut(4).enumerate() {
                pixel.copy_from_slice(&self.mean(x as u32 * 2, y as u32 * 2, &linear));
            }
        });
        Self { width, height, rgba }
    }

    fn mean(&self, x: u32, y: u32, linear: &[f32; 256]) -> [u8; 4] {
        let mut color = [0.0; 3];
        let (mut alpha, mut weight) = (0.0, 0.0);
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let (sx, sy) = ((x + dx).min(self.width - 1), (y + dy).min(self.height - 1));
            let at = (sy as usize * self.width as usize + sx as usize) * 4;
            let texel = &self.rgba[at..at + 4];
            let w = f32::from(texel[3]) + 1e-3;
            alpha += f32::from(texel[3]) * 0.25;
            weight += w;
            for c in 0..3 {
                color[c] += linear[texel[c] as usize] * w;
            }
        }
        let [r, g, b] = color.map(|c| srgb_from_linear(c / weight));
        [r, g, b, alpha.round() as u8]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_distant_chequer_of_black_and_white_looks_as_bright_as_its_mean_light() {
        let rgba = [[0, 0, 0, 255], [255, 255, 255, 255], [255, 255, 255, 255], [0, 0, 0, 255]].concat();
        let small = Level { width: 2, height: 2, rgba }.halved();
        assert_eq!((small.width, small.height), (1, 1));
        assert_eq!(small.rgba, [188, 188, 188, 255], "half the light is sRGB 188, not 128");
    }

    #[test]
    fn what_is_transparent_does_not_bleed_its_colour_into_what_is_not() {
        let rgba = [[255, 0, 0, 0], [0, 255, 0, 255], [255, 0, 0, 0], [0, 255, 0, 255]].concat();
        let small = Level { width: 2, height: 2, rgba }.halved();
        assert!(small.rgba[0] < 20 && small.rgba[1] > 250, "{:?}", small.rgba);
        assert_eq!(small.rgba[3], 128);
    }
}
