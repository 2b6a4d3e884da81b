// People: smooth bodies, dressed by where a point lies on the T-pose. Needs frame.wgsl and light.wgsl.
// The garments are those of dress.rs, line by line.
struct Person {
    skin: vec4f,      // linear rgb; w: how solid
    hair: vec4f,      // linear rgb; w: 0 cropped, 1 short, 2 chin-long
    shirt: vec4f,     // linear rgb; w: sleeve's end, |x| in the T-pose
    trim: vec4f,      // linear rgb of collar, cuffs and stripes; w: stripes' period in metres, 0 none
    trousers: vec4f,  // linear rgb; w: leg's end, y in the T-pose
    shoes: vec4f,     // linear rgb; w: shaft's end, y in the T-pose
    cut: vec4f,       // waist y, neckline's radius, z of its middle; w: 1 painted by heat
}
@group(1) @binding(0) var<uniform> person: Person;

struct Vertex {
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) heat: vec4f,
    @location(3) rest: vec4f,  // T-pose; w: 0 body, 1 eye
}

struct Varying {
    @builtin(position) clip: vec4f,
    @location(0) world: vec3f,
    @location(1) normal: vec3f,
    @location(2) rest: vec4f,
    @location(3) heat: vec4f,
}

@vertex
fn vs(v: Vertex) -> Varying {
    return Varying(frame.clip_from_world * vec4f(v.position, 1.0), v.position, v.normal, v.rest,
        vec4f(pow(v.heat.rgb, vec3f(2.2)), 1.0));
}

@vertex
fn vs_shadow(v: Vertex) -> @builtin(position) vec4f {
    return frame.shadow_from_world * vec4f(v.position, 1.0);
}

// Share of a pixel `width` metres wide that lies where `inside` is positive.
fn cover(inside: f32, width: f32) -> f32 {
    return clamp(inside / width + 0.5, 0.0, 1.0);
}

// Cloth has thickness: what lies beside its hem is a little darker.
fn hem_shade(outside: f32) -> f32 {
    return 1.0 - 0.45 * exp(-max(outside, 0.0) / 0.006);
}

fn hair_inside(p: vec3f, style: f32) -> f32 {
    let x = abs(p.x);
    let top = (p.y - 0.735 - (p.z - 0.14) * 0.58) * 0.86;
    let nape = select(0.60, 0.535, style > 1.5);
    let rise = select(1.2, 0.35, style > 1.5);
    let back = min(0.078 - p.z, (p.y - nape - max(p.z, 0.0) * rise) * 0.64);
    let ear = select(max(0.077 - x, p.y - 0.685), 1.0, style > 1.5);
    let near = max(1.0 - abs(top - back) / 0.03, 0.0);
    return min(max(top, back) + near * near * 0.0075, ear);
}

fn face(p: vec3f, base: vec3f, width: f32) -> vec3f {
    let x = abs(p.x);
    let front = p.z - 0.09;
    let lips = min(0.008 - length(vec2f(x * 0.36, p.y - 0.5945)), front);
    let arch = 0.6825 - (x - 0.030) * (x - 0.030) * 12.0;
    let brow = min(min(0.0032 - abs(p.y - arch), 0.016 - abs(x - 0.030)), front);
    let cheek = 0.10 * exp(-dot(vec2f(x - 0.043, p.y - 0.625), vec2f(x - 0.043, p.y - 0.625)) / 0.0004);
    var c = base * mix(vec3f(1.0), vec3f(1.08, 0.82, 0.80), select(0.0, cheek * 4.0, front > 0.0));
    c = mix(c, base * vec3f(0.86, 0.52, 0.50), 0.8 * cover(lips, width));
    return mix(c, person.hair.rgb * 0.7, 0.85 * cover(brow, width));
}

fn eye(p: vec3f, width: f32) -> vec3f {
    let r = length(vec2f(abs(p.x) - 0.030, p.y - 0.667));
    var c = mix(vec3f(0.85), vec3f(0.13, 0.075, 0.04), cover(0.0060 - r, width));
    return mix(c, vec3f(0.01), cover(0.0028 - r, width));
}

fn dressed(p: vec3f, part: f32, width: f32) -> vec3f {
    if (part > 0.5) { return eye(p, width); }
    let x = abs(p.x);
    let neck = min(distance(p, vec3f(0.0, 0.565, person.cut.z)) - person.cut.y, 0.548 - p.y);
    let arm = person.shirt.w - x;
    let shirt = min(min(p.y - person.cut.x, neck), arm);
    let leg = p.y - person.trousers.w;
    let trousers = min(person.cut.x - p.y, leg);
    let shoe = person.shoes.w - p.y;
    let hair = hair_inside(p, person.hair.w);
    var c = face(p, person.skin.rgb, width);
    c = mix(c, person.hair.rgb, cover(hair, width));
    c *= min(hem_shade(-min(neck, arm)), hem_shade(-leg));
    c = mix(c, person.trousers.rgb * hem_shade(p.y - person.cut.x + 0.02), cover(trousers, width));
    var cloth = person.shirt.rgb;
    if (person.trim.w > 0.0) {
        let along = p.y - max(x - 0.19, 0.0);
        let phase = abs(fract(along / person.trim.w) - 0.5) * person.trim.w;
        cloth = mix(cloth, person.trim.rgb, cover(phase - 0.32 * person.trim.w, width));
    }
    cloth = mix(cloth, person.trim.rgb, cover(0.012 - min(neck, arm), width));
    cloth *= mix(1.0, 0.75, cover(0.004 - abs(p.y - person.cut.x), width));
    c = mix(c, cloth, cover(shirt, width));
    let sole = mix(person.shoes.rgb, vec3f(0.75, 0.73, 0.70), cover(-0.897 - p.y, width));
    return mix(c, sole, cover(shoe, width));
}

fn shaded(v: Varying, width: f32) -> vec4f {
    let view = to_eye(v.world);
    var n = normalize(v.normal);
    n = select(-n, n, dot(n, view) > -0.2);
    let painted = person.cut.w > 0.5;
    let part = v.rest.w;
    let skin = !painted && part < 0.5;
    let base = select(dressed(v.rest.xyz, part, width), v.heat.rgb, painted);
    let eye_gloss = select(0.72, 0.15, part > 0.5 && !painted);
    let s = Surface(base, vec3f(0.0), 0.0, eye_gloss, select(0.4, 1.0, skin));
    return lit(s, v.world, n);
}

fn rest_width(v: Varying) -> f32 {
    return max(length(fwidth(v.rest.xyz)) * 0.7, 1e-5);
}

@fragment
fn fs_solid(v: Varying) -> @location(0) vec4f {
    return shaded(v, rest_width(v));
}

@fragment
fn fs_ghost(v: Varying) -> @location(0) vec4f {
    return vec4f(shaded(v, rest_width(v)).rgb, person.skin.w);
}

@fragment
fn fs_flag(v: Varying) -> @location(0) vec4f {
    return vec4f(1.0);
}
