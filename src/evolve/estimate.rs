//! A person of a photo in the room: keypoints, the camera that took it, and what people do in this scene.

use super::refine::family_of;
use crate::assets::PersonKeypoints;
use crate::body::Body;
use crate::fit::estimation::{EstimateConfig, EstimateTrace, Estimator, Pinhole};
use crate::generate::sensor::View;
use crate::inspect::{BodyReport, Finding, Limits, Site, inspect_body};
use crate::job::{JobCtx, Stop};
use crate::scene::{BodyParams, POSE, PoseFamily, RoomGeometry};

/// Which estimator (PSI table 5).
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum EstimatorKind {
    /// Keypoints and priors alone: knows no room.
    SmplifyX,
    /// With the room's contact and collision.
    Prox,
    /// With the room, and the pose prior centred at what people do in this scene (PSI §4.2).
    SceneAware,
}

impl EstimatorKind {
    /// Every estimator, in the order of table 5.
    pub const ALL: [Self; 3] = [Self::SmplifyX, Self::Prox, Self::SceneAware];

    /// Name in tables.
    pub fn label(self) -> &'static str {
        match self {
            Self::SmplifyX => "SMPLify-X",
            Self::Prox => "PROX",
            Self::SceneAware => "ours",
        }
    }

    /// Its configuration; `scene_code` is the centre of the prior where it is asked for.
    pub fn config(self, scene_code: &[f32; POSE]) -> EstimateConfig {
        match self {
            Self::SmplifyX => EstimateConfig::smplify_x(),
            Self::Prox => EstimateConfig::prox(),
            Self::SceneAware => EstimateConfig::scene_aware(*scene_code),
        }
    }
}

/// What a person is estimated from.
#[derive(Clone, Debug)]
pub struct EstimateRequest {
    /// The camera in the room that took the photo; its picture has the photo's size.
    pub view: View,
    /// The person in the photo.
    pub keypoints: PersonKeypoints,
    /// Which estimator.
    pub estimator: EstimatorKind,
    /// Mean pose code of people in this scene ([`mean_code`]); used by [`EstimatorKind::SceneAware`] alone.
    pub scene_code: [f32; POSE],
    /// What is acceptable.
    pub limits: Limits,
}

/// An estimated person.
#[derive(Clone, Debug)]
pub struct EstimatedPerson {
    /// The body, world frame.
    pub params: BodyParams,
    /// What it seems to do.
    pub family: PoseFamily,
    /// How it stands to the room.
    pub report: BodyReport,
    /// What is above its limit.
    pub findings: Vec<Finding>,
    /// Energies over the steps; columns are [`crate::fit::estimation::ESTIMATE_TERMS`].
    pub trace: EstimateTrace,
    /// Root mean square distance of the body's landmarks to the keypoints, pixels.
    pub reprojection_px: f32,
}

/// Estimates one person. Previews are bodies on their way.
///
/// # Errors
/// [`Stop::Cancelled`], or [`Stop::Failed`] when too few keypoints are there.
pub fn estimate_person(
    geometry: &RoomGeometry,
    request: &EstimateRequest,
    cx: &JobCtx<BodyParams>,
) -> Result<EstimatedPerson, Stop> {
    cx.stage("estimating the person", 0)?;
    let body = Body::bundled();
    let config = request.estimator.config(&request.scene_code);
    let estimate = Estimator::new(body).estimate(
        &pinhole(&request.view),
        &request.keypoints,
        &geometry.field,
        &config,
        cx.ticker(),
        &mut |params| cx.preview(params.clone()),
    )??;
    let report = inspect_body(geometry, body, &estimate.params);
    let findings = request.limits.findings(Site { body: 0, frame: None }, &report.metrics);
    Ok(EstimatedPerson {
        family: family_of(geometry, body, &estimate.params),
        params: estimate.params,
        report,
        findings,
        trace: estimate.trace,
        reprojection_px: estimate.reprojection_px,
    })
}

/// The estimators' camera of a view.
pub fn pinhole(view: &View) -> Pinhole {
    let intrinsics = &view.intrinsics;
    Pinhole {
        camera_from_world: view.camera_from_world(),
        focal_px: intrinsics.focal_px,
        center_px: intrinsics.center_px(),
        longest_px: intrinsics.width.max(intrinsics.height) as f32,
    }
}

/// Mean pose code of samples of a scene, PSI's θ_s; zero without samples.
pub fn mean_code(samples: &[BodyParams]) -> [f32; POSE] {
    let count = samples.len().max(1) as f32;
    std::array::from_fn(|i| samples.iter().map(|s| s.pose[i]).sum::<f32>() / count)
}
