use super::workers::for_frame;
use crate::assets::Texture;
use crate::render::mips::Level;

/// Uploads a picture with all its smaller sizes; one that is too large for the device starts at the first
/// size that fits.
pub fn upload(device: &wgpu::Device, queue: &wgpu::Queue, texture: &Texture) -> wgpu::TextureView {
    let limit = device.limits().max_texture_dimension_2d;
    let mut level = Level::full(texture);
    while level.width > limit || level.height > limit {
        level = for_frame(|| level.halved());
    }
    let levels = 32 - level.width.max(level.height).leading_zeros();
    let target = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("material"),
        size: extent(&level),
        mip_level_count: levels,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    for mip in 0..levels {
        write(queue, &target, mip, &level);
        level = for_frame(|| level.halved());
    }
    target.create_view(&wgpu::TextureViewDescriptor::default())
}

fn extent(level: &Level) -> wgpu::Extent3d {
    wgpu::Extent3d { width: level.width, height: level.height, depth_or_array_layers: 1 }
}

fn write(queue: &wgpu::Queue, target: &wgpu::Texture, mip: u32, level: &Level) {
    queue.write_texture(
        wgpu::TexelCopyTextureInfo {
            texture: target,
            mip_level: mip,
            origin: wgpu::Origin3d::ZERO,
            aspect: wgpu::TextureAspect::All,
        },
        &level.rgba,
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(level.width * 4),
            rows_per_image: Some(level.height),
        },
        extent(level),
    );
}
