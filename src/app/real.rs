//! The work behind the window as it really is: files, geometry, generation and measurement.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use glam::Vec3;

use super::engine::{
    BodyReport, Engine, ImportSummary, Made, Opened, PopulateTask, RoomGeometry, Snapshot, Source, UpAxis,
};
use crate::assets::Budget;
use crate::assets::read_model;
use crate::body::Body;
use crate::job::{JobCtx, Stop, Ticker};
use crate::render::BodySurface;
use crate::scene::BodyParams;
use crate::scene::GeometryConfig;
use crate::scene::Person;
use crate::scene::Room;
use crate::scene::Scene;

/// The program's own engine.
#[derive(Default)]
pub struct RealEngine;

impl Engine for RealEngine {
    fn samples(&self) -> Vec<String> {
        Vec::new()
    }

    fn open(&self, source: &Source, ticker: &Ticker) -> Result<Opened, Stop> {
        ticker.stage("reading", 0)?;
        let Source::File(path, _) = source else { return Err(Stop::Failed("no samples yet".into())) };
        let model = read_model(path, &Budget::default())?;
        let objects = model
            .parts
            .iter()
            .enumerate()
            .map(|(i, p)| crate::scene::Object {
                id: crate::scene::ObjectId(i as u32),
                name: p.name.clone(),
                category: crate::scene::Category::Unlabeled,
                parts: vec![crate::scene::ObjectPart {
                    mesh: p.mesh.clone(),
                    material: p.material,
                    object_from_mesh: p.file_from_mesh,
                }],
                world_from_object: glam::Affine3A::IDENTITY,
                visible: true,
                locked: false,
            })
            .collect();
        let room = Room {
            name: model.name.clone(),
            objects,
            materials: model.materials.clone(),
            textures: model.textures.clone(),
        };
        let summary = ImportSummary {
            source: source.clone(),
            name: model.name.clone(),
            unit_m: 1.0,
            up: UpAxis::Y,
            triangles: room.triangle_count(),
            objects: room.objects.len(),
            extent_m: room.bounds().size(),
            notes: model.notes.clone(),
        };
        Ok(Opened { scene: Scene { room: Arc::new(room), people: vec![] }, summary, project: None })
    }

    fn save(&self, _path: &Path, _snapshot: &Snapshot, _ticker: &Ticker) -> Result<(), Stop> {
        Err(Stop::Failed("not yet".into()))
    }

    fn geometry(&self, room: &Room, ticker: &Ticker) -> Result<RoomGeometry, Stop> {
        ticker.stage("distance field", 0)?;
        let step = |done: usize, total: usize| match ticker.step(done, total) {
            Ok(()) => ControlFlow::Continue(()),
            Err(_) => ControlFlow::Break(()),
        };
        RoomGeometry::build(room, &GeometryConfig::default(), &step).map_err(|_| Stop::Cancelled)
    }

    fn populate(&self, _task: &PopulateTask, _cx: &JobCtx<Vec<Person>>) -> Result<Made, Stop> {
        Err(Stop::Failed("not yet".into()))
    }

    fn measure(
        &self,
        _geometry: &RoomGeometry,
        _body: &BodyParams,
        _ticker: &Ticker,
    ) -> Result<BodyReport, Stop> {
        Ok(BodyReport::default())
    }

    fn pose(&self, body: &BodyParams) -> Arc<[Vec3]> {
        Body::bundled().pose(body).vertices.into()
    }

    fn faces(&self) -> Arc<[[u32; 3]]> {
        Body::bundled().model.faces.as_slice().into()
    }

    fn surface(&self) -> Arc<BodySurface> {
        Arc::new(BodySurface::of(Body::bundled()))
    }
}
