//! Rooms of plain boxes for the tests of this module.

use std::ops::ControlFlow;
use std::sync::{Arc, OnceLock};

use glam::{Affine3A, Vec3};

use crate::assets::Mesh;
use crate::scene::{
    Category, FieldConfig, GeometryConfig, Object, ObjectId, ObjectPart, Resolution, Room, RoomGeometry, bake,
};

/// 6 x 2.7 x 5 m about the origin with sofa, table, wardrobe and bed; the sofa's back is at -z.
pub fn furnished() -> (Room, &'static RoomGeometry) {
    static GEOMETRY: OnceLock<RoomGeometry> = OnceLock::new();
    let mut room = Room::default();
    let (low, high) = (Vec3::new(-3.0, 0.0, -2.5), Vec3::new(3.0, 2.7, 2.5));
    let shell =
        [Category::Wall, Category::Wall, Category::Floor, Category::Ceiling, Category::Wall, Category::Wall];
    for (side, category) in shell.into_iter().enumerate() {
        let mut wall = [low, high];
        // A slab 20 cm thick outside of one face.
        let axis = side / 2;
        match side % 2 {
            0 => (wall[0][axis], wall[1][axis]) = (low[axis] - 0.2, low[axis]),
            _ => (wall[0][axis], wall[1][axis]) = (high[axis], high[axis] + 0.2),
        }
        add(&mut room, category, wall[0], wall[1]);
    }
    let v = Vec3::new;
    add(&mut room, Category::Sofa, v(-2.2, 0.0, -2.4), v(-0.2, 0.45, -1.6));
    add(&mut room, Category::Sofa, v(-2.2, 0.45, -2.4), v(-0.2, 0.9, -2.2));
    add(&mut room, Category::DiningTable, v(0.5, 0.0, -0.5), v(1.9, 0.75, 0.3));
    add(&mut room, Category::Cabinet, v(2.3, 0.0, -2.3), v(2.9, 2.0, 0.5));
    add(&mut room, Category::Bed, v(-2.9, 0.0, 1.2), v(-1.2, 0.5, 2.4));
    let geometry = GEOMETRY.get_or_init(|| geometry_of(&room));
    (room, geometry)
}

/// A floor of 6 x 5 m with one box on it and nothing around: an open scan.
pub fn open_floor() -> (Room, &'static RoomGeometry) {
    static GEOMETRY: OnceLock<RoomGeometry> = OnceLock::new();
    let mut room = Room::default();
    add(&mut room, Category::Floor, Vec3::new(-3.0, -0.01, -2.5), Vec3::new(3.0, 0.0, 2.5));
    add(&mut room, Category::Table, Vec3::new(-2.0, 0.0, -1.0), Vec3::new(-1.0, 0.7, 1.0));
    let geometry = GEOMETRY.get_or_init(|| geometry_of(&room));
    (room, geometry)
}

fn geometry_of(room: &Room) -> RoomGeometry {
    let (owner, triangles): (Vec<_>, Vec<_>) = room.world_triangles().unzip();
    let go_on = |_, _| ControlFlow::Continue(());
    let resolution = Resolution::Cells { cell_m: 0.05, max_bytes: 64 << 20 };
    let config =
        GeometryConfig { field: FieldConfig { resolution, ..FieldConfig::default() }, ..Default::default() };
    let field = bake(&triangles, &config.field, &go_on).expect("not stopped");
    RoomGeometry::from_field(triangles, owner, field, &config, &go_on).expect("not stopped")
}

fn add(room: &mut Room, category: Category, low: Vec3, high: Vec3) {
    let corner = |i: usize| {
        let pick = |bit: usize, a: f32, b: f32| if i >> bit & 1 == 0 { a } else { b };
        Vec3::new(pick(0, low.x, high.x), pick(1, low.y, high.y), pick(2, low.z, high.z))
    };
    let quads: [[u32; 4]; 6] =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let mesh = Mesh {
        positions: (0..8).map(corner).collect(),
        normals: Vec::new(),
        uvs: Vec::new(),
        colors: Vec::new(),
        triangles: quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
    };
    let id = ObjectId(room.objects.len() as u32);
    let part = ObjectPart { mesh: Arc::new(mesh), material: 0, object_from_mesh: Affine3A::IDENTITY };
    room.objects.push(Object {
        id,
        name: format!("{} {}", category.label(), id.0),
        category,
        parts: vec![part],
        world_from_object: Affine3A::IDENTITY,
        visible: true,
        locked: false,
    });
}
