//! Lines inside of a thing. What a line runs through is in the thing, which a ray tells sooner than two trees of triangles
//! do; what no line meets must still be looked at. Most of what lies about in a crowd is thin, like cutlery and boards,
//! and its lines meet whatever it would lie across.

use glam::{Affine3A, Vec2, Vec3};

use crate::math::Aabb;
use crate::scene::TriangleBvh;

/// Places along a line at which the middle of the material is sought.
const STEPS: usize = 24;
/// Thinner material gives no line: rounding would leave it.
const THINNEST_M: f32 = 0.000_8;
/// Rays start this far from a surface that they shall not meet.
const OFF_M: f32 = 1e-5;

/// Segments inside of a thing, in its frame.
#[derive(Clone, Debug, Default)]
pub struct Spine(Vec<[Vec3; 2]>);

impl Spine {
    /// Along both sides of the box in plan, through `middle`, in the middle of the lowest material; nothing where that is
    /// open or bends away.
    pub fn of(tree: &TriangleBvh, bounds: &Aabb, middle: Vec2) -> Self {
        let (low, size) = (bounds.min, bounds.size());
        let share = |i: usize| (i as f32 + 0.5) / STEPS as f32;
        let along_x = (0..STEPS).map(|i| Vec2::new(low.x + share(i) * size.x, middle.y));
        let along_z = (0..STEPS).map(|i| Vec2::new(middle.x, low.z + share(i) * size.z));
        let mut segments = Vec::new();
        for line in [along_x.collect::<Vec<_>>(), along_z.collect()] {
            let inner: Vec<Option<Vec3>> = line.into_iter().map(|at| inside(tree, bounds, at)).collect();
            join(tree, &inner, &mut segments);
        }
        Self(segments)
    }

    /// Whether a line meets a surface of `other`, whose frame is placed by `other_from_self`.
    pub fn pierces(&self, other: &TriangleBvh, other_from_self: &Affine3A) -> bool {
        self.0.iter().any(|[from, to]| {
            let from = other_from_self.transform_point3(*from);
            let way = other_from_self.transform_point3(*to) - from;
            let length_m = way.length();
            length_m > 0.0 && other.any_hit(from, way / length_m, length_m)
        })
    }
}

/// The middle of the lowest material at a place of the plan.
fn inside(tree: &TriangleBvh, bounds: &Aabb, at: Vec2) -> Option<Vec3> {
    let height_m = bounds.size().y + 0.02;
    let below = Vec3::new(at.x, bounds.min.y - 0.01, at.y);
    let underside = below + Vec3::Y * tree.cast(below, Vec3::Y, height_m)?.distance_m;
    let from = underside + Vec3::Y * OFF_M;
    let thick_m = tree.cast(from, Vec3::Y, height_m)?.distance_m;
    let point = from + Vec3::Y * 0.5 * thick_m;
    (thick_m > THINNEST_M && tree.is_inside(point)).then_some(point)
}

/// Joins neighbours by segments that stay inside, as long ones as can be.
fn join(tree: &TriangleBvh, inner: &[Option<Vec3>], segments: &mut Vec<[Vec3; 2]>) {
    let mut open: Option<[Vec3; 2]> = None;
    for point in inner {
        let Some(point) = point else {
            segments.extend(open.take().filter(|[a, b]| a != b));
            continue;
        };
        open = match open {
            None => Some([*point; 2]),
            Some([from, _]) if is_clear(tree, from, *point) => Some([from, *point]),
            Some([from, last]) => {
                segments.extend((from != last).then_some([from, last]));
                Some(if is_clear(tree, last, *point) { [last, *point] } else { [*point; 2] })
            }
        };
    }
    segments.extend(open.filter(|[a, b]| a != b));
}

fn is_clear(tree: &TriangleBvh, from: Vec3, to: Vec3) -> bool {
    let (way, length_m) = ((to - from).normalize_or(Vec3::X), from.distance(to));
    !tree.any_hit(from, way, length_m)
}

#[cfg(test)]
mod tests {
    use super::super::shape::Shape;
    use super::super::shape::tests::block_triangles;
    use super::*;

    #[test]
    fn a_knife_has_a_line_along_its_length_and_it_meets_what_lies_across() {
        let knife = Shape::new(block_triangles(Vec3::new(0.02, 0.003, 0.2)));
        assert_eq!(knife.spine.0.len(), 2, "one along, one across: {:?}", knife.spine);
        let box_ = Shape::new(block_triangles(Vec3::splat(0.06)));
        let at = |x: f32, y: f32| Affine3A::from_translation(Vec3::new(x, y, 0.05));
        assert!(knife.spine.pierces(&box_.tree, &at(0.02, 0.01)));
        assert!(!knife.spine.pierces(&box_.tree, &at(0.045, 0.01)), "beside");
        assert!(!knife.spine.pierces(&box_.tree, &at(0.02, 0.061)), "on top");
    }

    #[test]
    fn open_things_have_no_line_and_bent_ones_lines_that_stay_inside() {
        let sheet = block_triangles(Vec3::new(0.2, 0.01, 0.2));
        let lid: Vec<_> = sheet.iter().filter(|t| t.iter().any(|p| p.y > 0.005)).copied().collect();
        assert!(Shape::new(lid).spine.0.is_empty(), "nothing below: open");
        // Two blocks in a row, the second three centimetres higher.
        let higher = sheet.iter().map(|t| t.map(|p| p + Vec3::new(0.2, 0.03, 0.0)));
        let step = Shape::new(sheet.iter().copied().chain(higher).collect());
        assert!(!step.spine.0.is_empty());
        for [from, to] in &step.spine.0 {
            for share in [0.0, 0.3, 0.7, 1.0] {
                assert!(step.tree.is_inside(from.lerp(*to, share)), "{from} {to}");
            }
        }
    }
}
