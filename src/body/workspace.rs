//! Forward pass and hand-derived gradient of the body, without allocation once a workspace has grown.
//!
//! With rest joints `J`, local rotations `L` and parents `p` (root: `p` is the world):
//! `R_j = R_p L_j`, `P_j = P_p + R_p (J_j - J_p)`, `T_j = P_j - R_j J_j`, and a vertex at rest position `x`
//! goes to `Σ_k w_k (R_k x + T_k)` (linear blend skinning; Loper et al. 2015, SMPL, eq. 2-4 without pose
//! correctives).

use glam::{Mat3, Mat3A, Vec3, Vec3A};

use crate::math::rotation;
use crate::scene::{BETAS, BodyParams, HANDS, PARAMS, POSE};

use super::hand_space::HAND_JOINTS;
use super::joints::{BODY_JOINTS, JOINTS, LEFT_HAND, PARENTS, RIGHT_HAND};
use super::pose_space::{BodyPose, PoseTape};
use super::posed::Body;
use super::skin_form::SkinMatrices;
use super::subset::{self, BLOCK, Block, LANES, VertexSubset};

/// Scratch memory of one thread, and the result of its last forward pass.
#[derive(Clone, Debug)]
pub struct Workspace {
    params: BodyParams,
    tape: PoseTape,
    vertices: Vec<Vec3>,
    joints: [Vec3; JOINTS],
    local_pose: [Vec3; JOINTS],
    rest_vertices: Vec<Block>,
    rest_gradient: Vec<Block>,
    rest_joints: [Vec3; JOINTS],
    local: [Mat3; JOINTS],
    world: [Mat3; JOINTS],
    skinning: [Affine; JOINTS],
}

/// A rotation, its transpose and a translation, in SIMD registers.
#[derive(Clone, Copy, Debug)]
struct Affine {
    rotation: Mat3A,
    transposed: Mat3A,
    translation: Vec3A,
}

/// What a function of the body says about its inputs: `df/dvertex` (one per vertex of the subset, or
/// empty), `df/djoint`, and `df/d(local axis-angle)` of every joint (for joint limits and priors; the root's
/// is ignored, for the root is 6-D).
#[derive(Clone, Copy, Debug)]
pub struct Gradients<'a> {
    /// Per vertex of the subset, in its order; empty means zero.
    pub vertices: &'a [Vec3],
    /// Per joint.
    pub joints: &'a [Vec3; JOINTS],
    /// Per local axis-angle.
    pub local_pose: &'a [Vec3; JOINTS],
}

/// Gradient with respect to the numbers of a body that was posed by joint rotations
/// ([`Body::forward_posed`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PosedGradient {
    /// By the translation.
    pub translation: Vec3,
    /// By the root's world-from-body matrix, entry by entry, columns as glam stores them.
    pub rotation: Mat3,
    /// By the axis-angles of joints 1 to 21.
    pub pose: BodyPose,
    /// By the hand codes.
    pub hands: [f32; HANDS],
}

/// No gradient on joints or local poses.
pub(super) const ZERO_JOINTS: [Vec3; JOINTS] = [Vec3::ZERO; JOINTS];

impl<'a> Gradients<'a> {
    /// Of a function of the vertices alone.
    pub fn of_vertices(vertices: &'a [Vec3]) -> Self {
        Self { vertices, joints: &ZERO_JOINTS, local_pose: &ZERO_JOINTS }
    }
}

impl Default for Workspace {
    fn default() -> Self {
        let affine =
            Affine { rotation: Mat3A::IDENTITY, transposed: Mat3A::IDENTITY, translation: Vec3A::ZERO };
        Self {
            params: BodyParams::default(),
            tape: PoseTape::default(),
            vertices: Vec::new(),
            joints: ZERO_JOINTS,
            local_pose: ZERO_JOINTS,
            rest_vertices: Vec::new(),
            rest_gradient: Vec::new(),
            rest_joints: ZERO_JOINTS,
            local: [Mat3::IDENTITY; JOINTS],
            world: [Mat3::IDENTITY; JOINTS],
            skinning: [affine; JOINTS],
        }
    }
}

