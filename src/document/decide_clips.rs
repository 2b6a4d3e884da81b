//! Decides what commands about motions lead to. Pure, as `decide` is.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::change::{Change, Numbered, RoomVersion};
use super::command::Refused;
use super::decide::{Decision, State, numbered, same_room};
use crate::scene::Clip;
use crate::scene::ClipId;
use crate::scene::Frame;
use crate::scene::Scene;
use crate::scene::SubGoal;

/// Key of a leg that must be made again.
const STALE: u64 = 0;

pub fn add(state: &State, clips: Vec<Clip>, made_for: Option<RoomVersion>) -> Decision {
    same_room(state, made_for)?;
    let first = state.scene.clips.len();
    let mut added = Vec::with_capacity(clips.len());
    for (i, mut clip) in clips.into_iter().enumerate() {
        sound(&clip)?;
        clip.id = ClipId(state.next.clip + i as u32);
        added.push(Numbered { index: first + i, value: Arc::new(clip) });
    }
    Ok((!added.is_empty()).then_some(Change::ClipsAdded(added)))
}

pub fn replace(state: &State, clip: Clip, made_for: Option<RoomVersion>) -> Decision {
    same_room(state, made_for)?;
    let before = by_id(state.scene, &[clip.id])?;
    unlocked(&before)?;
    sound(&clip)?;
    Ok(replaced(before, vec![Arc::new(clip)]))
}

pub fn remove(state: &State, ids: &[ClipId]) -> Decision {
    unlocked(&by_id(state.scene, ids)?)?;
    let gone = numbered(&state.scene.clips, |clip| ids.contains(&clip.id));
    Ok((!gone.is_empty()).then_some(Change::ClipsRemoved(gone)))
}

pub fn set_goals(state: &State, id: ClipId, goals: Vec<SubGoal>) -> Decision {
    let before = by_id(state.scene, &[id])?;
    unlocked(&before)?;
    let mut after = before[0].as_ref().clone();
    let changed = |id| {
        let (old, new) = (before[0].goal(id), goals.iter().find(|goal| goal.id == id));
        !old.zip(new).is_some_and(|(old, new)| same_place(old, new))
    };
    for leg in after.legs.iter_mut().filter(|leg| changed(leg.from) || changed(leg.to)) {
        leg.key = STALE;
    }
    // A way that leads over other sub-goals is another way, even where both ends stay.
    for leg in &mut after.legs {
        let place = |id| goals.iter().position(|goal| goal.id == id);
        let next = place(leg.from).zip(place(leg.to)).is_some_and(|(from, to)| to == from || to == from + 1);
        leg.key = if next { leg.key } else { STALE };
    }
    after.goals = goals;
    sound(&after)?;
    Ok(replaced(before, vec![Arc::new(after)]))
}

pub fn edit(state: &State, ids: &[ClipId], edit: impl Fn(&mut Clip)) -> Decision {
    let before = by_id(state.scene, ids)?;
    let edited = before.iter().map(|clip| {
        let mut clip = clip.as_ref().clone();
        edit(&mut clip);
        Arc::new(clip)
    });
    let after = edited.collect();
    Ok(replaced(before, after))
}

/// Whether somebody does the same at both: what is locked or was planned makes no motion another one.
fn same_place(old: &SubGoal, new: &SubGoal) -> bool {
    *old == SubGoal { locked: old.locked, planned: old.planned, ..new.clone() }
}

/// The replacement of those that really differ.
fn replaced(before: Vec<Arc<Clip>>, after: Vec<Arc<Clip>>) -> Option<Change> {
    let (before, after): (Vec<_>, Vec<_>) =
        before.into_iter().zip(after).filter(|(before, after)| before != after).unzip();
    (!before.is_empty()).then_some(Change::ClipsReplaced { before, after })
}

/// The motions named by `ids`, each once, in the order asked for.
fn by_id(scene: &Scene, ids: &[ClipId]) -> Result<Vec<Arc<Clip>>, Refused> {
    let mut seen = BTreeSet::new();
    let once = ids.iter().filter(|id| seen.insert(**id));
    once.map(|id| scene.clip(*id).cloned().ok_or(Refused::NoSuchClip(*id))).collect()
}

fn unlocked(clips: &[Arc<Clip>]) -> Result<(), Refused> {
    let locked = clips.iter().find(|clip| clip.locked);
    locked.map_or(Ok(()), |clip| Err(Refused::Locked(clip.name.clone())))
}

fn sound(clip: &Clip) -> Result<(), Refused> {
    let finite = |goal: &SubGoal| {
        let body = goal.body.as_ref().is_none_or(Frame::is_finite);
        body && goal.at.is_finite() && goal.facing.is_none_or(f32::is_finite) && goal.stay_s.is_finite()
    };
    if !clip.is_finite() || !clip.goals.iter().all(finite) {
        return Err(Refused::NotFinite(clip.name.clone()));
    }
    let ids: BTreeSet<_> = clip.goals.iter().map(|goal| goal.id).collect();
    if ids.len() < clip.goals.len() { Err(Refused::GoalTwice(clip.name.clone())) } else { Ok(()) }
}
