use rayon::prelude::*;

use super::observe::{ObserveConfig, Observer};
use crate::body::Body;
use crate::evolve::{EstimatorKind, pinhole};
use crate::fit::estimation::{Estimate, Estimator};
use crate::generate::sensor::{SceneImage, View};
use crate::inspect::EstimateErrors;
use crate::job::{Cancelled, Seed, Ticker};
use crate::scene::{BodyParams, POSE, PoseFamily, RoomGeometry};

/// A true body and the camera that sees it.
#[derive(Clone, Debug)]
pub struct Case {
    /// Room.
    pub room: String,
    /// Number of the case in the whole study: names its seed.
    pub number: u64,
    /// What the body does.
    pub family: PoseFamily,
    /// The truth, world frame.
    pub truth: BodyParams,
    /// The camera.
    pub view: View,
    /// What the camera sees of the room without the body, where it was captured before.
    pub image: Option<SceneImage>,
    /// PSI's θ_s of this view: mean pose code of samples of the scene without the body.
    pub scene_code: [f32; POSE],
}

/// What came of one case.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct CaseResult {
    /// Room.
    pub room: String,
    /// Number of the case.
    pub number: u64,
    /// What the body does.
    pub family: PoseFamily,
    /// Keypoints with any confidence.
    pub points: usize,
    /// From the camera to the pelvis along the optical axis, metres.
    pub depth_m: f32,
    /// Errors by [`EstimatorKind::ALL`].
    pub errors: Vec<EstimateErrors>,
    /// Reprojection by [`EstimatorKind::ALL`], pixels.
    pub reprojection_px: Vec<f32>,
}

/// Estimates every case of one room by every estimator, from the same keypoints. Cases with too few keypoints are
/// left out. In the order given, whatever the number of threads.
///
/// # Errors
/// [`Cancelled`] once the user cancelled.
pub fn study_room(
    geometry: &RoomGeometry,
    cases: &[Case],
    config: &ObserveConfig,
    seed: Seed,
    ticker: &Ticker,
) -> Result<Vec<CaseResult>, Cancelled> {
    let body = Body::bundled();
    let (observer, estimator) = (Observer::new(body), Estimator::new(body));
    let one = |case: &Case| {
        let view = Observer::enlarged(&case.view, config);
        let seed = seed.child("keypoints", case.number);
        let seen = observer.observe(&case.truth, &view, &geometry.bvh, config, seed);
        let camera = pinhole(&view);
        let mut estimates: Vec<Estimate> = Vec::new();
        for kind in EstimatorKind::ALL {
            let setting = kind.config(&case.scene_code);
            let found = estimator.estimate(&camera, &seen, &geometry.field, &setting, ticker, &mut |_| ());
            match found {
                Ok(estimate) => estimates.push(estimate?),
                Err(_) => return Ok(None),
            }
        }
        ticker.advance()?;
        Ok(Some(CaseResult {
            room: case.room.clone(),
            number: case.number,
            family: case.family,
            points: seen.points.iter().filter(|p| p.confidence > 0.0).count(),
            depth_m: camera.depth_m(body.model.rest_joints(&case.truth.betas)[0] + case.truth.translation),
            errors: estimates.iter().map(|e| EstimateErrors::of(body, &e.params, &case.truth)).collect(),
            reprojection_px: estimates.iter().map(|e| e.reprojection_px).collect(),
        }))
    };
    let results: Result<Vec<Option<CaseResult>>, Cancelled> = cases.par_iter().map(one).collect();
    Ok(results?.into_iter().flatten().collect())
}
