use glam::{Affine3A, Mat3, Vec3};
use rand::RngExt as _;
use rayon::prelude::*;

use crate::assets::content_hash;
use crate::body::joints::BODY_JOINTS;
use crate::body::{Body, BodyModel, BodyPose, mirrored};
use crate::generate::sensor::{Projection, SIDE, Valid, View};
use crate::job::{Cancelled, Rng, Seed, Ticker};
use crate::learn::corpus::{Corpus, CorpusPerson, CorpusView, Split};
use crate::nn::psi::{BODY, CLIP_M, SceneInput, ValidArea};
use crate::scene::{BodyParams, HANDS, POSE};

/// A body nearer to the camera than this is behind or around it, in metres.
const NEAREST_M: f32 = 0.4;
/// A picture goes with a body when it would show this share of its joints.
const SEEN_SHARE: f32 = 0.6;
/// Joints lie this far behind the surface that carries the body, in metres: flesh and what gives way.
const COVER_M: f32 = 0.12;
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
    /// Largest turn of the camera to either side and up or down, degrees. Virtual cameras aim at the body, so
    /// that it would always be in the middle of the picture.
    pub turn_deg: [f32; 2],
    /// Deviation of depth noise, as a share of the depth.
    pub depth_noise: f32,
}

impl Augment {
    /// Nothing is changed.
    pub const NONE: Self = Self { mirror: false, turn_deg: [0.0; 2], depth_noise: 0.0 };
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
    /// Bodies and pictures of a corpus; rooms keep their numbers. A body goes with every picture of its room that
    /// would show it, not only with those that aim at it: one picture stands for many bodies. Its test rooms are left out: nothing of them is
    /// ever seen in training.
    ///
    /// # Errors
    /// [`Cancelled`] once the user cancelled.
    pub fn from_corpus(corpus: Corpus, ticker: &Ticker) -> Result<Self, Cancelled> {
        ticker.stage("encoding people", corpus.rooms.iter().map(|room| room.people.len()).sum())?;
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
            let pictures: Vec<Picture> = of.views.iter().map(Picture::of).collect();
            let encode = |(i, person): (usize, &CorpusPerson)| {
                ticker.advance()?;
                let params = BodyParams {
                    translation: person.translation,
                    rotation6: person.rotation6,
                    betas: person.betas,
                    pose: [0.0; POSE],
                    hands: person.hands,
                };
                let mut body = PsiBody::new(room, params, &person.body_pose, Vec::new());
                let joints = joints_of(&body.params);
                let shows =
                    |v: usize| of.views[v].body == i || pictures[v].visible_share(&joints) >= SEEN_SHARE;
                body.views = (0..pictures.len()).filter(|v| shows(*v)).map(|v| first + v).collect();
                Ok(body)
            };
            let bodies: Result<Vec<PsiBody>, Cancelled> =
                of.people.par_iter().enumerate().map(encode).collect();
            let bodies = bodies?;
            match of.split {
                Split::Train => data.train.extend(bodies),
                _ => data.validation.extend(bodies),
            }
            data.views.extend(of.views);
        }
        Ok(data)
    }

    /// Leaves out pictures in which a body's pelvis does not lie between camera and largest depth (the published code
    /// drops such batches), and bodies that no picture is left of. Returns how many bodies were left out.
    pub fn drop_unseen(&mut self) -> usize {
        let views = &self.views;
        let mut dropped = 0;
        for bodies in [&mut self.train, &mut self.validation] {
            let before = bodies.len();
            bodies.par_iter_mut().for_each(|body| {
                let params = body.params.clone();
                body.views.retain(|v| Picture::of(&views[*v]).shows(&params, &Body::bundled().model));
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
        let mut picture = Picture::of(view);
        if augment.turn_deg != [0.0; 2] {
            let drawn = |most: f32, rng: &mut Rng| rng.random_range(-1.0..=1.0f32) * most.to_radians();
            let [yaw, pitch] = augment.turn_deg.map(|most| drawn(most, &mut rng));
            let turned = picture.turned(yaw, pitch);
            if turned.shows(&body.params, &Body::bundled().model) {
                picture = turned;
            }
        }
        if augment.depth_noise > 0.0 {
            // An even distribution of this half-width has the wanted deviation.
            let half = augment.depth_noise * 3f32.sqrt();
            picture.depth_m.iter_mut().for_each(|d| *d *= 1.0 + rng.random_range(-half..=half));
        }
        picture.item(body, mirrored)
    }
}

/// A picture on its way to the network.
#[derive(Clone, Debug)]
pub(super) struct Picture {
    pub view: View,
    valid: Valid,
    pub depth_m: Vec<f32>,
    pub labels: Vec<u8>,
}

impl Picture {
    pub fn of(view: &CorpusView) -> Self {
        let depth_m = view.depth_mm.iter().map(|mm| (f32::from(*mm) * 1e-3).min(CLIP_M)).collect();
        Self { view: view.view, valid: view.valid, depth_m, labels: view.labels.clone() }
    }

    /// What the camera sees when it turns left about the world's vertical by `yaw` and down by `pitch` (radians):
    /// exact, for it stays where it is. What comes in from beyond the border repeats the border.
    pub fn turned(&self, yaw: f32, pitch: f32) -> Self {
        let old = self.view.world_from_camera;
        let new = Mat3::from_rotation_y(yaw) * Mat3::from(old.matrix3) * Mat3::from_rotation_x(-pitch);
        let old_from_new = Mat3::from(old.matrix3).transpose() * new;
        let mut out = self.clone();
        out.view.world_from_camera = Affine3A { matrix3: new.into(), translation: old.translation };
        let (focal, middle) = (self.view.intrinsics.focal_px, SIDE as f32 * 0.5);
        let valid = [self.valid.left, self.valid.top, self.valid.width, self.valid.height].map(|n| n as f32);
        for at in (0..SIDE * SIDE).filter(|at| self.valid.contains(at % SIDE, at / SIDE)) {
            let flat = |pixel: usize| (pixel as f32 + 0.5 - middle) / focal;
            let along = old_from_new * Vec3::new(flat(at % SIDE), flat(at / SIDE), 1.0);
            let ahead = along.z.max(1e-3);
            let place = [along.x / ahead * focal + middle, along.y / ahead * focal + middle];
            let inside: [f32; 2] =
                std::array::from_fn(|k| place[k].clamp(valid[k] + 0.5, valid[k] + valid[k + 2] - 0.5));
            let from = inside[1] as usize * SIDE + inside[0] as usize;
            // The new depth of a point is its old one over the old depth of the new ray's unit depth.
            let scale = if inside == place { 1.0 / ahead } else { 1.0 };
            out.depth_m[at] = (self.depth_m[from] * scale).min(CLIP_M);
            out.labels[at] = self.labels[from];
        }
        out
    }

    /// Whether the body's pelvis lies in the picture, between camera and largest depth.
    fn shows(&self, params: &BodyParams, model: &BodyModel) -> bool {
        let pelvis = model.rest_joints(&params.betas)[0] + params.translation;
        let seen = self.view.project(pelvis).is_some_and(|(pixel, _)| {
            self.view.holds(pixel) && self.valid.contains(pixel.x as usize, pixel.y as usize)
        });
        let z = self.view.body_in_camera(params, model).translation.z;
        seen && (NEAREST_M..=self.max_depth_m()).contains(&z)
    }

    /// Share of points (world frame) that lie in the picture and not behind what it shows.
    fn visible_share(&self, points: &[Vec3]) -> f32 {
        let sees = |point: &&Vec3| {
            let Some((pixel, depth_m)) = self.view.project(**point) else { return false };
            let (x, y) = (pixel.x as usize, pixel.y as usize);
            self.view.holds(pixel)
                && self.valid.contains(x, y)
                && self.depth_m[y * SIDE + x] + COVER_M > depth_m
        };
        points.iter().filter(sees).count() as f32 / points.len().max(1) as f32
    }

    fn max_depth_m(&self) -> f32 {
        let deepest = self.depth_m.iter().copied().fold(0.0, f32::max);
        if deepest > 0.0 { deepest } else { CLIP_M }
    }

    /// The body in this picture, mirrored if asked for.
    pub fn item(self, body: &PsiBody, mirrored: bool) -> Item {
        let model = &Body::bundled().model;
        let in_camera = self.view.body_in_camera(&body.params, model);
        let (params, world_from_camera) = if mirrored {
            let flip = Affine3A::from_mat3(FLIP);
            (flipped(&in_camera, body.mirrored_pose, model), self.view.world_from_camera * flip)
        } else {
            (in_camera, self.view.world_from_camera)
        };
        let scene = self.scene_input(mirrored);
        Item { scene, body: params.to_vector(), world_from_camera, room: body.room }
    }

    /// As the network takes it, mirrored if asked for.
    pub fn scene_input(mut self, mirrored: bool) -> SceneInput {
        let max_depth_m = self.max_depth_m();
        let [mut left, top, width, height] =
            [self.valid.left, self.valid.top, self.valid.width, self.valid.height].map(|n| n as usize);
        if mirrored {
            left = SIDE - left - width;
            self.depth_m.chunks_mut(SIDE).for_each(<[f32]>::reverse);
            self.labels.chunks_mut(SIDE).for_each(<[u8]>::reverse);
        }
        SceneInput {
            depth_m: self.depth_m,
            labels: self.labels,
            valid: ValidArea { left, top, width, height },
            max_depth_m,
            focal: Projection::new(&self.view.intrinsics, max_depth_m).scale,
        }
    }
}

/// The body's joints without hands, world frame.
fn joints_of(params: &BodyParams) -> Vec<Vec3> {
    Body::bundled().joints(params)[..=BODY_JOINTS].to_vec()
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
