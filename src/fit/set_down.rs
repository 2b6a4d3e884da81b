//! The last step of our fitter: with every vertex of the mesh, the body is lifted or lowered until it just
//! touches. Descent works on a sample of the skin and leaves it a few millimetres off.

use glam::Vec3;

use crate::body::{Body, Workspace};
use crate::scene::{BodyParams, SignedDistanceField};

/// Farthest that the body is moved: more than that is no last step.
const REACH_M: f32 = 0.02;
/// Halvings of the reach: to a tenth of a millimetre.
const HALVINGS: usize = 8;
/// Skin that may be in the surface afterwards, as a share of the vertices: a few, so that the body touches by
/// every definition, PSI's own included.
const TOUCHING: f32 = 0.002;

/// Moves `params` vertically so that about [`TOUCHING`] of the skin lies in something solid, where that is
/// within reach: to less by lifting, to more by lowering.
pub fn set_down(
    body: &Body,
    field: &SignedDistanceField,
    params: &mut BodyParams,
    workspace: &mut Workspace,
) {
    body.forward(params, body.all_vertices(), workspace);
    let vertices = workspace.vertices();
    let most = (TOUCHING * vertices.len() as f32) as usize;
    let penetrating =
        |lift_m: f32| vertices.iter().filter(|v| field.sample(**v + Vec3::Y * lift_m) <= 0.0).count();
    let sinks = |lift_m: f32| penetrating(lift_m) > most;
    let (mut low, mut high) = if sinks(0.0) { (0.0, REACH_M) } else { (-REACH_M, 0.0) };
    if sinks(high) || !sinks(low) {
        // Lifting does not help (something above or beside holds it) or nothing is below: leave it.
        return;
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if sinks(middle) { low = middle } else { high = middle }
    }
    params.translation.y += high;
}
