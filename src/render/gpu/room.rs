//! The room on the card: meshes and textures once per `Arc`, instances once per room.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{Affine3A, Vec3, Vec4};
use wgpu::util::DeviceExt as _;

use super::Pipelines;
use super::mesh::{MeshData, RoomVertex};
use super::texture;
use crate::assets::{AlphaMode, Material, Mesh, Texture};
use crate::math::Aabb;
use crate::render::shell::{Shell, hung_inward};
use crate::scene::{ObjectId, Room};

const INSTANCE_ATTRIBUTES: [wgpu::VertexAttribute; 3] =
    wgpu::vertex_attr_array![5 => Float32x4, 6 => Float32x4, 7 => Float32x4];

/// Vertices and instances, as the room's pipelines read them.
pub const BUFFERS: [Option<wgpu::VertexBufferLayout<'static>>; 2] = [
    Some(wgpu::VertexBufferLayout {
        array_stride: size_of::<RoomVertex>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &RoomVertex::ATTRIBUTES,
    }),
    Some(wgpu::VertexBufferLayout {
        array_stride: size_of::<[Vec4; 3]>() as u64,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &INSTANCE_ATTRIBUTES,
    }),
];

/// A mesh on the card. Holds its source, so that the pointer that names it stays its own.
struct GpuMesh {
    _source: Arc<Mesh>,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    count: u32,
}

/// A texture on the card, with its source for the same reason.
struct GpuTexture {
    _source: Arc<Texture>,
    view: wgpu::TextureView,
}

/// Names a mesh on the card: its pointer, and for the shell where it stands, because its vertices then
/// know where the inside is.
#[derive(Clone, PartialEq, Eq, Hash)]
struct MeshKey {
    mesh: usize,
    placed: Option<[u32; 18]>,
}

/// How an item is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pass {
    /// Solid.
    Opaque,
    /// With holes.
    Masked,
    /// See-through.
    Blend,
}

/// One mesh of one object.
pub struct Item {
    /// Whose it is.
    pub object: ObjectId,
    /// How it is drawn.
    pub pass: Pass,
    /// Its box, world frame, for sorting.
    pub bounds: Aabb,
    /// A thing on a wall: left out when the camera looks at the wall from behind (point, direction inwards).
    hung: Option<(Vec3, Vec3)>,
    mesh: MeshKey,
    material: usize,
    instance: u32,
}

impl Item {
    /// Whether it hangs on a wall that is cut away for `eye`.
    pub fn is_cut_for(&self, eye: Vec3) -> bool {
        self.hung.is_some_and(|(at, inward)| inward.dot(eye - at) < 0.0)
    }
}

/// What of the room is on the card.
#[derive(Default)]
pub struct RoomCache {
    room: Option<Arc<Room>>,
    meshes: HashMap<MeshKey, GpuMesh>,
    textures: HashMap<usize, GpuTexture>,
    materials: Vec<wgpu::BindGroup>,
    instances: Option<wgpu::Buffer>,
    items: Vec<Item>,
    bounds: Option<Aabb>,
}

impl RoomCache {
    /// Brings the card up to date with `room`; free when it is the one already there.
    pub fn update(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, kit: &Pipelines, room: &Arc<Room>) {
        if self.room.as_ref().is_some_and(|known| Arc::ptr_eq(known, room)) {
            return;
        }
        let bounds = room.bounds();
        self.bounds = Some(bounds);
        self.update_materials(device, queue, kit, room);
        self.update_items(device, room, &bounds);
        self.room = Some(Arc::clone(room));
    }

    /// The box of the room that was last uploaded.
    pub fn bounds(&self) -> Aabb {
        self.bounds.unwrap_or(Aabb::EMPTY)
    }

    /// Everything that is visible.
    pub fn items(&self) -> &[Item] {
        &self.items
    }

