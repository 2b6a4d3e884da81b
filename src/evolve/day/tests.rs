//! Promises to a user: one timeline in the sample office.

use std::sync::{Arc, LazyLock};

use super::*;
use crate::assets::{Budget, read_model_bytes, sample_rooms};
use crate::evolve::action::{ActionModel, Library, Stage};
use crate::job::{Seed, Ticker};
use crate::scene::{ImportOptions, room_from_model};

/// A day of two actions, not fitted.
static DAY: LazyLock<Day> = LazyLock::new(|| {
    let sample = sample_rooms().iter().find(|r| r.key == "office").expect("bundled");
    let model = read_model_bytes(sample.key, sample.glb, &Budget::default()).expect("reads");
    let room = Arc::new(room_from_model(&model, &ImportOptions::default()).room);
    let stage = Stage::new(room, Library::bundled(), &Ticker::silent()).expect("not cancelled");
    let actions = ActionModel::bundled().expect("bundled");
    let start = Evolution::new(Arc::new(stage), actions, EvolutionConfig::usual(), Seed::root(1));
    let request = DayRequest { actions: 2, stay_s: 1.0, optimise: false };
    match day(&start, &request, &JobCtx::headless(Seed::root(1))) {
        Ok(day) => day,
        Err(why) => panic!("{why:?}"),
    }
});

#[test]
fn a_day_has_its_actions_one_after_the_other_and_things_change_when_somebody_gets_there() {
    let day = &*DAY;
    assert_eq!((day.moments.len(), day.states.len()), (2, 3), "{:?}", day.refused);
    let mut now_s = 0.0;
    for moment in &day.moments {
        assert!(
            now_s <= moment.changes_s && moment.changes_s <= moment.arrives_s,
            "{moment:?} after {now_s}"
        );
        assert!(moment.leaves_s - moment.arrives_s > 0.9, "it is done for a while: {moment:?}");
        now_s = moment.leaves_s;
    }
    assert!(day.clip.seconds() >= now_s && day.clip.planted.len() == day.clip.frames.len());
    let jump = |pair: &[crate::scene::Frame]| pair[0].translation.distance(pair[1].translation);
    let fastest = day.clip.frames.windows(2).map(jump).fold(0.0, f32::max);
    assert!(fastest * day.clip.fps < 3.0, "nobody leaps: {} m/s", fastest * day.clip.fps);
    assert_eq!(day.state_at(0.0).steps().len(), 0);
    assert_eq!(day.state_at(day.moments[0].arrives_s).steps().len(), 1);
}

#[test]
fn tracks_end_where_things_are_and_begin_where_they_were() {
    let day = &*DAY;
    let (first, last) = (&day.states[0], &day.states[2]);
    let tracks = day.tracks();
    assert!(tracks.iter().any(|t| t.comes_s.is_some()), "something was brought");
    for track in &tracks {
        let item = last.world().item(track.object).expect("there in the end");
        let apart = track.last().translation.distance(item.world_from_found().translation);
        assert!(apart < 1e-5, "{}: {apart}", item.name);
        assert!(track.places.windows(2).all(|w| w[0].at_s <= w[1].at_s));
        match first.world().item(track.object) {
            Some(before) => {
                assert!(track.places[0].at_m.distance(before.world_from_found().translation.into()) < 1e-5);
            }
            None => assert!(track.comes_s.is_some(), "{} came from nowhere", item.name),
        }
    }
}
