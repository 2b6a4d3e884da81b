//! What a user may expect of pictures, from the card (llvmpipe counts) and from the processor.
//!
//! Checks what is in a picture, not its exact bytes: drivers differ in those.

use std::sync::{Arc, LazyLock};

use glam::{Affine3A, Mat3, Vec2, Vec3};
use inhabit::assets::{AlphaMode, Material, Mesh, Texture};
use inhabit::body::Body;
use inhabit::render::{
    Backend, BodySurface, DepthTest, Look, Painter, PersonDraw, Picked, Picker, Picture, Point, Quality,
    RenderContext, RenderError, SceneDraw, Shown, Viewport, heat_color, picture, render_image,
    render_on_processor, room_views,
};
use inhabit::scene::{BodyParams, Camera, Category, Object, ObjectId, ObjectPart, PersonId, Room};

const SIZE: [u32; 2] = [320, 240];

/// One device for all tests of this file; a machine without one has to run `tests/run` first.
static CONTEXT: LazyLock<RenderContext> = LazyLock::new(|| {
    RenderContext::headless()
        .unwrap_or_else(|e| panic!("these tests need a Vulkan driver, `bash tests/run` installs one: {e}"))
});

/// An axis-aligned box.
fn cuboid(min: Vec3, max: Vec3) -> Mesh {
    let corner = |i: usize| {
        let pick = |axis: usize| if i >> axis & 1 == 0 { min[axis] } else { max[axis] };
        Vec3::new(pick(0), pick(1), pick(2))
    };
    let faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let mut mesh = Mesh::default();
    for face in faces {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(face.map(corner));
        mesh.uvs.extend([Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y]);
        mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    mesh
}

fn paint(base: [f32; 4]) -> Material {
    Material { base_color: base, ..Material::default() }
}

struct Builder(Room);

impl Builder {
    fn new() -> Self {
        Self(Room::default())
    }

    fn add(mut self, category: Category, min: Vec3, max: Vec3, material: Material) -> Self {
        let part = ObjectPart {
            mesh: Arc::new(cuboid(min, max)),
            material: self.0.materials.len(),
            object_from_mesh: Affine3A::IDENTITY,
        };
        self.0.materials.push(material);
        self.0.objects.push(Object {
            id: ObjectId(self.0.objects.len() as u32),
            name: category.label().to_owned(),
            category,
            parts: vec![part],
            world_from_object: Affine3A::IDENTITY,
            visible: true,
            locked: false,
        });
        self
    }

    fn floor(self) -> Self {
        let grey = paint([0.6, 0.6, 0.6, 1.0]);
        self.add(Category::Floor, Vec3::new(-3.0, -0.1, -3.0), Vec3::new(3.0, 0.0, 3.0), grey)
    }

    fn draw(self) -> SceneDraw {
        let look = Look { grid: Shown::No, ..Look::default() };
        SceneDraw { room: Arc::new(self.0), look, ..SceneDraw::default() }
    }
}

fn standing(id: u32) -> PersonDraw {
    let mut params = BodyParams { translation: Vec3::new(0.0, 0.92, 0.0), ..BodyParams::default() };
    params.set_rotation(&Mat3::IDENTITY);
    let vertices = Body::bundled().pose(&params).vertices;
    let low = vertices.iter().fold(f32::INFINITY, |low, v| low.min(v.y));
    PersonDraw::new(PersonId(id), vertices.iter().map(|v| *v - Vec3::Y * low).collect(), id)
}

fn with_person(mut draw: SceneDraw, person: PersonDraw) -> SceneDraw {
    draw.body = Some(Arc::new(BodySurface::of(Body::bundled())));
    draw.people.push(person);
    draw
}

fn front() -> Camera {
    Camera {
        eye: Vec3::new(0.6, 1.5, 3.4),
        target: Vec3::new(0.0, 0.85, 0.0),
        fov_y: 0.8,
        ortho_height_m: None,
    }
}

/// The same picture from both renderers.
fn both(draw: &SceneDraw, camera: &Camera) -> [Picture; 2] {
    let from_card = render_image(&CONTEXT, draw, camera, SIZE).expect("picture from the card");
    [from_card, render_on_processor(draw, camera, SIZE).expect("picture from the processor")]
}

/// The pixel that a world point falls on.
fn pixel_of(camera: &Camera, point: Vec3) -> (u32, u32) {
    let ndc = camera.clip_from_world(SIZE[0] as f32 / SIZE[1] as f32).project_point3(point);
    let x = (ndc.x * 0.5 + 0.5) * SIZE[0] as f32;
    let y = (0.5 - ndc.y * 0.5) * SIZE[1] as f32;
    (x as u32, y as u32)
}

fn color_at(picture: &Picture, camera: &Camera, point: Vec3) -> [i32; 3] {
    let (x, y) = pixel_of(camera, point);
    picture.pixel(x, y).map(i32::from)
}

fn brightness(color: [i32; 3]) -> i32 {
    color.iter().sum::<i32>() / 3
}

#[test]
fn a_persons_pixels_are_where_the_person_stands_and_show_clothes_not_background() {
    let camera = front();
    let empty = both(&Builder::new().floor().draw(), &camera);
    let full = both(&with_person(Builder::new().floor().draw(), standing(0)), &camera);
    for (before, after) in empty.iter().zip(&full) {
        let changed = before.rgba.chunks(4).zip(after.rgba.chunks(4)).filter(|(a, b)| a != b).count();
        assert!((2_000..40_000).contains(&changed), "{changed} pixels changed in {}", after.backend);
        let chest = color_at(after, &camera, Vec3::new(0.0, 1.2, 0.1));
        let leg = color_at(after, &camera, Vec3::new(0.13, 0.55, 0.06));
        let apart: i32 = chest.iter().zip(leg).map(|(a, b)| (a - b).abs()).sum();
        assert!(apart > 40, "shirt {chest:?} and trousers {leg:?} look alike in {}", after.backend);
    }
}

#[test]
fn the_floor_is_darker_under_a_box_than_in_the_open() {
    let wood = paint([0.5, 0.3, 0.2, 1.0]);
    let draw = Builder::new()
        .floor()
        .add(Category::Table, Vec3::new(-0.5, 0.05, -0.5), Vec3::new(0.5, 0.6, 0.5), wood)
        .draw();
    let camera = front();
    for picture in both(&draw, &camera) {
        let open = brightness(color_at(&picture, &camera, Vec3::new(-1.2, 0.0, 0.9)));
        let contact = brightness(color_at(&picture, &camera, Vec3::new(0.0, 0.0, 0.53)));
        let shadow = brightness(color_at(&picture, &camera, Vec3::new(-0.62, 0.0, 0.2)));
        assert!(contact < open - 12, "contact {contact}, open floor {open} in {}", picture.backend);
        assert!(shadow < open - 25, "shadow {shadow}, open floor {open} in {}", picture.backend);
    }
}

#[test]
fn open_floor_has_no_spots_of_false_shadow() {
    let camera = front();
    for picture in both(&Builder::new().floor().draw(), &camera) {
        let row: Vec<i32> = (0..40)
            .map(|i| brightness(color_at(&picture, &camera, Vec3::new(i as f32 * 0.04 - 0.8, 0.0, 0.4))))
            .collect();
        let (low, high) = (row.iter().min().unwrap(), row.iter().max().unwrap());
        assert!(high - low < 14, "one material under one light: {row:?} in {}", picture.backend);
    }
}

#[test]
fn heat_shows_blue_where_free_white_at_contact_and_red_inside() {
    let camera = front();
    for (distance_m, what) in [(0.3, "free"), (0.0, "contact"), (-0.04, "inside")] {
        let mut person = standing(0);
        person.heat = Some(vec![distance_m; person.vertices.len()].into());
        let expected = heat_color(distance_m).map(i32::from);
        for picture in both(&with_person(Builder::new().floor().draw(), person), &camera) {
            let seen = color_at(&picture, &camera, Vec3::new(0.0, 1.2, 0.1));
            // Light changes brightness, not which channel leads.
            let lead = |c: [i32; 3]| [(c[0] - c[1]).signum(), (c[0] - c[2]).signum()];
            if what == "contact" {
                assert!(seen.iter().max().unwrap() - seen.iter().min().unwrap() < 30, "{seen:?}");
            } else {
                assert_eq!(lead(seen), lead(expected), "{what}: {seen:?} in {}", picture.backend);
            }
        }
    }
}

#[test]
fn a_texture_is_seen_the_right_way_up() {
    let mut builder = Builder::new();
    // Top half red, bottom half green.
    let rgba = [[220, 30, 30, 255], [220, 30, 30, 255], [30, 200, 30, 255], [30, 200, 30, 255]].concat();
    builder.0.textures.push(Arc::new(Texture { width: 2, height: 2, rgba, ..Texture::default() }));
    let mut mesh = Mesh::default();
    mesh.positions =
        [(-1.0, 0.0), (1.0, 0.0), (1.0, 2.0), (-1.0, 2.0)].map(|(x, y)| Vec3::new(x, y, 0.0)).into();
    mesh.uvs = vec![Vec2::new(0.0, 1.0), Vec2::new(1.0, 1.0), Vec2::new(1.0, 0.0), Vec2::new(0.0, 0.0)];
    mesh.triangles = vec![[0, 1, 2], [0, 2, 3]];
    let textured = Material { base_color: [1.0; 4], base_color_texture: Some(0), ..Material::default() };
    let mut builder = builder.add(Category::Picture, Vec3::ZERO, Vec3::ONE, textured);
    builder.0.objects[0].parts[0].mesh = Arc::new(mesh);
    let camera = front();
    for picture in both(&builder.draw(), &camera) {
        let [top, bottom] = [1.5, 0.5].map(|y| color_at(&picture, &camera, Vec3::new(0.0, y, 0.0)));
        assert!(top[0] > top[1] + 60, "top {top:?} in {}", picture.backend);
        assert!(bottom[1] > bottom[0] + 60, "bottom {bottom:?} in {}", picture.backend);
    }
}

#[test]
fn glass_lets_what_is_behind_it_through() {
    let scene = |alpha: f32| {
        let glass = Material { alpha: AlphaMode::Blend, ..paint([0.1, 0.1, 1.0, alpha]) };
        Builder::new()
            .floor()
            .add(
                Category::Furniture,
                Vec3::new(-1.0, 0.0, -1.0),
                Vec3::new(1.0, 2.0, -0.9),
                paint([0.9, 0.1, 0.1, 1.0]),
            )
            .add(Category::Furniture, Vec3::new(-1.0, 0.0, 0.5), Vec3::new(1.0, 2.0, 0.52), glass)
            .draw()
    };
    let camera = front();
    let point = Vec3::new(0.0, 1.0, 0.52);
    let clear = both(&scene(0.05), &camera).map(|p| color_at(&p, &camera, point));
    let dense = both(&scene(0.9), &camera).map(|p| color_at(&p, &camera, point));
    for (clear, dense) in clear.iter().zip(dense) {
        assert!(clear[0] > clear[2], "thin glass hides the red behind it: {clear:?}");
        assert!(dense[2] > dense[0], "dense blue glass is not blue: {dense:?}");
    }
}

#[test]
fn an_outside_camera_sees_into_a_closed_room_and_an_inside_camera_sees_its_walls() {
    let white = || paint([0.8, 0.8, 0.8, 1.0]);
    let draw = Builder::new()
        .floor()
        .add(Category::Wall, Vec3::new(-3.0, 0.0, 2.9), Vec3::new(3.0, 2.5, 3.0), white())
        .add(Category::Wall, Vec3::new(2.9, 0.0, -3.0), Vec3::new(3.0, 2.5, 3.0), white())
        .add(Category::Wall, Vec3::new(-3.0, 0.0, -3.0), Vec3::new(3.0, 2.5, -2.9), white())
        .add(Category::Wall, Vec3::new(-3.0, 0.0, -3.0), Vec3::new(-2.9, 2.5, 3.0), white())
        .add(Category::Ceiling, Vec3::new(-3.0, 2.5, -3.0), Vec3::new(3.0, 2.6, 3.0), white())
        .add(
            Category::Sofa,
            Vec3::new(-1.0, 0.0, -0.5),
            Vec3::new(1.0, 0.8, 0.5),
            paint([0.9, 0.05, 0.05, 1.0]),
        )
        .draw();
    for camera in room_views(&draw.room, SIZE[0] as f32 / SIZE[1] as f32) {
        for picture in both(&draw, &camera) {
            let sofa = color_at(&picture, &camera, Vec3::new(0.0, 0.8, 0.0));
            assert!(sofa[0] > sofa[1] + 60, "the sofa is hidden: {sofa:?} in {}", picture.backend);
        }
    }
    let inside = Camera { eye: Vec3::new(0.0, 1.5, 2.5), target: Vec3::new(0.0, 1.5, 3.0), ..front() };
    for picture in both(&draw, &inside) {
        let wall = picture.pixel(SIZE[0] / 2, SIZE[1] / 2).map(i32::from);
        assert!(brightness(wall) > 90, "no wall in front of the inside camera: {wall:?}");
    }
}

#[test]
fn card_and_processor_agree_on_the_picture() {
    let draw = with_person(
        Builder::new()
            .floor()
            .add(
                Category::Sofa,
                Vec3::new(-1.5, 0.0, -1.4),
                Vec3::new(1.0, 0.5, -0.6),
                paint([0.2, 0.4, 0.6, 1.0]),
            )
            .draw(),
        standing(3),
    );
    let [card, processor] = both(&draw, &front());
    let differences = card.rgba.iter().zip(&processor.rgba).map(|(a, b)| f64::from(a.abs_diff(*b)));
    let mean = differences.sum::<f64>() / card.rgba.len() as f64;
    assert!(mean < 5.0, "mean difference of {mean} of 255");
}

#[test]
fn the_processors_picture_is_the_same_on_one_thread_and_on_many() {
    let draw = with_person(Builder::new().floor().draw(), standing(1));
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("pool");
        pool.install(|| render_on_processor(&draw, &front(), [160, 120]).expect("picture"))
    };
    assert_eq!(on(1).rgba, on(3).rgba);
}

