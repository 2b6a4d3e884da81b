//! Everything that fills the time between two bodies, by the names of LTM's tables.

use std::collections::BTreeMap;

use glam::Vec2;
use rand_distr::{Distribution as _, StandardNormal};

use crate::assets::{Weights, WeightsError};
use crate::body::Body;
use crate::body::joints::PELVIS;
use crate::job::{Cancelled, Seed, Ticker};
use crate::learn::motion::data::{MotionData, WindowRows};
use crate::learn::motion::staging::{Rest, rests_of};
use crate::learn::motion::takes::{Take, WINDOW};
use crate::learn::motion::train::{RouteOf, fill_windows};
use crate::motion::gait;
use crate::motion::learned::{LegEnds, LegScene, stretched};
use crate::motion::leg::{EndState, LegInput, PathPoint, Still, Walking};
use crate::motion::local::{LegFrame, code_of};
use crate::motion::retrieval::MotionMemory;
use crate::nn::motion::{BETWEEN, Between, CONDITION, MotionKind, MotionSampler, PLACE, ROW};
use crate::scene::{BETAS, CLIP_FPS, Frame, GoalPose, facing_of};

/// Whoever moves faster at a sub-goal walks through it, metres a second.
const WALKS_M_PER_S: f32 = 0.45;

/// The trained networks that there are, by kind and by whether they see the room.
#[derive(Default)]
pub struct MotionNets {
    nets: BTreeMap<(&'static str, bool), MotionSampler>,
}

impl MotionNets {
    /// Adds the network of a weight file; gives its name.
    ///
    /// # Errors
    /// [`WeightsError`] when the file holds none.
    pub fn add(&mut self, weights: &Weights) -> Result<&'static str, WeightsError> {
        let sampler = MotionSampler::from_weights(weights)?;
        let label = sampler.config().kind.label();
        self.nets.insert((label, sampler.config().scene), sampler);
        Ok(label)
    }

    fn of(&self, kind: MotionKind, scene: bool) -> Option<&MotionSampler> {
        self.nets.get(&(kind.label(), scene))
    }

    fn between(&self, which: Between, scene: bool) -> Option<&MotionSampler> {
        self.of(MotionKind::Between(which), scene)
    }
}

/// Who makes the motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Maker {
    /// The captured frames.
    Truth,
    /// The straight line from body to body: what any maker has to beat.
    Line,
    /// RouteNet(t) and a PoseNet that turns the body too, without the route.
    RouteWhere(bool),
    /// RouteNet(t+r) and a PoseNet without the route.
    RouteAlone(bool),
    /// BaseNet.
    Base(bool),
    /// RouteNet, and a body of the sub-goal network at every place of the route.
    RouteCvae,
    /// A memory of the training clips.
    Retrieval,
    /// RouteNet and PoseNet: LTM.
    Learned,
    /// The same with its ends met: what the program uses.
    LearnedMet,
    /// The program's own walking by rule and statistics, along the captured way; it meets sub-goals that are walked
    /// through in bodies of its own.
    Gait,
}

impl Maker {
    /// In the order of Table 1.
    pub const ALL: [Self; 12] = [
        Self::RouteWhere(false),
        Self::RouteWhere(true),
        Self::RouteAlone(false),
        Self::RouteAlone(true),
        Self::Base(false),
        Self::Base(true),
        Self::RouteCvae,
        Self::Retrieval,
        Self::Learned,
        Self::LearnedMet,
        Self::Line,
        Self::Truth,
    ];

    /// Name in the tables, and whether it sees the room.
    pub fn label(self) -> (&'static str, bool) {
        match self {
            Self::Truth => ("captured", true),
            Self::Line => ("straight line", false),
            Self::RouteWhere(scene) => ("RouteNet(t)+PoseNet", scene),
            Self::RouteAlone(scene) => ("RouteNet(t+r)+PoseNet", scene),
            Self::Base(scene) => ("BaseNet", scene),
            Self::RouteCvae => ("Route+CVAE", true),
            Self::Retrieval => ("retrieval (HSNMS-like)", false),
            Self::Learned => ("RouteNet and PoseNet (LTM)", true),
            Self::LearnedMet => ("the same, ends met", true),
            Self::Gait => ("gait (the default)", true),
        }
    }

