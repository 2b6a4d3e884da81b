//! Normals for meshes that come without. Knows meshes only.

use glam::Vec3;

use crate::assets::Mesh;

/// Faces that meet at more than this angle keep their edge when normals have to be made (cosine of 40°).
const CREASE_COS: f32 = 0.766;

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
