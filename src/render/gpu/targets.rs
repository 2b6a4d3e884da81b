//! The textures that a picture of one size is drawn into.

use super::pipelines::{COLOR, DEPTH, FLAGS, OCCLUSION, SAMPLES, SHOWN};

/// Everything that depends on the size of the picture.
pub struct Targets {
    /// Columns and rows.
    pub size: [u32; 2],
    /// The drawn picture, 4 samples a pixel.
    pub color: wgpu::TextureView,
    /// The drawn picture, resolved.
    pub resolved: wgpu::TextureView,
    /// Its depth.
    pub depth: wgpu::TextureView,
    /// What is selected, 4 samples a pixel.
    pub flags: wgpu::TextureView,
    /// What is selected, resolved.
    pub resolved_flags: wgpu::TextureView,
    /// Ambient occlusion at half the size, before and after the blur.
    pub occlusion: [wgpu::TextureView; 2],
    /// The shown picture.
    pub shown: wgpu::Texture,
    /// The shown picture, to draw into and to show.
    pub shown_view: wgpu::TextureView,
}

impl Targets {
    /// Makes all of them.
    pub fn new(device: &wgpu::Device, size: [u32; 2]) -> Self {
        use wgpu::TextureUsages as U;
        let half = size.map(|s| s.div_ceil(2));
        let read = U::RENDER_ATTACHMENT | U::TEXTURE_BINDING;
        let view = |size, format, samples, usage| {
            make(device, size, format, samples, usage).create_view(&wgpu::TextureViewDescriptor::default())
        };
        let shown = make(device, size, SHOWN, 1, read | U::COPY_SRC);
        Self {
            size,
            color: view(size, COLOR, SAMPLES, U::RENDER_ATTACHMENT),
            resolved: view(size, COLOR, 1, read),
            depth: view(size, DEPTH, SAMPLES, read),
            flags: view(size, FLAGS, SAMPLES, U::RENDER_ATTACHMENT),
            resolved_flags: view(size, FLAGS, 1, read),
            occlusion: [0, 1].map(|_| view(half, OCCLUSION, 1, read)),
            shown_view: shown.create_view(&wgpu::TextureViewDescriptor::default()),
            shown,
        }
    }
}

fn make(
    device: &wgpu::Device,
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
    sample_count: u32,
    usage: wgpu::TextureUsages,
) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("picture"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}
