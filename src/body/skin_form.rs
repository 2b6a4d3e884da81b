//! Sums of squares over the skin without going through the skin. Poses nothing and knows no room.
//!
//! A posed vertex is linear in the joints' skinning matrices, so the sum over vertices of the squared distance between
//! two poses of the same shape is a quadratic form of the difference of these matrices. Its coefficients are moments of
//! the rest shape, one 4x4 block for each pair of joints that share skin: some hundred blocks instead of ten thousand
//! vertices, and the same sum but for rounding.

use std::collections::BTreeMap;

use glam::{DMat4, DVec4, Mat3A, Mat4, Vec3A, Vec4};

use super::joints::JOINTS;
use super::subset::{self, LANES, VertexSubset};
use super::workspace::Workspace;

/// For each joint the three rows of `(rotation | translation)` that take a rest position to where that joint alone
/// would move it, metres; or what a function's slope by these numbers is.
#[derive(Clone, Debug, PartialEq)]
pub struct SkinMatrices([[Vec4; 3]; JOINTS]);

impl SkinMatrices {
    /// All zero.
    pub const ZERO: Self = Self([[Vec4::ZERO; 3]; JOINTS]);

    /// From a rotation and a translation of each joint.
    pub(super) fn from_joints(of: impl Fn(usize) -> (Mat3A, Vec3A)) -> Self {
        Self(std::array::from_fn(|j| {
            let (r, t) = of(j);
            std::array::from_fn(|row| Vec4::new(r.x_axis[row], r.y_axis[row], r.z_axis[row], t[row]))
        }))
    }

    /// These less `other`.
    #[must_use]
    pub fn less(&self, other: &Self) -> Self {
        Self(std::array::from_fn(|j| std::array::from_fn(|row| self.0[j][row] - other.0[j][row])))
    }

    /// The mean of the matrices of several poses; zero of none.
    pub fn mean<'a>(poses: impl Iterator<Item = &'a Self>) -> Self {
        let (mut sum, mut count) = (Self::ZERO, 0);
        for pose in poses {
            for (sum, rows) in sum.0.iter_mut().zip(&pose.0) {
                sum.iter_mut().zip(rows).for_each(|(s, row)| *s += *row);
            }
            count += 1;
        }
        let share = 1.0 / count.max(1) as f32;
        Self(sum.0.map(|rows| rows.map(|row| row * share)))
    }

    /// The part that belongs to a joint's rotation.
    pub(super) fn rotation(&self, joint: usize) -> Mat3A {
        let [x, y, z] = &self.0[joint];
        let column = |k: usize| Vec3A::new(x[k], y[k], z[k]);
        Mat3A::from_cols(column(0), column(1), column(2))
    }

    /// The part that belongs to a joint's translation.
    pub(super) fn translation(&self, joint: usize) -> Vec3A {
        let [x, y, z] = &self.0[joint];
        Vec3A::new(x.w, y.w, z.w)
    }
}

/// The weighted sum of squared distances of vertices between two poses, as a quadratic form.
#[derive(Clone, Debug)]
pub struct SkinForm {
    /// Moments of the skin that two joints share, each pair once, the smaller number first.
    blocks: Vec<(usize, usize, Mat4)>,
}

impl SkinForm {
    /// Of entries of a subset of one shape, each with its weight.
    pub fn new(subset: &VertexSubset, weighted: impl Iterator<Item = (usize, f32)>) -> Self {
        let mut blocks: BTreeMap<(usize, usize), DMat4> = BTreeMap::new();
        for (entry, weight) in weighted {
            let rest = subset::lane(&subset.template[entry / LANES], entry % LANES).as_dvec3();
            let influences = &subset.influences
                [subset.influence_start[entry] as usize..subset.influence_start[entry + 1] as usize];
            let y = DVec4::from((rest, 1.0));
            let outer = DMat4::from_cols(y * y.x, y * y.y, y * y.z, y);
            for (a, by_a) in influences {
                for (b, by_b) in influences.iter().filter(|(b, _)| a <= b) {
                    let share = f64::from(weight) * f64::from(*by_a) * f64::from(*by_b);
                    *blocks.entry((*a as usize, *b as usize)).or_insert(DMat4::ZERO) += outer * share;
                }
            }
        }
        Self { blocks: blocks.into_iter().map(|((a, b), block)| (a, b, block.as_mat4())).collect() }
    }

