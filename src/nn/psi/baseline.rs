//! The network of Li et al. 2019 ("Putting Humans in a Scene") as PSI §4.1.2 modifies it: a *where* module
//! for the translation; a *what* module that chooses one of K pose classes and deforms its centre; and a
//! discriminator that sees how the body's projected vertices lie before and behind the scene's depth.
//!
//! Their weights and code are not public; layer widths follow S2's so that both have like capacity.

use burn::tensor::activation::{leaky_relu, softmax};
use burn::tensor::{Device, Tensor};

use super::config::{GLOBAL, LOCAL, PsiConfig};
use super::input::SceneTensors;
use super::network::Reconstruction;
use super::trunk::SceneEncoder;
use crate::nn::graph::{Graph, numbers, tensor};
use crate::nn::layers::{LEAKY_SLOPE, Linear};
use crate::nn::params::{Declaration, Init, ParamId, Params, Role};
use crate::nn::vae::{Posterior, PosteriorHead};

/// Numbers of the pose code, and where it starts in the local part (after R 6 and betas 10).
pub const POSE_CODE: usize = 32;
/// Where the pose code starts in the local part.
const POSE_START: usize = 16;

/// Where and what.
#[derive(Clone, Debug)]
pub(super) struct Baseline {
    where_to: Where,
    what: What,
    centres: ParamId,
    latent: usize,
    classes: usize,
}

#[derive(Clone, Debug)]
struct Where {
    scene: SceneEncoder,
    lift: Linear,
    encoder: Linear,
    posterior: PosteriorHead,
    decoder: Linear,
    out: Linear,
}

#[derive(Clone, Debug)]
struct What {
    scene: SceneEncoder,
    place: Linear,
    classifier: Linear,
    logits: Linear,
    lift: Linear,
    encoder: Linear,
    posterior: PosteriorHead,
    decoder: [Linear; 2],
    out: Linear,
}

impl Baseline {
    pub fn declare(d: &mut Declaration, config: &PsiConfig) -> Self {
        let (lift, latent, classes) = (config.lift, config.latent, config.pose_classes);
        let where_to = Where {
            scene: SceneEncoder::declare(d, "where.scene", config, config.head_channels),
            lift: Linear::declare(d, "where.translation", GLOBAL, lift),
            encoder: Linear::declare(d, "where.encoder", 2 * lift, lift),
            posterior: PosteriorHead::declare(d, "where.posterior", lift, latent),
            decoder: Linear::declare(d, "where.decoder", lift + latent, lift),
            out: Linear::declare(d, "where.out", lift, GLOBAL),
        };
        let what = What {
            scene: SceneEncoder::declare(d, "what.scene", config, config.head_channels),
            place: Linear::declare(d, "what.translation", GLOBAL, lift),
            classifier: Linear::declare(d, "what.classifier", 2 * lift, lift),
            logits: Linear::declare(d, "what.logits", lift, classes),
            lift: Linear::declare(d, "what.body", LOCAL, lift),
            encoder: Linear::declare(d, "what.encoder", 3 * lift + classes, lift),
            posterior: PosteriorHead::declare(d, "what.posterior", lift, latent),
            decoder: [
                Linear::declare(d, "what.decoder.0", 2 * lift + latent + classes, 2 * lift),
                Linear::declare(d, "what.decoder.1", 2 * lift, lift),
            ],
            out: Linear::declare(d, "what.out", lift, LOCAL),
        };
        let centres = d.add("pose_centres", &[classes, POSE_CODE], Init::Constant(0.0), Role::Running);
        Self { where_to, what, centres, latent, classes }
    }

    /// Sets the middle of each pose class, `classes * 32` numbers.
    pub fn set_centres(&self, params: &mut Params, centres: Vec<f32>) {
        params.replace(self.centres, centres);
    }

