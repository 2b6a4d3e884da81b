//! `samples.npz`: people and views of one room as arrays.

use glam::{Affine3A, Mat3, Vec3};

use super::{CorpusError, CorpusPerson, CorpusRoom, CorpusView, RoomEntry, ViewKind};
use crate::assets::npz::{Npz, NpzWriter};
use crate::body::joints::BODY_JOINTS;
use crate::generate::sensor::{Intrinsics, LABELS, SIDE, Valid, View};
use crate::scene::{BETAS, HANDS, PoseFamily};

/// Every kind of view, in the order of their numbers in files.
const KINDS: [ViewKind; 2] = [ViewKind::Virtual, ViewKind::Agent];
/// Pixels of a view.
const PIXELS: usize = SIDE * SIDE;

impl CorpusRoom {
    /// The room's people and views as an archive. For N people: `people/translation` (N, 3) in metres,
    /// `people/rotation6` (N, 6), `people/betas` (N, 10), `people/body_pose` (N, 21, 3) axis-angles in radians,
    /// `people/hands` (N, 24), `people/family` (N) as numbers of [`PoseFamily::ALL`]. For V views: `views/kind` (V) 0
    /// virtual, 1 agent, `views/body` (V), `views/world_from_camera` (V, 3, 4) with x right, y down, z forward,
    /// `views/focal_px` (V), `views/valid` (V, 4) left, top, width, height, `views/depth_mm` (V, 128, 128),
    /// `views/labels` (V, 128, 128). The same room gives the same bytes.
    ///
    /// # Errors
    /// What the zip writer says; never in memory.
    pub fn to_npz(&self) -> std::io::Result<Vec<u8>> {
        let mut npz = NpzWriter::default();
        let (n, people) = (self.people.len(), &self.people);
        let floats = |f: &dyn Fn(&CorpusPerson) -> Vec<f32>| people.iter().flat_map(f).collect::<Vec<f32>>();
        npz.add("people/translation", &[n, 3], &floats(&|p| p.translation.to_array().to_vec()))?;
        npz.add("people/rotation6", &[n, 6], &floats(&|p| p.rotation6.to_vec()))?;
        npz.add("people/betas", &[n, BETAS], &floats(&|p| p.betas.to_vec()))?;
        let pose = |p: &CorpusPerson| p.body_pose.iter().flat_map(Vec3::to_array).collect();
        npz.add("people/body_pose", &[n, BODY_JOINTS, 3], &floats(&pose))?;
        npz.add("people/hands", &[n, HANDS], &floats(&|p| p.hands.to_vec()))?;
        let family = |p: &CorpusPerson| number_in(&PoseFamily::ALL, &p.family);
        npz.add("people/family", &[n], &people.iter().map(family).collect::<Vec<u8>>())?;
        self.add_views(&mut npz)?;
        npz.finish()
    }

    fn add_views(&self, npz: &mut NpzWriter) -> std::io::Result<()> {
        let (v, views) = (self.views.len(), &self.views);
        npz.add("views/kind", &[v], &views.iter().map(|w| number_in(&KINDS, &w.kind)).collect::<Vec<u8>>())?;
        npz.add("views/body", &[v], &views.iter().map(|w| w.body as i32).collect::<Vec<i32>>())?;
        let poses: Vec<f32> = views.iter().flat_map(|w| rows(&w.view.world_from_camera)).collect();
        npz.add("views/world_from_camera", &[v, 3, 4], &poses)?;
        let focal: Vec<f32> = views.iter().map(|w| w.view.intrinsics.focal_px).collect();
        npz.add("views/focal_px", &[v], &focal)?;
        let valid =
            |w: &CorpusView| [w.valid.left, w.valid.top, w.valid.width, w.valid.height].map(|n| n as i32);
        npz.add("views/valid", &[v, 4], &views.iter().flat_map(valid).collect::<Vec<i32>>())?;
        let depth: Vec<u16> = views.iter().flat_map(|w| w.depth_mm.iter().copied()).collect();
        npz.add("views/depth_mm", &[v, SIDE, SIDE], &depth)?;
        let labels: Vec<u8> = views.iter().flat_map(|w| w.labels.iter().copied()).collect();
        npz.add("views/labels", &[v, SIDE, SIDE], &labels)
    }

    /// Reads what [`CorpusRoom::to_npz`] wrote; `file` names it in errors.
    ///
    /// # Errors
    /// [`CorpusError`], which names file, array and place.
    pub fn from_npz(entry: &RoomEntry, file: &str, bytes: &[u8]) -> Result<Self, CorpusError> {
        let npz = Npz::from_bytes(file, bytes)?;
        let people = read_people(&npz, file)?;
        let views = read_views(&npz, file, people.len())?;
        let room = Self {
            name: entry.name.clone(),
            split: entry.split,
            source: entry.source.clone(),
            people,
            views,
        };
        super::Manifest::check(entry, &room)?;
        Ok(room)
    }
}

fn number_in<T: PartialEq>(all: &[T], one: &T) -> u8 {
    all.iter().position(|other| other == one).unwrap_or(0) as u8
}

