//! A simulator that proves the learner: people with known layouts around them, photographed, annotated as COCO would,
//! learned from, and compared.

use glam::{Mat3, Vec2, Vec3};
use rand::RngExt as _;
use rand_distr::{Distribution as _, StandardNormal};
use serde::Serialize;
use serde_json::json;

use super::instances::{InstanceConfig, find_instances};
use super::nodes::{ModelConfig, build_model};
use super::pose::{JointPlacer, Joints3, PoseDictionary, PoseSolver, PoseSolverConfig, coco, family_poses};
use super::rules::Rules;
use crate::assets::AssetError;
use crate::assets::photos::{PHOTO_JOINTS, Photo, PhotoSet};
use crate::body::{Body, FamilyHints, sample_pose};
use crate::evolve::action::{ActionKind, ActionNode, KeyObject, Occurrence, PersonFrame, Polar};
use crate::job::{Rng, Seed, Stop, Ticker};
use crate::math::LogNormal;
use crate::math::directions::{VonMises, VonMisesMixture, wrap};
use crate::scene::{BodyParams, PoseFamily};

/// An object of the simulated action.
#[derive(Clone, Debug, PartialEq)]
pub struct TrueObject {
    /// How often how many.
    pub occurrence: Occurrence,
    /// Distance from the person, metres.
    pub distance_m: LogNormal,
    /// Direction from the person.
    pub direction: VonMisesMixture,
}

/// The action whose parameters are known: using a laptop at a desk, seated.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    /// Its objects.
    pub objects: Vec<TrueObject>,
    /// Where the desk's middle is seen.
    pub key_angle: VonMises,
}

impl Truth {
    /// A laptop in front, cups to the right in front or to the left, at times a book.
    pub fn example() -> Self {
        let object = |name: &str, counts: &[f64], distance: [f64; 2], parts: &[[f64; 3]]| TrueObject {
            occurrence: Occurrence { object: name.to_owned(), probability: counts.to_vec() },
            distance_m: LogNormal { mu: distance[0], sigma: distance[1] },
            direction: VonMisesMixture {
                components: parts
                    .iter()
                    .map(|[weight, degrees, kappa]| {
                        (*weight, VonMises { mean_rad: degrees.to_radians(), kappa: *kappa })
                    })
                    .collect(),
            },
        };
        Self {
            objects: vec![
                object("laptop", &[0.0, 1.0], [-0.7, 0.25], &[[1.0, 90.0, 12.0]]),
                object("cup", &[0.4, 0.4, 0.2], [-0.5, 0.3], &[[0.7, 45.0, 10.0], [0.3, 150.0, 10.0]]),
                object("book", &[0.75, 0.25], [-0.3, 0.3], &[[1.0, 120.0, 5.0]]),
            ],
            key_angle: VonMises { mean_rad: 90.0_f64.to_radians(), kappa: 20.0 },
        }
    }
}

/// The simulated camera and annotators.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Conditions {
    /// Photos.
    pub photos: usize,
    /// Standard deviation of a marked joint, share of the torso's length.
    pub noise: f32,
    /// Share of photos in which everything below the hips is hidden.
    pub legs_hidden: f32,
    /// Share of other joints that nobody marked.
    pub joints_missed: f32,
    /// Standard deviation of the camera's pitch about 20°, degrees.
    pub pitch_spread_deg: f32,
    /// Height of the objects below the middle of the torso, metres.
    pub below_m: f32,
}

impl Default for Conditions {
    fn default() -> Self {
        Self {
            photos: 300,
            noise: 0.02,
            legs_hidden: 0.5,
            joints_missed: 0.05,
            pitch_spread_deg: 5.0,
            below_m: 0.0,
        }
    }
}

/// How far what was learned is from the truth.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Recovery {
    /// Under which conditions.
    pub conditions: Conditions,
    /// Instances that passed the filters.
    pub instances: usize,
    /// Largest error of a probability C(o, n).
    pub occurrence: f64,
    /// Largest error of a distance's μ.
    pub mu: f64,
    /// Largest error of a distance's σ.
    pub sigma: f64,
    /// Largest error of the mean direction of a whole mixture, degrees.
    pub direction_deg: f64,
    /// Largest half integral of the difference of two densities of direction: 0 alike, 1 disjoint.
    pub direction_apart: f64,
    /// Error of the key object's mean direction, degrees.
    pub key_deg: f64,
    /// Learned κ of the key object's direction over the true one.
    pub key_kappa_ratio: f64,
}

