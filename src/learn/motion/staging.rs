//! A room around a motion: a seat where it sits, a bed where it lies, floor where it treads, furniture where it does
//! not go, walls around it all. Made of the layouts' own pieces.

use std::collections::HashSet;

use glam::{Quat, Vec2, Vec3};
use rand::RngExt as _;

use crate::assets::Model;
use crate::body::joints::{LEFT_ANKLE, LEFT_KNEE, NECK, PELVIS, RIGHT_ANKLE, RIGHT_KNEE, SPINE3};
use crate::body::{Body, Region, VertexSubset, Workspace};
use crate::job::{Rng, Seed};
use crate::math::Aabb;
use crate::motion::local::heading_of;
use crate::motion::room_points::RoomPoints;
use crate::scene::layout::{
    Floor, Item, Layout, LayoutError, Outline, Placement, Srgb, bundled_furniture, compose,
};
use crate::scene::{BETAS, Category, Frame, direction_of};

/// Of the body's vertices every so-many-th counts for where the motion goes.
const STRIDE: usize = 24;
/// Of the frames likewise; a body moves a few centimetres in three.
const FRAME_STRIDE: usize = 3;
/// The space that a motion goes through is kept in cells of this size, metres.
const CELL_M: f32 = 0.05;
/// Between that space and furniture that has nothing to do with it, metres.
const FREE_M: f32 = 0.06;
/// How far skin may be inside the seat that bears it, metres.
const SINK_M: f32 = 0.03;
/// Smallest depth of a seat, metres.
const SHALLOWEST_M: f32 = 0.2;
/// Least time of sitting or lying that is furnished, frames.
const REST: usize = 8;
/// Attempts at standing a piece of furniture somewhere.
const TRIES: usize = 70;
/// Points kept of a room.
const POINTS: usize = 6144;

const WOOD: Srgb = Srgb(150, 110, 70);
const CLOTH: Srgb = Srgb(110, 120, 140);
const PAINT: Srgb = Srgb(225, 222, 215);

/// What a body does at one moment, as far as furniture matters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rest {
    /// On its feet, or on the move.
    None,
    /// On a seat this high, metres.
    Seat(f32),
    /// Lies this high over the floor, metres.
    Bed(f32),
}

/// A staged room.
#[derive(Clone, Debug)]
pub struct StagedRoom {
    /// How it is built.
    pub layout: Layout,
    /// Its surfaces.
    pub points: RoomPoints,
}

impl Default for StagedRoom {
    fn default() -> Self {
        let layout = Layout {
            name: "nothing".to_owned(),
            outline: Outline::Box(1.0, 1.0),
            height_m: 2.5,
            wall_thickness_m: 0.1,
            floor: Floor::Plain(WOOD),
            walls: PAINT,
            accent_walls: Default::default(),
            ceiling: PAINT,
            skirting: None,
            windows: Vec::new(),
            doors: Vec::new(),
            furniture: Vec::new(),
        };
        Self { layout, points: RoomPoints::default() }
    }
}

/// A body at one moment.
struct Moment {
    rest: Rest,
    pelvis: Vec3,
    heading: f32,
    /// Rearmost point of the back and buttocks from the pelvis, along the heading, metres.
    behind_m: f32,
}

/// Where a motion goes: one point for each cell that skin was in.
pub struct Swept {
    points: Vec<Vec3>,
}

impl Swept {
    /// Whether some of it is inside a box that grows by `margin_m` to all sides.
    fn meets(&self, piece: &Footprint, height_m: [f32; 2], margin_m: f32) -> bool {
        let [low, high] = [height_m[0] - margin_m, height_m[1] + margin_m];
        self.points.iter().any(|p| (low..high).contains(&p.y) && piece.holds(Vec2::new(p.x, p.z), margin_m))
    }

    /// The points, metres.
    pub fn points(&self) -> &[Vec3] {
        &self.points
    }
}

/// A turned rectangle of the floor.
#[derive(Clone, Copy, Debug)]
struct Footprint {
    centre: Vec2,
    half: Vec2,
    facing: f32,
}

impl Footprint {
    /// To its right hand (x) and its front (z).
    fn axes(&self) -> [Vec2; 2] {
        let front = direction_of(self.facing);
        [Vec2::new(front.y, -front.x), front]
    }