/// Row by row: rotation and translation.
fn rows(pose: &Affine3A) -> [f32; 12] {
    let (m, t) = (Mat3::from(pose.matrix3), Vec3::from(pose.translation));
    std::array::from_fn(|i| if i % 4 == 3 { t[i / 4] } else { m.col(i % 4)[i / 4] })
}

fn pose_of(rows: &[f32]) -> Affine3A {
    let column = |c: usize| Vec3::new(rows[c], rows[4 + c], rows[8 + c]);
    Affine3A::from_mat3_translation(Mat3::from_cols(column(0), column(1), column(2)), column(3))
}

fn array_of<const N: usize>(numbers: &[f32]) -> [f32; N] {
    std::array::from_fn(|i| numbers[i])
}

/// What a number of an array must be.
struct Range<'a> {
    file: &'a str,
    array: &'a str,
    below: usize,
}

impl Range<'_> {
    fn check(&self, index: usize, number: i64) -> Result<usize, CorpusError> {
        usize::try_from(number).ok().filter(|n| *n < self.below).ok_or_else(|| CorpusError::Value {
            file: self.file.into(),
            array: self.array.into(),
            index,
            problem: format!("{number} is not from 0 to {}", self.below.saturating_sub(1)),
        })
    }
}

fn read_people(npz: &Npz, file: &str) -> Result<Vec<CorpusPerson>, CorpusError> {
    let (shape, families) = npz.ints("people/family", &[None])?;
    let n = shape[0];
    let rows = |name: &str, width: usize| npz.floats(name, &[Some(n), Some(width)]).map(|(_, x)| x);
    let (translation, rotation6) = (rows("people/translation", 3)?, rows("people/rotation6", 6)?);
    let (betas, hands) = (rows("people/betas", BETAS)?, rows("people/hands", HANDS)?);
    let (_, poses) = npz.floats("people/body_pose", &[Some(n), Some(BODY_JOINTS), Some(3)])?;
    let known = Range { file, array: "people/family", below: PoseFamily::ALL.len() };
    (0..n)
        .map(|i| {
            let joint = |j: usize| Vec3::from_slice(&poses[(i * BODY_JOINTS + j) * 3..]);
            Ok(CorpusPerson {
                translation: Vec3::from_slice(&translation[3 * i..]),
                rotation6: array_of(&rotation6[6 * i..]),
                betas: array_of(&betas[BETAS * i..]),
                body_pose: std::array::from_fn(joint),
                hands: array_of(&hands[HANDS * i..]),
                family: PoseFamily::ALL[known.check(i, families[i])?],
            })
        })
        .collect()
}

fn read_views(npz: &Npz, file: &str, people: usize) -> Result<Vec<CorpusView>, CorpusError> {
    let (shape, kinds) = npz.ints("views/kind", &[None])?;
    let v = shape[0];
    let (_, bodies) = npz.ints("views/body", &[Some(v)])?;
    let (_, poses) = npz.floats("views/world_from_camera", &[Some(v), Some(3), Some(4)])?;
    let (_, focal) = npz.floats("views/focal_px", &[Some(v)])?;
    let (_, valid) = npz.ints("views/valid", &[Some(v), Some(4)])?;
    let pixels = [Some(v), Some(SIDE), Some(SIDE)];
    let (_, depth) = npz.ints("views/depth_mm", &pixels)?;
    let (_, labels) = npz.ints("views/labels", &pixels)?;
    let range = |array, below| Range { file, array, below };
    let known = range("views/kind", KINDS.len());
    let body = range("views/body", people);
    let (deep, label) = (range("views/depth_mm", 1 << 16), range("views/labels", LABELS));
    let fits = range("views/valid", SIDE + 1);
    (0..v)
        .map(|i| {
            let at = i * PIXELS..(i + 1) * PIXELS;
            let depth_mm = depth[at.clone()].iter().map(|d| deep.check(i, *d).map(|d| d as u16));
            let labels = labels[at].iter().map(|l| label.check(i, *l).map(|l| l as u8));
            let part = |k: usize| fits.check(i, valid[4 * i + k]).map(|n| n as u32);
            let (left, top) = (part(0)?, part(1)?);
            // A part that reached over the square's border would be read outside of it.
            let reach = |first: u32, k: usize| {
                range("views/valid", SIDE + 1 - first as usize).check(i, valid[4 * i + k]).map(|n| n as u32)
            };
            let intrinsics = Intrinsics { width: SIDE as u32, height: SIDE as u32, focal_px: focal[i] };
            Ok(CorpusView {
                kind: KINDS[known.check(i, kinds[i])?],
                body: body.check(i, bodies[i])?,
                view: View { world_from_camera: pose_of(&poses[12 * i..12 * i + 12]), intrinsics },
                valid: Valid { left, top, width: reach(left, 2)?, height: reach(top, 3)? },
                depth_mm: depth_mm.collect::<Result<_, _>>()?,
                labels: labels.collect::<Result<_, _>>()?,
            })
        })
        .collect()
}