/// Photographs people who follow `truth`, learns from the annotations, compares.
///
/// # Errors
/// [`Stop::Cancelled`] once the user cancelled; [`Stop::Failed`] when nobody passed the filters.
pub fn recover(
    truth: &Truth,
    conditions: &Conditions,
    seed: Seed,
    ticker: &Ticker,
) -> Result<Recovery, Stop> {
    let photos = simulated_photos(truth, conditions, seed)?;
    let solver = PoseSolver::new(PoseDictionary::bundled(), PoseSolverConfig::default());
    let config = InstanceConfig { categories_least: 1, ..InstanceConfig::default() };
    let found = find_instances(&photos, Rules::bundled(), &config, &solver, ticker)?;
    let model_config = ModelConfig { prior_instances: 0.0, prior_places: 0.0, ..ModelConfig::default() };
    let unit = config.frame.metres_per_unit();
    let model = build_model(&found, Rules::bundled(), &model_config, unit, seed);
    let of_kind =
        model.nodes.iter().filter(|n| n.kind == ActionKind::UseLaptop && n.key == KeyObject::OfficeDesk);
    let node = of_kind.max_by_key(|n| n.instances).ok_or_else(nobody)?;
    Ok(compare(truth, conditions, node))
}

fn compare(truth: &Truth, conditions: &Conditions, node: &ActionNode) -> Recovery {
    let mut recovery = Recovery {
        conditions: *conditions,
        instances: node.instances,
        occurrence: 0.0,
        mu: 0.0,
        sigma: 0.0,
        direction_deg: 0.0,
        direction_apart: 0.0,
        key_deg: 180.0,
        key_kappa_ratio: 0.0,
    };
    for object in &truth.objects {
        let name = &object.occurrence.object;
        for (n, expected) in object.occurrence.probability.iter().enumerate() {
            let learned = node.occurrence_of(name).and_then(|o| o.probability.get(n)).copied();
            let learned =
                learned.unwrap_or(if n == 0 && node.occurrence_of(name).is_none() { 1.0 } else { 0.0 });
            recovery.occurrence = recovery.occurrence.max((learned - expected).abs());
        }
        let Some(placement) = node.placement(name) else { continue };
        let density = &placement.density;
        recovery.mu = recovery.mu.max((density.distance_m.mu - object.distance_m.mu).abs());
        recovery.sigma = recovery.sigma.max((density.distance_m.sigma - object.distance_m.sigma).abs());
        let off = density.direction.resultant().mean_rad - object.direction.resultant().mean_rad;
        recovery.direction_deg = recovery.direction_deg.max(wrap(off).abs().to_degrees());
        recovery.direction_apart = recovery.direction_apart.max(apart(&density.direction, &object.direction));
    }
    if let Some(angle) = node.key_angle {
        recovery.key_deg = wrap(angle.mean_rad - truth.key_angle.mean_rad).abs().to_degrees();
        recovery.key_kappa_ratio = angle.kappa / truth.key_angle.kappa;
    }
    recovery
}

fn nobody() -> Stop {
    Stop::Failed("no simulated person passed the filters: show more joints".to_owned())
}

/// Half the integral of the difference.
fn apart(a: &VonMisesMixture, b: &VonMisesMixture) -> f64 {
    const STEPS: u32 = 720;
    let step = std::f64::consts::TAU / f64::from(STEPS);
    let at = |i: u32| f64::from(i) * step;
    0.5 * step * (0..STEPS).map(|i| (a.density(at(i)) - b.density(at(i))).abs()).sum::<f64>()
}

/// Photos of the action, through COCO's json.
///
/// # Errors
/// When the annotations can't be read back, which would be a fault of the reader.
pub fn simulated_photos(
    truth: &Truth,
    conditions: &Conditions,
    seed: Seed,
) -> Result<Vec<Photo>, AssetError> {
    let mut placer = JointPlacer::new(Body::bundled());
    let (mut images, mut annotations, mut captions) = (Vec::new(), Vec::new(), Vec::new());
    for id in 0..conditions.photos {
        let mut rng = seed.child("photo", id as u64).rng();
        let shot = Shot::take(truth, conditions, &mut placer, &mut rng);
        images.push(json!({ "id": id, "width": WIDTH, "height": HEIGHT }));
        captions.push(json!({ "image_id": id, "caption": "A person using a laptop on a desk." }));
        let boxed = |category: u32, bounds: [f32; 4]| json!({ "image_id": id, "category_id": category, "bbox": bounds, "iscrowd": 0 });
        let mut person = boxed(1, shot.person);
        person["keypoints"] = json!(shot.keypoints);
        annotations.push(person);
        annotations.push(boxed(2, shot.desk));
        annotations.extend(shot.objects.iter().map(|(index, bounds)| boxed(3 + *index as u32, *bounds)));
    }
    let mut categories =
        vec![json!({ "id": 1, "name": "person" }), json!({ "id": 2, "name": "dining table" })];
    let names = truth.objects.iter().enumerate();
    categories.extend(names.map(|(i, o)| json!({ "id": 3 + i, "name": o.occurrence.object })));
    let file = json!({ "images": images, "annotations": annotations, "captions": captions, "categories": categories });
    let mut set = PhotoSet::default();
    set.add_bytes("simulated photos", file.to_string().as_bytes())?;
    Ok(set.finish().photos)
}

