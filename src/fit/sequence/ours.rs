//! Our energy of a motion: what carries the body touches, nothing else is entered, planted feet stand, and apart from
//! that the motion stays what it was.

use glam::Vec3;

use super::config::MotionWeights;
use super::descent::{FrameState, MotionEnergy, Scratch, View};
use super::fitter::SequenceTask;
use super::stance::FootPlan;
use super::variables::{COSTS, NUMBERS};
use crate::body::joints::{BODY_JOINTS, JOINTS};
use crate::body::{Feet, JointLimit, Limb, Region};
use crate::fit::energy::{Energy, Term};
use crate::fit::goals::contact_goals;
use crate::fit::probe::Probe;
use crate::fit::surroundings::Bins;
use crate::fit::terms;
use crate::fit::terms::Distances;
use crate::math::Aabb;
use crate::scene::SignedDistanceField;

/// The energy, with all that it reads.
pub struct OurEnergy<'a> {
    pub weights: MotionWeights,
    pub task: &'a SequenceTask<'a>,
    pub field: &'a SignedDistanceField,
    /// Points on the room's surfaces, and where they are.
    pub surface: &'a [Vec3],
    pub bins: &'a Bins,
    pub probe: &'a Probe,
    pub limits: &'a [JointLimit; BODY_JOINTS],
    pub feet: &'a Feet,
    pub plan: &'a FootPlan,
}

impl MotionEnergy for OurEnergy<'_> {
    fn add(&self, view: &View<'_>, i: usize, out: &mut Scratch) {
        let w = &self.weights;
        let FrameState { workspace, intrusions } = &view.states[i];
        let Scratch { energy, distances, direct, .. } = out;
        self.contact(view.first + i, energy, distances);
        terms::collision(energy, distances, w.collision);
        intrusions.add_energy(energy, workspace.vertices(), w.intrusion);
        let joints = workspace.joints();
        terms::bones(energy, self.probe, joints, &|p| self.field.sample_gradient(p), w.bones);
        terms::self_collision(energy, self.probe, joints, w.self_collision);
        terms::joint_limits(energy, workspace.local_pose(), self.limits, w.joint_limits);
        self.planted(view.first + i, joints, energy);
        stay(view, i, w, energy, direct);
        smooth(view, i, w.smooth, energy);
    }

    fn search(&self, state: &mut FrameState) {
        let workspace = &state.workspace;
        let (vertices, rotations) = (workspace.vertices(), workspace.world_rotations());
        let bounds = Aabb::of(vertices.iter().copied());
        let near: Vec<Vec3> = match self.surface {
            [] => Vec::new(),
            surface => self.bins.around(&bounds).map(|p| surface[p as usize]).collect(),
        };
        state.intrusions.update(&near, self.probe, vertices, rotations);
    }
}

impl OurEnergy<'_> {
    /// What carries the body in a frame, besides the feet, which the plan places.
    fn contact(&self, frame: usize, energy: &mut Energy, distances: &Distances) {
        let Some(family) = self.task.rest(frame) else { return };
        let feet = [Region::LeftLeg, Region::RightLeg];
        for goal in contact_goals(family).iter().filter(|goal| !feet.contains(&goal.region)) {
            let region = &self.probe.regions[&goal.region];
            terms::gap(energy, region, distances, goal, self.weights.gap);
            terms::spread(energy, region, distances, self.weights.spread * goal.weight);
        }
    }

    /// Ankles and balls of planted feet come to their places.
    fn planted(&self, frame: usize, joints: &[Vec3; JOINTS], energy: &mut Energy) {
        let Some(places) = self.plan.places.get(frame) else { return };
        for (side, place) in places.iter().enumerate() {
            let Some(place) = place else { continue };
            let ankle = Limb::LEGS[side].end;
            let ball = ankle + super::stance::TOES_AFTER_ANKLE;
            for (joint, at) in [(ankle, place.ankle), (ball, self.feet.ball(side, place))] {
                let off = joints[joint] - at;
                energy.add(Term::Feet, self.weights.feet * off.length_squared());
                energy.joints[joint] += off * (2.0 * self.weights.feet);
            }
        }
    }
}

/// The change against the motion that came in stays small, and its second difference even smaller.
fn stay(view: &View<'_>, i: usize, w: &MotionWeights, energy: &mut Energy, direct: &mut [f32; NUMBERS]) {
    let last = view.states.len() - 1;
    let inner = |r: usize| r >= 1 && r < last;
    for k in 0..NUMBERS {
        let bend = |r: usize| view.change(r - 1, k) - 2.0 * view.change(r, k) + view.change(r + 1, k);
        let change = view.change(i, k);
        energy.add(Term::Start, w.stay * COSTS[k] * change * change);
        let mut slope = w.stay * change;
        if inner(i) {
            energy.add(Term::Smoothness, w.change * COSTS[k] * bend(i) * bend(i));
            slope -= 2.0 * w.change * bend(i);
        }
        if i >= 1 && inner(i - 1) {
            slope += w.change * bend(i - 1);
        }
        if inner(i + 1) {
            slope += w.change * bend(i + 1);
        }
        direct[k] += 2.0 * COSTS[k] * slope;
    }
}

/// Squared second differences of the body joints' places.
fn smooth(view: &View<'_>, i: usize, weight: f32, energy: &mut Energy) {
    let last = view.states.len() - 1;
    let at = |r: usize, j: usize| view.states[r].workspace.joints()[j];
    let bend = |r: usize, j: usize| at(r - 1, j) - at(r, j) * 2.0 + at(r + 1, j);
    for (row, share) in [(i.wrapping_sub(1), 1.0), (i, -2.0), (i + 1, 1.0)] {
        if row < 1 || row >= last {
            continue;
        }
        for j in 0..=BODY_JOINTS {
            let bend = bend(row, j);
            if row == i {
                energy.add(Term::Smoothness, weight * bend.length_squared());
            }
            energy.joints[j] += bend * (2.0 * weight * share);
        }
    }
}
