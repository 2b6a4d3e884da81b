//! Which vertices may touch the room, by name: PROX's contact segments and a few more, found by geometry on
//! the body's own mesh (rest position, joint that moves it most, outward normal).

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::joints;
use super::model::BodyModel;

/// A named patch of skin. The first seven are PROX's contact segments (PSI §3.3), the others serve lying
/// bodies and reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Region {
    /// Back of the torso.
    Back,
    /// What one sits on.
    Butt,
    /// Palm side of the left hand.
    LeftHand,
    /// Palm side of the right hand.
    RightHand,
    /// Left sole (PROX's `L_Leg`).
    LeftLeg,
    /// Right sole (PROX's `R_Leg`).
    RightLeg,
    /// Underside of the thighs.
    Thighs,
    /// Back of the head.
    HeadBack,
    /// Face.
    Face,
    /// Chest and belly.
    Front,
    /// Left flank: ribs, hip and outer thigh.
    LeftSide,
    /// Right flank.
    RightSide,
    /// Calves.
    Calves,
    /// Heels.
    Heels,
    /// Underside of the forearms.
    Forearms,
    /// Front of the thighs and shins, for lying face down.
    LegFronts,
}

impl Region {
    /// Every region.
    pub const ALL: [Self; 16] = [
        Self::Back,
        Self::Butt,
        Self::LeftHand,
        Self::RightHand,
        Self::LeftLeg,
        Self::RightLeg,
        Self::Thighs,
        Self::HeadBack,
        Self::Face,
        Self::Front,
        Self::LeftSide,
        Self::RightSide,
        Self::Calves,
        Self::Heels,
        Self::Forearms,
        Self::LegFronts,
    ];

    /// PROX's seven segments.
    pub const PROX: [Self; 7] = [
        Self::Back,
        Self::Butt,
        Self::LeftHand,
        Self::RightHand,
        Self::LeftLeg,
        Self::RightLeg,
        Self::Thighs,
    ];

    /// Name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Back => "back",
            Self::Butt => "butt",
            Self::LeftHand => "left_hand",
            Self::RightHand => "right_hand",
            Self::LeftLeg => "left_leg",
            Self::RightLeg => "right_leg",
            Self::Thighs => "thighs",
            Self::HeadBack => "head_back",
            Self::Face => "face",
            Self::Front => "front",
            Self::LeftSide => "left_side",
            Self::RightSide => "right_side",
            Self::Calves => "calves",
            Self::Heels => "heels",
            Self::Forearms => "forearms",
            Self::LegFronts => "leg_fronts",
        }
    }

    /// Vertices that an even sample of the region has: PROX's own counts for its segments, so that a mean
    /// over contact vertices weighs the regions as the papers' code does.
    fn sample_size(self) -> usize {
        match self {
            Self::Back => 222,
            Self::Butt => 113,
            Self::LeftHand => 261,
            Self::RightHand => 269,
            Self::LeftLeg | Self::RightLeg => 97,
            Self::Thighs => 62,
            Self::Front => 120,
            _ => 60,
        }
    }

    fn holds(self, at: &Site) -> bool {
        let Site { joint, position: p, normal: n } = *at;
        let torso = matches!(
            joint,
            joints::SPINE1
                | joints::SPINE2
                | joints::SPINE3
                | joints::LEFT_COLLAR
                | joints::RIGHT_COLLAR
                | joints::PELVIS
        );
        let hips = matches!(joint, joints::PELVIS | joints::LEFT_HIP | joints::RIGHT_HIP);
        let upper_leg = matches!(joint, joints::LEFT_HIP | joints::RIGHT_HIP);
        let lower_leg = matches!(joint, joints::LEFT_KNEE | joints::RIGHT_KNEE);
        let foot = |ankle, ball| (joint == ankle || joint == ball) && n.y < -0.6;
        // The arms lie along x at rest, palms down.
        let palm =
            |wrist, first: usize| (joint == wrist || (first..first + 15).contains(&joint)) && n.y < -0.35;
        let flank = |sign: f32| {
            (torso || upper_leg) && n.x * sign > 0.75 && p.x * sign > 0.05 && p.y < 0.38 && p.y > -0.36
        };
        match self {
            Self::Back => torso && n.z < -0.55 && p.y > 0.05 && p.y < 0.5,
            Self::Butt => hips && p.y < 0.03 && p.y > -0.17 && p.z < -0.01 && n.dot(BUTT_FACES) > 0.6,
            Self::LeftHand => palm(joints::LEFT_WRIST, joints::LEFT_HAND),
            Self::RightHand => palm(joints::RIGHT_WRIST, joints::RIGHT_HAND),
            Self::LeftLeg => foot(joints::LEFT_ANKLE, joints::LEFT_FOOT),
            Self::RightLeg => foot(joints::RIGHT_ANKLE, joints::RIGHT_FOOT),
            Self::Thighs => upper_leg && n.z < -0.6 && p.y < -0.17 && p.y > -0.34,
            Self::HeadBack => joint == joints::HEAD && n.z < -0.5 && p.y > 0.62,
            Self::Face => joint == joints::HEAD && n.z > 0.4 && p.y < 0.74 && p.z > 0.1,
            Self::Front => torso && n.z > 0.5 && p.y > 0.0 && p.y < 0.48,
            Self::LeftSide => flank(1.0),
            Self::RightSide => flank(-1.0),
            Self::Calves => lower_leg && n.z < -0.6 && p.y < -0.45 && p.y > -0.75,
            Self::Heels => {
                matches!(joint, joints::LEFT_ANKLE | joints::RIGHT_ANKLE) && n.z < -0.5 && p.y < -0.84
            }
            Self::Forearms => matches!(joint, joints::LEFT_ELBOW | joints::RIGHT_ELBOW) && n.y < -0.4,
            Self::LegFronts => (upper_leg || lower_leg) && n.z > 0.6 && p.y < -0.12 && p.y > -0.8,
        }
    }
}

