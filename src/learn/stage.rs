//! Stages a corpus: rooms made by rule, people put into them by search, fitted and measured, and cameras.
//!
//! What comes out is **staged, not captured**: poses are those of the program's own families, set down by its own
//! search and fitter, and kept only within limits of plausibility. Each room depends on nothing but the corpus's
//! seed and its own number: any order, any number of threads, any interruption give the same bytes. Files are the
//! caller's.

use std::ops::ControlFlow;

use rayon::prelude::*;

use super::corpus::{
    CorpusPerson, CorpusRoom, CorpusView, FORMAT, Manifest, RoomEntry, RoomSource, Split, ViewKind,
    corpus_geometry,
};
use crate::assets::{Budget, Model, read_model_bytes, sample_rooms};
use crate::body::Body;
use crate::body::joints::BODY_JOINTS;
use crate::fit::{FitConfig, Fitter, Surroundings};
use crate::generate::sensor::{
    AgentConfig, Sensor, View, VirtualCameraConfig, agent_views, virtual_cameras, visible_share,
};
use crate::generate::{Proposal, SearchRequest, search};
use crate::inspect::{Limits, Site, inspect_body};
use crate::job::{Cancelled, Seed, Stop, Ticker};
use crate::math::Aabb;
use crate::scene::layout::{Layout, RoomType, compose, procedural_layout};
use crate::scene::{BodyParams, PoseFamily, Room, RoomGeometry};

use glam::Vec3;

/// Rooms of which the split takes its shares, each block of this many in an order of its own.
const BLOCK: usize = 20;
/// Rooms of a block to learn from, 70 %; the others are halved between validation and test.
const TRAIN_OF_BLOCK: usize = 14;
/// Proposals fitted for each person still wanted.
const PROPOSALS_PER_PERSON: f32 = 1.4;
/// Rounds of proposing before a room is left with fewer people.
const ROUNDS: u64 = 3;
/// Pose groups in the order in which people are taken, so that all are there if a room affords them.
const GROUPS: [&str; 6] = ["sit", "lie", "stand", "sit", "lean", "sit"];
/// Candidate views of the agent for each that is kept: many see nobody.
const AGENT_VIEWS: usize = 40;
/// Share of a body's joints that the agent must see.
const AGENT_SEES: f32 = 0.6;
/// Distance from the agent to the pelvis in metres: as the virtual cameras keep it.
const AGENT_DISTANCE_M: std::ops::Range<f32> = 1.4..6.0;
/// Farthest that a pose may be from the mean of all poses: |z| of a standard normal vector of 32 numbers is 5.7 with a
/// deviation of 0.7; families keep well inside, what the fitter bent beyond does not.
const LIKELY_CODE: f32 = 9.0;

/// How much is staged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StageConfig {
    /// Rooms made by rule.
    pub rooms: usize,
    /// People in each, at most.
    pub people: usize,
    /// Virtual cameras for each person, at most.
    pub views: usize,
    /// Agent views for each person, at most.
    pub agent_views: usize,
    /// Whether the program's sample rooms are among those to learn from.
    pub sample_rooms: bool,
    /// Root of the seed tree.
    pub seed: u64,
    /// How bodies are fitted.
    pub fit: FitConfig,
    /// What is kept.
    pub limits: Limits,
}

impl Default for StageConfig {
    fn default() -> Self {
        Self {
            rooms: 200,
            people: 24,
            views: 4,
            agent_views: 1,
            sample_rooms: true,
            seed: 0,
            fit: FitConfig::default(),
            limits: Limits { psi_non_collision: 0.985, penetration_max_mm: 20.0, ..Limits::default() },
        }
    }
}

/// A room that is to be staged.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RoomPlan {
    /// Folder of the room.
    pub name: String,
    /// What it is for.
    pub split: Split,
    /// Where it comes from.
    pub source: RoomSource,
    /// Seed of all that is drawn in it.
    seed: Seed,
}

