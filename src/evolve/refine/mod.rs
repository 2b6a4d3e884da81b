//! From a body that somebody proposed (a network, a guess, chance) to one that could be there: what it does is
//! guessed, it is set right, starts around it are searched coarsely, and the best of their fits is taken.
//!
//! PSI's own way, eq. 8 from the sample itself, has the same interface for comparison. A body beyond rescue is
//! returned with its findings, never dropped. May not sample bodies itself.

mod coarse;
mod guess;
mod shape;
mod upright;

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use glam::Vec3;
use rayon::prelude::*;

use self::coarse::{Coarse, Reach, Spot, Start};
use self::guess::Posture;
use self::shape::Shaper;
use crate::body::Body;
use crate::body::joints::PELVIS;
use crate::fit::{FitConfig, FitPreset, Fitted, Fitter, Objective, Surroundings, Trace};
use crate::generate::{Place, all_places};
use crate::inspect::{BodyReport, Finding, Limits, Site, inspect_body};
use crate::job::{Cancelled, JobCtx, Seed, Stop};
use crate::math::Aabb;
use crate::scene::{BodyParams, PARAMS, PoseFamily, Room, RoomGeometry};

/// A body that has to go this far costs as much as a finding that misses its limit by half, metres.
const FAR_M: f32 = 2.0;

/// How bodies are refined.
#[derive(Clone, Debug, PartialEq)]
pub struct RefineRequest {
    /// The descent. With PSI's objective it starts at the sample itself and nothing else is done; with ours the
    /// starts are searched first.
    pub fit: FitConfig,
    /// Starts near the sample that are fitted until one has no findings.
    pub starts_near: usize,
    /// Further starts anywhere in the room for samples that no near start saves.
    pub starts_anywhere: usize,
    /// What is acceptable.
    pub limits: Limits,
}

impl Default for RefineRequest {
    fn default() -> Self {
        Self {
            fit: FitConfig { preview_every: 8, ..FitConfig::default() },
            starts_near: 3,
            starts_anywhere: 5,
            limits: Limits::default(),
        }
    }
}

impl RefineRequest {
    /// The request of a named setting: PSI's three, or ours.
    pub fn of_preset(preset: FitPreset) -> Self {
        Self { fit: FitConfig { preview_every: 8, ..preset.into() }, ..Self::default() }
    }
}

/// The bodies as they are while the job runs, by their place among the samples.
#[derive(Clone, Debug, Default)]
pub struct RefinePreview {
    /// Bodies that have begun.
    pub bodies: BTreeMap<usize, BodyParams>,
}

/// One sample and what became of it.
#[derive(Clone, Debug)]
pub struct Refined {
    /// The sample.
    pub before: BodyParams,
    /// The fitted body.
    pub params: BodyParams,
    /// What it does.
    pub family: PoseFamily,
    /// Name of what holds it; "nothing" where the published fit was asked for, which does not know.
    pub on: String,
    /// What was measured.
    pub report: BodyReport,
    /// What is above its limit; empty for a body that could be there. `site.body` counts the samples.
    pub findings: Vec<Finding>,
    /// Energies over the iterations of the fit that was taken.
    pub trace: Trace,
    /// From the sample's pelvis joint to the body's, metres.
    pub moved_m: f32,
    /// Fits that were made.
    pub fits: usize,
    /// Time that this body took on its thread.
    pub seconds: f64,
}

/// Everything that is shared by the bodies of one room.
struct Refiner<'a> {
    geometry: &'a RoomGeometry,
    body: &'a Body,
    fitter: Fitter<'a>,
    coarse: Coarse<'a>,
    request: &'a RefineRequest,
}

/// Refines samples (world frame) in a room, in parallel; results in the order given. Nothing of one body reaches
/// another: a sample gives the same body alone and among others, on any number of threads.
///
/// # Errors
/// [`Stop::Cancelled`] when the user cancelled. A body beyond rescue is no error but has [`Refined::findings`].
pub fn refine(
    room: &Room,
    geometry: &RoomGeometry,
    samples: &[BodyParams],
    request: &RefineRequest,
    cx: &JobCtx<RefinePreview>,
) -> Result<Vec<Refined>, Stop> {
    let shown = RefinePreview { bodies: samples.iter().cloned().enumerate().collect() };
    cx.preview(shown.clone());
    let shown = Mutex::new(shown);
    let places = match request.fit.objective {
        Objective::Psi(_) => Vec::new(),
        // The places of a room don't depend on who asks, so neither does their seed.
        Objective::Rescue(_) => all_places(room, geometry, Seed::root(0), cx.ticker())?,
    };
    let refiner = Refiner::new(room, geometry, &places, request);
    cx.stage("fitting people", samples.len())?;
    let one = |(index, sample): (usize, &BodyParams)| {
        let mut show = |params: &BodyParams| {
            let mut shown = shown.lock().unwrap_or_else(PoisonError::into_inner);
            shown.bodies.insert(index, params.clone());
            cx.preview(shown.clone());
        };
        let refined = refiner.refine(index, sample, cx, &mut show)?;
        show(&refined.params);
        cx.advance()?;
        Ok(refined)
    };
    let refined: Result<Vec<Refined>, Cancelled> = samples.par_iter().enumerate().map(one).collect();
    Ok(refined?)
}

/// One fit of one start, measured.
struct Attempt {
    start: Start,
    fitted: Fitted,
    report: BodyReport,
    findings: Vec<Finding>,
    moved_m: f32,
}

