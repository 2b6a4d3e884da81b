//! Every command of the program, once: its name, key, tip, when it is possible and what it does. Menus,
//! palette, keys and the shortcut sheet are all made from this table.

use egui::{Key, KeyboardShortcut, Modifiers};

use super::actions;
use super::orbit::AxisView;
use super::state::{EditorState, Overlay};

/// One command.
pub struct CommandInfo {
    /// Stable name for scripts and tests.
    pub id: &'static str,
    /// Which menu it stands in.
    pub menu: Menu,
    /// Name for people.
    pub label: &'static str,
    /// Keys that run it; the first is shown.
    pub keys: &'static [KeyboardShortcut],
    /// What it does, in a sentence.
    pub tip: &'static str,
    /// Whether it can be done now.
    pub enabled: fn(&EditorState) -> bool,
    /// Does it.
    pub run: fn(&mut EditorState),
}

/// A menu of the menu bar.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Menu {
    /// Files.
    File,
    /// Changes.
    Edit,
    /// Selection.
    Select,
    /// Camera and panels.
    View,
    /// Generation.
    People,
    /// Motions.
    Motion,
    /// Findings.
    Inspect,
    /// Help.
    Help,
}

impl Menu {
    /// Every menu from left to right.
    pub const ALL: [Self; 8] = [
        Self::File,
        Self::Edit,
        Self::Select,
        Self::View,
        Self::People,
        Self::Motion,
        Self::Inspect,
        Self::Help,
    ];

    /// Name for people.
    pub fn label(self) -> &'static str {
        match self {
            Self::File => "File",
            Self::Edit => "Edit",
            Self::Select => "Select",
            Self::View => "View",
            Self::People => "People",
            Self::Motion => "Motion",
            Self::Inspect => "Inspect",
            Self::Help => "Help",
        }
    }
}

const NONE: Modifiers = Modifiers::NONE;
const SHIFT: Modifiers = Modifiers::SHIFT;
const ALT: Modifiers = Modifiers::ALT;
const CTRL: Modifiers = Modifiers::COMMAND;
const CTRL_SHIFT: Modifiers = Modifiers { shift: true, ..Modifiers::COMMAND };
const CTRL_ALT: Modifiers = Modifiers { alt: true, ..Modifiers::COMMAND };

const fn key(modifiers: Modifiers, key: Key) -> KeyboardShortcut {
    KeyboardShortcut::new(modifiers, key)
}

fn always(_: &EditorState) -> bool {
    true
}

fn selected(state: &EditorState) -> bool {
    !state.selection.is_empty()
}

fn people_selected(state: &EditorState) -> bool {
    !state.selection.people().is_empty()
}

fn has_room(state: &EditorState) -> bool {
    state.has_room()
}

fn has_people(state: &EditorState) -> bool {
    !state.document.scene().people.is_empty()
}

fn can_play(state: &EditorState) -> bool {
    state.can_play()
}

fn can_re_roll(state: &EditorState) -> bool {
    has_people(state) || !state.selection.goals().is_empty()
}

fn has_cards(state: &EditorState) -> bool {
    !state.sheet.cards.is_empty()
}

fn has_open_cards(state: &EditorState) -> bool {
    state.sheet.open_cards().next().is_some()
}

/// The table. One line says all there is to know of a command.
macro_rules! commands {
    ($($id:literal $menu:ident $label:literal [$($modifiers:ident $key:ident),*] $tip:literal
       if $enabled:expr => $run:expr;)*) => {
        &[$(CommandInfo {
            id: $id,
            menu: Menu::$menu,
            label: $label,
            keys: &[$(key($modifiers, Key::$key)),*],
            tip: $tip,
            enabled: $enabled,
            run: $run,
        }),*]
    };
}

