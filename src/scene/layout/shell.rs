//! The room itself: walls of real thickness with openings, floor, ceiling, skirting, windows and doors.

use glam::{Affine3A, Mat3A, Vec2, Vec3};

use crate::assets::{Material, Mesh};

use super::mesh::{Build, ModelBuilder, Surface, glass, paint};
use super::surface::{PLANK_TILE_M, planks};
use super::{Door, Floor, Layout, LayoutError, Outline, Srgb, Window};

/// Thickness of floor and ceiling slabs: enough to be solid for a distance field of 2 cm cells.
const SLAB_M: f32 = 0.1;
/// Width and depth of window and door frames.
const FRAME_M: f32 = 0.05;
/// Thickness of a door's leaf, the usual one.
const LEAF_M: f32 = 0.04;
/// Width and depth of the boards around a door on the room's side.
const ARCHITRAVE_M: (f32, f32) = (0.06, 0.012);

/// A rectangular hole in a wall, in the wall's own coordinates: along it and up.
#[derive(Clone, Debug)]
struct Hole {
    what: String,
    min: Vec2,
    max: Vec2,
}

/// One wall. Its frame: x along it from its first inner corner, y up, z into the room.
#[derive(Clone, Debug)]
struct Wall {
    world_from_wall: Affine3A,
    length: f32,
    /// How much longer the outer face is at its start and end, by the mitre.
    outer_more: (f32, f32),
    holes: Vec<Hole>,
}

/// The checked outline with its walls.
pub struct Shell {
    corners: Vec<Vec2>,
    outer: Vec<Vec2>,
    walls: Vec<Wall>,
    height: f32,
    thickness: f32,
}

impl Shell {
    /// Checks sizes, outline and openings.
    pub fn new(layout: &Layout) -> Result<Self, LayoutError> {
        size("the room's height", layout.height_m, 1.8, 20.0)?;
        size("the walls' thickness", layout.wall_thickness_m, 0.02, 1.0)?;
        let corners = corners(&layout.outline)?;
        let (height, thickness) = (layout.height_m, layout.wall_thickness_m);
        let outer = outer_corners(&corners, thickness)?;
        let walls = (0..corners.len()).map(|i| wall(&corners, &outer, i)).collect();
        let mut shell = Self { corners, outer, walls, height, thickness };
        for (index, window) in layout.windows.iter().enumerate() {
            let bottom = window.sill_m;
            size("a window's sill", bottom, 0.0, height)?;
            shell.open(
                &format!("window {index}"),
                window.wall,
                window.at_m,
                bottom,
                window.width_m,
                window.height_m,
            )?;
        }
        for (index, door) in layout.doors.iter().enumerate() {
            shell.open(&format!("door {index}"), door.wall, door.at_m, 0.0, door.width_m, door.height_m)?;
        }
        Ok(shell)
    }

    /// Notes a hole after checking that it fits.
    fn open(
        &mut self,
        what: &str,
        wall: usize,
        at: f32,
        bottom: f32,
        width: f32,
        high: f32,
    ) -> Result<(), LayoutError> {
        let last = self.walls.len() - 1;
        let height = self.height;
        let Some(target) = self.walls.get_mut(wall) else {
            return Err(LayoutError::NoSuchWall { what: what.into(), wall, last });
        };
        size(&format!("the width of {what}"), width, 0.2, 20.0)?;
        size(&format!("the height of {what}"), high, 0.2, 20.0)?;
        let hole = Hole {
            what: what.into(),
            min: Vec2::new(at - width * 0.5, bottom),
            max: Vec2::new(at + width * 0.5, bottom + high),
        };
        let refuse = |problem: String| Err(LayoutError::Opening { what: what.into(), wall, problem });
        if hole.min.x < FRAME_M || hole.max.x > target.length - FRAME_M || hole.max.y > height {
            return refuse(format!("the wall is {:.2} m long and {height:.2} m high", target.length));
        }
        let clash = |other: &&Hole| hole.min.x < other.max.x && other.min.x < hole.max.x;
        if let Some(other) = target.holes.iter().find(clash) {
            return refuse(format!("it overlaps {}", other.what));
        }
        target.holes.push(hole);
        Ok(())
    }

