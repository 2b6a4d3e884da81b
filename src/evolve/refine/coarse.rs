//! Where a sample could be meant: many small moves, turns and supports around it and the room's own places,
//! scored by skin and bones through the distance field. Cheap: some milliseconds a body.

use glam::{Mat3, Vec2, Vec3};

use super::guess::Posture;
use super::shape::{Shape, Shaper};
use super::upright::repair;
use crate::body::joints as j;
use crate::generate::{Cells, Place, seat_family, support_name};
use crate::scene::{BodyParams, PoseFamily, Room, RoomGeometry};

/// Radii of the rings of positions tried around a sample, metres, and how many on each.
const RINGS: [(f32, usize); 7] =
    [(0.0, 1), (0.08, 6), (0.18, 8), (0.3, 10), (0.45, 12), (0.65, 14), (0.9, 16)];
/// Turns about the vertical tried at each, degrees.
const TURNS: [f32; 12] = [0.0, -14.0, 14.0, -30.0, 30.0, -55.0, 55.0, -85.0, 85.0, -125.0, 125.0, 180.0];
/// Heights tried over the resting height, metres.
const LIFTS_M: [f32; 5] = [0.0, 0.015, -0.015, 0.035, 0.06];
/// Moves tried around one of the room's places, forwards and sideways, metres.
const SHIFTS_M: [(f32, f32); 5] = [(0.0, 0.0), (0.06, 0.0), (-0.06, 0.0), (0.0, 0.06), (0.0, -0.06)];
/// Places farther from the sample than this are tried at one position only, metres.
const FINE_M: f32 = 1.2;
/// A move of this far costs 1.
const MOVE_M: f32 = 0.4;
/// A turn of this far costs 1, degrees.
const TURN_DEG: f32 = 60.0;
/// Cost beyond the best at which a start is no longer worth a fit.
const WORTH: f32 = 2.5;
/// Starts this near to a better one are the same, metres and degrees.
const SAME: (f32, f32) = (0.2, 25.0);
/// Heights over the floor of what one sits on.
const SEAT_M: std::ops::RangeInclusive<f32> = 0.2..=0.95;
/// Heights over the floor of what one lies on.
const BED_M: std::ops::RangeInclusive<f32> = 0.1..=1.0;
/// Smaller surfaces hold nobody who lies.
const LEAST_BED_M2: f32 = 0.5;
/// Sitting on a table, a shelf or a floor is less likely than on a seat.
const NO_SEAT: f32 = 0.6;
/// Bent knees are not meant for the floor.
const FLOOR_SEAT: f32 = 2.5;
/// Lying on the floor, or with straight legs, is less likely than on a bed.
const FLOOR_BED: f32 = 0.8;
/// Standing people whose torso leans farther than this are held by something, degrees.
const LEANING_DEG: f32 = 15.0;

/// How far a start may be from the sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// Moves cost as they should: the sample's surroundings.
    Near,
    /// Moves cost little: any place in the room.
    Anywhere,
}

impl Reach {
    /// Share of the cost of moving and turning that counts.
    fn price(self) -> f32 {
        match self {
            Self::Near => 1.0,
            Self::Anywhere => 0.2,
        }
    }
}

/// A body set down somewhere: where the fitter begins.
#[derive(Clone, Debug)]
pub struct Start {
    /// The body.
    pub params: BodyParams,
    /// What it does there.
    pub family: PoseFamily,
    /// Name of what holds it.
    pub on: String,
    /// How badly it stands, moves included: 0 is perfect and where the sample was.
    pub cost: f32,
    /// Where it is, to tell starts apart.
    pub spot: Spot,
}

/// A position and a turn from the sample.
#[derive(Clone, Copy, Debug)]
pub struct Spot {
    pelvis: Vec3,
    yaw_deg: f32,
}

impl Spot {
    /// Whether a fit from one would end as one from the other.
    fn is_like(&self, other: &Self) -> bool {
        let turn = (self.yaw_deg - other.yaw_deg).rem_euclid(360.0);
        self.pelvis.distance(other.pelvis) < SAME.0 && turn.min(360.0 - turn) < SAME.1
    }
}

