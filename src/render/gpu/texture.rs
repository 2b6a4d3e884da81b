use rayon::prelude::*;

use crate::assets::Texture;
use crate::render::light::{linear_from_srgb, srgb_from_linear};

/// Uploads a picture with all its smaller sizes; one that is too large for the device starts at the first
/// size that fits.
pub fn upload(device: &wgpu::Device, queue: &wgpu::Queue, texture: &Texture) -> wgpu::TextureView {
    let limit = device.limits().max_texture_dimension_2d;
    let mut level =
        Level { width: texture.width.max(1), height: texture.height.max(1), rgba: texture.rgba.clone() };
    level.rgba.resize(level.width as usize * level.height as usize * 4, 255);
    while level.width > limit || level.height > limit {
        level = level.halved();
    }
    let levels = 32 - level.width.max(level.height).leading_zeros();
    let target = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("material"),
        size: level.extent(),
        mip_level_count: levels,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    for mip in 0..levels {
        level.write(queue, &target, mip);
        level = level.halved();
    }
    target.create_view(&wgpu::TextureViewDescriptor::default())
}

/// One size of a picture, sRGB with straight alpha.
struct Level {
    width: u32,
    height: u32,
    rgba: Vec<u8>,
}

impl Level {
    fn extent(&self) -> wgpu::Extent3d {
        wgpu::Extent3d { width: self.width, height: self.height, depth_or_array_layers: 1 }
    }

    fn write(&self, queue: &wgpu::Queue, target: &wgpu::Texture, mip: u32) {
        queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture: target,
                mip_level: mip,
                origin: wgpu::Origin3d::ZERO,
                aspect: wgpu::TextureAspect::All,
            },
            &self.rgba,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(self.width * 4),
                rows_per_image: Some(self.height),
            },
            self.extent(),
        );
    }

    /// Half the size (at least 1), averaged in linear light, colours weighted by alpha.
    fn halved(&self) -> Self {
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
