//! People for a room: proposals by search, fitted in parallel, measured, and the best of them chosen.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use glam::Vec3;
use rayon::prelude::*;

use super::choose::{self, Entry, Occupied};
use crate::body::Body;
use crate::fit::{BoneSphere, FitConfig, Fitter, Surroundings, Trace, bone_spheres};
use crate::generate::{Proposal, SearchRequest, search};
use crate::inspect::{BodyReport, Finding, Limits, Site, inspect_body};
use crate::job::{Cancelled, JobCtx, Seed, Stop};
use crate::math::Aabb;
use crate::scene::{BodyParams, Person, PersonId, PoseFamily, Room, RoomGeometry};

/// Proposals fitted for each person asked for, in each round: some fail, and choice makes variety.
const PROPOSALS_PER_PERSON: usize = 2;
/// Rounds of proposing and fitting before fewer people than asked for are reported.
const ROUNDS: u64 = 4;

/// What becomes of people that are there when the user cancels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OnCancel {
    /// Nothing: cancelled is cancelled.
    #[default]
    Drop,
    /// Those that are fitted and good are the result.
    KeepBest,
}

/// Who should be put in.
#[derive(Clone, Debug)]
pub struct PopulateRequest {
    /// How many.
    pub people: usize,
    /// Only near this point, as near as can be.
    pub at: Option<Vec3>,
    /// Only these families; all when `None`.
    pub families: Option<Vec<PoseFamily>>,
    /// Who is there already: nobody is put inside them.
    pub existing: Vec<Person>,
    /// Number of the first new person.
    pub next_id: u32,
    /// How bodies are fitted.
    pub fit: FitConfig,
    /// What is acceptable; candidates beyond it are not taken.
    pub limits: Limits,
    /// What a cancel leaves.
    pub on_cancel: OnCancel,
}

impl Default for PopulateRequest {
    fn default() -> Self {
        Self {
            people: 1,
            at: None,
            families: None,
            existing: Vec::new(),
            next_id: 0,
            fit: FitConfig { preview_every: 8, ..FitConfig::default() },
            limits: Limits { psi_non_collision: 0.985, penetration_max_mm: 20.0, ..Limits::default() },
            on_cancel: OnCancel::Drop,
        }
    }
}

/// The people as they are while the job runs.
#[derive(Clone, Debug, Default)]
pub struct PopulatePreview {
    /// Bodies being fitted.
    pub people: Vec<Person>,
}

/// One new person and all that is known about them.
#[derive(Clone, Debug)]
pub struct PopulatedPerson {
    /// The person.
    pub person: Person,
    /// The body before it was fitted.
    pub proposed: BodyParams,
    /// What was measured.
    pub report: BodyReport,
    /// What is above its limit.
    pub findings: Vec<Finding>,
    /// Energies over the fit's iterations.
    pub trace: Trace,
    /// Time the fit and the measurement took.
    pub seconds: f64,
}

/// The result.
#[derive(Clone, Debug, Default)]
pub struct Populated {
    /// The new people, in the order they were chosen.
    pub people: Vec<PopulatedPerson>,
    /// Why there are fewer than asked for, if so.
    pub shortfall: Option<String>,
    /// Proposals that were fitted.
    pub fitted: usize,
    /// Time spent on proposals.
    pub generate_seconds: f64,
    /// Time spent on fitting, measuring and choosing.
    pub fit_seconds: f64,
}

/// A fitted proposal on its way to being chosen.
pub(super) struct Candidate {
    pub proposal: Proposal,
    pub params: BodyParams,
    pub report: BodyReport,
    pub trace: Trace,
    pub seconds: f64,
}