    fn holds(&self, p: Vec2, margin_m: f32) -> bool {
        let [right, front] = self.axes();
        let off = p - self.centre;
        off.dot(right).abs() < self.half.x + margin_m && off.dot(front).abs() < self.half.y + margin_m
    }

    fn corners(&self) -> [Vec2; 4] {
        let [right, front] = self.axes();
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, z)| self.centre + right * (x * self.half.x) + front * (z * self.half.y))
    }

    /// Separating axes: whether two rectangles overlap.
    fn meets(&self, other: &Self) -> bool {
        let apart = |axis: Vec2| {
            let span = |f: &Self| {
                let along = f.corners().map(|c| c.dot(axis));
                along.iter().fold([f32::INFINITY, f32::NEG_INFINITY], |[l, h], x| [l.min(*x), h.max(*x)])
            };
            let ([a, b], [c, d]) = (span(self), span(other));
            b < c || d < a
        };
        !self.axes().into_iter().chain(other.axes()).any(apart)
    }
}

/// Looks at a motion: where it goes and where it rests.
struct Watch<'a> {
    body: &'a Body,
    subset: VertexSubset,
    /// How many of the subset's first vertices are buttocks.
    seat: usize,
}

impl<'a> Watch<'a> {
    fn new(body: &'a Body) -> Self {
        let mut ids = body.regions.sample(Region::Butt).to_vec();
        let seat = ids.len();
        ids.extend((0..body.model.template.len() as u32).step_by(STRIDE));
        Self { body, subset: VertexSubset::new(&body.model, ids), seat }
    }

    fn pose(&self, frame: &Frame, workspace: &mut Workspace) {
        self.body.forward_posed(&frame.params(&[0.0; BETAS]), &frame.pose, &self.subset, workspace);
    }

    fn moment(&self, frame: &Frame, workspace: &Workspace) -> Moment {
        let joints = workspace.joints();
        let heading = heading_of(frame.rotation);
        let (front, pelvis) = (direction_of(heading), joints[PELVIS]);
        let skin = workspace.vertices();
        let behind = skin[..self.seat].iter().map(|v| Vec2::new(v.x - pelvis.x, v.z - pelvis.z).dot(front));
        Moment {
            rest: rest_of(joints, &skin[..self.seat], skin),
            pelvis,
            heading,
            behind_m: behind.fold(0.0, f32::min),
        }
    }
}

/// Sitting: buttocks off the floor, the weight behind the feet, no knee on the floor. Lying: the trunk level.
fn rest_of(joints: &[Vec3], buttocks: &[Vec3], skin: &[Vec3]) -> Rest {
    let lowest = |points: &[Vec3]| points.iter().map(|v| v.y).fold(f32::INFINITY, f32::min);
    let trunk = (joints[NECK] - joints[PELVIS]).normalize_or(Vec3::Y);
    if trunk.y.abs() < 0.5 && joints[PELVIS].y - lowest(skin) < 0.3 {
        return Rest::Bed(lowest(skin));
    }
    let flat = |p: Vec3| Vec2::new(p.x, p.z);
    let weight = flat(joints[PELVIS]).lerp(flat(joints[SPINE3]), 0.5);
    let feet = [LEFT_ANKLE, RIGHT_ANKLE].map(|j| weight.distance(flat(joints[j])));
    let seat = lowest(buttocks);
    let knees = joints[LEFT_KNEE].y.min(joints[RIGHT_KNEE].y);
    let seated = seat > 0.2
        && seat < 0.75
        && trunk.y > 0.5
        && feet[0].min(feet[1]) > 0.17
        && knees > 0.25
        && knees < joints[PELVIS].y + 0.2;
    if seated { Rest::Seat(seat) } else { Rest::None }
}

/// Where a motion goes.
pub fn swept(body: &Body, frames: &[Frame]) -> Swept {
    let watch = Watch::new(body);
    let mut workspace = Workspace::default();
    let mut cells = HashSet::new();
    let mut points = Vec::new();
    for frame in frames.iter().step_by(FRAME_STRIDE) {
        watch.pose(frame, &mut workspace);
        for vertex in workspace.vertices() {
            if cells.insert((*vertex / CELL_M).floor().as_ivec3()) {
                points.push(*vertex);
            }
        }
    }
    Swept { points }
}

