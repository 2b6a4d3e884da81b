//! A day in the room: somebody goes from action to action on one timeline, and the room is shown as it is by then. One
//! undo step; the states on the way are states of the tree of futures.

use std::sync::Arc;

use super::engine::RoomChanges;
use super::lived::LivedDay;
use super::living::LifeNode;
use super::state::EditorState;
use crate::document::Command;
use crate::document::RoomVersion;
use crate::evolve::day::Moment;
use crate::evolve::day::Track;
use crate::job::{Job, JobCtx, Seed};
use crate::scene::Clip;
use crate::scene::ClipId;
use crate::scene::ObjectId;

/// A day that was made: which state of the tree holds from when on.
#[derive(Clone, Debug, PartialEq)]
pub struct ShownDay {
    /// The person's motion.
    pub clip: ClipId,
    /// The state before anything was done.
    first: usize,
    /// Seconds, and the state from then on.
    changes: Vec<(f32, usize)>,
    /// How things come and move.
    tracks: Vec<Track>,
    /// What is done when.
    pub moments: Vec<Moment>,
}

impl ShownDay {
    /// The state at a time.
    fn node_at(&self, seconds: f32) -> usize {
        let begun = self.changes.iter().take_while(|(from_s, _)| *from_s <= seconds);
        begun.last().map_or(self.first, |(_, node)| *node)
    }

    /// What is done at a time, in words; nothing on the way.
    pub fn told_at(&self, seconds: f32) -> Option<String> {
        let now = self.moments.iter().find(|m| (m.arrives_s..=m.leaves_s).contains(&seconds))?;
        let (action, key) = (&now.action, &now.key);
        Some(format!("{action}, at {key}: {:.1} to {:.1} s", now.arrives_s, now.leaves_s))
    }
}

/// The room is no longer the one that a day ends in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RoomIsAnother;

/// A day that is being made.
pub(super) struct LivingDay {
    pub job: Job<LivedDay, LivedDay>,
    from: usize,
    version: RoomVersion,
    newest: Option<LivedDay>,
}

impl LivingDay {
    /// Whether there is a day so far, that a stop would keep.
    #[cfg(test)]
    pub fn has_begun(&self) -> bool {
        self.newest.is_some()
    }
}

impl EditorState {
    /// Starts to make a day of as many actions as *Sample* would do.
    pub fn start_day(&mut self) {
        if self.is_living() {
            return self.notices.warning("An action is being done already: wait or cancel.");
        }
        let Some(from) = self.life_now() else {
            return self.notices.warning("The room was changed by hand: look for actions again first.");
        };
        let objects = self.document.scene().room.objects.iter();
        let locked: Vec<ObjectId> = objects.filter(|o| o.locked).map(|o| o.id).collect();
        let start = self.living.tree[from].lived.decided(&self.living.choice, &locked);
        let actions = self.living.count.max(1);
        let work = move |cx: &JobCtx<LivedDay>| start.day(actions, cx);
        let job = Job::spawn("A day in this room", Seed::root(self.living.seed), self.waker(), work);
        self.jobs.day = Some(LivingDay { job, from, version: self.document.room_version(), newest: None });
    }

    pub(super) fn poll_day(&mut self) {
        let Some(living) = &mut self.jobs.day else { return };
        living.newest = living.job.take_preview().or(living.newest.take());
        let Some(outcome) = living.job.poll() else { return };
        let Some(LivingDay { job, from, version, .. }) = self.jobs.day.take() else { return };
        let Some(day) = self.taken(job.name(), outcome) else { return };
        if version != self.document.room_version() {
            return self.notices.warning("The room was changed while this was done, so it no longer fits.");
        }
        let wanted = self.living.count.max(1);
        if let Some(why) = day.refused.last().filter(|_| day.states.len() < wanted) {
            self.notices.warning(format!("{} of {wanted} actions: {why}", day.states.len()));
        }
        self.take_in_day(day, from);
    }

