//! Rooms that the program makes: chosen by kind and seed, looked at before they are opened.

use super::engine::{Opened, RoomRequest};
use super::pictures::Shown;
use super::state::{EditorState, Overlay};
use crate::job::{Job, JobCtx, Seed};
use crate::render::Picture;

/// A room that was made and nobody has opened yet.
#[derive(Debug, Default)]
pub struct NewRoom {
    /// What is wanted.
    pub request: RoomRequest,
    /// What was made, and of which request.
    pub made: Option<MadeRoom>,
    /// The request that failed; not tried again by itself.
    failed: Option<RoomRequest>,
}

/// A room to look at.
#[derive(Debug)]
pub struct MadeRoom {
    /// What was asked for.
    pub request: RoomRequest,
    /// The room.
    pub opened: Opened,
    /// A picture of it.
    pub picture: Shown,
}

/// A room being made, with its picture.
pub(super) type MakingRoom = Job<(RoomRequest, Opened, Picture)>;

impl EditorState {
    /// Makes the wanted room to look at, unless it is there or under way.
    pub fn keep_new_room_fresh(&mut self) {
        let request = &self.new_room.request;
        let done = self.new_room.made.as_ref().is_some_and(|made| made.request == *request);
        let failed = self.new_room.failed.as_ref() == Some(request);
        if done || failed || self.jobs.making_room() {
            return;
        }
        let (engine, request) = (self.engine.clone(), request.clone());
        let work = move |cx: &JobCtx| {
            let opened = engine.make_room(&request, cx.ticker())?;
            let picture = engine.overview(&opened.scene.room, cx.ticker())?;
            Ok((request, opened, picture))
        };
        self.jobs.making_room = Some(Job::spawn("Make room", Seed::root(0), self.waker(), work));
    }

    pub(super) fn poll_made_room(&mut self) {
        let Some(job) = &mut self.jobs.making_room else { return };
        let Some(outcome) = job.poll() else { return };
        let name = job.name().to_owned();
        self.jobs.making_room = None;
        match self.taken(&name, outcome) {
            Some((request, opened, picture)) => {
                self.new_room.made = Some(MadeRoom { request, opened, picture: picture.into() });
            }
            None => self.new_room.failed = Some(self.new_room.request.clone()),
        }
    }

    /// Opens the room that was made.
    pub fn open_new_room(&mut self) {
        if let Some(made) = self.new_room.made.take() {
            self.overlay = Overlay::None;
            self.show_opened(made.opened);
        }
    }
}
