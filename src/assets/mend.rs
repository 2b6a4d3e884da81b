//! What every reader does to a mesh before it is handed out: bad vertices and their triangles out, unused
//! vertices out, normals made where there are none.

use glam::Vec3;
use rayon::prelude::*;

use super::model::Mesh;

/// Beyond this many units a coordinate is a mistake and would overflow when squared a few times.
const MAX_COORDINATE: f32 = 1e9;

/// Faces that meet at a sharper angle than this get a hard edge: above a twelve-sided leg's 30°, below a
/// box's 90° and a bevel's 45°.
const CREASE_COS: f32 = 0.766; // 40°

/// A scan: so many triangles in one mesh, and at so many corners a crease. That is noise, not edges, and is
/// smoothed over. Furniture with as many creases has far fewer triangles.
const SCAN_TRIANGLES: usize = 50_000;
const SCAN_CREASED_SHARE: f32 = 0.3;

/// Corners compared with each other at one vertex; above it (the tip of a fan) all share one normal.
const MAX_CORNERS_COMPARED: usize = 64;

/// What was taken out of a mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Dropped {
    /// Triangles that use a vertex that is not finite.
    pub non_finite: usize,
    /// Triangles that use a vertex twice.
    pub degenerate: usize,
}

impl Dropped {
    /// Both added up.
    pub fn add(&mut self, other: Self) {
        self.non_finite += other.non_finite;
        self.degenerate += other.degenerate;
    }

    /// What to tell the user.
    pub fn notes(&self) -> impl Iterator<Item = String> + use<> {
        let note = |count: usize, why: &str| (count > 0).then(|| format!("{count} triangles dropped: {why}"));
        let bad = note(self.non_finite, "a corner is not a finite number");
        bad.into_iter().chain(note(self.degenerate, "two corners are the same"))
    }
}

/// Cleans `mesh`, whose indices are all in range; see the module.
pub(super) fn mended(mut mesh: Mesh) -> (Mesh, Dropped) {
    let bad: Vec<bool> = mesh.positions.iter().map(|p| !is_sound(*p)).collect();
    let mut dropped = Dropped::default();
    mesh.triangles.retain(|&[a, b, c]| {
        let non_finite = [a, b, c].iter().any(|&v| bad[v as usize]);
        let degenerate = !non_finite && (a == b || b == c || c == a);
        dropped.non_finite += usize::from(non_finite);
        dropped.degenerate += usize::from(degenerate);
        !non_finite && !degenerate
    });
    let mut mesh = without_unused_vertices(mesh);
    for uv in mesh.uvs.iter_mut().filter(|uv| !uv.is_finite()) {
        *uv = glam::Vec2::ZERO;
    }
    if mesh.normals.iter().any(|n| !is_sound(*n) || n.length_squared() < 1e-12) {
        mesh.normals.clear();
    }
    for normal in &mut mesh.normals {
        *normal = normal.normalize_or(Vec3::Y);
    }
    if mesh.normals.is_empty() {
        mesh = with_normals(&mesh);
    }
    (mesh, dropped)
}

/// Whether a coordinate can be worked with.
pub(super) fn is_sound(p: Vec3) -> bool {
    p.abs().cmple(Vec3::splat(MAX_COORDINATE)).all()
}

fn without_unused_vertices(mesh: Mesh) -> Mesh {
    let mut new_of_old = vec![u32::MAX; mesh.positions.len()];
    for v in mesh.triangles.iter().flatten() {
        new_of_old[*v as usize] = 0;
    }
    if new_of_old.iter().all(|&new| new == 0) {
        return mesh;
    }
    let mut used = Vec::new();
    for (old, new) in new_of_old.iter_mut().enumerate().filter(|(_, new)| **new == 0) {
        *new = used.len() as u32;
        used.push(old);
    }
    let triangles = mesh.triangles.iter().map(|t| t.map(|v| new_of_old[v as usize])).collect();
    Mesh { triangles, ..picked(&mesh, &used) }
}

/// The vertices `used` of `mesh`, in that order, without triangles.
fn picked(mesh: &Mesh, used: &[usize]) -> Mesh {
    fn pick<T: Copy>(values: &[T], used: &[usize]) -> Vec<T> {
        if values.is_empty() { Vec::new() } else { used.iter().map(|&v| values[v]).collect() }
    }
    Mesh {
        positions: pick(&mesh.positions, used),
        normals: pick(&mesh.normals, used),
        uvs: pick(&mesh.uvs, used),
        colors: pick(&mesh.colors, used),
        triangles: Vec::new(),
    }
}

