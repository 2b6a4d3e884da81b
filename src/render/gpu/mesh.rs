//! From the assets' meshes to what the card draws: one vertex a corner where normals are missing or a
//! triangle of the room's shell has to know where the inside is.

use glam::{Affine3A, Vec3};

use crate::assets::Mesh;
use crate::render::normals::corner_normals;
use crate::render::shell::Shell;

/// A vertex of the room as the card reads it.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
pub struct RoomVertex {
    position: [f32; 3],
    normal: [f32; 3],
    uv: [f32; 2],
    color: [u8; 4],
    inward: [i16; 4],
}

impl RoomVertex {
    /// Where each part of a vertex lies.
    pub const ATTRIBUTES: [wgpu::VertexAttribute; 5] = wgpu::vertex_attr_array![
        0 => Float32x3, 1 => Float32x3, 2 => Float32x2, 3 => Unorm8x4, 4 => Snorm16x4
    ];

    fn of(mesh: &Mesh, index: usize, normal: Vec3, inward: Vec3) -> Self {
        let quantized = (inward * f32::from(i16::MAX)).round();
        Self {
            position: mesh.positions[index].to_array(),
            normal: normal.to_array(),
            uv: mesh.uvs.get(index).copied().unwrap_or_default().to_array(),
            color: mesh.colors.get(index).copied().unwrap_or([255; 4]),
            inward: [quantized.x as i16, quantized.y as i16, quantized.z as i16, 0],
        }
    }
}

/// Vertices and triangle corners of a mesh, ready for the card.
pub struct MeshData {
    /// Vertices in the mesh's frame.
    pub vertices: Vec<RoomVertex>,
    /// Three for each triangle.
    pub indices: Vec<u32>,
}

impl MeshData {
    /// A mesh that is always drawn whole.
    pub fn plain(mesh: &Mesh) -> Self {
        if mesh.normals.len() == mesh.positions.len() {
            let vertices = (0..mesh.positions.len())
                .map(|i| RoomVertex::of(mesh, i, mesh.normals[i], Vec3::ZERO))
                .collect();
            return Self { vertices, indices: mesh.triangles.iter().flatten().copied().collect() };
        }
        Self::corner_by_corner(mesh, |_| Vec3::ZERO)
    }

    /// A mesh of the room's shell: each triangle knows where the inside is.
    pub fn shell(mesh: &Mesh, world_from_mesh: &Affine3A, shell: &Shell) -> Self {
        Self::corner_by_corner(mesh, |t| {
            shell.inward(mesh.corners(t).map(|p| world_from_mesh.transform_point3(p)))
        })
    }

    fn corner_by_corner(mesh: &Mesh, inward: impl Fn(usize) -> Vec3) -> Self {
        let normals = corner_normals(mesh);
        let mut vertices = Vec::with_capacity(mesh.triangles.len() * 3);
        for (t, triangle) in mesh.triangles.iter().enumerate() {
            let inward = inward(t);
            for (corner, vertex) in triangle.iter().enumerate() {
                vertices.push(RoomVertex::of(mesh, *vertex as usize, normals[t * 3 + corner], inward));
            }
        }
        let indices = (0..vertices.len() as u32).collect();
        Self { vertices, indices }
    }
}
