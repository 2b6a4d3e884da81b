//! The passes of one picture, and the viewport that keeps its targets from frame to frame.

use wgpu::util::DeviceExt as _;

use super::Pipelines;
use super::finish::Finish;
use super::frame::{Frame, ShadowFit};
use super::marks::Marks;
use super::room::Pass;
use super::shadow;
use super::targets::Targets;
use crate::render::RenderError;
use crate::render::context::{Cache, RenderContext};
use crate::render::draw::{Look, PersonDraw, SceneDraw, Shown, check_camera};
use crate::render::light::linear_from_srgb;
use crate::scene::Camera;

/// A picture that is drawn again and again: keeps its textures while its size stays. Its result is a
/// texture on the context's device.
#[derive(Default)]
pub struct Viewport {
    targets: Option<Targets>,
}

impl Viewport {
    /// Draws `draw` as `camera` sees it into a texture of `width` by `height` pixels; sides beyond the
    /// device's limit are cut to it. Returns at once: the card works on.
    ///
    /// # Errors
    /// [`RenderError::Size`] for an empty picture, and what [`SceneDraw::check`], the camera and
    /// [`RenderContext::check`] say.
    pub fn render(
        &mut self,
        context: &RenderContext,
        draw: &SceneDraw,
        camera: &Camera,
        [width, height]: [u32; 2],
    ) -> Result<(), RenderError> {
        context.check()?;
        draw.check()?;
        check_camera(camera)?;
        let limit = context.max_side();
        if width == 0 || height == 0 {
            return Err(RenderError::Size { width, height, limit });
        }
        let size = [width.min(limit), height.min(limit)];
        if self.targets.as_ref().is_none_or(|t| t.size != size) {
            self.targets = Some(Targets::new(context.device(), size));
        }
        if let Some(targets) = &self.targets {
            record(context, targets, draw, camera);
        }
        // What a refused call has left on the card is not to be trusted: the next picture starts afresh.
        context.check().inspect_err(|_| *context.cache() = Cache::default())
    }

    /// The picture that was drawn last: sRGB bytes in `Rgba8Unorm`, as window toolkits take them. It is a
    /// new texture whenever the size has changed.
    pub fn texture(&self) -> Option<&wgpu::Texture> {
        self.targets.as_ref().map(|t| &t.shown)
    }

    /// A view of [`Self::texture`].
    pub fn view(&self) -> Option<&wgpu::TextureView> {
        self.targets.as_ref().map(|t| &t.shown_view)
    }

    /// Columns and rows of the picture that was drawn last.
    pub fn size(&self) -> Option<[u32; 2]> {
        self.targets.as_ref().map(|t| t.size)
    }
}

/// Uploads what is new and records and submits every pass.
fn record(context: &RenderContext, targets: &Targets, draw: &SceneDraw, camera: &Camera) {
    let (device, queue, kit) = (context.device(), context.queue(), &context.pipelines);
    let mut cache = context.cache();
    cache.room.update(device, queue, kit, &draw.room);
    cache.people.update(device, queue, kit, draw);
    let bounds = people_bounds(draw).union(cache.room.bounds());
    let fit = ShadowFit::around(&bounds, shadow::side(draw.look.quality));
    let frame = Frame::new(camera, targets.size, &cache.room.bounds(), &draw.look, &fit);
    let (shadow_map, stale) = cache.shadow.prepare(device, draw, fit);
    let buffer = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("frame"),
        contents: bytemuck::bytes_of(&frame),
        usage: wgpu::BufferUsages::UNIFORM,
    });
    let picture = Picture {
        kit,
        cache: &cache,
        draw,
        camera,
        targets,
        frame: bind_frame(device, kit, &buffer),
        lit: bind_lit(device, kit, &buffer, &shadow_map),
        marks: Marks::upload(device, draw),
    };
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    if stale {
        picture.draw_shadow(&mut encoder, &shadow_map);
    }
    picture.draw_scene(&mut encoder);
    let outlined = picture.draw_flags(&mut encoder);
    Finish { camera, quality: draw.look.quality, outlined }.record(device, kit, targets, &mut encoder);
    queue.submit([encoder.finish()]);
}

fn people_bounds(draw: &SceneDraw) -> crate::math::Aabb {
    // In steps of 25 cm, so that the shadow map keeps its texels while somebody is being fitted.
    let people = crate::math::Aabb::of(draw.people.iter().flat_map(|p| p.vertices.iter().copied()));
    crate::math::Aabb { min: (people.min * 4.0).floor() / 4.0, max: (people.max * 4.0).ceil() / 4.0 }
}

fn bind_frame(device: &wgpu::Device, kit: &Pipelines, frame: &wgpu::Buffer) -> wgpu::BindGroup {
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("frame"),
        layout: &kit.layouts.frame,
        entries: &[wgpu::BindGroupEntry { binding: 0, resource: frame.as_entire_binding() }],
    })
}

fn bind_lit(
    device: &wgpu::Device,
    kit: &Pipelines,
    frame: &wgpu::Buffer,
    shadow_map: &wgpu::TextureView,
) -> wgpu::BindGroup {
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("lit"),
        layout: &kit.layouts.lit,
        entries: &[
            wgpu::BindGroupEntry { binding: 0, resource: frame.as_entire_binding() },
            wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(shadow_map) },
            wgpu::BindGroupEntry {
                binding: 2,
                resource: wgpu::BindingResource::Sampler(&kit.samplers.shadow),
            },
        ],
    })
}

