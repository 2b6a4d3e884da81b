//! Soft shapes: cushions and curtains.

use glam::{Vec2, Vec3};

use crate::assets::Mesh;

/// A pillow of `size` on its back: a rounded rectangle that swells towards the middle. Closed, smooth.
pub fn cushion(size: Vec3) -> Mesh {
    const RINGS: usize = 6;
    const SEGMENTS: usize = 28;
    let mut mesh = Mesh::default();
    // Superellipse (x⁴ + z⁴ = 1) in plan, a half ellipse in section.
    let rim: Vec<Vec2> = (0..SEGMENTS)
        .map(|i| {
            let (sin, cos) = (std::f64::consts::TAU * i as f64 / SEGMENTS as f64).sin_cos();
            let radius = (sin.powi(4) + cos.powi(4)).powf(-0.25);
            Vec2::new((sin * radius) as f32, (cos * radius) as f32)
        })
        .collect();
    let half = Vec3::new(size.x, size.y, size.z) * 0.5;
    let at = |share: f32, rise: f32, p: Vec2| Vec3::new(p.x * share, 1.0 + rise, p.y * share) * half;
    for ring in 0..=RINGS * 2 {
        let (sin, cos) = (std::f64::consts::FRAC_PI_2 * (ring as f64 / RINGS as f64 - 1.0)).sin_cos();
        let (share, rise) = (cos.max(0.0) as f32, sin as f32);
        for p in &rim {
            mesh.positions.push(at(share, rise, *p));
            let normal = Vec3::new(p.x * share / half.x, rise / half.y, p.y * share / half.z);
            mesh.normals.push(normal.normalize_or(Vec3::Y));
        }
    }
    bands(&mut mesh, RINGS * 2, SEGMENTS);
    mesh
}

/// Closes rows of `around` vertices into bands, skipping the triangles that shrink to a point at both ends.
fn bands(mesh: &mut Mesh, rows: usize, around: usize) {
    let vertex = |row: usize, i: usize| (row * around + i % around) as u32;
    for row in 0..rows {
        for i in 0..around {
            let [a, b] = [vertex(row, i), vertex(row, i + 1)];
            let [d, c] = [vertex(row + 1, i), vertex(row + 1, i + 1)];
            if row > 0 {
                mesh.triangles.push([a, b, c]);
            }
            if row + 1 < rows {
                mesh.triangles.push([a, c, d]);
            }
        }
    }
}

/// A hanging curtain of `width` by `height` in folds, closed, its back near z = 0.
pub fn curtain(width: f32, height: f32) -> Mesh {
    const FOLD_M: f64 = 0.11;
    const DEEP_M: f64 = 0.028;
    const THICK_M: f32 = 0.006;
    let steps = ((f64::from(width) / FOLD_M).round().max(2.0) as usize) * 8;
    let mut front = Vec::new();
    for i in 0..=steps {
        let phase = std::f64::consts::TAU * i as f64 / 8.0;
        let z = (DEEP_M * (1.0 - phase.cos())) as f32 + THICK_M;
        front.push(Vec2::new(width * (i as f32 / steps as f32 - 0.5), z));
    }
    let mut mesh = Mesh::default();
    let slope = |i: usize| {
        let along = front[(i + 1).min(steps)] - front[i.saturating_sub(1)];
        along.perp().normalize_or(Vec2::Y)
    };
    for (back, flip) in [(0.0, 1.0), (THICK_M, -1.0)] {
        let base = mesh.positions.len() as u32;
        for (i, p) in front.iter().enumerate() {
            let normal = slope(i) * flip;
            for y in [0.0, height] {
                mesh.positions.push(Vec3::new(p.x, y, p.y - back));
                mesh.normals.push(Vec3::new(normal.x, 0.0, normal.y));
            }
        }
        for i in 0..steps as u32 {
            let [a, b, c, d] = [0, 2, 3, 1].map(|k| base + 2 * i + k);
            let both = if flip > 0.0 { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] };
            mesh.triangles.extend(both);
        }
    }
    hem(&mut mesh, &front, height, THICK_M);
    mesh
}

/// Closes the curtain's thin edges: below, above, left and right.
fn hem(mesh: &mut Mesh, front: &[Vec2], height: f32, thick: f32) {
    use super::mesh::Build;
    let at = |i: usize, y: f32, back: f32| Vec3::new(front[i].x, y, front[i].y - back);
    let last = front.len() - 1;
    for i in 0..last {
        mesh.quad([at(i, 0.0, thick), at(i + 1, 0.0, thick), at(i + 1, 0.0, 0.0), at(i, 0.0, 0.0)]);
        mesh.quad([
            at(i, height, 0.0),
            at(i + 1, height, 0.0),
            at(i + 1, height, thick),
            at(i, height, thick),
        ]);
    }
    mesh.quad([at(0, 0.0, thick), at(0, 0.0, 0.0), at(0, height, 0.0), at(0, height, thick)]);
    mesh.quad([at(last, 0.0, 0.0), at(last, 0.0, thick), at(last, height, thick), at(last, height, 0.0)]);
}

/// A closed box of `size` with edges rounded by `radius_m`, smooth, on the middle of its underside: cushions of
/// sofas, mattresses, poufs.
pub fn soft_block(size: Vec3, radius_m: f32) -> Mesh {
    let half = size * 0.5;
    let radius = radius_m.min(half.min_element() * 0.98);
    let inner = half - radius;
    // Marks along each axis: evenly spread angles of the quarter bends, projected to the faces of the box.
    let marks = |axis: usize| -> Vec<f32> {
        let bend = BENDS.map(|tangent| inner[axis] + radius * (1.0 - tangent));
        bend.iter().rev().map(|m| -m).chain(bend).collect()
    };
    let mut mesh = Mesh::default();
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let (us, vs) = (marks(u), marks(v));
        for side in [1.0, -1.0] {
            let base = mesh.positions.len() as u32;
            for a in &us {
                for b in &vs {
                    let mut on_box = Vec3::ZERO;
                    (on_box[axis], on_box[u], on_box[v]) = (half[axis] * side, *a, *b);
                    let core = on_box.clamp(-inner, inner);
                    let normal = (on_box - core).normalize_or(Vec3::Y);
                    mesh.positions.push(core + normal * radius + Vec3::Y * half.y);
                    mesh.normals.push(normal);
                }
            }
            grid(&mut mesh, base, us.len() as u32, vs.len() as u32, side > 0.0);
        }
    }
    mesh
}

/// How far the marks of a quarter bend lie from its outer end, in radii: 1 - tan of 45, 22.5 and 0 degrees.
const BENDS: [f32; 3] = [1.0, 0.585_786_4, 0.0];

/// Fills a grid of vertices, rows of `columns`, with triangles.
fn grid(mesh: &mut Mesh, base: u32, rows: u32, columns: u32, forward: bool) {
    for i in 0..rows - 1 {
        for j in 0..columns - 1 {
            let [a, b, c, d] =
                [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| base + i * columns + j);
            let both = if forward { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] };
            mesh.triangles.extend(both);
        }
    }
}