    /// Adds floor, ceiling, walls, skirting, windows and doors.
    pub fn build(&self, layout: &Layout, model: &mut ModelBuilder) -> Result<(), LayoutError> {
        model.object("Floor", "floor", Affine3A::IDENTITY, self.floor(layout.floor)?);
        let ceiling = one(self.slab(self.height), paint(layout.ceiling));
        model.object("Ceiling", "ceiling", Affine3A::IDENTITY, ceiling);
        for (index, wall) in self.walls.iter().enumerate() {
            let color = layout.accent_walls.get(&index).copied().unwrap_or(layout.walls);
            let mesh = wall_mesh(wall, self.height, self.thickness);
            let name = format!("Wall {index}");
            model.object(&name, "wall", wall.world_from_wall, one(mesh, paint(color)));
        }
        if let Some(boards) = layout.skirting {
            let mesh = self.skirting(boards.height_m, boards.depth_m);
            model.object("Skirting", "wall", Affine3A::IDENTITY, one(mesh, paint(boards.color)));
        }
        for (index, window) in layout.windows.iter().enumerate() {
            let world = self.walls[window.wall].world_from_wall;
            model.object(
                &format!("Window {index}"),
                "window",
                world,
                window_surfaces(window, self.thickness),
            );
        }
        for (index, door) in layout.doors.iter().enumerate() {
            let world = self.walls[door.wall].world_from_wall;
            model.object(&format!("Door {index}"), "door", world, door_surfaces(door, self.thickness));
        }
        Ok(())
    }

    fn floor(&self, floor: Floor) -> Result<Vec<Surface>, LayoutError> {
        let mut mesh = self.slab(-SLAB_M);
        let (material, texture) = match floor {
            Floor::Plain(color) => (paint(color), None),
            Floor::Planks(tone) => {
                mesh.uvs = mesh.positions.iter().map(|p| Vec2::new(p.x, p.z) / PLANK_TILE_M).collect();
                let wood = Material { name: "planks".into(), roughness: 0.55, ..paint(Srgb(255, 255, 255)) };
                (wood, Some(planks(tone)?))
            }
        };
        Ok(vec![Surface { mesh, material, texture }])
    }

    /// A closed slab under (or over) room and walls, from `bottom` upwards.
    fn slab(&self, bottom: f32) -> Mesh {
        let at = |p: Vec2, y: f32| Vec3::new(p.x, y, p.y);
        let mut mesh = Mesh::default();
        for [a, b, c] in ears(&self.outer) {
            for (y, normal, turn) in [(bottom + SLAB_M, Vec3::Y, false), (bottom, Vec3::NEG_Y, true)] {
                let base = mesh.positions.len() as u32;
                mesh.positions.extend([a, b, c].map(|i| at(self.outer[i], y)));
                mesh.normals.extend([normal; 3]);
                // The outline runs clockwise seen from above.
                mesh.triangles.push(if turn {
                    [base, base + 1, base + 2]
                } else {
                    [base, base + 2, base + 1]
                });
            }
        }
        let n = self.outer.len();
        for i in 0..n {
            let (p, q) = (self.outer[i], self.outer[(i + 1) % n]);
            mesh.quad([at(q, bottom), at(p, bottom), at(p, bottom + SLAB_M), at(q, bottom + SLAB_M)]);
        }
        mesh
    }

    fn skirting(&self, height: f32, depth: f32) -> Mesh {
        let mut mesh = Mesh::default();
        for wall in &self.walls {
            let mut doors: Vec<(f32, f32)> = wall
                .holes
                .iter()
                .filter(|h| h.min.y < height)
                .map(|h| (h.min.x - ARCHITRAVE_M.0, h.max.x + ARCHITRAVE_M.0))
                .collect();
            doors.sort_by(|a, b| a.0.total_cmp(&b.0));
            let mut start = 0.0;
            // The next wall's board fills the corner.
            for (from, to) in doors.into_iter().chain([(wall.length - depth, 0.0)]) {
                if from - start > depth {
                    let mut board = Mesh::default();
                    board.cuboid(Vec3::new(start, 0.0, 0.0), Vec3::new(from, height, depth));
                    mesh.append(&board, wall.world_from_wall);
                }
                start = to;
            }
        }
        mesh
    }