impl Workspace {
    /// Vertices of the last forward pass, world frame, in the subset's order.
    pub fn vertices(&self) -> &[Vec3] {
        &self.vertices
    }

    /// Joints of the last forward pass, world frame.
    pub fn joints(&self) -> &[Vec3; JOINTS] {
        &self.joints
    }

    /// Axis-angles of every joint in its parent's frame; the root's is zero (its rotation is 6-D).
    pub fn local_pose(&self) -> &[Vec3; JOINTS] {
        &self.local_pose
    }

    /// World rotation of every joint: world from the joint's rest frame.
    pub fn world_rotations(&self) -> &[Mat3; JOINTS] {
        &self.world
    }

    pub(super) fn into_parts(self) -> (Vec<Vec3>, [Vec3; JOINTS], [Mat3; JOINTS]) {
        (self.vertices, self.joints, self.world)
    }

    fn move_joints(&mut self) {
        self.world[0] = self.local[0];
        self.joints[0] = self.rest_joints[0] + self.params.translation;
        for j in 1..JOINTS {
            let p = PARENTS[j];
            self.world[j] = self.world[p] * self.local[j];
            self.joints[j] = self.joints[p] + self.world[p] * (self.rest_joints[j] - self.rest_joints[p]);
        }
        for j in 0..JOINTS {
            let translation = self.joints[j] - self.world[j] * self.rest_joints[j];
            let rotation = Mat3A::from(self.world[j]);
            self.skinning[j] =
                Affine { rotation, transposed: rotation.transpose(), translation: translation.into() };
        }
    }

    /// A joint's skinning rotation and translation of the last forward pass.
    pub(super) fn skinning_of(&self, joint: usize) -> (Mat3A, Vec3A) {
        let Affine { rotation, translation, .. } = self.skinning[joint];
        (rotation, translation)
    }

    /// The rest vertices of the last forward pass; a subset of one shape has its shape in the template already.
    fn rest<'a>(&'a self, subset: &'a VertexSubset) -> &'a [Block] {
        if subset.shape_dirs.is_empty() { &subset.template } else { &self.rest_vertices }
    }

    fn shape_vertices(&mut self, subset: &VertexSubset) {
        if subset.shape_dirs.is_empty() {
            return;
        }
        let betas = &self.params.betas;
        self.rest_vertices.resize(subset.template.len(), [0.0; BLOCK]);
        for (i, rest) in self.rest_vertices.iter_mut().enumerate() {
            *rest = subset.template[i];
            for (dir, beta) in subset.shape_dirs[i].iter().zip(betas) {
                for (x, d) in rest.iter_mut().zip(dir) {
                    *x += d * beta;
                }
            }
        }
    }

    fn skin_vertices(&mut self, subset: &VertexSubset) {
        let mut vertices = std::mem::take(&mut self.vertices);
        vertices.resize(subset.len(), Vec3::ZERO);
        let blocks = self.rest(subset);
        for (i, vertex) in vertices.iter_mut().enumerate() {
            let rest = subset::lane(&blocks[i / LANES], i % LANES);
            let mut moved = Vec3A::ZERO;
            let (start, end) = (subset.influence_start[i] as usize, subset.influence_start[i + 1] as usize);
            for (joint, weight) in &subset.influences[start..end] {
                let Affine { rotation: r, translation, .. } = &self.skinning[*joint as usize];
                let by_joint = r.x_axis * rest.x + r.y_axis * rest.y + r.z_axis * rest.z + *translation;
                moved += by_joint * *weight;
            }
            *vertex = moved.into();
        }
        self.vertices = vertices;
    }
}

/// Gradients at the joints, gathered from the vertices and then passed up the tree.
struct JointGradients {
    rotation: [Mat3; JOINTS],
    position: [Vec3; JOINTS],
    rest: [Vec3; JOINTS],
}

