//! A furnished room of 6 x 2.7 x 5 m whose exact distance field is known: an inward room box, an outer
//! shell 15 cm away and six furniture boxes, tiled with small triangles. For tests and benches only.

use glam::Vec3;

/// Smallest corner of the room's inside.
pub const LOW: Vec3 = Vec3::new(-3.0, 0.0, -2.5);
/// Largest corner of the room's inside.
pub const HIGH: Vec3 = Vec3::new(3.0, 2.7, 2.5);
/// Sofa seat and back, table block, stool, wardrobe, bed: solid boxes, 10 cm or more from the walls.
pub const FURNITURE: [([f32; 3], [f32; 3]); 6] = [
    ([-2.2, 0.0, -2.4], [-0.2, 0.45, -1.6]),
    ([-2.2, 0.45, -2.4], [-0.2, 0.9, -2.2]),
    ([0.5, 0.0, -0.5], [1.9, 0.75, 0.3]),
    ([-1.0, 0.0, 0.6], [-0.5, 0.45, 1.1]),
    ([2.3, 0.0, -2.3], [2.9, 2.0, 0.5]),
    ([-2.9, 0.0, 1.2], [-1.2, 0.5, 2.4]),
];

/// Signed distance in metres to the room's solids, exact in free space.
pub fn exact_distance(p: Vec3) -> f32 {
    let inner = (p - LOW).min(HIGH - p);
    let inside = inner.min_element();
    let walls = if inside > 0.0 { inside } else { -inner.min(Vec3::ZERO).length() };
    FURNITURE.iter().fold(walls, |nearest, &(low, high)| {
        let (low, high) = (Vec3::from(low), Vec3::from(high));
        let beyond = (p - (low + high) * 0.5).abs() - (high - low) * 0.5;
        nearest.min(beyond.max(Vec3::ZERO).length() + beyond.max_element().min(0.0))
    })
}

/// About `count` triangles in the world frame.
pub fn triangles(count: usize) -> Vec<[Vec3; 3]> {
    let wall = Vec3::splat(0.15);
    let mut boxes = vec![(LOW, HIGH, true), (LOW - wall, HIGH + wall, false)];
    boxes.extend(FURNITURE.map(|(low, high)| (low.into(), high.into(), false)));
    let area = |&(low, high, _): &(Vec3, Vec3, bool)| {
        let s: Vec3 = high - low;
        2.0 * (s.x * s.y + s.y * s.z + s.z * s.x)
    };
    let edge_m = (2.0 * boxes.iter().map(area).sum::<f32>() / count as f32).sqrt();
    boxes.into_iter().flat_map(|(low, high, inward)| box_triangles(low, high, inward, edge_m)).collect()
}

/// A box tiled with right triangles of about `edge_m`; normals outward unless `inward`.
pub fn box_triangles(low: Vec3, high: Vec3, inward: bool, edge_m: f32) -> Vec<[Vec3; 3]> {
    let mut out = Vec::new();
    let size = high - low;
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let tiles = |a: usize| (size[a] / edge_m).round().max(1.0) as usize;
        let (nu, nv) = (tiles(u), tiles(v));
        for (at, top) in [(low[axis], false), (high[axis], true)] {
            let corner = |i: usize, j: usize| {
                let mut p = Vec3::ZERO;
                p[axis] = at;
                p[u] = low[u] + size[u] * i as f32 / nu as f32;
                p[v] = low[v] + size[v] * j as f32 / nv as f32;
                p
            };
            for (i, j) in (0..nu).flat_map(|i| (0..nv).map(move |j| (i, j))) {
                let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
                let outward = top != inward;
                out.extend(if outward { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] });
            }
        }
    }
    out
}
