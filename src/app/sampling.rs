//! How people are sampled from a view, fitted and drawn small, as it really is: the part of the engine behind the
//! contact sheet. Runs in jobs; may not touch the editor's state.

use std::sync::Arc;

use glam::Vec3;
use rayon::prelude::*;

use super::engine::{Candidate, FitTask, Made, SampleMethod, SampleTask, SampleView, Sampled};
use super::real::by_term;
use crate::body::Body;
use crate::evolve::PopulatePreview;
use crate::evolve::RefinePreview;
use crate::evolve::RefineRequest;
use crate::evolve::Refined;
use crate::evolve::clear_of_others;
use crate::evolve::family_of;
use crate::evolve::refine;
use crate::fit::FitConfig;
use crate::fit::Fitter;
use crate::fit::Surroundings;
use crate::generate::SearchRequest;
use crate::generate::learned::LearnedError;
use crate::generate::learned::LearnedMethod;
use crate::generate::learned::LearnedSampler;
use crate::generate::search;
use crate::generate::sensor::AgentConfig;
use crate::generate::sensor::Intrinsics;
use crate::generate::sensor::SceneImage;
use crate::generate::sensor::Sensor;
use crate::generate::sensor::View;
use crate::generate::sensor::agent_views;
use crate::inspect::inspect_body;
use crate::job::{Cancelled, JobCtx, Seed, Stop, Ticker};
use crate::math::Aabb;
use crate::nn::psi::PsiMethod;
use crate::render::BodySurface;
use crate::render::PersonDraw;
use crate::render::Picture;
use crate::render::SceneDraw;
use crate::render::person_views;
use crate::render::render_on_processor;
use crate::scene::BodyParams;
use crate::scene::Camera;
use crate::scene::Person;
use crate::scene::PersonId;
use crate::scene::PoseFamily;
use crate::scene::Room;
use crate::scene::RoomGeometry;
use crate::scene::Scene;

/// Columns of the view's picture; what the networks get is 128 wide at most.
const COLUMNS: f32 = 480.0;
/// A camera needs this much air around it, metres.
const AIR_M: f32 = 0.15;
/// How far a camera outside the room is moved along its view to get in, metres, and in which steps.
const WAY_IN_M: f32 = 40.0;
const WAY_IN_STEP_M: f32 = 0.05;
/// Proposals of the search for each candidate wanted: many are out of sight.
const PROPOSALS_PER_CANDIDATE: usize = 3;
/// Rounds of the search before fewer candidates than wanted are reported.
const ROUNDS: u64 = 4;
/// Side of a candidate's picture in pixels.
const PORTRAIT: u32 = 128;
/// Report pictures leave air around a body; a small one has to fill its frame.
const CLOSER: f32 = 0.85;
/// What lies farther from a person than this is left out of the picture, metres.
const NEAR_M: f32 = 1.5;

/// The camera of a sampling. A camera outside the room, looking in over a wall that is cut away, is moved
/// forward until it is inside, and sees through a wide lens from there.
///
/// # Errors
/// When there is no free spot to look from.
pub fn view_of(room: &Room, geometry: &RoomGeometry, view: &SampleView, seed: Seed) -> Result<View, Stop> {
    match view {
        SampleView::Camera(camera, aspect) => from_camera(geometry, camera, *aspect).ok_or_else(|| {
            let why = "this view does not look into the room: turn it towards the inside and sample again";
            Stop::Failed(why.to_owned())
        }),
        SampleView::Agent => {
            let sensor = Sensor::new(room, geometry);
            agent_views(&sensor, 1, &AgentConfig::default(), seed.child("view", 0)).pop().ok_or_else(|| {
                let why =
                    "nobody can stand in this room, so nobody can look around: sample from your own view";
                Stop::Failed(why.to_owned())
            })
        }
    }
}