impl Body {
    /// Poses the vertices of `subset` and all joints; results stay in `workspace`.
    pub fn forward(&self, params: &BodyParams, subset: &VertexSubset, workspace: &mut Workspace) {
        self.forward_joints(params, workspace);
        workspace.shape_vertices(subset);
        workspace.skin_vertices(subset);
    }

    /// Poses the joints alone: a few microseconds.
    pub fn forward_joints(&self, params: &BodyParams, workspace: &mut Workspace) {
        let pose = self.pose_space.decode_taped(&params.pose, &mut workspace.tape);
        self.forward_axis_angles(params, &pose, workspace);
    }

    /// The 55 joints of a body, metres, world frame; where many are asked for, keep a workspace and call
    /// [`Body::forward_joints`].
    pub fn joints(&self, params: &BodyParams) -> [Vec3; JOINTS] {
        let mut workspace = Workspace::default();
        self.forward_joints(params, &mut workspace);
        *workspace.joints()
    }

    /// Poses the joints with these axis-angles of the body joints in place of the pose code.
    fn forward_axis_angles(&self, params: &BodyParams, pose: &BodyPose, workspace: &mut Workspace) {
        let ws = workspace;
        ws.params.clone_from(params);
        ws.rest_joints = self.model.rest_joints(&params.betas);
        ws.local_pose[1..=BODY_JOINTS].copy_from_slice(pose);
        let [left, right] = self.hand_space.decode(&params.hands);
        ws.local_pose[LEFT_HAND..RIGHT_HAND].copy_from_slice(&left);
        ws.local_pose[RIGHT_HAND..].copy_from_slice(&right);
        ws.local[0] = params.rotation();
        for j in 1..JOINTS {
            ws.local[j] = rotation::matrix_from_axis_angle(ws.local_pose[j]);
        }
        ws.move_joints();
    }

    /// As [`Body::forward`] with these axis-angles of the body joints in place of the pose code: for captured poses.
    /// Its gradient comes from [`Body::backward_posed`].
    pub fn forward_posed(
        &self,
        params: &BodyParams,
        pose: &BodyPose,
        subset: &VertexSubset,
        workspace: &mut Workspace,
    ) {
        self.forward_axis_angles(params, pose, workspace);
        workspace.shape_vertices(subset);
        workspace.skin_vertices(subset);
    }

    /// Gradient with respect to the 75 numbers of a function of the last forward pass's vertices, joints and
    /// local axis-angles. `subset` must be the one of the forward pass.
    pub fn backward(
        &self,
        subset: &VertexSubset,
        gradients: &Gradients<'_>,
        workspace: &mut Workspace,
    ) -> [f32; PARAMS] {
        let mut rest = std::mem::take(&mut workspace.rest_gradient);
        let (joints, local) =
            gradient_of_joints(subset, gradients, &SkinMatrices::ZERO, workspace, Some(&mut rest));
        workspace.rest_gradient = rest;
        let mut betas = [0.0; BETAS];
        if !gradients.vertices.is_empty() {
            betas = shape_gradient(subset, &workspace.rest_gradient);
        }
        for (b, beta) in betas.iter_mut().enumerate() {
            *beta += (0..JOINTS).map(|j| self.model.joint_dirs[j][b].dot(joints.rest[j])).sum::<f32>();
        }
        let params = &workspace.params;
        flatten(
            joints.position[0],
            rotation::pull_back_6d(&params.rotation6, &joints.rotation[0]),
            betas,
            self.pose_space.pull_back_taped(&params.pose, &workspace.tape, &body_part(&local)),
            self.hand_space.pull_back(&hand_part(&local)),
        )
    }

