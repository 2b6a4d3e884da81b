//! What each command does to the editor. Called from menus, keys, palette and panels alike.

use std::path::PathBuf;

use glam::Vec3;

use super::engine::{ImportChoice, Source};
use super::orbit::AxisView;
use super::selection::Item;
use super::state::{EditorState, Heat, Leaving, Overlay, Tool};
use super::transform::TransformKind;
use crate::document::Command;
use crate::math::Aabb;
use crate::scene::PersonId;

/// Where a copy comes to stand, in metres from the original.
const COPY_OFFSET_M: Vec3 = Vec3::new(0.5, 0.0, 0.0);

/// Asks for a file to open.
pub fn ask_for_file(state: &mut EditorState) {
    state.requests.open_dialog = true;
}

/// Shows the field for a path and the recent files.
pub fn ask_for_path(state: &mut EditorState) {
    state.overlay = Overlay::OpenPath(String::new());
}

/// Opens the first bundled room.
pub fn open_first_sample(state: &mut EditorState) {
    state.open(Source::Sample(0));
}

/// Opens a file of the user's with everything detected.
pub fn open_file(state: &mut EditorState, path: PathBuf) {
    state.open(Source::File(path, ImportChoice::default()));
}

/// Saves where it was saved before, or asks where.
pub fn save(state: &mut EditorState) {
    match state.project.clone() {
        Some(path) => state.start_saving(path),
        None => save_as(state),
    }
}

/// Asks where to save.
pub fn save_as(state: &mut EditorState) {
    state.requests.save_dialog = true;
}

/// Asks for a folder and writes room and people into it.
pub fn export(state: &mut EditorState) {
    state.requests.export_dialog = true;
}

/// Moves the selection with the mouse.
pub fn move_selection(state: &mut EditorState) {
    state.begin_transform(TransformKind::Move);
}

/// Turns the selection with the mouse.
pub fn turn_selection(state: &mut EditorState) {
    state.begin_transform(TransformKind::Turn);
}

/// Fits the selected people to where they are.
pub fn settle(state: &mut EditorState) {
    let people = state.selection.people();
    state.settle(&people);
}

/// Shows the import report.
pub fn show_import(state: &mut EditorState) {
    state.overlay = Overlay::Import;
}

/// Closes the window, after asking when there are unsaved changes.
pub fn quit(state: &mut EditorState) {
    if state.has_unsaved_work() {
        state.overlay = Overlay::Unsaved(Leaving::Quit);
    } else {
        state.requests.close = true;
    }
}

/// Takes the last change back.
pub fn undo(state: &mut EditorState) {
    if let Some(label) = state.document.undo() {
        state.prune();
        state.notices.info(format!("Undone: {label}"));
    }
}

/// Does it again.
pub fn redo(state: &mut EditorState) {
    if let Some(label) = state.document.redo() {
        state.prune();
        state.notices.info(format!("Done again: {label}"));
    }
}

/// Shows the undo history.
pub fn show_history(state: &mut EditorState) {
    state.overlay = Overlay::History;
}

/// Copies the selection aside and selects the copies.
pub fn duplicate(state: &mut EditorState) {
    let people: Vec<_> = {
        let scene = state.document.scene();
        state.selection.people().iter().filter_map(|id| scene.person(*id)).cloned().collect()
    };
    let objects = state.selection.objects();
    let (first_person, first_object) = (state.document.next_person(), state.document.next_object());
    state.document.begin("Duplicate");
    if !people.is_empty() {
        let mut copies = people;
        for copy in &mut copies {
            copy.body.translation += COPY_OFFSET_M;
            copy.name.push_str(" copy");
            copy.locked = false;
            copy.palette = copy.palette.wrapping_add(1);
        }
        state.apply(Command::AddPeople { people: copies, made_for: None });
    }
    if !objects.is_empty() {
        state.apply(Command::DuplicateObjects(objects, COPY_OFFSET_M));
    }
    state.document.commit();
    let scene = state.document.scene();
    let people = scene.people.iter().map(|p| p.id).filter(|id| id.0 >= first_person).map(Item::Person);
    let objects = scene.room.objects.iter().map(|o| o.id).filter(|id| id.0 >= first_object);
    let copies: Vec<Item> = people.chain(objects.map(Item::Object)).collect();
    state.selection.set(copies);
}

