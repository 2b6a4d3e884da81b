//! From the assets' meshes to what the card draws: normals where they are missing, and the room's shell
//! with the direction in which each triangle looks into the room.

use glam::{Affine3A, Vec3};

use crate::assets::Mesh;
use crate::math::Aabb;
use crate::scene::{Category, Object};

/// Faces that meet at more than this angle keep their edge when normals have to be made (cosine of 40°).
const CREASE_COS: f32 = 0.766;

/// An unnamed scan's triangle belongs to the shell when it lies this close to the room's box, in metres.
const SHELL_DEPTH_M: f32 = 0.35;

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

/// A normal for each corner of each triangle: the file's, or the mean over the faces around the vertex
/// that bend by less than the crease angle, weighted by area.
pub fn corner_normals(mesh: &Mesh) -> Vec<Vec3> {
    if mesh.normals.len() == mesh.positions.len() {
        return mesh.triangles.iter().flatten().map(|v| mesh.normals[*v as usize]).collect();
    }
    let area_normals: Vec<Vec3> = (0..mesh.triangles.len())
        .map(|t| {
            let [a, b, c] = mesh.corners(t);
            (b - a).cross(c - a)
        })
        .collect();
    let around = faces_around(mesh);
    let mut normals = Vec::with_capacity(mesh.triangles.len() * 3);
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let own = area_normals[t].normalize_or(Vec3::Y);
        for vertex in triangle {
            let sum: Vec3 = around
                .of(*vertex as usize)
                .iter()
                .map(|f| area_normals[*f as usize])
                .filter(|n| n.normalize_or_zero().dot(own) > CREASE_COS)
                .sum();
            normals.push(sum.normalize_or(own));
        }
    }
    normals
}

/// Faces around each vertex, as one list and where each vertex starts in it.
struct Around {
    starts: Vec<u32>,
    faces: Vec<u32>,
}

impl Around {
    fn of(&self, vertex: usize) -> &[u32] {
        &self.faces[self.starts[vertex] as usize..self.starts[vertex + 1] as usize]
    }
}

fn faces_around(mesh: &Mesh) -> Around {
    let mut starts = vec![0u32; mesh.positions.len() + 1];
    for vertex in mesh.triangles.iter().flatten() {
        starts[*vertex as usize + 1] += 1;
    }
    for i in 1..starts.len() {
        starts[i] += starts[i - 1];
    }
    let mut next = starts.clone();
    let mut faces = vec![0u32; mesh.triangles.len() * 3];
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        for vertex in triangle {
            faces[next[*vertex as usize] as usize] = t as u32;
            next[*vertex as usize] += 1;
        }
    }
    Around { starts, faces }
}

/// What part of a room stands between an outside camera and the inside, and how it is told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shell {
    bounds: Aabb,
    kind: ShellKind,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum ShellKind {
    /// Walls, floor, ceiling: every triangle.
    Structure,
    /// One mesh for the whole room: triangles close to its box.
    Scan,
}

impl Shell {
    /// The shell that `object` is part of in a room of these bounds; `None` for furniture.
    pub fn of(object: &Object, bounds: &Aabb) -> Option<Self> {
        use Category::{Beam, Ceiling, Floor, Misc, Objects, Unlabeled, Wall};
        let kind = match object.category {
            Wall | Ceiling | Floor | Beam => ShellKind::Structure,
            Unlabeled | Misc | Objects if fills(&object.world_bounds(), bounds) => ShellKind::Scan,
            _ => return None,
        };
        Some(Self { bounds: *bounds, kind })
    }

    /// Unit normal of a world triangle towards the inside; zero for what is never left out.
    pub fn inward(&self, [a, b, c]: [Vec3; 3]) -> Vec3 {
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let middle = (a + b + c) / 3.0;
        let to_center = self.bounds.center() - middle;
        let inward = if normal.dot(to_center) < 0.0 { -normal } else { normal };
        match self.kind {
            ShellKind::Structure => inward,
            ShellKind::Scan if self.is_at_the_box(middle, inward) => inward,
            ShellKind::Scan => Vec3::ZERO,
        }
    }

    fn is_at_the_box(&self, at: Vec3, inward: Vec3) -> bool {
        (0..3).any(|axis| {
            let near_min = at[axis] - self.bounds.min[axis] < SHELL_DEPTH_M && inward[axis] > 0.5;
            let near_max = self.bounds.max[axis] - at[axis] < SHELL_DEPTH_M && inward[axis] < -0.5;
            near_min || near_max
        })
    }
}

/// Whether a box takes up most of the room's in every direction.
fn fills(object: &Aabb, room: &Aabb) -> bool {
    (object.size() / room.size().max(glam::Vec3::splat(1e-3))).min_element() > 0.7
}

/// Doors, windows, pictures and curtains hang on walls and vanish with them: the direction into the room,
/// by the thin side of the object's box.
pub fn hung_inward(object: &Object, bounds: &Aabb) -> Option<(Vec3, Vec3)> {
    use Category::{Blinds, BoardPanel, Curtain, Door, Mirror, Picture, TvMonitor, Window};
    if !matches!(
        object.category,
        Door | Window | Picture | Curtain | Blinds | BoardPanel | Mirror | TvMonitor
    ) {
        return None;
    }
    let own = object.world_bounds();
    let (size, middle) = (own.size(), own.center());
    let axis = if size.x < size.z { 0 } else { 2 };
    let wall = (middle[axis] - bounds.min[axis]).min(bounds.max[axis] - middle[axis]);
    if own.is_empty() || wall > SHELL_DEPTH_M {
        return None;
    }
    let mut inward = Vec3::ZERO;
    inward[axis] = if bounds.center()[axis] > middle[axis] { 1.0 } else { -1.0 };
    Some((middle, inward))
}