    /// Gradient with respect to place, rotation, joint rotations and hand codes of a function of what
    /// [`Body::forward_posed`] left in `workspace`; the shape stays. `skin` is the function's slope by the skinning
    /// matrices, beside that by vertices. Changes nothing in the workspace, so the frames of a sequence can read each
    /// other meanwhile.
    pub fn backward_posed(
        &self,
        subset: &VertexSubset,
        gradients: &Gradients<'_>,
        skin: &SkinMatrices,
        workspace: &Workspace,
    ) -> PosedGradient {
        let (joints, local) = gradient_of_joints(subset, gradients, skin, workspace, None);
        PosedGradient {
            translation: joints.position[0],
            rotation: joints.rotation[0],
            pose: body_part(&local),
            hands: self.hand_space.pull_back(&hand_part(&local)),
        }
    }
}

fn body_part(local: &[Vec3; JOINTS]) -> BodyPose {
    std::array::from_fn(|j| local[1 + j])
}

fn hand_part(local: &[Vec3; JOINTS]) -> [[Vec3; HAND_JOINTS]; 2] {
    [LEFT_HAND, RIGHT_HAND].map(|first| std::array::from_fn(|j| local[first + j]))
}

/// The gradient at every joint, passed up to the root, and that of the local axis-angles. `rest` receives that of
/// the rest vertices where the shape's gradient is asked for.
fn gradient_of_joints(
    subset: &VertexSubset,
    gradients: &Gradients<'_>,
    skin: &SkinMatrices,
    workspace: &Workspace,
    rest: Option<&mut Vec<Block>>,
) -> (JointGradients, [Vec3; JOINTS]) {
    let mut joints = gather_from_vertices(subset, gradients.vertices, skin, workspace, rest);
    for (position, given) in joints.position.iter_mut().zip(gradients.joints) {
        *position += *given;
    }
    let mut local = *gradients.local_pose;
    pass_up_the_tree(workspace, &mut joints, &mut local);
    (joints, local)
}

fn flatten(
    translation: Vec3,
    rotation6: [f32; 6],
    betas: [f32; BETAS],
    pose: [f32; POSE],
    hands: [f32; HANDS],
) -> [f32; PARAMS] {
    BodyParams { translation, rotation6, betas, pose, hands }.to_vector()
}

/// Skinning backwards: the gradient of each joint's `R`, `P`, `J`, starting from that of the skinning matrices, and in
/// `rest`, where it is asked for, that of the rest vertices.
fn gather_from_vertices(
    subset: &VertexSubset,
    vertices: &[Vec3],
    skin: &SkinMatrices,
    ws: &Workspace,
    mut rest: Option<&mut Vec<Block>>,
) -> JointGradients {
    let mut by_rotation: [Mat3A; JOINTS] = std::array::from_fn(|j| skin.rotation(j));
    let mut by_translation: [Vec3A; JOINTS] = std::array::from_fn(|j| skin.translation(j));
    let blocks = ws.rest(subset);
    if let Some(rest) = rest.as_deref_mut() {
        rest.resize(subset.template.len(), [0.0; BLOCK]);
    }
    for (i, gradient) in vertices.iter().enumerate() {
        let influences =
            &subset.influences[subset.influence_start[i] as usize..subset.influence_start[i + 1] as usize];
        if let Some(rest) = rest.as_deref_mut() {
            let at_rest = rest_gradient(influences, *gradient, ws);
            subset::set_lane(&mut rest[i / LANES], i % LANES, at_rest);
        }
        if *gradient == Vec3::ZERO {
            continue;
        }
        let at = subset::lane(&blocks[i / LANES], i % LANES);
        let g = Vec3A::from(*gradient);
        let (gx, gy, gz) = (g * at.x, g * at.y, g * at.z);
        for (joint, weight) in influences {
            let (j, w) = (*joint as usize, *weight);
            let sum = &mut by_rotation[j];
            sum.x_axis += gx * w;
            sum.y_axis += gy * w;
            sum.z_axis += gz * w;
            by_translation[j] += g * w;
        }
    }
    // T = P - R J
    let translation: [Vec3; JOINTS] = by_translation.map(Vec3::from);
    JointGradients {
        rotation: std::array::from_fn(|j| {
            Mat3::from(by_rotation[j]) - outer(translation[j], ws.rest_joints[j])
        }),
        position: translation,
        rest: std::array::from_fn(|j| -(ws.world[j].transpose() * translation[j])),
    }
}