/// What each frame of a motion does.
pub fn rests_of(body: &Body, frames: &[Frame]) -> Vec<Rest> {
    let watch = Watch::new(body);
    let mut workspace = Workspace::default();
    let rest = |frame: &Frame| {
        watch.pose(frame, &mut workspace);
        watch.moment(frame, &workspace).rest
    };
    frames.iter().map(rest).collect()
}

/// The times of rest of a motion: for each its middle.
fn rests(body: &Body, frames: &[Frame]) -> Vec<Moment> {
    let watch = Watch::new(body);
    let mut workspace = Workspace::default();
    let mut moments: Vec<Moment> = Vec::with_capacity(frames.len());
    for frame in frames {
        watch.pose(frame, &mut workspace);
        moments.push(watch.moment(frame, &workspace));
    }
    let still = |i: usize| {
        let near = (i + 3).min(moments.len() - 1);
        let calm = moments[i].pelvis.distance(moments[near].pelvis) < 0.02;
        calm && moments[i].rest != Rest::None
    };
    let mut found = Vec::new();
    let mut run = 0;
    for i in 0..=frames.len() {
        if i < frames.len() && still(i) {
            run += 1;
            continue;
        }
        if run >= REST.min(frames.len()) {
            found.push(i - 1 - run / 2);
        }
        run = 0;
    }
    let mut moments: Vec<Option<Moment>> = moments.into_iter().map(Some).collect();
    found.into_iter().filter_map(|i| moments[i].take()).collect()
}

/// Builds the room of a motion.
///
/// # Errors
/// [`LayoutError`] when the pieces don't compose, which is a mistake of the rules here.
pub fn stage(body: &Body, frames: &[Frame], seed: Seed) -> Result<StagedRoom, LayoutError> {
    let mut rng = seed.rng();
    let mut site = Site { swept: swept(body, frames), taken: Vec::new(), placements: Vec::new() };
    for moment in rests(body, frames) {
        site.bear(&moment, &mut rng);
    }
    let ways: Vec<Vec3> = frames.iter().step_by(5).map(|f| f.translation).collect();
    let wanted = rng.random_range(4..10);
    for _ in 0..TRIES {
        if site.taken.len() >= wanted {
            break;
        }
        site.furnish(&ways, &mut rng);
    }
    let layout = site.enclosed(&mut rng);
    let points = RoomPoints::of(&labelled_triangles(&layout)?, POINTS, seed.child("points", 0));
    Ok(StagedRoom { layout, points })
}

/// Every triangle of a layout's room with its class ([`point_class`]).
///
/// # Errors
/// [`LayoutError`] when the layout doesn't compose.
pub fn labelled_triangles(layout: &Layout) -> Result<Vec<([Vec3; 3], u8)>, LayoutError> {
    let model: Model = compose(layout, &bundled_furniture)?;
    let triangles = model.parts.iter().flat_map(|part| {
        let class = point_class(part.extras.as_deref().map_or(Category::Unlabeled, category_of));
        (0..part.mesh.triangles.len())
            .map(move |t| (part.mesh.corners(t).map(|p| part.file_from_mesh.transform_point3(p)), class))
    });
    Ok(triangles.collect())
}

fn category_of(extras: &str) -> Category {
    let value: serde_json::Value = serde_json::from_str(extras).unwrap_or_default();
    value["category"].as_str().and_then(Category::from_label).unwrap_or_default()
}

/// The class of a surface, as many as S3DIS has.
pub fn point_class(category: Category) -> u8 {
    match category {
        Category::Floor => 1,
        Category::Wall | Category::Window | Category::Column | Category::Beam => 2,
        Category::Ceiling => 3,
        Category::Chair | Category::Stool | Category::Seating => 4,
        Category::Sofa => 5,
        Category::Bed => 6,
        Category::CoffeeTable => 8,
        category if category.is_table() => 7,
        Category::Cabinet | Category::ChestOfDrawers | Category::Furniture => 9,
        Category::Shelving => 10,
        Category::Door => 11,
        Category::Counter | Category::Appliances | Category::KitchenIsland => 12,
        _ => 0,
    }
}

struct Site {
    swept: Swept,
    taken: Vec<Footprint>,
    placements: Vec<Placement>,
}

