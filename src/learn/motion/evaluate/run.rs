use std::collections::BTreeMap;
use std::ops::ControlFlow;

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::makers::{Bench, Maker, MotionNets};
use super::rows::{Measured, MotionRowKind, MotionStudyRow, Optimised};
use crate::body::joints::PELVIS;
use crate::body::{Body, Workspace};
use crate::fit::sequence::{SequenceConfig, SequenceFitter, SequencePreset, SequenceTask};
use crate::inspect::{MotionErrors, inspect_motion, mean_distance_mm};
use crate::job::{Seed, Stop, Ticker};
use crate::learn::corpus::Split;
use crate::learn::motion::data::{MotionData, Window};
use crate::learn::motion::staging::{Rest, labelled_triangles, rests_of};
use crate::learn::motion::takes::{Take, WINDOW};
use crate::motion::capture::Recording;
use crate::motion::planted::planted_feet;
use crate::motion::retrieval::MotionMemory;
use crate::scene::{
    BETAS, CLIP_FPS, Clip, Frame, GeometryConfig, GoalPose, Leg, ObjectId, PoseFamily, Resolution,
    RoomGeometry, SubGoal, SubGoalId, bake_cached, facing_of,
};

/// How much is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionStudyConfig {
    /// Windows of two seconds, of every activity alike.
    pub windows: usize,
    /// Of these so many are optimised too.
    pub optimised: usize,
    /// Motions of each length through several sub-goals.
    pub long: usize,
    /// Root of the seed tree.
    pub seed: u64,
}

impl Default for MotionStudyConfig {
    fn default() -> Self {
        Self { windows: 60, optimised: 15, long: 6, seed: 0 }
    }
}

/// Samples of the rooms' distance fields, metres: staged rooms are boxes, 3 cm tell them.
const FIELD_CELL_M: f32 = 0.03;
/// Makers that are optimised too.
const OPTIMISED: [Maker; 3] = [Maker::RouteCvae, Maker::Retrieval, Maker::LearnedMet];
/// Makers of the long motions.
const LONG: [Maker; 5] = [Maker::Truth, Maker::RouteCvae, Maker::Retrieval, Maker::LearnedMet, Maker::Gait];
/// Legs of the long motions: two, four and six seconds.
const LEGS: [usize; 3] = [1, 2, 3];

struct Study<'a> {
    bench: Bench<'a>,
    fitter: SequenceFitter<'a>,
    rooms: BTreeMap<usize, RoomGeometry>,
    seed: Seed,
    ticker: &'a Ticker,
}

/// Measures every maker that there is on the held-out clips; `each` gets every row as soon as it is known.
///
/// # Errors
/// [`Stop::Cancelled`] once the user cancelled, what `each` says, or [`Stop::Failed`] when there is no held-out window.
pub fn run_motion_study(
    data: &MotionData,
    nets: &MotionNets,
    config: &MotionStudyConfig,
    ticker: &Ticker,
    each: &mut dyn FnMut(&MotionStudyRow) -> Result<(), Stop>,
) -> Result<Vec<MotionStudyRow>, Stop> {
    let body = Body::bundled();
    let windows = data.measured(Split::Test, config.windows);
    if windows.is_empty() {
        return Err(Stop::Failed(
            "no held-out clip is two seconds long; give more clips with --corpus".into(),
        ));
    }
    let mut study = Study {
        bench: Bench { data, nets, memory: memory_of(data, body), body },
        fitter: SequenceFitter::new(body),
        rooms: BTreeMap::new(),
        seed: Seed::root(config.seed).child("study", 0),
        ticker,
    };
    let cases: Vec<(Window, usize)> = windows.iter().map(|w| (*w, 1)).collect();
    study.bake(&cases)?;
    let mut rows = Vec::new();
    let mut keep = |row: Option<MotionStudyRow>| -> Result<(), Stop> {
        if let Some(row) = row {
            each(&row)?;
            rows.push(row);
        }
        Ok(())
    };
    for maker in Maker::ALL {
        keep(study.row(MotionRowKind::Short, maker, Optimised::No, &cases)?)?;
    }
    let step = cases.len().div_ceil(config.optimised.max(1)).max(1);
    let few: Vec<(Window, usize)> = cases.iter().step_by(step).copied().collect();
    for optimised in [Optimised::Ours, Optimised::Paper] {
        for maker in OPTIMISED {
            keep(study.row(MotionRowKind::Short, maker, optimised, &few)?)?;
        }
    }
    for legs in LEGS {
        let cases = long_cases(data, legs, config.long);
        study.bake(&cases)?;
        for maker in LONG {
            let optimised = if maker == Maker::Truth { Optimised::No } else { Optimised::Ours };
            keep(study.row(MotionRowKind::Long, maker, optimised, &cases)?)?;
        }
    }
    Ok(rows)
}

