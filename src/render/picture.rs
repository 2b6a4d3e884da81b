//! Pictures without a window: drawn on whatever adapter there is and read back as pixels. Writes no file.

use super::RenderError;
use super::context::RenderContext;
use super::draw::SceneDraw;
use super::gpu::Viewport;
use crate::scene::Camera;

/// Longest side of a picture; far beyond any screen, and what the processor's renderer is held to as well.
pub const MAX_SIDE: u32 = 16384;

/// A picture in memory.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Columns.
    pub width: u32,
    /// Rows, the top one first.
    pub height: u32,
    /// sRGB with alpha 255, `width * height * 4` bytes.
    pub rgba: Vec<u8>,
    /// What drew it, for reports: the adapter's name, or the processor.
    pub backend: String,
}

impl Picture {
    /// sRGB colour of the pixel in column `x` and row `y`.
    pub fn pixel(&self, x: u32, y: u32) -> [u8; 3] {
        let at = (y as usize * self.width as usize + x as usize) * 4;
        [self.rgba[at], self.rgba[at + 1], self.rgba[at + 2]]
    }
}

/// Draws `draw` as `camera` sees it and waits for the pixels.
///
/// # Errors
/// [`RenderError::Size`] when a side is 0 or beyond the device's limit; else as [`Viewport::render`].
pub fn render_image(
    context: &RenderContext,
    draw: &SceneDraw,
    camera: &Camera,
    size: [u32; 2],
) -> Result<Picture, RenderError> {
    let [width, height] = size;
    let limit = context.max_side().min(MAX_SIDE);
    if width == 0 || height == 0 || width > limit || height > limit {
        return Err(RenderError::Size { width, height, limit });
    }
    let mut viewport = Viewport::default();
    viewport.render(context, draw, camera, size)?;
    let Some(texture) = viewport.texture() else { return Err(RenderError::Size { width, height, limit }) };
    let rgba = read_back(context, texture, size)?;
    Ok(Picture { width, height, rgba, backend: context.adapter().to_owned() })
}

/// Copies a texture of four bytes a pixel to memory.
fn read_back(
    context: &RenderContext,
    texture: &wgpu::Texture,
    [width, height]: [u32; 2],
) -> Result<Vec<u8>, RenderError> {
    let row = width * 4;
    let padded = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = context.device().create_buffer(&wgpu::BufferDescriptor {
        label: Some("read back"),
        size: u64::from(padded) * u64::from(height),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = context.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(padded),
                rows_per_image: Some(height),
            },
        },
        texture.size(),
    );
    context.queue().submit([encoder.finish()]);
    buffer.map_async(wgpu::MapMode::Read, .., |_| ());
    let refused = |detail: String| RenderError::Driver { detail };
    let waited = context.device().poll(wgpu::PollType::wait_indefinitely());
    context.check()?;
    waited.map_err(|e| refused(e.to_string()))?;
    let mapped = buffer.get_mapped_range(..).map_err(|e| refused(e.to_string()))?;
    Ok(mapped.chunks_exact(padded as usize).flat_map(|r| r[..row as usize].iter().copied()).collect())
}
