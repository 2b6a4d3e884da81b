//! A body for a place: a pose drawn from its family, turned and set down where it rests best.

use glam::{Mat3, Vec2, Vec3};
use rand::RngExt as _;
use rand_distr::{Distribution as _, StandardNormal};

use super::place::{Place, flat};
use crate::body::sample_pose;
use crate::body::{Body, Region, VertexSubset, Workspace};
use crate::job::Rng;
use crate::scene::{BETAS, BodyParams, PoseFamily, RoomGeometry};

/// Every so many vertices of the mesh stand for the skin in the coarse search.
const SKIN_STRIDE: usize = 24;
/// Heights tried over the resting height that the anchor region suggests, in metres.
const LIFTS_M: [f32; 9] = [-0.03, -0.02, -0.01, 0.0, 0.01, 0.02, 0.03, 0.05, 0.08];
/// Steps tried around the place, forwards and sideways, in metres.
const SHIFTS_M: [(f32, f32); 9] = [
    (0.0, 0.0),
    (0.05, 0.0),
    (-0.05, 0.0),
    (0.0, 0.05),
    (0.0, -0.05),
    (0.1, 0.0),
    (-0.1, 0.0),
    (0.0, 0.1),
    (0.0, -0.1),
];
/// A root mean square depth of this much over the skin costs 1.
const DEPTH_M: f32 = 0.01;
/// A gap of this much under the anchor costs 1.
const GAP_M: f32 = 0.04;
/// Spread of the facing around the place's own, in radians.
const TURN: f32 = 0.12;
/// Spread of body shape: most adults, few extremes.
const SHAPE: f32 = 0.7;

/// A body set down at a place.
#[derive(Clone, Debug)]
pub struct Settled {
    /// The body.
    pub params: BodyParams,
    /// How badly it stands: 0 is perfect.
    pub cost: f32,
}

/// Sets bodies down; holds the skin samples that the coarse search asks about.
pub struct Poser<'a> {
    body: &'a Body,
    skin: VertexSubset,
}

/// The skin sample of one posed body around its pelvis.
struct Skin<'a> {
    points: &'a [Vec3],
    /// How many of the points, from the first, belong to what the family rests on.
    anchors: usize,
}

impl<'a> Poser<'a> {
    /// A poser of `body`.
    pub fn new(body: &'a Body) -> Self {
        let ids = (0..body.model.template.len() as u32).step_by(SKIN_STRIDE).collect();
        Self { body, skin: VertexSubset::new(&body.model, ids) }
    }

    /// Draws a person of the place's family and sets them down there as well as a coarse search can.
    pub fn settle(&self, geometry: &RoomGeometry, place: &Place, rng: &mut Rng) -> Settled {
        let betas = shape(rng);
        let params = self.draw(place, betas, TURN, rng);
        self.set_down(geometry, place, params, &SHIFTS_M)
    }

    /// Draws how the person of this shape holds themselves and sets them down; with `exactly` the pelvis is over the
    /// place's point and the front in the place's direction.
    pub fn settle_person(
        &self,
        geometry: &RoomGeometry,
        place: &Place,
        betas: [f32; BETAS],
        exactly: bool,
        rng: &mut Rng,
    ) -> Settled {
        let params = self.draw(place, betas, if exactly { 0.0 } else { TURN }, rng);
        self.set_down(geometry, place, params, if exactly { &SHIFTS_M[..1] } else { &SHIFTS_M })
    }

    fn set_down(
        &self,
        geometry: &RoomGeometry,
        place: &Place,
        mut params: BodyParams,
        shifts_m: &[(f32, f32)],
    ) -> Settled {
        let points = self.posed_points(&params, place.family);
        let skin = Skin { points: &points.0, anchors: points.1 };
        let (offset, cost) = best_offset(geometry, place, &skin, shifts_m);
        params.translation += offset;
        Settled { params, cost }
    }

    /// A person of the place's family with the pelvis joint at the origin, turned as the place says up to `turn`
    /// radians.
    fn draw(&self, place: &Place, betas: [f32; BETAS], turn: f32, rng: &mut Rng) -> BodyParams {
        let sample = sample_pose(&self.body.model.joint_template, place.family, rng, &place.hints);
        let turn = rng.random_range(-1.0..1.0) * turn;
        let yaw = yaw_to(place, &sample.upright_from_body, turn);
        let mut params = sample.params(self.body, betas, &yaw);
        params.translation = -self.body.model.rest_joints(&betas)[0];
        params
    }