impl Site {
    /// Puts what bears a resting body under it.
    fn bear(&mut self, moment: &Moment, rng: &mut Rng) {
        match moment.rest {
            Rest::Seat(height_m) => self.seat(moment, height_m, rng),
            Rest::Bed(height_m) if height_m > 0.15 => self.bed(moment, height_m, rng),
            _ => {}
        }
    }

    fn seat(&mut self, moment: &Moment, height_m: f32, rng: &mut Rng) {
        let top_m = height_m + 0.01;
        let is_sofa = rng.random_bool(0.3);
        let width_m = if is_sofa { rng.random_range(1.2..2.0) } else { rng.random_range(0.42..0.6) };
        let rear_m = moment.behind_m - rng.random_range(0.01..0.05);
        let mut front_m: f32 = rng.random_range(0.26..0.36);
        let footprint = |front_m: f32| footprint_of(moment, [rear_m, front_m], width_m);
        // Feet and calves decide how far the seat reaches to the front.
        while front_m - rear_m > SHALLOWEST_M
            && self.swept.meets(&footprint(front_m), [0.0, top_m - SINK_M], -SINK_M)
        {
            front_m -= 0.04;
        }
        if front_m - rear_m <= SHALLOWEST_M || self.taken.iter().any(|t| t.meets(&footprint(front_m))) {
            return;
        }
        let category = match is_sofa {
            true => Category::Sofa,
            false if rng.random_bool(0.75) => Category::Chair,
            false => Category::Stool,
        };
        let seat = footprint(front_m);
        self.block(seat, top_m, CLOTH, category);
        let back = footprint_of(moment, [rear_m - 0.08, rear_m], width_m);
        let back_m = top_m + rng.random_range(0.3..0.5);
        let fits = !self.swept.meets(&back, [0.0, back_m], -0.01);
        if category != Category::Stool && fits {
            self.block(back, back_m, CLOTH, category);
        }
    }

    fn bed(&mut self, moment: &Moment, top_m: f32, rng: &mut Rng) {
        let half = Vec2::new(rng.random_range(0.45..0.8), 1.0);
        // The pelvis lies a little nearer to the feet than to the head's end.
        let centre = Vec2::new(moment.pelvis.x, moment.pelvis.z) - direction_of(moment.heading) * 0.05;
        let bed = Footprint { centre, half, facing: moment.heading };
        if !self.taken.iter().any(|t| t.meets(&bed)) {
            self.block(bed, top_m + 0.01, CLOTH, Category::Bed);
        }
    }

    fn block(&mut self, footprint: Footprint, height_m: f32, color: Srgb, category: Category) {
        let size = (2.0 * footprint.half.x, height_m, 2.0 * footprint.half.y);
        self.place(Item::Block { size, color }, footprint, category);
    }

    fn place(&mut self, item: Item, footprint: Footprint, category: Category) {
        self.placements.push(Placement {
            item,
            name: format!("{} {}", category.label(), self.placements.len()),
            category: category.label().to_owned(),
            at: (footprint.centre.x, 0.0, footprint.centre.y),
            yaw_deg: footprint.facing.to_degrees(),
            scale: 1.0,
            on: None,
            tint: None,
            finish: Default::default(),
        });
        self.taken.push(footprint);
    }

    /// Tries once to stand something beside the way.
    fn furnish(&mut self, ways: &[Vec3], rng: &mut Rng) {
        let (item, category, (width_m, height_m, depth_m)) = furniture(rng);
        let from = ways[rng.random_range(0..ways.len())];
        let towards = direction_of(rng.random_range(0.0..std::f32::consts::TAU));
        let off_m = rng.random_range(0.35..1.5) + depth_m * 0.5;
        let quarter = std::f32::consts::FRAC_PI_2 * rng.random_range(0..4) as f32;
        let facing = quarter + if rng.random_bool(0.3) { rng.random_range(-0.7..0.7) } else { 0.0 };
        let centre = Vec2::new(from.x, from.z) + towards * off_m;
        let footprint = Footprint { centre, half: Vec2::new(width_m, depth_m) * 0.5, facing };
        let blocked = self.swept.meets(&footprint, [0.0, height_m], FREE_M)
            || self.taken.iter().any(|t| t.meets(&footprint));
        if !blocked {
            self.place(item, footprint, category);
        }
    }