    pub fn centres<'a>(&self, params: &'a Params) -> &'a [f32] {
        &params.entry(self.centres).values
    }

    pub fn encode_scene(&self, g: &Graph, scenes: &SceneTensors) -> Vec<Tensor<2>> {
        vec![self.where_to.scene.forward(g, scenes), self.what.scene.forward(g, scenes)]
    }

    /// The two modules learn side by side: *what* is given the true place, as in Li et al.
    pub fn reconstruct(
        &self,
        g: &Graph,
        features: &[Tensor<2>],
        bodies: Tensor<2>,
        noise: Tensor<2>,
    ) -> Reconstruction {
        let (global, local) = (bodies.clone().narrow(1, 0, GLOBAL), bodies.narrow(1, GLOBAL, LOCAL));
        let class = one_hot(&self.nearest(g, local.clone()), self.classes, g.device());
        let where_to = self.where_to.posterior(g, &features[0], global.clone());
        let place =
            self.where_to.decode(g, &features[0], where_to.sample(noise.clone().narrow(1, 0, self.latent)));
        let context = self.what.context(g, &features[1], global);
        let class_logits = self.what.classify(g, context.clone());
        let how = self.what.posterior(g, context.clone(), class.clone(), local);
        let code = how.sample(noise.narrow(1, self.latent, self.latent));
        let local = self.deform(g, context, class.clone(), code);
        Reconstruction {
            body: Tensor::cat(vec![place, local], 1),
            posteriors: vec![where_to, how],
            class_logits: Some((class_logits, class)),
        }
    }

    pub fn decode(&self, g: &Graph, features: &[Tensor<2>], codes: Tensor<2>) -> Tensor<2> {
        let global = self.where_to.decode(g, &features[0], codes.clone().narrow(1, 0, self.latent));
        let context = self.what.context(g, &features[1], global.clone());
        let shares = numbers(&softmax(self.what.classify(g, context.clone()), 1));
        let choice = numbers(&codes.clone().narrow(1, 2 * self.latent, 1));
        let classes: Vec<usize> = shares
            .chunks(self.classes)
            .zip(choice)
            .map(|(shares, normal)| choose(shares, normal_to_share(normal)))
            .collect();
        let class = one_hot(&classes, self.classes, g.device());
        let local = self.deform(g, context, class, codes.narrow(1, self.latent, self.latent));
        Tensor::cat(vec![global, local], 1)
    }

    /// The class whose centre is nearest to each body's pose code.
    fn nearest(&self, g: &Graph, local: Tensor<2>) -> Vec<usize> {
        let centres = numbers(&g.param::<2>(self.centres));
        let codes = numbers(&local.narrow(1, POSE_START, POSE_CODE));
        codes.chunks(POSE_CODE).map(|code| nearest_centre(&centres, code)).collect()
    }

    /// The class's centre plus what the network changes.
    fn deform(&self, g: &Graph, context: Tensor<2>, class: Tensor<2>, code: Tensor<2>) -> Tensor<2> {
        let centre = class.clone().matmul(g.param::<2>(self.centres));
        let change = self.what.decode(g, context, class, code);
        let before = change.clone().narrow(1, 0, POSE_START);
        let pose = change.clone().narrow(1, POSE_START, POSE_CODE) + centre;
        let after = change.narrow(1, POSE_START + POSE_CODE, LOCAL - POSE_START - POSE_CODE);
        Tensor::cat(vec![before, pose, after], 1)
    }
}

impl Where {
    fn posterior(&self, g: &Graph, scene: &Tensor<2>, global: Tensor<2>) -> Posterior {
        let lifted = Tensor::cat(vec![scene.clone(), self.lift.forward(g, global)], 1);
        self.posterior.forward(g, leaky_relu(self.encoder.forward(g, lifted), LEAKY_SLOPE))
    }

    fn decode(&self, g: &Graph, scene: &Tensor<2>, code: Tensor<2>) -> Tensor<2> {
        let lifted = self.decoder.forward(g, Tensor::cat(vec![code, scene.clone()], 1));
        self.out.forward(g, leaky_relu(lifted, LEAKY_SLOPE))
    }
}

impl What {
    fn context(&self, g: &Graph, scene: &Tensor<2>, global: Tensor<2>) -> Tensor<2> {
        Tensor::cat(vec![scene.clone(), self.place.forward(g, global)], 1)
    }

    fn classify(&self, g: &Graph, context: Tensor<2>) -> Tensor<2> {
        self.logits.forward(g, leaky_relu(self.classifier.forward(g, context), LEAKY_SLOPE))
    }