/// For each vertex the number of the first vertex at the same place.
fn welded(positions: &[Vec3]) -> Vec<u32> {
    let key = |p: Vec3| (p + Vec3::ZERO).to_array().map(f32::to_bits);
    let mut order: Vec<([u32; 3], u32)> = positions.iter().zip(0..).map(|(p, v)| (key(*p), v)).collect();
    order.par_sort_unstable();
    let mut first_of = vec![0; positions.len()];
    for same in order.chunk_by(|a, b| a.0 == b.0) {
        for (_, v) in same {
            first_of[*v as usize] = same[0].1;
        }
    }
    first_of
}

/// Adds angle-weighted normals (Thürmer & Wüthrich 1998) that stay hard across creases; vertices at a crease
/// are split.
fn with_normals(mesh: &Mesh) -> Mesh {
    let place_of = welded(&mesh.positions);
    let (weighted, units): (Vec<[Vec3; 3]>, Vec<Vec3>) =
        (0..mesh.triangles.len()).into_par_iter().map(|t| corner_normals(mesh.corners(t))).unzip();
    let (start, corners) = corners_by_place(mesh, &place_of);
    let around = |t: usize, k: usize| {
        let place = place_of[mesh.triangles[t][k] as usize] as usize;
        &corners[start[place] as usize..start[place + 1] as usize]
    };
    let is_crease = |t: usize, other: u32| units[t].dot(units[other as usize / 3]) <= CREASE_COS;
    let creased = |t: usize| (0..3).any(|k| around(t, k).iter().any(|&other| is_crease(t, other)));
    let is_scan = mesh.triangles.len() > SCAN_TRIANGLES && {
        let seen = (0..mesh.triangles.len()).step_by(17);
        let (count, creased) = seen.fold((0, 0), |(n, c), t| (n + 1, c + usize::from(creased(t))));
        creased as f32 > SCAN_CREASED_SHARE * count as f32
    };
    let normal_at = |t: usize, k: usize| {
        let here = around(t, k);
        let smooth = is_scan || here.len() > MAX_CORNERS_COMPARED;
        let sum: Vec3 = here
            .iter()
            .filter(|&&other| smooth || other as usize / 3 == t || !is_crease(t, other))
            .map(|&other| weighted[other as usize / 3][other as usize % 3])
            .sum();
        sum.normalize_or(units[t])
    };
    let normals: Vec<[Vec3; 3]> =
        (0..mesh.triangles.len()).into_par_iter().map(|t| std::array::from_fn(|k| normal_at(t, k))).collect();
    split_at_creases(mesh, &normals)
}

/// The unit normal of a triangle, and it weighted by the angle at each corner; zero for a needle.
fn corner_normals(corners: [Vec3; 3]) -> ([Vec3; 3], Vec3) {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    let unit = (b - a).cross(c - a).normalize_or_zero().as_vec3();
    let angle = |at: glam::DVec3, p: glam::DVec3, q: glam::DVec3| {
        (p - at).normalize_or_zero().dot((q - at).normalize_or_zero()).clamp(-1.0, 1.0).acos() as f32
    };
    ([unit * angle(a, b, c), unit * angle(b, c, a), unit * angle(c, a, b)], unit)
}

/// Corners (3 t + k) sorted by place: those of place p are `corners[start[p]..start[p + 1]]`.
fn corners_by_place(mesh: &Mesh, place_of: &[u32]) -> (Vec<u32>, Vec<u32>) {
    let mut start = vec![0u32; mesh.positions.len() + 1];
    let places = || mesh.triangles.iter().flatten().map(|v| place_of[*v as usize] as usize);
    for place in places() {
        start[place + 1] += 1;
    }
    for p in 1..start.len() {
        start[p] += start[p - 1];
    }
    let mut next = start.clone();
    let mut corners = vec![0; mesh.triangles.len() * 3];
    for (corner, place) in places().enumerate() {
        corners[next[place] as usize] = corner as u32;
        next[place] += 1;
    }
    (start, corners)
}

