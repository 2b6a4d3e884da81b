use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::image::{SIDE, SceneImage, Valid};
use super::label_of;
use super::view::{Intrinsics, View};
use crate::job::{Cancelled, Ticker};
use crate::math::Aabb;
use crate::scene::{Category, PACKET, PacketCaster, Room, RoomGeometry};

/// Pixels along each side of a packet's tile.
const TILE: u32 = 4;
/// A room without a ceiling is closed at least this high above its lowest point, in metres; as the distance field
/// closes it.
const ROOM_HEIGHT_M: f32 = 2.4;

/// What a ray sees that leaves the room through a hole: open scans have no walls or ceiling.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Enclosure {
    /// The room is closed by virtual walls, floor and ceiling at the box around its objects (at least 2.4 m
    /// high), as PSI closed the open scans of PROX (§4.1.1). Seen from inside only.
    #[default]
    Box,
    /// Nothing: depth 0, label 0.
    Open,
}

/// Depth and semantics of a room from one view.
#[derive(Clone, Debug, PartialEq)]
pub struct Capture {
    /// The camera.
    pub view: View,
    /// Depth along the optical axis in metres, row by row; 0 where nothing is.
    pub depth_m: Vec<f32>,
    /// What is seen, as [`super::label_of`] numbers it, row by row; 0 where nothing is.
    pub labels: Vec<u8>,
}

/// Captures views of one room. Every surface is solid to it, glass too.
#[derive(Debug)]
pub struct Sensor<'a> {
    geometry: &'a RoomGeometry,
    /// Label of each triangle of the ray tree.
    labels: Vec<u8>,
    /// The virtual walls, if any.
    walls: Option<Aabb>,
}

/// The pixels of a picture that are captured: columns and rows from the first, on.
#[derive(Clone, Copy, Debug)]
struct Window {
    first: [u32; 2],
    size: [u32; 2],
}

impl<'a> Sensor<'a> {
    /// A sensor for a room and the geometry derived from it, closed by [`Enclosure::Box`].
    pub fn new(room: &Room, geometry: &'a RoomGeometry) -> Self {
        Self::with_enclosure(room, geometry, Enclosure::default())
    }

    /// The same with a choice of what closes the room.
    pub fn with_enclosure(room: &Room, geometry: &'a RoomGeometry, enclosure: Enclosure) -> Self {
        let mut known = std::collections::BTreeMap::new();
        known.extend(room.objects.iter().map(|o| (o.id, label_of(o.category))));
        let unlabeled = label_of(Category::Unlabeled);
        let label = |t: usize| geometry.object_of(t).and_then(|id| known.get(&id).copied());
        let labels = (0..geometry.bvh.triangles().len()).map(|t| label(t).unwrap_or(unlabeled)).collect();
        let walls = (enclosure == Enclosure::Box && !geometry.bounds.is_empty())
            .then(|| enclosing_box(&geometry.bounds));
        Self { geometry, labels, walls }
    }