/// Removes the selection, but what is locked.
pub fn delete(state: &mut EditorState) {
    let scene = state.document.scene();
    let mut locked = 0;
    let people: Vec<PersonId> = state
        .selection
        .people()
        .into_iter()
        .filter(|id| {
            scene.person(*id).is_some_and(|p| {
                !p.locked || {
                    locked += 1;
                    false
                }
            })
        })
        .collect();
    let objects: Vec<_> = state
        .selection
        .objects()
        .into_iter()
        .filter(|id| {
            scene.room.object(*id).is_some_and(|o| {
                !o.locked || {
                    locked += 1;
                    false
                }
            })
        })
        .collect();
    let (goals, clips) = (state.selection.goals(), state.selection.clips());
    let open = |id: &crate::scene::ClipId| scene.clip(*id).is_some_and(|clip| !clip.locked);
    let (clips, held): (Vec<_>, Vec<_>) = clips.into_iter().partition(open);
    locked += held.len();
    let others = goals.len() + clips.len();
    state.document.begin(removal_label(people.len(), objects.len(), others));
    if !people.is_empty() {
        state.apply(Command::RemovePeople(people));
    }
    if !objects.is_empty() {
        state.apply(Command::RemoveObjects(objects));
    }
    locked += state.remove_goals(&goals);
    if !clips.is_empty() {
        state.apply(Command::RemoveClips(clips));
    }
    state.document.commit();
    if let Some((clip, _)) = goals.first() {
        state.follow_change(*clip);
    }
    if locked > 0 {
        state.notices.warning(format!("{locked} locked and left in place. L unlocks."));
    }
}

fn removal_label(people: usize, objects: usize, others: usize) -> String {
    match (people, objects) {
        (0, 0) if others > 0 => "Remove from motion".to_owned(),
        _ if others > 0 => format!("Remove {} things", people + objects + others),
        (_, 0) => Command::RemovePeople(vec![PersonId(0); people]).label(),
        (0, n) => format!("Remove {n} object{}", if n == 1 { "" } else { "s" }),
        _ => format!("Remove {} things", people + objects),
    }
}

/// Asks for a new name of the active item.
pub fn rename(state: &mut EditorState) {
    let Some(item) = state.selection.active() else { return };
    let scene = state.document.scene();
    let name = match item {
        Item::Person(id) => scene.person(id).map(|p| p.name.clone()),
        Item::Object(id) => scene.room.object(id).map(|o| o.name.clone()),
        Item::Clip(id) | Item::Goal(id, _) => scene.clip(id).map(|c| c.name.clone()),
    };
    state.overlay = Overlay::Rename(item, name.unwrap_or_default());
}

/// Gives an item the name that was typed.
pub fn give_name(state: &mut EditorState, item: Item, name: String) {
    state.apply(match item {
        Item::Person(id) => Command::RenamePerson(id, name),
        Item::Object(id) => Command::RenameObject(id, name),
        Item::Clip(id) | Item::Goal(id, _) => Command::RenameClip(id, name),
    });
}

/// Does something to the selected people and to the selected objects as one step.
fn to_selection(
    state: &mut EditorState,
    label: &str,
    people: impl FnOnce(Vec<PersonId>) -> Command,
    objects: impl FnOnce(Vec<crate::scene::ObjectId>) -> Command,
    clips: impl FnOnce(Vec<crate::scene::ClipId>) -> Command,
) {
    let (who, what) = (state.selection.people(), state.selection.objects());
    let motions = state.selection.clips();
    state.document.begin(label);
    if !who.is_empty() {
        state.apply(people(who));
    }
    if !what.is_empty() {
        state.apply(objects(what));
    }
    if !motions.is_empty() {
        state.apply(clips(motions));
    }
    state.document.commit();
}

