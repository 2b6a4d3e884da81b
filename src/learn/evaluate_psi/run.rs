use std::sync::Arc;

use rayon::prelude::*;

use super::placers::{PlaceRequest, Placer};
use super::rows::{
    Evaluation, MethodRepresentation, MethodRow, Missing, PhysicalRow, RepresentationRow, Stage,
};
use crate::body::Body;
use crate::evolve::{RefineRequest, refine};
use crate::fit::FitPreset;
use crate::generate::sensor::{AgentConfig, SceneImage, Sensor, View, agent_views};
use crate::inspect::{BodyMetrics, Limits, Reconstruction, Site, diversity, inspect_body};
use crate::job::{Cancelled, JobCtx, Seed, Stop};
use crate::scene::{BodyParams, Room, RoomGeometry};

/// Bodies that a network reconstructs at once; a cancel acts between batches.
const EXAMPLES_AT_ONCE: usize = 16;

/// How much is evaluated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EvaluationConfig {
    /// Bodies of each method in each room that are measured before fitting (the paper: 1200 a scene).
    pub samples: usize,
    /// Of these, how many are fitted by each fit.
    pub fitted: usize,
    /// Views of each room; the samples are shared out among them.
    pub views: usize,
    /// Bodies that are reconstructed for each column of Table 1, at most.
    pub reconstructed: usize,
}

impl Default for EvaluationConfig {
    fn default() -> Self {
        Self { samples: 96, fitted: 12, views: 4, reconstructed: 400 }
    }
}

/// A room to evaluate in.
pub struct EvaluationRoom {
    /// Name in the rows.
    pub name: String,
    /// The set it belongs to, such as `test rooms`.
    pub set: String,
    /// The room.
    pub room: Arc<Room>,
    /// Its geometry.
    pub geometry: RoomGeometry,
    /// What is seen of it: through PROX-E's virtual cameras in rooms of a corpus (PSI §4.1.1). Empty: an agent's views
    /// are taken, as in MP3D-R.
    pub images: Vec<SceneImage>,
}

/// A body whose reconstruction is measured for Table 1.
pub struct Example {
    /// What the network sees.
    pub image: SceneImage,
    /// The body in the camera's frame.
    pub in_camera: BodyParams,
}

/// What a network makes of an [`Example`].
pub struct Encoded {
    /// The reconstruction from the mean of the code, camera frame.
    pub in_camera: BodyParams,
    /// Divergence of the code's distribution from the standard normal one: a mean over the latent numbers, summed
    /// over the stages of the network.
    pub divergence: f32,
}

/// A network that encodes and reconstructs bodies.
pub trait Representer: Send + Sync {
    /// Encodes each body in its scene and decodes it again.
    fn reconstruct(&self, examples: &[Example]) -> Vec<Encoded>;
}

/// A row of the tables that is to be filled.
pub struct MethodToEvaluate {
    /// Name in the tables.
    pub name: String,
    /// Puts bodies into rooms; or why it can't.
    pub placer: Result<Box<dyn Placer>, String>,
    /// Encodes bodies, for Table 1; `None` for what has no code.
    pub representer: Option<Box<dyn Representer>>,
}

/// A body and what was measured of it.
struct Measured {
    world: BodyParams,
    camera: BodyParams,
    metrics: BodyMetrics,
    faultless: bool,
}

/// All bodies of one method at one stage in one room.
struct Cell {
    method: usize,
    stage: Stage,
    bodies: Vec<Measured>,
}

/// What [`Evaluator::room`] found in one room.
struct RoomCells {
    name: String,
    set: String,
    cells: Vec<Cell>,
}

/// Collects rooms one after the other, so that only one is in memory.
pub struct Evaluator {
    methods: Vec<MethodToEvaluate>,
    config: EvaluationConfig,
    rooms: Vec<RoomCells>,
    representation: Vec<MethodRepresentation>,
}

impl Evaluator {
    /// Of these methods.
    pub fn new(methods: Vec<MethodToEvaluate>, config: EvaluationConfig) -> Self {
        let row = |m: &MethodToEvaluate| MethodRepresentation {
            method: m.name.clone(),
            validation: None,
            test: None,
        };
        let represents = methods.iter().filter(|m| m.representer.is_some() || m.placer.is_err());
        let representation = represents.map(row).collect();
        Self { methods, config, rooms: Vec::new(), representation }
    }

