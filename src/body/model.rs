use glam::Vec3;

use crate::assets::npz::{Npz, NpzError};
use crate::scene::BETAS;

use super::joints::{JOINTS, PARENTS};

/// Influences kept a vertex; the rest is renormalised away (the bundled body loses nothing visible by it).
const MAX_INFLUENCES: usize = 4;
/// Most vertices that a body file may have: ten times SMPL-X.
const MAX_VERTICES: usize = 105_000;

/// Why a body file can't be used.
#[derive(Debug, thiserror::Error)]
pub enum BodyModelError {
    /// An array is missing or damaged.
    #[error(transparent)]
    Npz(#[from] NpzError),
    /// The arrays don't fit together.
    #[error("body file: {what}; export the 55-joint SMPL-X layout")]
    Layout {
        /// What does not fit.
        what: String,
    },
}

/// A body model in SMPL-X's layout: template, shape directions, joints as an affine function of shape, and
/// skin weights. Body frame, metres. No pose correctives.
#[derive(Clone, Debug)]
pub struct BodyModel {
    /// Rest vertices of the mean shape.
    pub template: Vec<Vec3>,
    /// Displacement of each vertex per unit of each shape number.
    pub shape_dirs: Vec<[Vec3; BETAS]>,
    /// Triangles, counter-clockwise seen from outside.
    pub faces: Vec<[u32; 3]>,
    /// Rest joints of the mean shape.
    pub joint_template: [Vec3; JOINTS],
    /// Displacement of each joint per unit of each shape number.
    pub joint_dirs: [[Vec3; BETAS]; JOINTS],
    /// Up to four `(joint, weight)` of each vertex, heaviest first, weights summing to 1; unused ones are 0.
    pub skin: Vec<[(u8, f32); MAX_INFLUENCES]>,
}

impl BodyModel {
    /// Reads a model from an archive of SMPL-X's layout: `v_template`, `shapedirs`, `f`, `weights`,
    /// `kintree_parents` or `kintree_table`, and the joints by `J_template` with `J_shapedirs` or by
    /// `J_regressor`. Of more than ten shape directions the first ten are used.
    ///
    /// # Errors
    /// [`BodyModelError`], which names the array.
    pub fn from_npz(npz: &Npz) -> Result<Self, BodyModelError> {
        let (shape, template) = npz.floats("v_template", &[None, Some(3)])?;
        let vertices = shape[0];
        check(vertices <= MAX_VERTICES, || format!("{vertices} vertices are more than {MAX_VERTICES}"))?;
        check_tree(npz)?;
        let template: Vec<Vec3> = template.chunks_exact(3).map(Vec3::from_slice).collect();
        let shape_dirs = read_dirs(npz, "shapedirs", vertices)?;
        let (joint_template, joint_dirs) = read_joints(npz, &template, &shape_dirs)?;
        let (_, weights) = npz.floats("weights", &[Some(vertices), Some(JOINTS)])?;
        let skin = weights.chunks_exact(JOINTS).map(heaviest).collect::<Option<Vec<_>>>();
        let skin = skin.ok_or_else(|| layout("a vertex has no positive skin weight".into()))?;
        Ok(Self { faces: read_faces(npz, vertices)?, template, shape_dirs, joint_template, joint_dirs, skin })
    }

    /// Rest joints of a shape, body frame.
    pub fn rest_joints(&self, betas: &[f32; BETAS]) -> [Vec3; JOINTS] {
        std::array::from_fn(|j| self.joint_template[j] + blend(&self.joint_dirs[j], betas))
    }

    /// The joint that moves a vertex most.
    pub fn dominant_joint(&self, vertex: usize) -> usize {
        usize::from(self.skin[vertex][0].0)
    }

