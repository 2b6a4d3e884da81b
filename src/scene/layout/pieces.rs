//! Pieces made on the spot, for what no model file is needed: rugs, lamps, curtains, pictures, simple tables.
//! Each stands on y = 0 about its middle and looks along +z; what hangs on a wall has its back at z = 0.

use glam::{Affine3A, Quat, Vec2, Vec3};
use serde::{Deserialize, Serialize};

use crate::assets::{Material, Mesh};

use super::mesh::{Build, Surface, block, lathe, paint};
use super::seats;
use super::soft::{curtain, cushion};
use super::surface::painting;
use super::{LayoutError, Srgb};

/// What a placement places. Sizes are (width, height, depth) in metres.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Item {
    /// A model file by name.
    Model(String),
    /// A plain box.
    Block {
        /// Its size.
        size: (f32, f32, f32),
        /// Its colour.
        color: Srgb,
    },
    /// A pillow on its back.
    Cushion {
        /// Its size.
        size: (f32, f32, f32),
        /// Its colour.
        color: Srgb,
    },
    /// A flat rug with a border.
    Rug {
        /// Width and depth.
        size: (f32, f32),
        /// Colour of the middle.
        color: Srgb,
        /// Colour of the border.
        border: Srgb,
    },
    /// A curtain in folds; its back is at z = 0.
    Curtain {
        /// Width and height.
        size: (f32, f32),
        /// Its colour.
        color: Srgb,
    },
    /// A round rod along x, for curtains; its middle is 3 cm before z = 0.
    Rod {
        /// Its length.
        length_m: f32,
        /// Its colour.
        color: Srgb,
    },
    /// A lamp on a pole, or on a table when short.
    Lamp {
        /// Its height.
        height_m: f32,
        /// Colour of the lit shade.
        shade: Srgb,
        /// Colour of foot and pole.
        stand: Srgb,
    },
    /// A lamp that hangs; place its top at the ceiling: `at` is the lowest point.
    Pendant {
        /// From the ceiling to the lowest point.
        drop_m: f32,
        /// Colour of the shade.
        shade: Srgb,
    },
    /// A framed picture; its back is at z = 0.
    Picture {
        /// Width and height with the frame.
        size: (f32, f32),
        /// What it shows.
        art: Art,
        /// Its four colours.
        colors: (Srgb, Srgb, Srgb, Srgb),
        /// Colour of the frame.
        frame: Srgb,
    },
    /// A table or high counter: a board on four legs.
    Table {
        /// Its size.
        size: (f32, f32, f32),
        /// Colour of the board.
        top: Srgb,
        /// Colour of the legs.
        legs: Srgb,
    },
    /// A wardrobe with doors.
    Wardrobe {
        /// Its size.
        size: (f32, f32, f32),
        /// Number of doors.
        doors: u8,
        /// Colour of the case.
        case: Srgb,
        /// Colour of the doors.
        front: Srgb,
    },
    /// A computer screen on a foot.
    Monitor {
        /// Width of the screen.
        width_m: f32,
    },
    /// An open laptop.
    Laptop,
    /// A computer keyboard.
    Keyboard,
    /// A stack of books of these colours, the lowest first.
    Books(Vec<Srgb>),
    /// A sofa, or an armchair when it has one seat; its back is at -z.
    Sofa {
        /// Its size, to the top of the back.
        size: (f32, f32, f32),
        /// Height of the seat.
        seat_m: f32,
        /// Number of seat cushions.
        seats: u8,
        /// Width of each armrest; 0 for none.
        arm_m: f32,
        /// Colour of the fabric.
        fabric: Srgb,
        /// Colour of the feet.
        wood: Srgb,
    },
    /// A bed; its head is at -z.
    Bed {
        /// Its size, to the top of the mattress.
        size: (f32, f32, f32),
        /// Height of the headboard.
        headboard_m: f32,
        /// Colour of the cover.
        cover: Srgb,
        /// Colour of the frame.
        wood: Srgb,
    },
    /// A pouf.
    Pouf {
        /// Its size.
        size: (f32, f32, f32),
        /// Its colour.
        fabric: Srgb,
    },
    /// A padded bench without a back.
    Bench {
        /// Its size.
        size: (f32, f32, f32),
        /// Colour of the pad.
        fabric: Srgb,
        /// Colour of the legs.
        wood: Srgb,
    },
    /// An open shelf; its back is at -z.
    Shelf {
        /// Its size.
        size: (f32, f32, f32),
        /// Number of boards, lowest and top one with them.
        boards: u8,
        /// Its colour.
        color: Srgb,
    },
}