impl Start {
    /// The sample itself, for the published fit, which knows no families.
    pub fn as_sampled(sample: &BodyParams) -> Self {
        Self::unmoved(sample, PoseFamily::Stand, Vec3::ZERO)
    }

    fn unmoved(params: &BodyParams, family: PoseFamily, pelvis: Vec3) -> Self {
        let on = "nothing".to_owned();
        Self { params: params.clone(), family, on, cost: f32::INFINITY, spot: Spot { pelvis, yaw_deg: 0.0 } }
    }
}

/// Finds starts for samples in one room. Shared by threads.
pub struct Coarse<'a> {
    room: &'a Room,
    geometry: &'a RoomGeometry,
    shaper: Shaper<'a>,
    places: &'a [Place],
    cells: Vec<Cells>,
}

/// Something to rest on at one point: its height, which surface (`None` is the floor), what choosing it costs.
#[derive(Clone, Copy, Debug)]
struct Rest {
    height_m: f32,
    support: Option<usize>,
    cost: f32,
}

/// One position and turn of the body with what it costs to go there.
#[derive(Clone, Copy)]
struct Pose<'p> {
    pelvis: Vec2,
    yaw_deg: f32,
    moving: f32,
    place: Option<&'p Place>,
}

/// A sample made upright, ready to be moved.
struct Sample {
    params: BodyParams,
    family: PoseFamily,
    pelvis: Vec3,
    shape: Shape,
    leans: bool,
}

impl<'a> Coarse<'a> {
    /// A finder for the room; `places` are its affordances.
    pub fn new(room: &'a Room, geometry: &'a RoomGeometry, shaper: Shaper<'a>, places: &'a [Place]) -> Self {
        let cells = geometry.supports.iter().map(Cells::new).collect();
        Self { room, geometry, shaper, places, cells }
    }

    /// Up to `count` starts, the most promising first, none alike and none like one that was `tried`. Where nothing
    /// is to rest on at all, the sample set right.
    pub fn starts(&self, sample: &BodyParams, reach: Reach, count: usize, tried: &[Spot]) -> Vec<Start> {
        let sample = self.upright(sample);
        let mut found: Vec<Start> = Vec::new();
        let mut best = f32::INFINITY;
        let mut poses = self.poses_around(&sample, reach);
        poses.extend(self.poses_at_places(&sample, reach));
        poses.sort_by(|a, b| a.moving.total_cmp(&b.moving));
        let mut turned = sample.shape.clone();
        for pose in poses {
            if pose.moving > best + WORTH {
                break;
            }
            sample.shape.turn_into(pose.yaw_deg.to_radians(), &mut turned);
            if let Some(start) = self.best_height(&sample, &turned, &pose, best + WORTH) {
                best = best.min(start.cost);
                found.push(start);
            }
        }
        if found.is_empty() {
            // Nothing to rest on anywhere near: set right and nothing else.
            found.push(Start::unmoved(&sample.params, sample.family, sample.pelvis));
        }
        distinct(found, count, tried)
    }

    /// What the body does, set right.
    fn upright(&self, sample: &BodyParams) -> Sample {
        let mut params = sample.clone();
        let joints = self.shaper.joints(&params);
        let pelvis = joints[j::PELVIS];
        let below = super::height_over_m(self.geometry, pelvis);
        let posture = Posture::of(&joints, &params.rotation());
        let family = posture.family(below);
        let turn = repair(family, &joints, &params.rotation());
        params.set_rotation(&(turn * params.rotation()));
        let shape = self.shaper.shape(&params, family);
        let upright = Posture::of(&self.shaper.joints(&params), &params.rotation());
        Sample { leans: upright.torso_deg > LEANING_DEG, params, family, pelvis, shape }
    }

