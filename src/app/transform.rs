//! Moving and turning the selection with the mouse or by typing, as in Blender: G or R, then X, Y or Z, a number,
//! Enter or a click to keep it, Esc or the right button to leave everything as it was. One undo step.

use egui::{Key, Modifiers};
use glam::{Affine3A, Mat3, Vec3};

use super::motion::carried_goal;
use super::pick::{self, Ray};
use super::selection::Item;
use super::state::EditorState;
use crate::body::Body;
use crate::document::Command;
use crate::scene::BodyParams;
use crate::scene::ClipId;
use crate::scene::GoalPose;
use crate::scene::ObjectId;
use crate::scene::PersonId;
use crate::scene::SubGoal;

/// Farther than this nobody moves by mouse: near the horizon a pixel is a kilometre. Metres.
const FARTHEST_M: f32 = 30.0;
/// With Ctrl held moves go in steps of this, metres.
const SNAP_M: f32 = 0.1;
/// With Ctrl held turns go in steps of this, degrees.
const SNAP_DEG: f32 = 15.0;

/// What the mouse does to the selection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TransformKind {
    /// Over the floor, or along one axis.
    Move,
    /// About the vertical.
    Turn,
}

/// A move or turn under way. Holds everything as it was, so that each step starts from there.
#[derive(Clone, Debug)]
pub struct Transform {
    /// Which.
    pub kind: TransformKind,
    /// 0, 1 or 2 when held to an axis.
    pub axis: Option<usize>,
    /// What was typed: metres or degrees.
    pub typed: String,
    people: Vec<(PersonId, BodyParams)>,
    objects: Vec<(ObjectId, Affine3A)>,
    goals: Vec<(ClipId, SubGoal)>,
    /// Ends when the button is let go of, not with a click.
    pub by_drag: bool,
    pivot: Vec3,
    /// Where the mouse was when it began.
    from: Option<Ray>,
    /// What it amounts to now: metres moved, or radians about the vertical.
    moved_m: Vec3,
    turned_rad: f32,
}

impl Transform {
    /// What it amounts to, for the status bar.
    pub fn text(&self) -> String {
        let axis = self.axis.map_or("", |axis| [" along X", " along Y", " along Z"][axis]);
        let typed = if self.typed.is_empty() { String::new() } else { format!(" [{}]", self.typed) };
        let amount = match self.kind {
            TransformKind::Move => {
                let m = self.moved_m;
                format!("Move {:.2}, {:.2}, {:.2} m{axis}", m.x, m.y, m.z)
            }
            TransformKind::Turn => format!("Turn {:.1}°", self.turned_rad.to_degrees()),
        };
        format!(
            "{amount}{typed}   X Y Z: axis   number: exactly   Ctrl: steps   Enter or click: keep   Esc: leave"
        )
    }

    /// The sub-goal that is moved by itself over whatever the mouse points at: one on a seat or bed.
    fn over_surfaces(&self) -> bool {
        let alone = self.people.is_empty() && self.objects.is_empty() && self.goals.len() == 1;
        let rests = self.goals.iter().all(|(_, goal)| !matches!(goal.pose, GoalPose::Walk | GoalPose::Stand));
        alone && rests && self.kind == TransformKind::Move && self.axis.is_none() && self.typed.is_empty()
    }

    /// Sub-goals as they are after what was done.
    fn moved_goals(&self) -> Vec<(ClipId, SubGoal)> {
        let rigid = self.rigid();
        self.goals.iter().map(|(clip, goal)| (*clip, carried_goal(goal, &rigid, self.turned_rad))).collect()
    }

    /// Whether a person is being moved.
    pub fn holds(&self, id: PersonId) -> bool {
        self.people.iter().any(|(of, _)| *of == id)
    }

    fn number(&self) -> Option<f32> {
        self.typed.parse().ok().filter(|n: &f32| n.is_finite())
    }

    /// Sets what it amounts to from where the mouse points.
    fn follow(&mut self, ray: &Ray, snap: bool) {
        let from = *self.from.get_or_insert(*ray);
        match self.kind {
            TransformKind::Move => self.follow_move(&from, ray, snap),
            TransformKind::Turn => self.follow_turn(&from, ray, snap),
        }
    }

    fn follow_move(&mut self, from: &Ray, to: &Ray, snap: bool) {
        // Upwards along a wall that faces the camera, otherwise over the floor.
        let normal =
            if self.axis == Some(1) { -to.direction.with_y(0.0).normalize_or(Vec3::Z) } else { Vec3::Y };
        let (Some(a), Some(b)) = (on_plane(from, self.pivot, normal), on_plane(to, self.pivot, normal))
        else {
            return;
        };
        let mut moved = (b - a).clamp_length_max(FARTHEST_M);
        moved = match self.axis {
            Some(axis) => Vec3::AXES[axis] * moved[axis],
            None => moved.with_y(0.0),
        };
        self.moved_m = if snap { (moved / SNAP_M).round() * SNAP_M } else { moved };
    }