/// Locks the selection, or unlocks it if all of it is locked.
pub fn lock(state: &mut EditorState) {
    let scene = state.document.scene();
    let people = state.selection.people();
    let objects = state.selection.objects();
    let (clips, goals) = (state.selection.clips(), state.selection.goals());
    let all = people.iter().all(|id| scene.person(*id).is_some_and(|p| p.locked))
        && objects.iter().all(|id| scene.room.object(*id).is_some_and(|o| o.locked))
        && clips.iter().all(|id| scene.clip(*id).is_some_and(|c| c.locked))
        && goals.iter().all(|(clip, goal)| state.goal(*clip, *goal).is_some_and(|g| g.locked));
    let (label, locked) = if all { ("Unlock", false) } else { ("Lock", true) };
    to_selection(
        state,
        label,
        |ids| Command::SetPeopleLocked(ids, locked),
        |ids| Command::SetObjectsLocked(ids, locked),
        |ids| Command::SetClipsLocked(ids, locked),
    );
    state.edit_goals(&goals, |goal| goal.locked = locked);
}

/// Hides the selection.
pub fn hide(state: &mut EditorState) {
    to_selection(
        state,
        "Hide",
        |ids| Command::SetPeopleVisible(ids, false),
        |ids| Command::SetObjectsVisible(ids, false),
        |ids| Command::SetClipsVisible(ids, false),
    );
}

/// Shows all that is hidden.
pub fn show_all(state: &mut EditorState) {
    state.view.isolated = None;
    let scene = state.document.scene();
    let people = scene.people.iter().map(|p| p.id).collect();
    let objects = scene.room.objects.iter().map(|o| o.id).collect();
    let clips = scene.clips.iter().map(|c| c.id).collect();
    state.document.begin("Show all");
    state.apply(Command::SetPeopleVisible(people, true));
    state.apply(Command::SetObjectsVisible(objects, true));
    state.apply(Command::SetClipsVisible(clips, true));
    state.document.commit();
}

/// Shows the selection alone, or all again. Only a way of looking: geometry and history don't change.
pub fn isolate(state: &mut EditorState) {
    let selection = &state.selection;
    state.view.isolated = match state.view.isolated {
        None if !selection.is_empty() => {
            let people = selection.people().into_iter().map(Item::Person);
            let clips = selection.clips().into_iter().map(Item::Clip);
            let objects = selection.objects().into_iter().map(Item::Object);
            Some(people.chain(objects).chain(clips).collect())
        }
        _ => None,
    };
}

/// Selects every person.
pub fn select_all(state: &mut EditorState) {
    let all: Vec<Item> = state.document.scene().people.iter().map(|p| Item::Person(p.id)).collect();
    state.selection.set(all);
}

/// Clears the selection.
pub fn select_none(state: &mut EditorState) {
    state.selection.clear();
}

/// Selects the people that are not selected.
pub fn select_inverse(state: &mut EditorState) {
    let people = state.document.scene().people.iter().map(|p| Item::Person(p.id));
    let others: Vec<Item> = people.filter(|item| !state.selection.contains(*item)).collect();
    state.selection.set(others);
}

/// Selects the next person.
pub fn next_person(state: &mut EditorState) {
    step_person(state, 1);
}

/// Selects the previous person.
pub fn previous_person(state: &mut EditorState) {
    step_person(state, -1);
}

fn step_person(state: &mut EditorState, step: isize) {
    let people = &state.document.scene().people;
    let count = people.len() as isize;
    if count == 0 {
        return;
    }
    let active = state.selection.active_person();
    let now = people.iter().position(|p| Some(p.id) == active);
    let next = now.map_or(if step > 0 { 0 } else { count - 1 }, |at| (at as isize + step).rem_euclid(count));
    let id = people[next as usize].id;
    state.selection.only(Item::Person(id));
}

/// Brings the selection into view.
pub fn frame_selection(state: &mut EditorState) {
    let bounds = state.selection.iter().fold(Aabb::EMPTY, |all, item| all.union(state.bounds_of(item)));
    state.orbit.frame(&bounds, state.aspect);
}

/// Brings one item into view.
pub fn frame_item(state: &mut EditorState, item: Item) {
    let bounds = state.bounds_of(item);
    state.orbit.frame(&bounds, state.aspect);
}

/// Brings everything into view.
pub fn frame_all(state: &mut EditorState) {
    let bounds = state.document.scene().room.bounds();
    state.orbit.frame(&bounds, state.aspect);
}

/// Looks along an axis.
pub fn view(state: &mut EditorState, view: AxisView) {
    state.orbit.view(view);
}