/// The pictures' size in pixels and their focal length.
const WIDTH: f32 = 640.0;
const HEIGHT: f32 = 480.0;
const FOCAL_PX: f32 = 700.0;
/// Half the side of an object, metres.
const HALF_OBJECT_M: f32 = 0.08;
/// Size of the desk over the floor plan, and how far its middle is from the person, metres.
const DESK_M: [f32; 2] = [1.2, 0.7];
const DESK_AWAY_M: f32 = 0.75;

/// What is annotated of one photo; boxes as COCO writes them (left, top, width, height).
struct Shot {
    person: [f32; 4],
    keypoints: Vec<f32>,
    desk: [f32; 4],
    /// Number of the object in the truth, and its box.
    objects: Vec<(usize, [f32; 4])>,
}

/// A pinhole camera that looks at somebody.
struct Lens {
    camera_from_world: Mat3,
    eye_m: Vec3,
}

impl Lens {
    fn around(middle_m: Vec3, conditions: &Conditions, rng: &mut Rng) -> Self {
        let tilt: f32 = StandardNormal.sample(rng);
        let pitch = (20.0 + conditions.pitch_spread_deg * tilt).to_radians();
        let yaw: f32 = rng.random_range(-std::f32::consts::PI..std::f32::consts::PI);
        let camera_from_world = Mat3::from_rotation_x(pitch) * Mat3::from_rotation_y(yaw);
        let distance_m: f32 = rng.random_range(2.5..4.5);
        Self {
            camera_from_world,
            eye_m: middle_m + camera_from_world.transpose() * Vec3::new(0.0, 0.0, distance_m),
        }
    }

    /// Column and row; the camera looks along its own -Z.
    fn pixel(&self, point_m: Vec3) -> Vec2 {
        let p = self.camera_from_world * (point_m - self.eye_m);
        let scale = FOCAL_PX / (-p.z).max(0.2);
        Vec2::new(0.5 * WIDTH + p.x * scale, 0.5 * HEIGHT - p.y * scale)
    }

