//! Photos and the people in them, as it really is: the part of the engine behind *Fit to a photo*.

use std::path::Path;

use super::engine::{Made, Photo, PhotoMethod, PhotoTask, SampleMethod};
use super::sampling;
use crate::assets::Budget;
use crate::assets::PictureKeypoints;
use crate::assets::read_keypoints;
use crate::assets::read_photo;
use crate::evolve::EstimateRequest;
use crate::evolve::EstimatorKind;
use crate::evolve::PopulatePreview;
use crate::evolve::estimate_person;
use crate::fit::estimation::ESTIMATE_TERMS;
use crate::generate::sensor::Sensor;
use crate::generate::sensor::View;
use crate::inspect::Limits;
use crate::job::{JobCtx, Stop};
use crate::render::Picture;
use crate::scene::BodyParams;
use crate::scene::POSE;
use crate::scene::Person;
use crate::scene::PersonId;
use crate::scene::PoseFamily;

/// Reads a photo and the keypoints of whoever is in it.
///
/// # Errors
/// What, which file and place, what to do.
pub fn open(picture: &Path, keypoints: &Path) -> Result<Photo, Stop> {
    let budget = Budget::default();
    let (texture, size_px) = read_photo(picture, &budget)?;
    let name = picture.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let pictures = read_keypoints(keypoints, &budget)?;
    let people = of_picture(pictures, &name).ok_or_else(|| {
        let file = keypoints.display();
        Stop::Failed(format!("{file}: it has keypoints of other pictures, but none of {name}. Choose the file that belongs to it."))
    })?;
    let (width, height) = (texture.width, texture.height);
    let picture = Picture { width, height, rgba: texture.rgba, backend: String::new() };
    Ok(Photo { picture, size_px, people: people.people })
}

/// The entry of the picture called `name`; the only one where the file names none.
fn of_picture(mut pictures: Vec<PictureKeypoints>, name: &str) -> Option<PictureKeypoints> {
    let by_name = pictures.iter().position(|picture| {
        let file = picture.name.as_deref().map(|of| of.rsplit(['/', '\\']).next().unwrap_or(of));
        file == Some(name)
    });
    match by_name {
        Some(at) => Some(pictures.swap_remove(at)),
        None if pictures.len() == 1 => pictures.pop(),
        None => None,
    }
}

/// Finds a person of a photo in the room.
///
/// # Errors
/// Why it can't be found; or cancelled.
pub fn fit(task: &PhotoTask, cx: &JobCtx<PopulatePreview>) -> Result<Made, Stop> {
    let [width, height] = task.size_px;
    let view = View::from_camera(&task.camera, width, height);
    let (estimator, scene_code) = match task.method {
        PhotoMethod::Keypoints => (EstimatorKind::SmplifyX, [0.0; POSE]),
        PhotoMethod::Room => (EstimatorKind::Prox, [0.0; POSE]),
        PhotoMethod::Scene => (EstimatorKind::SceneAware, scene_code(task, &view, cx)?),
    };
    let keypoints = task.keypoints.clone();
    let request = EstimateRequest { view, keypoints, estimator, scene_code, limits: Limits::default() };
    let id = task.id;
    let shown = cx.mapped(move |body: BodyParams| PopulatePreview {
        people: vec![person(id, body, PoseFamily::Stand)],
    });
    let found = estimate_person(&task.geometry, &request, &shown)?;
    let curve = |i: usize| found.trace.iter().map(|terms| terms[i]).collect();
    let energies =
        ESTIMATE_TERMS.iter().enumerate().map(|(i, term)| (term.label().to_owned(), curve(i))).collect();
    let px = found.reprojection_px;
    Ok(Made {
        people: vec![person(id, found.params, found.family)],
        reports: vec![found.report],
        energies: vec![energies],
        before: Vec::new(),
        shortfall: (px > DOUBTFUL * height as f32).then(|| {
            format!("The body misses the keypoints by {px:.0} pixels on average: is the view where the photo was taken from?")
        }),
    })
}

/// A body that misses its keypoints by more than this share of the photo's height is not that of the photo.
const DOUBTFUL: f32 = 0.03;

/// What people do in this view (PSI §4.2), by the network S1.
fn scene_code(task: &PhotoTask, view: &View, cx: &JobCtx<PopulatePreview>) -> Result<[f32; POSE], Stop> {
    cx.stage("looking", 0)?;
    let seen = Sensor::new(&task.room, &task.geometry).scene_image(view);
    Ok(sampling::network(SampleMethod::S1)?.mean_pose_code(&seen, SCENE_SAMPLES, cx.seed.child("scene", 0)))
}

/// Samples whose mean is what people do in a view (PSI §4.2).
const SCENE_SAMPLES: usize = 100;

fn person(id: u32, body: BodyParams, family: PoseFamily) -> Person {
    Person {
        id: PersonId(id),
        name: format!("Person {}", id + 1),
        body,
        family,
        on: "what the photo shows".to_owned(),
        seed: 0,
        palette: id,
        visible: true,
        locked: false,
    }
}
