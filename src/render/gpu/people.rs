//! People on the card: what all share is uploaded once, positions and normals stream as bodies change.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{Vec3, Vec4};
use rayon::prelude::*;
use wgpu::util::DeviceExt as _;

use super::Pipelines;
use super::workers::for_frame;
use crate::render::draw::{PersonDraw, SceneDraw};
use crate::render::dress::{BodySurface, Outfit, SurfacePart};
use crate::render::heat::heat_color;
use crate::scene::PersonId;

const POSED: [wgpu::VertexAttribute; 2] = wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3];
const HEAT: [wgpu::VertexAttribute; 1] = wgpu::vertex_attr_array![2 => Unorm8x4];
const REST: [wgpu::VertexAttribute; 1] = wgpu::vertex_attr_array![3 => Float32x4];

/// Posed vertices, heat colours, T-pose, as the people's pipelines read them.
pub const BUFFERS: [Option<wgpu::VertexBufferLayout<'static>>; 3] =
    [per_vertex(24, &POSED), per_vertex(4, &HEAT), per_vertex(16, &REST)];

const fn per_vertex(
    stride: u64,
    attributes: &'static [wgpu::VertexAttribute],
) -> Option<wgpu::VertexBufferLayout<'static>> {
    Some(wgpu::VertexBufferLayout {
        array_stride: stride,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes,
    })
}

/// What all people share on the card.
struct Surface {
    source: Arc<BodySurface>,
    rest: wgpu::Buffer,
    indices: wgpu::Buffer,
    count: u32,
}

/// One person on the card, and what was uploaded last.
struct GpuPerson {
    vertices: Option<Arc<[Vec3]>>,
    heat: Option<Arc<[f32]>>,
    posed: wgpu::Buffer,
    colors: wgpu::Buffer,
    outfit: wgpu::Buffer,
    group: wgpu::BindGroup,
}

/// Everybody on the card.
#[derive(Default)]
pub struct PeopleCache {
    surface: Option<Surface>,
    people: HashMap<PersonId, GpuPerson>,
}

impl PeopleCache {
    /// Brings the card up to date with `draw`: only changed vertices travel.
    pub fn update(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, kit: &Pipelines, draw: &SceneDraw) {
        let Some(surface) = &draw.body else {
            self.people.clear();
            return;
        };
        if !self.surface.as_ref().is_some_and(|known| Arc::ptr_eq(&known.source, surface)) {
            self.surface = Some(Surface::upload(device, surface));
            self.people.clear();
        }
        self.people.retain(|id, _| draw.people.iter().any(|p| p.id == *id));
        let changed: Vec<&PersonDraw> = draw.people.iter().filter(|p| self.is_new(p)).collect();
        let posed: Vec<Vec<[Vec3; 2]>> =
            for_frame(|| changed.par_iter().map(|p| interleave(surface, p)).collect());
        for (person, posed) in changed.iter().zip(&posed) {
            let gpu = self
                .people
                .entry(person.id)
                .or_insert_with(|| GpuPerson::new(device, kit, surface.vertex_count()));
            queue.write_buffer(&gpu.posed, 0, bytemuck::cast_slice(posed));
            gpu.vertices = Some(Arc::clone(&person.vertices));
        }
        for person in &draw.people {
            if let Some(gpu) = self.people.get_mut(&person.id) {
                gpu.paint(queue, person);
            }
        }
    }

    fn is_new(&self, person: &PersonDraw) -> bool {
        let known = self.people.get(&person.id).and_then(|gpu| gpu.vertices.as_ref());
        !known.is_some_and(|known| Arc::ptr_eq(known, &person.vertices))
    }

    /// Draws one person with the pipeline that is set. `outfit_group` is the number of the bind group
    /// that the pipeline wants the outfit in, if it wants it.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, person: &PersonDraw, outfit_group: Option<u32>) {
        let (Some(surface), Some(gpu)) = (&self.surface, self.people.get(&person.id)) else { return };
        if let Some(index) = outfit_group {
            pass.set_bind_group(index, &gpu.group, &[]);
        }
        pass.set_vertex_buffer(0, gpu.posed.slice(..));
        pass.set_vertex_buffer(1, gpu.colors.slice(..));
        pass.set_vertex_buffer(2, surface.rest.slice(..));
        pass.set_index_buffer(surface.indices.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..surface.count, 0, 0..1);
    }
}

fn interleave(surface: &BodySurface, person: &PersonDraw) -> Vec<[Vec3; 2]> {
    let normals = surface.normals(&person.vertices);
    person.vertices.iter().zip(normals).map(|(p, n)| [*p, n]).collect()
}

impl Surface {
    fn upload(device: &wgpu::Device, source: &Arc<BodySurface>) -> Self {
        let rest: Vec<Vec4> = (0..source.vertex_count())
            .map(|v| {
                let part = match source.part(v) {
                    SurfacePart::Body => 0.0,
                    SurfacePart::Eye => 1.0,
                };
                source.rest(v).extend(part)
            })
            .collect();
        let make = |contents, usage| {
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("body"),
                contents,
                usage,
            })
        };
        Self {
            source: Arc::clone(source),
            rest: make(bytemuck::cast_slice(&rest), wgpu::BufferUsages::VERTEX),
            indices: make(bytemuck::cast_slice(source.triangles()), wgpu::BufferUsages::INDEX),
            count: source.triangles().len() as u32 * 3,
        }
    }
}

impl GpuPerson {
    fn new(device: &wgpu::Device, kit: &Pipelines, vertices: usize) -> Self {
        let make = |size: u64, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("person"),
                size,
                usage: usage | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        let count = vertices as u64;
        let outfit = make(size_of::<[Vec4; 7]>() as u64, wgpu::BufferUsages::UNIFORM);
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("person"),
            layout: &kit.layouts.person,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: outfit.as_entire_binding() }],
        });
        Self {
            vertices: None,
            heat: None,
            posed: make(count * 24, wgpu::BufferUsages::VERTEX),
            colors: make(count * 4, wgpu::BufferUsages::VERTEX),
            outfit,
            group,
        }
    }

    /// Uploads colours: outfit always (it is small), heat when it changed.
    fn paint(&mut self, queue: &wgpu::Queue, person: &PersonDraw) {
        let outfit = Outfit::from_palette(person.palette).to_uniform(person.alpha, person.heat.is_some());
        queue.write_buffer(&self.outfit, 0, bytemuck::cast_slice(&outfit));
        let Some(heat) = &person.heat else { return };
        if self.heat.as_ref().is_some_and(|known| Arc::ptr_eq(known, heat)) {
            return;
        }
        let colors: Vec<[u8; 4]> = heat
            .iter()
            .map(|d| {
                let [r, g, b] = heat_color(*d);
                [r, g, b, 255]
            })
            .collect();
        queue.write_buffer(&self.colors, 0, bytemuck::cast_slice(&colors));
        self.heat = Some(Arc::clone(heat));
    }
}