/// Puts people into a room. The same seed gives the same people, whatever the number of threads.
///
/// # Errors
/// [`Stop::Cancelled`] when the user cancelled. Fewer people than asked for are not an error but a
/// [`Populated::shortfall`].
pub fn populate(
    room: &Room,
    geometry: &RoomGeometry,
    request: &PopulateRequest,
    cx: &JobCtx<PopulatePreview>,
) -> Result<Populated, Stop> {
    let round = |missing: usize, seed: Seed| {
        let started = Instant::now();
        let proposals = propose(room, geometry, request, missing, seed, cx)?;
        let generate_seconds = started.elapsed().as_secs_f64();
        let (candidates, all) = fit_all(geometry, request, proposals, cx);
        Ok(Round { candidates, all, generate_seconds })
    };
    in_rounds(request, cx.seed, round, |people, fitted| {
        format!(
            "{people}: of {fitted} fitted proposals no other was held by something, free of penetration and clear \
             of the others. Give the room more free floor or seats, allow more pose families, or try another seed"
        )
    })
}

/// What one round of proposing and fitting brought.
pub(super) struct Round {
    /// Fitted, measured, not yet chosen from.
    pub candidates: Vec<Candidate>,
    /// Whether that is all, or the user cancelled meanwhile.
    pub all: Result<(), Cancelled>,
    /// Time spent on proposals.
    pub generate_seconds: f64,
}

/// Chooses people from rounds until enough are there. `round` is told how many are missing; `shortfall` words what
/// to do when they stay so, from "N of M people" and the number of fits.
pub(super) fn in_rounds(
    request: &PopulateRequest,
    seed: Seed,
    round: impl Fn(usize, Seed) -> Result<Round, Stop>,
    shortfall: impl FnOnce(String, usize) -> String,
) -> Result<Populated, Stop> {
    let body = Body::bundled();
    let bones = bone_spheres(body);
    let mut chosen: Vec<Entry> =
        request.existing.iter().map(|p| entry_of_existing(body, &bones, p)).collect();
    let mut result = Populated::default();
    for number in 0..ROUNDS {
        let missing = request.people - result.people.len();
        if missing == 0 {
            break;
        }
        let started = Instant::now();
        let Round { candidates, all, generate_seconds } = match round(missing, seed.child("round", number)) {
            Ok(round) => round,
            Err(Stop::Cancelled) => return stopped(request, result),
            Err(failed) => return Err(failed),
        };
        result.fitted += candidates.len();
        take_best(body, &bones, candidates, request, &mut chosen, &mut result);
        result.generate_seconds += generate_seconds;
        result.fit_seconds += started.elapsed().as_secs_f64() - generate_seconds;
        if all.is_err() {
            return stopped(request, result);
        }
    }
    let found = result.people.len();
    if found < request.people {
        result.shortfall = Some(shortfall(format!("{found} of {} people", request.people), result.fitted));
    }
    Ok(result)
}

/// The result of a job that was cancelled.
fn stopped(request: &PopulateRequest, mut result: Populated) -> Result<Populated, Stop> {
    if request.on_cancel == OnCancel::Drop || result.people.is_empty() {
        return Err(Stop::Cancelled);
    }
    result.shortfall = Some(format!(
        "{} of {} people: stopped before the rest was there",
        result.people.len(),
        request.people
    ));
    Ok(result)
}

fn propose(
    room: &Room,
    geometry: &RoomGeometry,
    request: &PopulateRequest,
    missing: usize,
    seed: Seed,
    cx: &JobCtx<PopulatePreview>,
) -> Result<Vec<Proposal>, Cancelled> {
    let wanted = SearchRequest {
        proposals: PROPOSALS_PER_PERSON * missing + 4,
        at: request.at,
        families: request.families.clone(),
    };
    search(room, geometry, Body::bundled(), &wanted, seed, cx.ticker())
}

fn entry_of_existing(body: &Body, bones: &[BoneSphere], person: &Person) -> Entry {
    let occupied = Occupied::new(bones, &body.joints(&person.body));
    Entry { family: person.family, support: None, occupied, cost: 0.0 }
}

