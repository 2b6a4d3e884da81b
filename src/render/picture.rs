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

    /// White, for others to be pasted on.
    pub fn blank([width, height]: [usize; 2]) -> Self {
        let rgba = vec![255; width * height * 4];
        Self { width: width as u32, height: height as u32, rgba, backend: String::new() }
    }

    /// Puts a picture on this one, its upper left corner in column `left` and row `top`.
    ///
    /// # Panics
    /// When it does not lie within this one: a bug of the caller.
    pub fn paste(&mut self, [left, top]: [usize; 2], picture: &Self) {
        let bytes = 4 * picture.width as usize;
        for (y, row) in picture.rgba.chunks_exact(bytes.max(1)).enumerate() {
            let at = 4 * ((top + y) * self.width as usize + left);
            self.rgba[at..at + bytes].copy_from_slice(row);
        }
    }

    /// The same at half the size, each pixel the mean of four; an odd last column or row is left out.
    #[must_use]
    pub fn halved(&self) -> Self {
        let [width, height] = [self.width / 2, self.height / 2];
        let byte = |x: u32, y: u32, channel: u32| {
            let at = |x: u32, y: u32| u32::from(self.rgba[((y * self.width + x) * 4 + channel) as usize]);
            ((at(2 * x, 2 * y) + at(2 * x + 1, 2 * y) + at(2 * x, 2 * y + 1) + at(2 * x + 1, 2 * y + 1) + 2)
                / 4) as u8
        };
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let rgba = pixels.flat_map(|(x, y)| (0..4).map(move |channel| (x, y, channel)));
        let rgba = rgba.map(|(x, y, channel)| byte(x, y, channel)).collect();
        Self { width, height, rgba, backend: self.backend.clone() }
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

#[cfg(test)]
mod tests {
    use super::Picture;

    #[test]
    fn half_a_picture_has_the_mean_of_four_pixels_each() {
        let grey = |v: u8| [v, v, v, 255];
        let rgba = [0, 10, 200, 99, 20, 30, 200, 99].map(grey).concat();
        let picture = Picture { width: 4, height: 2, rgba, backend: "nobody".to_owned() };
        let half = picture.halved();
        assert_eq!([half.width, half.height], [2, 1]);
        assert_eq!((half.pixel(0, 0), half.pixel(1, 0)), ([15; 3], [150; 3]));
        assert!(half.rgba.chunks_exact(4).all(|p| p[3] == 255));
    }
}