#[test]
fn a_selected_person_gets_an_outline_and_a_ghost_shows_what_is_behind() {
    let camera = front();
    let plain =
        render_image(&CONTEXT, &with_person(Builder::new().floor().draw(), standing(0)), &camera, SIZE);
    let mut chosen = standing(0);
    chosen.selected = true;
    let outlined = render_image(&CONTEXT, &with_person(Builder::new().floor().draw(), chosen), &camera, SIZE);
    let (plain, outlined) = (plain.expect("picture"), outlined.expect("picture"));
    let orange = |p: &Picture| {
        p.rgba.chunks(4).filter(|c| c[0] > 220 && (110..200).contains(&c[1]) && c[2] < 90).count()
    };
    assert!(orange(&outlined) > orange(&plain) + 100, "no orange outline");
    let mut ghost = standing(0);
    ghost.alpha = 0.3;
    let floor = both(&Builder::new().floor().draw(), &camera);
    let ghosts = both(&with_person(Builder::new().floor().draw(), ghost), &camera);
    let chest = Vec3::new(0.0, 1.2, 0.1);
    for (without, with) in floor.iter().zip(&ghosts) {
        let [a, b] = [without, with].map(|p| brightness(color_at(p, &camera, chest)));
        let solid = brightness(color_at(&plain, &camera, chest));
        assert!((a - b).abs() < (a - solid).abs(), "ghost {b} between {a} and {solid} in {}", with.backend);
    }
}