/// One vertex for each different normal that the corners of an old vertex have.
fn split_at_creases(mesh: &Mesh, normals: &[[Vec3; 3]]) -> Mesh {
    let mut copies_of: Vec<Option<usize>> = vec![None; mesh.positions.len()];
    let mut next_copy: Vec<Option<usize>> = Vec::with_capacity(mesh.positions.len());
    let mut old_of: Vec<usize> = Vec::with_capacity(mesh.positions.len());
    let mut new_normals: Vec<Vec3> = Vec::with_capacity(mesh.positions.len());
    let mut triangles = Vec::with_capacity(mesh.triangles.len());
    for (triangle, normals) in mesh.triangles.iter().zip(normals) {
        triangles.push(std::array::from_fn(|k| {
            let old = triangle[k] as usize;
            let mut copy = copies_of[old];
            while let Some(c) = copy.filter(|&c| new_normals[c].distance_squared(normals[k]) > 1e-6) {
                copy = next_copy[c];
            }
            let new = copy.unwrap_or_else(|| {
                new_normals.push(normals[k]);
                old_of.push(old);
                next_copy.push(copies_of[old]);
                copies_of[old] = Some(old_of.len() - 1);
                old_of.len() - 1
            });
            new as u32
        }));
    }
    Mesh { triangles, normals: new_normals, ..picked(mesh, &old_of) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A closed box of eight shared vertices.
    fn cube() -> Mesh {
        let positions =
            (0..8).map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32)).collect();
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        Mesh { positions, triangles, ..Mesh::default() }
    }

    #[test]
    fn a_box_without_normals_gets_flat_faces_that_point_outwards() {
        let (mesh, dropped) = mended(cube());
        assert_eq!(dropped, Dropped::default());
        assert_eq!((mesh.positions.len(), mesh.triangles.len()), (24, 12));
        for t in 0..12 {
            let [a, b, c] = mesh.corners(t);
            let outward = (b - a).cross(c - a).normalize_or_zero();
            assert!(outward.dot((a + b + c) / 3.0 - Vec3::splat(0.5)) > 0.0);
            assert!(mesh.triangles[t].iter().all(|v| mesh.normals[*v as usize].distance(outward) < 1e-5));
        }
    }

    #[test]
    fn a_round_thing_without_normals_is_smooth_across_a_texture_seam() {
        let sides = 24;
        let ring = |y: f32| {
            (0..=sides).map(move |i| {
                let angle = i as f32 / sides as f32 * std::f32::consts::TAU;
                let at = if i == sides { 0.0 } else { angle };
                Vec3::new(at.cos(), y, at.sin())
            })
        };
        let positions: Vec<Vec3> = ring(0.0).chain(ring(1.0)).collect();
        let above = sides + 1;
        let triangles = (0..sides).flat_map(|i| [[i, i + above, i + 1], [i + 1, i + above, i + 1 + above]]);
        let mesh = Mesh { positions, triangles: triangles.collect(), ..Mesh::default() };
        let (mesh, _) = mended(mesh);
        assert_eq!(mesh.positions.len(), 2 * above as usize);
        for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
            assert!(n.distance(Vec3::new(p.x, 0.0, p.z)) < 0.02, "{p} {n}");
        }
    }

    #[test]
    fn the_noise_of_a_scan_is_not_taken_for_edges() {
        let side = 200u32;
        let mut state = 1u32;
        let mut noise = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 16) as f32 / 65_536.0 - 0.5
        };
        let positions = (0..side * side)
            .map(|i| Vec3::new((i % side) as f32, noise() * 1.5, (i / side) as f32))
            .collect();
        let quads = (0..side - 1).flat_map(|z| (0..side - 1).map(move |x| z * side + x));
        let triangles = quads.flat_map(|i| [[i, i + side, i + 1], [i + 1, i + side, i + side + 1]]).collect();
        let (mesh, _) = mended(Mesh { positions, triangles, ..Mesh::default() });
        assert_eq!(mesh.positions.len(), (side * side) as usize, "no vertex was split");
    }

    #[test]
    fn triangles_with_bad_corners_go_and_the_rest_stays() {
        let mut mesh = cube();
        mesh.positions[0] = Vec3::new(f32::NAN, 0.0, 0.0);
        mesh.positions.push(Vec3::splat(1e30));
        mesh.triangles.push([1, 1, 2]);
        mesh.triangles.push([1, 2, 8]);
        let users = mesh.triangles.iter().filter(|t| t.contains(&0)).count();
        let (mended, dropped) = mended(mesh);
        assert_eq!(dropped, Dropped { non_finite: users + 1, degenerate: 1 });
        assert_eq!(mended.triangles.len(), 12 - users);
        assert!(mended.positions.iter().all(|p| p.is_finite() && p.max_element() <= 1.0));
    }
}