    fn posterior(&self, g: &Graph, context: Tensor<2>, class: Tensor<2>, local: Tensor<2>) -> Posterior {
        let lifted = Tensor::cat(vec![context, class, self.lift.forward(g, local)], 1);
        self.posterior.forward(g, leaky_relu(self.encoder.forward(g, lifted), LEAKY_SLOPE))
    }

    fn decode(&self, g: &Graph, context: Tensor<2>, class: Tensor<2>, code: Tensor<2>) -> Tensor<2> {
        let lifted = Tensor::cat(vec![code, context, class], 1);
        let deep = self.decoder.iter().fold(lifted, |x, fc| leaky_relu(fc.forward(g, x), LEAKY_SLOPE));
        self.out.forward(g, deep)
    }
}

/// The index of the centre nearest to `code`; centres stand one after another.
pub fn nearest_centre(centres: &[f32], code: &[f32]) -> usize {
    let squared = |centre: &[f32]| centre.iter().zip(code).map(|(a, b)| (a - b) * (a - b)).sum::<f32>();
    let all = centres.chunks(code.len()).map(squared).enumerate();
    all.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(index, _)| index)
}

fn one_hot(classes: &[usize], count: usize, device: &Device) -> Tensor<2> {
    let mut values = vec![0.0; classes.len() * count];
    classes.iter().enumerate().for_each(|(row, class)| values[row * count + class] = 1.0);
    tensor(values, [classes.len(), count], device)
}

/// The class in which `share` of the whole falls.
fn choose(shares: &[f32], share: f32) -> usize {
    let mut sum = 0.0;
    let inside = shares.iter().position(|s| {
        sum += s;
        share < sum
    });
    inside.unwrap_or(shares.len() - 1)
}

/// The share of a standard normal below `x` (logistic approximation of Bowling et al. 2009, within 1.4e-4).
fn normal_to_share(x: f32) -> f32 {
    1.0 / (1.0 + (-(0.07056 * x * x * x + 1.5976 * x)).exp())
}

/// Which vertices the discriminator sees, and its layers: for every vertex where it projects to, how deep it
/// lies, and how far the scene is behind it there.
#[derive(Clone, Copy, Debug)]
pub struct Discriminator {
    layers: [Linear; 2],
    out: Linear,
}

/// Numbers of one vertex: normalised u and v, depth over the largest depth, scene depth less vertex depth in
/// metres (clipped to [`GAP_M`]).
pub const VERTEX_FEATURES: usize = 4;
/// Vertices that the discriminator sees.
pub const DISCRIMINATOR_VERTICES: usize = 128;
/// A scene farther than this before or behind a vertex says nothing more.
pub const GAP_M: f32 = 1.0;

impl Discriminator {
    /// A discriminator with its own numbers.
    pub fn declare(seed: u64) -> (Self, Params) {
        let mut d = Declaration::new(seed);
        let width = 128;
        let layers = [
            Linear::declare(&mut d, "discriminator.0", DISCRIMINATOR_VERTICES * VERTEX_FEATURES, width),
            Linear::declare(&mut d, "discriminator.1", width, width),
        ];
        let out = Linear::declare(&mut d, "discriminator.out", width, 1);
        (Self { layers, out }, d.finish())
    }

    /// `[batch, vertices * 4]` to `[batch, 1]`: large for real bodies.
    pub fn forward(&self, g: &Graph, vertices: Tensor<2>) -> Tensor<2> {
        let deep = self.layers.iter().fold(vertices, |x, fc| leaky_relu(fc.forward(g, x), 0.2));
        self.out.forward(g, deep)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_class_is_chosen_with_its_share() {
        let shares = [0.2, 0.5, 0.3];
        assert_eq!([0.1, 0.3, 0.69, 0.71, 1.0].map(|s| choose(&shares, s)), [0, 1, 1, 2, 2]);
        assert!((normal_to_share(0.0) - 0.5).abs() < 1e-6);
        assert!(
            (normal_to_share(1.0) - 0.8413).abs() < 1e-3 && (normal_to_share(-1.645) - 0.05).abs() < 1e-3
        );
    }

    #[test]
    fn a_code_belongs_to_the_nearest_centre() {
        assert_eq!(nearest_centre(&[0.0, 0.0, 3.0, 3.0, -1.0, 2.0], &[2.0, 2.5]), 1);
    }
}
