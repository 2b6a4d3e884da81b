//! What the networks of PSI are given, as plain numbers, and how it becomes tensors.

use burn::tensor::{Device, Int, Tensor, TensorData};
use glam::{Mat3, Vec3};

use super::config::{CLASSES, FLOOR_PLANE, IMAGE, PsiConfig, Semantics, Stem};
use crate::nn::graph::tensor;

/// Deepest depth that counts, metres (published code: clipped at 6).
pub const CLIP_M: f32 = 6.0;

/// Matterport3D's number (mpcat40) of each label: the paper's scalar semantics knows no finer ones. Kinds of
/// table count as table, an island as counter.
pub const MPCAT40: [u8; CLASSES] = {
    let mut numbers = [0; CLASSES];
    let mut label = 0;
    while label < CLASSES {
        numbers[label] = match label {
            41..=43 => 5,
            44 => 26,
            45 => 41,
            coarse => coarse as u8,
        };
        label += 1;
    }
    numbers
};

/// Floor, in Matterport3D's numbers and in ours.
const FLOOR_LABEL: u8 = 2;
/// A plane needs this many pixels: a patch of 8 by 8.
const FLOOR_PIXELS: usize = 64;
/// Inverse depths that differ by more than this (1/m: 3 cm at 2 m) are not of the same floor.
const FLOOR_TOLERANCE: f32 = 0.008;

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ValidArea {
    /// First column.
    pub left: usize,
    /// First row.
    pub top: usize,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

impl ValidArea {
    /// Whether pixel `at`, counted row by row, lies inside.
    pub fn contains(&self, at: usize) -> bool {
        let (x, y) = (at % IMAGE, at / IMAGE);
        (self.left..self.left + self.width).contains(&x) && (self.top..self.top + self.height).contains(&y)
    }
}

/// One picture of a scene, 128x128, and the two numbers of π.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneInput {
    /// Depth along the axis in metres, row by row from the top; 0 where nothing is.
    pub depth_m: Vec<f32>,
    /// Class of each pixel, less than [`super::CLASSES`]; 0 where nothing is.
    pub labels: Vec<u8>,
    /// Where the picture is not padding.
    pub valid: ValidArea,
    /// The picture's largest depth after clipping: max_d of π.
    pub max_depth_m: f32,
    /// `s f` of π: normalised x is this times x / z.
    pub focal: f32,
}

impl SceneInput {
    /// The translation `t` of camera coordinates (metres, z forward) as π normalises it to [-1, 1].
    pub fn normalize(&self, t: [f32; 3]) -> [f32; 3] {
        let scale = self.focal / (t[2] + 1e-6);
        [t[0] * scale, t[1] * scale, 2.0 * t[2] / self.max_depth_m - 1.0]
    }

    /// The inverse of [`SceneInput::normalize`].
    pub fn denormalize(&self, n: [f32; 3]) -> [f32; 3] {
        let z = (n[2] + 1.0) * 0.5 * self.max_depth_m;
        let scale = (z + 1e-6) / self.focal;
        [n[0] * scale, n[1] * scale, z]
    }
}

/// A batch of pictures as tensors.
#[derive(Clone)]
pub struct SceneTensors {
    /// Depth, mask and scalar semantics: `[batch, channels, 128, 128]`, or `[batch * places, pixels of a
    /// patch * channels]` for a stem of patches.
    pub(super) pixels: Pixels,
    /// Classes in the order of the pixels, `[batch, 128 * 128]`.
    pub(super) labels: Option<Tensor<2, Int>>,
    /// `[batch, view numbers]`: largest depth over its clip and focal length of π, then the floor's plane, as configured;
    /// `None` for networks that are given the picture alone.
    pub(super) camera: Option<Tensor<2>>,
    /// Pictures.
    pub(super) batch: usize,
}

/// Pixels in the layout that the stem wants.
#[derive(Clone)]
pub(super) enum Pixels {
    /// `[batch, channels, 128, 128]`.
    Planes(Tensor<4>),
    /// `[batch * places, side * side * channels]`.
    Patches(Tensor<2>),
}