    /// Places, fits and measures the bodies of every method in a room.
    ///
    /// # Errors
    /// [`Stop::Cancelled`] when the user cancelled; a sampler's failure.
    pub fn room(&mut self, room: &EvaluationRoom, cx: &JobCtx) -> Result<(), Stop> {
        let number = self.rooms.len() as u64;
        let sensor = Sensor::new(&room.room, &room.geometry);
        let seed = cx.seed.child("room", number);
        let images = if room.images.is_empty() {
            let views = agent_views(&sensor, self.config.views, &AgentConfig::default(), seed);
            sensor.scene_images(&views, cx.ticker())?
        } else {
            room.images.clone()
        };
        let mut cells = Vec::new();
        for (index, method) in self.methods.iter().enumerate() {
            let Ok(placer) = &method.placer else { continue };
            cx.stage("placing and fitting bodies", 0)?;
            let seed = seed.child("method", index as u64);
            let placed = place_all(placer.as_ref(), room, &images, self.config.samples, seed, cx)?;
            cells.extend(stages(room, placed, index, &self.config, seed, cx)?);
        }
        self.rooms.push(RoomCells { name: room.name.clone(), set: room.set.clone(), cells });
        Ok(())
    }

    /// Fills a column of Table 1: validation (rooms of the training) or test.
    ///
    /// # Errors
    /// [`Cancelled`] when the user cancelled.
    pub fn represent(&mut self, examples: &[Example], is_test: bool, cx: &JobCtx) -> Result<(), Cancelled> {
        let examples = &examples[..examples.len().min(self.config.reconstructed)];
        cx.stage("reconstructing bodies", examples.len() * self.methods.len())?;
        for row in &mut self.representation {
            let method = self.methods.iter().find(|m| m.name == row.method);
            let Some(representer) = method.and_then(|m| m.representer.as_deref()) else { continue };
            let found = representation(representer, examples, cx)?;
            *(if is_test { &mut row.test } else { &mut row.validation }) = found;
        }
        Ok(())
    }

    /// The rows of everything that was collected: each set as a whole, then its rooms.
    pub fn finish(self, seed: Seed) -> Evaluation {
        let mut rows = Vec::new();
        let mut sets: Vec<&str> = Vec::new();
        for room in &self.rooms {
            if !sets.contains(&room.set.as_str()) {
                sets.push(&room.set);
            }
        }
        for set in &sets {
            let rooms: Vec<&RoomCells> = self.rooms.iter().filter(|r| r.set == **set).collect();
            rows.extend(self.rows_of(&rooms, set, None, seed));
            for room in rooms {
                rows.extend(self.rows_of(&[room], set, Some(&room.name), seed));
            }
        }
        let missing = self.methods.iter().filter_map(|m| {
            let why = m.placer.as_ref().err()?.clone();
            Some(Missing { method: m.name.clone(), why })
        });
        Evaluation { rows, missing: missing.collect(), representation: self.representation }
    }

    fn rows_of(&self, rooms: &[&RoomCells], set: &str, room: Option<&str>, seed: Seed) -> Vec<MethodRow> {
        let stages = Stage::ALL.into_iter();
        let places: Vec<(Stage, usize)> =
            stages.flat_map(|s| (0..self.methods.len()).map(move |m| (s, m))).collect();
        let row = |(stage, method): (Stage, usize)| {
            let cells =
                rooms.iter().flat_map(|r| &r.cells).filter(|c| (c.method, c.stage) == (method, stage));
            let bodies: Vec<&Measured> = cells.flat_map(|c| &c.bodies).collect();
            let figures = self.methods[method].placer.is_ok().then(|| figures(&bodies, seed));
            let (method, set, room) =
                (self.methods[method].name.clone(), set.into(), room.map(str::to_owned));
            MethodRow { method, set, room, stage, figures }
        };
        places.into_par_iter().map(row).collect()
    }
}

fn figures(bodies: &[&Measured], seed: Seed) -> PhysicalRow {
    let all = |of: &dyn Fn(&Measured) -> BodyParams| bodies.iter().map(|m| of(m)).collect::<Vec<_>>();
    let seed = seed.child("clusters", 0).value();
    let camera = diversity(&all(&|m| m.camera.clone()), seed);
    let world = diversity(&all(&|m| m.world.clone()), seed);
    let measured: Vec<_> = bodies.iter().map(|m| (m.metrics.clone(), m.faultless)).collect();
    PhysicalRow::of(&measured, camera, world)
}

