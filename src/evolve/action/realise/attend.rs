//! What the hands and eyes of people are on while they do something: the keys, the pages, the fork and the cup as they
//! lie. Says where; the pose is made by who fits the body.

use glam::{Quat, Vec2, Vec3};

use super::evolution::Evolution;
use super::step::{EvolutionStep, MoveReason, StepPerson};
use super::world::Item;
use crate::body::{Attention, HandOn};
use crate::evolve::action::ActionKind;
use crate::math::Aabb;
use crate::scene::{ObjectId, PoseFamily, facing_of};

/// Nobody's hand goes farther from the pelvis than this over the plan, metres.
const REACH_M: f32 = 0.85;
/// Nor to what is so far behind the pelvis.
const BEHIND_M: f32 = -0.05;
/// Hands on keys and pages are so far from the middle, metres.
const BESIDE_M: f32 = 0.09;
/// Things taller than this are taken by the side, flatter ones from above, metres.
const TALL_M: f32 = 0.05;
/// A palm is so far from what it is on, metres: the hand's flesh is there first.
const OFF_M: f32 = 0.012;
/// Thickness of a laptop's lower half.
const KEYS_M: f32 = 0.022;

/// How something is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Grip {
    /// Both hands on its keys, which are the half towards the person where there is a screen.
    Keys,
    /// Both hands at its sides.
    Sides,
    /// The nearer hand.
    One,
}

/// What an action is about, the first first: kinds of the library and how they are used.
fn handled(kind: ActionKind) -> &'static [(&'static str, Grip)] {
    use Grip::{Keys, One, Sides};
    match kind {
        ActionKind::UseComputer => &[("keyboard", Keys), ("laptop", Keys), ("mouse", One)],
        ActionKind::UseLaptop => &[("laptop", Keys), ("keyboard", Keys), ("mouse", One)],
        ActionKind::ReadBook => {
            &[("book", Sides), ("magazine", Sides), ("newspaper", Sides), ("tablet", Sides), ("paper", Sides)]
        }
        ActionKind::PrepareFood => &[
            ("kitchen knife", One),
            ("knife", One),
            ("chopping board", Sides),
            ("pan", One),
            ("pot", One),
            ("bowl", One),
        ],
        ActionKind::WatchTv => &[("remote", One)],
        ActionKind::EatSnacks | ActionKind::EatDinner | ActionKind::EatDinnerInGroup => &[
            ("fork", One),
            ("knife", One),
            ("spoon", One),
            ("sandwich", One),
            ("hot dog", One),
            ("donut", One),
            ("pizza", One),
            ("cake", One),
            ("crisps", One),
            ("banana", One),
            ("apple", One),
            ("cup", One),
            ("glass", One),
            ("wine glass", One),
            ("bowl", One),
            ("plate", One),
        ],
    }
}

/// The upright frame of somebody: where pose families count from.
struct Frame {
    pelvis: Vec3,
    upright_from_world: Quat,
}

impl Frame {
    fn of(person: &StepPerson) -> Self {
        // Who lies has the head where the place looks, which is behind in the upright frame.
        let lies = person.family.group() == "lie";
        let ahead = if lies { -person.place.facing } else { person.place.facing };
        let upright_from_world = Quat::from_rotation_y(-facing_of(ahead));
        Self { pelvis: person.spot.pelvis, upright_from_world }
    }

    fn point(&self, world: Vec3) -> Vec3 {
        self.upright_from_world * (world - self.pelvis)
    }
}

/// Something within reach, in the upright frame of who uses it.
struct Near {
    label: String,
    grip: Grip,
    /// Place in the list of what the action is about.
    rank: usize,
    bounds: Aabb,
}

impl Near {
    fn far_m(&self) -> f32 {
        let middle = self.bounds.center();
        Vec2::new(middle.x, middle.z).length()
    }
}

/// What person `number` of a step has hands and eyes on; nothing where nothing that is used is at hand.
pub fn attention(evolution: &Evolution, step: &EvolutionStep, number: usize) -> Option<Attention> {
    let person = step.people.get(number).filter(|p| p.family != PoseFamily::LieUp)?;
    let frame = Frame::of(person);
    let mut near = near(evolution, step, number, &frame);
    near.sort_by(|a, b| a.rank.cmp(&b.rank).then(a.far_m().total_cmp(&b.far_m())));
    let mut hands = [None; 2];
    for thing in &near {
        take(&mut hands, thing);
    }
    let watched = watched(evolution, step, person).map(|at| frame.point(at));
    let look_at = watched.or(near.first().map(|thing| thing.bounds.center()));
    (hands.iter().any(Option::is_some) || look_at.is_some()).then_some(Attention { hands, look_at })
}

