//! Small things made on the spot, for what no free model could be found: food, kitchenware, paper, what lies on
//! desks. Each stands on y = 0 about its middle; the side that people use looks along +z. Metres.

use glam::{Affine3A, Quat, Vec2, Vec3};

use crate::assets::{Material, Mesh, Model};

use super::Srgb;
use super::mesh::{Build, ModelBuilder, Surface, block, lathe, paint};
use super::pieces::Item;
use super::soft::{cushion, soft_block};

/// A thing's name and how it is made.
type Recipe = (&'static str, fn() -> Vec<Surface>);

/// Everything that can be made, in the order of the names.
const RECIPES: &[Recipe] = &[
    ("apple_green", || apple(Srgb(126, 168, 52))),
    ("apple_red", || apple(Srgb(176, 38, 36))),
    ("banana", banana),
    ("book_blue", || book(Srgb(44, 70, 110), Vec3::new(0.15, 0.024, 0.22))),
    ("book_green", || book(Srgb(58, 92, 66), Vec3::new(0.13, 0.034, 0.2))),
    ("book_open", || open_book(Srgb(124, 44, 40), 0.16, 0.23)),
    ("book_open_small", || open_book(Srgb(40, 52, 78), 0.12, 0.18)),
    ("book_red", || book(Srgb(136, 44, 40), Vec3::new(0.17, 0.018, 0.24))),
    ("bowl_blue", || bowl(Srgb(92, 122, 158), 0.08)),
    ("bowl_white", || bowl(Srgb(238, 236, 230), 0.075)),
    ("broccoli", broccoli),
    ("can", can),
    ("carrot", carrot),
    ("crisps", || packet(Srgb(206, 62, 40))),
    ("cushion_grey", || soft_cushion(Srgb(128, 132, 138), 0.4)),
    ("cushion_ochre", || soft_cushion(Srgb(196, 150, 62), 0.45)),
    ("donut_chocolate", || donut(Srgb(88, 52, 34))),
    ("donut_pink", || donut(Srgb(232, 150, 170))),
    ("frying_pan", frying_pan),
    ("jumper", || folded(Srgb(96, 118, 106))),
    ("keyboard_full", || made(&Item::Keyboard)),
    ("keyboard_small", keyboard_small),
    ("laptop_100", || laptop(10.0, SILVER)),
    ("laptop_115", || laptop(25.0, GRAPHITE)),
    ("laptop_130", || laptop(40.0, SILVER)),
    ("magazine", || sheets(Vec2::new(0.21, 0.28), 0.005, Srgb(198, 92, 70))),
    ("monitor_22", || made(&Item::Monitor { width_m: 0.5 })),
    ("monitor_27", || made(&Item::Monitor { width_m: 0.61 })),
    ("mouse_black", || mouse(GRAPHITE)),
    ("mouse_white", || mouse(Srgb(236, 236, 236))),
    ("napkin", || sheets(Vec2::new(0.12, 0.17), 0.003, Srgb(238, 236, 228))),
    ("notebook", || sheets(Vec2::new(0.15, 0.21), 0.009, Srgb(40, 44, 52))),
    ("orange", orange),
    ("paper", || sheets(Vec2::new(0.21, 0.297), 0.001, Srgb(248, 248, 246))),
    ("paper_stack", || sheets(Vec2::new(0.21, 0.297), 0.012, Srgb(246, 245, 240))),
    ("parcel", || parcel(Vec3::new(0.24, 0.12, 0.17))),
    ("parcel_small", || parcel(Vec3::new(0.16, 0.09, 0.12))),
    ("pizza", || pizza(8)),
    ("pizza_begun", || pizza(6)),
    ("plate_side", || plate(0.09, Srgb(240, 238, 232))),
    ("plate_wide", || plate(0.13, Srgb(230, 234, 236))),
    ("sandwich", sandwich),
    ("saucepan", saucepan),
    ("scarf", || folded(Srgb(150, 64, 60))),
];

const SILVER: Srgb = Srgb(178, 180, 184);
const GRAPHITE: Srgb = Srgb(58, 60, 66);
const CRUST: Srgb = Srgb(190, 134, 74);
const PAPER: Srgb = Srgb(240, 234, 220);

/// Names of everything that can be made on the spot, in alphabetical order.
pub fn made_names() -> impl Iterator<Item = &'static str> {
    RECIPES.iter().map(|(name, _)| *name)
}

