//! Lines and markers on the card: made anew for every picture, they are few.

use wgpu::util::DeviceExt as _;

use super::Pipelines;
use crate::render::draw::{DepthTest, Line, Point, SceneDraw};

/// A line, or a point with equal ends, as the card reads it.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct Mark {
    from: [f32; 3],
    size_px: f32,
    to: [f32; 3],
    color: [u8; 4],
}

const ATTRIBUTES: [wgpu::VertexAttribute; 4] =
    wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32, 2 => Float32x3, 3 => Unorm8x4];

/// One mark for each instance.
pub const BUFFERS: [Option<wgpu::VertexBufferLayout<'static>>; 1] = [Some(wgpu::VertexBufferLayout {
    array_stride: size_of::<Mark>() as u64,
    step_mode: wgpu::VertexStepMode::Instance,
    attributes: &ATTRIBUTES,
})];

/// The marks of one picture: hidden and on-top lines, hidden and on-top points.
pub struct Marks {
    lines: [Option<(wgpu::Buffer, u32)>; 2],
    points: [Option<(wgpu::Buffer, u32)>; 2],
}

impl Marks {
    /// Uploads the marks of `draw`.
    pub fn upload(device: &wgpu::Device, draw: &SceneDraw) -> Self {
        let depths = [DepthTest::Hidden, DepthTest::OnTop];
        Self {
            lines: depths.map(|d| buffer(device, draw.lines.iter().filter(|l| l.depth == d).map(of_line))),
            points: depths.map(|d| buffer(device, draw.points.iter().filter(|p| p.depth == d).map(of_point))),
        }
    }

    /// Draws them all; group 0 has to be the frame.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, kit: &Pipelines) {
        let lines = kit.lines.iter().zip(&self.lines);
        for (pipeline, marks) in lines.chain(kit.points.iter().zip(&self.points)) {
            if let Some((buffer, count)) = marks {
                pass.set_pipeline(pipeline);
                pass.set_vertex_buffer(0, buffer.slice(..));
                pass.draw(0..4, 0..*count);
            }
        }
    }
}

fn of_line(line: &Line) -> Mark {
    Mark { from: line.from.to_array(), size_px: line.width_px, to: line.to.to_array(), color: line.color }
}

fn of_point(point: &Point) -> Mark {
    Mark { from: point.at.to_array(), size_px: point.size_px, to: point.at.to_array(), color: point.color }
}

fn buffer(device: &wgpu::Device, marks: impl Iterator<Item = Mark>) -> Option<(wgpu::Buffer, u32)> {
    let marks: Vec<Mark> = marks.collect();
    (!marks.is_empty()).then(|| {
        let buffer = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("marks"),
            contents: bytemuck::cast_slice(&marks),
            usage: wgpu::BufferUsages::VERTEX,
        });
        (buffer, marks.len() as u32)
    })
}
