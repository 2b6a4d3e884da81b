//! Bodies from what a camera sees, by the networks of PSI: samples a code, decodes, puts back into the world.

use std::sync::OnceLock;

use rand_distr::{Distribution as _, StandardNormal};

use super::sensor::SceneImage;
use crate::assets::{Weights, WeightsError};
use crate::body::Body;
use crate::job::{Cancelled, Seed, Ticker};
use crate::nn::psi::{PsiMethod, PsiSampler, SceneInput, ValidArea};
use crate::scene::{BodyParams, POSE};

/// Networks that ship with the program.
const BUNDLED: &[(LearnedMethod, &[u8])] = &[
    (S1, include_bytes!("../../assets/networks/s1.safetensors")),
    (S1_HS, include_bytes!("../../assets/networks/s1_hs.safetensors")),
    (S2, include_bytes!("../../assets/networks/s2.safetensors")),
    (S2_HS, include_bytes!("../../assets/networks/s2_hs.safetensors")),
    (BASELINE, include_bytes!("../../assets/networks/baseline.safetensors")),
];

const S1: LearnedMethod = LearnedMethod { network: PsiMethod::S1, scene_loss: false };
const S1_HS: LearnedMethod = LearnedMethod { network: PsiMethod::S1, scene_loss: true };
const S2: LearnedMethod = LearnedMethod { network: PsiMethod::S2, scene_loss: false };
const S2_HS: LearnedMethod = LearnedMethod { network: PsiMethod::S2, scene_loss: true };
const BASELINE: LearnedMethod = LearnedMethod { network: PsiMethod::Baseline, scene_loss: false };

/// A trained network: which, and whether the scene loss L_HS joined in its training (PSI §3.2.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct LearnedMethod {
    /// The network.
    pub network: PsiMethod,
    /// Trained with L_HS in its last quarter.
    pub scene_loss: bool,
}

/// Why a learned sampler is not there.
#[derive(Debug, thiserror::Error)]
pub enum LearnedError {
    /// No weights came with this build.
    #[error(
        "no weights of `{0}` come with this build; train them with `inhabit train psi --method {0}` and give the file with --weights"
    )]
    NotBundled(String),
    /// The weights can't be used.
    #[error(transparent)]
    Weights(#[from] WeightsError),
}

impl LearnedMethod {
    /// S1, S2 and the baseline, then S1 and S2 with the scene loss.
    pub const ALL: [Self; 5] = [S1, S2, BASELINE, S1_HS, S2_HS];

    /// The one that the program takes when a user names only the network: with L_HS where there is one, for its samples
    /// sink far less into the validation rooms (cards and tables in `assets/networks`).
    pub fn best_of(network: PsiMethod) -> Self {
        Self { network, scene_loss: network != PsiMethod::Baseline }
    }

    /// The name of its weight file: `s1`, `s1_hs`, `s2`, `s2_hs`, `baseline`.
    pub fn label(self) -> String {
        let suffix = if self.scene_loss { "_hs" } else { "" };
        format!("{}{suffix}", self.network.label())
    }
}

/// A network of PSI, ready to put people into rooms. Shared by threads, keeps nothing between calls.
pub struct LearnedSampler {
    sampler: PsiSampler,
}