fn from_camera(geometry: &RoomGeometry, camera: &Camera, aspect: f32) -> Option<View> {
    let is_free = |p: Vec3| geometry.bounds.contains(p) && geometry.field.sample(p) > AIR_M;
    let rows = (COLUMNS / aspect.clamp(0.25, 4.0)).round();
    if camera.ortho_height_m.is_none() && is_free(camera.eye) {
        return Some(View::from_camera(camera, COLUMNS as u32, rows as u32));
    }
    let forward = camera.forward();
    let start =
        if camera.ortho_height_m.is_some() { camera.target - forward * WAY_IN_M * 0.5 } else { camera.eye };
    let steps = (WAY_IN_M / WAY_IN_STEP_M) as usize;
    let eye = (1..=steps).map(|i| start + forward * (i as f32 * WAY_IN_STEP_M)).find(|p| is_free(*p))?;
    Some(View::look_at(eye, eye + forward, Intrinsics::PROX_E))
}

/// Samples people from a view and measures them.
///
/// # Errors
/// As [`view_of`]; or cancelled.
pub fn sample(task: &SampleTask, cx: &JobCtx<PopulatePreview>) -> Result<Sampled, Stop> {
    cx.stage("looking", 0)?;
    let view = view_of(&task.room, &task.geometry, &task.view, cx.seed)?;
    let seen = Sensor::new(&task.room, &task.geometry).scene_image(&view);
    let people = match task.method {
        SampleMethod::Search => searched(task, &view, cx)?,
        method => drawn(task, network(method)?, &seen, cx)?,
    };
    let shortfall = (people.len() < task.count)
        .then(|| format!("{} of {} candidates: this view affords no more", people.len(), task.count));
    let candidates = measured(&task.geometry, people, cx)?;
    Ok(Sampled { seen: Arc::new(seen), candidates, shortfall })
}

/// The network behind a method.
///
/// # Errors
/// When this build has none.
pub fn network(method: SampleMethod) -> Result<&'static LearnedSampler, Stop> {
    let of = network_of(method).ok_or_else(|| Stop::Failed(format!("{} is no network", method.label())))?;
    Ok(LearnedSampler::bundled(of)?)
}

fn network_of(method: SampleMethod) -> Option<LearnedMethod> {
    let network = match method {
        SampleMethod::S1 => PsiMethod::S1,
        SampleMethod::S2 => PsiMethod::S2,
        SampleMethod::Baseline => PsiMethod::Baseline,
        SampleMethod::Search | SampleMethod::Photo => return None,
    };
    Some(LearnedMethod::best_of(network))
}

/// Why a method can't be used; `None` when it can.
pub fn why_missing(method: SampleMethod) -> Option<String> {
    let missing = network_of(method).filter(|of| !LearnedSampler::is_bundled(*of))?;
    Some(LearnedError::NotBundled(missing.label()).to_string())
}

/// Bodies that a network draws from the image.
fn drawn(
    task: &SampleTask,
    network: &LearnedSampler,
    seen: &SceneImage,
    cx: &JobCtx<PopulatePreview>,
) -> Result<Vec<Person>, Stop> {
    cx.stage("sampling", task.count)?;
    let people = |bodies: &[BodyParams]| -> Vec<Person> {
        let somebody = |(number, body): (usize, &BodyParams)| {
            let family = family_of(&task.geometry, Body::bundled(), body);
            let seed = cx.seed.child("sample", number as u64).value();
            somebody(number, body.clone(), family, "not fitted yet".to_owned(), seed)
        };
        bodies.par_iter().enumerate().map(somebody).collect()
    };
    let mut show = |bodies: &[BodyParams]| cx.preview(PopulatePreview { people: people(bodies) });
    let bodies = network.sample(seen, task.count, cx.seed, cx.ticker(), &mut show)?;
    Ok(people(&bodies))
}