/// Every room of a corpus: the bundled samples to learn from, then the rooms made by rule, their kinds in turn.
pub fn plan_rooms(config: &StageConfig) -> Vec<RoomPlan> {
    let root = Seed::root(config.seed);
    let sample = |room: &crate::assets::SampleRoom| RoomPlan {
        name: format!("sample_{}", room.key),
        split: Split::Train,
        source: RoomSource::Sample(room.key.to_owned()),
        seed: root.child(room.key, 0),
    };
    let made = |number: usize| {
        let kind = RoomType::ALL[number % RoomType::ALL.len()];
        let seed = root.child("room", number as u64);
        RoomPlan {
            name: format!("room_{number:04}"),
            split: split_of(root, number),
            source: RoomSource::Procedural { kind, seed: seed.child("layout", 0).value() },
            seed,
        }
    };
    let samples = if config.sample_rooms { sample_rooms() } else { &[] };
    samples.iter().map(sample).chain((0..config.rooms).map(made)).collect()
}

/// 70, 15 and 15 % of every twenty rooms, whatever their whole number.
fn split_of(root: Seed, number: usize) -> Split {
    let block = root.child("split", (number / BLOCK) as u64);
    let rank = |n: usize| (block.child("room", n as u64).value(), n);
    let before = (0..BLOCK).filter(|n| rank(*n) < rank(number % BLOCK)).count();
    let validation = (BLOCK - TRAIN_OF_BLOCK) / 2;
    match before {
        b if b < TRAIN_OF_BLOCK => Split::Train,
        b if b < TRAIN_OF_BLOCK + validation => Split::Validation,
        _ => Split::Test,
    }
}

/// The room itself, and the layout it was made from.
///
/// # Errors
/// When the source is unknown or doesn't compose.
pub fn make_room(source: &RoomSource) -> Result<(Option<Layout>, Model), Stop> {
    match source {
        RoomSource::Procedural { kind, seed } => {
            let layout = procedural_layout(*kind, *seed);
            let model = compose(&layout, &crate::scene::layout::bundled_furniture)?;
            Ok((Some(layout), model))
        }
        RoomSource::Sample(key) => {
            let sample = sample_rooms().iter().find(|r| r.key == key);
            let sample = sample.ok_or_else(|| Stop::Failed(format!("no sample room is called {key}")))?;
            Ok((None, read_model_bytes(&format!("{key}.glb"), sample.glb, &Budget::default())?))
        }
        RoomSource::File(name) => Err(Stop::Failed(format!("{name} is a capture: it can't be staged"))),
    }
}

/// Puts people and cameras into a room that was read back from its own file.
///
/// # Errors
/// [`Stop::Cancelled`] once the user cancelled.
pub fn stage_room(
    plan: &RoomPlan,
    room: &Room,
    config: &StageConfig,
    ticker: &Ticker,
) -> Result<CorpusRoom, Stop> {
    let step = |_, _| match ticker.check() {
        Ok(()) => ControlFlow::Continue(()),
        Err(Cancelled) => ControlFlow::Break(()),
    };
    let geometry = RoomGeometry::build(room, &corpus_geometry(), &step).map_err(|_| Stop::Cancelled)?;
    let bodies = people(room, &geometry, plan.seed, config, ticker)?;
    let sensor = Sensor::new(room, &geometry);
    let agents = agent_views(&sensor, AGENT_VIEWS, &AgentConfig::default(), plan.seed.child("agents", 0));
    let of_body = |(index, body): (usize, &Staged)| {
        let seed = plan.seed.child("views", index as u64);
        views(&sensor, &agents, index, body, config, seed, ticker)
    };
    let views: Vec<Vec<CorpusView>> =
        bodies.par_iter().enumerate().map(of_body).collect::<Result<_, Cancelled>>()?;
    let person = |b: &Staged| CorpusPerson::new(&b.params, b.family, Body::bundled());
    Ok(CorpusRoom {
        name: plan.name.clone(),
        split: plan.split,
        source: plan.source.clone(),
        people: bodies.iter().map(person).collect(),
        views: views.into_iter().flatten().collect(),
    })
}

