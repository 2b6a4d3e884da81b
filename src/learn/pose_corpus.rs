//! The poses that the prior learns from: frames of clips and draws of the program's own pose families.

use glam::Vec3;
use rand::RngExt as _;
use rand_distr::{Distribution as _, StandardNormal};

use crate::assets::PoseClip;
use crate::body::{BodyModel, BodyPose, FamilyHints, JointLimit, joint_limits, mirrored, sample_pose};
use crate::job::{Cancelled, Rng, Seed, Ticker};
use crate::motion::capture::is_calibration;
use crate::scene::PoseFamily;

/// What a corpus is made of.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PoseCorpusConfig {
    /// Poses drawn of each family for training; a tenth as many more are held out.
    pub samples_a_family: usize,
    /// Weight of all clips together, where each of the ten families weighs 1.
    pub weight_of_clips: f32,
    /// One clip of so many is held out of training, of every source that has as many.
    pub held_out_one_in: usize,
    /// Frames a second that are taken of a clip.
    pub frames_a_second: f32,
    /// Share of training poses that are varied.
    pub varied: f32,
    /// Standard deviation of that variation, radians a component.
    pub variation: f32,
}

impl Default for PoseCorpusConfig {
    fn default() -> Self {
        Self {
            samples_a_family: 6000,
            weight_of_clips: 6.0,
            held_out_one_in: 8,
            frames_a_second: 30.0,
            varied: 0.4,
            variation: 0.05,
        }
    }
}

/// Poses of one source.
#[derive(Clone, Debug)]
pub struct PoseGroup {
    /// Source or family.
    pub label: String,
    /// Share in training, before normalisation.
    pub weight: f32,
    /// Its poses.
    pub poses: Vec<BodyPose>,
}

/// Training poses by source, and held-out ones.
#[derive(Clone, Debug, Default)]
pub struct PoseCorpus {
    config: PoseCorpusConfig,
    /// What is trained on.
    pub train: Vec<PoseGroup>,
    /// Held-out clips, by name.
    pub held_out_clips: Vec<PoseGroup>,
    /// Held-out draws of each family.
    pub held_out_families: Vec<PoseGroup>,
    limits: Vec<JointLimit>,
}

impl PoseCorpus {
    /// Splits clips by clip, thins them, and draws the families.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn new(
        clips: &[PoseClip],
        model: &BodyModel,
        config: PoseCorpusConfig,
        seed: Seed,
        ticker: &Ticker,
    ) -> Result<Self, Cancelled> {
        let mut corpus = Self { config, limits: joint_limits().to_vec(), ..Self::default() };
        corpus.add_clips(clips, seed);
        ticker.stage("drawing pose families", PoseFamily::ALL.len())?;
        for (done, family) in PoseFamily::ALL.into_iter().enumerate() {
            let drawn = draw_family(model, family, &config, seed, ticker)?;
            let [train, held_out] =
                drawn.map(|poses| PoseGroup { label: family.label().into(), weight: 1.0, poses });
            corpus.train.push(train);
            corpus.held_out_families.push(held_out);
            ticker.step(done + 1, PoseFamily::ALL.len())?;
        }
        Ok(corpus)
    }

    fn add_clips(&mut self, clips: &[PoseClip], seed: Seed) {
        let source = |clip: &PoseClip| clip.name.split('/').next().unwrap_or_default().to_owned();
        let mut sources: Vec<String> = clips.iter().map(source).collect();
        sources.sort();
        sources.dedup();
        let first = self.train.len();
        for label in sources {
            let mut own: Vec<&PoseClip> = clips.iter().filter(|clip| source(clip) == label).collect();
            own.sort_by(|a, b| a.name.cmp(&b.name));
            shuffle(&mut own, &mut seed.child(&label, 0).rng());
            let held_out = own.len() / self.config.held_out_one_in;
            let (held_out, train) = own.split_at(held_out);
            for clip in held_out {
                let poses = self.thinned(clip);
                self.held_out_clips.push(PoseGroup { label: clip.name.clone(), weight: 1.0, poses });
            }
            let poses: Vec<BodyPose> = train.iter().flat_map(|clip| self.thinned(clip)).collect();
            // A source of ten times the frames is not ten times as telling.
            self.train.push(PoseGroup { label, weight: (poses.len() as f32).sqrt(), poses });
        }
        self.train.retain(|group| !group.poses.is_empty());
        let total: f32 = self.train[first..].iter().map(|group| group.weight).sum();
        let share = self.config.weight_of_clips / total.max(f32::MIN_POSITIVE);
        self.train[first..].iter_mut().for_each(|group| group.weight *= share);
    }

    /// Frames of a clip at the configured rate, without those of a calibration pose.
    fn thinned(&self, clip: &PoseClip) -> Vec<BodyPose> {
        let stride = (1.0 / (self.config.frames_a_second * clip.frame_seconds)).round().max(1.0);
        let frames = clip.frames.iter().step_by(stride as usize);
        let poses = frames.map(|frame| std::array::from_fn(|j| frame[j + 1]));
        poses.filter(|pose| !is_calibration(pose)).collect()
    }

    /// Number of training poses.
    pub fn len(&self) -> usize {
        self.train.iter().map(|group| group.poses.len()).sum()
    }

    /// Whether there is nothing to train on.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Draws a training pose: a group by weight, one of its poses, mirrored half of the time, often varied.
    pub fn draw(&self, rng: &mut Rng) -> BodyPose {
        let total: f32 = self.train.iter().map(|group| group.weight).sum();
        let mut left = rng.random_range(0.0..total);
        let chosen = self.train.iter().find(|group| {
            left -= group.weight;
            left <= 0.0
        });
        let group = chosen.unwrap_or(&self.train[self.train.len() - 1]);
        let mut pose = group.poses[rng.random_range(0..group.poses.len())];
        if rng.random::<bool>() {
            pose = mirrored(&pose);
        }
        if rng.random_range(0.0..1.0) < self.config.varied {
            self.vary(&mut pose, rng);
        }
        pose
    }

    fn vary(&self, pose: &mut BodyPose, rng: &mut Rng) {
        for (angle, limit) in pose.iter_mut().zip(&self.limits) {
            let before = limit.excess(*angle);
            let noise: [f32; 3] = std::array::from_fn(|_| StandardNormal.sample(rng));
            *angle += Vec3::from_array(noise) * self.config.variation;
            // Variation leads nobody farther beyond the limits than they were.
            let after = limit.excess(*angle);
            *angle -= after - after.clamp(before.min(Vec3::ZERO), before.max(Vec3::ZERO));
        }
    }
}

