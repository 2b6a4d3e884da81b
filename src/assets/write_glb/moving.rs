use glam::{Affine3A, Mat4, Quat, Vec3};

use super::GlbWriteError;
use super::buffer::{GlbBuilder, Layout};
use super::json;
use super::motion::unit;
use crate::assets::Model;

/// Where an object of a model is at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObjectKey {
    /// Seconds.
    pub at_s: f32,
    /// Its origin, metres.
    pub translation_m: Vec3,
    /// Its turn.
    pub rotation: Quat,
}

/// How an object of a model moves: straight from key to key.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectMotion {
    /// [`crate::assets::Part::node`] of its parts.
    pub node: usize,
    /// Its frame as it lies in the model; the keys say how that frame moves.
    pub model_from_object: Affine3A,
    /// Its places at rising times.
    pub keys: Vec<ObjectKey>,
    /// Not to be seen before, seconds: until then its scale is zero.
    pub comes_s: Option<f32>,
}

/// Hangs the objects that move below nodes of their own and adds their channels to the animation. `roots` are the
/// model's root nodes, one for each of its objects in the order in which they first appear.
pub(super) fn add_objects(
    builder: &mut GlbBuilder,
    animation: &mut json::Animation,
    model: &Model,
    roots: &mut [usize],
    motions: &[ObjectMotion],
) -> Result<(), GlbWriteError> {
    let mut order: Vec<usize> = Vec::new();
    for part in &model.parts {
        if !order.contains(&part.node) {
            order.push(part.node);
        }
    }
    for motion in motions {
        let count = order.len();
        let what = || format!("object {}", motion.node);
        let Some(index) = order.iter().position(|node| *node == motion.node) else {
            return Err(GlbWriteError::OutOfRange { what: what(), array: "node", index: motion.node, count });
        };
        if motion
            .keys
            .iter()
            .any(|k| !k.translation_m.is_finite() || !k.rotation.is_finite() || !k.at_s.is_finite())
        {
            return Err(GlbWriteError::NotFinite { what: what(), array: "motion" });
        }
        roots[index] = hang(builder, roots[index], motion);
        add_channels(builder, animation, roots[index], motion);
    }
    Ok(())
}

/// A node above `below` that stands where the object does; what is below is placed against it.
fn hang(builder: &mut GlbBuilder, below: usize, motion: &ObjectMotion) -> usize {
    let object_from_model = Mat4::from(motion.model_from_object.inverse());
    let node = &mut builder.root.nodes[below];
    let matrix = node.matrix.map_or(Mat4::IDENTITY, |m| Mat4::from_cols_array(&m));
    node.matrix = Some((object_from_model * matrix).to_cols_array());
    let (_, rotation, at) = motion.model_from_object.to_scale_rotation_translation();
    let above = json::Node {
        name: format!("{} moves", node.name),
        translation: Some(at.to_array()),
        rotation: Some(unit(rotation).to_array()),
        children: vec![below],
        ..json::Node::default()
    };
    builder.root.nodes.push(above);
    builder.root.nodes.len() - 1
}

fn add_channels(
    builder: &mut GlbBuilder,
    animation: &mut json::Animation,
    node: usize,
    motion: &ObjectMotion,
) {
    let mut channel = |input, output, path, interpolation| {
        animation.samplers.push(json::AnimationSampler { input, output, interpolation });
        let sampler = animation.samplers.len() - 1;
        animation.channels.push(json::Channel { sampler, target: json::ChannelTarget { node, path } });
    };
    let layout = |kind| Layout { target: None, ..Layout::floats(kind) };
    // Times must rise: of keys at the same time the last counts.
    let mut keys: Vec<ObjectKey> = Vec::with_capacity(motion.keys.len());
    for key in &motion.keys {
        keys.retain(|k| k.at_s < key.at_s);
        keys.push(*key);
    }
    if keys.len() > 1 {
        let input = builder.times(&keys.iter().map(|k| k.at_s).collect::<Vec<_>>());
        let at: Vec<Vec3> = keys.iter().map(|k| k.translation_m).collect();
        channel(input, builder.array(&at, layout("VEC3")), "translation", "LINEAR");
        let mut turns: Vec<Quat> = Vec::with_capacity(keys.len());
        for key in &keys {
            let turn = unit(key.rotation);
            let flips = turns.last().is_some_and(|last| last.dot(turn) < 0.0);
            turns.push(if flips { -turn } else { turn });
        }
        let turns: Vec<[f32; 4]> = turns.iter().map(glam::Quat::to_array).collect();
        channel(input, builder.array(&turns, layout("VEC4")), "rotation", "LINEAR");
    }
    if let Some(comes_s) = motion.comes_s.filter(|s| *s > 0.0) {
        let input = builder.times(&[0.0, comes_s]);
        let output = builder.array(&[Vec3::ZERO, Vec3::ONE], layout("VEC3"));
        channel(input, output, "scale", "STEP");
    }
}
