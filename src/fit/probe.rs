//! Where a body is asked how it stands to the room: a sample of its skin with all contact regions, and
//! spheres along its bones.

use std::collections::{BTreeMap, BTreeSet};

use glam::{IVec3, Vec3};

use crate::body::joints as j;
use crate::body::{Body, Region, VertexSubset};

/// One vertex is taken of each cube of skin of this size: about 2,000 of an adult.
const SKIN_SAMPLE_M: f32 = 0.03;

/// A sphere along a bone, thinner than the flesh there: the joints it lies between, the share of the way,
/// and its radius.
#[derive(Clone, Copy, Debug)]
pub struct BoneSphere {
    /// The upper joint.
    pub from: usize,
    /// The lower joint.
    pub to: usize,
    /// 0 at `from`, 1 at `to`.
    pub along: f32,
    /// Radius in metres.
    pub radius_m: f32,
    /// Which limb it belongs to, for self-collision.
    pub limb: Limb,
}

impl BoneSphere {
    /// Centre for the given joints.
    pub fn center(&self, joints: &[Vec3; j::JOINTS]) -> Vec3 {
        joints[self.from].lerp(joints[self.to], self.along)
    }
}

/// Groups of bones that may run into each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limb {
    /// Pelvis to neck.
    Torso,
    /// Head.
    Head,
    /// Left thigh, shin and foot.
    LeftLeg,
    /// Right thigh, shin and foot.
    RightLeg,
    /// Left forearm and hand; the upper arm may always touch the torso.
    LeftArm,
    /// Right forearm and hand.
    RightArm,
    /// Upper arms: tested against the room only.
    UpperArm,
}

impl Limb {
    /// Whether the two can run into each other (and are not joined).
    fn meets(self, other: Self) -> bool {
        use Limb::{Head, LeftArm, LeftLeg, RightArm, RightLeg, Torso};
        matches!(
            (self, other),
            (LeftArm, Torso | Head | LeftLeg | RightLeg | RightArm)
                | (RightArm, Torso | Head | LeftLeg | RightLeg)
                | (LeftLeg, RightLeg)
        )
    }
}

/// Share of the least thickness of flesh around a point of a bone that its sphere takes.
const FLESH_SHARE: f32 = 0.9;

/// Bones as (from, to, spheres, limb).
const BONES: &[(usize, usize, u32, Limb)] = &[
    (j::PELVIS, j::SPINE2, 3, Limb::Torso),
    (j::SPINE2, j::SPINE3, 2, Limb::Torso),
    (j::SPINE3, j::NECK, 3, Limb::Torso),
    (j::NECK, j::HEAD, 2, Limb::Head),
    (j::LEFT_HIP, j::LEFT_KNEE, 5, Limb::LeftLeg),
    (j::RIGHT_HIP, j::RIGHT_KNEE, 5, Limb::RightLeg),
    (j::LEFT_KNEE, j::LEFT_ANKLE, 5, Limb::LeftLeg),
    (j::RIGHT_KNEE, j::RIGHT_ANKLE, 5, Limb::RightLeg),
    (j::LEFT_ANKLE, j::LEFT_FOOT, 2, Limb::LeftLeg),
    (j::RIGHT_ANKLE, j::RIGHT_FOOT, 2, Limb::RightLeg),
    (j::LEFT_SHOULDER, j::LEFT_ELBOW, 4, Limb::UpperArm),
    (j::RIGHT_SHOULDER, j::RIGHT_ELBOW, 4, Limb::UpperArm),
    (j::LEFT_ELBOW, j::LEFT_WRIST, 4, Limb::LeftArm),
    (j::RIGHT_ELBOW, j::RIGHT_WRIST, 4, Limb::RightArm),
    (j::LEFT_WRIST, j::LEFT_MIDDLE1, 2, Limb::LeftArm),
    (j::RIGHT_WRIST, j::RIGHT_MIDDLE1, 2, Limb::RightArm),
];

