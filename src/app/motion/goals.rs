//! Sub-goals by hand: placed by a press and a drag, moved, turned, locked, removed. Every change is a command.

use glam::{Affine3A, Vec2, Vec3};

use crate::app::selection::Item;
use crate::app::state::EditorState;
use crate::body::Body;
use crate::document::Command;
use crate::scene::Clip;
use crate::scene::ClipId;
use crate::scene::Frame;
use crate::scene::GoalPose;
use crate::scene::Person;
use crate::scene::PersonId;
use crate::scene::SubGoal;
use crate::scene::SubGoalId;
use crate::scene::facing_of;

/// The planner numbers its own sub-goals from here (`motion::plan`).
const PLANNED: u32 = 0x4000_0000;
/// A drag shorter than this leaves the facing to the planner, metres.
const SHORTEST_FACING_M: f32 = 0.12;

/// A sub-goal whose place is chosen and whose facing is being dragged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placing {
    /// The place.
    pub at: Vec3,
    /// Where the mouse points on the level of the place.
    pub towards: Vec3,
}

impl Placing {
    /// Which way the drag says to face.
    pub fn facing(&self) -> Option<f32> {
        let way = self.towards - self.at;
        let way = Vec2::new(way.x, way.z);
        (way.length() > SHORTEST_FACING_M).then(|| facing_of(way))
    }
}

impl EditorState {
    /// Puts the sub-goal that was being placed at the end of the active motion; begins a motion if there is none.
    pub fn place_goal(&mut self, placing: Placing) {
        let options = &self.motion.options;
        let (pose, stay_s) =
            (options.pose, if options.pose == GoalPose::Walk { 0.0 } else { options.stay_s });
        let clip = self.active_clip().filter(|clip| !clip.locked).cloned();
        let mut goals = clip.as_ref().map_or_else(Vec::new, |clip| clip.goals.clone());
        self.document.begin("Add sub-goal");
        let id = match &clip {
            Some(clip) => Some(clip.id),
            None => self.begin_clip(&mut goals),
        };
        let mut placed = None;
        if let Some(id) = id {
            let legs = clip.as_ref().map_or(&[][..], |clip| &clip.legs);
            let name = free_id(&goals, legs.iter().flat_map(|leg| [leg.from, leg.to]));
            goals.push(SubGoal {
                id: name,
                at: placing.at,
                facing: placing.facing(),
                pose,
                stay_s,
                planned: false,
                locked: false,
                body: None,
            });
            if self.apply(Command::SetGoals(id, goals)) {
                self.selection.only(Item::Goal(id, name));
                placed = Some((id, name));
            }
        }
        self.document.commit();
        self.motion.reach = None;
        if let Some((clip, goal)) = placed {
            self.ask_reach(clip, goal);
        }
    }

    /// Begins a motion without sub-goals; if somebody is selected, with that person, who begins where they are.
    fn begin_clip(&mut self, goals: &mut Vec<SubGoal>) -> Option<ClipId> {
        let id = ClipId(self.document.next_clip());
        let person = self.selection.active_person().and_then(|id| self.document.scene().person(id)).cloned();
        let options = &self.motion.options;
        let clip = Clip {
            name: person.as_ref().map_or_else(|| format!("Motion {}", id.0 + 1), |p| p.name.clone()),
            person: person.as_ref().map(|p| p.id),
            betas: person.as_ref().map_or(options.betas, |p| p.body.betas),
            palette: person.as_ref().map_or(id.0, |p| p.palette),
            seed: options.seed,
            ..Clip::default()
        };
        goals.extend(person.as_ref().map(|p| start_of(p, SubGoalId(0))));
        self.apply(Command::AddClips { clips: vec![clip], made_for: None }).then(|| {
            self.activate_clip(id);
            id
        })
    }

    /// Begins another motion with the next sub-goal that is placed.
    pub fn new_clip(&mut self) {
        let mut goals = Vec::new();
        self.document.begin("New motion");
        if let Some(id) = self.begin_clip(&mut goals)
            && !goals.is_empty()
        {
            self.apply(Command::SetGoals(id, goals));
        }
        self.document.commit();
    }

    /// Puts a sub-goal into the leg that is shown now, where the person is now.
    pub fn insert_goal_now(&mut self) {
        let Some(clip) = self.active_clip().cloned() else { return };
        let Some(frame) = self.frame_now(&clip) else { return };
        let Some(leg) = clip.legs.iter().find(|leg| (leg.first..=leg.last).contains(&frame)) else { return };
        let Some(after) = clip.goals.iter().position(|goal| goal.id == leg.from) else { return };
        let posed = Body::bundled().pose_frame(&clip.betas, &clip.frames[frame]);
        let front = clip.frames[frame].rotation * Vec3::Z;
        let floor_m = posed.vertices.iter().map(|v| v.y).fold(f32::INFINITY, f32::min);
        let id = free_id(&clip.goals, clip.legs.iter().flat_map(|leg| [leg.from, leg.to]));
        let goal = SubGoal {
            id,
            at: posed.joints[0].with_y(floor_m),
            facing: Some(facing_of(Vec2::new(front.x, front.z))),
            pose: GoalPose::Walk,
            stay_s: 0.0,
            planned: false,
            locked: true,
            body: Some(clip.frames[frame].clone()),
        };
        let mut goals = clip.goals.clone();
        goals.insert(after + 1, goal);
        if self.apply(Command::SetGoals(clip.id, goals)) {
            self.selection.only(Item::Goal(clip.id, id));
        }
    }