#[test]
fn a_new_pose_of_the_same_person_is_drawn_and_the_old_one_is_gone() {
    let camera = front();
    let mut viewport = Viewport::default();
    let draw = with_person(Builder::new().floor().draw(), standing(0));
    viewport.render(&CONTEXT, &draw, &camera, SIZE).expect("first frame");
    let mut moved = draw.clone();
    moved.people[0].vertices = draw.people[0].vertices.iter().map(|v| *v + Vec3::X * 0.9).collect();
    viewport.render(&CONTEXT, &moved, &camera, SIZE).expect("second frame");
    let after = render_image(&CONTEXT, &moved, &camera, SIZE).expect("picture");
    let afresh = render_on_processor(&moved, &camera, SIZE).expect("picture");
    for x in [0.0, 0.9] {
        let chest = Vec3::new(x, 1.2, 0.1);
        let apart: i32 = color_at(&after, &camera, chest)
            .iter()
            .zip(color_at(&afresh, &camera, chest))
            .map(|(a, b)| (a - b).abs())
            .sum();
        assert!(apart < 60, "what stands at x = {x} is stale");
    }
}

#[test]
fn markers_on_top_are_seen_through_walls_and_hidden_ones_are_not() {
    let camera = front();
    let mark =
        |depth| Point { at: Vec3::new(0.0, 1.0, -1.0), color: [255, 0, 255, 255], size_px: 12.0, depth };
    let wall = paint([0.5, 0.5, 0.5, 1.0]);
    let mut draw = Builder::new()
        .floor()
        .add(Category::Furniture, Vec3::new(-1.0, 0.0, 0.0), Vec3::new(1.0, 2.0, 0.1), wall)
        .draw();
    for (depth, expected) in [(DepthTest::OnTop, true), (DepthTest::Hidden, false)] {
        draw.points = vec![mark(depth)];
        let picture = render_image(&CONTEXT, &draw, &camera, SIZE).expect("picture");
        let seen = color_at(&picture, &camera, Vec3::new(0.0, 1.0, -1.0));
        assert_eq!(seen[0] > 200 && seen[1] < 80, expected, "{depth:?}: {seen:?}");
    }
}