impl LearnedSampler {
    /// The network that ships with the program; read at the first call.
    ///
    /// # Errors
    /// [`LearnedError::NotBundled`] when this build has none.
    pub fn bundled(method: LearnedMethod) -> Result<&'static Self, LearnedError> {
        static LOADED: OnceLock<Vec<OnceLock<LearnedSampler>>> = OnceLock::new();
        let at = BUNDLED.iter().position(|(of, _)| *of == method);
        let at = at.ok_or_else(|| LearnedError::NotBundled(method.label()))?;
        let slots = LOADED.get_or_init(|| BUNDLED.iter().map(|_| OnceLock::new()).collect());
        if let Some(loaded) = slots[at].get() {
            return Ok(loaded);
        }
        let name = format!("bundled {}", method.label());
        let fresh = Self::from_weights(&Weights::from_bytes(&name, BUNDLED[at].1)?)?;
        Ok(slots[at].get_or_init(|| fresh))
    }

    /// The weight file of a bundled network: its notes tell how it was trained.
    pub fn bundled_file(method: LearnedMethod) -> Option<&'static [u8]> {
        BUNDLED.iter().find(|(of, _)| *of == method).map(|(_, file)| *file)
    }

    /// Whether this build has the network.
    pub fn is_bundled(method: LearnedMethod) -> bool {
        BUNDLED.iter().any(|(of, _)| *of == method)
    }

    /// The network in a weight file of `inhabit train psi`.
    ///
    /// # Errors
    /// [`WeightsError`] when the file holds another network.
    pub fn from_weights(weights: &Weights) -> Result<Self, WeightsError> {
        Ok(Self { sampler: PsiSampler::from_weights(weights)? })
    }

    /// The network itself, for evaluations that encode bodies.
    pub fn network(&self) -> &PsiSampler {
        &self.sampler
    }

    /// `count` bodies for what the image shows, world frame, in the order of their seeds; none is fitted to the
    /// room yet. The same seed gives the same bytes. `preview` gets the first bodies before all are there.
    ///
    /// # Errors
    /// [`Cancelled`] once the user cancelled.
    pub fn sample(
        &self,
        image: &SceneImage,
        count: usize,
        seed: Seed,
        ticker: &Ticker,
        preview: &mut dyn FnMut(&[BodyParams]),
    ) -> Result<Vec<BodyParams>, Cancelled> {
        let scene = scene_input(image);
        let mut bodies = Vec::with_capacity(count);
        while bodies.len() < count {
            ticker.step(bodies.len(), count)?;
            let first = bodies.len();
            let batch = BATCH.min(count - first);
            bodies.extend(self.decode(image, &scene, first, batch, seed));
            preview(&bodies);
        }
        ticker.step(count, count)?;
        Ok(bodies)
    }

    /// The mean pose code of `count` samples: what people do in this scene, θ_b^s of PSI §4.2. NaN never:
    /// zero for no samples.
    pub fn mean_pose_code(&self, image: &SceneImage, count: usize, seed: Seed) -> [f32; POSE] {
        let scene = scene_input(image);
        let mut mean = [0.0; POSE];
        for first in (0..count).step_by(BATCH) {
            let batch = BATCH.min(count - first);
            for body in self.decode(image, &scene, first, batch, seed) {
                mean.iter_mut().zip(body.pose).for_each(|(m, p)| *m += p / count as f32);
            }
        }
        mean
    }

    fn decode(
        &self,
        image: &SceneImage,
        scene: &SceneInput,
        first: usize,
        count: usize,
        seed: Seed,
    ) -> Vec<BodyParams> {
        let noise = self.sampler.config().noise();
        let mut codes = Vec::with_capacity(count * noise);
        for index in first..first + count {
            let mut rng = seed.child("sample", index as u64).rng();
            codes.extend((0..noise).map(|_| -> f32 { StandardNormal.sample(&mut rng) }));
        }
        let model = &Body::bundled().model;
        let decoded = self.sampler.decode(scene, &codes);
        let in_world = |x| image.view.body_in_world(&BodyParams::from_vector(x), model);
        decoded.iter().map(in_world).collect()
    }
}

/// Bodies decoded together: a cancel acts between batches, and a body does not depend on how many are asked for.
const BATCH: usize = 25;