/// What the action is about that lies before the person.
fn near(evolution: &Evolution, step: &EvolutionStep, number: usize, frame: &Frame) -> Vec<Near> {
    let about = handled(step.kind);
    let mine = step.inserted.iter().filter(|thing| thing.person.is_none_or(|of| of == number)).map(|t| t.id);
    let used = step.moved.iter().filter(|thing| thing.why == MoveReason::Used).map(|thing| thing.id);
    let one = |id: ObjectId| {
        let item = evolution.world().item(id)?;
        let label = evolution.library().kind(item.kind?).kind.clone();
        let rank = about.iter().position(|(kind, _)| *kind == label)?;
        let thing = Near { label, grip: about[rank].1, rank, bounds: local_bounds(item, frame) };
        let ahead = thing.bounds.center().z > BEHIND_M || lies_prone(step, number);
        (thing.far_m() < REACH_M && ahead).then_some(thing)
    };
    mine.chain(used).filter_map(one).collect()
}

fn lies_prone(step: &EvolutionStep, number: usize) -> bool {
    step.people.get(number).is_some_and(|person| person.family == PoseFamily::LieDown)
}

/// The box of a thing in the frame of who uses it, around its own geometry.
fn local_bounds(item: &Item, frame: &Frame) -> Aabb {
    let place = item.world_from_item();
    let corners = item.shape.tree.triangles().iter().flatten();
    Aabb::of(corners.map(|p| frame.point(place.transform_point3(*p))))
}

/// Gives the hands that are still free to a thing.
fn take(hands: &mut [Option<HandOn>; 2], thing: &Near) {
    let (middle, half) = (thing.bounds.center(), 0.5 * thing.bounds.size());
    // Towards the person, along the plan.
    let back = Vec3::new(-middle.x, 0.0, -middle.z).normalize_or(Vec3::NEG_Z);
    let depth = (half.x * back.x.abs()).max(half.z * back.z.abs());
    let aside = Vec3::new(-back.z, 0.0, back.x);
    match thing.grip {
        Grip::Keys if hands.iter().all(Option::is_none) => {
            let has_screen = thing.label == "laptop";
            let top = if has_screen { thing.bounds.min.y + KEYS_M } else { thing.bounds.max.y };
            let keys = (middle + back * depth * if has_screen { 0.45 } else { 0.25 }).with_y(top + OFF_M);
            lay_both(hands, keys, aside * BESIDE_M);
        }
        Grip::Sides if hands.iter().all(Option::is_none) => {
            let width = (half.x * aside.x.abs() + half.z * aside.z.abs()).min(0.2);
            let at = (middle + back * depth * 0.4).with_y(thing.bounds.max.y + OFF_M);
            lay_both(hands, at, aside * (width - 0.03).max(0.05));
        }
        Grip::One => lay_one(hands, thing, middle, half),
        Grip::Keys | Grip::Sides => {}
    }
}

fn lay_both(hands: &mut [Option<HandOn>; 2], at: Vec3, aside: Vec3) {
    let aside = if aside.x >= 0.0 { aside } else { -aside };
    *hands = [at + aside, at - aside].map(|at| Some(HandOn { at, palm: Vec3::NEG_Y }));
}

/// The hand of the side that the thing lies on; a mouse belongs to the right one, which leaves the keys for it.
fn lay_one(hands: &mut [Option<HandOn>; 2], thing: &Near, middle: Vec3, half: Vec3) {
    let is_mouse = thing.label == "mouse";
    let side = usize::from(is_mouse || middle.x < 0.0);
    if hands[side].is_some() && !(is_mouse && middle.x < 0.0) {
        return;
    }
    let outward = if side == 0 { Vec3::X } else { Vec3::NEG_X };
    let tall = thing.bounds.size().y > TALL_M && half.x < 0.08;
    hands[side] = Some(if tall {
        HandOn { at: middle + outward * (half.x + OFF_M), palm: -outward }
    } else {
        HandOn { at: middle.with_y(thing.bounds.max.y + OFF_M), palm: Vec3::NEG_Y }
    });
}

/// The television that is watched.
fn watched(evolution: &Evolution, step: &EvolutionStep, person: &StepPerson) -> Option<Vec3> {
    if step.kind != ActionKind::WatchTv {
        return None;
    }
    let centre = |id: &ObjectId| {
        let item = evolution.world().item(*id).map(|item| item.bounds);
        let bounds = item.or_else(|| Some(evolution.stage().room.object(*id)?.world_bounds()))?;
        Some(bounds.center())
    };
    let apart = |at: &Vec3| at.distance(person.frame.centre_m);
    step.used.iter().filter_map(centre).min_by(|a, b| apart(a).total_cmp(&apart(b)))
}
