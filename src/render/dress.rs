//! Clothes, skin and hair: painted on the body by where a point lies on the T-pose, so that seams are as
//! straight as the planes that cut them and as sharp as the picture. Nobody is naked.
//!
//! Knows no graphics card: [`Outfit`] is what `shaders/people.wgsl` reads, [`Outfit::color_at`] is the same
//! for the processor.

use glam::{Vec3, Vec4};

use super::light::linear_rgb;
use crate::body::{Body, BodyPart};

/// What a vertex belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfacePart {
    /// The body, to be dressed.
    Body,
    /// An eyeball.
    Eye,
}

/// The surface that all people share: how vertices join, and where each lies on the T-pose of the mean
/// shape (metres, Y up, face to +Z, pelvis at the origin).
#[derive(Clone, Debug)]
pub struct BodySurface {
    rest: Vec<Vec3>,
    parts: Vec<SurfacePart>,
    triangles: Vec<[u32; 3]>,
}

impl BodySurface {
    /// The surface of a body model.
    pub fn of(body: &Body) -> Self {
        let parts = body.parts.bare.iter().map(|bare| match bare {
            BodyPart::Eyes | BodyPart::Iris => SurfacePart::Eye,
            _ => SurfacePart::Body,
        });
        Self {
            rest: body.model.template.clone(),
            parts: parts.collect(),
            triangles: body.model.faces.clone(),
        }
    }

    /// How many vertices a person has.
    pub fn vertex_count(&self) -> usize {
        self.rest.len()
    }

    /// Vertex indices, counter-clockwise seen from outside.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Where vertex `index` lies on the T-pose.
    pub fn rest(&self, index: usize) -> Vec3 {
        self.rest[index]
    }

    /// What vertex `index` belongs to.
    pub fn part(&self, index: usize) -> SurfacePart {
        self.parts[index]
    }

    /// Unit normals of the posed `vertices`, mean over the faces around each, weighted by area.
    pub fn normals(&self, vertices: &[Vec3]) -> Vec<Vec3> {
        let mut normals = vec![Vec3::ZERO; vertices.len()];
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(|v| vertices[v as usize]);
            let area = (b - a).cross(c - a);
            for v in triangle {
                normals[*v as usize] += area;
            }
        }
        normals.iter_mut().for_each(|n| *n = n.normalize_or(Vec3::Y));
        normals
    }
}

/// How long the hair is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hair {
    /// Down to the ears.
    Short,
    /// Over the ears, down to the chin.
    Long,
}

/// What somebody wears. Colours are linear RGB; lengths are metres on the T-pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outfit {
    /// Skin.
    pub skin: Vec3,
    /// Hair and brows.
    pub hair: Vec3,
    /// Its length.
    pub hair_style: Hair,
    /// Shirt.
    pub shirt: Vec3,
    /// Collar, cuffs and stripes.
    pub trim: Vec3,
    /// Height of a stripe and its gap; 0 for none.
    pub stripe_m: f32,
    /// `|x|` where the sleeve ends.
    pub sleeve_x: f32,
    /// Trousers.
    pub trousers: Vec3,
    /// `y` where the legs of the trousers end.
    pub leg_y: f32,
    /// Shoes.
    pub shoes: Vec3,
    /// `y` up to which they reach.
    pub shoe_y: f32,
    /// `y` where shirt and trousers meet.
    pub waist_y: f32,
    /// `y` of the neckline above the spine.
    pub neck_y: f32,
    /// How much it falls for each metre towards the front.
    pub neck_fall: f32,
}

/// Skin tones from light to dark, sRGB.
const SKINS: [[u8; 3]; 8] = [
    [240, 206, 184],
    [229, 187, 158],
    [217, 168, 134],
    [198, 145, 110],
    [173, 120, 86],
    [146, 97, 67],
    [112, 74, 52],
    [86, 57, 42],
];