    /// The layout: walls around motion and furniture.
    fn enclosed(self, rng: &mut Rng) -> Layout {
        let corners = self.taken.iter().flat_map(Footprint::corners).map(|c| Vec3::new(c.x, 0.0, c.y));
        let bounds = Aabb::of(corners.chain(self.swept.points.iter().copied()));
        let mut margin = || rng.random_range(0.12..0.9);
        let (low_x, low_z) = (bounds.min.x - margin(), bounds.min.z - margin());
        let (high_x, high_z) = (bounds.max.x + margin(), bounds.max.z + margin());
        // Clockwise seen from above: from +x towards +z.
        let outline = vec![(low_x, low_z), (high_x, low_z), (high_x, high_z), (low_x, high_z)];
        Layout {
            name: "staged".to_owned(),
            outline: Outline::Polygon(outline),
            height_m: bounds.max.y.max(2.3) + 0.2,
            furniture: self.placements,
            ..StagedRoom::default().layout
        }
    }
}

/// A rectangle about a resting body, from `along_m[0]` to `along_m[1]` before its pelvis.
fn footprint_of(moment: &Moment, along_m: [f32; 2], width_m: f32) -> Footprint {
    let middle = 0.5 * (along_m[0] + along_m[1]);
    let centre = Vec2::new(moment.pelvis.x, moment.pelvis.z) + direction_of(moment.heading) * middle;
    let half = Vec2::new(0.5 * width_m, 0.5 * (along_m[1] - along_m[0]));
    Footprint { centre, half, facing: moment.heading }
}

/// Something that stands about in rooms: the piece, what it is, its size.
fn furniture(rng: &mut Rng) -> (Item, Category, (f32, f32, f32)) {
    let mut size = |w: [f32; 2], h: [f32; 2], d: [f32; 2]| {
        let mut between = |[low, high]: [f32; 2]| rng.random_range(low..high);
        (between(w), between(h), between(d))
    };
    let table = |size, category| (Item::Table { size, top: WOOD, legs: WOOD }, category, size);
    let block = |size, category| (Item::Block { size, color: WOOD }, category, size);
    let made = [
        table(size([1.0, 1.8], [0.7, 0.78], [0.6, 0.9]), Category::DiningTable),
        table(size([0.7, 1.2], [0.35, 0.48], [0.4, 0.6]), Category::CoffeeTable),
        block(size([0.8, 1.8], [1.6, 2.1], [0.5, 0.65]), Category::Cabinet),
        block(size([0.6, 1.4], [0.7, 1.0], [0.4, 0.5]), Category::ChestOfDrawers),
        block(size([0.38, 0.5], [0.4, 0.5], [0.38, 0.5]), Category::Stool),
        block(size([1.2, 2.4], [0.86, 0.95], [0.55, 0.7]), Category::Counter),
        {
            let size = size([0.7, 1.2], [1.4, 2.0], [0.28, 0.4]);
            (Item::Shelf { size, boards: 5, color: WOOD }, Category::Shelving, size)
        },
        {
            let size = size([1.5, 2.2], [0.75, 0.9], [0.8, 0.95]);
            let sofa = Item::Sofa { size, seat_m: 0.43, seats: 2, arm_m: 0.15, fabric: CLOTH, wood: WOOD };
            (sofa, Category::Sofa, size)
        },
        {
            let size = size([0.9, 1.8], [0.4, 0.55], [1.95, 2.1]);
            (Item::Bed { size, headboard_m: 0.9, cover: CLOTH, wood: WOOD }, Category::Bed, size)
        },
        {
            let size = size([0.9, 1.3], [0.42, 0.48], [0.35, 0.45]);
            (Item::Bench { size, fabric: CLOTH, wood: WOOD }, Category::Seating, size)
        },
    ];
    let chosen = rng.random_range(0..made.len());
    made.into_iter().nth(chosen).unwrap_or_else(|| block((0.4, 0.45, 0.4), Category::Stool))
}

/// A body turned about the vertical through the origin.
pub fn turned(frame: &Frame, by: f32, rest_pelvis: Vec3) -> Frame {
    let turn = Quat::from_rotation_y(by);
    Frame {
        translation: turn * (frame.translation + rest_pelvis) - rest_pelvis,
        rotation: (turn * frame.rotation).normalize(),
        ..frame.clone()
    }
}
