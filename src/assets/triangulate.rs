//! Cuts polygons of any number of corners, convex or not, into triangles.

use glam::{Vec2, Vec3};

/// Above this many corners a polygon is cut as a fan: ear clipping takes the square of the corners.
const MAX_CLIPPED_CORNERS: usize = 2_000;

/// Cuts a polygon into triangles of its corner numbers, in the polygon's winding. A polygon of n corners
/// always gives n - 2 triangles; one that crosses itself gives some that overlap.
pub(super) fn triangulated(corners: &[Vec3]) -> Vec<[usize; 3]> {
    match corners.len() {
        0..3 => Vec::new(),
        3 => vec![[0, 1, 2]],
        n => {
            let flat = flattened(corners);
            let convex = (0..n).all(|i| turn(flat[i], flat[(i + 1) % n], flat[(i + 2) % n]) >= 0.0);
            if convex || n > MAX_CLIPPED_CORNERS { fan(n) } else { ears(&flat) }
        }
    }
}

fn fan(n: usize) -> Vec<[usize; 3]> {
    (2..n).map(|i| [0, i - 1, i]).collect()
}

/// The polygon seen against its normal (Newell's), counter-clockwise.
fn flattened(corners: &[Vec3]) -> Vec<Vec2> {
    let next = |i: usize| corners[(i + 1) % corners.len()];
    let normal: Vec3 =
        corners.iter().enumerate().map(|(i, &p)| (p - corners[0]).cross(next(i) - corners[0])).sum();
    let normal = normal.normalize_or(Vec3::Z);
    let right = normal.any_orthonormal_vector();
    let up = normal.cross(right);
    corners.iter().map(|&p| Vec2::new((p - corners[0]).dot(right), (p - corners[0]).dot(up))).collect()
}

/// Twice the signed area of a triangle; positive to the left.
fn turn(a: Vec2, b: Vec2, c: Vec2) -> f32 {
    (b - a).perp_dot(c - a)
}

/// Ear clipping (Meisters 1975): cuts off a corner whose triangle holds no other corner, until three are left.
fn ears(flat: &[Vec2]) -> Vec<[usize; 3]> {
    let mut left: Vec<usize> = (0..flat.len()).collect();
    let mut triangles = Vec::with_capacity(flat.len() - 2);
    let mut at = 0;
    let mut tried = 0;
    while left.len() > 3 {
        let n = left.len();
        let [a, b, c] = [left[(at + n - 1) % n], left[at % n], left[(at + 1) % n]];
        // A polygon that crosses itself may have no ear left: then cut anyway.
        if tried >= n || is_ear(flat, &left, [a, b, c]) {
            triangles.push([a, b, c]);
            left.remove(at % n);
            at = (at + left.len() - 1) % left.len();
            tried = 0;
        } else {
            at = (at + 1) % n;
            tried += 1;
        }
    }
    triangles.push([left[0], left[1], left[2]]);
    triangles
}

fn is_ear(flat: &[Vec2], left: &[usize], [a, b, c]: [usize; 3]) -> bool {
    let (pa, pb, pc) = (flat[a], flat[b], flat[c]);
    let inside = |p: Vec2| turn(pa, pb, p) >= 0.0 && turn(pb, pc, p) >= 0.0 && turn(pc, pa, p) >= 0.0;
    let is_corner = |p: Vec2| p == pa || p == pb || p == pc;
    turn(pa, pb, pc) > 0.0 && !left.iter().any(|&i| !is_corner(flat[i]) && inside(flat[i]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(corners: &[Vec3], triangles: &[[usize; 3]]) -> f32 {
        let one =
            |t: &[usize; 3]| (corners[t[1]] - corners[t[0]]).cross(corners[t[2]] - corners[t[0]]).y * 0.5;
        triangles.iter().map(one).inspect(|a| assert!(*a >= 0.0, "turned over")).sum()
    }

    #[test]
    fn an_l_shaped_floor_is_covered_once_from_whichever_corner_it_starts() {
        let l = [(0, 0), (0, 3), (1, 3), (1, 1), (4, 1), (4, 0)];
        for start in 0..l.len() {
            let corners: Vec<Vec3> = (0..l.len())
                .map(|i| l[(i + start) % l.len()])
                .map(|(x, z)| Vec3::new(x as f32, 0.5, z as f32))
                .collect();
            let triangles = triangulated(&corners);
            assert_eq!(triangles.len(), 4);
            assert!((area(&corners, &triangles) - 6.0).abs() < 1e-5, "start {start}");
        }
    }

    #[test]
    fn a_star_and_a_degenerate_polygon_end() {
        let star: Vec<Vec3> = (0..100)
            .map(|i| {
                let (radius, angle) = (if i % 2 == 0 { 1.0 } else { 0.4 }, i as f32 * -0.062_831_85);
                Vec3::new(radius * angle.cos(), 0.0, radius * angle.sin())
            })
            .collect();
        let triangles = triangulated(&star);
        assert_eq!(triangles.len(), 98);
        let expected = 50.0 * 0.4 * 0.062_831_85_f32.sin();
        assert!((area(&star, &triangles) - expected).abs() < 1e-3);
        assert_eq!(triangulated(&[Vec3::ZERO; 7]).len(), 5);
        assert_eq!(triangulated(&[Vec3::ZERO; 2]).len(), 0);
    }
}
