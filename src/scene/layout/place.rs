//! Puts furniture where the layout says and checks that it can stand there.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use glam::{Affine3A, Vec2, Vec3};

use crate::assets::{Material, Mesh, Model, Part};

use super::mesh::{ModelBuilder, linear, yaw};
use super::shell::Shell;
use super::{Furniture, Item, Layout, LayoutError, Placement, Srgb};
use crate::scene::Category;

/// How far an object may reach into a wall before the layout is refused: rounding and curtain rails.
const OUTSIDE_LIMIT_M: f32 = 0.005;

/// Adds every placement of the layout.
pub fn furnish(
    layout: &Layout,
    shell: &Shell,
    furniture: &Furniture<'_>,
    model: &mut ModelBuilder,
) -> Result<(), LayoutError> {
    let mut files = HashMap::new();
    for placement in &layout.furniture {
        let name = &placement.name;
        if model.parts(name).is_some() {
            return Err(LayoutError::SameName { name: name.clone() });
        }
        if Category::from_label(&placement.category).is_none() {
            let category = placement.category.clone();
            return Err(LayoutError::Category { name: name.clone(), category });
        }
        let world = world_from_piece(placement, model)?;
        match &placement.item {
            Item::Model(file) => {
                if !files.contains_key(file) {
                    let loaded = load(placement, file, furniture)?;
                    files.insert(file.clone(), loaded);
                }
                let parts = finished(placement, &files[file], model)?;
                model.shared_object(name, &placement.category, world, &parts);
            }
            piece => model.object(name, &placement.category, world, piece.surfaces()?),
        }
        inside(name, shell, model)?;
    }
    Ok(())
}

/// A model file whose pieces are all in the model's own frame.
struct Loaded {
    model: Model,
    meshes: Vec<(Arc<Mesh>, usize)>,
}

fn load(placement: &Placement, file: &str, furniture: &Furniture<'_>) -> Result<Loaded, LayoutError> {
    let error = |problem: String| LayoutError::Furniture {
        name: placement.name.clone(),
        model: file.to_owned(),
        problem,
    };
    let model = furniture(file).map_err(error)?;
    if model.triangle_count() == 0 {
        return Err(error("has no triangles".into()));
    }
    let meshes = model.parts.iter().map(|part| (own_frame(part, &model), part.material)).collect();
    Ok(Loaded { model, meshes })
}

