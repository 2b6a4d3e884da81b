//! What a fit knows of the room: the distance field, and points on the surfaces near the body. The field
//! can't tell a limb that a thin sheet cuts through from one beside it; the points can.

use std::collections::HashMap;

use glam::{IVec3, Mat3, Vec3};

use super::energy::{Energy, Term};
use super::probe::Probe;
use crate::body::joints::JOINTS;
use crate::inspect::surface_samples;
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
        let bins = binned(vertices);
        for point in surface.iter().filter(|p| bounds.contains(**p)) {
            let Some(vertex) = nearest(*point, vertices, &bins) else { continue };
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

fn bin(p: Vec3) -> IVec3 {
    (p / DEEPEST_M).floor().as_ivec3()
}

fn binned(vertices: &[Vec3]) -> HashMap<IVec3, Vec<u32>> {
    let mut bins: HashMap<IVec3, Vec<u32>> = HashMap::new();
    for (i, v) in vertices.iter().enumerate() {
        bins.entry(bin(*v)).or_default().push(i as u32);
    }
    bins
}

/// The vertex nearest to `point`, at most [`DEEPEST_M`] away.
fn nearest(point: Vec3, vertices: &[Vec3], bins: &HashMap<IVec3, Vec<u32>>) -> Option<u32> {
    let center = bin(point);
    let around =
        (-1..=1).flat_map(|x| (-1..=1).flat_map(move |y| (-1..=1).map(move |z| IVec3::new(x, y, z))));
    let candidates = around.filter_map(|step| bins.get(&(center + step))).flatten();
    let mut best = (DEEPEST_M * DEEPEST_M, None);
    for v in candidates {
        let squared = vertices[*v as usize].distance_squared(point);
        if squared < best.0 {
            best = (squared, Some(*v));
        }
    }
    best.1
}
