//! Cases of a room: the people in it, each seen by virtual cameras around them.

use super::study::Case;
use crate::body::Body;
use crate::body::joints::BODY_JOINTS;
use crate::evolve::mean_code;
use crate::generate::sensor::{VirtualCameraConfig, virtual_cameras};
use crate::generate::{SearchRequest, search};
use crate::job::{Cancelled, Seed, Ticker};
use crate::learn::corpus::{CorpusRoom, CorpusView, ViewKind};
use crate::scene::{BodyParams, POSE, PoseFamily, Room, RoomGeometry};

/// Samples of a scene over which PSI §4.2 averages the pose code.
pub const SCENE_SAMPLES: usize = 100;

/// Views of a room's people (their families beside them), at most `views_each` of each, numbered from `first`. The
/// scene code is left zero: it belongs to a view, and who samples it is the caller's choice.
pub fn cases_of_room(
    room: &str,
    geometry: &RoomGeometry,
    people: &[(BodyParams, PoseFamily)],
    views_each: usize,
    first: u64,
    seed: Seed,
) -> Vec<Case> {
    let body = Body::bundled();
    let config = VirtualCameraConfig { most: views_each, ..VirtualCameraConfig::default() };
    let mut cases = Vec::new();
    for (index, (truth, family)) in people.iter().enumerate() {
        let joints = &body.joints(truth)[..=BODY_JOINTS];
        let views = virtual_cameras(geometry, joints, &config, seed.child("views", index as u64));
        for view in views {
            let number = first + cases.len() as u64;
            let truth = truth.clone();
            cases.push(Case {
                room: room.to_owned(),
                number,
                family: *family,
                truth,
                view,
                image: None,
                scene_code: [0.0; POSE],
            });
        }
    }
    cases
}

/// Views of a corpus's room, evenly picked up to `most` of those of one kind, numbered from `first`.
pub fn cases_of_corpus(room: &CorpusRoom, kind: ViewKind, most: usize, first: u64, body: &Body) -> Vec<Case> {
    let views: Vec<&CorpusView> =
        room.views.iter().filter(|v| v.kind == kind && v.body < room.people.len()).collect();
    let count = most.min(views.len());
    // Views of one person follow each other: steps pick them from all people.
    let picked = (0..count).map(|i| views[i * views.len() / count]);
    let case = |(index, view): (usize, &CorpusView)| {
        let person = &room.people[view.body];
        Case {
            room: room.name.clone(),
            number: first + index as u64,
            family: person.family,
            truth: person.params(body),
            view: view.view,
            image: Some(view.scene_image()),
            scene_code: [0.0; POSE],
        }
    };
    picked.enumerate().map(case).collect()
}

/// The mean pose code of people that the affordance search proposes for a room: a scene's prior without learning.
///
/// # Errors
/// [`Cancelled`] once the user cancelled.
pub fn scene_code_by_search(
    room: &Room,
    geometry: &RoomGeometry,
    seed: Seed,
    ticker: &Ticker,
) -> Result<[f32; POSE], Cancelled> {
    let request = SearchRequest { proposals: SCENE_SAMPLES, ..SearchRequest::default() };
    let proposals = search(room, geometry, Body::bundled(), &request, seed, ticker)?;
    let samples: Vec<BodyParams> = proposals.into_iter().map(|p| p.params).collect();
    Ok(mean_code(&samples))
}