    fn follow_turn(&mut self, from: &Ray, to: &Ray, snap: bool) {
        let around = |ray: &Ray| {
            let at = on_plane(ray, self.pivot, Vec3::Y)? - self.pivot;
            (at.length() > 1e-3).then(|| (-at.z).atan2(at.x))
        };
        if let (Some(a), Some(b)) = (around(from), around(to)) {
            let full = std::f32::consts::TAU;
            let turned = (b - a + 0.5 * full).rem_euclid(full) - 0.5 * full;
            let step = SNAP_DEG.to_radians();
            self.turned_rad = if snap { (turned / step).round() * step } else { turned };
        }
    }

    /// Sets what it amounts to from what was typed.
    fn obey(&mut self) {
        let Some(number) = self.number() else { return };
        match self.kind {
            TransformKind::Move => self.moved_m = Vec3::AXES[self.axis.unwrap_or(0)] * number,
            TransformKind::Turn => self.turned_rad = number.to_radians(),
        }
    }

    /// World after from world before.
    fn rigid(&self) -> Affine3A {
        let about = Affine3A::from_translation(self.pivot);
        let back = Affine3A::from_translation(-self.pivot);
        Affine3A::from_translation(self.moved_m) * about * Affine3A::from_rotation_y(self.turned_rad) * back
    }

    fn commands(&self) -> Vec<Command> {
        let rigid = self.rigid();
        let people = self.people.iter().map(|(id, body)| Command::SetBody(*id, carried(body, &rigid)));
        let objects = self.objects.iter().map(|(id, from)| Command::MoveObject(*id, rigid * *from));
        people.chain(objects).collect()
    }
}

/// The body after a rigid motion of the world: its pelvis joint goes along, its rotation turns.
fn carried(body: &BodyParams, rigid: &Affine3A) -> BodyParams {
    let pelvis = Body::bundled().pose(body).joints[0];
    let mut moved = body.clone();
    moved.translation += rigid.transform_point3(pelvis) - pelvis;
    moved.set_rotation(&(Mat3::from(rigid.matrix3) * body.rotation()));
    moved
}

/// Where a ray meets the plane through `point`; nowhere behind it or beyond the horizon.
pub fn on_plane(ray: &Ray, point: Vec3, normal: Vec3) -> Option<Vec3> {
    let along = ray.direction.dot(normal);
    let distance_m = (point - ray.origin).dot(normal) / along;
    (along.abs() > 1e-4 && distance_m > 0.0).then(|| ray.origin + ray.direction * distance_m)
}

impl EditorState {
    /// Begins to move or turn what is selected and not locked.
    pub fn begin_transform(&mut self, kind: TransformKind) {
        self.end_transform(false);
        let scene = self.document.scene();
        let people: Vec<_> = self
            .selection
            .people()
            .into_iter()
            .filter_map(|id| scene.person(id).filter(|p| !p.locked).map(|p| (id, p.body.clone())))
            .collect();
        let objects: Vec<_> = self
            .selection
            .objects()
            .into_iter()
            .filter_map(|id| scene.room.object(id).filter(|o| !o.locked).map(|o| (id, o.world_from_object)))
            .collect();
        let free = |clip: ClipId| scene.clip(clip).is_some_and(|clip| !clip.locked);
        let goals: Vec<(ClipId, SubGoal)> = self
            .selection
            .goals()
            .into_iter()
            .filter(|(clip, _)| free(*clip))
            .filter_map(|(clip, goal)| Some((clip, self.goal(clip, goal)?.clone())))
            .collect();
        if people.is_empty() && objects.is_empty() && goals.is_empty() {
            self.notices.warning("Nothing to move: select people, sub-goals or things that are not locked.");
            return;
        }
        let items = people.iter().map(|(id, _)| Item::Person(*id));
        let items = items.chain(objects.iter().map(|(id, _)| Item::Object(*id)));
        let items = items.chain(goals.iter().map(|(clip, goal)| Item::Goal(*clip, goal.id)));
        let bounds = items.fold(crate::math::Aabb::EMPTY, |all, item| all.union(self.bounds_of(item)));
        let only_goals = people.is_empty() && objects.is_empty();
        let pivot = if only_goals { bounds.center().with_y(goals[0].1.at.y) } else { bounds.center() };
        self.document.begin(if kind == TransformKind::Move { "Move" } else { "Turn" });
        self.transform = Some(Transform {
            kind,
            axis: None,
            typed: String::new(),
            people,
            objects,
            goals,
            by_drag: false,
            pivot,
            from: None,
            moved_m: Vec3::ZERO,
            turned_rad: 0.0,
        });
    }