/// The manifest of a staged corpus.
pub fn manifest(config: &StageConfig, rooms: Vec<RoomEntry>) -> Manifest {
    let about = format!(
        "Staged, not captured: people put into rooms made by rule, by inhabit {} (inhabit stage --rooms {} --people {} \
         --views {} --agent-views {} --seed {})",
        env!("CARGO_PKG_VERSION"),
        config.rooms,
        config.people,
        config.views,
        config.agent_views,
        config.seed
    );
    Manifest { format: FORMAT, about, seed: config.seed, rooms }
}

impl RoomPlan {
    /// The room's line in the manifest, once it is staged.
    pub fn entry(&self, people: usize, views: usize) -> RoomEntry {
        RoomEntry { name: self.name.clone(), split: self.split, source: self.source.clone(), people, views }
    }
}

/// Somebody who was kept.
struct Staged {
    params: BodyParams,
    family: PoseFamily,
    joints: Vec<Vec3>,
    cost: f32,
}

/// Proposes, fits and measures until enough people are kept or the room gives no more; balanced over what it affords.
fn people(
    room: &Room,
    geometry: &RoomGeometry,
    seed: Seed,
    config: &StageConfig,
    ticker: &Ticker,
) -> Result<Vec<Staged>, Cancelled> {
    let body = Body::bundled();
    let fitter = Fitter::new(body);
    let mut kept: Vec<Staged> = Vec::new();
    for round in 0..ROUNDS {
        let missing = config.people.saturating_sub(kept.len());
        if missing == 0 {
            break;
        }
        let proposals = (missing as f32 * PROPOSALS_PER_PERSON).ceil() as usize + 2;
        let request = SearchRequest { proposals, at: None, families: None };
        let proposals = search(room, geometry, body, &request, seed.child("people", round), ticker)?;
        let fit = |proposal: Proposal| fitted(geometry, &fitter, body, &proposal, config, ticker);
        let fitted: Vec<Option<Staged>> =
            proposals.into_par_iter().map(fit).collect::<Result<_, Cancelled>>()?;
        kept.extend(fitted.into_iter().flatten());
    }
    Ok(balanced(kept, config.people))
}

/// The proposal fitted, or `None` when it is not plausible.
fn fitted(
    geometry: &RoomGeometry,
    fitter: &Fitter<'_>,
    body: &Body,
    proposal: &Proposal,
    config: &StageConfig,
    ticker: &Ticker,
) -> Result<Option<Staged>, Cancelled> {
    let start = Aabb::of(body.pose(&proposal.params).vertices);
    let around = Surroundings::new(geometry, start);
    let fitted = fitter.fit(&around, &proposal.params, proposal.family, &config.fit, ticker, &mut |_| ())?;
    let metrics = inspect_body(geometry, body, &fitted.params).metrics;
    let code = fitted.params.pose.iter().map(|z| z * z).sum::<f32>().sqrt();
    let findings = config.limits.findings(Site { body: 0, frame: None }, &metrics);
    if !findings.is_empty() || code > LIKELY_CODE {
        return Ok(None);
    }
    Ok(Some(Staged {
        joints: body.joints(&fitted.params)[..=BODY_JOINTS].to_vec(),
        params: fitted.params,
        family: proposal.family,
        cost: proposal.cost + metrics.penetration_max_mm / 25.0 + metrics.joint_limit_deg / 20.0,
    }))
}