/// The part's mesh in the file's frame, without texture coordinates that nothing uses.
fn own_frame(part: &Part, model: &Model) -> Arc<Mesh> {
    let textured = model.materials[part.material].base_color_texture.is_some();
    if part.file_from_mesh == Affine3A::IDENTITY && (textured || part.mesh.uvs.is_empty()) {
        return part.mesh.clone();
    }
    let mut mesh = Mesh::clone(&part.mesh);
    let normals_turn = part.file_from_mesh.matrix3.inverse().transpose();
    for position in &mut mesh.positions {
        *position = part.file_from_mesh.transform_point3(*position);
    }
    for normal in &mut mesh.normals {
        *normal = (normals_turn * *normal).normalize_or(Vec3::Y);
    }
    if part.file_from_mesh.matrix3.determinant() < 0.0 {
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    if !textured {
        mesh.uvs.clear();
    }
    Arc::new(mesh)
}

/// The model's parts with the placement's colours.
fn finished(
    placement: &Placement,
    loaded: &Loaded,
    model: &mut ModelBuilder,
) -> Result<Vec<(Arc<Mesh>, usize)>, LayoutError> {
    let materials = &loaded.model.materials;
    if let Some(unknown) = placement.finish.keys().find(|k| !materials.iter().any(|m| &m.name == *k)) {
        let known: Vec<&str> = materials.iter().map(|m| m.name.as_str()).collect();
        return Err(LayoutError::Finish {
            name: placement.name.clone(),
            material: unknown.clone(),
            known: known.join(", "),
        });
    }
    let numbers: Vec<usize> = materials
        .iter()
        .map(|material| {
            let mut look = look(material, placement.tint, &placement.finish);
            let texture = look.base_color_texture.map(|t| model.texture(&loaded.model.textures[t]));
            look.base_color_texture = texture;
            model.material(&look)
        })
        .collect();
    Ok(loaded.meshes.iter().map(|(mesh, material)| (mesh.clone(), numbers[*material])).collect())
}

fn look(material: &Material, tint: Option<Srgb>, finish: &BTreeMap<String, Srgb>) -> Material {
    let mut look = material.clone();
    if let Some(color) = finish.get(&material.name) {
        look.base_color_texture = None;
        look.base_color[..3].copy_from_slice(&linear(*color));
    } else if let Some(color) = tint {
        let factor = linear(color);
        for k in 0..3 {
            look.base_color[k] *= factor[k];
        }
    }
    look
}

fn world_from_piece(placement: &Placement, model: &ModelBuilder) -> Result<Affine3A, LayoutError> {
    let (name, scale) = (&placement.name, placement.scale);
    if !(0.01..=100.0).contains(&scale) {
        let (what, least_m, most_m) = (format!("the scale of '{name}'"), 0.01, 100.0);
        return Err(LayoutError::Size { what, value_m: scale, least_m, most_m });
    }
    let mut at = Vec3::from(placement.at);
    if let Some(on) = &placement.on {
        at.y += top_under(placement, on, model)?;
    }
    Ok(Affine3A::from_scale_rotation_translation(Vec3::splat(scale), yaw(placement.yaw_deg), at))
}

/// Height of the topmost surface of the object `on` at the placement's spot.
fn top_under(placement: &Placement, on: &str, model: &ModelBuilder) -> Result<f32, LayoutError> {
    let error = |problem: &str| LayoutError::Support {
        name: placement.name.clone(),
        on: on.to_owned(),
        problem: problem.into(),
    };
    let parts = model.parts(on).ok_or_else(|| error("isn't placed before it"))?;
    let spot = Vec2::new(placement.at.0, placement.at.2);
    let hits = parts.iter().flat_map(|part| {
        (0..part.mesh.triangles.len()).filter_map(move |t| {
            let corners = part.mesh.corners(t).map(|p| part.file_from_mesh.transform_point3(p));
            height_at(corners, spot)
        })
    });
    let top = hits.fold(f32::NEG_INFINITY, f32::max);
    if top.is_finite() { Ok(top) } else { Err(error("isn't below it")) }
}

/// Height of a triangle above or below the plan point `spot`; `None` beside it or if it stands upright.
fn height_at(corners: [Vec3; 3], spot: Vec2) -> Option<f32> {
    let [a, b, c] = corners.map(|p| Vec2::new(p.x, p.z));
    let area = (b - a).perp_dot(c - a);
    if area.abs() < 1e-12 {
        return None;
    }
    let weights = [(b, c), (c, a), (a, b)].map(|(p, q)| (q - p).perp_dot(spot - p) / area);
    let height = (0..3).map(|k| weights[k] * corners[k].y).sum();
    weights.iter().all(|w| *w >= 0.0).then_some(height)
}

/// Checks that no corner of the object's box leaves the room.
fn inside(name: &str, shell: &Shell, model: &ModelBuilder) -> Result<(), LayoutError> {
    let bounds = model.bounds(name);
    let corners = [bounds.min.x, bounds.max.x]
        .into_iter()
        .flat_map(|x| [bounds.min.z, bounds.max.z].map(|z| Vec2::new(x, z)));
    let sideways = corners.map(|c| shell.outside_m(c)).fold(0.0, f32::max);
    let outside_m = sideways.max(-bounds.min.y).max(bounds.max.y - shell.height_m());
    if outside_m > OUTSIDE_LIMIT_M {
        return Err(LayoutError::Outside { name: name.to_owned(), outside_m });
    }
    Ok(())
}