/// The thing of this name as a model of one node; `None` if there is no such recipe.
pub fn made_thing(name: &str) -> Option<Model> {
    let (name, recipe) = RECIPES.iter().find(|(known, _)| *known == name)?;
    let mut model = ModelBuilder::new(name);
    model.object(name, "objects", Affine3A::IDENTITY, recipe());
    Some(model.finish())
}

fn made(item: &Item) -> Vec<Surface> {
    item.surfaces().unwrap_or_default()
}

fn plain(mesh: Mesh, color: Srgb) -> Surface {
    Surface { mesh, material: paint(color), texture: None }
}

fn shiny(mesh: Mesh, color: Srgb) -> Surface {
    let material = Material { roughness: 0.35, ..paint(color) };
    Surface { mesh, material, texture: None }
}

fn metal(mesh: Mesh, color: Srgb) -> Surface {
    let material = Material { metallic: 0.5, roughness: 0.35, ..paint(color) };
    Surface { mesh, material, texture: None }
}

fn lit(mesh: Mesh, color: Srgb) -> Surface {
    let mut material = paint(color);
    material.emissive = [0, 1, 2].map(|k| material.base_color[k] * 0.5);
    Surface { mesh, material, texture: None }
}

/// A solid of revolution lying about the line from `from` to `to`; `radii` are given at even steps along it.
fn rod(from: Vec3, to: Vec3, radii: &[f32]) -> Mesh {
    let long = from.distance(to);
    let last = (radii.len() - 1) as f32;
    let mut profile = vec![(0.0, 0.0)];
    profile.extend(radii.iter().enumerate().map(|(i, r)| (*r, long * i as f32 / last)));
    profile.push((0.0, long));
    let turn = Quat::from_rotation_arc(Vec3::Y, (to - from).normalize_or(Vec3::Y));
    let mut mesh = Mesh::default();
    mesh.append(&lathe(&profile, 14), Affine3A::from_rotation_translation(turn, from));
    mesh
}

/// A ball squeezed to `half` sizes on y = 0.
fn ball(half: Vec3) -> Mesh {
    let profile: Vec<(f32, f32)> = (0..=10)
        .map(|i| {
            let (sin, cos) = (std::f64::consts::PI * f64::from(i) / 10.0).sin_cos();
            (if i == 0 || i == 10 { 0.0 } else { sin as f32 }, 1.0 - cos as f32)
        })
        .collect();
    let mut mesh = lathe(&profile, 18);
    for (p, n) in mesh.positions.iter_mut().zip(&mut mesh.normals) {
        *p *= half;
        *n = (*n / half).normalize_or(Vec3::Y);
    }
    mesh
}

fn at(mesh: &Mesh, x: f32, y: f32, z: f32) -> Mesh {
    let mut moved = Mesh::default();
    moved.append(mesh, Affine3A::from_translation(Vec3::new(x, y, z)));
    moved
}

fn joined(meshes: &[Mesh]) -> Mesh {
    let mut all = Mesh::default();
    meshes.iter().for_each(|m| all.append(m, Affine3A::IDENTITY));
    all
}

// What lies on desks ------------------------------------------------------------------------------------------

/// `lean_deg` is how far the lid leans back from upright.
fn laptop(lean_deg: f32, case_color: Srgb) -> Vec<Surface> {
    let (width, depth, thick) = (0.32, 0.22, 0.016);
    let case = block(Vec3::ZERO, Vec3::new(width, thick, depth));
    let hinge = Vec3::new(0.0, thick, -depth * 0.5 + 0.004);
    let open = Affine3A::from_rotation_translation(Quat::from_rotation_x(-lean_deg.to_radians()), hinge);
    let (mut lid, mut screen, mut keys) = (case, Mesh::default(), Mesh::default());
    lid.append(&block(Vec3::ZERO, Vec3::new(width, 0.21, 0.006)), open);
    screen.append(&block(Vec3::new(0.0, 0.012, 0.0035), Vec3::new(width - 0.02, 0.186, 0.001)), open);
    for row in 0..5 {
        let z = -0.072 + 0.0185 * row as f32;
        keys.append(
            &block(Vec3::new(0.0, thick, z), Vec3::new(width * 0.88, 0.0015, 0.015)),
            Affine3A::IDENTITY,
        );
    }
    keys.append(&block(Vec3::new(0.0, thick, 0.062), Vec3::new(0.1, 0.0006, 0.06)), Affine3A::IDENTITY);
    vec![metal(lid, case_color), lit(screen, Srgb(86, 128, 160)), plain(keys, Srgb(32, 33, 36))]
}