/// Proposals of the search whose pelvis the view sees.
fn searched(task: &SampleTask, view: &View, cx: &JobCtx<PopulatePreview>) -> Result<Vec<Person>, Stop> {
    let body = Body::bundled();
    let mut people: Vec<Person> = Vec::new();
    for round in 0..ROUNDS {
        let missing = task.count - people.len();
        if missing == 0 {
            break;
        }
        let wanted =
            SearchRequest { proposals: PROPOSALS_PER_CANDIDATE * missing + 4, ..SearchRequest::default() };
        let seed = cx.seed.child("round", round);
        let proposals = search(&task.room, &task.geometry, body, &wanted, seed, cx.ticker())?;
        let visible =
            proposals.into_iter().filter(|p| is_seen(&task.geometry, view, middle(body, &p.params)));
        for proposal in visible.take(missing) {
            let (family, on, seed) = (proposal.family, proposal.on, proposal.seed.value());
            people.push(somebody(people.len(), proposal.params, family, on, seed));
        }
        cx.preview(PopulatePreview { people: people.clone() });
    }
    Ok(people)
}

/// The middle of a body's skin, metres, world frame.
fn middle(body: &Body, params: &BodyParams) -> Vec3 {
    Aabb::of(body.pose(params).vertices).center()
}

/// Whether a point is in the picture and nothing stands before it.
fn is_seen(geometry: &RoomGeometry, view: &View, point: Vec3) -> bool {
    let inside = view.project(point).is_some_and(|(pixel, _)| view.holds(pixel));
    let way = point - view.eye();
    // The last 30 cm may be what the body lies or sits in.
    inside && !geometry.bvh.any_hit(view.eye(), way.normalize_or(Vec3::Z), (way.length() - 0.3).max(0.0))
}

fn somebody(number: usize, body: BodyParams, family: PoseFamily, on: String, seed: u64) -> Person {
    Person {
        id: PersonId(number as u32),
        name: format!("Candidate {}", number + 1),
        body,
        family,
        on,
        seed,
        palette: number as u32,
        visible: true,
        locked: false,
    }
}

fn measured(
    geometry: &RoomGeometry,
    people: Vec<Person>,
    cx: &JobCtx<PopulatePreview>,
) -> Result<Vec<Candidate>, Cancelled> {
    cx.stage("measuring", people.len())?;
    let measure = |person: Person| {
        let report = inspect_body(geometry, Body::bundled(), &person.body);
        cx.advance()?;
        Ok(Candidate { person, report })
    };
    people.into_par_iter().map(measure).collect()
}

/// Fits people: by what they are known to do, or by what is found out about them.
///
/// # Errors
/// Cancelled.
pub fn fit(task: &FitTask, cx: &JobCtx<PopulatePreview>) -> Result<Made, Stop> {
    let made = if task.knows_family { fit_known(task, cx) } else { fit_guessed(task, cx) }?;
    Ok(match &task.clear_of {
        Some(there) => without_meetings(there, made),
        None => made,
    })
}

fn kept<T>(all: Vec<T>, clear: &[bool]) -> Vec<T> {
    all.into_iter().zip(clear).filter(|(_, clear)| **clear).map(|(one, _)| one).collect()
}

/// Leaves out whoever would end in somebody who is there or who was accepted before.
fn without_meetings(there: &[Person], made: Made) -> Made {
    let bodies = |people: &[Person]| people.iter().map(|p| p.body.clone()).collect::<Vec<BodyParams>>();
    let clear = clear_of_others(&bodies(there), &bodies(&made.people));
    let left_out = clear.iter().filter(|clear| !**clear).count();
    let shortfall = (left_out > 0)
        .then(|| format!("{left_out} of {} left out: they would end in somebody else.", made.people.len()));
    Made {
        people: kept(made.people, &clear),
        reports: kept(made.reports, &clear),
        energies: kept(made.energies, &clear),
        before: kept(made.before, &clear),
        shortfall,
    }
}

