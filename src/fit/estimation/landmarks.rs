//! Which points of the body the keypoints of a picture are.

use glam::Vec3;

use crate::assets::KeypointSet;
use crate::body::joints as j;
use crate::body::{BodyModel, VertexSubset, Workspace};

/// One keypoint on the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Landmark {
    /// A joint.
    Joint(usize),
    /// An entry of [`Landmarks::subset`].
    Skin(usize),
}

use Landmark::{Joint, Skin};

/// Entries of the skin points, in this order.
const NOSE: usize = 0;
const LEFT_EAR: usize = 1;
const RIGHT_EAR: usize = 2;
const LEFT_BIG_TOE: usize = 3;
const LEFT_SMALL_TOE: usize = 4;
const LEFT_HEEL: usize = 5;
const RIGHT_BIG_TOE: usize = 6;
const RIGHT_SMALL_TOE: usize = 7;
const RIGHT_HEEL: usize = 8;

const COCO: [Landmark; 17] = [
    Skin(NOSE),
    Joint(j::LEFT_EYE),
    Joint(j::RIGHT_EYE),
    Skin(LEFT_EAR),
    Skin(RIGHT_EAR),
    Joint(j::LEFT_SHOULDER),
    Joint(j::RIGHT_SHOULDER),
    Joint(j::LEFT_ELBOW),
    Joint(j::RIGHT_ELBOW),
    Joint(j::LEFT_WRIST),
    Joint(j::RIGHT_WRIST),
    Joint(j::LEFT_HIP),
    Joint(j::RIGHT_HIP),
    Joint(j::LEFT_KNEE),
    Joint(j::RIGHT_KNEE),
    Joint(j::LEFT_ANKLE),
    Joint(j::RIGHT_ANKLE),
];

const BODY_25: [Landmark; 25] = [
    Skin(NOSE),
    Joint(j::NECK),
    Joint(j::RIGHT_SHOULDER),
    Joint(j::RIGHT_ELBOW),
    Joint(j::RIGHT_WRIST),
    Joint(j::LEFT_SHOULDER),
    Joint(j::LEFT_ELBOW),
    Joint(j::LEFT_WRIST),
    Joint(j::PELVIS),
    Joint(j::RIGHT_HIP),
    Joint(j::RIGHT_KNEE),
    Joint(j::RIGHT_ANKLE),
    Joint(j::LEFT_HIP),
    Joint(j::LEFT_KNEE),
    Joint(j::LEFT_ANKLE),
    Joint(j::RIGHT_EYE),
    Joint(j::LEFT_EYE),
    Skin(RIGHT_EAR),
    Skin(LEFT_EAR),
    Skin(LEFT_BIG_TOE),
    Skin(LEFT_SMALL_TOE),
    Skin(LEFT_HEEL),
    Skin(RIGHT_BIG_TOE),
    Skin(RIGHT_SMALL_TOE),
    Skin(RIGHT_HEEL),
];

/// The keypoints of every set on one body model: joints, and for nose, ears, toes and heels the skin there (as
/// SMPLify-X does, with OpenPose's neck and middle hip at the neck and pelvis joints).
#[derive(Clone, Debug)]
pub struct Landmarks {
    /// The skin points.
    pub subset: VertexSubset,
}

impl Landmarks {
    /// Found by geometry on the model's rest pose.
    pub fn of(model: &BodyModel) -> Self {
        Self { subset: VertexSubset::new(model, skin_points(model).to_vec()) }
    }

    /// What each keypoint of a set is.
    pub fn list(set: KeypointSet) -> &'static [Landmark] {
        match set {
            KeypointSet::Coco17 => &COCO,
            KeypointSet::Body25 => &BODY_25,
        }
    }

    /// Where each keypoint of a set is after a forward pass whose subset begins with [`Landmarks::subset`], world
    /// frame, in the set's order.
    pub fn positions(set: KeypointSet, workspace: &Workspace) -> Vec<Vec3> {
        let at = |landmark: &Landmark| match *landmark {
            Joint(joint) => workspace.joints()[joint],
            Skin(entry) => workspace.vertices()[entry],
        };
        Self::list(set).iter().map(at).collect()
    }
}