    fn bounds(&self, points: impl Iterator<Item = Vec3>) -> [f32; 4] {
        let (low, high) = points
            .map(|p| self.pixel(p))
            .fold((Vec2::INFINITY, Vec2::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
        [low.x, low.y, high.x - low.x, high.y - low.y]
    }
}

impl Shot {
    fn take(truth: &Truth, conditions: &Conditions, placer: &mut JointPlacer<'_>, rng: &mut Rng) -> Self {
        let rest = &Body::bundled().model.joint_template;
        let hints = FamilyHints { table_height_m: Some(0.74), ..FamilyHints::default() };
        let pose = sample_pose(rest, PoseFamily::SitChair, rng, &hints);
        let mut params = BodyParams::default();
        params.set_rotation(&pose.upright_from_body);
        let joints = placer.joints_of(&params, &pose.pose);
        let person = frame_of(&joints);
        let lens = Lens::around(person.centre_m, conditions, rng);
        let down = Vec3::Y * conditions.below_m;
        let mut objects = Vec::new();
        for (index, object) in truth.objects.iter().enumerate() {
            for _ in 0..object.occurrence.draw(rng) {
                let distance_m = object.distance_m.sample(rng) as f32;
                let angle_rad = object.direction.sample(rng) as f32;
                let at = person.place(Polar { distance_m, angle_rad }) - down;
                objects.push((index, lens.bounds(corners(at, Vec3::splat(HALF_OBJECT_M)))));
            }
        }
        let angle_rad = truth.key_angle.sample(rng) as f32;
        let desk = person.place(Polar { distance_m: DESK_AWAY_M, angle_rad }) - down;
        let half = Vec3::new(0.5 * DESK_M[0], 0.01, 0.5 * DESK_M[1]);
        Self {
            person: lens.bounds(joints.iter().copied()),
            keypoints: marks(&joints, &lens, conditions, rng),
            desk: lens.bounds(corners(desk, half)),
            objects,
        }
    }
}

fn frame_of(joints: &Joints3) -> PersonFrame {
    let middle = |a: usize, b: usize| (joints[a] + joints[b]) * 0.5;
    let shoulders = middle(coco::LEFT_SHOULDER, coco::RIGHT_SHOULDER);
    let hips = middle(coco::LEFT_HIP, coco::RIGHT_HIP);
    let front = Vec3::Y.cross(joints[coco::RIGHT_SHOULDER] - joints[coco::LEFT_SHOULDER]);
    PersonFrame { centre_m: (shoulders + hips) * 0.5, facing_rad: front.x.atan2(front.z) }
}

fn corners(middle: Vec3, half: Vec3) -> impl Iterator<Item = Vec3> {
    (0..8).map(move |i: u32| {
        let sign = |bit: u32| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
        middle + half * Vec3::new(sign(0), sign(1), sign(2))
    })
}

fn marks(joints: &Joints3, lens: &Lens, conditions: &Conditions, rng: &mut Rng) -> Vec<f32> {
    let hidden = rng.random::<f32>() < conditions.legs_hidden;
    let pixels = joints.map(|j| lens.pixel(j));
    let torso_px = (pixels[coco::LEFT_SHOULDER] + pixels[coco::RIGHT_SHOULDER]
        - pixels[coco::LEFT_HIP]
        - pixels[coco::RIGHT_HIP])
        .length()
        * 0.5;
    let mut numbers = Vec::with_capacity(3 * PHOTO_JOINTS);
    for (joint, pixel) in pixels.iter().enumerate() {
        let [dx, dy]: [f32; 2] = std::array::from_fn(|_| StandardNormal.sample(rng));
        let missed = rng.random::<f32>() < conditions.joints_missed;
        let torso = (coco::LEFT_SHOULDER..=coco::RIGHT_SHOULDER).contains(&joint)
            || (coco::LEFT_HIP..=coco::RIGHT_HIP).contains(&joint);
        if (hidden && joint >= coco::LEFT_KNEE) || (missed && !torso) {
            numbers.extend([0.0, 0.0, 0.0]);
        } else {
            let at = *pixel + Vec2::new(dx, dy) * (conditions.noise * torso_px);
            numbers.extend([at.x, at.y, 2.0]);
        }
    }
    numbers
}

/// The conditions of [`degradation`]: fewer photos, more noise, hidden legs, other cameras, lower objects.
pub fn conditions_to_try() -> Vec<(&'static str, Conditions)> {
    let usual = Conditions::default();
    vec![
        ("n = 30", Conditions { photos: 30, ..usual }),
        ("n = 100", Conditions { photos: 100, ..usual }),
        ("n = 300", usual),
        ("n = 1000", Conditions { photos: 1000, ..usual }),
        ("no noise, all joints", Conditions { noise: 0.0, legs_hidden: 0.0, joints_missed: 0.0, ..usual }),
        ("joints 5 % of the torso off", Conditions { noise: 0.05, ..usual }),
        ("joints 10 % of the torso off", Conditions { noise: 0.1, ..usual }),
        ("all legs hidden", Conditions { legs_hidden: 1.0, ..usual }),
        ("cameras pitched 20 ± 15°", Conditions { pitch_spread_deg: 15.0, ..usual }),
        ("objects 10 cm below the torso's middle", Conditions { below_m: 0.1, ..usual }),
    ]
}

/// Recovery under each of [`conditions_to_try`].
///
/// # Errors
/// [`Stop::Cancelled`] once the user cancelled; [`Stop::Failed`] when nobody passed the filters.
pub fn degradation(seed: Seed, ticker: &Ticker) -> Result<Vec<(String, Recovery)>, Stop> {
    let truth = Truth::example();
    let tried = conditions_to_try().into_iter().map(|(name, conditions)| {
        Ok((name.to_owned(), recover(&truth, &conditions, seed, &ticker.without_progress())?))
    });
    tried.collect()
}

/// Errors of poses in space, millimetres after the best similarity, and frames' facings.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PoseAccuracy {
    /// What was solved.
    pub what: String,
    /// Poses.
    pub poses: usize,
    /// Mean error of the relaxation alone, millimetres.
    pub convex_mm: f32,
    /// Mean error after refinement, millimetres.
    pub refined_mm: f32,
    /// Half of the facings are off by less, degrees.
    pub facing_median_deg: f32,
    /// Nine of ten facings are off by less, degrees.
    pub facing_90_percent_deg: f32,
}

/// How well poses (body frame, metres) are found through random cameras, with joints off by `noise_m`, optionally
/// without legs (then the others are compared).
pub fn pose_accuracy(
    what: &str,
    poses: &[Joints3],
    dictionary: &PoseDictionary,
    noise_m: f32,
    legs_hidden: bool,
    seed: Seed,
) -> PoseAccuracy {
    use rayon::prelude::*;
    let refined = PoseSolver::new(dictionary, PoseSolverConfig::default());
    let convex =
        PoseSolver::new(dictionary, PoseSolverConfig { refine: false, ..PoseSolverConfig::default() });
    let last = if legs_hidden { coco::LEFT_KNEE } else { PHOTO_JOINTS };
    let rows: Vec<[f32; 3]> = poses
        .par_iter()
        .enumerate()
        .filter_map(|(index, joints)| {
            let mut rng = seed.child("camera", index as u64).rng();
            let yaw = rng.random_range(-std::f32::consts::PI..std::f32::consts::PI);
            let turn = Mat3::from_rotation_x(rng.random_range(-0.3..0.3)) * Mat3::from_rotation_y(yaw);
            let truth = joints.map(|p| turn * p);
            let mark = |p: Vec3, rng: &mut Rng| {
                let off: [f32; 2] = std::array::from_fn(|_| StandardNormal.sample(rng));
                let pixel = (Vec2::new(p.x, -p.y) + Vec2::from_array(off) * noise_m) * 100.0;
                crate::assets::Keypoint { pixel, confidence: 1.0 }
            };
            let mut marks = truth.map(|p| mark(p, &mut rng));
            marks[last..].fill(crate::assets::Keypoint::default());
            let error = |solver: &PoseSolver<'_>| {
                let found = solver.solve(&marks)?.joints_px;
                Some((aligned_mm(&found[..last], &truth[..last]), facing_off_deg(&found, &truth)))
            };
            let (refined, convex) = (error(&refined)?, error(&convex)?);
            Some([convex.0, refined.0, refined.1])
        })
        .collect();
    let mean = |i: usize| rows.iter().map(|r| r[i]).sum::<f32>() / rows.len().max(1) as f32;
    let mut facings: Vec<f32> = rows.iter().map(|r| r[2]).collect();
    facings.sort_by(f32::total_cmp);
    let at = |share: f32| facings.get((share * facings.len() as f32) as usize).copied().unwrap_or(f32::NAN);
    PoseAccuracy {
        what: what.to_owned(),
        poses: rows.len(),
        convex_mm: mean(0),
        refined_mm: mean(1),
        facing_median_deg: at(0.5),
        facing_90_percent_deg: at(0.9),
    }
}