fn fit_guessed(task: &FitTask, cx: &JobCtx<PopulatePreview>) -> Result<Made, Stop> {
    let samples: Vec<BodyParams> = task.people.iter().map(|p| p.body.clone()).collect();
    let people = task.people.clone();
    let shown = cx.mapped(move |preview: RefinePreview| {
        let begun = preview.bodies.into_iter().filter_map(|(index, body)| {
            let person = people.get(index)?;
            Some(Person { body, ..person.clone() })
        });
        PopulatePreview { people: begun.collect() }
    });
    let refined = refine(&task.room, &task.geometry, &samples, &RefineRequest::default(), &shown)?;
    let mut made = Made::default();
    for (person, Refined { before, params, family, on, report, trace, .. }) in task.people.iter().zip(refined)
    {
        made.people.push(Person { body: params, family, on, ..person.clone() });
        made.reports.push(report);
        made.energies.push(by_term(&trace));
        made.before.push(before);
    }
    Ok(made)
}

fn fit_known(task: &FitTask, cx: &JobCtx<PopulatePreview>) -> Result<Made, Stop> {
    cx.stage("fitting people", task.people.len())?;
    let fitter = Fitter::new(Body::bundled());
    let config = FitConfig { preview_every: 8, ..FitConfig::default() };
    let shown = std::sync::Mutex::new(task.people.clone());
    let one = |(index, person): (usize, &Person)| {
        let mut show = |params: &BodyParams| {
            let mut shown = shown.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            shown[index].body = params.clone();
            cx.preview(PopulatePreview { people: shown.clone() });
        };
        let around = Aabb::of(Body::bundled().pose(&person.body).vertices);
        let around = Surroundings::new(&task.geometry, around);
        let fitted = fitter.fit(&around, &person.body, person.family, &config, cx.ticker(), &mut show)?;
        let report = inspect_body(&task.geometry, Body::bundled(), &fitted.params);
        cx.advance()?;
        Ok((fitted, report))
    };
    let fitted: Vec<_> = task.people.par_iter().enumerate().map(one).collect::<Result<_, Cancelled>>()?;
    let mut made = Made::default();
    for (person, (fitted, report)) in task.people.iter().zip(fitted) {
        made.people.push(Person { body: fitted.params, ..person.clone() });
        made.reports.push(report);
        made.energies.push(by_term(&fitted.trace));
        made.before.push(person.body.clone());
    }
    Ok(made)
}

/// A small picture of somebody among what stands near, drawn on the processor: it needs no graphics device and
/// leaves the window's alone.
///
/// # Errors
/// What the renderer says; or cancelled.
pub fn portrait(
    room: &Room,
    geometry: &RoomGeometry,
    person: &Person,
    surface: &Arc<BodySurface>,
    ticker: &Ticker,
) -> Result<Picture, Stop> {
    ticker.check()?;
    let vertices = Body::bundled().pose(&person.body).vertices;
    let around = Aabb::of(vertices.iter().copied()).grown(NEAR_M);
    let objects =
        room.objects.iter().filter(|object| meets(&object.world_bounds(), &around)).cloned().collect();
    let near = Room { objects, ..room.clone() };
    let camera = person_views(&vertices, &geometry.bvh, 1, 1.0).into_iter().next().unwrap_or_default();
    let camera = Camera { fov_y: camera.fov_y * CLOSER, ..camera };
    let mut draw = SceneDraw::of_room(&Scene { room: Arc::new(near), ..Scene::default() });
    draw.body = Some(surface.clone());
    draw.people = vec![PersonDraw::new(person.id, vertices.into(), person.palette)];
    ticker.check()?;
    Ok(render_on_processor(&draw, &camera, [PORTRAIT, PORTRAIT])?)
}

fn meets(a: &Aabb, b: &Aabb) -> bool {
    a.min.cmple(b.max).all() && b.min.cmple(a.max).all()
}
