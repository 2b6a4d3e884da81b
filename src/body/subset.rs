use glam::Vec3;

use crate::scene::BETAS;

use super::model::BodyModel;

/// Vertices worked on together, so that the compiler fills SIMD registers.
pub(super) const LANES: usize = 8;
/// Numbers of a block: x of all lanes, then y, then z.
pub(super) const BLOCK: usize = 3 * LANES;

/// One block of vertices: positions or gradients, component by component.
pub(super) type Block = [f32; BLOCK];

/// Chosen vertices of a body, packed for the optimiser: template and shape directions in blocks, skin
/// weights without gaps. Posing a subset costs in proportion to its size.
#[derive(Clone, Debug)]
pub struct VertexSubset {
    ids: Vec<u32>,
    pub(super) template: Vec<Block>,
    pub(super) shape_dirs: Vec<[Block; BETAS]>,
    /// Where the influences of each vertex start, and one past the last.
    pub(super) influence_start: Vec<u32>,
    pub(super) influences: Vec<(u32, f32)>,
}

impl VertexSubset {
    /// The given vertices, in the given order.
    ///
    /// # Panics
    /// If an id is not a vertex of `model`.
    pub fn new(model: &BodyModel, ids: Vec<u32>) -> Self {
        let blocks = ids.len().div_ceil(LANES);
        let mut subset = Self {
            template: vec![[0.0; BLOCK]; blocks],
            shape_dirs: vec![[[0.0; BLOCK]; BETAS]; blocks],
            influence_start: vec![0],
            influences: Vec::new(),
            ids,
        };
        for (i, id) in subset.ids.iter().enumerate() {
            let id = *id as usize;
            set_lane(&mut subset.template[i / LANES], i % LANES, model.template[id]);
            for (block, dir) in subset.shape_dirs[i / LANES].iter_mut().zip(&model.shape_dirs[id]) {
                set_lane(block, i % LANES, *dir);
            }
            let used = model.skin[id].iter().filter(|(_, weight)| *weight > 0.0);
            subset.influences.extend(used.map(|(joint, weight)| (u32::from(*joint), *weight)));
            subset.influence_start.push(subset.influences.len() as u32);
        }
        subset
    }

    /// The given vertices of one body shape, in the given order: posed without blending the shape again, so the
    /// `betas` of the forward pass only place the joints, and there is no gradient by shape. For sequences.
    ///
    /// # Panics
    /// If an id is not a vertex of `model`.
    pub fn of_shape(model: &BodyModel, ids: Vec<u32>, betas: &[f32; BETAS]) -> Self {
        let mut subset = Self::new(model, ids);
        for (rest, dirs) in subset.template.iter_mut().zip(&subset.shape_dirs) {
            for (dir, beta) in dirs.iter().zip(betas) {
                rest.iter_mut().zip(dir).for_each(|(x, d)| *x += d * beta);
            }
        }
        subset.shape_dirs = vec![];
        subset
    }

    /// Every vertex of one body shape, in the model's order ([`VertexSubset::of_shape`]).
    pub fn all_of_shape(model: &BodyModel, betas: &[f32; BETAS]) -> Self {
        Self::of_shape(model, (0..model.template.len() as u32).collect(), betas)
    }

    /// Every vertex of the model, in its order.
    pub fn all(model: &BodyModel) -> Self {
        Self::new(model, (0..model.template.len() as u32).collect())
    }

    /// Number of vertices.
    pub fn len(&self) -> usize {
        self.ids.len()
    }

    /// Whether no vertex is chosen.
    pub fn is_empty(&self) -> bool {
        self.ids.is_empty()
    }

    /// The model's vertex behind each entry.
    pub fn ids(&self) -> &[u32] {
        &self.ids
    }
}

pub(super) fn lane(block: &Block, lane: usize) -> Vec3 {
    Vec3::new(block[lane], block[LANES + lane], block[2 * LANES + lane])
}

pub(super) fn set_lane(block: &mut Block, lane: usize, value: Vec3) {
    block[lane] = value.x;
    block[LANES + lane] = value.y;
    block[2 * LANES + lane] = value.z;
}