    /// Whether it is there with these networks.
    pub fn is_there(self, nets: &MotionNets) -> bool {
        match self {
            Self::Truth | Self::Line | Self::Retrieval | Self::Gait => true,
            Self::RouteWhere(scene) => {
                nets.between(Between::RouteWhere, scene).is_some()
                    && nets.between(Between::PoseTurning, scene).is_some()
            }
            Self::RouteAlone(scene) => {
                nets.between(Between::Route, scene).is_some()
                    && nets.between(Between::PoseAlone, scene).is_some()
            }
            Self::Base(scene) => nets.between(Between::Base, scene).is_some(),
            Self::RouteCvae => {
                nets.between(Between::Route, true).is_some() && nets.of(MotionKind::SubGoal, true).is_some()
            }
            Self::Learned | Self::LearnedMet => {
                nets.between(Between::Route, true).is_some() && nets.between(Between::Pose, true).is_some()
            }
        }
    }
}

/// What makers work with.
pub(super) struct Bench<'a> {
    pub data: &'a MotionData,
    pub nets: &'a MotionNets,
    pub memory: MotionMemory,
    pub body: &'a Body,
}

impl Bench<'_> {
    /// [`WINDOW`] frames from the first body of `truth` to its last; both stand there as they are. `None` when a network
    /// is missing or the memory empty.
    pub fn make(
        &self,
        maker: Maker,
        take: &Take,
        first: usize,
        seed: Seed,
        ticker: &Ticker,
    ) -> Result<Option<Vec<Frame>>, Cancelled> {
        let truth = &take.frames[first..first + WINDOW];
        let (start, end) = (&truth[0], &truth[WINDOW - 1]);
        let betas = [0.0; BETAS];
        let seconds = (WINDOW - 1) as f32 / CLIP_FPS;
        let ends = LegEnds { betas: &betas, from: start, to: end, floor_m: 0.0, seconds: Some(seconds) };
        match maker {
            Maker::Truth => return Ok(Some(truth.to_vec())),
            Maker::Gait => return Ok(Some(self.walked(truth, seed, ticker)?)),
            Maker::Retrieval => {
                // At both ends the speed is known, as it is at a sub-goal that is walked through.
                let speed =
                    |a: usize, b: usize| Some((truth[b].translation - truth[a].translation) * CLIP_FPS);
                let speeds = [speed(0, 1), speed(WINDOW - 2, WINDOW - 1)];
                let leg = self.memory.leg(self.body, &ends, speeds, &[], ticker)?;
                return Ok(leg.map(|leg| leg.frames));
            }
            _ => {}
        }
        let points = self.nets.nets.values().map(|n| n.config().points.count).max().unwrap_or(0);
        let number = self.data.takes.iter().position(|t| std::ptr::eq(t, take)).unwrap_or(0);
        let window = crate::learn::motion::Window { take: number, first };
        let window = self.data.rows(window, points, seed.child("cloud", 0));
        Ok(self.rows(maker, take, &window, seed).map(|rows| match maker {
            Maker::LearnedMet => {
                let scene = LegScene {
                    leg: window.leg,
                    rows: [window.rows[0], window.rows[WINDOW - 1]],
                    clouds: Default::default(),
                };
                scene.frames(self.body, &ends, &rows)
            }
            _ => self.as_given(&window.leg, &rows, [start, end]),
        }))
    }

    /// A leg of the program's own walking along the captured way.
    fn walked(&self, truth: &[Frame], seed: Seed, ticker: &Ticker) -> Result<Vec<Frame>, Cancelled> {
        let rest = self.body.model.joint_template[PELVIS];
        let floor = |f: &Frame| (f.translation + rest).with_y(0.0);
        let last = truth.len() - 1;
        let state = |at: usize, beside: usize| {
            let ahead = (floor(&truth[at.max(beside)]) - floor(&truth[at.min(beside)])) * CLIP_FPS;
            let upright = rests_of(self.body, &truth[at..=at])[0] == Rest::None;
            match upright && ahead.length() > WALKS_M_PER_S {
                true => EndState::Walking(Walking {
                    at: floor(&truth[at]),
                    heading: facing_of(Vec2::new(ahead.x, ahead.z)),
                    speed_m_per_s: ahead.length(),
                }),
                false => EndState::Still(Still {
                    frame: truth[at].clone(),
                    pose: if upright { GoalPose::Stand } else { GoalPose::Sit },
                }),
            }
        };
        let point = |k: usize| {
            let (a, b) = (floor(&truth[k.saturating_sub(3)]), floor(&truth[(k + 3).min(last)]));
            let seconds = ((k + 3).min(last) - k.saturating_sub(3)) as f32 / CLIP_FPS;
            PathPoint {
                at: floor(&truth[k]),
                heading: facing_of(Vec2::new(b.x - a.x, b.z - a.z)),
                clearance_m: 1.0,
                speed_m_per_s: a.distance(b) / seconds,
            }
        };
        let moved = floor(&truth[0]).distance(floor(&truth[last])) > 0.3;
        let input = LegInput {
            from: state(0, 1),
            to: state(last, last - 1),
            path: if moved { (0..=last).map(point).collect() } else { vec![point(0)] },
            betas: [0.0; BETAS],
            seconds: Some(last as f32 / CLIP_FPS),
            seed,
        };
        let made = gait::synthesise_leg(self.body, &input, ticker)?;
        Ok(stretched(&made.frames, WINDOW))
    }

    /// Rows between the two ends as they come out.
    fn as_given(&self, leg: &LegFrame, rows: &[[f32; ROW]], [start, end]: [&Frame; 2]) -> Vec<Frame> {
        let rest = self.body.model.joint_template[PELVIS];
        let frame = |row: &[f32; ROW]| Frame {
            pose: self.body.pose_space.decode(&code_of(row)),
            ..leg.placed(row, rest)
        };
        let mut frames = vec![start.clone()];
        frames.extend(rows.iter().map(frame));
        frames.push(end.clone());
        frames
    }

    fn rows(&self, maker: Maker, take: &Take, window: &WindowRows, seed: Seed) -> Option<Vec<[f32; ROW]>> {
        let mut rows = line(&window.rows[0], &window.rows[WINDOW - 1]);
        let put = |which: Between, scene: bool, route: RouteOf<'_>, rows: &mut [[f32; ROW]]| {
            let net = self.nets.between(which, scene)?;
            let made = fill_windows(net, which, route, std::slice::from_ref(window)).pop()?;
            let columns = which.outputs();
            for (row, made) in rows.iter_mut().zip(made.chunks_exact(columns.len())) {
                row[columns.clone()].copy_from_slice(made);
            }
            Some(())
        };
        match maker {
            Maker::RouteWhere(scene) => {
                put(Between::RouteWhere, scene, None, &mut rows)?;
                put(Between::PoseTurning, scene, None, &mut rows)?;
            }
            Maker::RouteAlone(scene) => {
                put(Between::Route, scene, None, &mut rows)?;
                put(Between::PoseAlone, scene, None, &mut rows)?;
            }
            Maker::Base(scene) => put(Between::Base, scene, None, &mut rows)?,
            Maker::Learned | Maker::LearnedMet => {
                put(Between::Route, true, None, &mut rows)?;
                put(Between::Pose, true, self.nets.between(Between::Route, true), &mut rows)?;
            }
            Maker::RouteCvae => {
                put(Between::Route, true, None, &mut rows)?;
                self.pose_by_sub_goals(take, &window.leg, &mut rows, seed)?;
            }
            Maker::Line | Maker::Truth | Maker::Retrieval | Maker::Gait => {}
        }
        Some(rows)
    }

    /// A body of the sub-goal network at every place of a route, all from one code (LTM §4.4, Route+CVAE).
    fn pose_by_sub_goals(
        &self,
        take: &Take,
        leg: &LegFrame,
        rows: &mut [[f32; ROW]],
        seed: Seed,
    ) -> Option<()> {
        let net = self.nets.of(MotionKind::SubGoal, true)?;
        let rest = self.body.model.joint_template[PELVIS];
        let mut rng = seed.child("sub-goal", 0).rng();
        let code: Vec<f32> = (0..net.config().latent).map(|_| StandardNormal.sample(&mut rng)).collect();
        for (k, row) in rows.iter_mut().enumerate() {
            let placed = leg.placed(row, rest);
            let own = LegFrame::of(&placed, rest, 0.0);
            let here = own.row(&placed, &code_of(row), rest);
            let mut asked = [0.0; CONDITION];
            asked[..PLACE].copy_from_slice(&here[..PLACE]);
            let count = net.config().points.count;
            let ends = [placed.translation; 2];
            let cloud = take.room.points.around(&own, ends, count, seed.child("cloud", k as u64)).0;
            let body = net.bodies(&cloud, &asked, &code).pop()?;
            row[PLACE..].copy_from_slice(&body[PLACE..]);
        }
        Some(())
    }
}

/// The straight line between two rows.
fn line(start: &[f32; ROW], end: &[f32; ROW]) -> Vec<[f32; ROW]> {
    let at = |k: usize| {
        let share = k as f32 / (BETWEEN + 1) as f32;
        std::array::from_fn(|c| start[c] + (end[c] - start[c]) * share)
    };
    (1..=BETWEEN).map(at).collect()
}