fn keyboard_small() -> Vec<Surface> {
    let case = block(Vec3::ZERO, Vec3::new(0.28, 0.01, 0.115));
    let mut keys = Mesh::default();
    for (row, column) in (0..5).flat_map(|r| (0..13).map(move |c| (r, c))) {
        let foot = Vec3::new(-0.125 + 0.0208 * column as f32, 0.01, -0.042 + 0.021 * row as f32);
        keys.append(&block(foot, Vec3::new(0.017, 0.004, 0.017)), Affine3A::IDENTITY);
    }
    vec![plain(case, GRAPHITE), plain(keys, Srgb(90, 93, 100))]
}

fn mouse(color: Srgb) -> Vec<Surface> {
    let mut shell = ball(Vec3::new(0.031, 0.036, 0.055));
    // The lower half is flat: a mouse is half an egg.
    shell.positions.iter_mut().for_each(|p| p.y = (p.y - 0.036).max(0.0));
    let wheel = rod(Vec3::new(-0.004, 0.031, -0.028), Vec3::new(0.004, 0.031, -0.028), &[0.006, 0.006]);
    vec![shiny(shell, color), plain(wheel, Srgb(20, 20, 22))]
}

fn book(cover: Srgb, size: Vec3) -> Vec<Surface> {
    let board = 0.003;
    let mut covers = block(Vec3::ZERO, Vec3::new(size.x, board, size.z));
    covers.append(&block(Vec3::Y * (size.y - board), Vec3::new(size.x, board, size.z)), Affine3A::IDENTITY);
    let spine = Vec3::new(-size.x * 0.5 + board * 0.5, board, 0.0);
    covers.append(&block(spine, Vec3::new(board, size.y - 2.0 * board, size.z)), Affine3A::IDENTITY);
    let title = block(Vec3::new(0.0, size.y, -size.z * 0.2), Vec3::new(size.x * 0.6, 0.0004, size.z * 0.12));
    let pages =
        block(Vec3::new(0.001, board, 0.0), Vec3::new(size.x - 0.008, size.y - 2.0 * board, size.z - 0.008));
    vec![plain(covers, cover), plain(pages, PAPER), plain(title, Srgb(226, 208, 160))]
}

/// An open book on its back: two bowed blocks of pages over flat covers. `page` is the width of one page.
fn open_book(cover: Srgb, page: f32, height: f32) -> Vec<Surface> {
    const STEPS: usize = 7;
    let back = block(Vec3::ZERO, Vec3::new(2.0 * page + 0.012, 0.003, height + 0.008));
    let mut pages = Mesh::default();
    let rise = |t: f32| 0.003 + 0.016 * (1.0 - t).powi(2) * (1.0 - (-18.0 * t).exp()) + 0.004 * (1.0 - t);
    let mut lines = Mesh::default();
    for side in [-1.0_f32, 1.0] {
        for k in 0..STEPS {
            let (t0, t1) = (k as f32 / STEPS as f32, (k + 1) as f32 / STEPS as f32);
            let (x0, x1) = (side * page * t0, side * page * t1);
            let (x0, y0, x1, y1) =
                if side > 0.0 { (x0, rise(t0), x1, rise(t1)) } else { (x1, rise(t1), x0, rise(t0)) };
            let (n, s) = (-height * 0.5, height * 0.5);
            pages.quad([
                Vec3::new(x0, y0, s),
                Vec3::new(x1, y1, s),
                Vec3::new(x1, y1, n),
                Vec3::new(x0, y0, n),
            ]);
            for z in [n, s] {
                let low = [Vec3::new(x0, 0.003, z), Vec3::new(x1, 0.003, z)];
                let high = [Vec3::new(x1, y1, z), Vec3::new(x0, y0, z)];
                let face = [low[0], low[1], high[0], high[1]];
                pages.quad(if z > 0.0 { face } else { [face[1], face[0], face[3], face[2]] });
            }
        }
        let edge = side * page;
        let (n, s) = (-height * 0.5 * side, height * 0.5 * side);
        pages.quad([
            Vec3::new(edge, 0.003, s),
            Vec3::new(edge, 0.003, n),
            Vec3::new(edge, rise(1.0).max(0.0035), n),
            Vec3::new(edge, rise(1.0).max(0.0035), s),
        ]);
        for row in 0..9 {
            let z = -height * 0.38 + height * 0.09 * row as f32;
            let (t0, t1) = (0.2, 0.85);
            let (a, b) = (side * page * t0, side * page * t1);
            let (ya, yb) = (rise(t0) + 0.0006, rise(t1) + 0.0006);
            let (x0, y0, x1, y1) = if side > 0.0 { (a, ya, b, yb) } else { (b, yb, a, ya) };
            let half = height * 0.014;
            lines.quad([
                Vec3::new(x0, y0, z + half),
                Vec3::new(x1, y1, z + half),
                Vec3::new(x1, y1, z - half),
                Vec3::new(x0, y0, z - half),
            ]);
        }
    }
    vec![plain(back, cover), plain(pages, PAPER), plain(lines, Srgb(150, 146, 138))]
}