#[test]
fn pictures_without_pixels_people_without_surface_and_wrong_vertices_are_refused() {
    let draw = Builder::new().floor().draw();
    for size in [[0, 10], [10, 0], [100_000, 10]] {
        let by_card = render_image(&CONTEXT, &draw, &front(), size);
        assert!(matches!(by_card, Err(RenderError::Size { .. })), "{size:?}");
        assert!(matches!(render_on_processor(&draw, &front(), size), Err(RenderError::Size { .. })));
    }
    let mut alone = draw.clone();
    alone.people.push(standing(0));
    assert_eq!(render_image(&CONTEXT, &alone, &front(), SIZE), Err(RenderError::NoBodySurface { people: 1 }));
    let mut cut = standing(0);
    cut.vertices = cut.vertices[..10].into();
    let error = render_image(&CONTEXT, &with_person(draw.clone(), cut), &front(), SIZE);
    assert!(matches!(error, Err(RenderError::PersonShape { found: 10, .. })));
    let lost = Camera { eye: Vec3::NAN, ..front() };
    assert!(matches!(render_image(&CONTEXT, &draw, &lost, SIZE), Err(RenderError::Camera { .. })));
    assert!(render_image(&CONTEXT, &draw, &front(), SIZE).is_ok(), "the device still works afterwards");
}