/// Every command, in the order of the menus.
pub const COMMANDS: &[CommandInfo] = commands! {
    "open" File "Open..." [CTRL O] "Opens a room (GLB, glTF, OBJ, PLY) or a project." if always => actions::ask_for_file;
    "open-path" File "Open by path..." [CTRL_SHIFT O] "Opens a file by typing its path, or one of the recent files." if always => actions::ask_for_path;
    "new-room" File "New room..." [CTRL N] "Makes a furnished room: choose its kind and a seed." if always => actions::new_room;
    "sample" File "Open sample room" [] "Opens the first of the bundled rooms." if always => actions::open_first_sample;
    "save" File "Save" [CTRL S] "Saves the project." if has_room => actions::save;
    "save-as" File "Save as..." [CTRL_SHIFT S] "Saves the project under another name." if has_room => actions::save_as;
    "export" File "Export..." [CTRL E] "Writes the room and everybody in it as GLB files for other programs into a folder." if has_room => actions::export;
    "import-report" File "Import report" [] "Shows what was understood of the room's file; unit and up axis can be changed." if has_room => actions::show_import;
    "quit" File "Quit" [CTRL Q] "Closes the window." if always => actions::quit;

    "undo" Edit "Undo" [CTRL Z] "Takes the last change back." if |s| s.document.can_undo() => actions::undo;
    "redo" Edit "Redo" [CTRL_SHIFT Z, CTRL Y] "Does it again." if |s| s.document.can_redo() => actions::redo;
    "history" Edit "History" [CTRL_ALT Z] "Lists every step; click one to go there." if always => actions::show_history;
    "move" Edit "Move" [NONE G] "Moves the selection over the floor with the mouse; X, Y, Z hold it to an axis." if selected => actions::move_selection;
    "turn" Edit "Turn" [NONE R] "Turns the selection about the vertical with the mouse." if selected => actions::turn_selection;
    "settle" Edit "Settle" [NONE T] "Fits the selected people to where they are: no hovering, no sinking." if people_selected => actions::settle;
    "duplicate" Edit "Duplicate" [SHIFT D, CTRL D] "Copies the selected people and objects half a metre aside." if selected => actions::duplicate;
    "delete" Edit "Delete" [NONE Delete, NONE X, NONE Backspace] "Removes the selected people and objects." if selected => actions::delete;
    "rename" Edit "Rename" [NONE F2] "Renames the active person or object." if |s| s.selection.active().is_some() => actions::rename;
    "lock" Edit "Lock" [NONE L] "Locks or unlocks the selection: locked things are not moved, re-rolled or removed." if selected => actions::lock;
    "hide" Edit "Hide" [NONE H] "Hides the selection; hidden objects are no obstacle." if selected => actions::hide;
    "show-all" Edit "Show all" [ALT H] "Shows everything that is hidden." if has_room => actions::show_all;
    "isolate" Edit "Isolate" [NONE Slash] "Shows the selection alone; again to leave." if has_room => actions::isolate;

    "select-all" Select "All people" [CTRL A] "Selects every person." if has_people => actions::select_all;
    "select-none" Select "Nothing" [ALT A] "Clears the selection." if selected => actions::select_none;
    "invert" Select "Invert" [CTRL I] "Selects the people that are not selected." if has_people => actions::select_inverse;
    "next-person" Select "Next person" [NONE Tab] "Selects the next person." if has_people => actions::next_person;
    "previous-person" Select "Previous person" [SHIFT Tab] "Selects the previous person." if has_people => actions::previous_person;

    "frame" View "Frame selection" [NONE F, NONE Period] "Brings the selection into view." if selected => actions::frame_selection;
    "frame-all" View "Frame all" [NONE Home] "Brings the whole room into view." if has_room => actions::frame_all;
    "front" View "Front" [NONE Num1] "Looks along -Z." if always => |s| actions::view(s, AxisView::Front);
    "back" View "Back" [CTRL Num1] "Looks along +Z." if always => |s| actions::view(s, AxisView::Back);
    "right" View "Right" [NONE Num3] "Looks along -X." if always => |s| actions::view(s, AxisView::Right);
    "left" View "Left" [CTRL Num3] "Looks along +X." if always => |s| actions::view(s, AxisView::Left);
    "top" View "Top" [NONE Num7] "Looks down." if always => |s| actions::view(s, AxisView::Top);
    "bottom" View "Bottom" [CTRL Num7] "Looks up." if always => |s| actions::view(s, AxisView::Bottom);
    "ortho" View "Orthographic" [NONE Num5] "Switches between perspective and parallel projection." if always => actions::toggle_ortho;
    "home-view" View "Room view" [NONE Num0] "Back to the view from a corner." if has_room => actions::home_view;
    "cutaway" View "Cut walls away" [NONE C] "Leaves out walls and ceiling between camera and room." if always => actions::toggle_cutaway;
    "grid" View "Grid" [SHIFT G] "Shows or hides the metre grid." if always => actions::toggle_grid;
    "theme" View "Light or dark" [] "Switches between the light and the dark theme." if always => actions::toggle_theme;
    "full-screen" View "Full screen" [NONE F11] "Fills the screen; again to leave." if always => actions::toggle_full_screen;
    "reset-layout" View "Reset panels" [] "Puts every panel back where it was." if always => actions::reset_layout;

    "populate" People "Populate" [CTRL Enter] "Puts people into the room." if has_room => actions::populate;
    "put-here" People "Put somebody here" [SHIFT A] "Click a spot and somebody appears there." if has_room => actions::put_here;
    "re-roll" People "Re-roll" [NONE F9] "Makes the selected people anew with another seed; without a selection, the last generation. Selected sub-goals get another body." if can_re_roll => actions::re_roll;
    "sample-view" People "Sample from this view" [SHIFT S] "Proposes people for what is seen; accept those you like." if |s| s.geometry().is_some() => actions::sample_view;
    "photo" People "Fit to a photo..." [] "Finds a person of a photo, by its keypoints, in this room." if has_room => actions::show_photo;
    "accept" People "Accept candidate" [NONE Enter] "Fits the candidate that is shown and puts it into the room." if |s| s.sheet.chosen_card().is_some() => actions::accept_chosen;
    "accept-all" People "Accept all" [SHIFT Enter] "Fits every candidate that is left and puts them into the room." if has_open_cards => actions::accept_all;
    "next-candidate" People "Next candidate" [NONE CloseBracket] "Shows the next candidate in the view." if has_cards => actions::next_candidate;
    "previous-candidate" People "Previous candidate" [NONE OpenBracket] "Shows the previous candidate in the view." if has_cards => actions::previous_candidate;
    "lock-candidate" People "Lock candidate" [SHIFT L] "Re-rolls leave the candidate that is shown alone; again to unlock." if |s| s.sheet.chosen_card().is_some() => actions::lock_chosen;
    "re-roll-candidates" People "Re-roll candidates" [SHIFT F9] "Somebody new on every card that is neither locked nor accepted." if has_open_cards => actions::re_roll_candidates;
    "clear-candidates" People "Clear candidates" [] "Forgets the candidates; who was accepted stays." if has_cards => actions::clear_candidates;
    "cancel" People "Cancel jobs" [] "Stops everything that runs." if |s| s.jobs.any_running() => actions::cancel_jobs;

    "add-goals" Motion "Add sub-goals" [SHIFT I] "Click where somebody should stand, sit or lie; drag to say which way to face. Esc ends." if has_room => actions::add_goals;
    "new-motion" Motion "New motion" [] "Begins another motion; with a person selected, theirs." if has_room => actions::new_motion;
    "synthesise" Motion "Synthesise" [CTRL_SHIFT Enter] "Makes the motion from sub-goal to sub-goal; only legs that something has changed are made again." if |s| s.can_synthesise().is_ok() && !s.jobs.moving() => actions::synthesise;
    "another-way" Motion "Another way" [] "Makes the motion with the next seed." if |s| s.can_synthesise().is_ok() && !s.jobs.moving() => actions::another_way;
    "insert-goal" Motion "Insert sub-goal" [NONE I] "Puts a sub-goal where the motion is now." if can_play => actions::insert_goal;
    "play" Motion "Play" [NONE Space] "Plays the motions, or stops." if can_play => actions::play;
    "next-frame" Motion "Next frame" [NONE ArrowRight] "One frame on." if can_play => |s| actions::step_frames(s, 1);
    "previous-frame" Motion "Previous frame" [NONE ArrowLeft] "One frame back." if can_play => |s| actions::step_frames(s, -1);
    "next-second" Motion "Next second" [CTRL ArrowRight] "One second on." if can_play => |s| actions::step_seconds(s, 1.0);
    "previous-second" Motion "Previous second" [CTRL ArrowLeft] "One second back." if can_play => |s| actions::step_seconds(s, -1.0);
    "next-goal" Motion "Next sub-goal" [NONE ArrowUp] "Goes to the next sub-goal of the motion." if can_play => |s| actions::step_goal(s, true);
    "previous-goal" Motion "Previous sub-goal" [NONE ArrowDown] "Goes to the previous sub-goal of the motion." if can_play => |s| actions::step_goal(s, false);
    "first-frame" Motion "First frame" [SHIFT ArrowLeft] "Goes to the beginning." if can_play => |s| actions::go_to_end(s, false);
    "last-frame" Motion "Last frame" [SHIFT ArrowRight] "Goes to the end." if can_play => |s| actions::go_to_end(s, true);
    "loop" Motion "Loop" [] "Plays on and on, or once." if can_play => actions::toggle_loop;
    "trail" Motion "Trail" [SHIFT T] "Shows the way: a line, a line with figures, nothing." if can_play => actions::cycle_trail;
    "export-motion" Motion "Export motion..." [CTRL_SHIFT E] "Writes the motions as animated GLB, BVH, AMASS npz, GIF or pictures." if can_play => actions::export_motion;

    "heat" Inspect "Heat map" [NONE M] "Colours bodies by distance: off, contact, penetration." if has_people => actions::cycle_heat;
    "next-finding" Inspect "Next finding" [NONE N] "Goes to the next thing above its limit, worst first." if |s| s.has_findings() => actions::next_finding;
    "previous-finding" Inspect "Previous finding" [NONE P] "Goes to the previous thing above its limit." if |s| s.has_findings() => actions::previous_finding;
    "why" Inspect "Why like this" [SHIFT W] "Shows what the sampler saw and what the fit made of it." if has_room => actions::show_why;
    "before" Inspect "Before the fit" [NONE B] "Shows the selected person as sampled, before the fit, as a ghost." if people_selected => actions::toggle_before;
    "networks" Inspect "Networks" [] "Training curves and figures of the bundled networks." if always => actions::show_networks;
    "actions" People "Actions..." [] "What can be done in this room next, and what was done." if has_room => |s| s.requests.show_actions = true;
    "learned" Inspect "What was learned of actions" [] "Which action follows which, how many things they take and where these lie." if always => |s| s.overlay = Overlay::Learned(None);
    "study" Inspect "Human study..." [] "Shows results of several methods blind and in random order; raters score them from 1 to 5." if always => |s| s.overlay = Overlay::Study;
    "measure" Inspect "Measure selected again" [] "Measures the selected people anew." if people_selected => actions::measure_again;

    "palette" Help "Command palette" [CTRL K, CTRL P, NONE F3] "Finds and runs any command." if always => actions::show_palette;
    "shortcuts" Help "Keyboard shortcuts" [NONE Questionmark] "Lists every key." if always => actions::show_shortcuts;
    "help" Help "Help" [NONE F1] "How to move around and what to do first." if always => actions::show_help;
    "notifications" Help "Notifications" [] "Everything the program has said." if always => actions::show_notifications;
    "escape" Help "Cancel / deselect" [NONE Escape] "Closes what is open, cancels the tool, then clears the selection." if always => actions::escape;
};