fn sheets(size: Vec2, thick: f32, color: Srgb) -> Vec<Surface> {
    let pile = block(Vec3::ZERO, Vec3::new(size.x, thick, size.y));
    if thick > 0.002 {
        return vec![plain(pile, color)];
    }
    let mut lines = Mesh::default();
    for row in 0..12 {
        let z = -size.y * 0.36 + size.y * 0.06 * row as f32;
        let wide = size.x * if row % 4 == 3 { 0.45 } else { 0.74 };
        let left = -size.x * 0.37 + wide * 0.5;
        lines.append(&block(Vec3::new(left, thick, z), Vec3::new(wide, 0.0003, 0.004)), Affine3A::IDENTITY);
    }
    vec![plain(pile, color), plain(lines, Srgb(150, 152, 158))]
}

fn parcel(size: Vec3) -> Vec<Surface> {
    let tape = block(Vec3::Y * size.y, Vec3::new(size.x, 0.0006, size.z * 0.18));
    let label =
        block(Vec3::new(size.x * 0.25, size.y, size.z * 0.3), Vec3::new(size.x * 0.3, 0.0008, size.z * 0.25));
    vec![
        plain(block(Vec3::ZERO, size), Srgb(178, 138, 92)),
        plain(tape, Srgb(204, 178, 132)),
        plain(label, Srgb(244, 244, 240)),
    ]
}

// Soft things -------------------------------------------------------------------------------------------------

fn soft_cushion(color: Srgb, side: f32) -> Vec<Surface> {
    vec![plain(cushion(Vec3::new(side, 0.13, side)), color)]
}

fn folded(color: Srgb) -> Vec<Surface> {
    let low = soft_block(Vec3::new(0.3, 0.035, 0.25), 0.016);
    let high = at(&soft_block(Vec3::new(0.285, 0.03, 0.235), 0.014), 0.004, 0.034, -0.003);
    vec![plain(joined(&[low, high]), color)]
}

fn packet(color: Srgb) -> Vec<Surface> {
    let mut bag = cushion(Vec3::new(0.17, 0.055, 0.24));
    bag.positions.iter_mut().for_each(|p| p.y = p.y.max(0.004) - 0.004);
    let label = block(Vec3::new(0.0, 0.0495, 0.0), Vec3::new(0.07, 0.0015, 0.08));
    vec![shiny(bag, color), plain(label, Srgb(246, 208, 76))]
}

// Food --------------------------------------------------------------------------------------------------------

fn apple(color: Srgb) -> Vec<Surface> {
    let profile = [
        (0.0, 0.004),
        (0.014, 0.0),
        (0.027, 0.008),
        (0.037, 0.03),
        (0.039, 0.045),
        (0.034, 0.062),
        (0.02, 0.071),
        (0.008, 0.068),
        (0.0, 0.062),
    ];
    let stalk = rod(Vec3::new(0.0, 0.062, 0.0), Vec3::new(0.004, 0.083, 0.002), &[0.0018, 0.0014, 0.0018]);
    vec![shiny(lathe(&profile, 20), color), plain(stalk, Srgb(84, 60, 38))]
}