    fn poses_around(&self, sample: &Sample, reach: Reach) -> Vec<Pose<'a>> {
        let at = flat(sample.pelvis);
        let mut poses = Vec::new();
        for (radius_m, count) in RINGS {
            for i in 0..count {
                let angle = std::f32::consts::TAU * i as f32 / count as f32;
                for yaw_deg in TURNS {
                    let moving = reach.price() * (radius_m / MOVE_M + yaw_deg.abs() / TURN_DEG);
                    let pelvis = at + Vec2::from_angle(angle) * radius_m;
                    poses.push(Pose { pelvis, yaw_deg, moving, place: None });
                }
            }
        }
        poses
    }

    /// The room's own places for the sample's group.
    fn poses_at_places(&self, sample: &Sample, reach: Reach) -> Vec<Pose<'a>> {
        let group = sample.family.group();
        let lies = group == "lie";
        let front = flat(sample.params.rotation() * if lies { Vec3::Y } else { Vec3::Z });
        let straight = |f: PoseFamily| f == PoseFamily::SitStraight;
        let fits = |p: &&Place| p.family.group() == group && straight(p.family) == straight(sample.family);
        let pose = |place: &'a Place, shift: (f32, f32)| {
            let ahead = place.facing * shift.0 + place.facing.perp() * shift.1;
            let pelvis = flat(place.under_pelvis) + ahead;
            let yaw_deg = yaw_between(front, place.facing);
            let apart_m = flat(sample.pelvis).distance(pelvis);
            let less_inviting = 0.3 * (1.0 - place.weight.min(1.0));
            let moving = reach.price() * (apart_m / MOVE_M + yaw_deg.abs() / TURN_DEG) + less_inviting;
            Pose { pelvis, yaw_deg, moving, place: Some(place) }
        };
        let near = |p: &Place| flat(sample.pelvis).distance(flat(p.under_pelvis)) < FINE_M;
        let shifts = |p: &Place| if near(p) { SHIFTS_M.len() } else { 1 };
        let poses = |p: &'a Place| SHIFTS_M.into_iter().take(shifts(p)).map(move |s| (p, s));
        self.places.iter().filter(fits).flat_map(poses).map(|(place, shift)| pose(place, shift)).collect()
    }

    /// The best height at a position, if any costs less than `limit`.
    fn best_height(&self, sample: &Sample, shape: &Shape, pose: &Pose<'_>, limit: f32) -> Option<Start> {
        let mut best: Option<(f32, Vec3, Rest)> = None;
        for rest in self.rests(sample, pose) {
            for lift_m in LIFTS_M {
                let y = rest.height_m - shape.lowest_m + lift_m;
                let pelvis = Vec3::new(pose.pelvis.x, y, pose.pelvis.y);
                // Falling or rising is part of the move, though a body that hovers is expected to fall.
                let moving = pose.moving + rest.cost + 0.3 * (y - sample.pelvis.y).abs();
                let limit = best.map_or(limit, |(cost, ..)| cost).min(limit);
                if moving >= limit {
                    continue;
                }
                let cost = moving + shape.cost(&self.geometry.field, pelvis, limit - moving);
                if cost < limit {
                    best = Some((cost, pelvis, rest));
                }
            }
        }
        let (cost, pelvis, rest) = best?;
        Some(self.start(sample, pose, pelvis, rest, cost))
    }

    /// What there is to rest on at a position.
    fn rests(&self, sample: &Sample, pose: &Pose<'_>) -> Vec<Rest> {
        if let Some(place) = pose.place {
            return vec![Rest { height_m: place.under_pelvis.y, support: place.support, cost: 0.0 }];
        }
        let floor = self.geometry.floor.cell_at(pose.pelvis);
        let floor_m = floor.map(|cell| self.geometry.floor.height_m[cell]);
        let over_m = floor_m.unwrap_or(0.0);
        let on_floor =
            |cost: f32| floor_m.map(|height_m| Rest { height_m, support: None, cost }).into_iter().collect();
        let mut rests: Vec<Rest> = match sample.family.group() {
            "sit" if sample.family != PoseFamily::SitStraight => on_floor(FLOOR_SEAT),
            "sit" | "lie" => on_floor(FLOOR_BED),
            _ => return on_floor(0.0),
        };
        let lies = sample.family.group() == "lie";
        for (index, surface) in self.geometry.supports.iter().enumerate() {
            let near = surface.bounds.grown(0.03);
            let (low, high) = (flat(near.min), flat(near.max));
            if pose.pelvis.cmplt(low).any() || pose.pelvis.cmpgt(high).any() {
                continue;
            }
            let Some(height_m) = self.cells[index].height_at(pose.pelvis) else { continue };
            let range = if lies { BED_M } else { SEAT_M };
            if range.contains(&(height_m - over_m)) && (!lies || surface.area_m2 > LEAST_BED_M2) {
                let category = surface.object.and_then(|id| self.room.object(id)).map(|o| o.category);
                let meant = category.is_none_or(|c| c.is_seat());
                rests.push(Rest { height_m, support: Some(index), cost: if meant { 0.0 } else { NO_SEAT } });
            }
        }
        rests
    }

    fn start(&self, sample: &Sample, pose: &Pose<'_>, pelvis: Vec3, rest: Rest, cost: f32) -> Start {
        let mut params = sample.params.clone();
        params.set_rotation(&(Mat3::from_rotation_y(pose.yaw_deg.to_radians()) * params.rotation()));
        params.translation += pelvis - sample.pelvis;
        let group = sample.family.group();
        let (family, on) = match (pose.place, rest.support) {
            (Some(place), _) if group != "lie" => (place.family, place.on.clone()),
            (Some(place), _) => (sample.family, place.on.clone()),
            (None, Some(index)) => {
                let surface = &self.geometry.supports[index];
                let sits = group == "sit" && sample.family != PoseFamily::SitStraight;
                let family = if sits { seat_family(self.room, surface) } else { sample.family };
                (family, support_name(self.room, surface, if group == "lie" { "bed" } else { "seat" }))
            }
            (None, None) if sample.family == PoseFamily::SitChair => {
                (PoseFamily::SitEdge, "floor".to_owned())
            }
            (None, None) if group == "stand" && sample.leans => (PoseFamily::Lean, "floor".to_owned()),
            (None, None) => (sample.family, "floor".to_owned()),
        };
        Start { params, family, on, cost, spot: Spot { pelvis, yaw_deg: pose.yaw_deg } }
    }
}