/// The command called `id`.
pub fn find(id: &str) -> Option<&'static CommandInfo> {
    COMMANDS.iter().find(|command| command.id == id)
}

/// The command whose key was pressed, with exactly these modifiers.
pub fn for_key(pressed: Key, modifiers: Modifiers) -> Option<&'static CommandInfo> {
    let matches = |shortcut: &KeyboardShortcut| {
        // Where "?" lies differs by keyboard: some need Shift for it.
        let shift = pressed == Key::Questionmark || modifiers.shift == shortcut.modifiers.shift;
        let rest = modifiers.alt == shortcut.modifiers.alt && modifiers.command == shortcut.modifiers.command;
        shortcut.logical_key == pressed && shift && rest
    };
    COMMANDS.iter().find(|command| command.keys.iter().any(matches))
}

/// A key as people read it.
pub fn key_text(shortcut: &KeyboardShortcut) -> String {
    let mut text = String::new();
    let modifiers = shortcut.modifiers;
    for (on, name) in [(modifiers.command, "Ctrl+"), (modifiers.alt, "Alt+"), (modifiers.shift, "Shift+")] {
        if on {
            text.push_str(name);
        }
    }
    text.push_str(match shortcut.logical_key {
        Key::Slash => "/",
        Key::Period => ".",
        Key::Questionmark => "?",
        Key::Escape => "Esc",
        Key::Delete => "Del",
        Key::OpenBracket => "[",
        Key::CloseBracket => "]",
        other => other.name(),
    });
    text
}

