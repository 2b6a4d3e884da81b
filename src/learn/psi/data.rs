use glam::{Affine3A, Mat3, Vec3};
use rand::RngExt as _;
use rayon::prelude::*;

use crate::assets::content_hash;
use crate::body::{Body, BodyModel, BodyPose};
use crate::generate::sensor::{Projection, SIDE};
use crate::job::Seed;
use crate::learn::corpus::{Corpus, CorpusPerson, CorpusView, Split};
use crate::learn::mirrored;
use crate::nn::psi::{BODY, CLIP_M, SceneInput, ValidArea};
use crate::scene::{BodyParams, HANDS, POSE};

/// A body nearer to the camera than this is behind or around it, in metres.
const NEAREST_M: f32 = 0.4;
/// Turns left into right in the camera's frame.
const FLIP: Mat3 = Mat3::from_cols(Vec3::NEG_X, Vec3::Y, Vec3::Z);

/// One person, and the pictures that show their place.
#[derive(Clone, Debug)]
pub struct PsiBody {
    /// The room's number.
    pub room: usize,
    /// The body, world frame.
    pub params: BodyParams,
    /// Pose code of the body's mirror image.
    pub mirrored_pose: [f32; POSE],
    /// Numbers of the pictures.
    pub views: Vec<usize>,
}

/// A corpus as the networks see it.
#[derive(Clone, Debug, Default)]
pub struct PsiData {
    /// What the corpus is, for weight files.
    pub id: String,
    /// Bodies to learn from.
    pub train: Vec<PsiBody>,
    /// Bodies of other rooms, to see how learning goes on.
    pub validation: Vec<PsiBody>,
    /// The pictures.
    pub views: Vec<CorpusView>,
}

/// One body in one picture, ready for the network.
#[derive(Clone, Debug)]
pub struct Item {
    /// The picture.
    pub scene: SceneInput,
    /// The body in the camera's frame, metres.
    pub body: [f32; BODY],
    /// Where the camera stands; with a reflection when the picture is mirrored.
    pub world_from_camera: Affine3A,
    /// The room's number.
    pub room: usize,
}

/// How an item is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Augment {
    /// Mirror half of them.
    pub mirror: bool,
    /// Deviation of depth noise, as a share of the depth.
    pub depth_noise: f32,
}

impl Augment {
    /// Nothing is changed.
    pub const NONE: Self = Self { mirror: false, depth_noise: 0.0 };
}

impl PsiBody {
    /// A person whose body pose is given as axis-angles; encodes it and its mirror image.
    pub fn new(room: usize, mut params: BodyParams, pose: &BodyPose, views: Vec<usize>) -> Self {
        let space = &Body::bundled().pose_space;
        params.pose = space.encode(pose);
        Self { room, params, mirrored_pose: space.encode(&mirrored(pose)), views }
    }
}

impl PsiData {
    /// Bodies and pictures of a corpus; rooms keep their numbers. Its test rooms are left out: nothing of them is
    /// ever seen in training.
    pub fn from_corpus(corpus: Corpus) -> Self {
        let text = corpus.manifest.to_ron().unwrap_or_default();
        let id = format!(
            "{}, seed {}, {:032x}",
            corpus.manifest.about,
            corpus.manifest.seed,
            content_hash(text.as_bytes())
        );
        let mut data = Self { id, ..Self::default() };
        for (room, of) in corpus.rooms.into_iter().enumerate().filter(|(_, r)| r.split != Split::Test) {
            let first = data.views.len();
            let of_person = |person: usize| {
                let theirs = of.views.iter().enumerate().filter(|(_, v)| v.body == person);
                theirs.map(|(i, _)| first + i).collect::<Vec<usize>>()
            };
            let encode = |(i, person): (usize, &CorpusPerson)| {
                let params = BodyParams {
                    translation: person.translation,
                    rotation6: person.rotation6,
                    betas: person.betas,
                    pose: [0.0; POSE],
                    hands: person.hands,
                };
                PsiBody::new(room, params, &person.body_pose, of_person(i))
            };
            let bodies: Vec<PsiBody> = of.people.par_iter().enumerate().map(encode).collect();
            match of.split {
                Split::Train => data.train.extend(bodies),
                _ => data.validation.extend(bodies),
            }
            data.views.extend(of.views);
        }
        data
    }

