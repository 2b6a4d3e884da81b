// The room: textured triangles, instanced. Needs frame.wgsl and light.wgsl before it.
struct Material {
    base: vec4f,      // linear, alpha last
    emissive: vec4f,  // linear; w: alpha below this is not drawn (0: everything is)
    finish: vec4f,    // metallic, roughness
}
@group(1) @binding(0) var<uniform> material: Material;
@group(1) @binding(1) var base_texture: texture_2d<f32>;
@group(1) @binding(2) var base_sampler: sampler;

struct Vertex {
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) uv: vec2f,
    @location(3) color: vec4f,
    @location(4) inward: vec4f,
    @location(5) row0: vec4f,
    @location(6) row1: vec4f,
    @location(7) row2: vec4f,
}

struct Varying {
    @builtin(position) clip: vec4f,
    @location(0) world: vec3f,
    @location(1) normal: vec3f,
    @location(2) uv: vec2f,
    @location(3) color: vec4f,
}

fn world_of(v: Vertex) -> vec3f {
    let p = vec4f(v.position, 1.0);
    return vec3f(dot(v.row0, p), dot(v.row1, p), dot(v.row2, p));
}

// Part of the room's shell that shows its outer side to the point that the cut is made for.
fn is_cut(v: Vertex, world: vec3f, from_point: vec3f) -> bool {
    let n = v.inward.xyz;
    return dot(n, n) > 0.5 && dot(n, from_point - world) < 0.0;
}

const NOWHERE = vec4f(0.0, 0.0, 2.0, 1.0);

@vertex
fn vs(v: Vertex) -> Varying {
    let world = world_of(v);
    let normal = vec3f(
        dot(cross(v.row1.xyz, v.row2.xyz), v.normal),
        dot(cross(v.row2.xyz, v.row0.xyz), v.normal),
        dot(cross(v.row0.xyz, v.row1.xyz), v.normal),
    );
    let cut = frame.cut.w > 0.5 && is_cut(v, world, frame.cut.xyz);
    let clip = select(frame.clip_from_world * vec4f(world, 1.0), NOWHERE, cut);
    return Varying(clip, world, normal, v.uv, vec4f(pow(v.color.rgb, vec3f(2.2)), v.color.a));
}

fn base_of(v: Varying) -> vec4f {
    return material.base * v.color * textureSample(base_texture, base_sampler, v.uv);
}

fn shaded(v: Varying, base: vec3f) -> vec4f {
    let view = to_eye(v.world);
    let flat_normal = cross(dpdy(v.world), dpdx(v.world));
    let long = dot(v.normal, v.normal) > 1e-12;
    var n = normalize(select(flat_normal, v.normal, long));
    n = select(-n, n, dot(n, view) > 0.0);
    let s = Surface(base, material.emissive.rgb, material.finish.x, material.finish.y, 0.0);
    return lit(s, v.world, n);
}

@fragment
fn fs_opaque(v: Varying) -> @location(0) vec4f {
    return shaded(v, base_of(v).rgb);
}

@fragment
fn fs_masked(v: Varying) -> @location(0) vec4f {
    let base = base_of(v);
    let color = shaded(v, base.rgb);
    if (base.a < material.emissive.w) {
        discard;
    }
    return color;
}

@fragment
fn fs_blend(v: Varying) -> @location(0) vec4f {
    let base = base_of(v);
    return vec4f(shaded(v, base.rgb).rgb, base.a);
}

@fragment
fn fs_flag(v: Varying) -> @location(0) vec4f {
    if (base_of(v).a < material.emissive.w) {
        discard;
    }
    return vec4f(1.0);
}

// Seen from the light: the shell's far side casts, its near side lets the light in.
struct ShadowVarying {
    @builtin(position) clip: vec4f,
    @location(0) uv: vec2f,
}

@vertex
fn vs_shadow(v: Vertex) -> ShadowVarying {
    let world = world_of(v);
    let cut = is_cut(v, world, world + frame.to_key.xyz);
    return ShadowVarying(select(frame.shadow_from_world * vec4f(world, 1.0), NOWHERE, cut), v.uv);
}

@fragment
fn fs_shadow(v: ShadowVarying) {
    let alpha = material.base.a * textureSample(base_texture, base_sampler, v.uv).a;
    if (alpha < material.emissive.w) {
        discard;
    }
}