    /// Skin points of a body at the origin: those of its anchor region first, and how many these are.
    fn posed_points(&self, params: &BodyParams, family: PoseFamily) -> (Vec<Vec3>, usize) {
        let mut workspace = Workspace::default();
        let anchor = VertexSubset::new(&self.body.model, self.anchor_vertices(family));
        self.body.forward(params, &anchor, &mut workspace);
        let mut points = workspace.vertices().to_vec();
        let anchors = points.len();
        self.body.forward(params, &self.skin, &mut workspace);
        points.extend_from_slice(workspace.vertices());
        (points, anchors)
    }

    fn anchor_vertices(&self, family: PoseFamily) -> Vec<u32> {
        let regions: &[Region] = match family.group() {
            "sit" => &[Region::Butt],
            "lie" => &[Region::Back, Region::Butt, Region::Front, Region::LeftSide, Region::RightSide],
            _ => &[Region::LeftLeg, Region::RightLeg],
        };
        regions.iter().flat_map(|r| self.body.regions.sample(*r).iter().copied()).collect()
    }
}

/// A body shape, cut at two and a half standard deviations of the population.
fn shape(rng: &mut Rng) -> [f32; BETAS] {
    std::array::from_fn(|_| {
        let z: f32 = StandardNormal.sample(rng);
        z.clamp(-2.5, 2.5) * SHAPE
    })
}

/// The turn about the vertical that brings the sampled body's front (its head, for lying) to the place's facing.
fn yaw_to(place: &Place, upright_from_body: &Mat3, turn: f32) -> Mat3 {
    let lies = place.family.group() == "lie";
    let front = flat(*upright_from_body * if lies { Vec3::Y } else { Vec3::Z });
    let front = if front.length() > 1e-3 { front } else { Vec2::Y };
    // About +Y an angle turns z towards x, so the (x, z) plane's own angle runs the other way.
    let angle = front.to_angle() - place.facing.to_angle();
    Mat3::from_rotation_y(angle + turn)
}

/// The translation from the origin under which the body rests best, and its cost there.
fn best_offset(
    geometry: &RoomGeometry,
    place: &Place,
    skin: &Skin<'_>,
    shifts_m: &[(f32, f32)],
) -> (Vec3, f32) {
    let lowest = skin.points[..skin.anchors].iter().map(|p| p.y).fold(f32::INFINITY, f32::min);
    let rest = place.under_pelvis - Vec3::Y * lowest;
    let ahead = Vec3::new(place.facing.x, 0.0, place.facing.y);
    let aside = ahead.cross(Vec3::Y);
    let mut best = (rest, f32::INFINITY);
    for &(forward_m, sideways_m) in shifts_m {
        for lift_m in LIFTS_M {
            let offset = rest + ahead * forward_m + aside * sideways_m + Vec3::Y * lift_m;
            let moved = 0.02 * (forward_m.abs() + sideways_m.abs()) / 0.05;
            let cost = cost_at(geometry, skin, offset, best.1 - moved) + moved;
            if cost < best.1 {
                best = (offset, cost);
            }
        }
    }
    best
}

/// Depth of the skin in solid matter and gap under the anchor; gives up early beyond `limit`.
fn cost_at(geometry: &RoomGeometry, skin: &Skin<'_>, offset: Vec3, limit: f32) -> f32 {
    let mut nearest = f32::INFINITY;
    let mut depth = 0.0;
    let scale = 1.0 / (DEPTH_M * DEPTH_M * skin.points.len() as f32);
    for (i, point) in skin.points.iter().enumerate() {
        let d = geometry.field.sample(*point + offset);
        if i < skin.anchors {
            nearest = nearest.min(d);
        }
        if d < 0.0 {
            depth += d * d * scale;
            if depth > limit {
                return f32::INFINITY;
            }
        }
    }
    let gap = nearest / GAP_M;
    depth.sqrt() + gap * gap
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_of_a_sitter_turns_to_where_the_place_faces() {
        for facing in [Vec2::X, Vec2::Y, Vec2::new(-0.6, 0.8)] {
            let place = Place {
                family: PoseFamily::SitChair,
                under_pelvis: Vec3::ZERO,
                facing,
                support: None,
                hints: crate::body::FamilyHints::default(),
                on: String::new(),
                weight: 1.0,
            };
            let leaning_back = Mat3::from_rotation_x(-0.3);
            let front = yaw_to(&place, &leaning_back, 0.0) * leaning_back * Vec3::Z;
            assert!(flat(front).normalize_or_zero().dot(facing) > 0.999, "{front} for {facing}");
        }
    }
}