/// What a picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Art {
    /// A sun over hills: sky, sun, far hills, near hills.
    Hills,
    /// Nested arches: ground, outer, middle and inner arch.
    Arches,
}

/// A black that still shows its shape.
const BLACK: Srgb = Srgb(32, 33, 36);
/// Brushed aluminium.
const SILVER: Srgb = Srgb(178, 180, 184);

impl Item {
    /// The piece's surfaces; none for a model file.
    pub(super) fn surfaces(&self) -> Result<Vec<Surface>, LayoutError> {
        Ok(match self {
            Self::Model(_) => Vec::new(),
            Self::Block { size, color } => vec![plain(block(Vec3::ZERO, Vec3::from(*size)), *color)],
            Self::Cushion { size, color } => vec![plain(cushion(Vec3::from(*size)), *color)],
            Self::Rug { size, color, border } => rug(Vec2::from(*size), *color, *border),
            Self::Curtain { size, color } => vec![plain(curtain(size.0, size.1), *color)],
            Self::Rod { length_m, color } => vec![rod(*length_m, *color)],
            Self::Lamp { height_m, shade, stand } => lamp(*height_m, *shade, *stand),
            Self::Pendant { drop_m, shade } => pendant(*drop_m, *shade),
            Self::Picture { size, art, colors, frame } => {
                picture(*size, *art, [colors.0, colors.1, colors.2, colors.3], *frame)?
            }
            Self::Table { size, top, legs } => table(Vec3::from(*size), *top, *legs),
            Self::Wardrobe { size, doors, case, front } => wardrobe(Vec3::from(*size), *doors, *case, *front),
            Self::Monitor { width_m } => monitor(*width_m),
            Self::Laptop => laptop(),
            Self::Keyboard => keyboard(),
            Self::Books(colors) => books(colors),
            Self::Sofa { size, seat_m, seats, arm_m, fabric, wood } => {
                seats::sofa(Vec3::from(*size), *seat_m, *seats, *arm_m, *fabric, *wood)
            }
            Self::Bed { size, headboard_m, cover, wood } => {
                seats::bed(Vec3::from(*size), *headboard_m, *cover, *wood)
            }
            Self::Pouf { size, fabric } => seats::pouf(Vec3::from(*size), *fabric),
            Self::Bench { size, fabric, wood } => seats::bench(Vec3::from(*size), *fabric, *wood),
            Self::Shelf { size, boards, color } => seats::shelf(Vec3::from(*size), *boards, *color),
        })
    }
}

fn plain(mesh: Mesh, color: Srgb) -> Surface {
    Surface { mesh, material: paint(color), texture: None }
}

/// A surface that gives off `share` of its colour, like a lit shade or screen.
fn lit(mesh: Mesh, color: Srgb, share: f32) -> Surface {
    let mut material = paint(color);
    material.emissive = [0, 1, 2].map(|k| material.base_color[k] * share);
    Surface { mesh, material, texture: None }
}

fn metal(mesh: Mesh, color: Srgb) -> Surface {
    let material = Material { metallic: 0.4, roughness: 0.4, ..paint(color) };
    Surface { mesh, material, texture: None }
}

fn rug(size: Vec2, color: Srgb, border: Srgb) -> Vec<Surface> {
    // Thin enough to step on, thick enough not to flicker against the floor.
    let under = block(Vec3::ZERO, Vec3::new(size.x, 0.006, size.y));
    let rim = (size.min_element() * 0.08).min(0.14);
    let inner = Vec3::new(size.x - 2.0 * rim, 0.002, size.y - 2.0 * rim);
    let middle = block(Vec3::Y * 0.006, inner);
    let line = Vec3::new(inner.x - rim * 0.7, 0.0005, inner.z - rim * 0.7);
    let mut stripe = block(Vec3::Y * 0.008, line);
    let field = block(Vec3::Y * 0.0085, Vec3::new(line.x - 0.03, 0.0005, line.z - 0.03));
    stripe.append(&under, Affine3A::IDENTITY);
    vec![plain(stripe, border), plain(middle, color), plain(field, color)]
}