    /// Lets go of the job; the day as far as it has come stays, as one step.
    pub(super) fn stop_day(&mut self) {
        let Some(LivingDay { job, from, version, newest }) = self.jobs.day.take() else { return };
        job.cancel();
        let so_far = job.take_preview().or(newest).filter(|_| version == self.document.room_version());
        let Some(day) = so_far else { return self.notices.info("Cancelled. Nothing was changed.") };
        let kept = day.states.len();
        self.take_in_day(day, from);
        self.notices.info(format!("Cancelled. The day up to its action {kept} is kept; undo takes it back."));
    }

    /// The states join the tree, the room becomes the last one and the motion is added: one step.
    fn take_in_day(&mut self, day: LivedDay, from: usize) {
        let mut parent = from;
        let mut changes = Vec::new();
        for (lived, moment) in day.states.into_iter().zip(&day.moments) {
            self.living.tree.push(LifeNode::of_day(parent, lived));
            parent = self.living.tree.len() - 1;
            changes.push((moment.changes_s, parent));
        }
        let clip = ClipId(self.document.next_clip());
        self.document.begin("A day in this room");
        self.show_life(parent);
        let name = format!("Day {}", clip.0 + 1);
        let clips = vec![Clip { id: clip, name, palette: clip.0, locked: true, ..day.clip }];
        self.apply(Command::AddClips { clips, made_for: None });
        self.document.commit();
        self.living.day =
            Some(ShownDay { clip, first: from, changes, tracks: day.tracks, moments: day.moments });
        self.activate_clip(clip);
        self.motion.player.seconds = 0.0;
        self.motion.player.playing = true;
        self.requests.show_timeline = true;
    }

    /// The state of the tree that a day shows at the time that is played, while the document holds that day.
    pub(super) fn day_node(&self) -> Option<usize> {
        let day = self.living.day.as_ref()?;
        let clip = self.document.scene().clip(day.clip).filter(|clip| clip.visible)?;
        let (_, last) = *day.changes.last()?;
        let node = day.node_at(self.motion.player.seconds.min(clip.seconds()));
        (self.life_now() == Some(last) && node != last).then_some(node)
    }

    /// How the room changes while motions play that are written to a file: not at all without a day among them.
    pub(super) fn room_changes(&self, clips: &[Arc<Clip>]) -> Result<RoomChanges, RoomIsAnother> {
        let Some(day) = self.living.day.as_ref().filter(|day| clips.iter().any(|c| c.id == day.clip)) else {
            return Ok(RoomChanges::default());
        };
        if self.life_now() != day.changes.last().map(|(_, node)| *node) {
            return Err(RoomIsAnother);
        }
        let state = |(from_s, node): (f32, usize)| Some((from_s, self.life_scene(node)?.0.clone()));
        let states = std::iter::once((0.0, day.first)).chain(day.changes.iter().copied());
        Ok(RoomChanges { tracks: day.tracks.clone(), rooms: states.filter_map(state).collect() })
    }

    /// The day that a motion is, if it is one.
    pub fn day_of(&self, clip: ClipId) -> Option<&ShownDay> {
        self.living.day.as_ref().filter(|day| day.clip == clip)
    }

    /// Whether a motion is a day: its room changes under it, so that it can't be measured against one room.
    pub(super) fn is_day(&self, clip: &Arc<Clip>) -> bool {
        self.day_of(clip.id).is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_room_of_a_day_is_that_of_the_last_change() {
        let changes = vec![(2.0, 5), (7.5, 6)];
        let day = ShownDay { clip: ClipId(0), first: 4, changes, tracks: Vec::new(), moments: Vec::new() };
        assert_eq!([0.0, 1.9, 2.0, 7.4, 7.5, 90.0].map(|s| day.node_at(s)), [4, 4, 5, 5, 6, 6]);
    }
}