/// All that the energies ask of a body, found once per body model.
pub struct Probe {
    /// The skin sample.
    pub subset: VertexSubset,
    /// Entries of the subset in each region.
    pub regions: BTreeMap<Region, Vec<u32>>,
    /// Of each entry of the subset: the joint that moves it most, and its outward normal at rest.
    pub rest_normals: Vec<(usize, Vec3)>,
    /// Spheres along the bones.
    pub bones: Vec<BoneSphere>,
    /// Pairs of `bones` that must not run into each other.
    pub pairs: Vec<(u16, u16)>,
}

impl Probe {
    /// The probe of a body.
    pub fn new(body: &Body) -> Self {
        Self::sparse(body, SKIN_SAMPLE_M, usize::MAX)
    }

    /// A probe with one vertex of each cube of skin of side `sample_m`, metres, and at most about `region_sample`
    /// vertices of each contact region.
    pub fn sparse(body: &Body, sample_m: f32, region_sample: usize) -> Self {
        let mut chosen: BTreeSet<u32> = skin_sample(&body.model.template, sample_m).into_iter().collect();
        for region in Region::ALL {
            let sample = body.regions.sample(region);
            chosen.extend(sample.iter().step_by(sample.len().div_ceil(region_sample).max(1)));
        }
        let ids: Vec<u32> = chosen.into_iter().collect();
        let entry = |vertex: &u32| ids.binary_search(vertex).ok().map(|i| i as u32);
        let regions = Region::ALL
            .into_iter()
            .map(|r| (r, body.regions.sample(r).iter().filter_map(entry).collect()))
            .collect();
        let bones = bone_spheres(body);
        let pairs = meeting_pairs(&bones);
        let normals = body.vertex_normals(&body.model.template);
        let rest_normals =
            ids.iter().map(|v| (body.model.dominant_joint(*v as usize), normals[*v as usize])).collect();
        Self { subset: VertexSubset::new(&body.model, ids), regions, rest_normals, bones, pairs }
    }
}

/// The first vertex in each occupied cube.
fn skin_sample(template: &[Vec3], sample_m: f32) -> Vec<u32> {
    let mut cubes: BTreeMap<[i32; 3], u32> = BTreeMap::new();
    for (i, p) in template.iter().enumerate() {
        let cube: IVec3 = (*p / sample_m).floor().as_ivec3();
        cubes.entry(cube.to_array()).or_insert(i as u32);
    }
    cubes.into_values().collect()
}

/// Every sphere along every bone, as thick as the flesh of the mean shape allows.
pub fn bone_spheres(body: &Body) -> Vec<BoneSphere> {
    let joints = &body.model.joint_template;
    let spheres = BONES.iter().flat_map(|&(from, to, count, limb)| {
        (0..count).map(move |i| BoneSphere {
            from,
            to,
            along: (i as f32 + 0.5) / count as f32,
            radius_m: 0.0,
            limb,
        })
    });
    // The middle of the skull lies above its joint: beyond the end of the neck.
    let skull = BoneSphere { from: j::NECK, to: j::HEAD, along: 1.9, radius_m: 0.0, limb: Limb::Head };
    let thick = |sphere: BoneSphere| {
        let center = sphere.center(joints);
        let skin_m = body.model.template.iter().map(|v| v.distance(center)).fold(f32::INFINITY, f32::min);
        BoneSphere { radius_m: skin_m * FLESH_SHARE, ..sphere }
    };
    spheres.chain([skull]).map(thick).collect()
}

fn meeting_pairs(bones: &[BoneSphere]) -> Vec<(u16, u16)> {
    let all = 0..bones.len() as u16;
    all.clone()
        .flat_map(|a| all.clone().map(move |b| (a, b)))
        .filter(|(a, b)| bones[usize::from(*a)].limb.meets(bones[usize::from(*b)].limb))
        .collect()
}