    /// Leaves out pictures in which a body does not lie between camera and largest depth (the published code
    /// drops such batches), and bodies that no picture is left of. Returns how many bodies were left out.
    pub fn drop_unseen(&mut self) -> usize {
        let views = &self.views;
        let mut dropped = 0;
        for bodies in [&mut self.train, &mut self.validation] {
            let before = bodies.len();
            bodies.par_iter_mut().for_each(|body| {
                let params = body.params.clone();
                body.views.retain(|v| is_seen(&views[*v], &params, &Body::bundled().model));
            });
            bodies.retain(|body| !body.views.is_empty());
            dropped += before - bodies.len();
        }
        dropped
    }

    /// Draws one of a body's pictures.
    pub fn draw(&self, body: &PsiBody, augment: Augment, seed: Seed) -> Item {
        let mut rng = seed.rng();
        let view = &self.views[body.views[rng.random_range(0..body.views.len())]];
        let mirrored = augment.mirror && rng.random_bool(0.5);
        let mut item = self.item(body, view, mirrored);
        if augment.depth_noise > 0.0 {
            // An even distribution of this half-width has the wanted deviation.
            let half = augment.depth_noise * 3f32.sqrt();
            item.scene.depth_m.iter_mut().for_each(|d| *d *= 1.0 + rng.random_range(-half..=half));
        }
        item
    }

    fn item(&self, body: &PsiBody, view: &CorpusView, mirrored: bool) -> Item {
        let model = &Body::bundled().model;
        let in_camera = view.view.body_in_camera(&body.params, model);
        let (params, world_from_camera) = if mirrored {
            let flip = Affine3A::from_mat3(FLIP);
            (flipped(&in_camera, body.mirrored_pose, model), view.view.world_from_camera * flip)
        } else {
            (in_camera, view.view.world_from_camera)
        };
        let scene = scene_input(view, mirrored);
        Item { scene, body: params.to_vector(), world_from_camera, room: body.room }
    }
}

/// The body's mirror image in the camera's frame.
fn flipped(body: &BodyParams, pose: [f32; POSE], model: &BodyModel) -> BodyParams {
    let rest_pelvis = model.rest_joints(&body.betas)[0];
    let mut out = body.clone();
    out.translation = FLIP * (rest_pelvis + body.translation) - rest_pelvis;
    out.set_rotation(&(FLIP * body.rotation() * FLIP));
    out.pose = pose;
    out.hands[..HANDS / 2].copy_from_slice(&body.hands[HANDS / 2..]);
    out.hands[HANDS / 2..].copy_from_slice(&body.hands[..HANDS / 2]);
    out
}

fn is_seen(view: &CorpusView, params: &BodyParams, model: &BodyModel) -> bool {
    let deepest_m = max_depth_m(&view.depth_mm);
    let z = view.view.body_in_camera(params, model).translation.z;
    (NEAREST_M..=deepest_m).contains(&z)
}

fn max_depth_m(depth_mm: &[u16]) -> f32 {
    let deepest = f32::from(depth_mm.iter().copied().max().unwrap_or(0)) * 1e-3;
    if deepest > 0.0 { deepest.min(CLIP_M) } else { CLIP_M }
}

/// The picture as the network takes it, mirrored if asked for.
pub fn scene_input(view: &CorpusView, mirrored: bool) -> SceneInput {
    let from = |at: usize| if mirrored { at - at % SIDE + SIDE - 1 - at % SIDE } else { at };
    let max_depth_m = max_depth_m(&view.depth_mm);
    let depth = |at: usize| (f32::from(view.depth_mm[from(at)]) * 1e-3).min(CLIP_M);
    let intrinsics = &view.view.intrinsics;
    let [left, top, width, height] =
        [view.valid.left, view.valid.top, view.valid.width, view.valid.height].map(|n| n as usize);
    let left = if mirrored { SIDE - left - width } else { left };
    SceneInput {
        depth_m: (0..SIDE * SIDE).map(depth).collect(),
        labels: (0..SIDE * SIDE).map(|at| view.labels[from(at)]).collect(),
        valid: ValidArea { left, top, width, height },
        max_depth_m,
        focal: Projection::new(intrinsics, max_depth_m).scale,
    }
}