fn orange() -> Vec<Surface> {
    let navel = at(&ball(Vec3::new(0.005, 0.002, 0.005)), 0.0, 0.0745, 0.0);
    vec![plain(ball(Vec3::new(0.038, 0.038, 0.038)), Srgb(236, 138, 30)), plain(navel, Srgb(96, 120, 54))]
}

fn banana() -> Vec<Surface> {
    let bend = |t: f32| {
        let angle = -1.0 + 2.0 * t;
        Vec3::new(0.095 * angle.sin(), 0.018, 0.095 * (angle.cos() - 0.77))
    };
    let radii = [0.005, 0.012, 0.0165, 0.018, 0.018, 0.018, 0.0165, 0.012, 0.006];
    let mut skin = Mesh::default();
    for k in 0..radii.len() - 1 {
        let (a, b) = (bend(k as f32 / 8.0), bend((k + 1) as f32 / 8.0));
        skin.append(&rod(a, b, &[radii[k], radii[k + 1]]), Affine3A::IDENTITY);
    }
    let tip = rod(bend(1.0), bend(1.0) + Vec3::new(0.008, 0.0, -0.012), &[0.006, 0.004]);
    vec![plain(skin, Srgb(238, 204, 72)), plain(tip, Srgb(90, 74, 40))]
}

fn carrot() -> Vec<Surface> {
    let root =
        rod(Vec3::new(-0.08, 0.016, 0.0), Vec3::new(0.08, 0.007, 0.0), &[0.014, 0.016, 0.013, 0.009, 0.004]);
    let leaves: Vec<Mesh> = [-0.3_f32, 0.0, 0.3]
        .iter()
        .map(|a| {
            rod(
                Vec3::new(-0.08, 0.016, 0.0),
                Vec3::new(-0.125, 0.016, 0.05 * a.sin()),
                &[0.003, 0.004, 0.002],
            )
        })
        .collect();
    vec![plain(root, Srgb(230, 122, 40)), plain(joined(&leaves), Srgb(92, 130, 58))]
}

fn broccoli() -> Vec<Surface> {
    let stalk = lathe(&[(0.0, 0.0), (0.016, 0.0), (0.015, 0.05), (0.02, 0.07), (0.0, 0.07)], 12);
    let head: Vec<Mesh> = (0..7)
        .map(|k| {
            let (sin, cos) = (std::f32::consts::TAU * k as f32 / 6.0).sin_cos();
            let (r, y) = if k == 6 { (0.0, 0.062) } else { (0.03, 0.048) };
            at(&ball(Vec3::new(0.026, 0.022, 0.026)), r * sin, y, r * cos)
        })
        .collect();
    vec![plain(stalk, Srgb(158, 182, 104)), plain(joined(&head), Srgb(66, 110, 52))]
}