    /// The room's geometry.
    pub fn geometry(&self) -> &'a RoomGeometry {
        self.geometry
    }

    /// Depth and semantics at the view's own resolution, a ray through the middle of each pixel.
    pub fn capture(&self, view: &View) -> Capture {
        let size = [view.intrinsics.width, view.intrinsics.height];
        let (depth_m, labels) = self.cast(view, Window { first: [0, 0], size });
        Capture { view: *view, depth_m, labels }
    }

    /// The networks' 128 x 128 image of a view, its rays cast at that resolution straight away: kept aspect,
    /// centred, padded. Labels are those of single points, never mixtures.
    pub fn scene_image(&self, view: &View) -> SceneImage {
        let (square, valid) = Valid::of(view);
        let window = Window { first: [valid.left, valid.top], size: [valid.width, valid.height] };
        let (depth_m, labels) = self.cast(&square, window);
        SceneImage::padded(square, valid, &depth_m, &labels)
    }

    /// [`Sensor::scene_image`] of many views on all threads, in their order.
    ///
    /// # Errors
    /// [`Cancelled`] once the user cancelled.
    pub fn scene_images(&self, views: &[View], ticker: &Ticker) -> Result<Vec<SceneImage>, Cancelled> {
        let one = |view: &View| {
            ticker.check()?;
            Ok(self.scene_image(view))
        };
        views.par_iter().map(one).collect()
    }

    /// A quick look with `width` columns: for judging many views.
    pub fn thumbnail(&self, view: &View, width: u32) -> Capture {
        let lens = view.intrinsics;
        let scale = width as f32 / lens.width as f32;
        let height = ((lens.height as f32 * scale).round() as u32).max(1);
        let intrinsics = Intrinsics { width, height, focal_px: lens.focal_px * scale };
        self.capture(&View { intrinsics, ..*view })
    }

    fn cast(&self, view: &View, window: Window) -> (Vec<f32>, Vec<u8>) {
        let pixels = window.size[0] as usize * window.size[1] as usize;
        let (mut depth_m, mut labels) = (vec![0.0; pixels], vec![0; pixels]);
        let mut caster = self.geometry.bvh.packets_from(view.eye());
        for top in (0..window.size[1]).step_by(TILE as usize) {
            for left in (0..window.size[0]).step_by(TILE as usize) {
                self.cast_tile(view, window, [left, top], &mut caster, &mut depth_m, &mut labels);
            }
        }
        (depth_m, labels)
    }

    /// Casts the tile at `corner` (counted in the window); pixels beyond the window are cast for nothing.
    fn cast_tile(
        &self,
        view: &View,
        window: Window,
        corner: [u32; 2],
        caster: &mut PacketCaster<'_>,
        depth_m: &mut [f32],
        labels: &mut [u8],
    ) {
        let place = |i: usize| [corner[0] + i as u32 % TILE, corner[1] + i as u32 / TILE];
        let directions: [Vec3; PACKET] = std::array::from_fn(|i| {
            let [x, y] = place(i);
            let middle = Vec2::new((window.first[0] + x) as f32 + 0.5, (window.first[1] + y) as f32 + 0.5);
            view.direction(middle)
        });
        let hits = caster.cast(&directions, f32::INFINITY);
        for i in 0..PACKET {
            let [x, y] = place(i);
            if x >= window.size[0] || y >= window.size[1] {
                continue;
            }
            let at = y as usize * window.size[0] as usize + x as usize;
            (depth_m[at], labels[at]) = match hits.t[i].is_finite() {
                true => (hits.t[i], self.labels[hits.triangle[i]]),
                false => self.virtual_wall(view.eye(), directions[i]),
            };
        }
    }

    /// Where a ray that hit nothing leaves the box of virtual walls; nothing from outside of it.
    fn virtual_wall(&self, eye: Vec3, direction: Vec3) -> (f32, u8) {
        let Some(walls) = self.walls.filter(|w| w.contains(eye)) else { return (0.0, 0) };
        let exit = |axis: usize| match direction[axis] {
            d if d > 1e-9 => (walls.max[axis] - eye[axis]) / d,
            d if d < -1e-9 => (walls.min[axis] - eye[axis]) / d,
            _ => f32::INFINITY,
        };
        let (across, up) = (exit(0).min(exit(2)), exit(1));
        let category = match up < across {
            true if direction.y > 0.0 => Category::Ceiling,
            true => Category::Floor,
            false => Category::Wall,
        };
        (across.min(up), label_of(category))
    }
}

impl Capture {
    /// The networks' image of this capture: the long side resized to 128 by nearest pixel (depth too: a mean
    /// over an edge would be a surface in mid air), centred on an empty square.
    pub fn scene_image(&self) -> SceneImage {
        let lens = self.view.intrinsics;
        let (square, valid) = Valid::of(&self.view);
        let scale = square.intrinsics.focal_px / lens.focal_px;
        let nearest = |i: u32, first: u32, limit: u32| {
            let from_middle = (first + i) as f32 + 0.5 - 0.5 * SIDE as f32;
            let at = from_middle / scale + 0.5 * limit as f32;
            (at.max(0.0) as usize).min(limit as usize - 1)
        };
        let pixels = (0..valid.height).flat_map(|y| (0..valid.width).map(move |x| (x, y)));
        let sources = pixels.map(|(x, y)| {
            nearest(y, valid.top, lens.height) * lens.width as usize + nearest(x, valid.left, lens.width)
        });
        let (depth_m, labels): (Vec<f32>, Vec<u8>) =
            sources.map(|at| (self.depth_m[at], self.labels[at])).unzip();
        SceneImage::padded(square, valid, &depth_m, &labels)
    }
}