/// The view from a corner, as after opening.
pub fn home_view(state: &mut EditorState) {
    let fresh = super::orbit::Orbit::default();
    state.orbit.arrive();
    state.orbit.yaw = fresh.yaw;
    state.orbit.pitch = fresh.pitch;
    state.orbit.ortho = false;
    frame_all(state);
}

/// Switches the projection.
pub fn toggle_ortho(state: &mut EditorState) {
    state.orbit.ortho = !state.orbit.ortho;
}

/// Switches the cutaway of walls.
pub fn toggle_cutaway(state: &mut EditorState) {
    state.view.cutaway = !state.view.cutaway;
}

/// Switches the grid.
pub fn toggle_grid(state: &mut EditorState) {
    state.view.grid = !state.view.grid;
}

/// Switches the theme.
pub fn toggle_theme(state: &mut EditorState) {
    state.view.dark = !state.view.dark;
}

/// Switches full screen.
pub fn toggle_full_screen(state: &mut EditorState) {
    state.requests.full_screen = true;
}

/// Puts the panels back.
pub fn reset_layout(state: &mut EditorState) {
    state.requests.reset_layout = true;
}

/// Puts people into the room.
pub fn populate(state: &mut EditorState) {
    state.start_populating(None);
}

/// The next click puts somebody there.
pub fn put_here(state: &mut EditorState) {
    state.tool = if state.tool == Tool::PutHere { Tool::Select } else { Tool::PutHere };
}

/// Makes the selected people, or the ones made last, anew with another seed.
pub fn re_roll(state: &mut EditorState) {
    let goals = state.selection.goals();
    if let Some((clip, _)) = goals.first().copied() {
        state.activate_clip(clip);
        let anew = goals.iter().filter(|(of, _)| *of == clip).map(|(_, goal)| *goal);
        state.synthesise_anew(anew.collect());
        return;
    }
    let selected = state.selection.people();
    let ids = if selected.is_empty() { state.last_made.clone() } else { selected };
    let scene = state.document.scene();
    let ids: Vec<PersonId> =
        ids.into_iter().filter(|id| scene.person(*id).is_some_and(|p| !p.locked)).collect();
    if ids.is_empty() {
        state.notices.warning("Nobody to re-roll: select somebody who is not locked.");
        return;
    }
    state.populate.seed = state.populate.seed.wrapping_add(1);
    state.start_re_rolling(&ids);
}

/// Stops everything that runs.
pub fn cancel_jobs(state: &mut EditorState) {
    state.cancel_all();
}

/// Off, then distances.
pub fn cycle_heat(state: &mut EditorState) {
    state.view.heat = match state.view.heat {
        Heat::Off => Heat::Distance,
        Heat::Distance => Heat::Off,
    };
}

/// Goes to the next finding.
pub fn next_finding(state: &mut EditorState) {
    step_finding(state, 1);
}

/// Goes to the previous finding.
pub fn previous_finding(state: &mut EditorState) {
    step_finding(state, -1);
}

fn step_finding(state: &mut EditorState, step: isize) {
    let count = (state.findings().len() + state.worst_clip_findings().len()) as isize;
    if count == 0 {
        return;
    }
    let next = state
        .finding
        .map_or(if step > 0 { 0 } else { count - 1 }, |at| (at as isize + step).rem_euclid(count));
    go_to_finding(state, next as usize);
}

/// Selects and frames the person of a finding; behind those of people come those of motions.
pub fn go_to_finding(state: &mut EditorState, number: usize) {
    let people = state.findings();
    if number >= people.len() {
        go_to_clip_finding(state, number - people.len());
        state.finding = Some(number);
    } else if let Some(finding) = people.get(number) {
        let item = Item::Person(PersonId(finding.site.body));
        state.finding = Some(number);
        state.selection.only(item);
        frame_item(state, item);
    }
}

/// Measures the selected people anew.
pub fn measure_again(state: &mut EditorState) {
    for id in state.selection.people() {
        state.forget_measured(id);
    }
}

/// Shows the palette.
pub fn show_palette(state: &mut EditorState) {
    state.overlay = Overlay::Palette { query: String::new(), row: 0 };
}

