//! A clip as the plain motions that the writers of other programs' files take.

use glam::{Mat3, Quat, Vec3};

use super::Body;
use super::export::skinned_mesh;
use super::joints::{HEAD, JAW, JOINTS, LEFT_HAND, NAMES, PARENTS};
use crate::assets::{AMASS_JOINTS, AmassMotion, RigJoint, RigMotion, SkinMotion, SkinnedMesh};
use crate::scene::{Clip, Frame};

/// How far the skull reaches above the head's joint, for the tip of its bone, metres.
const SKULL_M: f32 = 0.17;

/// The person of `clip` as bind mesh, skin, skeleton and motion in the world frame; the skeleton stands as in the
/// first frame. `None` for a clip without frames.
///
/// `colors` are sRGB with alpha, one per vertex, or empty. What the motion was made from goes along as extras:
/// `{"clip": {name, fps, frames, betas, seed}}`.
pub fn skinned_clip(body: &Body, clip: &Clip, colors: Vec<[u8; 4]>) -> Option<SkinnedMesh> {
    let first = clip.frames.first()?;
    let mut mesh = skinned_mesh(body, &clip.name, &first.params(&clip.betas), colors);
    for (joint, turn) in mesh.skeleton.iter_mut().zip(local_rotations(body, first)) {
        joint.rotation = turn;
    }
    let (name, frames) = (&clip.name, clip.frames.len());
    let about = serde_json::json!({
        "clip": { "name": name, "fps": clip.fps, "frames": frames, "betas": clip.betas, "seed": clip.seed }
    });
    mesh.extras = Some(about.to_string());
    mesh.motion = Some(SkinMotion {
        fps: clip.fps,
        translations_m: clip.frames.iter().map(|frame| frame.translation).collect(),
        rotations: clip.frames.iter().map(|frame| local_rotations(body, frame)).collect(),
    });
    Some(mesh)
}

/// The clip on the body's own skeleton, without jaw and eyes, which it never moves; metres.
pub fn rig_motion(body: &Body, clip: &Clip) -> RigMotion {
    let rest = body.model.rest_joints(&clip.betas);
    let kept: Vec<usize> = (0..JOINTS).filter(|joint| !(JAW..LEFT_HAND).contains(joint)).collect();
    let place = |joint: usize| kept.iter().position(|k| *k == joint);
    let joint = |joint: usize| RigJoint {
        name: NAMES[joint].to_owned(),
        parent: if joint == 0 { None } else { place(PARENTS[joint]) },
        offset: if joint == 0 { Vec3::ZERO } else { rest[joint] - rest[PARENTS[joint]] },
        tip: (joint == HEAD).then_some(Vec3::Y * SKULL_M),
    };
    let turns = |frame: &Frame| {
        let all = local_rotations(body, frame);
        kept.iter().map(|joint| all[*joint]).collect()
    };
    RigMotion {
        name: clip.name.clone(),
        joints: kept.iter().map(|k| joint(*k)).collect(),
        frame_seconds: clip.fps.recip(),
        root: clip.frames.iter().map(|frame| rest[0] + frame.translation).collect(),
        rotations: clip.frames.iter().map(turns).collect(),
    }
}

/// The clip on SMPL+H's joints.
pub fn amass_motion(body: &Body, clip: &Clip) -> AmassMotion {
    let pose = |frame: &Frame| {
        let hands = body.hand_space.decode(&frame.hands);
        let mut joints = frame.pose.iter().chain(hands.as_flattened()).copied();
        [(); AMASS_JOINTS - 1].map(|()| joints.next().unwrap_or_default())
    };
    AmassMotion {
        fps: clip.fps,
        betas: clip.betas.to_vec(),
        pelvis_rest_m: body.model.rest_joints(&clip.betas)[0],
        translations_m: clip.frames.iter().map(|frame| frame.translation).collect(),
        roots: clip.frames.iter().map(|frame| frame.rotation).collect(),
        poses: clip.frames.iter().map(pose).collect(),
    }
}

