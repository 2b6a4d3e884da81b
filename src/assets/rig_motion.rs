use glam::{Quat, Vec3};

/// A joint of a captured skeleton.
#[derive(Clone, Debug, PartialEq)]
pub struct RigJoint {
    /// The file's name for it.
    pub name: String,
    /// The joint above it, which stands earlier in the list; `None` for the root.
    pub parent: Option<usize>,
    /// From the parent at rest, in the file's unit.
    pub offset: Vec3,
    /// Where the bone ends, from this joint at rest, when no child says it.
    pub tip: Option<Vec3>,
}

/// A motion on whatever skeleton its file has, before it is carried over to the body's 55 joints.
///
/// Y up; at rest (no rotation anywhere) the figure faces +Z with its left towards +X, as the body does.
/// Lengths are in the file's own unit, which most formats leave open.
#[derive(Clone, Debug, PartialEq)]
pub struct RigMotion {
    /// Where it comes from, such as the file's name without its ending.
    pub name: String,
    /// The skeleton, parents before children, the root first.
    pub joints: Vec<RigJoint>,
    /// Time from frame to frame, seconds.
    pub frame_seconds: f32,
    /// For each frame the root's position.
    pub root: Vec<Vec3>,
    /// For each frame the rotation of every joint in its parent's frame.
    pub rotations: Vec<Vec<Quat>>,
}

impl RigMotion {
    /// The joint of a name, upper and lower case alike.
    pub fn joint(&self, name: &str) -> Option<usize> {
        self.joints.iter().position(|joint| joint.name.eq_ignore_ascii_case(name))
    }

    /// World rotation of every joint in a frame: world from the joint's rest frame.
    pub fn world_rotations(&self, frame: usize) -> Vec<Quat> {
        let mut world: Vec<Quat> = Vec::with_capacity(self.joints.len());
        for (joint, local) in self.joints.iter().zip(&self.rotations[frame]) {
            world.push(joint.parent.map_or(*local, |p| world[p] * *local));
        }
        world
    }

    /// Position of every joint at rest, from the root.
    pub fn rest_positions(&self) -> Vec<Vec3> {
        let mut positions: Vec<Vec3> = Vec::with_capacity(self.joints.len());
        for joint in &self.joints {
            positions.push(joint.parent.map_or(Vec3::ZERO, |p| positions[p] + joint.offset));
        }
        positions
    }
}