    /// Area-weighted unit normals of vertices posed by this model's faces.
    pub fn vertex_normals(&self, vertices: &[Vec3]) -> Vec<Vec3> {
        let mut normals = vec![Vec3::ZERO; vertices.len()];
        for face in &self.faces {
            let [a, b, c] = face.map(|i| vertices[i as usize]);
            let doubled_area = (b - a).cross(c - a);
            for i in face {
                normals[*i as usize] += doubled_area;
            }
        }
        normals.into_iter().map(|n| n.normalize_or(Vec3::Y)).collect()
    }
}

fn blend(dirs: &[Vec3; BETAS], betas: &[f32; BETAS]) -> Vec3 {
    dirs.iter().zip(betas).map(|(dir, beta)| *dir * *beta).sum()
}

fn layout(what: String) -> BodyModelError {
    BodyModelError::Layout { what }
}

fn check(holds: bool, what: impl FnOnce() -> String) -> Result<(), BodyModelError> {
    if holds { Ok(()) } else { Err(layout(what())) }
}

/// The tree is SMPL-X's, or poses would turn other joints than they name.
fn check_tree(npz: &Npz) -> Result<(), BodyModelError> {
    let parents = if npz.has("kintree_parents") {
        npz.ints("kintree_parents", &[Some(JOINTS)])?.1
    } else {
        let mut table = npz.ints("kintree_table", &[Some(2), Some(JOINTS)])?.1;
        table.truncate(JOINTS);
        table
    };
    let differs = (1..JOINTS).find(|&j| parents[j] != PARENTS[j] as i64);
    check(differs.is_none(), || format!("joint {} has another parent than in SMPL-X", differs.unwrap_or(0)))
}

fn read_dirs(npz: &Npz, name: &str, rows: usize) -> Result<Vec<[Vec3; BETAS]>, BodyModelError> {
    let (shape, values) = npz.floats(name, &[Some(rows), Some(3), None])?;
    let given = shape[2];
    check(given >= BETAS, || format!("`{name}` has {given} directions, {BETAS} are needed"))?;
    let row = |row: &[f32]| std::array::from_fn(|b| Vec3::new(row[b], row[given + b], row[2 * given + b]));
    Ok(values.chunks_exact(3 * given).map(row).collect())
}

type JointsOfShape = ([Vec3; JOINTS], [[Vec3; BETAS]; JOINTS]);

fn read_joints(
    npz: &Npz,
    template: &[Vec3],
    shape_dirs: &[[Vec3; BETAS]],
) -> Result<JointsOfShape, BodyModelError> {
    if npz.has("J_template") {
        let (_, joints) = npz.floats("J_template", &[Some(JOINTS), Some(3)])?;
        let dirs = read_dirs(npz, "J_shapedirs", JOINTS)?;
        let joints = std::array::from_fn(|j| Vec3::from_slice(&joints[3 * j..]));
        return Ok((joints, std::array::from_fn(|j| dirs[j])));
    }
    let (_, regressor) = npz.floats("J_regressor", &[Some(JOINTS), Some(template.len())])?;
    let mut joints = [Vec3::ZERO; JOINTS];
    let mut dirs = [[Vec3::ZERO; BETAS]; JOINTS];
    for (j, row) in regressor.chunks_exact(template.len()).enumerate() {
        for (v, weight) in row.iter().enumerate().filter(|(_, weight)| **weight != 0.0) {
            joints[j] += template[v] * *weight;
            for b in 0..BETAS {
                dirs[j][b] += shape_dirs[v][b] * *weight;
            }
        }
    }
    Ok((joints, dirs))
}

fn read_faces(npz: &Npz, vertices: usize) -> Result<Vec<[u32; 3]>, BodyModelError> {
    let (_, indices) = npz.ints("f", &[None, Some(3)])?;
    let valid = |i: &i64| usize::try_from(*i).is_ok_and(|i| i < vertices);
    check(indices.iter().all(valid), || format!("a face names a vertex beyond the {vertices} there are"))?;
    Ok(indices.chunks_exact(3).map(|f| [f[0] as u32, f[1] as u32, f[2] as u32]).collect())
}

/// The heaviest influences of one row of weights, renormalised; `None` if there are none.
fn heaviest(row: &[f32]) -> Option<[(u8, f32); MAX_INFLUENCES]> {
    let mut all: Vec<(u8, f32)> =
        row.iter().enumerate().filter(|(_, w)| **w > 1e-3).map(|(j, w)| (j as u8, *w)).collect();
    all.sort_by(|a, b| b.1.total_cmp(&a.1));
    all.truncate(MAX_INFLUENCES);
    let total: f32 = all.iter().map(|(_, w)| w).sum();
    (total > 0.0).then(|| std::array::from_fn(|k| all.get(k).map_or((0, 0.0), |(j, w)| (*j, w / total))))
}