/// The cheapest starts, none like a cheaper one or one that was tried.
fn distinct(mut found: Vec<Start>, count: usize, tried: &[Spot]) -> Vec<Start> {
    found.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let mut kept: Vec<Start> = Vec::new();
    for start in found {
        let alike = |spot: &Spot| spot.is_like(&start.spot);
        if kept.len() < count && !tried.iter().any(alike) && !kept.iter().any(|k| alike(&k.spot)) {
            kept.push(start);
        }
    }
    kept
}

/// Degrees about +Y that turn the horizontal direction `from` to `to`, in (-180, 180]; both as (x, z).
fn yaw_between(from: Vec2, to: Vec2) -> f32 {
    if from.length() < 1e-3 {
        return 0.0;
    }
    // About +Y an angle turns z towards x, so the (x, z) plane's own angle runs the other way.
    let turn = (from.to_angle() - to.to_angle()).to_degrees().rem_euclid(360.0);
    if turn > 180.0 { turn - 360.0 } else { turn }
}

fn flat(v: Vec3) -> Vec2 {
    Vec2::new(v.x, v.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_turn_between_two_directions_turns_one_into_the_other() {
        for (from, to) in [(Vec2::X, Vec2::Y), (Vec2::Y, Vec2::new(-0.6, 0.8)), (Vec2::X, Vec2::NEG_X)] {
            let turn = Mat3::from_rotation_y(yaw_between(from, to).to_radians());
            let turned = flat(turn * Vec3::new(from.x, 0.0, from.y));
            assert!(turned.abs_diff_eq(to, 1e-5), "{from} became {turned}, not {to}");
        }
    }
}