/// The box that closes a room: that around its objects, at least 2.4 m high.
pub(super) fn enclosing_box(bounds: &Aabb) -> Aabb {
    let top = bounds.max.y.max(bounds.min.y + ROOM_HEIGHT_M);
    Aabb { min: bounds.min, max: Vec3::new(bounds.max.x, top, bounds.max.z) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::sensor::tests_room::{furnished, open_floor};

    #[test]
    fn depth_is_measured_along_the_axis_and_labels_are_those_of_the_objects() {
        let (room, geometry) = furnished();
        let sensor = Sensor::new(&room, geometry);
        // Looking along -z from the middle at the wall 2.5 m away, at a height over all furniture.
        let eye = Vec3::new(0.0, 1.6, 0.0);
        let lens = Intrinsics { width: 64, height: 48, focal_px: 60.0 };
        let capture = sensor.capture(&View::look_at(eye, eye + Vec3::NEG_Z, lens));
        for (x, y) in [(32, 24), (0, 20), (63, 20)] {
            let depth_m = capture.depth_m[y * 64 + x];
            assert!((depth_m - 2.5).abs() < 1e-3, "pixel ({x}, {y}) is {depth_m} m deep, not the wall's 2.5");
            assert_eq!(capture.labels[y * 64 + x], label_of(Category::Wall));
        }
        let down =
            sensor.capture(&View::look_at(Vec3::new(-1.2, 2.0, -2.0), Vec3::new(-1.2, 0.0, -2.0), lens));
        assert_eq!(down.labels[24 * 64 + 32], label_of(Category::Sofa));
        assert!((down.depth_m[24 * 64 + 32] - 1.55).abs() < 1e-3, "the seat is 45 cm high");
    }

    #[test]
    fn an_open_scan_is_closed_by_virtual_walls_or_left_open() {
        let (room, geometry) = open_floor();
        let eye = Vec3::new(0.0, 1.5, 0.0);
        let lens = Intrinsics { width: 9, height: 9, focal_px: 4.0 };
        let view = View::look_at(eye, eye + Vec3::X, lens);
        let closed = Sensor::new(&room, geometry).capture(&view);
        assert!((closed.depth_m[4 * 9 + 4] - 3.0).abs() < 1e-4);
        assert_eq!(closed.labels[4 * 9 + 4], label_of(Category::Wall));
        let up = Sensor::new(&room, geometry).capture(&View::look_at(eye, eye + Vec3::Y, lens));
        assert!((up.depth_m[4 * 9 + 4] - 0.89).abs() < 1e-4, "2.4 m over the floor's underside");
        assert_eq!(up.labels[4 * 9 + 4], label_of(Category::Ceiling));
        let open = Sensor::with_enclosure(&room, geometry, Enclosure::Open).capture(&view);
        assert_eq!((open.depth_m[4 * 9 + 4], open.labels[4 * 9 + 4]), (0.0, 0));
    }

    #[test]
    fn a_big_capture_resized_is_the_image_cast_at_once() {
        let (room, geometry) = furnished();
        let sensor = Sensor::new(&room, geometry);
        let lens = Intrinsics { width: 640, height: 360, focal_px: 355.0 };
        let view = View::look_at(Vec3::new(2.0, 1.8, 1.9), Vec3::new(-1.0, 0.5, -1.0), lens);
        let (direct, resized) = (sensor.scene_image(&view), sensor.capture(&view).scene_image());
        assert_eq!(direct.valid, resized.valid);
        let same = direct.labels.iter().zip(&resized.labels).filter(|(a, b)| a == b).count();
        assert!(same > SIDE * SIDE * 98 / 100, "{same} labels agree");
        let pairs = direct.depth_m.iter().zip(&resized.depth_m);
        let close = pairs.filter(|(a, b)| (*a - *b).abs() < 0.1).count();
        assert!(close > SIDE * SIDE * 97 / 100, "{close} depths agree");
    }
}