/// Rotation of all 55 joints in their parents' frames; the root's is world from body.
fn local_rotations(body: &Body, frame: &Frame) -> Vec<Quat> {
    let hands = body.hand_space.decode(&frame.hands);
    let turn = |joint: usize| match joint {
        0 => Quat::from_mat3(&Mat3::from_quat(frame.rotation)),
        1..JAW => Quat::from_scaled_axis(frame.pose[joint - 1]),
        JAW..LEFT_HAND => Quat::IDENTITY,
        _ => Quat::from_scaled_axis(hands.as_flattened()[joint - LEFT_HAND]),
    };
    (0..JOINTS).map(turn).collect()
}

#[cfg(test)]
mod tests {
    use glam::Mat4;

    use super::*;
    use crate::assets::npz::Npz;
    use crate::assets::{glb_from_skinned, read_bvh, write_bvh};
    use crate::scene::{BETAS, FRAME_JOINTS, HANDS};

    fn wave(i: usize, swing: f32) -> f32 {
        swing * (i as f32 * 1.7).sin()
    }

    fn clip() -> Clip {
        let frame = |f: usize| Frame {
            translation: Vec3::new(0.03 * f as f32, 0.9 + wave(f, 0.02), -2.5),
            rotation: Quat::from_rotation_y(0.05 * f as f32) * Quat::from_rotation_x(wave(f, 0.3)),
            pose: std::array::from_fn::<Vec3, FRAME_JOINTS, _>(|j| {
                Vec3::new(wave(f + j, 0.6), wave(f + 3 * j, 0.3), wave(f + 7 * j, 0.4))
            }),
            hands: std::array::from_fn::<f32, HANDS, _>(|i| wave(f + i, 0.5)),
        };
        Clip {
            name: "Ada".to_owned(),
            betas: std::array::from_fn::<f32, BETAS, _>(|i| wave(i, 1.5)),
            frames: (0..20).map(frame).collect(),
            ..Clip::default()
        }
    }

    /// World matrices of the file's nodes at key `frame` of its animation.
    fn posed_nodes(glb: &gltf::Gltf, frame: usize) -> Vec<Mat4> {
        let blob = glb.blob.as_deref().expect("a binary chunk");
        let mut local: Vec<(Vec3, Quat)> = glb
            .nodes()
            .map(|node| {
                let (t, r, _) = node.transform().decomposed();
                (Vec3::from(t), Quat::from_array(r))
            })
            .collect();
        for channel in glb.animations().next().expect("an animation").channels() {
            let node = channel.target().node().index();
            match channel.reader(|_| Some(blob)).read_outputs().expect("outputs") {
                gltf::animation::util::ReadOutputs::Translations(mut places) => {
                    local[node].0 = places.nth(frame).expect("the frame").into();
                }
                gltf::animation::util::ReadOutputs::Rotations(turns) => {
                    local[node].1 = Quat::from_array(turns.into_f32().nth(frame).expect("the frame"));
                }
                _ => panic!("another path"),
            }
        }
        let mut world = vec![Mat4::IDENTITY; local.len()];
        for node in glb.nodes() {
            let (t, r) = local[node.index()];
            world[node.index()] *= Mat4::from_rotation_translation(r, t);
            node.children().for_each(|child| world[child.index()] = world[node.index()]);
        }
        world
    }