#[test]
fn an_empty_room_and_a_camera_that_looks_nowhere_still_give_a_picture() {
    let camera = Camera { eye: Vec3::Y, target: Vec3::Y, ..front() };
    for camera in [front(), camera, Camera { ortho_height_m: Some(4.0), ..front() }] {
        both(&SceneDraw::default(), &camera);
    }
}

#[test]
fn reports_say_what_drew_their_pictures_and_carry_the_legend() {
    let mut person = standing(0);
    person.heat = Some(vec![0.0; person.vertices.len()].into());
    let draw = with_person(Builder::new().floor().draw(), person);
    let shown = picture(&draw, &front(), SIZE, Backend::Cpu).expect("picture");
    assert!(shown.backend.contains("processor"), "{}", shown.backend);
    let bare = render_on_processor(&draw, &front(), SIZE).expect("picture");
    assert_ne!(shown.pixel(14, 18), bare.pixel(14, 18), "no legend");
    let painter = Painter::new(Backend::Auto).expect("some backend");
    assert_eq!(painter.fallback_reason().is_some(), painter.backend().contains("processor"));
}

#[test]
fn low_quality_shows_the_same_scene() {
    let mut draw = with_person(Builder::new().floor().draw(), standing(2));
    let high = render_image(&CONTEXT, &draw, &front(), SIZE).expect("picture");
    draw.look.quality = Quality::Low;
    let low = render_image(&CONTEXT, &draw, &front(), SIZE).expect("picture");
    let sum: f64 = high.rgba.iter().zip(&low.rgba).map(|(a, b)| f64::from(a.abs_diff(*b))).sum();
    assert!(sum / (high.rgba.len() as f64) < 4.0);
}

#[test]
fn the_pointer_picks_the_person_in_front_the_object_behind_and_nothing_beside() {
    let sofa = paint([0.2, 0.4, 0.6, 1.0]);
    let draw = with_person(
        Builder::new()
            .floor()
            .add(Category::Sofa, Vec3::new(-1.5, 0.0, -1.4), Vec3::new(1.5, 0.9, -0.6), sofa)
            .draw(),
        standing(7),
    );
    let camera = front();
    let picker = Picker::new(&draw.room);
    assert!(picker.is_for(&draw.room));
    let at = |point: Vec3| {
        let (x, y) = pixel_of(&camera, point);
        let share = [x as f32 / SIZE[0] as f32, y as f32 / SIZE[1] as f32];
        picker.pick(&draw, &camera, share, SIZE[0] as f32 / SIZE[1] as f32)
    };
    let chest = at(Vec3::new(0.0, 1.2, 0.1)).expect("the person");
    assert_eq!(chest.what, Picked::Person(PersonId(7)));
    assert!(chest.vertex.is_some() && chest.normal.z > 0.0 && (chest.at.y - 1.2).abs() < 0.1);
    assert_eq!(at(Vec3::new(1.2, 0.6, -0.6)).map(|p| p.what), Some(Picked::Object(ObjectId(1))));
    assert_eq!(at(Vec3::new(0.0, 2.3, 0.0)), None);
}
