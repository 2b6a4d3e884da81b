//! L_HS: contact (eq. 7) and collision (eq. 6) of the bodies that a network gives, and the gradient with
//! respect to their 75 numbers in the camera's frame, by the hand-derived body.

use glam::{Affine3A, Vec3};

use crate::body::{Body, Gradients, VertexSubset, Workspace};
use crate::fit::{Distances, Energy, Term, psi_collision, psi_contact};
use crate::scene::{BodyParams, PARAMS, SignedDistanceField};

/// Of the vertices that can't touch by intention every so-many-th counts for collision.
const STRIDE: u32 = 6;

/// The terms of one body, weighted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneLossValue {
    /// Eq. 7, weighted.
    pub contact: f32,
    /// Eq. 6, weighted.
    pub collision: f32,
    /// Gradient of their sum.
    pub gradient: [f32; PARAMS],
}

/// What L_HS needs once for all bodies.
pub struct SceneLoss {
    subset: VertexSubset,
    contact: Vec<u32>,
    contact_weight: f32,
    collision_weight: f32,
    robust_c_m: f32,
}

impl SceneLoss {
    /// With the weights of eq. 1 and c of the robust distance.
    pub fn new(body: &Body, contact_weight: f32, collision_weight: f32, robust_c_m: f32) -> Self {
        let mut ids = body.regions.prox_sample();
        ids.sort_unstable();
        ids.dedup();
        let contact = (0..ids.len() as u32).collect();
        let vertices = body.model.template.len() as u32;
        ids.extend(
            (0..vertices)
                .step_by(STRIDE as usize)
                .filter(|v| ids.binary_search(v).is_err())
                .collect::<Vec<_>>(),
        );
        let subset = VertexSubset::new(&body.model, ids);
        Self { subset, contact, contact_weight, collision_weight, robust_c_m }
    }

    /// The terms of a body in the frame of a camera that may be a mirrored one.
    pub fn evaluate(
        &self,
        body: &Body,
        field: &SignedDistanceField,
        world_from_camera: &Affine3A,
        in_camera: &[f32; PARAMS],
        workspace: &mut Workspace,
    ) -> SceneLossValue {
        body.forward(&BodyParams::from_vector(in_camera), &self.subset, workspace);
        let (value, gradient): (Vec<f32>, Vec<Vec3>) = workspace
            .vertices()
            .iter()
            .map(|v| field.sample_gradient(world_from_camera.transform_point3(*v)))
            .unzip();
        let distances = Distances { value, gradient };
        let mut energy = Energy::new(self.subset.len());
        psi_contact(&mut energy, &self.contact, &distances, self.robust_c_m, self.contact_weight);
        psi_collision(&mut energy, &distances, self.collision_weight);
        let camera_from_world = world_from_camera.matrix3.transpose();
        let pulls: Vec<Vec3> = energy.vertices.iter().map(|g| camera_from_world * *g).collect();
        SceneLossValue {
            contact: energy.terms[Term::Contact as usize],
            collision: energy.terms[Term::Collision as usize],
            gradient: body.backward(&self.subset, &Gradients::of_vertices(&pulls), workspace),
        }
    }
}