fn donut(icing: Srgb) -> Vec<Surface> {
    const AROUND: usize = 22;
    const TUBE: usize = 10;
    let ring = |tube: f32, squash: f32, lift: f32| {
        let mut mesh = Mesh::default();
        for i in 0..AROUND {
            let (s, c) = (std::f32::consts::TAU * i as f32 / AROUND as f32).sin_cos();
            for j in 0..TUBE {
                let (ts, tc) = (std::f32::consts::TAU * j as f32 / TUBE as f32).sin_cos();
                let r = 0.028 + tube * tc;
                mesh.positions.push(Vec3::new(r * s, lift + squash * tube * (1.0 + ts), r * c));
                mesh.normals.push(Vec3::new(tc * s, ts, tc * c).normalize_or(Vec3::Y));
            }
        }
        for i in 0..AROUND {
            for j in 0..TUBE {
                let v = |i: usize, j: usize| ((i % AROUND) * TUBE + j % TUBE) as u32;
                let [a, b, c, d] = [v(i, j), v(i + 1, j), v(i + 1, j + 1), v(i, j + 1)];
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        mesh
    };
    vec![plain(ring(0.018, 0.85, 0.0), CRUST), shiny(ring(0.0165, 0.8, 0.0065), icing)]
}

/// A pizza on a board with this many of its eight slices left.
fn pizza(slices: usize) -> Vec<Surface> {
    const STEPS: usize = 5;
    let board = lathe(&[(0.0, 0.0), (0.17, 0.0), (0.17, 0.012), (0.0, 0.012)], 36);
    let wedge = |inner: f32, outer: f32, low: f32, high: f32, from: f32, to: f32| {
        let mut mesh = Mesh::default();
        let p = |r: f32, t: f32, y: f32| {
            let (s, c) = (from + (to - from) * t).sin_cos();
            Vec3::new(r * s, y, r * c)
        };
        for k in 0..STEPS {
            let (a, b) = (k as f32 / STEPS as f32, (k + 1) as f32 / STEPS as f32);
            mesh.quad([p(inner, a, high), p(outer, a, high), p(outer, b, high), p(inner, b, high)]);
            mesh.quad([p(outer, a, low), p(outer, b, low), p(outer, b, high), p(outer, a, high)]);
            mesh.quad([p(inner, b, low), p(inner, a, low), p(inner, a, high), p(inner, b, high)]);
        }
        mesh.quad([p(inner, 0.0, low), p(outer, 0.0, low), p(outer, 0.0, high), p(inner, 0.0, high)]);
        mesh.quad([p(outer, 1.0, low), p(inner, 1.0, low), p(inner, 1.0, high), p(outer, 1.0, high)]);
        mesh
    };
    let (mut rim, mut cheese, mut spots) = (Mesh::default(), Mesh::default(), Mesh::default());
    for k in 0..slices {
        let step = std::f32::consts::TAU / 8.0;
        let (from, to) = (step * k as f32 + 0.012, step * (k + 1) as f32 - 0.012);
        rim.append(&wedge(0.133, 0.15, 0.012, 0.028, from, to), Affine3A::IDENTITY);
        cheese.append(&wedge(0.004, 0.133, 0.012, 0.022, from, to), Affine3A::IDENTITY);
        let (s, c) = ((from + to) * 0.5 + 0.1 * (k % 3) as f32 - 0.1).sin_cos();
        for r in [0.06, 0.105] {
            let slice = lathe(&[(0.0, 0.0), (0.016, 0.0), (0.016, 0.002), (0.0, 0.002)], 12);
            spots.append(&slice, Affine3A::from_translation(Vec3::new(r * s, 0.022, r * c)));
        }
    }
    vec![
        plain(board, Srgb(164, 122, 78)),
        plain(rim, CRUST),
        plain(cheese, Srgb(232, 188, 92)),
        plain(spots, Srgb(170, 52, 40)),
    ]
}

/// Two triangles of toast, one leaning over the other.
fn sandwich() -> Vec<Surface> {
    let slab = |low: f32, high: f32, half: f32| {
        let corners = [Vec2::new(-half, -half), Vec2::new(-half, half), Vec2::new(half, half)];
        let mut mesh = Mesh::default();
        let at = |i: usize, y: f32| Vec3::new(corners[i % 3].x, y, corners[i % 3].y);
        let base = mesh.positions.len() as u32;
        for (y, normal) in [(low, Vec3::NEG_Y), (high, Vec3::Y)] {
            mesh.positions.extend([at(0, y), at(1, y), at(2, y)]);
            mesh.normals.extend([normal; 3]);
        }
        mesh.triangles.extend([[base, base + 2, base + 1], [base + 3, base + 4, base + 5]]);
        for i in 0..3 {
            mesh.quad([at(i, low), at(i + 1, low), at(i + 1, high), at(i, high)]);
        }
        mesh
    };
    let bread = joined(&[slab(0.0, 0.013, 0.055), slab(0.027, 0.04, 0.055)]);
    let leaf = slab(0.013, 0.017, 0.059);
    let cheese = slab(0.017, 0.021, 0.056);
    let ham = slab(0.021, 0.027, 0.054);
    vec![
        plain(bread, Srgb(214, 172, 112)),
        plain(leaf, Srgb(110, 160, 70)),
        plain(cheese, Srgb(240, 200, 84)),
        plain(ham, Srgb(222, 144, 140)),
    ]
}

// Kitchenware -------------------------------------------------------------------------------------------------

fn bowl(color: Srgb, radius: f32) -> Vec<Surface> {
    let profile = [
        (0.0, 0.0),
        (0.4, 0.0),
        (0.4, 0.06),
        (0.75, 0.32),
        (0.97, 0.72),
        (1.0, 0.8),
        (0.96, 0.8),
        (0.7, 0.38),
        (0.35, 0.14),
        (0.0, 0.12),
    ];
    vec![shiny(lathe(&profile.map(|(r, y)| (r * radius, y * radius)), 28), color)]
}

fn plate(radius: f32, color: Srgb) -> Vec<Surface> {
    let profile = [
        (0.0, 0.0),
        (0.55 * radius, 0.0),
        (0.72 * radius, 0.006),
        (radius, 0.018),
        (radius * 0.995, 0.021),
        (0.7 * radius, 0.01),
        (0.6 * radius, 0.006),
        (0.0, 0.005),
    ];
    vec![shiny(lathe(&profile, 32), color)]
}

fn can() -> Vec<Surface> {
    let profile = [
        (0.0, 0.002),
        (0.024, 0.0),
        (0.0325, 0.008),
        (0.033, 0.1),
        (0.0265, 0.113),
        (0.0265, 0.115),
        (0.025, 0.115),
        (0.024, 0.111),
        (0.0, 0.111),
    ];
    let band = lathe(&[(0.0, 0.035), (0.0332, 0.035), (0.0332, 0.08), (0.0, 0.08)], 24);
    vec![metal(lathe(&profile, 24), Srgb(190, 192, 196)), shiny(band, Srgb(184, 36, 40))]
}

fn frying_pan() -> Vec<Surface> {
    let profile = [
        (0.0, 0.0),
        (0.095, 0.0),
        (0.125, 0.04),
        (0.128, 0.042),
        (0.124, 0.042),
        (0.093, 0.004),
        (0.0, 0.004),
    ];
    let handle =
        rod(Vec3::new(0.122, 0.034, 0.0), Vec3::new(0.3, 0.056, 0.0), &[0.007, 0.009, 0.011, 0.01, 0.007]);
    // The handle belongs to the pan's size: its middle is that of both.
    let middle = Affine3A::from_translation(Vec3::new(-0.087, 0.0, 0.0));
    let (mut pan, mut grip) = (Mesh::default(), Mesh::default());
    pan.append(&lathe(&profile, 32), middle);
    grip.append(&handle, middle);
    vec![metal(pan, Srgb(48, 49, 52)), plain(grip, Srgb(28, 28, 30))]
}

fn saucepan() -> Vec<Surface> {
    let profile = [
        (0.0, 0.0),
        (0.09, 0.0),
        (0.096, 0.006),
        (0.096, 0.1),
        (0.1, 0.104),
        (0.096, 0.106),
        (0.092, 0.1),
        (0.092, 0.006),
        (0.0, 0.004),
    ];
    let handles: Vec<Mesh> = [-1.0_f32, 1.0]
        .iter()
        .map(|side| {
            let bar = block(Vec3::new(side * 0.118, 0.074, 0.0), Vec3::new(0.01, 0.012, 0.07));
            let arms = [-0.03, 0.03]
                .map(|z| block(Vec3::new(side * 0.107, 0.074, z), Vec3::new(0.024, 0.012, 0.01)));
            joined(&[bar, arms[0].clone(), arms[1].clone()])
        })
        .collect();
    vec![metal(lathe(&profile, 32), Srgb(176, 178, 182)), plain(joined(&handles), Srgb(40, 40, 42))]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_thing_stands_on_its_middle_and_is_light() {
        assert!(made_names().is_sorted());
        for name in made_names() {
            let model = made_thing(name).expect(name);
            let bounds = model.bounds();
            assert!(bounds.min.y.abs() < 0.002, "{name} stands at {}", bounds.min.y);
            let off = bounds.center().with_y(0.0).length();
            assert!(off < 0.08, "{name} is {off} m off its middle");
            assert!(model.triangle_count() < 5000, "{name}: {}", model.triangle_count());
            let turned_out = model.parts.iter().all(|p| p.mesh.normals.len() == p.mesh.positions.len());
            assert!(turned_out, "{name} lacks normals");
        }
        assert!(made_thing("no such thing").is_none());
    }
}