fn rod(length: f32, color: Srgb) -> Surface {
    let half = length * 0.5;
    let profile = [
        (0.0, -half - 0.03),
        (0.022, -half - 0.03),
        (0.022, -half),
        (0.012, -half),
        (0.012, half),
        (0.022, half),
        (0.022, half + 0.03),
        (0.0, half + 0.03),
    ];
    let mut mesh = Mesh::default();
    let lying = Quat::from_xyzw(0.0, 0.0, -std::f32::consts::FRAC_1_SQRT_2, std::f32::consts::FRAC_1_SQRT_2);
    let middle = Vec3::new(0.0, 0.022, 0.05);
    mesh.append(&lathe(&profile, 12), Affine3A::from_rotation_translation(lying, middle));
    for side in [-1.0, 1.0] {
        let foot = Vec3::new(side * (half - 0.06), 0.012, 0.0);
        mesh.cuboid(foot - Vec3::X * 0.008, foot + Vec3::new(0.008, 0.02, 0.05));
    }
    metal(mesh, color)
}

fn lamp(height: f32, shade: Srgb, stand: Srgb) -> Vec<Surface> {
    // Proportions of a usual floor lamp; a table lamp is the same, shorter and with a wider foot.
    let short = height < 0.8;
    let (foot, pole) = if short { (0.22 * height, 0.02) } else { (0.15, 0.012) };
    let (tall, wide) = if short { (height * 0.45, height * 0.34) } else { (0.30, 0.21) };
    let neck = height - tall;
    let stand_profile = [
        (0.0, 0.0),
        (foot, 0.0),
        (foot, 0.02),
        (pole, 0.028),
        (pole, neck + tall * 0.5),
        (0.0, neck + tall * 0.5),
    ];
    let (low, high, thin) = (wide, wide * 0.72, 0.004);
    let shade_profile = [
        (0.0, neck + tall * 0.5),
        (high, neck + tall * 0.5),
        (low - thin, neck),
        (low, neck),
        (high, height),
        (0.0, height),
    ];
    // The shade is a closed cap: the pole ends under its plate.
    let mut cap: Vec<(f32, f32)> = shade_profile.to_vec();
    cap[1].0 = high + (low - high) * 0.5 - thin;
    vec![metal(lathe(&stand_profile, 24), stand), lit(lathe(&cap, 28), shade, 0.45)]
}

fn pendant(drop: f32, shade: Srgb) -> Vec<Surface> {
    const TALL_M: f32 = 0.22;
    const WIDE_M: f32 = 0.22;
    let cable = [
        (0.0, TALL_M - 0.01),
        (0.004, TALL_M - 0.01),
        (0.004, drop - 0.02),
        (0.05, drop - 0.02),
        (0.05, drop),
        (0.0, drop),
    ];
    let bell = [
        (0.0, TALL_M * 0.75),
        (0.05, TALL_M * 0.72),
        (0.13, TALL_M * 0.45),
        (WIDE_M - 0.005, 0.0),
        (WIDE_M, 0.0),
        (0.14, TALL_M * 0.52),
        (0.06, TALL_M * 0.88),
        (0.0, TALL_M),
    ];
    let bulb = [
        (0.0, 0.05),
        (0.035, 0.07),
        (0.045, 0.10),
        (0.03, 0.14),
        (0.02, TALL_M * 0.74),
        (0.0, TALL_M * 0.75),
    ];
    vec![
        metal(lathe(&cable, 12), BLACK),
        plain(lathe(&bell, 28), shade),
        lit(lathe(&bulb, 14), Srgb(255, 236, 200), 1.0),
    ]
}