/// Lists every key.
pub fn show_shortcuts(state: &mut EditorState) {
    state.overlay = Overlay::Shortcuts;
}

/// Shows the first steps.
pub fn show_help(state: &mut EditorState) {
    state.overlay = Overlay::Help;
}

/// Shows everything that was said.
pub fn show_notifications(state: &mut EditorState) {
    state.notices.mark_read();
    state.overlay = Overlay::Notifications;
}

/// One thing at a time: closes what is open, ends a drag, leaves the tool, clears the selection. Never quits.
pub fn escape(state: &mut EditorState) {
    if state.overlay != Overlay::None {
        state.overlay = Overlay::None;
    } else if state.motion.placing.take().is_some() {
        // The press is forgotten; the tool stays.
    } else if state.document.in_gesture() {
        state.document.abort();
    } else if state.tool != Tool::Select {
        state.tool = Tool::Select;
    } else if state.sheet.chosen.is_some() {
        state.sheet.chosen = None;
    } else {
        state.selection.clear();
    }
}

/// Sets one shape number of a person; part of the gesture that the slider opened.
pub fn set_beta(state: &mut EditorState, id: PersonId, index: usize, value: f32) {
    let Some(person) = state.document.scene().person(id) else { return };
    let mut body = person.body.clone();
    body.betas[index] = value;
    state.apply(Command::SetBody(id, body));
}

/// Goes to a step of the history: `steps` back (negative) or forward.
pub fn travel(state: &mut EditorState, steps: isize) {
    for _ in 0..steps.unsigned_abs() {
        if steps < 0 {
            state.document.undo()
        } else {
            state.document.redo()
        };
    }
    state.prune();
}

/// Shows the room maker.
pub fn new_room(state: &mut EditorState) {
    state.overlay = Overlay::NewRoom;
}

/// Samples candidates from the view that the options name.
pub fn sample_view(state: &mut EditorState) {
    state.requests.show_sample = true;
    state.start_sampling();
}

/// Accepts the candidate that is shown.
pub fn accept_chosen(state: &mut EditorState) {
    if let Some(key) = state.sheet.chosen {
        state.accept_cards(&[key]);
    }
}

/// Accepts every candidate that is left.
pub fn accept_all(state: &mut EditorState) {
    let keys: Vec<u64> = state.sheet.open_cards().collect();
    state.accept_cards(&keys);
}

/// Somebody new on one card.
pub fn re_roll_card(state: &mut EditorState, key: u64) {
    state.re_roll_cards(&[key]);
}

/// Somebody new on every card that is neither locked nor accepted.
pub fn re_roll_candidates(state: &mut EditorState) {
    let keys: Vec<u64> = state.sheet.open_cards().collect();
    state.re_roll_cards(&keys);
}

/// Forgets the candidates.
pub fn clear_candidates(state: &mut EditorState) {
    state.clear_sheet();
}

/// Locks the candidate that is shown, or unlocks it.
pub fn lock_chosen(state: &mut EditorState) {
    if let Some(key) = state.sheet.chosen {
        state.lock_card(key);
    }
}

/// Shows the next candidate.
pub fn next_candidate(state: &mut EditorState) {
    step_candidate(state, 1);
}

/// Shows the previous candidate.
pub fn previous_candidate(state: &mut EditorState) {
    step_candidate(state, -1);
}

fn step_candidate(state: &mut EditorState, step: isize) {
    let cards = &state.sheet.cards;
    let count = cards.len() as isize;
    let now = cards.iter().position(|card| Some(card.key) == state.sheet.chosen);
    let next =
        now.map_or(if step > 0 { 0 } else { count - 1 }, |at| (at as isize + step).rem_euclid(count.max(1)));
    if let Some(key) = cards.get(next as usize).map(|card| card.key) {
        state.choose_card(key);
    }
}

/// Brings *Why like this* to the front.
pub fn show_why(state: &mut EditorState) {
    state.requests.show_why = true;
}

/// Shows or hides the selected person's body before the fit.
pub fn toggle_before(state: &mut EditorState) {
    state.view.before = !state.view.before;
}

/// Shows the networks' training curves and figures.
pub fn show_networks(state: &mut EditorState) {
    state.overlay = Overlay::Networks(0);
}