/// The gradient of one rest vertex.
fn rest_gradient(influences: &[(u32, f32)], gradient: Vec3, ws: &Workspace) -> Vec3 {
    let mut at_rest = Vec3A::ZERO;
    if gradient != Vec3::ZERO {
        for (joint, weight) in influences {
            let rt = &ws.skinning[*joint as usize].transposed;
            at_rest += (rt.x_axis * gradient.x + rt.y_axis * gradient.y + rt.z_axis * gradient.z) * *weight;
        }
    }
    at_rest.into()
}

/// Kinematic chain backwards: adds to the local axis-angles' gradient and completes that of the rest joints and the
/// root.
fn pass_up_the_tree(ws: &Workspace, joints: &mut JointGradients, local: &mut [Vec3; JOINTS]) {
    for j in (1..JOINTS).rev() {
        let p = PARENTS[j];
        let offset = ws.rest_joints[j] - ws.rest_joints[p];
        let parent_from_world = ws.world[p].transpose();
        let at_position = joints.position[j];
        joints.position[p] += at_position;
        joints.rotation[p] += outer(at_position, offset);
        let at_offset = parent_from_world * at_position;
        joints.rest[j] += at_offset;
        joints.rest[p] -= at_offset;
        let at_rotation = joints.rotation[j];
        joints.rotation[p] += at_rotation * ws.local[j].transpose();
        let at_local = parent_from_world * at_rotation;
        local[j] += rotation::pull_back_axis_angle(ws.local_pose[j], &ws.local[j], &at_local);
    }
    joints.rest[0] += joints.position[0];
}

fn shape_gradient(subset: &VertexSubset, at_rest: &[Block]) -> [f32; BETAS] {
    let mut sums = [[0.0f32; BLOCK]; BETAS];
    // Most skin is neither in contact nor in anything: whole blocks of it say nothing.
    for (dirs, gradient) in subset.shape_dirs.iter().zip(at_rest).filter(|(_, g)| **g != [0.0; BLOCK]) {
        for (sum, dir) in sums.iter_mut().zip(dirs) {
            for ((s, d), g) in sum.iter_mut().zip(dir).zip(gradient) {
                *s += d * g;
            }
        }
    }
    sums.map(|lanes| lanes.iter().sum())
}