impl SceneTensors {
    /// Puts pictures on a device as `config` wants them.
    pub fn new(config: &PsiConfig, scenes: &[&SceneInput], device: &Device) -> Self {
        let batch = scenes.len();
        let channels = plain_channels(config);
        let order = pixel_order(config.trunk.stem);
        let mut labels: Vec<i32> = Vec::with_capacity(batch * IMAGE * IMAGE);
        let mut values = Vec::with_capacity(batch * channels * IMAGE * IMAGE);
        for scene in scenes {
            let planes = planes(config, scene);
            match config.trunk.stem {
                Stem::Conv7 => planes.iter().for_each(|plane| values.extend_from_slice(plane)),
                Stem::Patches(_) => {
                    for pixel in &order {
                        values.extend(planes.iter().map(|plane| plane[*pixel as usize]));
                    }
                }
            }
            labels.extend(order.iter().map(|pixel| i32::from(scene.labels[*pixel as usize])));
        }
        let pixels = match config.trunk.stem {
            Stem::Conv7 => Pixels::Planes(tensor(values, [batch, channels, IMAGE, IMAGE], device)),
            Stem::Patches(side) => {
                let places = (IMAGE / side) * (IMAGE / side);
                Pixels::Patches(tensor(values, [batch * places, side * side * channels], device))
            }
        };
        let embedded = matches!(config.semantics, Semantics::Embedding(_));
        let label_data = || TensorData::new(labels, [batch, IMAGE * IMAGE]);
        Self {
            pixels,
            labels: embedded.then(|| Tensor::from_data(label_data(), device)),
            camera: (config.view_numbers() > 0).then(|| camera(config, scenes, device)),
            batch,
        }
    }

    /// How many pictures.
    pub fn batch(&self) -> usize {
        self.batch
    }
}

/// Channels that need no embedding.
fn plain_channels(config: &PsiConfig) -> usize {
    1 + usize::from(config.valid_mask) + usize::from(config.semantics == Semantics::Scalar)
}

fn camera(config: &PsiConfig, scenes: &[&SceneInput], device: &Device) -> Tensor<2> {
    let mut numbers = Vec::with_capacity(scenes.len() * config.view_numbers());
    for scene in scenes {
        if config.camera_scale {
            numbers.extend([scene.max_depth_m / CLIP_M, scene.focal]);
        }
        if config.floor_plane {
            numbers.extend(floor_plane(scene));
        }
    }
    tensor(numbers, [scenes.len(), config.view_numbers()], device)
}

/// The plane of the pixels that are labelled floor: its unit normal towards the floor (camera frame, y down), the
/// camera's distance from it in metres, and 1; zeros where too little floor is seen.
///
/// A plane's inverse depth is linear in the picture, 1 / z = n . (x/z, y/z, 1) / distance, so three equations give it;
/// pixels that lie off (a wrong label, a border) weigh less in a second and third round.
pub(super) fn floor_plane(scene: &SceneInput) -> [f32; FLOOR_PLANE] {
    let middle = IMAGE as f32 * 0.5;
    let pixel = |at: usize| {
        let flat = |i: usize| (i as f32 + 0.5 - middle) / (middle * scene.focal);
        (Vec3::new(flat(at % IMAGE), flat(at / IMAGE), 1.0), 1.0 / scene.depth_m[at])
    };
    let is_floor = |at: &usize| {
        scene.labels[*at] == FLOOR_LABEL
            && scene.valid.contains(*at)
            && (0.1..CLIP_M).contains(&scene.depth_m[*at])
    };
    let floor: Vec<(Vec3, f32)> = (0..IMAGE * IMAGE).filter(is_floor).map(pixel).collect();
    if floor.len() < FLOOR_PIXELS {
        return [0.0; FLOOR_PLANE];
    }
    let mut plane = Vec3::ZERO;
    for round in 0..3 {
        let (mut matrix, mut right) = (Mat3::ZERO, Vec3::ZERO);
        for (along, inverse_m) in &floor {
            let off = (plane.dot(*along) - inverse_m) / FLOOR_TOLERANCE;
            let weight = if round == 0 { 1.0 } else { 1.0 / (1.0 + off * off) };
            matrix += Mat3::from_cols(*along * along.x, *along * along.y, *along) * weight;
            right += *along * (weight * inverse_m);
        }
        if matrix.determinant().abs() < 1e-9 {
            return [0.0; FLOOR_PLANE];
        }
        plane = matrix.inverse() * right;
    }
    let normal = plane.normalize_or_zero();
    [normal.x, normal.y, normal.z, (1.0 / plane.length()).min(CLIP_M), 1.0]
}