    /// The mouse points along `ray`; with `snap` in round steps.
    pub fn drag_transform(&mut self, ray: &Ray, snap: bool) {
        let picked = pick::pick_object(self, ray).map(|picked| picked.point);
        let Some(transform) = &mut self.transform else { return };
        if transform.over_surfaces() {
            if let Some(point) = picked {
                transform.moved_m = point - transform.goals[0].1.at;
            }
        } else if transform.typed.is_empty() {
            transform.follow(ray, snap);
        }
        self.apply_transform();
    }

    fn apply_transform(&mut self) {
        let commands = self.transform.as_ref().map(Transform::commands).unwrap_or_default();
        for command in commands {
            self.apply(command);
        }
        let goals = self.transform.as_ref().map(Transform::moved_goals).unwrap_or_default();
        self.put_goals(&goals);
        if let [(clip, goal)] = goals.as_slice() {
            self.ask_reach(*clip, goal.id);
        }
    }

    /// A key while something is moved; whether it meant anything.
    pub fn key_in_transform(&mut self, key: Key, modifiers: Modifiers) -> bool {
        let Some(transform) = &mut self.transform else { return false };
        match key {
            Key::X | Key::Y | Key::Z if modifiers.is_none() => {
                let axis = [Key::X, Key::Y, Key::Z].iter().position(|k| *k == key);
                transform.axis = if transform.axis == axis { None } else { axis };
                transform.moved_m = Vec3::ZERO;
                transform.obey();
                self.apply_transform();
            }
            Key::Enter => self.end_transform(true),
            Key::Escape => self.end_transform(false),
            Key::G => self.begin_transform(TransformKind::Move),
            Key::R => self.begin_transform(TransformKind::Turn),
            Key::Backspace => {
                transform.typed.pop();
                transform.obey();
                self.apply_transform();
            }
            _ => {
                let Some(sign) = typed_sign(key) else { return true };
                transform.typed.push(sign);
                transform.obey();
                self.apply_transform();
            }
        }
        true
    }

    /// Keeps what was done, or puts everything back.
    pub fn end_transform(&mut self, keep: bool) {
        let Some(transform) = self.transform.take() else { return };
        self.motion.reach = None;
        if !keep {
            self.document.abort();
            return;
        }
        self.document.commit();
        let people: Vec<PersonId> = transform.people.into_iter().map(|(id, _)| id).collect();
        if self.populate.settle && !people.is_empty() {
            self.settle(&people);
        }
        if let Some((clip, _)) = transform.goals.first() {
            self.follow_change(*clip);
        }
    }
}

/// What a key types into a number.
fn typed_sign(key: Key) -> Option<char> {
    let digits = [
        Key::Num0,
        Key::Num1,
        Key::Num2,
        Key::Num3,
        Key::Num4,
        Key::Num5,
        Key::Num6,
        Key::Num7,
        Key::Num8,
        Key::Num9,
    ];
    match key {
        Key::Minus => Some('-'),
        Key::Period => Some('.'),
        _ => digits.iter().position(|k| *k == key).and_then(|n| char::from_digit(n as u32, 10)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_carried_body_is_the_same_body_somewhere_else() {
        let mut body = BodyParams { translation: Vec3::new(0.4, 0.9, -1.0), ..BodyParams::default() };
        body.betas[0] = 1.0;
        let pivot = Vec3::new(1.0, 0.0, 2.0);
        let rigid = Affine3A::from_translation(pivot)
            * Affine3A::from_rotation_y(0.7)
            * Affine3A::from_translation(Vec3::new(0.3, 0.1, 0.0) - pivot);
        let before = Body::bundled().pose(&body).vertices;
        let after = Body::bundled().pose(&carried(&body, &rigid)).vertices;
        for (a, b) in before.iter().zip(&after).step_by(97) {
            assert!(rigid.transform_point3(*a).distance(*b) < 1e-4);
        }
    }

    #[test]
    fn a_ray_meets_the_floor_before_it_and_not_behind() {
        let ray = Ray { origin: Vec3::new(0.0, 2.0, 0.0), direction: Vec3::new(0.6, -0.8, 0.0) };
        let met = on_plane(&ray, Vec3::ZERO, Vec3::Y).expect("the floor");
        assert!(met.distance(Vec3::new(1.5, 0.0, 0.0)) < 1e-5);
        assert!(on_plane(&ray, Vec3::Y * 3.0, Vec3::Y).is_none());
    }
}
