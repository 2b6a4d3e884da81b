use std::ops::Deref;

use glam::{Mat3, Vec3};
use rand::RngExt as _;
use rand_distr::{Distribution as _, StandardNormal};

use crate::body::{Body, FamilyHints, sample_pose};
use crate::generate::learned::{LearnedSampler, scene_input};
use crate::generate::sensor::SceneImage;
use crate::generate::{SearchRequest, search};
use crate::job::{Rng, Seed, Stop, Ticker};
use crate::scene::{BETAS, BodyParams, PoseFamily, Room, RoomGeometry};

use super::run::{Encoded, Example, Representer};

/// What a placer is asked for.
pub struct PlaceRequest<'a> {
    /// The room.
    pub room: &'a Room,
    /// Its geometry.
    pub geometry: &'a RoomGeometry,
    /// What the agent sees of it.
    pub image: &'a SceneImage,
    /// How many bodies.
    pub count: usize,
    /// Seed of these bodies.
    pub seed: Seed,
}

/// Something that puts bodies into a room as seen from a view.
pub trait Placer: Send + Sync {
    /// Bodies in the world frame; fewer than asked for where the room affords no more.
    ///
    /// # Errors
    /// [`Stop::Cancelled`] when the user cancelled, or why it failed.
    fn place(&self, request: &PlaceRequest<'_>, ticker: &Ticker) -> Result<Vec<BodyParams>, Stop>;
}

/// Human poses anywhere in what the camera sees: the floor under every other method. Poses come from the pose
/// families, upright or lying as these are; the direction is even, the pelvis lies at an even place of the room
/// within the picture, its height even over those that pelvises have.
#[derive(Clone, Copy, Debug, Default)]
pub struct RandomPlacement;

/// Heights of the pelvis joint over the floor, from lying on the floor to standing, in metres.
const PELVIS_HEIGHT_M: std::ops::Range<f32> = 0.1..1.05;
/// Draws of a point before it is taken although the camera doesn't see it.
const POINT_DRAWS: usize = 200;
/// Spread of the shape numbers, as everywhere in the program: most adults, few extremes.
const SHAPE: f32 = 0.7;

impl Placer for RandomPlacement {
    fn place(&self, request: &PlaceRequest<'_>, ticker: &Ticker) -> Result<Vec<BodyParams>, Stop> {
        let place = |index: usize| {
            ticker.check()?;
            let mut rng = request.seed.child("random", index as u64).rng();
            Ok(random_body(request, &mut rng))
        };
        (0..request.count).map(place).collect()
    }
}

fn random_body(request: &PlaceRequest<'_>, rng: &mut Rng) -> BodyParams {
    let body = Body::bundled();
    let family = PoseFamily::ALL[rng.random_range(0..PoseFamily::ALL.len())];
    let sample = sample_pose(&body.model.joint_template, family, rng, &FamilyHints::default());
    let betas: [f32; BETAS] = std::array::from_fn(|_| {
        let z: f32 = StandardNormal.sample(rng);
        z.clamp(-2.5, 2.5) * SHAPE
    });
    let yaw = Mat3::from_rotation_y(rng.random_range(0.0..std::f32::consts::TAU));
    let mut params = sample.params(body, betas, &yaw);
    params.translation = random_point(request, rng) - body.model.rest_joints(&betas)[0];
    params
}

/// A point of the room at a pelvis' height that the camera has in its picture.
fn random_point(request: &PlaceRequest<'_>, rng: &mut Rng) -> Vec3 {
    let bounds = &request.geometry.bounds;
    let mut point = bounds.center();
    for _ in 0..POINT_DRAWS {
        let mut between = |low: f32, high: f32| low + (high - low) * rng.random_range(0.0..1.0);
        point = Vec3::new(
            between(bounds.min.x, bounds.max.x),
            between(PELVIS_HEIGHT_M.start, PELVIS_HEIGHT_M.end),
            between(bounds.min.z, bounds.max.z),
        );
        let seen = request.image.view.project(point).is_some_and(|(pixel, depth_m)| {
            let (x, y) = (pixel.x as usize, pixel.y as usize);
            pixel.min_element() >= 0.0
                && request.image.valid.contains(x, y)
                && depth_m <= request.image.max_depth_m
        });
        if seen {
            break;
        }
    }
    point
}

/// Part 1's affordance search over the whole room; it does not look through the camera.
#[derive(Clone, Copy, Debug, Default)]
pub struct SearchPlacement;

impl Placer for SearchPlacement {
    fn place(&self, request: &PlaceRequest<'_>, ticker: &Ticker) -> Result<Vec<BodyParams>, Stop> {
        let wanted = SearchRequest { proposals: request.count, ..SearchRequest::default() };
        let body = Body::bundled();
        let found = search(request.room, request.geometry, body, &wanted, request.seed, ticker)?;
        Ok(found.into_iter().map(|p| p.params).collect())
    }
}

/// A network of PSI, the program's or one out of a file.
pub struct LearnedPlacement<S>(pub S);

impl<S: Deref<Target = LearnedSampler> + Send + Sync> Placer for LearnedPlacement<S> {
    fn place(&self, request: &PlaceRequest<'_>, ticker: &Ticker) -> Result<Vec<BodyParams>, Stop> {
        Ok(self.0.sample(request.image, request.count, request.seed, ticker, &mut |_| ())?)
    }
}

impl<S: Deref<Target = LearnedSampler> + Send + Sync> Representer for LearnedPlacement<S> {
    fn reconstruct(&self, examples: &[Example]) -> Vec<Encoded> {
        let scenes: Vec<_> = examples.iter().map(|e| scene_input(&e.image)).collect();
        let bodies: Vec<_> = examples.iter().map(|e| e.in_camera.to_vector()).collect();
        let made = self.0.network().reconstruct(&scenes.iter().collect::<Vec<_>>(), &bodies);
        let encoded = |r: crate::nn::psi::Reconstructed| Encoded {
            in_camera: BodyParams::from_vector(&r.body),
            divergence: r.divergence,
        };
        made.into_iter().map(encoded).collect()
    }
}