    /// Draws one item with the pipeline that is set; group 1 and buffers are set here.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>, item: &Item) {
        let (Some(mesh), Some(instances)) = (self.meshes.get(&item.mesh), &self.instances) else { return };
        let Some(material) = self.materials.get(item.material) else { return };
        pass.set_bind_group(1, material, &[]);
        pass.set_vertex_buffer(0, mesh.vertices.slice(..));
        pass.set_vertex_buffer(1, instances.slice(..));
        pass.set_index_buffer(mesh.indices.slice(..), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..mesh.count, 0, item.instance..item.instance + 1);
    }

    fn update_items(&mut self, device: &wgpu::Device, room: &Room, bounds: &Aabb) {
        let mut instances: Vec<[Vec4; 3]> = Vec::new();
        let mut kept = HashMap::new();
        self.items.clear();
        for object in room.objects.iter().filter(|o| o.visible) {
            let shell = Shell::of(object, bounds);
            let hung = hung_inward(object, bounds);
            for part in object.parts.iter().filter(|p| !p.mesh.triangles.is_empty()) {
                let world_from_mesh = object.world_from_object * part.object_from_mesh;
                let key = MeshKey::new(&part.mesh, shell.is_some().then_some((&world_from_mesh, bounds)));
                if !kept.contains_key(&key) {
                    let mesh = self.meshes.remove(&key).unwrap_or_else(|| {
                        let data = match &shell {
                            Some(shell) => MeshData::shell(&part.mesh, &world_from_mesh, shell),
                            None => MeshData::plain(&part.mesh),
                        };
                        GpuMesh::upload(device, &part.mesh, &data)
                    });
                    kept.insert(key.clone(), mesh);
                }
                self.items.push(Item {
                    object: object.id,
                    pass: pass_of(room.materials.get(part.material)),
                    bounds: Aabb::of(
                        part.mesh.positions.iter().map(|p| world_from_mesh.transform_point3(*p)),
                    ),
                    hung,
                    mesh: key,
                    material: part.material.min(room.materials.len()),
                    instance: instances.len() as u32,
                });
                instances.push(rows(&world_from_mesh));
            }
        }
        self.meshes = kept;
        self.instances = (!instances.is_empty()).then(|| {
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("instances"),
                contents: bytemuck::cast_slice(&instances),
                usage: wgpu::BufferUsages::VERTEX,
            })
        });
    }

    /// One bind group for each material, and a last one for parts without.
    fn update_materials(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, kit: &Pipelines, room: &Room) {
        let mut kept = HashMap::new();
        for texture in &room.textures {
            let key = Arc::as_ptr(texture) as usize;
            let known = self.textures.remove(&key).unwrap_or_else(|| GpuTexture {
                _source: Arc::clone(texture),
                view: texture::upload(device, queue, texture),
            });
            kept.insert(key, known);
        }
        self.textures = kept;
        let white = texture::upload(device, queue, &white());
        let fallback = Material::default();
        let materials = room.materials.iter().chain(std::iter::once(&fallback));
        self.materials = materials
            .map(|material| {
                let texture = material.base_color_texture.and_then(|i| room.textures.get(i));
                let known = texture.and_then(|t| self.textures.get(&(Arc::as_ptr(t) as usize)));
                bind_material(device, kit, material, known.map_or(&white, |t| &t.view))
            })
            .collect();
    }
}

impl GpuMesh {
    fn upload(device: &wgpu::Device, source: &Arc<Mesh>, data: &MeshData) -> Self {
        let make = |contents, usage| {
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("mesh"),
                contents,
                usage,
            })
        };
        Self {
            _source: Arc::clone(source),
            vertices: make(bytemuck::cast_slice(&data.vertices), wgpu::BufferUsages::VERTEX),
            indices: make(bytemuck::cast_slice(&data.indices), wgpu::BufferUsages::INDEX),
            count: data.indices.len() as u32,
        }
    }
}

impl MeshKey {
    fn new(mesh: &Arc<Mesh>, placed: Option<(&Affine3A, &Aabb)>) -> Self {
        let placed = placed.map(|(at, bounds)| {
            let matrix = at.to_cols_array();
            let numbers = matrix.into_iter().chain(bounds.min.to_array()).chain(bounds.max.to_array());
            let mut bits = [0; 18];
            bits.iter_mut().zip(numbers).for_each(|(b, n)| *b = n.to_bits());
            bits
        });
        Self { mesh: Arc::as_ptr(mesh) as usize, placed }
    }
}

fn rows(m: &Affine3A) -> [Vec4; 3] {
    let (x, y, z, w) = (m.matrix3.x_axis, m.matrix3.y_axis, m.matrix3.z_axis, m.translation);
    [Vec4::new(x.x, y.x, z.x, w.x), Vec4::new(x.y, y.y, z.y, w.y), Vec4::new(x.z, y.z, z.z, w.z)]
}

fn pass_of(material: Option<&Material>) -> Pass {
    match material.map(|m| (m.alpha, m.base_color_texture)) {
        Some((AlphaMode::Mask(_), _)) => Pass::Masked,
        Some((AlphaMode::Blend, _)) => Pass::Blend,
        _ => Pass::Opaque,
    }
}

fn bind_material(
    device: &wgpu::Device,
    kit: &Pipelines,
    material: &Material,
    texture: &wgpu::TextureView,
) -> wgpu::BindGroup {
    let cutoff = match material.alpha {
        AlphaMode::Mask(cutoff) => cutoff,
        AlphaMode::Opaque | AlphaMode::Blend => 0.0,
    };
    let [r, g, b] = material.emissive;
    let values: [[f32; 4]; 3] =
        [material.base_color, [r, g, b, cutoff], [material.metallic, material.roughness, 0.0, 0.0]];
    let buffer = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("material"),
        contents: bytemuck::cast_slice(&values),
        usage: wgpu::BufferUsages::UNIFORM,
    });
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("material"),
        layout: &kit.layouts.material,
        entries: &[
            wgpu::BindGroupEntry { binding: 0, resource: buffer.as_entire_binding() },
            wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(texture) },
            wgpu::BindGroupEntry {
                binding: 2,
                resource: wgpu::BindingResource::Sampler(&kit.samplers.texture),
            },
        ],
    })
}

/// Stands in where a material has no texture.
fn white() -> Texture {
    Texture { width: 1, height: 1, rgba: vec![255; 4], ..Texture::default() }
}