    /// `scale` times the sum for two poses whose matrices differ by `difference`; adds its slope by the matrices of the
    /// first of them to `slope`.
    pub fn add_square(&self, difference: &SkinMatrices, scale: f32, slope: &mut SkinMatrices) -> f32 {
        let mut sum = 0.0;
        for (a, b, block) in &self.blocks {
            for row in 0..3 {
                let (at_a, at_b) = (difference.0[*a][row], difference.0[*b][row]);
                let by_a = *block * at_b;
                slope.0[*a][row] += by_a * (2.0 * scale);
                if a == b {
                    sum += at_a.dot(by_a);
                } else {
                    sum += 2.0 * at_a.dot(by_a);
                    slope.0[*b][row] += *block * at_a * (2.0 * scale);
                }
            }
        }
        scale * sum
    }
}

impl Workspace {
    /// The skinning matrices of the last forward pass.
    pub fn skin_matrices(&self) -> SkinMatrices {
        SkinMatrices::from_joints(|j| self.skinning_of(j))
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::body::joints::BODY_JOINTS;
    use crate::body::{Body, Gradients, joints};
    use crate::scene::{BETAS, BodyParams, HANDS};

    fn posed(body: &Body, subset: &VertexSubset, betas: [f32; BETAS], turn: f32) -> Workspace {
        let params = BodyParams {
            betas,
            translation: Vec3::new(1.0, 0.9, -2.0) * (1.0 + turn),
            hands: [turn; HANDS],
            ..BodyParams::default()
        };
        let pose = std::array::from_fn(|j| Vec3::new(turn, 0.3 * turn, -turn) * (1.0 + j as f32).sin());
        debug_assert_eq!(pose.len(), BODY_JOINTS);
        let mut workspace = Workspace::default();
        body.forward_posed(&params, &pose, subset, &mut workspace);
        workspace
    }

    /// The sum and its gradient, once vertex by vertex and once by the form.
    #[test]
    fn the_form_is_the_sum_over_the_vertices_and_has_its_gradient() {
        let body = Body::bundled();
        let betas: [f32; BETAS] = std::array::from_fn(|i| 0.5 * (i as f32 * 2.1).cos());
        let subset = VertexSubset::all_of_shape(&body.model, &betas);
        let (a, b) = (posed(body, &subset, betas, 0.35), posed(body, &subset, betas, 0.31));
        let weight = |v: usize| if v.is_multiple_of(3) { 2e-4 } else { 1e-4 };
        let offsets: Vec<Vec3> = a.vertices().iter().zip(b.vertices()).map(|(a, b)| *a - *b).collect();
        let by_vertices: f64 =
            offsets.iter().enumerate().map(|(v, o)| f64::from(weight(v) * o.length_squared())).sum();
        let slopes: Vec<Vec3> = offsets.iter().enumerate().map(|(v, o)| *o * (2.0 * weight(v))).collect();
        let expected =
            body.backward_posed(&subset, &Gradients::of_vertices(&slopes), &SkinMatrices::ZERO, &a);

        let form = SkinForm::new(&subset, (0..subset.len()).map(|v| (v, weight(v))));
        let mut slope = SkinMatrices::ZERO;
        let difference = a.skin_matrices().less(&b.skin_matrices());
        let by_form = f64::from(form.add_square(&difference, 1.0, &mut slope));
        assert!(by_vertices > 1e-3, "{by_vertices}: the poses differ");
        assert!((by_form / by_vertices - 1.0).abs() < 1e-4, "{by_form} against {by_vertices}");
        let found = body.backward_posed(&subset, &Gradients::of_vertices(&[]), &slope, &a);
        let norm = expected.pose.iter().map(|g| g.length_squared()).sum::<f32>().sqrt();
        let error = |j: usize| found.pose[j].distance(expected.pose[j]);
        assert!((0..BODY_JOINTS).all(|j| error(j) < 1e-3 * norm), "{:?}", error(joints::LEFT_HIP - 1));
        assert!(found.translation.distance(expected.translation) < 1e-3 * expected.translation.length());
    }

    #[test]
    fn the_mean_of_two_poses_lies_between_their_vertices() {
        let body = Body::bundled();
        let betas = [0.0; BETAS];
        let subset = VertexSubset::all_of_shape(&body.model, &betas);
        let (a, b) = (posed(body, &subset, betas, 0.2), posed(body, &subset, betas, -0.2));
        let (of_a, of_b) = (a.skin_matrices(), b.skin_matrices());
        let mean = SkinMatrices::mean([&of_a, &of_b].into_iter());
        let form = SkinForm::new(&subset, [(4_000, 1.0)].into_iter());
        let halfway = (a.vertices()[4_000] + b.vertices()[4_000]) * 0.5;
        let expected = a.vertices()[4_000].distance_squared(halfway);
        let found = form.add_square(&of_a.less(&mean), 1.0, &mut SkinMatrices::ZERO.clone());
        assert!((found / expected - 1.0).abs() < 1e-3, "{found} against {expected}");
    }
}