/// Brings the photo panel to the front.
pub fn show_photo(state: &mut EditorState) {
    state.requests.show_photo = true;
}

/// The next clicks place sub-goals; again to stop.
pub fn add_goals(state: &mut EditorState) {
    state.tool = if state.tool == Tool::AddGoal { Tool::Select } else { Tool::AddGoal };
    state.requests.show_motion = true;
}

/// Begins another motion.
pub fn new_motion(state: &mut EditorState) {
    state.new_clip();
    state.tool = Tool::AddGoal;
    state.requests.show_motion = true;
}

/// Makes the active motion.
pub fn synthesise(state: &mut EditorState) {
    state.requests.show_motion = true;
    state.start_synthesis();
}

/// Makes the active motion with another seed.
pub fn another_way(state: &mut EditorState) {
    state.motion.options.seed = state.motion.options.seed.wrapping_add(1);
    state.start_synthesis();
}

/// Plays or stops.
pub fn play(state: &mut EditorState) {
    let length_s = state.play_seconds();
    state.motion.player.toggle(length_s);
    state.requests.show_timeline = true;
}

/// Goes so many frames on or back.
pub fn step_frames(state: &mut EditorState, frames: i32) {
    let length_s = state.play_seconds();
    state.motion.player.step(frames, crate::scene::CLIP_FPS, length_s);
}

/// Goes so many seconds on or back.
pub fn step_seconds(state: &mut EditorState, seconds: f32) {
    let (length_s, now) = (state.play_seconds(), state.motion.player.seconds);
    state.motion.player.seek(now + seconds, length_s);
}

/// Goes to the first or the last frame.
pub fn go_to_end(state: &mut EditorState, last: bool) {
    let length_s = state.play_seconds();
    state.motion.player.seek(if last { length_s } else { 0.0 }, length_s);
}

/// Goes to where the active motion reaches the next (or previous) sub-goal, and selects it.
pub fn step_goal(state: &mut EditorState, forwards: bool) {
    let Some(clip) = state.active_clip().filter(|clip| !clip.frames.is_empty()).cloned() else { return };
    let Some(now) = state.frame_now(&clip) else { return };
    let mut stops: Vec<_> =
        clip.legs.iter().flat_map(|leg| [(leg.first, leg.from), (leg.last, leg.to)]).collect();
    stops.sort_unstable();
    let stop = if forwards {
        stops.iter().find(|(frame, _)| *frame > now)
    } else {
        stops.iter().rev().find(|(frame, _)| *frame < now)
    };
    if let Some((frame, goal)) = stop.copied() {
        go_to_frame(state, &clip, frame);
        state.selection.only(Item::Goal(clip.id, goal));
    }
}

/// Shows a frame of a motion.
pub fn go_to_frame(state: &mut EditorState, clip: &crate::scene::Clip, frame: usize) {
    let length_s = state.play_seconds();
    state.motion.player.seek(frame as f32 / clip.fps, length_s);
}

/// Puts a sub-goal where the active motion is now.
pub fn insert_goal(state: &mut EditorState) {
    state.insert_goal_now();
}

/// Plays on and on, or once.
pub fn toggle_loop(state: &mut EditorState) {
    state.motion.player.looping = !state.motion.player.looping;
}

/// Nothing, a line, a line with figures.
pub fn cycle_trail(state: &mut EditorState) {
    use super::motion::Trail;
    state.motion.trail = match state.motion.trail {
        Trail::Off => Trail::Line,
        Trail::Line => Trail::Figures,
        Trail::Figures => Trail::Off,
    };
}

/// Asks where to write the motions.
pub fn export_motion(state: &mut EditorState) {
    let format = state.motion.export.format;
    state.ask_motion_export(format);
}

/// Shows the frame of a finding in a motion and selects the motion.
pub fn go_to_clip_finding(state: &mut EditorState, number: usize) {
    let Some((clip, finding)) = state.worst_clip_findings().get(number).cloned() else { return };
    state.activate_clip(clip.id);
    state.selection.only(Item::Clip(clip.id));
    if let Some(frame) = finding.site.frame {
        go_to_frame(state, &clip, frame as usize);
    }
    state.requests.show_timeline = true;
}