fn skin_points(model: &BodyModel) -> [u32; 9] {
    let rest = &model.joint_template;
    // The vertex moved by one of `joints` that goes farthest in a direction.
    let farthest = |joints: &[usize], score: &dyn Fn(Vec3) -> f32| {
        let of = (0..model.template.len()).filter(|v| joints.contains(&model.dominant_joint(*v)));
        let best = of.max_by(|a, b| score(model.template[*a]).total_cmp(&score(model.template[*b])));
        best.unwrap_or(0) as u32
    };
    let head = [j::HEAD, j::JAW];
    // The tip of the nose lies below the eyes and above the mouth.
    let eyes_y = rest[j::LEFT_EYE].y;
    let nose = farthest(&head, &|p| p.z - 2.0 * (p.x.abs() - 0.005).max(0.0) - 2.0 * (p.y - eyes_y).max(0.0));
    // Ears stand out between the heights of eyes and mouth.
    let ear = |sign: f32| {
        farthest(&[j::HEAD], &|p| p.x * sign - 4.0 * ((p.y - eyes_y + 0.02).abs() - 0.02).max(0.0))
    };
    let foot = |ankle: usize, ball: usize, sign: f32| {
        let out = move |p: Vec3| p.x * sign - rest[ball].x.abs();
        let big = farthest(&[ball], &move |p| p.z - 0.6 * out(p));
        let small = farthest(&[ball], &move |p| out(p) + 0.3 * p.z);
        let heel = farthest(&[ankle], &|p| -p.z - 0.5 * p.y);
        [big, small, heel]
    };
    let [big_l, small_l, heel_l] = foot(j::LEFT_ANKLE, j::LEFT_FOOT, 1.0);
    let [big_r, small_r, heel_r] = foot(j::RIGHT_ANKLE, j::RIGHT_FOOT, -1.0);
    [nose, ear(1.0), ear(-1.0), big_l, small_l, heel_l, big_r, small_r, heel_r]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Body;

    #[test]
    fn noses_ears_toes_and_heels_are_where_people_have_them() {
        let model = &Body::bundled().model;
        let rest = &model.joint_template;
        let at = skin_points(model).map(|v| model.template[v as usize]);
        let (eye, ankle) = (rest[j::LEFT_EYE], rest[j::LEFT_ANKLE]);
        let nose = at[NOSE];
        assert!(nose.x.abs() < 0.006 && nose.z > eye.z && nose.y < eye.y && nose.y > eye.y - 0.07, "{nose}");
        assert!(at[LEFT_EAR].x > 0.06 && at[LEFT_EAR].z < eye.z - 0.03, "{}", at[LEFT_EAR]);
        assert!((at[LEFT_EAR].y - eye.y).abs() < 0.06, "{} beside {eye}", at[LEFT_EAR]);
        assert!(at[LEFT_BIG_TOE].z > ankle.z + 0.12 && at[LEFT_HEEL].z < ankle.z, "{at:?}");
        assert!(at[LEFT_SMALL_TOE].x > at[LEFT_BIG_TOE].x + 0.03, "{at:?}");
        for (left, right) in [(LEFT_EAR, RIGHT_EAR), (LEFT_BIG_TOE, RIGHT_BIG_TOE), (LEFT_HEEL, RIGHT_HEEL)] {
            let mirrored = at[right] * Vec3::new(-1.0, 1.0, 1.0);
            assert!(at[left].distance(mirrored) < 0.015, "{} and {}", at[left], at[right]);
        }
    }

    #[test]
    fn left_and_right_are_told_apart_in_both_sets() {
        for (set, left_wrist, right_wrist) in [(KeypointSet::Coco17, 9, 10), (KeypointSet::Body25, 7, 4)] {
            let list = Landmarks::list(set);
            assert_eq!(list.len(), set.len());
            assert_eq!(list[left_wrist], Joint(j::LEFT_WRIST));
            assert_eq!(list[right_wrist], Joint(j::RIGHT_WRIST));
        }
    }
}