/// How well `query` finds `label`: lower is better, `None` if it does not. Every letter must come in order;
/// the start of a word counts most.
pub fn match_score(query: &str, label: &str) -> Option<usize> {
    let label = label.to_lowercase();
    let query = query.trim().to_lowercase();
    if let Some(at) = label.find(&query) {
        return Some(at);
    }
    let mut score = 100;
    let mut rest = label.as_str();
    for letter in query.chars().filter(|c| !c.is_whitespace()) {
        let at = rest.find(letter)?;
        score += at;
        rest = &rest[at + letter.len_utf8()..];
    }
    Some(score)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn every_command_has_its_own_name_and_no_key_does_two_things() {
        let ids: BTreeSet<_> = COMMANDS.iter().map(|c| c.id).collect();
        assert_eq!(ids.len(), COMMANDS.len());
        let mut keys = BTreeSet::new();
        for command in COMMANDS {
            assert!(command.tip.ends_with('.'), "{} has no sentence as tip", command.id);
            for shortcut in command.keys {
                assert!(keys.insert(key_text(shortcut)), "{} is taken twice", key_text(shortcut));
            }
        }
    }

    #[test]
    fn shift_and_control_tell_commands_apart() {
        let id = |key, modifiers| for_key(key, modifiers).map(|c| c.id);
        assert_eq!(id(Key::Z, CTRL), Some("undo"));
        assert_eq!(id(Key::Z, CTRL_SHIFT), Some("redo"));
        assert_eq!(id(Key::Z, NONE), None);
        assert_eq!(id(Key::A, SHIFT), Some("put-here"));
        assert_eq!(id(Key::Questionmark, SHIFT), Some("shortcuts"));
    }

    #[test]
    fn the_palette_finds_by_parts_and_by_initial_letters() {
        assert!(match_score("pop", "Populate").is_some());
        assert!(match_score("frsel", "Frame selection").is_some());
        assert!(match_score("zzz", "Populate").is_none());
        assert!(match_score("roll", "Re-roll") < match_score("rl", "Re-roll"));
    }
}