    /// How far `point` (x, z) lies outside of the inner outline; 0 inside.
    pub fn outside_m(&self, point: Vec2) -> f32 {
        let n = self.corners.len();
        let edges = || (0..n).map(|i| (self.corners[i], self.corners[(i + 1) % n]));
        let crossings = edges().filter(|(a, b)| {
            (a.y > point.y) != (b.y > point.y) && point.x < a.x + (point.y - a.y) / (b.y - a.y) * (b.x - a.x)
        });
        if crossings.count() % 2 == 1 {
            return 0.0;
        }
        edges().map(|(a, b)| distance(point, a, b)).fold(f32::INFINITY, f32::min)
    }

    /// The point in plan (x, z) this far before a wall.
    #[cfg(test)]
    pub fn before_wall(&self, wall: usize, along_m: f32, out_m: f32) -> Vec2 {
        let p = self.walls[wall].world_from_wall.transform_point3(Vec3::new(along_m, 0.0, out_m));
        Vec2::new(p.x, p.z)
    }

    /// From floor to ceiling.
    pub fn height_m(&self) -> f32 {
        self.height
    }
}

fn distance(point: Vec2, a: Vec2, b: Vec2) -> f32 {
    let along = ((point - a).dot(b - a) / (b - a).length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
    point.distance(a + (b - a) * along)
}

fn size(what: &str, value_m: f32, least_m: f32, most_m: f32) -> Result<(), LayoutError> {
    if (least_m..=most_m).contains(&value_m) {
        return Ok(());
    }
    Err(LayoutError::Size { what: what.into(), value_m, least_m, most_m })
}

fn corners(outline: &Outline) -> Result<Vec<Vec2>, LayoutError> {
    let corners: Vec<Vec2> = match outline {
        Outline::Polygon(corners) => corners.iter().map(|(x, z)| Vec2::new(*x, *z)).collect(),
        Outline::Box(width, depth) => {
            size("the room's width", *width, 0.5, 100.0)?;
            size("the room's depth", *depth, 0.5, 100.0)?;
            let (x, z) = (width * 0.5, depth * 0.5);
            vec![Vec2::new(-x, -z), Vec2::new(x, -z), Vec2::new(x, z), Vec2::new(-x, z)]
        }
    };
    let bad = |problem: &str| Err(LayoutError::Outline { problem: problem.into() });
    let n = corners.len();
    if n < 3 {
        return bad("has fewer than three corners");
    }
    if corners.iter().any(|c| !c.is_finite() || c.abs().max_element() > 1000.0) {
        return bad("has a corner that is not a number or more than 1000 m away");
    }
    let area: f32 = (0..n).map(|i| corners[i].perp_dot(corners[(i + 1) % n])).sum::<f32>() * 0.5;
    if area < 0.25 {
        return bad("runs counter-clockwise or encloses less than a quarter of a square metre");
    }
    if (0..n).any(|i| corners[i].distance(corners[(i + 1) % n]) < 0.05) {
        return bad("has a wall shorter than 5 cm");
    }
    if ears(&corners).len() + 2 != n {
        return bad("crosses itself");
    }
    Ok(corners)
}

/// Unit vectors along wall `i` and into the room.
fn along_inward(corners: &[Vec2], i: usize) -> (Vec2, Vec2) {
    let along = (corners[(i + 1) % corners.len()] - corners[i]).normalize_or(Vec2::X);
    (along, along.perp())
}

/// Corners of the walls' outer faces, mitred.
fn outer_corners(corners: &[Vec2], thickness: f32) -> Result<Vec<Vec2>, LayoutError> {
    let n = corners.len();
    let mitre = |i: usize| {
        let (before, after) = (along_inward(corners, (i + n - 1) % n).1, along_inward(corners, i).1);
        let spread = 1.0 + before.dot(after);
        (spread > 0.1).then(|| corners[i] - (before + after) * (thickness / spread))
    };
    (0..n)
        .map(|i| {
            mitre(i).ok_or_else(|| LayoutError::Outline { problem: format!("is too pointed at corner {i}") })
        })
        .collect()
}

fn wall(corners: &[Vec2], outer: &[Vec2], i: usize) -> Wall {
    let next = (i + 1) % corners.len();
    let (along, inward) = along_inward(corners, i);
    let turn = Mat3A::from_cols(
        glam::Vec3A::new(along.x, 0.0, along.y),
        glam::Vec3A::Y,
        glam::Vec3A::new(inward.x, 0.0, inward.y),
    );
    Wall {
        world_from_wall: Affine3A {
            matrix3: turn,
            translation: glam::Vec3A::new(corners[i].x, 0.0, corners[i].y),
        },
        length: corners[i].distance(corners[next]),
        outer_more: (-(outer[i] - corners[i]).dot(along), (outer[next] - corners[next]).dot(along)),
        holes: Vec::new(),
    }
}

/// A watertight wall: a grid of cells along the edges of its openings, closed around each opening.
fn wall_mesh(wall: &Wall, height: f32, thickness: f32) -> Mesh {
    let breaks = |ends: [f32; 2], pick: fn(&Hole) -> [f32; 2]| {
        let mut all: Vec<f32> = wall.holes.iter().flat_map(pick).chain(ends).collect();
        all.sort_by(f32::total_cmp);
        all.dedup();
        all
    };
    let us = breaks([0.0, wall.length], |h| [h.min.x, h.max.x]);
    let ys = breaks([0.0, height], |h| [h.min.y, h.max.y]);
    let solid = |i: usize, j: usize| {
        let inside = i < us.len() - 1 && j < ys.len() - 1;
        inside && {
            let middle = Vec2::new(us[i] + us[i + 1], ys[j] + ys[j + 1]) * 0.5;
            !wall.holes.iter().any(|h| middle.cmpgt(h.min).all() && middle.cmplt(h.max).all())
        }
    };
    let inner = |i: usize, j: usize| Vec3::new(us[i], ys[j], 0.0);
    let outer = |i: usize, j: usize| {
        let more = match i {
            0 => -wall.outer_more.0,
            _ if i == us.len() - 1 => wall.outer_more.1,
            _ => 0.0,
        };
        Vec3::new(us[i] + more, ys[j], -thickness)
    };
    let mut mesh = Mesh::default();
    for i in 0..us.len() - 1 {
        for j in (0..ys.len() - 1).filter(|j| solid(i, *j)) {
            mesh.quad([inner(i, j), inner(i + 1, j), inner(i + 1, j + 1), inner(i, j + 1)]);
            mesh.quad([outer(i + 1, j), outer(i, j), outer(i, j + 1), outer(i + 1, j + 1)]);
            // Below, above, before and after this cell: close it where the neighbour is open.
            let mut close = |open: bool, a: (usize, usize), b: (usize, usize)| {
                if open {
                    mesh.quad([inner(b.0, b.1), inner(a.0, a.1), outer(a.0, a.1), outer(b.0, b.1)]);
                }
            };
            close(j == 0 || !solid(i, j - 1), (i, j), (i + 1, j));
            close(!solid(i, j + 1), (i + 1, j + 1), (i, j + 1));
            close(i == 0 || !solid(i - 1, j), (i, j + 1), (i, j));
            close(!solid(i + 1, j), (i + 1, j), (i + 1, j + 1));
        }
    }
    mesh
}

fn one(mesh: Mesh, material: Material) -> Vec<Surface> {
    vec![Surface { mesh, material, texture: None }]
}

/// Four bars inside the rectangle `min` to `max`, between depths `z`.
fn frame(mesh: &mut Mesh, min: Vec2, max: Vec2, z: (f32, f32), bar: f32) {
    let mut bar_at = |a: Vec2, b: Vec2| mesh.cuboid(a.extend(z.0), b.extend(z.1));
    bar_at(min, Vec2::new(min.x + bar, max.y));
    bar_at(Vec2::new(max.x - bar, min.y), max);
    bar_at(Vec2::new(min.x + bar, min.y), Vec2::new(max.x - bar, min.y + bar));
    bar_at(Vec2::new(min.x + bar, max.y - bar), Vec2::new(max.x - bar, max.y));
}

fn window_surfaces(window: &Window, thickness: f32) -> Vec<Surface> {
    let min = Vec2::new(window.at_m - window.width_m * 0.5, window.sill_m);
    let max = min + Vec2::new(window.width_m, window.height_m);
    let middle = -thickness * 0.5;
    let depth = (middle - FRAME_M * 0.5, middle + FRAME_M * 0.5);
    // About one casement per metre, so that wide windows have mullions.
    let casements = (window.width_m / 1.1).ceil().max(1.0) as usize;
    let step = window.width_m / casements as f32;
    let (mut wood, mut panes) = (Mesh::default(), Mesh::default());
    for k in 0..casements {
        let from = Vec2::new(min.x + step * k as f32, min.y);
        let to = Vec2::new(min.x + step * (k + 1) as f32, max.y);
        frame(&mut wood, from, to, depth, FRAME_M);
        panes.cuboid((from + FRAME_M).extend(middle - 0.004), (to - FRAME_M).extend(middle + 0.004));
    }
    let sill = Vec3::new(min.x - 0.05, min.y - 0.03, 0.0);
    wood.cuboid(sill, Vec3::new(max.x + 0.05, min.y, 0.12));
    [one(wood, paint(window.color)), one(panes, glass())].into_iter().flatten().collect()
}

fn door_surfaces(door: &Door, thickness: f32) -> Vec<Surface> {
    let min = Vec2::new(door.at_m - door.width_m * 0.5, 0.0);
    let max = min + Vec2::new(door.width_m, door.height_m);
    let mut wood = Mesh::default();
    let (bar, proud) = ARCHITRAVE_M;
    for (from, to) in [
        (Vec2::new(min.x, 0.0), Vec2::new(min.x + FRAME_M, max.y)),
        (Vec2::new(max.x - FRAME_M, 0.0), max),
        (Vec2::new(min.x + FRAME_M, max.y - FRAME_M), Vec2::new(max.x - FRAME_M, max.y)),
    ] {
        wood.cuboid(from.extend(-thickness), to.extend(0.0));
    }
    for (from, to) in [
        (Vec2::new(min.x - bar, 0.0), Vec2::new(min.x, max.y + bar)),
        (Vec2::new(max.x, 0.0), max + bar),
        (Vec2::new(min.x, max.y), Vec2::new(max.x, max.y + bar)),
    ] {
        wood.cuboid(from.extend(0.0), to.extend(proud));
    }
    let leaf = (min + Vec2::new(FRAME_M, 0.0), max - FRAME_M);
    let front = -thickness * 0.5 + LEAF_M * 0.5;
    wood.cuboid(leaf.0.extend(front - LEAF_M), leaf.1.extend(front));
    let (width, high) = (leaf.1.x - leaf.0.x, leaf.1.y);
    for (low, top) in [(0.06, 0.46), (0.54, 0.94)] {
        let from = Vec2::new(leaf.0.x + 0.16 * width, low * high);
        let to = Vec2::new(leaf.1.x - 0.16 * width, top * high);
        frame(&mut wood, from, to, (front, front + 0.008), 0.03);
    }
    let knob = Vec3::new(leaf.1.x - 0.06, 1.02, front);
    let mut metal = Mesh::default();
    metal.cuboid(knob - Vec3::new(0.02, 0.1, 0.0), knob + Vec3::new(0.02, 0.06, 0.006));
    metal.cuboid(knob + Vec3::new(-0.008, -0.008, 0.006), knob + Vec3::new(0.008, 0.008, 0.05));
    metal.cuboid(knob + Vec3::new(-0.12, -0.009, 0.05), knob + Vec3::new(0.009, 0.009, 0.064));
    let steel = Material { metallic: 0.6, roughness: 0.35, ..paint(Srgb(150, 150, 152)) };
    [one(wood, paint(door.color)), one(metal, steel)].into_iter().flatten().collect()
}

/// Triangles of a simple polygon whose signed area is positive, by cutting ears; fewer than `n - 2` if it
/// crosses itself.
fn ears(corners: &[Vec2]) -> Vec<[usize; 3]> {
    let mut left: Vec<usize> = (0..corners.len()).collect();
    let mut triangles = Vec::new();
    while left.len() >= 3 {
        let n = left.len();
        let ear = (0..n).find(|k| {
            let [a, b, c] = [left[(k + n - 1) % n], left[*k], left[(k + 1) % n]];
            let [pa, pb, pc] = [a, b, c].map(|i| corners[i]);
            let convex = (pb - pa).perp_dot(pc - pb) > 0.0;
            convex && !left.iter().any(|i| ![a, b, c].contains(i) && in_triangle(corners[*i], pa, pb, pc))
        });
        let Some(k) = ear else { break };
        triangles.push([left[(k + n - 1) % n], left[k], left[(k + 1) % n]]);
        left.remove(k);
    }
    triangles
}

fn in_triangle(p: Vec2, a: Vec2, b: Vec2, c: Vec2) -> bool {
    [(a, b), (b, c), (c, a)].into_iter().all(|(from, to)| (to - from).perp_dot(p - from) >= 0.0)
}
