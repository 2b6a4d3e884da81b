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
    /// Radius of the neckline about the throat.
    pub neck_m: f32,
    /// How far its middle lies towards the front: more shows more of the chest, less of the nape.
    pub neck_z: f32,
}

/// Skin tones from light to dark, sRGB.
const SKINS: [[u8; 3]; 8] = [
    [240, 206, 184],
    [229, 187, 158],
    [217, 168, 134],
    [198, 145, 110],
    [173, 120, 86],
    [146, 97, 67],
    [126, 85, 61],
    [104, 70, 51],
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
        let (neck_m, neck_z) = [(0.098, 0.04), (0.112, 0.055), (0.092, 0.035)][pick(2, 1) as usize % 3];
        let skin = pick(3, 1) as usize % SKINS.len();
        // Fair hair goes with fair skin: the darker half wears the first three and grey.
        let hairs: &[usize] = if skin < SKINS.len() / 2 { &[0, 1, 2, 3, 4, 5, 6] } else { &[0, 1, 0, 2, 6] };
        Self {
            skin: linear_rgb(SKINS[skin]),
            hair: linear_rgb(HAIRS[hairs[pick(5, 2) as usize % hairs.len()]]),
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
            neck_m,
            neck_z,
        }
    }

    /// Linear RGB of the point `rest` of the dressed body; a pixel is `width_m` wide there.
    pub fn color_at(&self, rest: Vec3, width_m: f32) -> Vec3 {
        let (x, cover) = (rest.x.abs(), |inside: f32| cover(inside, width_m));
        let throat = Vec3::new(0.0, 0.565, self.neck_z);
        let neck = (rest.distance(throat) - self.neck_m).min(0.548 - rest.y);
        let arm = self.sleeve_x - x;
        let leg = rest.y - self.leg_y;
        let mut c = self.face_at(rest, width_m).lerp(self.hair, cover(self.hair_inside(rest)));
        c *= hem_shade(-neck.min(arm)).min(hem_shade(-leg));
        let trousers = self.trousers * hem_shade(rest.y - self.waist_y + 0.02);
        c = c.lerp(trousers, cover((self.waist_y - rest.y).min(leg)));
        let mut cloth = self.shirt;
        if self.stripe_m > 0.0 {
            let along = rest.y - (x - 0.19).max(0.0);
            let phase = ((along / self.stripe_m).rem_euclid(1.0) - 0.5).abs() * self.stripe_m;
            cloth = cloth.lerp(self.trim, cover(phase - 0.32 * self.stripe_m));
        }
        cloth = cloth.lerp(self.trim, cover(0.012 - neck.min(arm)));
        cloth *= 1.0 - 0.25 * cover(0.004 - (rest.y - self.waist_y).abs());
        c = c.lerp(cloth, cover((rest.y - self.waist_y).min(neck).min(arm)));
        let sole = self.shoes.lerp(SOLE, cover(-0.897 - rest.y));
        c.lerp(sole, cover(self.shoe_y - rest.y))
    }

    /// Linear RGB of the point `rest` of an eyeball.
    pub fn eye_at(&self, rest: Vec3, width_m: f32) -> Vec3 {
        let r = (rest.x.abs() - 0.030).hypot(rest.y - 0.667);
        let white = Vec3::splat(0.85).lerp(Vec3::new(0.13, 0.075, 0.04), cover(0.0060 - r, width_m));
        white.lerp(Vec3::splat(0.01), cover(0.0028 - r, width_m))
    }

    fn face_at(&self, p: Vec3, width_m: f32) -> Vec3 {
        let (x, front) = (p.x.abs(), p.z - 0.09);
        let lips = (0.008 - (x * 0.36).hypot(p.y - 0.5945)).min(front);
        let arch = 0.6825 - (x - 0.030).powi(2) * 12.0;
        let brow = (0.0032 - (p.y - arch).abs()).min(0.016 - (x - 0.030).abs()).min(front);
        let cheek = (-((x - 0.043).powi(2) + (p.y - 0.625).powi(2)) / 0.0004).exp();
        let flush = if front > 0.0 { 0.4 * cheek } else { 0.0 };
        let mut c = self.skin * Vec3::ONE.lerp(Vec3::new(1.08, 0.82, 0.80), flush);
        c = c.lerp(self.skin * Vec3::new(0.86, 0.52, 0.50), 0.8 * cover(lips, width_m));
        c.lerp(self.hair * 0.7, 0.85 * cover(brow, width_m))
    }

    /// Metres inside the hairline.
    fn hair_inside(&self, p: Vec3) -> f32 {
        let x = p.x.abs();
        let (nape, rise) = match self.hair_style {
            Hair::Short => (0.60, 1.2),
            Hair::Long => (0.535, 0.35),
        };
        let top = (p.y - 0.735 - (p.z - 0.14) * 0.58) * 0.86;
        let back = (0.078 - p.z).min((p.y - nape - p.z.max(0.0) * rise) * 0.64);
        let ear = match self.hair_style {
            Hair::Short => (0.077 - x).max(p.y - 0.685),
            Hair::Long => f32::INFINITY,
        };
        smooth_max(top, back).min(ear)
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
            Vec4::new(self.waist_y, self.neck_m, self.neck_z, f32::from(u8::from(by_heat))),
        ]
    }
}

/// Soles of shoes, linear RGB.
const SOLE: Vec3 = Vec3::new(0.75, 0.73, 0.70);

/// Share of a pixel `width_m` wide that lies where `inside` is positive.
fn cover(inside: f32, width_m: f32) -> f32 {
    (inside / width_m.max(1e-5) + 0.5).clamp(0.0, 1.0)
}

/// Cloth has thickness: what lies beside its hem is a little darker.
fn hem_shade(outside: f32) -> f32 {
    1.0 - 0.45 * (-outside.max(0.0) / 0.006).exp()
}

/// The larger of two distances, rounded where they meet within 3 cm: a hairline has no corners.
fn smooth_max(a: f32, b: f32) -> f32 {
    let near = (1.0 - (a - b).abs() / 0.03).max(0.0);
    a.max(b) + near * near * 0.0075
}