fn shuffle<T>(items: &mut [T], rng: &mut Rng) {
    for i in (1..items.len()).rev() {
        items.swap(i, rng.random_range(0..=i));
    }
}

fn draw_family(
    model: &BodyModel,
    family: PoseFamily,
    config: &PoseCorpusConfig,
    seed: Seed,
    ticker: &Ticker,
) -> Result<[Vec<BodyPose>; 2], Cancelled> {
    let mut sets = [Vec::new(), Vec::new()];
    let counts = [config.samples_a_family, config.samples_a_family.div_ceil(10)];
    for (which, (set, count)) in sets.iter_mut().zip(counts).enumerate() {
        let mut rng = seed.child(family.label(), which as u64).rng();
        for i in 0..count {
            if i % 64 == 0 {
                ticker.check()?;
            }
            let hints = random_hints(family, &mut rng);
            set.push(sample_pose(&model.joint_template, family, &mut rng, &hints).pose);
        }
    }
    Ok(sets)
}

/// The spread of places that people find, so that the space holds the poses of all of them.
fn random_hints(family: PoseFamily, rng: &mut Rng) -> FamilyHints {
    let mut maybe = |low: f32, high: f32, often: f32| {
        let (value, said) = (rng.random_range(low..high), rng.random_range(0.0..1.0) < often);
        said.then_some(value)
    };
    let seated = family.group() == "sit";
    let (low, high) = if family == PoseFamily::SitStool { (0.5, 0.8) } else { (0.32, 0.6) };
    FamilyHints {
        seat_height_m: maybe(low, high, 0.8),
        armrest_above_seat_m: maybe(0.15, 0.27, 0.25),
        table_height_m: maybe(0.65, 1.0, if seated { 0.0 } else { 0.3 })
            .or_else(|| maybe(0.66, 0.78, if seated { 0.2 } else { 0.0 })),
        ..FamilyHints::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::joints::{self, LEFT_SHOULDER};
    use crate::body::{Body, worst_excess};

    fn clip(name: &str, frames: usize, turn: f32) -> PoseClip {
        let mut frame = [Vec3::ZERO; crate::assets::CLIP_JOINTS];
        frame[LEFT_SHOULDER].z = turn;
        PoseClip {
            name: name.into(),
            frames: vec![frame; frames],
            pelvis_m: vec![Vec3::ZERO; frames],
            frame_seconds: 1.0 / 120.0,
        }
    }

    fn corpus(clips: &[PoseClip]) -> PoseCorpus {
        let config = PoseCorpusConfig { samples_a_family: 10, ..PoseCorpusConfig::default() };
        PoseCorpus::new(clips, &Body::bundled().model, config, Seed::root(1), &Ticker::silent())
            .expect("corpus")
    }

    #[test]
    fn clips_are_held_out_whole_and_thinned() {
        let clips: Vec<PoseClip> =
            (0..16).map(|i| clip(&format!("a/{i}"), 40, -1.0 - 0.01 * i as f32)).collect();
        let corpus = corpus(&clips);
        assert_eq!((corpus.held_out_clips.len(), corpus.train[0].poses.len()), (2, 14 * 10));
        for held_out in &corpus.held_out_clips {
            assert!(corpus.train[0].poses.iter().all(|pose| *pose != held_out.poses[0]));
        }
    }

    #[test]
    fn calibration_poses_are_left_out() {
        assert!(corpus(&[clip("a/1", 40, 0.0)]).train.iter().all(|group| group.label != "a"));
    }

    #[test]
    fn varied_poses_stay_possible_and_half_are_mirrored() {
        let corpus = corpus(&[]);
        let mut rng = Seed::root(2).rng();
        let worst = |pose: &BodyPose| worst_excess(pose).0;
        let before = corpus.train.iter().flat_map(|group| &group.poses).map(worst).fold(0.0, f32::max);
        for _ in 0..300 {
            let (excess, joint) = worst_excess(&corpus.draw(&mut rng));
            assert!(excess < before + 1e-4, "{} by {excess}, {before} unvaried", joints::NAMES[joint]);
        }
        let pose = corpus.train[0].poses[0];
        assert_eq!(mirrored(&mirrored(&pose)), pose);
    }
}