/// At most `count`, the best of each pose group in turn.
fn balanced(mut from: Vec<Staged>, count: usize) -> Vec<Staged> {
    let mut taken = Vec::new();
    let mut empty_in_a_row = 0;
    for turn in 0.. {
        if taken.len() == count || empty_in_a_row > GROUPS.len() {
            break;
        }
        let group = GROUPS[turn % GROUPS.len()];
        let of_group = from.iter().enumerate().filter(|(_, s)| s.family.group() == group);
        let best = of_group.min_by(|a, b| a.1.cost.total_cmp(&b.1.cost).then(a.0.cmp(&b.0)));
        let Some((index, _)) = best else {
            empty_in_a_row += 1;
            continue;
        };
        empty_in_a_row = 0;
        taken.push(from.remove(index));
    }
    taken
}

/// Virtual cameras around one person and agent views that see them, captured.
fn views(
    sensor: &Sensor<'_>,
    agents: &[View],
    index: usize,
    body: &Staged,
    config: &StageConfig,
    seed: Seed,
    ticker: &Ticker,
) -> Result<Vec<CorpusView>, Cancelled> {
    let geometry = sensor.geometry();
    let cameras = VirtualCameraConfig { most: config.views, ..VirtualCameraConfig::default() };
    let around = virtual_cameras(geometry, &body.joints, &cameras, seed);
    // Each person begins at another of the agent's views, so that all of them are used.
    let offset = index * AGENT_VIEWS / config.people.max(1);
    let turned = (0..agents.len()).map(|k| &agents[(k + offset) % agents.len()]);
    let sees = |view: &&View| {
        let distance_m = view.eye().distance(body.joints[0]);
        AGENT_DISTANCE_M.contains(&distance_m) && visible_share(geometry, view, &body.joints) >= AGENT_SEES
    };
    let seen_by = turned.filter(sees).take(config.agent_views);
    let all = around.iter().map(|v| (ViewKind::Virtual, v)).chain(seen_by.map(|v| (ViewKind::Agent, v)));
    all.map(|(kind, view)| {
        ticker.check()?;
        Ok(CorpusView::new(kind, index, &sensor.scene_image(view)))
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seventy_fifteen_fifteen_of_every_twenty_rooms_whatever_their_number() {
        let config = StageConfig { rooms: 200, ..StageConfig::default() };
        let plans = plan_rooms(&config);
        let made: Vec<&RoomPlan> = plans.iter().filter(|p| p.name.starts_with("room_")).collect();
        let count = |split| made.iter().filter(|p| p.split == split).count();
        assert_eq!([count(Split::Train), count(Split::Validation), count(Split::Test)], [140, 30, 30]);
        let fewer = plan_rooms(&StageConfig { rooms: 50, ..config });
        assert_eq!(fewer[..], plans[..fewer.len()], "a room's plan doesn't depend on how many there are");
        let other = plan_rooms(&StageConfig { seed: 1, ..config });
        assert_ne!(other, plans);
        for kind in RoomType::ALL {
            let of_kind = |p: &&&RoomPlan| {
                matches!(p.source, RoomSource::Procedural { kind: k, .. } if k == kind)
                    && p.split == Split::Test
            };
            assert!(made.iter().filter(of_kind).count() > 0, "{} is tested too", kind.key());
        }
    }

    fn staged(family: PoseFamily, cost: f32) -> Staged {
        Staged { params: BodyParams::default(), family, joints: Vec::new(), cost }
    }

    #[test]
    fn people_are_balanced_over_what_the_room_affords_and_the_best_are_taken() {
        let mut all: Vec<Staged> = (0..9).map(|i| staged(PoseFamily::Stand, i as f32)).collect();
        all.extend([staged(PoseFamily::SitChair, 5.0), staged(PoseFamily::SitChair, 1.0)]);
        all.push(staged(PoseFamily::LieUp, 9.0));
        let taken = balanced(all, 5);
        let families: Vec<(&str, f32)> = taken.iter().map(|s| (s.family.group(), s.cost)).collect();
        assert_eq!(families, [("sit", 1.0), ("lie", 9.0), ("stand", 0.0), ("sit", 5.0), ("stand", 1.0)]);
    }
}