/// Bodies of every view, taken from the views in turn, each with its view.
fn place_all(
    placer: &dyn Placer,
    room: &EvaluationRoom,
    images: &[SceneImage],
    samples: usize,
    seed: Seed,
    cx: &JobCtx,
) -> Result<Vec<(View, BodyParams)>, Stop> {
    let mut of_views = Vec::new();
    for (index, image) in images.iter().enumerate() {
        let count = samples / images.len() + usize::from(index < samples % images.len());
        let seed = seed.child("view", index as u64);
        let request = PlaceRequest { room: &room.room, geometry: &room.geometry, image, count, seed };
        of_views.push((image.view, placer.place(&request, cx.ticker())?.into_iter()));
    }
    let mut placed = Vec::with_capacity(samples);
    let mut any = true;
    while any {
        any = false;
        for (view, bodies) in &mut of_views {
            let next = bodies.next();
            any |= next.is_some();
            placed.extend(next.map(|body| (*view, body)));
        }
    }
    Ok(placed)
}

/// The placed bodies and the first of them fitted, all measured.
fn stages(
    room: &EvaluationRoom,
    placed: Vec<(View, BodyParams)>,
    method: usize,
    config: &EvaluationConfig,
    seed: Seed,
    cx: &JobCtx,
) -> Result<Vec<Cell>, Stop> {
    let starts: Vec<BodyParams> = placed.iter().take(config.fitted).map(|(_, body)| body.clone()).collect();
    let views: Vec<View> = placed.iter().map(|(view, _)| *view).collect();
    let before = measure_all(room, placed, cx)?;
    let mut cells = vec![Cell { method, stage: Stage::Before, bodies: before }];
    // The published fit for rooms that an agent walks: `fitting_habitat`.
    let presets = [(Stage::PublishedFit, FitPreset::PsiMatterport), (Stage::OurFit, FitPreset::Rescue)];
    for (stage, preset) in presets {
        let request = RefineRequest::of_preset(preset);
        let cx = JobCtx::watched(seed.child("refine", 0), cx.ticker().clone());
        let refined = refine(&room.room, &room.geometry, &starts, &request, &cx)?;
        let body = Body::bundled();
        let bodies = refined.into_iter().zip(&views).map(|(refined, view)| Measured {
            camera: view.body_in_camera(&refined.params, &body.model),
            world: refined.params,
            metrics: refined.report.metrics,
            faultless: refined.findings.is_empty(),
        });
        cells.push(Cell { method, stage, bodies: bodies.collect() });
    }
    Ok(cells)
}

fn measure_all(
    room: &EvaluationRoom,
    placed: Vec<(View, BodyParams)>,
    cx: &JobCtx,
) -> Result<Vec<Measured>, Cancelled> {
    let body = Body::bundled();
    let measure = |(view, world): (View, BodyParams)| {
        cx.check()?;
        let metrics = inspect_body(&room.geometry, body, &world).metrics;
        let findings = Limits::default().findings(Site { body: 0, frame: None }, &metrics);
        let camera = view.body_in_camera(&world, &body.model);
        Ok(Measured { camera, world, metrics, faultless: findings.is_empty() })
    };
    placed.into_par_iter().map(measure).collect()
}

fn representation(
    representer: &dyn Representer,
    examples: &[Example],
    cx: &JobCtx,
) -> Result<Option<RepresentationRow>, Cancelled> {
    let mut row = RepresentationRow::default();
    for batch in examples.chunks(EXAMPLES_AT_ONCE) {
        cx.check()?;
        for (example, encoded) in batch.iter().zip(representer.reconstruct(batch)) {
            let projection = example.image.projection();
            let project = |body: &BodyParams| projection.normalize(body.translation);
            let found = Reconstruction::of(
                (&example.in_camera, project(&example.in_camera)),
                (&encoded.in_camera, project(&encoded.in_camera)),
            );
            row.bodies += 1;
            row.error += found.error();
            row.negative_elbo += found.negative_elbo(encoded.divergence);
            row.divergence += encoded.divergence;
            cx.advance()?;
        }
    }
    let count = row.bodies.max(1) as f32;
    (row.error, row.negative_elbo, row.divergence) =
        (row.error / count, row.negative_elbo / count, row.divergence / count);
    Ok((row.bodies > 0).then_some(row))
}
