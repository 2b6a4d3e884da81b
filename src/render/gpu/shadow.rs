//! The shadow map, drawn again only when something that casts a shadow has changed.

use std::sync::Arc;

use glam::Vec3;

use super::frame::ShadowFit;
use super::pipelines::DEPTH;
use crate::render::draw::{Quality, SceneDraw};
use crate::scene::{PersonId, Room};

/// What the map was drawn from, by pointer.
struct Casters {
    room: Arc<Room>,
    people: Vec<(PersonId, Arc<[Vec3]>)>,
    fit: ShadowFit,
}

impl Casters {
    fn of(draw: &SceneDraw, fit: ShadowFit) -> Self {
        let people = draw.people.iter().filter(|p| p.alpha >= 1.0);
        Self {
            room: Arc::clone(&draw.room),
            people: people.map(|p| (p.id, Arc::clone(&p.vertices))).collect(),
            fit,
        }
    }

    fn same(&self, other: &Self) -> bool {
        let equal =
            |a: &(PersonId, Arc<[Vec3]>), b: &(PersonId, Arc<[Vec3]>)| a.0 == b.0 && Arc::ptr_eq(&a.1, &b.1);
        Arc::ptr_eq(&self.room, &other.room)
            && self.fit == other.fit
            && self.people.len() == other.people.len()
            && self.people.iter().zip(&other.people).all(|(a, b)| equal(a, b))
    }
}

/// The map and what it shows.
#[derive(Default)]
pub struct ShadowCache {
    map: Option<(u32, wgpu::TextureView)>,
    casters: Option<Casters>,
}

/// Texels along a side of the map.
pub fn side(quality: Quality) -> u32 {
    match quality {
        Quality::Low => 1024,
        Quality::High => 2048,
    }
}

impl ShadowCache {
    /// The map for `draw`, and whether it has to be drawn.
    pub fn prepare(
        &mut self,
        device: &wgpu::Device,
        draw: &SceneDraw,
        fit: ShadowFit,
    ) -> (wgpu::TextureView, bool) {
        let side = side(draw.look.quality);
        let casters = Casters::of(draw, fit);
        let known = self.map.as_ref().filter(|(known, _)| *known == side).map(|(_, view)| view.clone());
        let fresh = known.is_some() && self.casters.as_ref().is_some_and(|old| old.same(&casters));
        let view = known.unwrap_or_else(|| make(device, side));
        self.map = Some((side, view.clone()));
        self.casters = Some(casters);
        (view, !fresh)
    }
}

fn make(device: &wgpu::Device, side: u32) -> wgpu::TextureView {
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("shadow"),
        size: wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: DEPTH,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    });
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}