impl Attempt {
    /// How bad it is: its findings first, then how far it went.
    fn badness(&self) -> f32 {
        self.findings.iter().map(Finding::severity).sum::<f32>() + self.moved_m / FAR_M
    }
}

impl<'a> Refiner<'a> {
    fn new(
        room: &'a Room,
        geometry: &'a RoomGeometry,
        places: &'a [Place],
        request: &'a RefineRequest,
    ) -> Self {
        let body = Body::bundled();
        let coarse = Coarse::new(room, geometry, Shaper::new(body), places);
        Self { geometry, body, fitter: Fitter::new(body), coarse, request }
    }

    fn refine(
        &self,
        index: usize,
        sample: &BodyParams,
        cx: &JobCtx<RefinePreview>,
        show: &mut dyn FnMut(&BodyParams),
    ) -> Result<Refined, Cancelled> {
        let started = Instant::now();
        cx.check()?;
        let (attempt, fits) = if !is_finite(sample) {
            (self.unfitted(index, sample), 0)
        } else if matches!(self.request.fit.objective, Objective::Psi(_)) {
            (self.attempt(index, sample, Start::as_sampled(sample), cx, show)?, 1)
        } else {
            self.rescue(index, sample, cx, show)?
        };
        let Attempt { start, fitted, report, findings, moved_m } = attempt;
        Ok(Refined {
            before: sample.clone(),
            params: fitted.params,
            family: start.family,
            on: start.on,
            report,
            findings,
            trace: fitted.trace,
            moved_m,
            fits,
            seconds: started.elapsed().as_secs_f64(),
        })
    }

    /// Fits starts, near ones first, until one has no findings; else the best of them, and how many there were.
    fn rescue(
        &self,
        index: usize,
        sample: &BodyParams,
        cx: &JobCtx<RefinePreview>,
        show: &mut dyn FnMut(&BodyParams),
    ) -> Result<(Attempt, usize), Cancelled> {
        let mut best: Option<Attempt> = None;
        let mut tried: Vec<Spot> = Vec::new();
        let plan = [(Reach::Near, self.request.starts_near), (Reach::Anywhere, self.request.starts_anywhere)];
        for (reach, count) in plan {
            let starts = self.coarse.starts(sample, reach, count, &tried);
            for start in starts {
                tried.push(start.spot);
                let attempt = self.attempt(index, sample, start, cx, show)?;
                let clean = attempt.findings.is_empty();
                if best.as_ref().is_none_or(|b| attempt.badness() < b.badness()) {
                    best = Some(attempt);
                }
                if clean {
                    return Ok((best.unwrap_or_else(|| self.unfitted(index, sample)), tried.len()));
                }
            }
        }
        Ok((best.unwrap_or_else(|| self.unfitted(index, sample)), tried.len()))
    }

    fn attempt(
        &self,
        index: usize,
        sample: &BodyParams,
        start: Start,
        cx: &JobCtx<RefinePreview>,
        show: &mut dyn FnMut(&BodyParams),
    ) -> Result<Attempt, Cancelled> {
        let around = match self.request.fit.objective {
            Objective::Psi(_) => Surroundings::of_field(&self.geometry.field),
            Objective::Rescue(_) => {
                Surroundings::new(self.geometry, Aabb::of(self.body.pose(&start.params).vertices))
            }
        };
        let fitted =
            self.fitter.fit(&around, &start.params, start.family, &self.request.fit, cx.ticker(), show)?;
        let (report, findings) = self.measure(index, &fitted.params);
        let pelvis = |params: &BodyParams| self.body.joints(params)[PELVIS];
        let moved_m = pelvis(sample).distance(pelvis(&fitted.params));
        Ok(Attempt { start, fitted, report, findings, moved_m })
    }

    /// The sample as it is: for one whose numbers are not finite.
    fn unfitted(&self, index: usize, sample: &BodyParams) -> Attempt {
        let (report, findings) = self.measure(index, sample);
        let fitted = Fitted { params: sample.clone(), trace: Trace::new() };
        Attempt { start: Start::as_sampled(sample), fitted, report, findings, moved_m: 0.0 }
    }

    fn measure(&self, index: usize, params: &BodyParams) -> (BodyReport, Vec<Finding>) {
        let report = inspect_body(self.geometry, self.body, params);
        let findings =
            self.request.limits.findings(Site { body: index as u32, frame: None }, &report.metrics);
        (report, findings)
    }
}

/// What a body seems to do, from its posture and its height above what lies below it. Seats and walls are not looked
/// at: everybody who sits with bent knees sits on a chair, and everybody upright stands.
pub fn family_of(geometry: &RoomGeometry, body: &Body, params: &BodyParams) -> PoseFamily {
    let joints = body.joints(params);
    Posture::of(&joints, &params.rotation()).family(height_over_m(geometry, joints[PELVIS]))
}

/// From a point down to the first surface below it, metres; infinite where nothing is.
fn height_over_m(geometry: &RoomGeometry, point: Vec3) -> f32 {
    geometry.bvh.cast(point, Vec3::NEG_Y, 4.0).map_or(f32::INFINITY, |hit| hit.distance_m)
}

fn is_finite(sample: &BodyParams) -> bool {
    let x: [f32; PARAMS] = sample.to_vector();
    x.iter().all(|v| v.is_finite())
}
