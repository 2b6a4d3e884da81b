//! What a fit knows of the room: the distance field, and points on the surfaces near the body. The field
//! can't tell a limb that a thin sheet cuts through from one beside it; the points can.

use std::collections::HashSet;

use glam::{Mat3, Vec3};

use super::energy::{Energy, Term};
use super::probe::Probe;
use crate::body::joints::JOINTS;
use crate::inspect::{each_surface_sample, surface_samples};
use crate::math::Aabb;
use crate::scene::{RoomGeometry, SignedDistanceField};

/// Distance between points on the room's surfaces: that of the probe's skin.
const SPACING_M: f32 = 0.03;
/// The body moves less than this during a fit, so surfaces farther away don't matter.
const MARGIN_M: f32 = 0.12;
/// Points deeper in the body than this are not pushed out the nearest way: they may have come in at the other side.
const DEEPEST_M: f32 = 0.07;
/// A point this deep is in contact, not a fault.
const SKIN_M: f32 = 0.002;

/// The room around one body.
pub struct Surroundings<'a> {
    /// Signed distances of the whole room.
    pub field: &'a SignedDistanceField,
    /// Points on surfaces near the body, world frame.
    pub surface: Vec<Vec3>,
}

impl<'a> Surroundings<'a> {
    /// The surroundings of a body that starts within `body_bounds`.
    pub fn new(geometry: &'a RoomGeometry, body_bounds: Aabb) -> Self {
        let near = body_bounds.grown(MARGIN_M);
        Self { field: &geometry.field, surface: surface_samples(geometry.bvh.triangles(), &near, SPACING_M) }
    }

    /// The surroundings of a motion within `bounds`: surfaces thinned to one point in each cube of [`SPACING_M`], for
    /// a room's finely tiled furniture has millions of triangles and a motion passes all of it.
    pub fn along(geometry: &'a RoomGeometry, bounds: Aabb) -> Self {
        let mut seen = HashSet::new();
        let mut surface = Vec::new();
        each_surface_sample(geometry.bvh.triangles(), &bounds, SPACING_M, |p| {
            if seen.insert((p / SPACING_M).floor().as_ivec3()) {
                surface.push(p);
            }
        });
        Self { field: &geometry.field, surface }
    }

    /// The field alone: all that the published method knows.
    pub fn of_field(field: &'a SignedDistanceField) -> Self {
        Self { field, surface: Vec::new() }
    }
}

/// Which skin each surface point inside the body would leave through: (point, probe vertex, outward normal).
#[derive(Default)]
pub struct Intrusions {
    pairs: Vec<(Vec3, u32, Vec3)>,
}

impl Intrusions {
    /// Finds them anew for the present pose.
    pub fn update(&mut self, surface: &[Vec3], probe: &Probe, vertices: &[Vec3], rotations: &[Mat3; JOINTS]) {
        self.pairs.clear();
        if surface.is_empty() {
            return;
        }
        let bounds = Aabb::of(vertices.iter().copied());
        let bins = Bins::new(vertices, &bounds);
        for point in surface.iter().filter(|p| bounds.contains(**p)) {
            let Some(vertex) = bins.nearest(*point, vertices) else { continue };
            let (joint, rest_normal) = probe.rest_normals[vertex as usize];
            let normal = rotations[joint] * rest_normal;
            if (*point - vertices[vertex as usize]).dot(normal) < 0.0 {
                self.pairs.push((*point, vertex, normal));
            }
        }
    }

    /// Pushes skin inwards past the points: sum of squared depths of the points under their skin, each
    /// standing for its share of surface.
    pub fn add_energy(&self, energy: &mut Energy, vertices: &[Vec3], weight: f32) {
        for (point, vertex, normal) in &self.pairs {
            let v = *vertex as usize;
            let depth = (vertices[v] - *point).dot(*normal) - SKIN_M;
            if depth > 0.0 {
                energy.add(Term::Intrusion, weight * depth * depth);
                energy.vertices[v] += *normal * (2.0 * weight * depth);
            }
        }
    }
}

/// Points sorted into cubes of side [`DEEPEST_M`], so that all within that distance lie in the cubes around.
pub(super) struct Bins {
    origin: Vec3,
    dim: [usize; 3],
    /// First item of each cube, and one past the last; cubes in z, y, x order, z fastest.
    start: Vec<u32>,
    items: Vec<u32>,
}

impl Bins {
    pub fn new(vertices: &[Vec3], bounds: &Aabb) -> Self {
        let dim = ((bounds.size() / DEEPEST_M).floor() + Vec3::ONE).as_uvec3().to_array().map(|n| n as usize);
        let mut bins = Self { origin: bounds.min, dim, start: Vec::new(), items: Vec::new() };
        let cubes: Vec<usize> = vertices.iter().map(|v| bins.index(bins.cube(*v))).collect();
        bins.start = vec![0; dim.iter().product::<usize>() + 1];
        cubes.iter().for_each(|cube| bins.start[cube + 1] += 1);
        for i in 1..bins.start.len() {
            bins.start[i] += bins.start[i - 1];
        }
        let mut next = bins.start.clone();
        bins.items = vec![0; vertices.len()];
        for (vertex, cube) in cubes.into_iter().enumerate() {
            bins.items[next[cube] as usize] = vertex as u32;
            next[cube] += 1;
        }
        bins
    }

    fn cube(&self, p: Vec3) -> [usize; 3] {
        let place = ((p - self.origin) / DEEPEST_M).max(Vec3::ZERO).as_uvec3().to_array();
        std::array::from_fn(|axis| (place[axis] as usize).min(self.dim[axis] - 1))
    }

    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (x * self.dim[1] + y) * self.dim[2] + z
    }

    /// Which points lie in the cubes that `bounds` touches: all within it and some beside it.
    pub fn around(&self, bounds: &Aabb) -> impl Iterator<Item = u32> {
        let (low, high) = (self.cube(bounds.min), self.cube(bounds.max));
        let rows = (low[0]..=high[0]).flat_map(move |x| (low[1]..=high[1]).map(move |y| (x, y)));
        rows.flat_map(move |(x, y)| {
            let (first, last) = (self.index([x, y, low[2]]), self.index([x, y, high[2]]));
            self.items[self.start[first] as usize..self.start[last + 1] as usize].iter().copied()
        })
    }

    /// The vertex nearest to `point`, at most [`DEEPEST_M`] away.
    fn nearest(&self, point: Vec3, vertices: &[Vec3]) -> Option<u32> {
        let center = self.cube(point);
        let range = |axis: usize| center[axis].saturating_sub(1)..=(center[axis] + 1).min(self.dim[axis] - 1);
        let mut best = (DEEPEST_M * DEEPEST_M, None);
        for x in range(0) {
            for y in range(1) {
                let run = range(2);
                let (first, last) = (self.index([x, y, *run.start()]), self.index([x, y, *run.end()]));
                for v in &self.items[self.start[first] as usize..self.start[last + 1] as usize] {
                    let squared = vertices[*v as usize].distance_squared(point);
                    if squared < best.0 {
                        best = (squared, Some(*v));
                    }
                }
            }
        }
        best.1
    }
}
