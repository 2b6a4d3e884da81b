//! From the drawn picture to the shown one: ambient occlusion, outline, sRGB.

use glam::{Mat4, Vec4};
use wgpu::util::DeviceExt as _;

use super::Pipelines;
use super::targets::Targets;
use crate::render::draw::Quality;
use crate::render::light::linear_rgb;
use crate::scene::Camera;

/// How far ambient occlusion looks around, in metres: a hand's length, enough to see what touches what.
const REACH_M: f32 = 0.30;

/// Colour of the selection outline, sRGB: the orange that 3-D programs have taught people.
const OUTLINE: [u8; 3] = [255, 156, 36];

/// Width of the outline in pixels.
const OUTLINE_PX: f32 = 2.2;

/// What the finishing shaders read; `shaders/finish.wgsl` mirrors it.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct View {
    view_from_clip: Mat4,
    size: Vec4,
    reach: Vec4,
    outline: Vec4,
}

/// What the finishing passes need to know.
pub struct Finish<'a> {
    /// The view.
    pub camera: &'a Camera,
    /// Work per picture.
    pub quality: Quality,
    /// Whether anything has a selection outline.
    pub outlined: bool,
}

impl Finish<'_> {
    /// Records the three passes.
    pub fn record(
        &self,
        device: &wgpu::Device,
        kit: &Pipelines,
        targets: &Targets,
        encoder: &mut wgpu::CommandEncoder,
    ) {
        let view = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("finish"),
            contents: bytemuck::bytes_of(&self.view(targets.size)),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let [raw, blurred] = &targets.occlusion;
        // Each pass reads what the one before has written; the first reads neither.
        let passes = [
            (&kit.occlusion, &targets.resolved, raw),
            (&kit.blur, raw, blurred),
            (&kit.compose, blurred, &targets.shown_view),
        ];
        for (pipeline, occlusion, target) in passes {
            let group = bind(device, kit, targets, &view, occlusion);
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("finish"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: target,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations::default(),
                })],
                ..wgpu::RenderPassDescriptor::default()
            });
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.draw(0..3, 0..1);
        }
    }

    fn view(&self, size: [u32; 2]) -> View {
        let [width, height] = size.map(|s| s as f32);
        let clip_from_world = self.camera.clip_from_world(width / height);
        let view_from_clip = self.camera.view_from_world() * clip_from_world.inverse();
        let taps = match self.quality {
            Quality::Low => 5.0,
            Quality::High => 14.0,
        };
        let (pixels_per_m, orthographic) = match self.camera.ortho_height_m {
            None => (height * 0.5 / (self.camera.fov_y * 0.5).tan(), 0.0),
            Some(height_m) => (height / height_m, 1.0),
        };
        let width_px = if self.outlined { OUTLINE_PX } else { 0.0 };
        View {
            view_from_clip,
            size: Vec4::new(width, height, 0.0, taps),
            reach: Vec4::new(REACH_M, pixels_per_m, orthographic, 0.0),
            outline: linear_rgb(OUTLINE).extend(width_px),
        }
    }
}

fn bind(
    device: &wgpu::Device,
    kit: &Pipelines,
    targets: &Targets,
    view: &wgpu::Buffer,
    occlusion: &wgpu::TextureView,
) -> wgpu::BindGroup {
    let texture =
        |binding, view| wgpu::BindGroupEntry { binding, resource: wgpu::BindingResource::TextureView(view) };
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("finish"),
        layout: &kit.layouts.finish,
        entries: &[
            wgpu::BindGroupEntry { binding: 0, resource: view.as_entire_binding() },
            texture(1, &targets.depth),
            texture(2, &targets.resolved),
            texture(3, &targets.resolved_flags),
            texture(4, occlusion),
            wgpu::BindGroupEntry {
                binding: 5,
                resource: wgpu::BindingResource::Sampler(&kit.samplers.smooth),
            },
        ],
    })
}