/// The takes that are learnt from, as a memory: the test's clips are not in it.
fn memory_of(data: &MotionData, body: &Body) -> MotionMemory {
    let of = |t: &Take| Recording { name: t.clip.clone(), mirrored: false, frames: t.frames.clone() };
    let known = data.takes.iter().filter(|t| t.split == Split::Train).map(of);
    MotionMemory::of_recordings(known.collect(), body)
}

/// Beginnings of motions of `legs` windows one after the other, of different takes as far as there are.
fn long_cases(data: &MotionData, legs: usize, most: usize) -> Vec<(Window, usize)> {
    let frames = legs * (WINDOW - 1) + 1;
    let fits =
        data.takes.iter().enumerate().filter(|(_, t)| t.split == Split::Test && t.frames.len() >= frames);
    let windows: Vec<Window> =
        fits.map(|(take, t)| Window { take, first: (t.frames.len() - frames) / 2 }).collect();
    windows.iter().step_by(windows.len().div_ceil(most.max(1)).max(1)).map(|w| (*w, legs)).collect()
}

impl Study<'_> {
    /// The geometry of the rooms of these cases.
    fn bake(&mut self, cases: &[(Window, usize)]) -> Result<(), Stop> {
        self.ticker.stage("distance fields", cases.len())?;
        let ticker = self.ticker;
        let step = |_: usize, _: usize| match ticker.check() {
            Ok(()) => ControlFlow::Continue(()),
            Err(_) => ControlFlow::Break(()),
        };
        let mut config = GeometryConfig::default();
        config.field.resolution = Resolution::Cells { cell_m: FIELD_CELL_M, max_bytes: 256 << 20 };
        for (window, _) in cases {
            ticker.advance()?;
            if self.rooms.contains_key(&window.take) {
                continue;
            }
            let labelled = labelled_triangles(&self.bench.data.takes[window.take].room.layout)?;
            let owner = labelled.iter().map(|(_, class)| ObjectId(u32::from(*class))).collect();
            let triangles: Vec<_> = labelled.into_iter().map(|(triangle, _)| triangle).collect();
            let field = bake_cached(&triangles, &config.field, &step).map_err(|_| Stop::Cancelled)?;
            let room = RoomGeometry::from_field(triangles, owner, field, &config, &step);
            self.rooms.insert(window.take, room.map_err(|_| Stop::Cancelled)?);
        }
        Ok(())
    }

    /// One maker over all cases; `None` when it isn't there.
    fn row(
        &self,
        kind: MotionRowKind,
        maker: Maker,
        optimised: Optimised,
        cases: &[(Window, usize)],
    ) -> Result<Option<MotionStudyRow>, Stop> {
        if cases.is_empty() || !maker.is_there(self.bench.nets) {
            return Ok(None);
        }
        self.ticker.stage(maker.label().0, cases.len())?;
        let one = |(number, (window, legs)): (usize, &(Window, usize))| {
            let seed = self.seed.child("case", number as u64);
            let measured = self.case(maker, optimised, *window, *legs, seed)?;
            self.ticker.advance()?;
            Ok(measured)
        };
        let measured: Vec<Option<Measured>> =
            cases.par_iter().enumerate().map(one).collect::<Result<_, Stop>>()?;
        let measured: Vec<Measured> = measured.into_iter().flatten().collect();
        let seconds = 2 * cases[0].1 as u32;
        let row = || MotionStudyRow::mean(kind, maker.label(), optimised, seconds, &measured);
        Ok((!measured.is_empty()).then(row))
    }

    fn case(
        &self,
        maker: Maker,
        optimised: Optimised,
        window: Window,
        legs: usize,
        seed: Seed,
    ) -> Result<Option<Measured>, Stop> {
        let take = &self.bench.data.takes[window.take];
        let mut frames: Vec<Frame> = Vec::new();
        for leg in 0..legs {
            let first = window.first + leg * (WINDOW - 1);
            let seed = seed.child("leg", leg as u64);
            let Some(made) = self.bench.make(maker, take, first, seed, self.ticker)? else { return Ok(None) };
            // A leg's first frame is the last one's.
            frames.extend(made.into_iter().skip(usize::from(leg > 0)));
        }
        let geometry = &self.rooms[&window.take];
        let planted = planted_feet(self.bench.body, &[0.0; BETAS], &frames, 0.0);
        self.optimise(optimised, geometry, &planted, &mut frames)?;
        let truth = &take.frames[window.first..window.first + frames.len()];
        let clip = clip_of(self.bench.body, frames, planted, truth);
        let ticker = self.ticker;
        let step = |_: usize, _: usize| match ticker.check() {
            Ok(()) => ControlFlow::Continue(()),
            Err(_) => ControlFlow::Break(()),
        };
        let report =
            inspect_motion(&geometry.field, self.bench.body, &clip, &step).map_err(|_| Stop::Cancelled)?;
        Ok(Some(Measured {
            errors: MotionErrors::of(self.bench.body, &clip.betas, &clip.frames, truth),
            neighbour_v2v_cm: self.neighbours_cm(&clip.frames, truth),
            metrics: report.metrics,
        }))
    }

    fn optimise(
        &self,
        how: Optimised,
        geometry: &RoomGeometry,
        planted: &[[bool; 2]],
        frames: &mut [Frame],
    ) -> Result<(), Stop> {
        let preset = match how {
            Optimised::No => return Ok(()),
            Optimised::Paper => SequencePreset::Paper,
            Optimised::Ours => SequencePreset::Ours,
        };
        let family = |rest: Rest| match rest {
            Rest::Seat(_) => Some(PoseFamily::SitChair),
            Rest::Bed(_) => Some(PoseFamily::LieUp),
            Rest::None => None,
        };
        let rests: Vec<Option<PoseFamily>> =
            rests_of(self.bench.body, frames).into_iter().map(family).collect();
        let task = SequenceTask { betas: &[0.0; BETAS], planted, rests: &rests, pinned: [1, 1] };
        let around = self.fitter.surroundings(geometry, frames);
        let config = SequenceConfig::from(preset);
        self.fitter.optimise(&around, &task, frames, &config, self.ticker, &mut |_| ())?;
        Ok(())
    }

    /// LTM §4.3: between the given first and last body and the frames beside them.
    fn neighbours_cm(&self, frames: &[Frame], truth: &[Frame]) -> f32 {
        let last = frames.len() - 1;
        let mut workspace = Workspace::default();
        let mut skin = |frame: &Frame| {
            let all = self.bench.body.all_vertices();
            self.bench.body.forward_posed(&frame.params(&[0.0; BETAS]), &frame.pose, all, &mut workspace);
            workspace.vertices().to_vec()
        };
        let (first, second) = (skin(&truth[0]), skin(&frames[1]));
        let (before, end) = (skin(&frames[last - 1]), skin(&truth[last]));
        0.05 * (mean_distance_mm(&first, &second) + mean_distance_mm(&before, &end))
    }
}