/// Fits and measures every proposal on all threads; results keep the proposals' order. After a cancel those that
/// were done, and that it was cancelled.
fn fit_all(
    geometry: &RoomGeometry,
    request: &PopulateRequest,
    proposals: Vec<Proposal>,
    cx: &JobCtx<PopulatePreview>,
) -> (Vec<Candidate>, Result<(), Cancelled>) {
    if let Err(cancelled) = cx.stage("fitting people", proposals.len()) {
        return (Vec::new(), Err(cancelled));
    }
    let fitter = Fitter::new(Body::bundled());
    let shown: Mutex<BTreeMap<usize, Person>> = Mutex::default();
    let fit_one = |(index, proposal): (usize, Proposal)| {
        let started = Instant::now();
        let mut show = |params: &BodyParams| {
            let mut shown = shown.lock().unwrap_or_else(PoisonError::into_inner);
            shown.insert(index, person(&proposal, params.clone(), request.next_id + index as u32));
            if shown.len() > request.people {
                shown.pop_first();
            }
            cx.preview(PopulatePreview { people: shown.values().cloned().collect() });
        };
        let start = Aabb::of(Body::bundled().pose(&proposal.params).vertices);
        let fitted = fitter.fit(
            &Surroundings::new(geometry, start),
            &proposal.params,
            proposal.family,
            &request.fit,
            cx.ticker(),
            &mut show,
        )?;
        let report = inspect_body(geometry, Body::bundled(), &fitted.params);
        cx.advance()?;
        let seconds = started.elapsed().as_secs_f64();
        Ok(Candidate { proposal, params: fitted.params, report, trace: fitted.trace, seconds })
    };
    let fitted: Vec<Result<Candidate, Cancelled>> =
        proposals.into_par_iter().enumerate().map(fit_one).collect();
    let all = if fitted.iter().all(Result::is_ok) { Ok(()) } else { Err(Cancelled) };
    (fitted.into_iter().flatten().collect(), all)
}

/// Moves the best candidates that fit together into the result, until enough are there or none is left.
fn take_best(
    body: &Body,
    bones: &[BoneSphere],
    candidates: Vec<Candidate>,
    request: &PopulateRequest,
    chosen: &mut Vec<Entry>,
    result: &mut Populated,
) {
    let mut entries: Vec<Option<Entry>> =
        candidates.iter().map(|c| acceptable_entry(body, bones, c, &request.limits)).collect();
    let mut candidates: Vec<Option<Candidate>> = candidates.into_iter().map(Some).collect();
    while result.people.len() < request.people {
        let Some(index) = choose::best(&entries, chosen) else { break };
        let (Some(entry), Some(candidate)) = (entries[index].take(), candidates[index].take()) else { break };
        chosen.push(entry);
        let id = request.next_id + result.people.len() as u32;
        let site = Site { body: id, frame: None };
        result.people.push(PopulatedPerson {
            person: person(&candidate.proposal, candidate.params, id),
            proposed: candidate.proposal.params,
            findings: Limits::default().findings(site, &candidate.report.metrics),
            report: candidate.report,
            trace: candidate.trace,
            seconds: candidate.seconds,
        });
    }
}

/// The candidate as an entry of the choice, or `None` when it is beyond the limits.
fn acceptable_entry(
    body: &Body,
    bones: &[BoneSphere],
    candidate: &Candidate,
    limits: &Limits,
) -> Option<Entry> {
    let metrics = &candidate.report.metrics;
    let site = Site { body: 0, frame: None };
    if !limits.findings(site, metrics).is_empty() {
        return None;
    }
    let cost = candidate.proposal.cost
        + 40.0 * (1.0 - metrics.psi_non_collision)
        + metrics.penetration_max_mm / 25.0
        + metrics.joint_limit_deg / 20.0;
    Some(Entry {
        family: candidate.proposal.family,
        support: candidate.proposal.support,
        occupied: Occupied::new(bones, &body.joints(&candidate.params)),
        cost,
    })
}

fn person(proposal: &Proposal, body: BodyParams, id: u32) -> Person {
    Person {
        id: PersonId(id),
        name: format!("Person {}", id + 1),
        body,
        family: proposal.family,
        on: proposal.on.clone(),
        seed: proposal.seed.value(),
        palette: id,
        visible: true,
        locked: false,
    }
}
