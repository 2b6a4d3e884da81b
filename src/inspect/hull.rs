//! Whether a body's weight stands over what holds it: a point against the convex hull of contact points.

use glam::Vec2;

/// Distance in metres from `point` to the convex hull of `points`; 0 inside, infinite without points.
pub fn distance_to_hull(points: &[Vec2], point: Vec2) -> f32 {
    let hull = convex_hull(points);
    match hull.len() {
        0 => f32::INFINITY,
        1 => hull[0].distance(point),
        _ => {
            let edges = (0..hull.len()).map(|i| (hull[i], hull[(i + 1) % hull.len()]));
            let inside = hull.len() > 2 && edges.clone().all(|(a, b)| (b - a).perp_dot(point - a) >= 0.0);
            if inside {
                0.0
            } else {
                edges.map(|(a, b)| to_segment(a, b, point)).fold(f32::INFINITY, f32::min)
            }
        }
    }
}

fn to_segment(a: Vec2, b: Vec2, point: Vec2) -> f32 {
    let along = b - a;
    let t = (point - a).dot(along) / along.length_squared().max(1e-12);
    (a + along * t.clamp(0.0, 1.0)).distance(point)
}

/// Andrew's monotone chain, counter-clockwise, without collinear points.
pub fn convex_hull(points: &[Vec2]) -> Vec<Vec2> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    sorted.dedup();
    if sorted.len() < 3 {
        return sorted;
    }
    let half = |points: &mut dyn Iterator<Item = Vec2>| {
        let mut chain: Vec<Vec2> = Vec::new();
        for p in points {
            while chain.len() >= 2 {
                let (a, b) = (chain[chain.len() - 2], chain[chain.len() - 1]);
                if (b - a).perp_dot(p - a) > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut hull = half(&mut sorted.iter().copied());
    hull.extend(half(&mut sorted.iter().rev().copied()));
    hull
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_over_the_feet_is_inside_and_one_beside_them_is_as_far_as_measured() {
        let square = [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE, Vec2::splat(0.5)];
        assert_eq!(distance_to_hull(&square, Vec2::splat(0.3)), 0.0);
        assert!((distance_to_hull(&square, Vec2::new(1.5, 0.5)) - 0.5).abs() < 1e-6);
        assert!((distance_to_hull(&square, Vec2::new(2.0, 2.0)) - 2f32.sqrt()).abs() < 1e-6);
    }

    #[test]
    fn one_or_two_points_hold_only_what_is_right_over_them() {
        assert_eq!(distance_to_hull(&[], Vec2::ZERO), f32::INFINITY);
        assert_eq!(distance_to_hull(&[Vec2::X], Vec2::ZERO), 1.0);
        assert!((distance_to_hull(&[Vec2::X, Vec2::Y], Vec2::ZERO) - 0.5f32.sqrt()).abs() < 1e-6);
    }
}