/// All that the passes of one picture read.
struct Picture<'a> {
    kit: &'a Pipelines,
    cache: &'a Cache,
    draw: &'a SceneDraw,
    camera: &'a Camera,
    targets: &'a Targets,
    frame: wgpu::BindGroup,
    lit: wgpu::BindGroup,
    marks: Marks,
}

impl Picture<'_> {
    fn solid_people(&self) -> impl Iterator<Item = &PersonDraw> {
        self.draw.people.iter().filter(|p| p.alpha >= 1.0)
    }

    fn draw_shadow(&self, encoder: &mut wgpu::CommandEncoder, map: &wgpu::TextureView) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("shadow"),
            depth_stencil_attachment: Some(depth_attachment(map)),
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_bind_group(0, &self.frame, &[]);
        pass.set_pipeline(&self.kit.room_shadow);
        for item in self.cache.room.items().iter().filter(|i| i.pass != Pass::Blend) {
            self.cache.room.draw(&mut pass, item);
        }
        pass.set_pipeline(&self.kit.person_shadow);
        for person in self.solid_people() {
            self.cache.people.draw(&mut pass, person, None);
        }
    }

    fn draw_scene(&self, encoder: &mut wgpu::CommandEncoder) {
        let [r, g, b] = self.draw.look.background.map(|c| f64::from(linear_from_srgb(c)));
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("scene"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.targets.color,
                depth_slice: None,
                resolve_target: Some(&self.targets.resolved),
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color { r, g, b, a: 0.0 }),
                    store: wgpu::StoreOp::Discard,
                },
            })],
            depth_stencil_attachment: Some(depth_attachment(&self.targets.depth)),
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_bind_group(0, &self.lit, &[]);
        pass.set_pipeline(&self.kit.person_solid);
        for person in self.solid_people() {
            self.cache.people.draw(&mut pass, person, Some(1));
        }
        self.draw_room(&mut pass, Pass::Opaque, &self.kit.room_opaque);
        self.draw_room(&mut pass, Pass::Masked, &self.kit.room_masked);
        if self.draw.look.grid == Shown::Yes {
            pass.set_pipeline(&self.kit.grid);
            pass.draw(0..4, 0..1);
        }
        self.draw_glass(&mut pass);
        self.draw_ghosts(&mut pass);
        pass.set_bind_group(0, &self.frame, &[]);
        self.marks.draw(&mut pass, self.kit);
    }

    fn is_shown(&self, item: &super::room::Item) -> bool {
        let cuts = self.draw.look.cuts(self.camera, &self.cache.room.bounds());
        !(cuts && item.is_cut_for(Look::cut_eye(self.camera)))
    }

    /// The nearest first, so that what they hide costs little.
    fn draw_room(&self, pass: &mut wgpu::RenderPass<'_>, kind: Pass, pipeline: &wgpu::RenderPipeline) {
        pass.set_pipeline(pipeline);
        for item in self.sorted(kind) {
            self.cache.room.draw(pass, item);
        }
    }

    /// See-through things, the farthest first.
    fn draw_glass(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_pipeline(&self.kit.room_blend);
        for item in self.sorted(Pass::Blend).into_iter().rev() {
            self.cache.room.draw(pass, item);
        }
    }

    /// What is shown of one kind, the nearest first.
    fn sorted(&self, kind: Pass) -> Vec<&super::room::Item> {
        let eye = Look::cut_eye(self.camera);
        let items = self.cache.room.items().iter();
        let mut shown: Vec<_> = items.filter(|i| i.pass == kind && self.is_shown(i)).collect();
        shown.sort_by(|a, b| a.bounds.distance(eye).total_cmp(&b.bounds.distance(eye)));
        shown
    }

    /// Each ghost first as depth, then as colour: only its front shows.
    fn draw_ghosts(&self, pass: &mut wgpu::RenderPass<'_>) {
        for person in self.draw.people.iter().filter(|p| p.alpha > 0.0 && p.alpha < 1.0) {
            for pipeline in [&self.kit.ghost_depth, &self.kit.ghost_color] {
                pass.set_pipeline(pipeline);
                self.cache.people.draw(pass, person, Some(1));
            }
        }
    }

    /// Marks every pixel of what is selected; false if nothing is.
    fn draw_flags(&self, encoder: &mut wgpu::CommandEncoder) -> bool {
        let people: Vec<_> = self.draw.people.iter().filter(|p| p.selected).collect();
        let chosen = &self.draw.selected_objects;
        let items: Vec<_> = self.cache.room.items().iter().filter(|i| chosen.contains(&i.object)).collect();
        if people.is_empty() && items.is_empty() {
            return false;
        }
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("selection"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.targets.flags,
                depth_slice: None,
                resolve_target: Some(&self.targets.resolved_flags),
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: wgpu::StoreOp::Discard,
                },
            })],
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_bind_group(0, &self.lit, &[]);
        pass.set_pipeline(&self.kit.room_flag);
        for item in items {
            self.cache.room.draw(&mut pass, item);
        }
        pass.set_pipeline(&self.kit.person_flag);
        for person in people {
            self.cache.people.draw(&mut pass, person, Some(1));
        }
        true
    }
}

fn depth_attachment(view: &wgpu::TextureView) -> wgpu::RenderPassDepthStencilAttachment<'_> {
    wgpu::RenderPassDepthStencilAttachment {
        view,
        depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Store }),
        stencil_ops: None,
    }
}
