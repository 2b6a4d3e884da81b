//! What a keypoint detector would say of a body whose truth is known.

use glam::{Vec2, Vec3};
use rand::RngExt as _;
use rand_distr::{Distribution as _, StandardNormal};

use crate::assets::{Keypoint, KeypointSet, PersonKeypoints};
use crate::body::{Body, Workspace};
use crate::fit::estimation::Landmarks;
use crate::generate::sensor::{Intrinsics, View};
use crate::job::{Rng, Seed};
use crate::scene::{BodyParams, TriangleBvh};

/// How good the made-up detector is.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct ObserveConfig {
    /// Which points.
    pub set: KeypointSet,
    /// Columns of the picture: noise is in its pixels.
    pub columns: u32,
    /// Standard deviation of a well-seen point in x and in y, pixels.
    pub noise_px: f32,
    /// Share of points that are missed by chance.
    pub dropped: f32,
    /// Share of points hidden by furniture or walls that are guessed all the same, badly and with low confidence.
    pub guessed: f32,
}

impl Default for ObserveConfig {
    /// Full-HD pictures as PROX's; 8 px there are 1.3 % of the height of somebody 3 m away, what detectors reach.
    fn default() -> Self {
        Self { set: KeypointSet::Body25, columns: 1920, noise_px: 8.0, dropped: 0.05, guessed: 0.5 }
    }
}

/// Noise of points that the body itself hides, and of guesses behind furniture, as multiples of a seen point's.
const SELF_HIDDEN_NOISE: f32 = 2.0;
const GUESS_NOISE: f32 = 4.0;
/// Confidences of seen, self-hidden and guessed points.
const SEEN: std::ops::Range<f32> = 0.7..1.0;
const SELF_HIDDEN: std::ops::Range<f32> = 0.35..0.7;
const GUESSED: std::ops::Range<f32> = 0.1..0.4;
/// Joints lie under skin, so skin up to this far before one does not hide it, metres.
const UNDER_SKIN_M: f32 = 0.14;
/// A surface up to this far before a point touches it rather than hides it, metres.
const TOUCHING_M: f32 = 0.03;

/// Makes keypoints of bodies of one model.
pub struct Observer<'a> {
    body: &'a Body,
    landmarks: Landmarks,
}

/// How a point is to the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sight {
    Seen,
    BehindOneself,
    BehindThings,
    OutsideThePicture,
}

impl<'a> Observer<'a> {
    /// For bodies of `body`.
    pub fn new(body: &'a Body) -> Self {
        Self { body, landmarks: Landmarks::of(&body.model) }
    }

    /// The view with the configured number of columns: the same camera with more pixels.
    pub fn enlarged(view: &View, config: &ObserveConfig) -> View {
        let Intrinsics { width, height, focal_px } = view.intrinsics;
        let factor = config.columns as f32 / width.max(1) as f32;
        let height = (height as f32 * factor).round() as u32;
        View {
            intrinsics: Intrinsics { width: config.columns, height, focal_px: focal_px * factor },
            ..*view
        }
    }

    /// Keypoints of `truth` in the enlarged `view` of a room with surfaces `room`.
    pub fn observe(
        &self,
        truth: &BodyParams,
        view: &View,
        room: &TriangleBvh,
        config: &ObserveConfig,
        seed: Seed,
    ) -> PersonKeypoints {
        let mut workspace = Workspace::default();
        self.body.forward(truth, &self.landmarks.subset, &mut workspace);
        let positions = Landmarks::positions(config.set, &workspace);
        let skin = skin_of(self.body, truth);
        let mut rng = seed.rng();
        let points = positions
            .into_iter()
            .map(|p| detected(p, sight(p, view, room, &skin), view, config, &mut rng))
            .collect();
        PersonKeypoints { set: config.set, points }
    }
}

fn skin_of(body: &Body, params: &BodyParams) -> TriangleBvh {
    let vertices = body.pose(params).vertices;
    TriangleBvh::new(body.model.faces.iter().map(|f| f.map(|v| vertices[v as usize])).collect())
}

