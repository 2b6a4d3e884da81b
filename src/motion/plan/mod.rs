//! Planning: from what the user asked for to a route that can be walked, or to a reason why it can't.
//!
//! Walks on `scene::WalkableFloor` with room for the body, rounds corners to curves that people walk, puts sub-goals
//! in between at most two seconds of walking apart (LTM §3.1: short legs between known bodies), and finds where one
//! stands before a seat. Poses nobody and may not name seats, beds or how bodies get there: seated bodies come in.
//! Deterministic without any seed; what lies between two stations depends on these two alone.

mod approach;
mod blocked;
mod curve;
mod ground;
mod route;
mod split;
#[cfg(test)]
mod tests;

pub use approach::{Seated, Side, Stance, stances};
pub use blocked::Blocked;
pub use route::{Role, Route, Station, Stop, Unreachable, route};

use glam::{Vec2, Vec3};

use super::leg::PathPoint;
use crate::scene::{RoomGeometry, WalkableFloor};

/// What the planner holds walking people to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanConfig {
    /// Room on each side that people like to have when it costs no long way round, metres.
    pub comfort_m: f32,
    /// Half the width of somebody who walks straight on, metres.
    pub body_m: f32,
    /// Half of what somebody needs who turns a shoulder and squeezes through, metres.
    pub squeeze_m: f32,
    /// Natural walking speed, metres per second.
    pub speed_m_per_s: f32,
    /// Most walking time between two sub-goals, seconds.
    pub apart_s: f32,
    /// Length of a natural stride (two steps) at that speed, metres: between two moments of a walk at the same phase
    /// lies a whole number of these.
    pub stride_m: f32,
}

impl Default for PlanConfig {
    /// Half a shoulder's width with arms is 22 cm (`scene::Walker`); a turned chest 30 cm thick passes 32 cm. People
    /// indoors walk at about 1.2 m/s (Bohannon 1997: 1.27 to 1.46 m/s outdoors). LTM §4.1: clips of two seconds.
    fn default() -> Self {
        Self {
            comfort_m: 0.45,
            body_m: 0.22,
            squeeze_m: 0.155,
            speed_m_per_s: 1.2,
            apart_s: 2.0,
            stride_m: 1.3,
        }
    }
}

/// Somebody or something else that takes room on the floor for now: seen from above, a disc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Its middle (x, z), metres, world frame.
    pub at: Vec2,
    /// Its radius, metres.
    pub radius_m: f32,
}

/// Where a way begins or ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// The point (x, z), metres, world frame.
    pub at: Vec2,
    /// Which way it is walked through, radians about +Y; `None` where somebody stands still, who can turn.
    pub heading: Option<f32>,
    /// Whether it is right before furniture, which the knees may touch.
    pub beside: bool,
}

impl Spot {
    /// Somebody who stands on open floor.
    pub fn open(at: Vec3) -> Self {
        Self { at: flat(at), heading: None, beside: false }
    }
}

/// A way over the floor.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Way {
    /// Points at most 5 cm apart, ends included; a single point where there is nothing to walk.
    pub points: Vec<PathPoint>,
    /// Where it is so narrow that one squeezes through: the narrowest point and its clearance, metres.
    pub squeeze: Option<(Vec3, f32)>,
}

impl Way {
    /// Its length, metres.
    pub fn length_m(&self) -> f32 {
        self.points.windows(2).map(|p| p[0].at.distance(p[1].at)).sum()
    }
}

/// Plans ways in one room. Cheap to make.
#[derive(Clone, Copy, Debug)]
pub struct Planner<'a> {
    geometry: &'a RoomGeometry,
    /// What it holds people to.
    pub config: PlanConfig,
}

impl<'a> Planner<'a> {
    /// A planner for the room.
    pub fn new(geometry: &'a RoomGeometry, config: PlanConfig) -> Self {
        Self { geometry, config }
    }

    /// The room's floor.
    pub fn floor(&self) -> &'a WalkableFloor {
        &self.geometry.floor
    }

    /// The room.
    pub fn geometry(&self) -> &'a RoomGeometry {
        self.geometry
    }

    /// The way from one spot to another, clear of `others`: with room for the body, else, where there is no other
    /// way, squeezing through, which the way then says.
    ///
    /// # Errors
    /// [`Blocked`] says what is in the way.
    pub fn way(&self, from: &Spot, to: &Spot, others: &[Disc]) -> Result<Way, Blocked> {
        let mut narrow = None;
        for (least_m, squeezes) in [(self.config.body_m, false), (self.config.squeeze_m, true)] {
            let ground = ground::Ground::new(self, least_m, [from, to], others);
            self.fits(&ground, from, to)?;
            if let Some(corners) = ground.path(from, to) {
                let points = curve::walkable(&ground, &corners, &self.config);
                narrow = Some((points, squeezes));
                break;
            }
        }
        let Some((points, squeezes)) = narrow else { return Err(self.apart(from, to)) };
        let inner = points.iter().filter(|p| flat(p.at).distance(to.at) > APRON_M);
        let narrowest = inner
            .filter(|p| flat(p.at).distance(from.at) > APRON_M)
            .min_by(|a, b| a.clearance_m.total_cmp(&b.clearance_m));
        let squeeze = narrowest.filter(|_| squeezes).map(|p| (p.at, p.clearance_m));
        Ok(Way { points, squeeze })
    }

    /// Whether somebody can stand at both ends.
    fn fits(&self, ground: &ground::Ground<'_>, from: &Spot, to: &Spot) -> Result<(), Blocked> {
        for spot in [from, to] {
            if !ground.is_free(spot.at) {
                return Err(self.no_room(spot, ground.least_m(spot.at)));
            }
        }
        Ok(())
    }
}

/// Before a seat or bed the body's width need not be free up to this far from where one stands, metres.
const APRON_M: f32 = 0.55;

/// The horizontal part (x, z) of a point.
fn flat(p: Vec3) -> Vec2 {
    Vec2::new(p.x, p.z)
}
