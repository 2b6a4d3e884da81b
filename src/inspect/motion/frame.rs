//! One frame by itself.

use glam::Vec3;
use serde::Serialize;

use crate::body::joints::BODY_JOINTS;
use crate::body::{Body, Feet, TREADS, VertexSubset, Workspace};
use crate::inspect::{CONTACT_M, mean_distance_mm};
use crate::scene::{BETAS, Frame, SignedDistanceField};

/// A vertex deeper than this is seen to be inside something: more than a cushion or a mattress gives way.
pub const DEEP_MM: f32 = 25.0;

/// Pelvis and the 21 body joints.
pub(super) type BodyJoints = [Vec3; BODY_JOINTS + 1];

/// What was measured of one frame: what a timeline shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct FrameRecord {
    /// Share of vertices in free space (PSI §4.1.4).
    pub non_collision: f32,
    /// Whether some vertex has a signed distance of zero or less (PSI §4.1.4).
    pub psi_contact: bool,
    /// Whether some contact vertex is within [`CONTACT_M`] of a surface or in something solid.
    pub contact: bool,
    /// Deepest vertex in solid matter, millimetres.
    pub penetration_max_mm: f32,
    /// Mean depth of the penetrating vertices, millimetres.
    pub penetration_mean_mm: f32,
    /// Whether the left and the right foot is planted.
    pub planted: [bool; 2],
    /// Speed along the floor of each planted foot, 0 for one that is not, cm/s.
    pub skate_cm_per_s: [f32; 2],
    /// Height of the planted foot that is highest above what is under it, millimetres.
    pub hover_mm: f32,
    /// Vertices outside the distance field: never free space.
    pub outside_field: usize,
    /// Vertices that are not finite.
    pub not_finite: usize,
}

/// A record with what the clip's metrics need besides.
pub(super) struct Measured {
    pub record: FrameRecord,
    pub joints: BodyJoints,
    pub treads: [[Vec3; TREADS]; 2],
    pub penetrating: usize,
    pub depth_sum_mm: f64,
}

impl Measured {
    /// Whether a foot is planted in a frame that can be measured.
    pub fn is_planted(&self, side: usize) -> bool {
        self.record.planted[side] && self.record.not_finite == 0
    }
}

/// Measures frames of one body shape in one room.
pub(super) struct FrameMeter<'a> {
    body: &'a Body,
    field: &'a SignedDistanceField,
    betas: &'a [f32; BETAS],
    skin: VertexSubset,
    /// PROX's contact vertices.
    contact: Vec<u32>,
    feet: Feet,
}

impl<'a> FrameMeter<'a> {
    pub fn new(body: &'a Body, field: &'a SignedDistanceField, betas: &'a [f32; BETAS]) -> Self {
        Self {
            body,
            field,
            betas,
            skin: VertexSubset::all_of_shape(&body.model, betas),
            contact: body.regions.prox_sample(),
            feet: Feet::of(body, betas),
        }
    }

    fn pose(&self, frame: &Frame, workspace: &mut Workspace) {
        self.body.forward_posed(&frame.params(self.betas), &frame.pose, &self.skin, workspace);
    }

    /// Everything about one frame but the speed of its feet.
    pub fn measure(&self, frame: &Frame, planted: [bool; 2], workspace: &mut Workspace) -> Measured {
        self.pose(frame, workspace);
        let vertices = workspace.vertices();
        let mut record = FrameRecord { planted, ..FrameRecord::default() };
        record.not_finite = vertices.iter().filter(|v| !v.is_finite()).count();
        let joints = std::array::from_fn(|j| workspace.joints()[j]);
        let treads = self.feet.positions(workspace.joints(), workspace.world_rotations());
        if record.not_finite > 0 {
            return Measured { record, joints, treads, penetrating: 0, depth_sum_mm: 0.0 };
        }
        let distances: Vec<f32> = vertices.iter().map(|v| self.field.sample(*v)).collect();
        record.outside_field = vertices.iter().filter(|v| !self.field.contains(**v)).count();
        let free = distances.iter().filter(|d| **d > 0.0).count();
        record.non_collision = free as f32 / distances.len().max(1) as f32;
        record.psi_contact = free < distances.len();
        record.contact = self.contact.iter().any(|v| distances[*v as usize] <= CONTACT_M);
        let depths = || distances.iter().filter(|d| **d < 0.0).map(|d| -d * 1e3);
        let (penetrating, depth_sum_mm) = (depths().count(), depths().map(f64::from).sum::<f64>());
        record.penetration_max_mm = depths().fold(0.0, f32::max);
        record.penetration_mean_mm = (depth_sum_mm / penetrating.max(1) as f64) as f32;
        record.hover_mm = self.hover_mm(planted, &treads);
        Measured { record, joints, treads, penetrating, depth_sum_mm }
    }

    fn hover_mm(&self, planted: [bool; 2], treads: &[[Vec3; TREADS]; 2]) -> f32 {
        let gap = |foot: &[Vec3; TREADS]| {
            foot.iter().map(|p| self.field.sample(*p)).fold(f32::INFINITY, f32::min).max(0.0) * 1e3
        };
        planted
            .iter()
            .zip(treads)
            .filter(|(planted, _)| **planted)
            .map(|(_, foot)| gap(foot))
            .fold(0.0, f32::max)
    }

    /// Mean distance of the vertices of two frames, metres.
    pub fn distance_m(&self, a: &Frame, b: &Frame) -> f32 {
        let mut workspace = Workspace::default();
        self.pose(a, &mut workspace);
        let first = workspace.vertices().to_vec();
        self.pose(b, &mut workspace);
        mean_distance_mm(&first, workspace.vertices()) * 1e-3
    }
}
