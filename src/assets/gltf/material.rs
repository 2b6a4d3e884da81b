//! Materials and pictures of a glTF document.

use std::sync::Arc;

use super::accessor::Buffers;
use super::json::{Document, MaterialJson, TextureInfo};
use crate::assets::error::{Fault, Problem};
use crate::assets::model::{AlphaMode, Material, Texture};
use crate::assets::picture::{EncodedPicture, decode_all};
use crate::assets::uri::Surroundings;

/// Glass in the viewport lets three quarters through: clear, but to be seen.
const GLASS_ALPHA: f32 = 0.25;

/// A document's looks.
pub struct Looks {
    /// The document's materials, then the default one.
    pub materials: Vec<Material>,
    pub textures: Vec<Arc<Texture>>,
}

/// Where the base colour's texture coordinates come from.
pub fn base_texture(material: &MaterialJson) -> Option<&TextureInfo> {
    let old = material.extensions.specular_glossiness.as_ref().and_then(|s| s.diffuse_texture.as_ref());
    material.pbr_metallic_roughness.base_color_texture.as_ref().or(old)
}

/// Reads every material and the pictures that their base colours use.
pub fn read(buffers: &Buffers, around: Surroundings, notes: &mut Vec<String>) -> Result<Looks, Fault> {
    let document = buffers.document;
    around.budget.check_nodes("materials", "materials", document.materials.len())?;
    let mut images = Vec::new();
    let mut pictures = Vec::new();
    for image in wanted_images(document, notes)? {
        match encoded(buffers, image, around)? {
            Ok(picture) => {
                images.push(image);
                pictures.push(picture);
            }
            Err(note) => notes.push(note),
        }
    }
    let mut texture_of_image = vec![None; document.images.len()];
    let mut textures = Vec::new();
    for (image, decoded) in images.into_iter().zip(decode_all(&pictures, around.budget)?) {
        match decoded {
            Ok(texture) => {
                texture_of_image[image] = Some(textures.len());
                textures.push(texture);
            }
            Err(note) => notes.push(note),
        }
    }
    let texture_of =
        |t: &TextureInfo| document.textures.get(t.index)?.source.and_then(|i| texture_of_image[i]);
    let look_of = |m| look(m, base_texture(m).and_then(texture_of));
    let materials = document.materials.iter().map(look_of).chain([Material::default()]).collect();
    Ok(Looks { materials, textures })
}

/// The images that base colours use, each once.
fn wanted_images(document: &Document, notes: &mut Vec<String>) -> Result<Vec<usize>, Fault> {
    let mut wanted = std::collections::BTreeSet::new();
    let mut unreadable = std::collections::BTreeSet::new();
    for (m, texture) in document.materials.iter().enumerate().filter_map(|(m, x)| Some((m, base_texture(x)?)))
    {
        let place = format!("materials[{m}]");
        let count = document.textures.len();
        let Some(found) = document.textures.get(texture.index) else {
            return Err(Fault::out_of_range(place, "texture", texture.index, count));
        };
        match found.source {
            Some(image) if image < document.images.len() => {
                wanted.insert(image);
            }
            Some(image) => {
                let place = format!("textures[{}]", texture.index);
                return Err(Fault::out_of_range(place, "image", image, document.images.len()));
            }
            None => unreadable.extend(found.extensions.keys().map(|name| (texture.index, name.clone()))),
        }
    }
    notes.extend(unreadable.into_iter().map(|(texture, name)| {
        let format = if name == "KHR_texture_basisu" { "KTX2 (KHR_texture_basisu)" } else { name.as_str() };
        format!("textures[{texture}]: left out, {format} is not supported. Export with PNG or JPEG textures.")
    }));
    Ok(wanted.into_iter().collect())
}

/// The bytes of image `index`; a note when its file is missing.
fn encoded(
    buffers: &Buffers,
    index: usize,
    around: Surroundings,
) -> Result<Result<EncodedPicture, String>, Fault> {
    let image = &buffers.document.images[index];
    let place = format!("images[{index}]");
    let bytes = match (image.buffer_view, &image.uri) {
        (Some(view), _) => buffers.view(view)?.0.to_vec(),
        (None, Some(uri)) => match around.read_uri(&place, uri) {
            Ok(bytes) => bytes,
            Err(Fault { place, problem: Problem::Io(e) }) => {
                return Ok(Err(format!("{place}: left out, {e}")));
            }
            Err(fault) => return Err(fault),
        },
        (None, None) => return Ok(Err(format!("{place}: left out, it refers to no bytes"))),
    };
    Ok(Ok(EncodedPicture { name: image.name.clone().unwrap_or_default(), place, bytes }))
}

fn look(material: &MaterialJson, texture: Option<usize>) -> Material {
    let pbr = &material.pbr_metallic_roughness;
    let old = material.extensions.specular_glossiness.as_ref();
    let factor = pbr.base_color_factor.or(old.and_then(|s| s.diffuse_factor)).unwrap_or([1.0; 4]);
    let mut base_color = factor.map(unit);
    let mut alpha = match material.alpha_mode.as_deref() {
        Some("MASK") => AlphaMode::Mask(unit(material.alpha_cutoff.unwrap_or(0.5))),
        Some("BLEND") => AlphaMode::Blend,
        _ => AlphaMode::Opaque,
    };
    if material.extensions.transmission.as_ref().is_some_and(|t| t.transmission_factor > 0.5) {
        base_color[3] = base_color[3].min(GLASS_ALPHA);
        alpha = AlphaMode::Blend;
    }
    // A picture of metalness isn't drawn; most of such materials are paint and wood, so don't call them metal.
    let is_painted = pbr.metallic_roughness_texture.is_some() || old.is_some();
    let roughness = old.and_then(|s| s.glossiness_factor).map(|g| 1.0 - g).or(pbr.roughness_factor);
    Material {
        name: material.name.clone().unwrap_or_default(),
        base_color,
        base_color_texture: texture,
        metallic: if is_painted { 0.0 } else { unit(pbr.metallic_factor.unwrap_or(1.0)) },
        roughness: unit(roughness.unwrap_or(1.0)),
        emissive: material.emissive_factor.unwrap_or_default().map(unit),
        double_sided: material.double_sided,
        alpha,
    }
}

/// A finite number from 0 to 1.
fn unit(value: f32) -> f32 {
    if value.is_finite() { value.clamp(0.0, 1.0) } else { 1.0 }
}