/// Depth as 2 d / max - 1 (0 where padded), the mask, and the paper's scalar semantics.
fn planes(config: &PsiConfig, scene: &SceneInput) -> Vec<Vec<f32>> {
    let plane = |value: &dyn Fn(usize) -> f32| -> Vec<f32> {
        (0..IMAGE * IMAGE).map(|at| if scene.valid.contains(at) { value(at) } else { 0.0 }).collect()
    };
    let mut planes =
        vec![plane(&|at| 2.0 * scene.depth_m[at].min(scene.max_depth_m) / scene.max_depth_m - 1.0)];
    if config.valid_mask {
        planes.push(plane(&|_| 1.0));
    }
    if config.semantics == Semantics::Scalar {
        let number = |label: u8| f32::from(MPCAT40[usize::from(label)]);
        let largest = scene.labels.iter().map(|l| number(*l)).fold(1.0, f32::max);
        planes.push(plane(&|at| 2.0 * number(scene.labels[at]) / largest - 1.0));
    }
    planes
}

/// The pixels in the order of the tensors: row by row, or patch by patch.
fn pixel_order(stem: Stem) -> Vec<u32> {
    let Stem::Patches(side) = stem else {
        return (0..(IMAGE * IMAGE) as u32).collect();
    };
    let places = IMAGE / side;
    let mut order = Vec::with_capacity(IMAGE * IMAGE);
    for place in 0..places * places {
        let (top, left) = (place / places * side, place % places * side);
        for pixel in 0..side * side {
            let (y, x) = (top + pixel / side, left + pixel % side);
            order.push((y * IMAGE + x) as u32);
        }
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normalising_a_place_can_be_undone() {
        let scene = SceneInput {
            depth_m: Vec::new(),
            labels: Vec::new(),
            valid: ValidArea { left: 0, top: 0, width: IMAGE, height: IMAGE },
            max_depth_m: 4.5,
            focal: 1.7,
        };
        let t = [0.8, -0.4, 3.1];
        let back = scene.denormalize(scene.normalize(t));
        assert!(t.iter().zip(back).all(|(a, b)| (a - b).abs() < 1e-5), "{back:?}");
        assert_eq!(scene.normalize([0.0, 0.0, 4.5])[2], 1.0);
    }

    /// A floor 1.6 m below a camera that looks down by `pitch`, with a table's worth of wrong labels.
    fn floor_seen(pitch: f32, wrong: usize) -> SceneInput {
        let (sin, cos) = pitch.sin_cos();
        let focal = 1.5;
        let depth = |at: usize| {
            let y = ((at / IMAGE) as f32 + 0.5 - 64.0) / (64.0 * focal);
            let down = sin + cos * y;
            if down > 0.3 { 1.6 / down } else { 0.0 }
        };
        let mut depth_m: Vec<f32> = (0..IMAGE * IMAGE).map(depth).collect();
        let labels = depth_m.iter().map(|d| if *d > 0.0 { FLOOR_LABEL } else { 1 }).collect();
        depth_m.iter_mut().rev().take(wrong).for_each(|d| *d *= 0.5);
        let valid = ValidArea { left: 0, top: 0, width: IMAGE, height: IMAGE };
        SceneInput { depth_m, labels, valid, max_depth_m: CLIP_M, focal }
    }

    #[test]
    fn the_floor_tells_how_the_camera_is_tilted_and_how_high_it_stands() {
        for (pitch, wrong) in [(0.4f32, 0), (0.7, 0), (0.5, 1000)] {
            let [x, y, z, height_m, seen] = floor_plane(&floor_seen(pitch, wrong));
            let off = (Vec3::new(x, y, z) - Vec3::new(0.0, pitch.cos(), pitch.sin())).length();
            assert!(
                off < 0.02 && (height_m - 1.6).abs() < 0.03 && seen == 1.0,
                "{pitch}: {x} {y} {z} {height_m}"
            );
        }
        let mut hidden = floor_seen(0.4, 0);
        hidden.labels.fill(5);
        assert_eq!(floor_plane(&hidden), [0.0; FLOOR_PLANE]);
    }

    #[test]
    fn patches_hold_every_pixel_once() {
        let mut order = pixel_order(Stem::Patches(4));
        assert_eq!(order[..6], [0, 1, 2, 3, 128, 129]);
        order.sort_unstable();
        assert!(order.iter().enumerate().all(|(i, p)| i as u32 == *p));
    }
}
