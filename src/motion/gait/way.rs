//! The way of a leg as a curve by its length.

use glam::Vec3;

use super::figure::{ahead, wrap};
use crate::motion::leg::PathPoint;

/// The way: positions, headings and speeds by the length gone.
#[derive(Clone, Debug)]
pub(super) struct Way {
    points: Vec<PathPoint>,
    /// Length gone at each point, metres.
    along_m: Vec<f32>,
}

impl Way {
    pub(super) fn new(path: &[PathPoint]) -> Self {
        let mut points = path.to_vec();
        points.dedup_by(|b, a| a.at.distance(b.at) < 1e-4);
        let mut along_m = Vec::with_capacity(points.len());
        let mut gone = 0.0;
        for i in 0..points.len() {
            if i > 0 {
                gone += points[i].at.distance(points[i - 1].at);
                // Headings go on without a jump at half a turn.
                points[i].heading = points[i - 1].heading + wrap(points[i].heading - points[i - 1].heading);
            }
            along_m.push(gone);
        }
        Self { points, along_m }
    }

    pub(super) fn length(&self) -> f32 {
        self.along_m.last().copied().unwrap_or(0.0)
    }

    fn between(&self, along_m: f32) -> Option<(&PathPoint, &PathPoint, f32)> {
        let last = self.points.len().checked_sub(1)?;
        let i = self.along_m.partition_point(|a| *a <= along_m).clamp(1, last.max(1)) - 1;
        let j = (i + 1).min(last);
        let span = (self.along_m[j] - self.along_m[i]).max(1e-6);
        Some((&self.points[i], &self.points[j], ((along_m - self.along_m[i]) / span).clamp(0.0, 1.0)))
    }

    /// The point of the floor after so many metres; beyond the ends straight on.
    pub(super) fn at(&self, along_m: f32) -> Vec3 {
        let Some((a, b, share)) = self.between(along_m) else { return Vec3::ZERO };
        let beyond = along_m.min(0.0) + (along_m - self.length()).max(0.0);
        a.at.lerp(b.at, share) + ahead(self.heading(along_m)) * beyond
    }

    /// Which way it goes there, radians about +Y, without jumps.
    pub(super) fn heading(&self, along_m: f32) -> f32 {
        self.between(along_m).map_or(0.0, |(a, b, share)| a.heading + (b.heading - a.heading) * share)
    }

    /// The planner's speed there, metres per second.
    pub(super) fn speed(&self, along_m: f32) -> f32 {
        let hint = self
            .between(along_m)
            .map_or(0.0, |(a, b, share)| a.speed_m_per_s + (b.speed_m_per_s - a.speed_m_per_s) * share);
        if hint > 0.1 { hint } else { USUAL_M_PER_S }
    }

    /// The speed that takes as long over all of the way.
    pub(super) fn mean_speed(&self) -> f32 {
        let samples = 16;
        let at = |k: usize| self.length() * (k as f32 + 0.5) / samples as f32;
        samples as f32 / (0..samples).map(|k| 1.0 / self.speed(at(k))).sum::<f32>()
    }
}

/// Walking speed in rooms where nothing else is said, metres per second.
const USUAL_M_PER_S: f32 = 1.15;