fn outer(column: Vec3, row: Vec3) -> Mat3 {
    Mat3::from_cols(column * row.x, column * row.y, column * row.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt as _, SeedableRng as _};
    use rand_chacha::ChaCha8Rng;

    fn random_body(rng: &mut ChaCha8Rng) -> BodyParams {
        let mut x: [f32; PARAMS] = std::array::from_fn(|_| rng.random_range(-1.0..1.0));
        x[3..9].iter_mut().for_each(|v| *v *= 1.2);
        BodyParams::from_vector(&x)
    }

    fn random_directions(rng: &mut ChaCha8Rng, count: usize) -> Vec<Vec3> {
        (0..count).map(|_| Vec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)))).collect()
    }

    /// A function that is not linear in anything the body moves, summed in f64.
    fn energy(ws: &Workspace, at: &[Vec3], joints_at: &[Vec3; JOINTS], local_at: &[Vec3; JOINTS]) -> f64 {
        let bowl = |x: &[Vec3], at: &[Vec3]| -> f64 {
            x.iter().zip(at).map(|(x, a)| 0.5 * f64::from((*x - *a).length_squared())).sum()
        };
        bowl(ws.vertices(), at) / 100.0
            + bowl(ws.joints(), joints_at)
            + bowl(&ws.local_pose()[1..], &local_at[1..])
    }

    #[test]
    fn every_one_of_the_75_gradients_agrees_with_finite_differences() {
        let body = Body::bundled();
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let subset =
            VertexSubset::new(&body.model, (0..body.model.template.len() as u32).step_by(37).collect());
        let mut ws = Workspace::default();
        for _ in 0..4 {
            let x = random_body(&mut rng).to_vector();
            let at = random_directions(&mut rng, subset.len());
            let joints_at: [Vec3; JOINTS] = std::array::from_fn(|_| random_directions(&mut rng, 1)[0]);
            let local_at: [Vec3; JOINTS] = std::array::from_fn(|_| random_directions(&mut rng, 1)[0]);
            body.forward(&BodyParams::from_vector(&x), &subset, &mut ws);
            let vertices: Vec<Vec3> = ws.vertices().iter().zip(&at).map(|(x, a)| (*x - *a) / 100.0).collect();
            let joints: [Vec3; JOINTS] = std::array::from_fn(|j| ws.joints()[j] - joints_at[j]);
            let local_pose: [Vec3; JOINTS] = std::array::from_fn(|j| ws.local_pose()[j] - local_at[j]);
            let gradients = Gradients { vertices: &vertices, joints: &joints, local_pose: &local_pose };
            let analytic = body.backward(&subset, &gradients, &mut ws);
            for i in 0..PARAMS {
                let mut side = |step: f32| {
                    let mut moved = x;
                    moved[i] += step;
                    body.forward(&BodyParams::from_vector(&moved), &subset, &mut ws);
                    energy(&ws, &at, &joints_at, &local_at)
                };
                // Five-point stencil: a long step drowns f32's rounding, the fourth order its curvature. The pose
                // space's slope has many small kinks that any step crosses, so its numbers are compared roughly
                // here; its decoder has an exact test of its own.
                let is_pose = (19..51).contains(&i);
                let (steps, tolerance) =
                    if is_pose { (&[0.01, 0.002][..], 5e-2) } else { (&[0.04][..], 2e-3) };
                let numeric: Vec<f64> = steps
                    .iter()
                    .map(|&h| {
                        let slope = 8.0 * (side(h) - side(-h)) - (side(2.0 * h) - side(-2.0 * h));
                        slope / (12.0 * f64::from(h))
                    })
                    .collect();
                let agrees = |n: &f64| (f64::from(analytic[i]) - n).abs() < tolerance * (1.0 + n.abs());
                assert!(numeric.iter().any(agrees), "[{i}]: {} against {numeric:?}", analytic[i]);
            }
        }
    }

    #[test]
    fn the_gradient_by_joint_rotations_agrees_with_finite_differences() {
        let body = Body::bundled();
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let betas: [f32; BETAS] = std::array::from_fn(|i| 0.4 * (i as f32 * 1.3).sin());
        let ids = (0..body.model.template.len() as u32).step_by(41).collect();
        let subset = VertexSubset::of_shape(&body.model, ids, &betas);
        let mut ws = Workspace::default();
        let params = BodyParams { betas, ..random_body(&mut rng) };
        let pose: BodyPose = std::array::from_fn(|_| random_directions(&mut rng, 1)[0]);
        let at = random_directions(&mut rng, subset.len());
        let joints_at: [Vec3; JOINTS] = std::array::from_fn(|_| random_directions(&mut rng, 1)[0]);
        body.forward_posed(&params, &pose, &subset, &mut ws);
        let vertices: Vec<Vec3> = ws.vertices().iter().zip(&at).map(|(x, a)| (*x - *a) / 100.0).collect();
        let joints: [Vec3; JOINTS] = std::array::from_fn(|j| ws.joints()[j] - joints_at[j]);
        let local_pose = *ws.local_pose();
        let gradients = Gradients { vertices: &vertices, joints: &joints, local_pose: &local_pose };
        let analytic = body.backward_posed(&subset, &gradients, &SkinMatrices::ZERO, &ws);
        let mut value = |params: &BodyParams, pose: &BodyPose| {
            body.forward_posed(params, pose, &subset, &mut ws);
            energy(&ws, &at, &joints_at, &ZERO_JOINTS)
        };
        let mut check = |what: &str, analytic: f32, moved: &dyn Fn(f32) -> (BodyParams, BodyPose)| {
            let mut side = |h: f32| {
                let (params, pose) = moved(h);
                value(&params, &pose)
            };
            let numeric = (8.0 * (side(0.04) - side(-0.04)) - (side(0.08) - side(-0.08))) / 0.48;
            let error = (f64::from(analytic) - numeric).abs();
            assert!(error < 3e-3 * (1.0 + numeric.abs()), "{what}: {analytic} against {numeric}");
        };
        let turned = |w: Vec3| rotation::matrix_from_axis_angle(w) * params.rotation();
        let still = analytic.rotation * params.rotation().transpose();
        let by_turn = rotation::pull_back_axis_angle(Vec3::ZERO, &Mat3::IDENTITY, &still);
        for (axis, unit) in Vec3::AXES.into_iter().enumerate() {
            check("translation", analytic.translation[axis], &|h| {
                (BodyParams { translation: params.translation + unit * h, ..params.clone() }, pose)
            });
            check("rotation", by_turn[axis], &|h| {
                let mut moved = params.clone();
                moved.set_rotation(&turned(unit * h));
                (moved, pose)
            });
            for joint in 0..BODY_JOINTS {
                check("pose", analytic.pose[joint][axis], &|h| {
                    let mut moved = pose;
                    moved[joint] += unit * h;
                    (params.clone(), moved)
                });
            }
        }
        for code in 0..HANDS {
            check("hands", analytic.hands[code], &|h| {
                let mut moved = params.clone();
                moved.hands[code] += h;
                (moved, pose)
            });
        }
    }

    #[test]
    fn a_subset_of_one_shape_is_posed_as_the_whole_body_of_that_shape() {
        let body = Body::bundled();
        let params = random_body(&mut ChaCha8Rng::seed_from_u64(5));
        let pose: BodyPose = [Vec3::new(0.1, -0.2, 0.3); BODY_JOINTS];
        let whole = body.pose_axis_angles(&params, &pose);
        let subset = VertexSubset::of_shape(&body.model, vec![12_000, 7, 3_977], &params.betas);
        let mut ws = Workspace::default();
        body.forward_posed(&params, &pose, &subset, &mut ws);
        for (vertex, id) in ws.vertices().iter().zip(subset.ids()) {
            assert!(vertex.distance(whole.vertices[*id as usize]) < 1e-5);
        }
    }

    #[test]
    fn a_subset_is_posed_as_the_whole_body_is() {
        let body = Body::bundled();
        let params = random_body(&mut ChaCha8Rng::seed_from_u64(3));
        let whole = body.pose(&params);
        let subset = VertexSubset::new(&body.model, vec![13_000, 5, 977]);
        let mut ws = Workspace::default();
        body.forward(&params, &subset, &mut ws);
        for (vertex, id) in ws.vertices().iter().zip(subset.ids()) {
            assert!(vertex.distance(whole.vertices[*id as usize]) < 1e-6);
        }
    }

    #[test]
    fn vertices_without_gradient_leave_nothing_behind_in_a_used_workspace() {
        let body = Body::bundled();
        let subset = VertexSubset::new(&body.model, (0..100).collect());
        let mut ws = Workspace::default();
        body.forward(&BodyParams::default(), &subset, &mut ws);
        body.backward(&subset, &Gradients::of_vertices(&[Vec3::ONE; 100]), &mut ws);
        let again = body.backward(&subset, &Gradients::of_vertices(&[Vec3::ZERO; 100]), &mut ws);
        assert_eq!(again, [0.0; PARAMS]);
    }
}