/// Where the seat meets a sitting body, as a direction of the body at rest: behind and below.
const BUTT_FACES: Vec3 = Vec3::new(0.0, -0.5, -0.866);

#[derive(Clone, Copy)]
struct Site {
    joint: usize,
    position: Vec3,
    normal: Vec3,
}

/// The regions of one body model.
#[derive(Clone, Debug)]
pub struct ContactRegions {
    whole: Vec<Vec<u32>>,
    sample: Vec<Vec<u32>>,
}

impl ContactRegions {
    /// Finds the regions of a model at rest. Skips eyes and tongue by their joints.
    pub fn of(model: &BodyModel) -> Self {
        let normals = model.vertex_normals(&model.template);
        let sites: Vec<Site> = (0..model.template.len())
            .map(|v| Site { joint: model.dominant_joint(v), position: model.template[v], normal: normals[v] })
            .collect();
        let of_region =
            |region: Region| (0..sites.len() as u32).filter(|v| region.holds(&sites[*v as usize])).collect();
        let whole: Vec<Vec<u32>> = Region::ALL.into_iter().map(of_region).collect();
        let sample = Region::ALL
            .iter()
            .zip(&whole)
            .map(|(region, ids)| spread_out(&model.template, ids, region.sample_size()))
            .collect();
        Self { whole, sample }
    }

    /// Every vertex of a region, ascending.
    pub fn vertices(&self, region: Region) -> &[u32] {
        &self.whole[region as usize]
    }

    /// An even sample of a region, as many vertices as PROX's segment has (fewer if the region is smaller),
    /// ascending.
    pub fn sample(&self, region: Region) -> &[u32] {
        &self.sample[region as usize]
    }

    /// The samples of PROX's seven segments together: the papers' contact vertices.
    pub fn prox_sample(&self) -> Vec<u32> {
        let mut ids: Vec<u32> =
            Region::PROX.iter().flat_map(|region| self.sample(*region).iter().copied()).collect();
        ids.sort_unstable();
        ids.dedup();
        ids
    }
}

/// Farthest-point sample: each pick is the vertex farthest from those picked before. Ascending.
fn spread_out(positions: &[Vec3], ids: &[u32], count: usize) -> Vec<u32> {
    let mut nearest = vec![f32::INFINITY; ids.len()];
    let mut picked = Vec::with_capacity(count);
    let mut next = 0;
    while picked.len() < count.min(ids.len()) {
        picked.push(ids[next]);
        let from = positions[ids[next] as usize];
        for (distance, id) in nearest.iter_mut().zip(ids) {
            *distance = distance.min(from.distance_squared(positions[*id as usize]));
        }
        next = (0..ids.len()).max_by(|a, b| nearest[*a].total_cmp(&nearest[*b])).unwrap_or(0);
    }
    picked.sort_unstable();
    picked
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Body;

    #[test]
    fn regions_have_the_size_of_the_papers_and_sit_on_the_right_side() {
        let body = Body::bundled();
        for region in Region::ALL {
            let (whole, sample) = (body.regions.vertices(region).len(), body.regions.sample(region).len());
            assert!(sample * 10 >= region.sample_size() * 7, "{}: {sample} of {whole}", region.name());
        }
        let mean = |region| {
            let ids = body.regions.sample(region);
            ids.iter().map(|v| body.model.template[*v as usize]).sum::<Vec3>() / ids.len() as f32
        };
        assert!(mean(Region::LeftHand).x > 0.6 && mean(Region::RightHand).x < -0.6);
        assert!(mean(Region::LeftLeg).y < -0.87 && mean(Region::LeftLeg).x > 0.1);
        assert!(mean(Region::Back).z < -0.06 && mean(Region::Front).z > 0.06);
        assert!(mean(Region::Butt).z < -0.06 && mean(Region::Butt).y < 0.0);
        assert!(mean(Region::Thighs).y < mean(Region::Butt).y);
    }

    #[test]
    fn left_and_right_hold_the_same_share() {
        let body = Body::bundled();
        for (left, right) in [
            (Region::LeftHand, Region::RightHand),
            (Region::LeftLeg, Region::RightLeg),
            (Region::LeftSide, Region::RightSide),
        ] {
            let (l, r) =
                (body.regions.vertices(left).len() as f32, body.regions.vertices(right).len() as f32);
            assert!((l / r - 1.0).abs() < 0.05, "{}: {l} against {r}", left.name());
        }
    }

    #[test]
    fn a_sample_covers_its_region() {
        let body = Body::bundled();
        let at = |v: &u32| body.model.template[*v as usize];
        for v in body.regions.vertices(Region::Back) {
            let nearest = body.regions.sample(Region::Back).iter().map(|s| at(s).distance(at(v)));
            assert!(nearest.fold(f32::INFINITY, f32::min) < 0.04);
        }
    }
}