/// Hair colours, sRGB.
const HAIRS: [[u8; 3]; 7] =
    [[28, 24, 22], [46, 34, 27], [72, 50, 36], [104, 72, 46], [158, 122, 76], [142, 66, 36], [142, 140, 138]];

/// Shirts and what goes with each, sRGB.
const SHIRTS: [([u8; 3], [u8; 3]); 12] = [
    ([58, 110, 165], [232, 236, 240]),
    ([186, 64, 58], [244, 226, 214]),
    ([236, 232, 222], [64, 92, 136]),
    ([74, 128, 96], [224, 232, 214]),
    ([232, 184, 74], [110, 76, 30]),
    ([104, 84, 140], [222, 214, 236]),
    ([84, 92, 102], [206, 210, 214]),
    ([44, 140, 148], [226, 240, 238]),
    ([206, 120, 142], [250, 232, 236]),
    ([38, 52, 88], [214, 190, 120]),
    ([214, 124, 66], [252, 236, 214]),
    ([150, 174, 196], [52, 70, 98]),
];

/// Trousers, sRGB.
const TROUSERS: [[u8; 3]; 8] = [
    [44, 58, 88],
    [62, 80, 112],
    [52, 52, 56],
    [140, 118, 88],
    [96, 90, 80],
    [74, 82, 66],
    [36, 38, 46],
    [118, 124, 132],
];

/// Shoes, sRGB.
const SHOES: [[u8; 3]; 6] =
    [[40, 36, 34], [92, 60, 40], [208, 206, 200], [54, 62, 82], [150, 52, 46], [120, 116, 110]];

impl Outfit {
    /// The outfit that `palette` chooses. Neighbouring numbers look different: each choice walks its own
    /// list with its own stride.
    pub fn from_palette(palette: u32) -> Self {
        let pick = |stride: u32, shift: u32| palette.wrapping_mul(stride).wrapping_add(shift + palette / 7);
        let at = |list: &[[u8; 3]], n: u32| linear_rgb(list[n as usize % list.len()]);
        let (shirt, trim) = SHIRTS[pick(5, 0) as usize % SHIRTS.len()];
        let sleeve_x = [0.335, 0.655, 0.36, 0.64][pick(3, 1) as usize % 4];
        let stripe_m = [0.0, 0.0, 0.05, 0.0, 0.0][pick(2, 0) as usize % 5];
        let leg_y = if pick(7, 3) % 6 == 0 { -0.47 } else { -0.835 };
        let neck_fall = [0.45, 0.7, 0.35][pick(2, 1) as usize % 3];
        Self {
            skin: at(&SKINS, pick(3, 1)),
            hair: at(&HAIRS, pick(5, 2)),
            hair_style: if pick(3, 0) % 5 < 2 { Hair::Long } else { Hair::Short },
            shirt: linear_rgb(shirt),
            trim: linear_rgb(trim),
            stripe_m,
            sleeve_x,
            trousers: at(&TROUSERS, pick(3, 0)),
            leg_y,
            shoes: at(&SHOES, pick(5, 1)),
            shoe_y: -0.825,
            waist_y: 0.045,
            neck_y: 0.527,
            neck_fall,
        }
    }

    /// The same numbers as `shaders/people.wgsl` reads them; `alpha` how solid, `by_heat` whether colours
    /// come from the heat map instead.
    pub(super) fn to_uniform(self, alpha: f32, by_heat: bool) -> [Vec4; 7] {
        let style = match self.hair_style {
            Hair::Short => 1.0,
            Hair::Long => 2.0,
        };
        [
            self.skin.extend(alpha),
            self.hair.extend(style),
            self.shirt.extend(self.sleeve_x),
            self.trim.extend(self.stripe_m),
            self.trousers.extend(self.leg_y),
            self.shoes.extend(self.shoe_y),
            Vec4::new(self.waist_y, self.neck_y, self.neck_fall, f32::from(u8::from(by_heat))),
        ]
    }
}