/// The motion with the captured bodies as its sub-goals, one every two seconds: whoever is upright there has a facing.
fn clip_of(body: &Body, frames: Vec<Frame>, planted: Vec<[bool; 2]>, truth: &[Frame]) -> Clip {
    let bounds: Vec<usize> = (0..frames.len()).step_by(WINDOW - 1).collect();
    let facing = |frame: &Frame| {
        let front = frame.rotation * Vec3::Z;
        let upright = (frame.rotation * Vec3::Y).y > std::f32::consts::FRAC_1_SQRT_2;
        upright.then(|| facing_of(Vec2::new(front.x, front.z)))
    };
    let goal = |(id, at): (usize, &usize)| SubGoal {
        id: SubGoalId(id as u32),
        at: (truth[*at].translation + body.model.joint_template[PELVIS]).with_y(0.0),
        facing: facing(&truth[*at]),
        pose: GoalPose::Any,
        stay_s: 0.0,
        planned: false,
        locked: false,
        body: Some(truth[*at].clone()),
    };
    let leg = |(i, pair): (usize, &[usize])| Leg {
        from: SubGoalId(i as u32),
        to: SubGoalId(i as u32 + 1),
        first: pair[0],
        last: pair[1],
        key: 0,
    };
    Clip {
        goals: bounds.iter().enumerate().map(goal).collect(),
        legs: bounds.windows(2).enumerate().map(leg).collect(),
        frames,
        planted,
        fps: CLIP_FPS,
        ..Clip::default()
    }
}
