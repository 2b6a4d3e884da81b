//! People for a room by what it looks like: views of it, bodies by a network of PSI, refined, the best chosen.

use std::time::Instant;

use glam::Vec3;

use super::populate::{Candidate, PopulatePreview, PopulateRequest, Populated, Round, in_rounds};
use super::refine::{RefineRequest, Refined, refine};
use crate::body::Body;
use crate::body::joints::PELVIS;
use crate::generate::Proposal;
use crate::generate::learned::LearnedSampler;
use crate::generate::sensor::{AgentConfig, SceneImage, Sensor, View, agent_views};
use crate::job::{Cancelled, JobCtx, Seed, Stop};
use crate::scene::{BodyParams, Room, RoomGeometry};

/// Samples refined for each person asked for, in each round: some are beyond rescue, and choice makes variety.
const SAMPLES_PER_PERSON: usize = 3;
/// Samples drawn for each that is refined when only some places will do.
const DRAWS_NEAR: usize = 8;
/// With a point asked for, only samples this near come into question, metres; as in the search.
const NEAR_M: f32 = 1.6;
/// What a metre between sample and refined body costs in the choice: a body that had to go far is less of what
/// the network proposed.
const COST_PER_M: f32 = 0.4;

/// How the network looks at the room.
#[derive(Clone, Debug)]
pub struct LearnedRequest {
    /// Who should be put in.
    pub populate: PopulateRequest,
    /// Views to sample from; the agent chooses them itself when empty.
    pub views: Vec<View>,
    /// How many views the agent chooses.
    pub agent_views: usize,
}

impl Default for LearnedRequest {
    fn default() -> Self {
        Self { populate: PopulateRequest::default(), views: Vec::new(), agent_views: 6 }
    }
}

/// Puts people into a room by a network's samples. The same seed gives the same people, whatever the number of
/// threads.
///
/// # Errors
/// [`Stop::Cancelled`] when the user cancelled, [`Stop::Failed`] when nobody can stand anywhere to look at the
/// room. Fewer people than asked for are not an error but a [`Populated::shortfall`].
pub fn populate_learned(
    room: &Room,
    geometry: &RoomGeometry,
    sampler: &LearnedSampler,
    request: &LearnedRequest,
    cx: &JobCtx<PopulatePreview>,
) -> Result<Populated, Stop> {
    let wanted = &request.populate;
    let started = Instant::now();
    let images = look(room, geometry, request, cx)?;
    let look_seconds = started.elapsed().as_secs_f64();
    let round = |missing: usize, seed: Seed| {
        let started = Instant::now();
        let samples = sample(sampler, &images, wanted.at, SAMPLES_PER_PERSON * missing + 4, seed, cx)?;
        let generate_seconds = started.elapsed().as_secs_f64();
        let candidates = refined(room, geometry, &samples, wanted, seed, cx)?;
        Ok(Round { candidates, all: Ok(()), generate_seconds })
    };
    let mut result = in_rounds(wanted, cx.seed, round, |people, fitted| {
        format!(
            "{people}: of {fitted} refined samples no other was held by something, free of penetration and clear of \
             the others. Look from other views, allow more pose families, or use --method search"
        )
    })?;
    result.generate_seconds += look_seconds;
    Ok(result)
}

/// What the network sees: the views asked for, or the agent's.
fn look(
    room: &Room,
    geometry: &RoomGeometry,
    request: &LearnedRequest,
    cx: &JobCtx<PopulatePreview>,
) -> Result<Vec<SceneImage>, Stop> {
    cx.stage("looking around", 0)?;
    let sensor = Sensor::new(room, geometry);
    let views = match request.views.is_empty() {
        true => agent_views(&sensor, request.agent_views, &AgentConfig::default(), cx.seed.child("views", 0)),
        false => request.views.clone(),
    };
    if views.is_empty() {
        let problem = "nobody can stand anywhere in this room to look at it: clear some floor, give a view, or use --method search";
        return Err(Stop::Failed(problem.to_owned()));
    }
    Ok(sensor.scene_images(&views, cx.ticker())?)
}

/// The same share of `count` samples from each view; near a point only those near it, if there are any.
fn sample(
    sampler: &LearnedSampler,
    images: &[SceneImage],
    at: Option<Vec3>,
    count: usize,
    seed: Seed,
    cx: &JobCtx<PopulatePreview>,
) -> Result<Vec<BodyParams>, Cancelled> {
    cx.stage("sampling", images.len())?;
    let draws = count.div_ceil(images.len()) * if at.is_some() { DRAWS_NEAR } else { 1 };
    let mut samples = Vec::new();
    for (index, image) in images.iter().enumerate() {
        let seed = seed.child("view", index as u64);
        samples.extend(sampler.sample(image, draws, seed, cx.ticker(), &mut |_| ())?);
    }
    if let Some(at) = at {
        let pelvis = |params: &BodyParams| Body::bundled().joints(params)[PELVIS];
        let away = |params: &BodyParams| ((pelvis(params) - at) * Vec3::new(1.0, 0.0, 1.0)).length();
        samples.retain(|body| away(body) < NEAR_M);
    }
    samples.truncate(count.max(1) * 2);
    Ok(samples)
}

fn refined(
    room: &Room,
    geometry: &RoomGeometry,
    samples: &[BodyParams],
    wanted: &PopulateRequest,
    seed: Seed,
    cx: &JobCtx<PopulatePreview>,
) -> Result<Vec<Candidate>, Stop> {
    let request = RefineRequest { fit: wanted.fit, limits: wanted.limits, ..RefineRequest::default() };
    let inner = JobCtx::watched(seed, cx.ticker().clone());
    let all = refine(room, geometry, samples, &request, &inner)?;
    let allowed = |r: &Refined| wanted.families.as_ref().is_none_or(|families| families.contains(&r.family));
    let candidate = |(index, r): (usize, Refined)| Candidate {
        proposal: Proposal {
            params: r.before,
            family: r.family,
            on: r.on,
            support: None,
            seed: seed.child("sample", index as u64),
            cost: COST_PER_M * r.moved_m,
        },
        params: r.params,
        report: r.report,
        trace: r.trace,
        seconds: r.seconds,
    };
    Ok(all.into_iter().filter(allowed).enumerate().map(candidate).collect())
}