fn aligned_mm(found: &[Vec3], truth: &[Vec3]) -> f32 {
    use crate::inspect::{Similarity, mean_distance_mm};
    mean_distance_mm(&Similarity::between(found, truth).apply(found), truth)
}

fn facing_off_deg(found: &Joints3, truth: &Joints3) -> f32 {
    let off = f64::from(frame_of(found).facing_rad - frame_of(truth).facing_rad);
    wrap(off).abs().to_degrees() as f32
}

/// Draws of every pose family that no dictionary has seen.
///
/// # Errors
/// When cancelled.
pub fn unseen_families(each: usize, seed: Seed, ticker: &Ticker) -> Result<Vec<Joints3>, Stop> {
    let mut placer = JointPlacer::new(Body::bundled());
    let poses = family_poses(Body::bundled(), each, seed.child("unseen", 0), ticker)?;
    Ok(poses.iter().map(|p| placer.joints(p)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recovery(conditions: Conditions) -> Recovery {
        recover(&Truth::example(), &conditions, Seed::root(1), &Ticker::silent()).expect("recovered")
    }

    #[test]
    fn known_layouts_are_recovered_from_annotations() {
        let found = recovery(Conditions { photos: 300, ..Conditions::default() });
        assert!(found.instances > 200, "{found:?}");
        assert!(found.occurrence < 0.08, "{found:?}");
        assert!(found.mu < 0.25 && found.sigma < 0.25, "{found:?}");
        assert!(found.direction_deg < 15.0 && found.direction_apart < 0.35, "{found:?}");
        assert!(found.key_deg < 12.0, "{found:?}");
    }

    #[test]
    fn fewer_photos_and_noisier_joints_are_learned_from_less_well() {
        let apart = |photos: usize, noise: f32| {
            let conditions = Conditions { photos, noise, ..Conditions::default() };
            recovery(conditions).direction_apart
        };
        let usual = apart(250, 0.02);
        assert!(usual < apart(250, 0.25), "noise");
        assert!(usual < apart(20, 0.02), "few photos");
    }
}