fn sight(point: Vec3, view: &View, room: &TriangleBvh, skin: &TriangleBvh) -> Sight {
    let inside = view.project(point).is_some_and(|(pixel, _)| view.holds(pixel));
    if !inside {
        return Sight::OutsideThePicture;
    }
    let ray = point - view.eye();
    let (distance_m, direction) = (ray.length(), ray.normalize_or(Vec3::Z));
    if room.any_hit(view.eye(), direction, distance_m - TOUCHING_M) {
        Sight::BehindThings
    } else if skin.any_hit(view.eye(), direction, distance_m - UNDER_SKIN_M) {
        Sight::BehindOneself
    } else {
        Sight::Seen
    }
}

/// The same random numbers are drawn whatever is seen, so that one point's luck does not change another's.
fn detected(point: Vec3, sight: Sight, view: &View, config: &ObserveConfig, rng: &mut Rng) -> Keypoint {
    let noise: [f32; 2] = std::array::from_fn(|_| StandardNormal.sample(rng));
    let [missed, guess, trust]: [f32; 3] = std::array::from_fn(|_| rng.random_range(0.0..1.0));
    let (noise_factor, range) = match sight {
        Sight::Seen => (1.0, SEEN),
        Sight::BehindOneself => (SELF_HIDDEN_NOISE, SELF_HIDDEN),
        Sight::BehindThings if guess < config.guessed => (GUESS_NOISE, GUESSED),
        _ => return Keypoint::default(),
    };
    let Some((pixel, _)) = view.project(point).filter(|_| missed >= config.dropped) else {
        return Keypoint::default();
    };
    let off = Vec2::from_array(noise) * (config.noise_px * noise_factor);
    Keypoint { pixel: pixel + off, confidence: range.start + trust * (range.end - range.start) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wall 1 m high across the view, 1 m before the body.
    fn low_wall() -> TriangleBvh {
        let corner = |x: f32, y: f32| Vec3::new(x, y, 1.0);
        TriangleBvh::new(vec![
            [corner(-5.0, 0.0), corner(5.0, 0.0), corner(5.0, 0.8)],
            [corner(-5.0, 0.0), corner(5.0, 0.8), corner(-5.0, 0.8)],
        ])
    }

    #[test]
    fn legs_behind_a_wall_are_guessed_or_missed_and_the_head_is_seen_with_noise_as_said() {
        let body = Body::bundled();
        let observer = Observer::new(body);
        let config = ObserveConfig::default();
        let lens = Intrinsics::from_fov_y(480, 270, 1.0);
        let view = View::look_at(Vec3::new(0.0, 1.2, 3.5), Vec3::Y * 0.9, lens);
        let view = Observer::enlarged(&view, &config);
        assert_eq!((view.intrinsics.width, view.intrinsics.height), (1920, 1080));
        let truth = BodyParams { translation: Vec3::Y * 0.95, ..BodyParams::default() };
        let seen = |seed| observer.observe(&truth, &view, &low_wall(), &config, Seed::root(seed));
        assert_eq!(seen(1), seen(1));
        let (nose, ankle) = (0, 14);
        let exact = {
            let no_noise = ObserveConfig { noise_px: 0.0, dropped: 0.0, ..config };
            observer.observe(&truth, &view, &low_wall(), &no_noise, Seed::root(0)).points[nose].pixel
        };
        let all: Vec<PersonKeypoints> = (0..300).map(seen).collect();
        assert!(all.iter().all(|p| p.points[ankle].confidence < 0.4), "ankles stand behind the wall");
        let found: Vec<&Keypoint> =
            all.iter().map(|p| &p.points[nose]).filter(|p| p.confidence > 0.0).collect();
        assert!((270..297).contains(&found.len()), "{} of 300 noses, 95 % are expected", found.len());
        let squared = found.iter().map(|p| p.pixel.distance_squared(exact)).sum::<f32>();
        let deviation = (squared / found.len() as f32 / 2.0).sqrt();
        assert!((deviation - config.noise_px).abs() < 0.8, "{deviation} px");
    }
}