fn picture(size: (f32, f32), art: Art, colors: [Srgb; 4], frame: Srgb) -> Result<Vec<Surface>, LayoutError> {
    const BAR_M: f32 = 0.025;
    const DEEP_M: f32 = 0.022;
    let (w, h) = (size.0 * 0.5, size.1);
    let mut wood = Mesh::default();
    wood.cuboid(Vec3::new(-w, 0.0, 0.0), Vec3::new(-w + BAR_M, h, DEEP_M));
    wood.cuboid(Vec3::new(w - BAR_M, 0.0, 0.0), Vec3::new(w, h, DEEP_M));
    wood.cuboid(Vec3::new(-w + BAR_M, 0.0, 0.0), Vec3::new(w - BAR_M, BAR_M, DEEP_M));
    wood.cuboid(Vec3::new(-w + BAR_M, h - BAR_M, 0.0), Vec3::new(w - BAR_M, h, DEEP_M));
    let mut mount = Mesh::default();
    mount.cuboid(Vec3::new(-w + BAR_M, BAR_M, 0.0), Vec3::new(w - BAR_M, h - BAR_M, 0.008));
    let margin = BAR_M + 0.12 * size.0.min(size.1);
    let (x, low, high) = (w - margin, margin, h - margin);
    let mut canvas = Mesh::default();
    canvas.cuboid(Vec3::new(-x, low, 0.008), Vec3::new(x, high, 0.009));
    canvas.uvs = canvas
        .positions
        .iter()
        .map(|p| Vec2::new((p.x + x) / (2.0 * x), (high - p.y) / (high - low)))
        .collect();
    let texture = painting(art, (2.0 * x, high - low), colors)?;
    let material = Material { name: "painting".into(), ..paint(Srgb(255, 255, 255)) };
    Ok(vec![
        plain(wood, frame),
        plain(mount, Srgb(244, 241, 234)),
        Surface { mesh: canvas, material, texture: Some(texture) },
    ])
}

fn table(size: Vec3, top: Srgb, legs: Srgb) -> Vec<Surface> {
    const BOARD_M: f32 = 0.03;
    const LEG_M: f32 = 0.05;
    let board = block(Vec3::Y * (size.y - BOARD_M), Vec3::new(size.x, BOARD_M, size.z));
    let mut under = Mesh::default();
    let (x, z) = (size.x * 0.5 - LEG_M * 1.2, size.z * 0.5 - LEG_M * 1.2);
    for (sx, sz) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
        let leg = block(Vec3::new(sx * x, 0.0, sz * z), Vec3::new(LEG_M, size.y - BOARD_M, LEG_M));
        under.append(&leg, Affine3A::IDENTITY);
    }
    vec![plain(board, top), plain(under, legs)]
}

fn wardrobe(size: Vec3, doors: u8, case: Srgb, front: Srgb) -> Vec<Surface> {
    const DOOR_M: f32 = 0.02;
    const GAP_M: f32 = 0.004;
    let (plinth, depth) = (0.07, size.z - DOOR_M);
    let back = -size.z * 0.5;
    let mut body = Mesh::default();
    let half = size.x * 0.5;
    body.cuboid(Vec3::new(-half + 0.02, 0.0, back), Vec3::new(half - 0.02, plinth, back + depth - 0.03));
    body.cuboid(Vec3::new(-half, plinth, back), Vec3::new(half, size.y, back + depth));
    let (mut panels, mut handles) = (Mesh::default(), Mesh::default());
    let count = usize::from(doors.max(1));
    let step = size.x / count as f32;
    for k in 0..count {
        let left = -half + step * k as f32 + GAP_M * 0.5;
        let right = left + step - GAP_M;
        let z = back + depth;
        panels.cuboid(Vec3::new(left, plinth, z), Vec3::new(right, size.y - GAP_M, z + DOOR_M * 0.9));
        // Handles meet in pairs.
        let x = if k % 2 == 0 && k + 1 < count { right - 0.045 } else { left + 0.045 };
        let low = Vec3::new(x - 0.006, size.y * 0.45, z + DOOR_M * 0.9);
        handles.cuboid(low, low + Vec3::new(0.012, 0.22, 0.022));
    }
    vec![plain(body, case), plain(panels, front), metal(handles, BLACK)]
}

