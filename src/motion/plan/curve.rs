//! From corners to a curve that people walk: rounded, evenly spaced, with headings and speeds.

use glam::{Vec2, Vec3};

use super::PlanConfig;
use super::ground::Ground;
use crate::motion::leg::PathPoint;
use crate::scene::{direction_of, facing_of};

/// Spacing of the curve's points, metres.
const SPACING_M: f32 = 0.05;
/// A corner is rounded from at most this far before it, metres.
const ROUND_M: f32 = 0.7;
/// Passes of smoothing; each spreads a bend by about one spacing.
const SMOOTH: usize = 24;
/// Headings are those of chords this many points to each side.
const CHORD: usize = 3;
/// People turn at most this fast while they walk on, radians per second.
const TURN_RATE: f32 = 1.6;
/// Side acceleration that people accept in a bend, metres per second squared.
const SIDEWAYS: f32 = 1.0;
/// Nobody walks slower than this in the middle of a way, metres per second.
const SLOWEST_M_PER_S: f32 = 0.5;
/// With this clearance nobody slows down, metres.
const ROOMY_M: f32 = 0.35;
/// On ways shorter than this nobody reaches the natural speed, metres.
const SHORT_M: f32 = 2.5;

/// The curve along `corners`, free wherever they are.
pub(super) fn walkable(ground: &Ground<'_>, corners: &[Vec2], config: &PlanConfig) -> Vec<PathPoint> {
    let mut points = resampled(&rounded(ground, corners));
    smooth(ground, &mut points);
    let points = resampled(&points);
    let heading = headings(&points);
    let length: f32 = points.windows(2).map(|p| p[0].distance(p[1])).sum();
    let top = config.speed_m_per_s * (0.55 + 0.45 * (length / SHORT_M).min(1.0));
    (0..points.len())
        .map(|i| {
            let clearance_m = ground.clearance_m(points[i]);
            let bend = curvature(&points, &heading, i);
            PathPoint {
                at: Vec3::new(points[i].x, ground.height_m(points[i]), points[i].y),
                heading: heading[i],
                clearance_m,
                speed_m_per_s: speed(top, bend, clearance_m),
            }
        })
        .collect()
}

/// Corners cut by parabolas that begin at most half the shorter side away.
fn rounded(ground: &Ground<'_>, corners: &[Vec2]) -> Vec<Vec2> {
    let mut points = vec![corners[0]];
    for i in 1..corners.len().saturating_sub(1) {
        let [before, corner, after] = [corners[i - 1], corners[i], corners[i + 1]];
        // The first and last side belong to one corner alone.
        let share = |end: bool| if end { 0.9 } else { 0.5 };
        let most = (share(i == 1) * before.distance(corner))
            .min(share(i + 2 == corners.len()) * corner.distance(after))
            .min(ROUND_M);
        points.extend(fillet(ground, before, corner, after, most));
    }
    if corners.len() > 1 {
        points.push(corners[corners.len() - 1]);
    }
    points
}

/// The largest free parabola around a corner.
fn fillet(ground: &Ground<'_>, before: Vec2, corner: Vec2, after: Vec2, most_m: f32) -> Vec<Vec2> {
    for part in [1.0, 0.75, 0.5, 0.3, 0.15] {
        let reach = part * most_m;
        let start = corner + (before - corner).normalize_or_zero() * reach;
        let end = corner + (after - corner).normalize_or_zero() * reach;
        let at = |t: f32| start.lerp(corner, t).lerp(corner.lerp(end, t), t);
        let curve: Vec<Vec2> = (0..=12).map(|k| at(k as f32 / 12.0)).collect();
        if curve.iter().all(|p| ground.is_free(*p)) {
            return curve;
        }
    }
    vec![corner]
}

/// The same line with points evenly spaced; a single point for a line without length.
fn resampled(line: &[Vec2]) -> Vec<Vec2> {
    let length: f32 = line.windows(2).map(|p| p[0].distance(p[1])).sum();
    if length < 0.5 * SPACING_M {
        return line.last().copied().into_iter().collect();
    }
    let steps = (length / SPACING_M).ceil().max(1.0) as usize;
    let mut points = Vec::with_capacity(steps + 1);
    let (mut segment, mut walked) = (0, 0.0);
    for k in 0..=steps {
        let target = length * k as f32 / steps as f32;
        loop {
            let side = line[segment].distance(line[segment + 1]);
            if walked + side >= target || segment + 2 >= line.len() {
                let share = if side > 0.0 { ((target - walked) / side).clamp(0.0, 1.0) } else { 1.0 };
                points.push(line[segment].lerp(line[segment + 1], share));
                break;
            }
            walked += side;
            segment += 1;
        }
    }
    points
}

/// Moves every inner point to the middle of its neighbours where that is free, some times over.
fn smooth(ground: &Ground<'_>, points: &mut [Vec2]) {
    for _ in 0..SMOOTH {
        for i in 1..points.len().saturating_sub(1) {
            let moved = 0.5 * points[i] + 0.25 * (points[i - 1] + points[i + 1]);
            if ground.clearance_m(moved) >= ground.least_m(moved).min(ground.clearance_m(points[i])) {
                points[i] = moved;
            }
        }
    }
}

fn headings(points: &[Vec2]) -> Vec<f32> {
    let last = points.len() - 1;
    let chord = |i: usize| points[(i + CHORD).min(last)] - points[i.saturating_sub(CHORD)];
    (0..points.len()).map(|i| facing_of(chord(i))).collect()
}

/// Turn per metre of way around point `i`, radians per metre.
fn curvature(points: &[Vec2], heading: &[f32], i: usize) -> f32 {
    let (a, b) = (i.saturating_sub(CHORD), (i + CHORD).min(points.len() - 1));
    let along: f32 = points[a..=b].windows(2).map(|p| p[0].distance(p[1])).sum();
    let turn = direction_of(heading[a]).angle_to(direction_of(heading[b]));
    if along > 0.0 { turn.abs() / along } else { 0.0 }
}

fn speed(top: f32, bend: f32, clearance_m: f32) -> f32 {
    let in_bend = (SIDEWAYS / bend.max(1e-3)).sqrt().min(TURN_RATE / bend.max(1e-3));
    let narrow = (clearance_m / ROOMY_M).clamp(0.6, 1.0);
    (top.min(in_bend) * narrow).max(SLOWEST_M_PER_S.min(top))
}
