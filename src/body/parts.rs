//! What each vertex is painted as: people are dressed by body region. Seams are signed distances that vary
//! smoothly over the skin, so a renderer can draw them straight through triangles.

use glam::Vec3;

use super::joints;
use super::model::BodyModel;

/// What a point of the body shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BodyPart {
    /// Bare skin.
    Skin,
    /// Hair of the head.
    Hair,
    /// Shirt with half sleeves.
    Shirt,
    /// Long trousers.
    Trousers,
    /// Shoes.
    Shoes,
    /// White of the eyes.
    Eyes,
    /// Iris and pupil.
    Iris,
}

impl BodyPart {
    /// Every part.
    pub const ALL: [Self; 7] =
        [Self::Skin, Self::Hair, Self::Shirt, Self::Trousers, Self::Shoes, Self::Eyes, Self::Iris];
}

/// Signed distance in metres to the seam of each garment along the skin, positive inside it:
/// shoes, trousers, shirt, hair; on an eyeball the last is the distance inside the iris. Interpolate over a
/// triangle, then ask [`part_at`].
pub type Seams = [f32; 4];

/// The part of a point: its garments in the order shoes over trousers over shirt over hair, else `bare`.
pub fn part_at(seams: &Seams, bare: BodyPart) -> BodyPart {
    if bare == BodyPart::Eyes {
        return if seams[3] > 0.0 { BodyPart::Iris } else { bare };
    }
    let worn = [BodyPart::Shoes, BodyPart::Trousers, BodyPart::Shirt, BodyPart::Hair];
    seams.iter().zip(worn).find(|(inside, _)| **inside > 0.0).map_or(bare, |(_, part)| part)
}

/// The parts of one body model.
#[derive(Clone, Debug)]
pub struct BodyParts {
    /// Seam distances of each vertex.
    pub seams: Vec<Seams>,
    /// What each vertex is without clothes: skin or eyes.
    pub bare: Vec<BodyPart>,
}

impl BodyParts {
    /// Dresses a model by its rest pose.
    pub fn of(model: &BodyModel) -> Self {
        let rest = &model.joint_template;
        let bare: Vec<BodyPart> = (0..model.template.len()).map(|v| bare_part(model, v)).collect();
        let seams = model.template.iter().enumerate().map(|(v, p)| match bare[v] {
            BodyPart::Eyes => {
                let off_axis = (*p - rest[model.dominant_joint(v)]).truncate().length();
                [-1.0, -1.0, -1.0, IRIS_RADIUS_M - off_axis]
            }
            _ => seams_at(*p, rest),
        });
        Self { seams: seams.collect(), bare }
    }

    /// The part of a vertex.
    pub fn part_of(&self, vertex: usize) -> BodyPart {
        part_at(&self.seams[vertex], self.bare[vertex])
    }
}

fn bare_part(model: &BodyModel, vertex: usize) -> BodyPart {
    let joint = model.dominant_joint(vertex);
    let from_joint = model.template[vertex] - model.joint_template[joint];
    match joint {
        // Lids and brows move with the eyes too but stand farther off than the ball's radius.
        joints::LEFT_EYE | joints::RIGHT_EYE if from_joint.length() < EYEBALL_RADIUS_M => BodyPart::Eyes,
        _ => BodyPart::Skin,
    }
}

/// Radius of an eyeball with its cornea, at the model's mean.
const EYEBALL_RADIUS_M: f32 = 0.018;
/// A human iris is about 12 mm across.
const IRIS_RADIUS_M: f32 = 0.006;
/// Ears stand farther out than the skull above them.
const SKULL_HALF_WIDTH_M: f32 = 0.079;

fn seams_at(p: Vec3, rest: &[Vec3; joints::JOINTS]) -> Seams {
    let ankle_y = rest[joints::LEFT_ANKLE].y;
    let waist_y = rest[joints::SPINE1].y - 0.02;
    // Collars: a ball around the middle of the neck, a little forward so that the front runs lower.
    let neck = rest[joints::NECK] + Vec3::new(0.0, 0.035, 0.03);
    let sleeve_x = 0.45 * rest[joints::LEFT_SHOULDER].x + 0.55 * rest[joints::LEFT_ELBOW].x;
    let below_chin = rest[joints::NECK].y + 0.01 - p.y;
    let below_collar = (p.distance(neck) - COLLAR_RADIUS_M).min(below_chin);
    [
        ankle_y + 0.01 - p.y,
        waist_y - p.y,
        below_collar.min(sleeve_x - p.x.abs()),
        hair_inside(p - rest[joints::HEAD]),
    ]
}

/// Half the width of a crew neck.
const COLLAR_RADIUS_M: f32 = 0.098;

/// Distance inside the hairline of a point given from the head joint: above the plane that runs from the
/// forehead over the ears to the nape.
fn hair_inside(from_head: Vec3) -> f32 {
    let (forehead, nape) = (Vec3::new(0.0, 0.115, 0.085), Vec3::new(0.0, -0.035, -0.09));
    let along = nape - forehead;
    let up_and_back = Vec3::new(0.0, -along.z, along.y).normalize_or(Vec3::Y);
    (from_head - nape).dot(up_and_back).min(SKULL_HALF_WIDTH_M - from_head.x.abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::Body;

    fn parts_where(at: impl Fn(Vec3) -> bool) -> Vec<BodyPart> {
        let body = Body::bundled();
        let mut parts: Vec<BodyPart> = (0..body.model.template.len())
            .filter(|v| at(body.model.template[*v]))
            .map(|v| body.parts.part_of(v))
            .collect();
        parts.dedup();
        parts
    }

    #[test]
    fn nobody_is_naked() {
        let dressed = |p: Vec3| p.y < 0.4 && p.x.abs() < 0.3;
        let parts = parts_where(dressed);
        assert!(!parts.contains(&BodyPart::Skin) && !parts.contains(&BodyPart::Hair), "{parts:?}");
    }

    #[test]
    fn soles_are_shoes_hands_are_skin_and_the_crown_is_hair() {
        assert_eq!(parts_where(|p| p.y < -0.87), [BodyPart::Shoes]);
        assert_eq!(parts_where(|p| p.x.abs() > 0.6), [BodyPart::Skin]);
        assert_eq!(parts_where(|p| p.y > 0.765), [BodyPart::Hair]);
        assert_eq!(parts_where(|p| (p.y - 0.62).abs() < 0.02 && p.z > 0.12), [BodyPart::Skin]);
    }
}