    #[test]
    fn an_exported_walk_shows_every_frame_where_the_program_does_to_a_tenth_of_a_millimetre() {
        let (body, clip) = (Body::bundled(), clip());
        let file = glb_from_skinned(&skinned_clip(body, &clip, Vec::new()).expect("frames")).expect("writes");
        let glb = gltf::Gltf::from_slice(&file).expect("a valid GLB");
        let blob = glb.blob.as_deref();
        let skin = glb.skins().next().expect("a skin");
        let inverse: Vec<_> =
            skin.reader(|_| blob).read_inverse_bind_matrices().expect("bind matrices").collect();
        let primitive = glb.meshes().next().and_then(|m| m.primitives().next()).expect("a primitive");
        let reader = primitive.reader(|_| blob);
        let joints: Vec<_> = reader.read_joints(0).expect("joints").into_u16().collect();
        let weights: Vec<_> = reader.read_weights(0).expect("weights").into_f32().collect();
        let positions: Vec<_> = reader.read_positions().expect("positions").map(Vec3::from).collect();
        for frame in [0, 7, 19] {
            let world = posed_nodes(&glb, frame);
            let bones: Vec<Mat4> = skin
                .joints()
                .zip(&inverse)
                .map(|(joint, inverse)| world[joint.index()] * Mat4::from_cols_array_2d(inverse))
                .collect();
            let posed = body.pose_frame(&clip.betas, &clip.frames[frame]).vertices;
            for v in (0..posed.len()).step_by(41) {
                let pull = |k: usize| {
                    bones[usize::from(joints[v][k])].transform_point3(positions[v]) * weights[v][k]
                };
                let shown: Vec3 = (0..4).map(pull).sum();
                assert!(shown.distance(posed[v]) < 1e-4, "frame {frame}, vertex {v}");
            }
        }
    }

    #[test]
    fn the_bvh_file_moves_every_joint_as_the_body_does() {
        let (body, clip) = (Body::bundled(), clip());
        let read = read_bvh("ada.bvh", "ada", &write_bvh(&rig_motion(body, &clip))).expect("a BVH file");
        assert_eq!(read.joints.len(), JOINTS - 3);
        for frame in [0, 11, 19] {
            let posed = body.pose_frame(&clip.betas, &clip.frames[frame]);
            let turns = read.world_rotations(frame);
            let mut places: Vec<Vec3> = Vec::new();
            for (i, joint) in read.joints.iter().enumerate() {
                let at = joint.parent.map_or(read.root[frame], |p| places[p] + turns[p] * joint.offset);
                places.push(at);
                let ours = NAMES.iter().position(|name| *name == joint.name).expect("one of our joints");
                assert!(at.distance(posed.joints[ours]) < 1e-3, "frame {frame}, {} ({i})", joint.name);
            }
        }
    }

    #[test]
    fn an_amass_archive_poses_the_same_joints_in_a_world_whose_z_is_up() {
        let (body, clip) = (Body::bundled(), clip());
        let npz = amass_motion(body, &clip).to_npz().expect("writes");
        let npz = Npz::from_bytes("clip.npz", &npz).expect("reads");
        let (_, poses) = npz.floats("poses", &[Some(20), Some(156)]).expect("poses");
        let (_, trans) = npz.floats("trans", &[Some(20), Some(3)]).expect("trans");
        let frame = 13;
        let vector = |numbers: &[f32], at: usize| Vec3::from_slice(&numbers[3 * at..]);
        let read = Frame {
            translation: vector(&trans, frame),
            rotation: Quat::from_scaled_axis(vector(&poses, 52 * frame)),
            pose: std::array::from_fn(|j| vector(&poses, 52 * frame + 1 + j)),
            hands: clip.frames[frame].hands,
        };
        let there = body.pose_frame(&clip.betas, &read).joints;
        let here = body.pose_frame(&clip.betas, &clip.frames[frame]).joints;
        for (there, here) in there.iter().zip(&here) {
            assert!(there.distance(Vec3::new(here.x, -here.z, here.y)) < 1e-4);
        }
        let hand = body.hand_space.decode(&clip.frames[frame].hands)[1][14];
        assert!(vector(&poses, 52 * frame + 51).distance(hand) < 1e-6, "the last joint is the right thumb's");
    }

    #[test]
    fn a_plan_without_frames_is_no_motion() {
        assert!(skinned_clip(Body::bundled(), &Clip::default(), Vec::new()).is_none());
    }
}
