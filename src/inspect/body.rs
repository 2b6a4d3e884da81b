use std::collections::BTreeMap;

use glam::{Vec2, Vec3};

use super::hull::distance_to_hull;
use super::surface::BodySolid;
use crate::body::{Body, Region, worst_excess};
use crate::scene::{BodyParams, RoomGeometry, SignedDistanceField};

/// A vertex this near to a surface touches it (Scene-Diffuser's 2 cm).
pub const CONTACT_M: f32 = 0.02;

/// A surface whose normal rises at least this steeply carries weight (about 70 degrees of slope).
const CARRIES: f32 = 0.35;

/// The centre of mass may stand this far beyond what holds the body: muscles and soft tissue balance it.
const BALANCE_M: f32 = 0.06;

/// What was measured of one body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BodyMetrics {
    /// PSI §4.1.4: vertices with positive signed distance over all vertices.
    pub psi_non_collision: f32,
    /// PSI §4.1.4: whether some vertex has a signed distance of zero or less.
    pub psi_contact: bool,
    /// Whether some contact vertex is within [`CONTACT_M`] of a surface, on either side.
    pub contact_2cm: bool,
    /// Mean depth of the penetrating vertices in millimetres.
    pub penetration_mean_mm: f32,
    /// The deeper of the next two.
    pub penetration_max_mm: f32,
    /// Deepest vertex in solid matter, in millimetres.
    pub penetration_vertices_max_mm: f32,
    /// Deepest point of the room's surfaces inside the body, in millimetres.
    pub penetration_surface_max_mm: f32,
    /// Skin within [`CONTACT_M`] of a surface, in square centimetres.
    pub contact_area_cm2: f32,
    /// The same by contact region.
    pub contact_area_by_region_cm2: BTreeMap<&'static str, f32>,
    /// Whether the weight stands over what carries it.
    pub supported: bool,
    /// Largest excess over a joint's limit in degrees.
    pub joint_limit_deg: f32,
    /// Vertices outside the distance field: never free space.
    pub outside_field: usize,
    /// Vertices or distances that are not finite.
    pub not_finite: usize,
}

/// Everything that is known about one body in one room.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BodyReport {
    /// The numbers.
    pub metrics: BodyMetrics,
    /// Signed distance of every vertex in metres, for the heat map.
    pub signed_distances_m: Vec<f32>,
}

/// Measures one body in one room.
pub fn inspect_body(geometry: &RoomGeometry, body: &Body, params: &BodyParams) -> BodyReport {
    let posed = body.pose(params);
    let faces = &body.model.faces;
    let mut report = measure(&geometry.field, body, &posed.vertices, faces);
    let metrics = &mut report.metrics;
    if metrics.not_finite == 0 {
        let solid = BodySolid::new(&posed.vertices, faces);
        metrics.penetration_surface_max_mm = solid.deepest_surface(geometry.bvh.triangles()) * 1e3;
        metrics.penetration_max_mm =
            metrics.penetration_vertices_max_mm.max(metrics.penetration_surface_max_mm);
    }
    metrics.joint_limit_deg = worst_excess(&body.pose_space.decode(&params.pose)).0.to_degrees();
    report
}

/// Everything that needs only the distance field.
fn measure(field: &SignedDistanceField, body: &Body, vertices: &[Vec3], faces: &[[u32; 3]]) -> BodyReport {
    let mut metrics = BodyMetrics::default();
    let signed_distances_m: Vec<f32> = vertices.iter().map(|v| field.sample(*v)).collect();
    metrics.not_finite = vertices.iter().filter(|v| !v.is_finite()).count()
        + signed_distances_m.iter().filter(|d| !d.is_finite()).count();
    if metrics.not_finite > 0 {
        return BodyReport { metrics, signed_distances_m };
    }
    metrics.outside_field = vertices.iter().filter(|v| !field.contains(**v)).count();
    penetration(&mut metrics, &signed_distances_m);
    contact(&mut metrics, body, &signed_distances_m, &vertex_areas_m2(vertices, faces));
    metrics.supported = is_supported(field, vertices, faces, &signed_distances_m);
    BodyReport { metrics, signed_distances_m }
}

/// PSI's two scores and the depths, all from the vertices' distances.
fn penetration(metrics: &mut BodyMetrics, distances_m: &[f32]) {
    let free = distances_m.iter().filter(|d| **d > 0.0).count();
    metrics.psi_non_collision = free as f32 / distances_m.len().max(1) as f32;
    metrics.psi_contact = free < distances_m.len();
    let depths = || distances_m.iter().filter(|d| **d < 0.0).map(|d| -d * 1e3);
    metrics.penetration_vertices_max_mm = depths().fold(0.0, f32::max);
    metrics.penetration_max_mm = metrics.penetration_vertices_max_mm;
    metrics.penetration_mean_mm = depths().sum::<f32>() / depths().count().max(1) as f32;
}

fn contact(metrics: &mut BodyMetrics, body: &Body, distances_m: &[f32], areas_m2: &[f32]) {
    let touches = |v: usize| distances_m[v].abs() <= CONTACT_M;
    let area = |v: usize| if touches(v) { areas_m2[v] * 1e4 } else { 0.0 };
    metrics.contact_area_cm2 = (0..distances_m.len()).map(area).sum();
    for region in Region::ALL {
        let vertices = body.regions.vertices(region);
        metrics.contact_2cm |= vertices.iter().any(|v| touches(*v as usize));
        let area = vertices.iter().map(|v| area(*v as usize)).sum();
        metrics.contact_area_by_region_cm2.insert(region.name(), area);
    }
}

/// A third of each triangle's area to each of its corners, in square metres.
fn vertex_areas_m2(vertices: &[Vec3], faces: &[[u32; 3]]) -> Vec<f32> {
    let mut areas = vec![0.0; vertices.len()];
    for face in faces {
        let [a, b, c] = face.map(|v| vertices[v as usize]);
        let third = (b - a).cross(c - a).length() / 6.0;
        face.iter().for_each(|v| areas[*v as usize] += third);
    }
    areas
}

/// Gravity: the centre of mass stands over the contacts that carry it; contacts with walls and backrests
/// prop it sideways, so they widen the base as long as something carries at all.
fn is_supported(
    field: &SignedDistanceField,
    vertices: &[Vec3],
    faces: &[[u32; 3]],
    distances: &[f32],
) -> bool {
    let flat = |p: Vec3| Vec2::new(p.x, p.z);
    let mut base = Vec::new();
    let mut carried = false;
    for (vertex, _) in vertices.iter().zip(distances).filter(|(_, d)| d.abs() <= CONTACT_M) {
        let normal = field.sample_gradient(*vertex).1.normalize_or_zero();
        if normal.y >= -CARRIES {
            base.push(flat(*vertex));
            carried |= normal.y >= CARRIES;
        }
    }
    carried && distance_to_hull(&base, flat(center_of_mass(vertices, faces))) <= BALANCE_M
}

/// Centroid of the closed surface's volume, uniform density.
fn center_of_mass(vertices: &[Vec3], faces: &[[u32; 3]]) -> Vec3 {
    let origin = vertices.first().copied().unwrap_or_default();
    let (mut volume, mut moment) = (0.0, Vec3::ZERO);
    for face in faces {
        let [a, b, c] = face.map(|v| vertices[v as usize] - origin);
        let tetrahedron = a.dot(b.cross(c));
        volume += tetrahedron;
        moment += (a + b + c) * (0.25 * tetrahedron);
    }
    origin + if volume.abs() > 1e-9 { moment / volume } else { Vec3::ZERO }
}
