//! What the baseline's discriminator sees of a body: its vertices projected into the picture (PSI §4.1.2).

use glam::Vec3;

use crate::body::{Body, Gradients, VertexSubset, Workspace};
use crate::nn::psi::{DISCRIMINATOR_VERTICES, GAP_M, IMAGE, SceneInput, VERTEX_FEATURES};
use crate::scene::{BodyParams, PARAMS};

/// A vertex this near to the camera's plane is treated as if it were this far, in metres.
const NEAREST_M: f32 = 0.1;
/// Normalised image coordinates beyond this say nothing more.
const FAR_OUT: f32 = 3.0;

/// The vertices that are projected.
pub struct Projector {
    subset: VertexSubset,
}

impl Projector {
    /// Evenly chosen vertices of the whole body.
    pub fn new(body: &Body) -> Self {
        let all = body.model.template.len();
        let ids = (0..DISCRIMINATOR_VERTICES).map(|i| (i * all / DISCRIMINATOR_VERTICES) as u32).collect();
        Self { subset: VertexSubset::new(&body.model, ids) }
    }

    /// The features of a body in the camera's frame, [`VERTEX_FEATURES`] for each vertex.
    pub fn features(&self, body: &Body, scene: &SceneInput, in_camera: &[f32; PARAMS]) -> Vec<f32> {
        let mut workspace = Workspace::default();
        body.forward(&BodyParams::from_vector(in_camera), &self.subset, &mut workspace);
        workspace.vertices().iter().flat_map(|v| Projected::new(scene, *v).features()).collect()
    }

    /// Gradient with respect to the body's numbers, given that of its features.
    pub fn pull_back(
        &self,
        body: &Body,
        scene: &SceneInput,
        in_camera: &[f32; PARAMS],
        gradient: &[f32],
    ) -> [f32; PARAMS] {
        let mut workspace = Workspace::default();
        body.forward(&BodyParams::from_vector(in_camera), &self.subset, &mut workspace);
        let rows = gradient.chunks(VERTEX_FEATURES);
        let pulls: Vec<Vec3> = workspace
            .vertices()
            .iter()
            .zip(rows)
            .map(|(v, row)| Projected::new(scene, *v).pull_back(scene, row))
            .collect();
        body.backward(&self.subset, &Gradients::of_vertices(&pulls), &mut workspace)
    }
}

/// One vertex in the picture.
struct Projected {
    at: Vec3,
    z: f32,
    u: f32,
    v: f32,
    depth: f32,
    gap_m: f32,
}

impl Projected {
    fn new(scene: &SceneInput, at: Vec3) -> Self {
        let z = at.z.max(NEAREST_M);
        let (u, v) = (scene.focal * at.x / z, scene.focal * at.y / z);
        let gap_m = scene_depth(scene, u, v).map_or(GAP_M, |d| d - z);
        Self { at, z, u, v, depth: 2.0 * z / scene.max_depth_m - 1.0, gap_m }
    }

    fn features(&self) -> [f32; VERTEX_FEATURES] {
        let inside = |x: f32| x.clamp(-FAR_OUT, FAR_OUT);
        [inside(self.u), inside(self.v), self.depth, self.gap_m.clamp(-GAP_M, GAP_M)]
    }

    fn pull_back(&self, scene: &SceneInput, row: &[f32]) -> Vec3 {
        let counts = |x: f32, limit: f32| if x.abs() < limit { 1.0 } else { 0.0 };
        let (du, dv) = (row[0] * counts(self.u, FAR_OUT), row[1] * counts(self.v, FAR_OUT));
        let per_m = scene.focal / self.z;
        let moves = if self.at.z > NEAREST_M { 1.0 } else { 0.0 };
        let along = -(du * self.u + dv * self.v) / self.z + row[2] * 2.0 / scene.max_depth_m
            - row[3] * counts(self.gap_m, GAP_M);
        Vec3::new(du * per_m, dv * per_m, along * moves)
    }
}

/// Depth of the scene at normalised image coordinates; `None` outside the picture and where nothing is.
fn scene_depth(scene: &SceneInput, u: f32, v: f32) -> Option<f32> {
    let pixel = |x: f32| (x + 1.0) * 0.5 * IMAGE as f32;
    let (x, y) = (pixel(u), pixel(v));
    let inside = |p: f32| (0.0..IMAGE as f32).contains(&p);
    if !inside(x) || !inside(y) {
        return None;
    }
    let at = y as usize * IMAGE + x as usize;
    (scene.valid.contains(at) && scene.depth_m[at] > 0.0).then_some(scene.depth_m[at])
}