    /// Puts changed sub-goals in place of those with their names.
    pub(in crate::app) fn put_goals(&mut self, changed: &[(ClipId, SubGoal)]) -> bool {
        let mut clips: Vec<ClipId> = changed.iter().map(|(clip, _)| *clip).collect();
        clips.dedup();
        let mut any = false;
        for id in clips {
            let Some(clip) = self.document.scene().clip(id) else { continue };
            let mut goals = clip.goals.clone();
            for goal in &mut goals {
                if let Some((_, new)) = changed.iter().find(|(of, new)| *of == id && new.id == goal.id) {
                    goal.clone_from(new);
                }
            }
            any |= self.apply(Command::SetGoals(id, goals));
        }
        any
    }

    /// Changes sub-goals by a rule.
    pub fn edit_goals(&mut self, goals: &[(ClipId, SubGoalId)], edit: impl Fn(&mut SubGoal)) -> bool {
        let edited = |(clip, goal): &(ClipId, SubGoalId)| {
            let mut goal = self.goal(*clip, *goal)?.clone();
            edit(&mut goal);
            Some((*clip, goal))
        };
        let changed: Vec<(ClipId, SubGoal)> = goals.iter().filter_map(edited).collect();
        self.put_goals(&changed)
    }

    /// Removes sub-goals but the locked ones; how many were left in place.
    pub(in crate::app) fn remove_goals(&mut self, goals: &[(ClipId, SubGoalId)]) -> usize {
        let mut kept = 0;
        let mut clips: Vec<ClipId> = goals.iter().map(|(clip, _)| *clip).collect();
        clips.dedup();
        for id in clips {
            let Some(clip) = self.document.scene().clip(id) else { continue };
            let goes = |goal: &SubGoal| goals.contains(&(id, goal.id)) && !goal.locked;
            kept += clip.goals.iter().filter(|g| g.locked && goals.contains(&(id, g.id))).count();
            let left: Vec<SubGoal> = clip.goals.iter().filter(|goal| !goes(goal)).cloned().collect();
            self.apply(Command::SetGoals(id, left));
        }
        kept
    }

    /// Asks what is in the way of a sub-goal, and remembers the answer for the view.
    pub(in crate::app) fn ask_reach(&mut self, clip: ClipId, goal: SubGoalId) {
        let (Some(geometry), Some(of)) =
            (self.geometry().cloned(), self.document.scene().clip(clip).cloned())
        else {
            return;
        };
        let room = self.document.scene().room.clone();
        let answer = self.engine.reach(&room, &geometry, &of, goal);
        self.motion.reach = Some((Item::Goal(clip, goal), answer));
    }
}

/// A sub-goal moved by a rigid motion of the world. Its body is no longer right; a planned one is kept from now on.
pub fn carried_goal(goal: &SubGoal, rigid: &Affine3A, turned_rad: f32) -> SubGoal {
    let facing = match goal.facing {
        Some(facing) => Some(facing + turned_rad),
        None => (turned_rad != 0.0).then_some(turned_rad),
    };
    let at = rigid.transform_point3(goal.at);
    let body = goal.body.clone().filter(|_| at == goal.at && facing == goal.facing);
    SubGoal { at, facing, body, locked: goal.locked || goal.planned, ..goal.clone() }
}

/// Where somebody is who is to walk away.
fn start_of(person: &Person, id: SubGoalId) -> SubGoal {
    let body = Body::bundled();
    let posed = body.pose(&person.body);
    let lowest_m = posed.vertices.iter().map(|v| v.y).fold(f32::INFINITY, f32::min);
    let front = person.body.rotation() * Vec3::Z;
    let pose = match person.family.group() {
        "sit" => GoalPose::Sit,
        "lie" => GoalPose::Lie,
        _ => GoalPose::Stand,
    };
    SubGoal {
        id,
        at: posed.joints[0].with_y(lowest_m),
        facing: Some(facing_of(Vec2::new(front.x, front.z))),
        pose,
        stay_s: 1.0,
        planned: false,
        locked: true,
        body: Some(Frame::of(&person.body, &body.pose_space.decode(&person.body.pose))),
    }
}

/// A number that no sub-goal of the motion has, nor one that its frames still speak of.
fn free_id(goals: &[SubGoal], spoken_of: impl Iterator<Item = SubGoalId>) -> SubGoalId {
    let known = goals.iter().map(|goal| goal.id).chain(spoken_of).filter(|id| id.0 < PLANNED);
    SubGoalId(known.map(|id| id.0 + 1).max().unwrap_or(0))
}

/// The motion's sub-goals, those named by `anew` under numbers that were never used and without their bodies: a body
/// is drawn by its sub-goal's number, so this gives somebody else there.
pub fn renumbered(clip: &Clip, anew: &[SubGoalId]) -> Vec<SubGoal> {
    let spoken_of = clip.legs.iter().flat_map(|leg| [leg.from, leg.to]);
    let mut free = free_id(&clip.goals, spoken_of);
    let renumber = |goal: &SubGoal| {
        if !anew.contains(&goal.id) {
            return goal.clone();
        }
        let id = free;
        free.0 += 1;
        SubGoal { id, body: None, ..goal.clone() }
    };
    clip.goals.iter().map(renumber).collect()
}

/// Whether the person is the one that a motion which is shown moves: then only the motion shows them.
pub fn moves(clips: &[std::sync::Arc<Clip>], person: PersonId) -> bool {
    clips.iter().any(|clip| clip.person == Some(person) && !clip.frames.is_empty())
}