/// The image as the networks take it.
pub fn scene_input(image: &SceneImage) -> SceneInput {
    let [left, top, width, height] =
        [image.valid.left, image.valid.top, image.valid.width, image.valid.height].map(|n| n as usize);
    SceneInput {
        depth_m: image.depth_m.clone(),
        labels: image.labels.clone(),
        valid: ValidArea { left, top, width, height },
        max_depth_m: image.max_depth_m,
        focal: image.projection().scale,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::sensor::{Intrinsics, LABELS, SIDE, Valid, View, category_of};
    use crate::nn::psi::{CLASSES, MPCAT40, PsiConfig, PsiNetwork};
    use glam::Vec3;

    fn image() -> SceneImage {
        let eye = Vec3::new(1.0, 1.8, 2.0);
        let (view, valid) = Valid::of(&View::look_at(eye, Vec3::new(0.0, 0.5, 0.0), Intrinsics::PROX_E));
        let depth = (0..SIDE * SIDE).map(|at| 2.0 + (at % SIDE) as f32 * 0.01).collect();
        SceneImage::new(view, valid, depth, vec![2; SIDE * SIDE])
    }

    fn sampler(method: PsiMethod) -> LearnedSampler {
        let (network, params) = PsiNetwork::declare(&PsiConfig::mini(method), 3);
        LearnedSampler { sampler: PsiSampler::new(network, &params) }
    }

    fn sample(sampler: &LearnedSampler, count: usize, seed: u64) -> Vec<BodyParams> {
        let ticker = Ticker::silent();
        sampler.sample(&image(), count, Seed::root(seed), &ticker, &mut |_| ()).expect("not cancelled")
    }

    #[test]
    fn labels_mean_the_same_to_sensors_and_networks() {
        assert_eq!(LABELS, CLASSES);
        for label in 1..LABELS as u8 {
            let category = category_of(label).expect("a category");
            assert_eq!(MPCAT40[usize::from(label)], category.mpcat40(), "{category:?}");
        }
    }

    #[test]
    fn the_same_seed_gives_the_same_bodies_whatever_the_number_asked_for_and_of_threads() {
        let sampler = sampler(PsiMethod::S1);
        let bodies = sample(&sampler, 60, 1);
        assert_eq!(bodies.len(), 60);
        assert_eq!(bodies[..50], sample(&sampler, 50, 1));
        assert_ne!(bodies, sample(&sampler, 60, 2));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
        assert_eq!(bodies, pool.install(|| sample(&sampler, 60, 1)));
    }

    #[test]
    fn samples_lie_where_the_image_says_in_the_world() {
        let image = image();
        for body in sample(&sampler(PsiMethod::S2), 8, 4) {
            let in_camera = image.view.body_in_camera(&body, &Body::bundled().model);
            let back = image.projection().normalize(in_camera.translation);
            assert!(back.is_finite() && body.rotation6.iter().all(|r| r.abs() <= 1.0), "{body:?}");
        }
    }

    #[test]
    fn the_mean_pose_code_is_the_mean_of_the_samples() {
        let sampler = sampler(PsiMethod::Baseline);
        let bodies = sample(&sampler, 30, 9);
        let mean = sampler.mean_pose_code(&image(), 30, Seed::root(9));
        let first: f32 = bodies.iter().map(|b| b.pose[0]).sum::<f32>() / 30.0;
        assert!((mean[0] - first).abs() < 1e-5, "{} {first}", mean[0]);
    }

    #[test]
    fn a_network_that_does_not_ship_says_how_to_train_it() {
        for method in LearnedMethod::ALL {
            match LearnedSampler::bundled(method) {
                Ok(_) => assert!(LearnedSampler::is_bundled(method)),
                Err(error) => assert!(error.to_string().contains("inhabit train psi"), "{error}"),
            }
        }
        let other = LearnedMethod { scene_loss: true, ..BASELINE };
        let error = LearnedSampler::bundled(other).err().expect("nobody trains it with the scene loss");
        assert!(error.to_string().contains("inhabit train psi"), "{error}");
    }

    #[test]
    fn every_network_that_ships_is_the_one_its_name_says_and_proposes_people_in_the_room() {
        for method in LearnedMethod::ALL {
            let sampler = LearnedSampler::bundled(method).expect("ships");
            assert_eq!(sampler.network().config().method, method.network);
            for body in sample(sampler, 20, 1) {
                let away = (body.translation - image().view.eye()).length();
                assert!((0.2..9.0).contains(&away), "{}: {away} m from the camera", method.label());
            }
        }
    }
}