fn monitor(width: f32) -> Vec<Surface> {
    let high = width * 0.58;
    let lift = 0.11;
    let mut case = block(Vec3::ZERO, Vec3::new(width * 0.42, 0.012, 0.17));
    case.append(
        &block(Vec3::new(0.0, 0.012, -0.03), Vec3::new(0.05, lift + high * 0.5, 0.018)),
        Affine3A::IDENTITY,
    );
    case.append(&block(Vec3::Y * lift, Vec3::new(width, high, 0.03)), Affine3A::IDENTITY);
    let rim = 0.012;
    let mut screen = Mesh::default();
    screen.cuboid(
        Vec3::new(-width * 0.5 + rim, lift + rim, 0.015),
        Vec3::new(width * 0.5 - rim, lift + high - rim, 0.017),
    );
    vec![plain(case, BLACK), lit(screen, Srgb(64, 104, 148), 0.5)]
}

/// Turns by `degrees` about x, leaning the top back for negative values.
fn tilt(degrees: f32) -> Quat {
    let (sin, cos) = (f64::from(degrees).to_radians() * 0.5).sin_cos();
    Quat::from_xyzw(sin as f32, 0.0, 0.0, cos as f32)
}

fn laptop() -> Vec<Surface> {
    let (width, depth) = (0.33, 0.23);
    let mut case = block(Vec3::Y * 0.002, Vec3::new(width, 0.014, depth));
    case.append(&block(Vec3::ZERO, Vec3::new(width * 0.9, 0.002, depth * 0.8)), Affine3A::IDENTITY);
    let hinge = Vec3::new(0.0, 0.016, -depth * 0.5 + 0.003);
    let open = Affine3A::from_rotation_translation(tilt(-15.0), hinge);
    case.append(&block(Vec3::ZERO, Vec3::new(width, 0.215, 0.006)), open);
    let (mut screen, mut keys) = (Mesh::default(), Mesh::default());
    screen.append(&block(Vec3::new(0.0, 0.012, 0.0035), Vec3::new(width - 0.02, 0.19, 0.001)), open);
    keys.append(
        &block(Vec3::new(0.0, 0.016, -0.025), Vec3::new(width * 0.86, 0.0015, depth * 0.42)),
        Affine3A::IDENTITY,
    );
    keys.append(&block(Vec3::new(0.0, 0.016, 0.07), Vec3::new(0.1, 0.0008, 0.06)), Affine3A::IDENTITY);
    vec![metal(case, SILVER), lit(screen, Srgb(86, 128, 160), 0.5), plain(keys, BLACK)]
}

fn keyboard() -> Vec<Surface> {
    let case = block(Vec3::ZERO, Vec3::new(0.43, 0.014, 0.13));
    let mut keys = Mesh::default();
    for row in 0..5 {
        let z = -0.048 + 0.024 * row as f32;
        keys.append(&block(Vec3::new(0.0, 0.014, z), Vec3::new(0.41, 0.005, 0.02)), Affine3A::IDENTITY);
    }
    vec![plain(case, SILVER), plain(keys, Srgb(236, 236, 238))]
}

fn books(colors: &[Srgb]) -> Vec<Surface> {
    let mut height = 0.0;
    let mut surfaces = Vec::new();
    for (k, color) in colors.iter().enumerate() {
        // Each a little smaller and turned against the one below.
        let size = Vec3::new(0.25 - 0.02 * k as f32, 0.028 - 0.004 * (k % 2) as f32, 0.18 - 0.015 * k as f32);
        let turn = Affine3A::from_rotation_y([0.06f32, -0.09, 0.13][k % 3]);
        let (mut cover, mut pages) = (Mesh::default(), Mesh::default());
        let board = 0.003;
        cover.append(&block(Vec3::Y * height, Vec3::new(size.x, board, size.z)), turn);
        cover.append(&block(Vec3::Y * (height + size.y - board), Vec3::new(size.x, board, size.z)), turn);
        let spine = Vec3::new(-size.x * 0.5 + board * 0.5, height + board, 0.0);
        cover.append(&block(spine, Vec3::new(board, size.y - 2.0 * board, size.z)), turn);
        let inner = Vec3::new(size.x - 0.01, size.y - 2.0 * board, size.z - 0.008);
        pages.append(&block(Vec3::Y * (height + board), inner), turn);
        surfaces.extend([plain(cover, *color), plain(pages, Srgb(240, 234, 220))]);
        height += size.y;
    }
    surfaces
}
