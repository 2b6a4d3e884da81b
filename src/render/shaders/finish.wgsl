// From the drawn picture to the shown one: ambient occlusion from the depth, selection outline, sRGB.
struct View {
    view_from_clip: mat4x4f,
    size: vec4f,     // width, height of the picture; w of occlusion: taps
    reach: vec4f,    // x: metres that occlusion looks around; y: pixels a metre spans at 1 m; z: orthographic
    outline: vec4f,  // linear rgb; w: width in pixels
}
@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var depth: texture_depth_multisampled_2d;
@group(0) @binding(2) var color: texture_2d<f32>;
@group(0) @binding(3) var flags: texture_2d<f32>;
@group(0) @binding(4) var occlusion: texture_2d<f32>;
@group(0) @binding(5) var smooth_sampler: sampler;

@vertex
fn vs(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
    let at = vec2f(f32(i & 1u), f32(i >> 1u)) * 4.0 - 1.0;
    return vec4f(at, 0.0, 1.0);
}

fn depth_at(pixel: vec2f) -> f32 {
    let p = clamp(vec2i(pixel), vec2i(0), vec2i(view.size.xy) - 1);
    return textureLoad(depth, p, 0);
}

fn view_of(pixel: vec2f) -> vec3f {
    let ndc = vec2f(pixel.x / view.size.x * 2.0 - 1.0, 1.0 - pixel.y / view.size.y * 2.0);
    // A symmetric projection's inverse has these entries only.
    let m = view.view_from_clip;
    let d = depth_at(pixel);
    return vec3f(m[0].x * ndc.x, m[1].y * ndc.y, m[2].z * d + m[3].z) / (m[2].w * d + m[3].w);
}

// The shorter of two differences: the one that does not cross a silhouette.
fn nearer(a: vec3f, b: vec3f) -> vec3f {
    return select(b, a, dot(a, a) < dot(b, b));
}

// Ambient occlusion by obscurance (Bunnell's and Alchemy's idea): how far the points around rise above
// the tangent plane. Half size; alpha-free grey, 1 open. Second channel: distance for the blur.
@fragment
fn fs_occlusion(@builtin(position) at: vec4f) -> @location(0) vec2f {
    let pixel = floor(at.xy) * 2.0 + 1.0;
    if (depth_at(pixel) >= 1.0) {
        return vec2f(1.0, 0.0);
    }
    let p = view_of(pixel);
    let dx = nearer(view_of(pixel + vec2f(1.0, 0.0)) - p, p - view_of(pixel - vec2f(1.0, 0.0)));
    let dy = nearer(view_of(pixel + vec2f(0.0, 1.0)) - p, p - view_of(pixel - vec2f(0.0, 1.0)));
    let n = normalize(cross(dy, dx));
    let distance = select(-p.z, 1.0, view.reach.z > 0.5);
    let span = clamp(view.reach.x * view.reach.y / max(distance, 0.05), 4.0, 0.25 * view.size.y);
    let taps = i32(view.size.w);
    // Interleaved gradient noise turns the spiral from pixel to pixel; the blur averages 4 x 4 of them.
    let turn = 6.2831853 * fract(52.9829189 * fract(dot(floor(at.xy), vec2f(0.06711056, 0.00583715))));
    var sum = 0.0;
    for (var i = 0; i < taps; i++) {
        let t = (f32(i) + 0.5) / f32(taps);
        let angle = turn + f32(i) * 2.3999632;
        let q = view_of(pixel + vec2f(cos(angle), sin(angle)) * span * t);
        let d = q - p;
        let dd = dot(d, d);
        let rise = max(dot(d, n) - 0.003 - 0.002 * distance, 0.0);
        let near = max(1.0 - dd / (view.reach.x * view.reach.x), 0.0);
        sum += near * near * rise / (sqrt(dd) + 0.01);
    }
    let open = clamp(1.0 - 2.6 * sum / f32(taps), 0.0, 1.0);
    return vec2f(open, distance);
}

// 4 x 4 blur that does not cross silhouettes; same size as the occlusion.
@fragment
fn fs_blur(@builtin(position) at: vec4f) -> @location(0) vec2f {
    let pixel = vec2i(at.xy);
    let last = vec2i(textureDimensions(occlusion)) - 1;
    let own = textureLoad(occlusion, pixel, 0).rg;
    var sum = own.r;
    var weight = 1.0;
    for (var j = -2; j < 2; j++) {
        for (var i = -2; i < 2; i++) {
            let q = textureLoad(occlusion, clamp(pixel + vec2i(i, j), vec2i(0), last), 0).rg;
            let w = max(1.0 - abs(q.g - own.g) / (0.03 * own.g + 0.02), 0.0);
            sum += q.r * w;
            weight += w;
        }
    }
    return vec2f(sum / weight, own.g);
}

fn flagged(uv: vec2f) -> f32 {
    return textureSampleLevel(flags, smooth_sampler, uv, 0.0).r;
}

fn srgb(c: vec3f) -> vec3f {
    let low = c * 12.92;
    let high = 1.055 * pow(max(c, vec3f(0.0031308)), vec3f(1.0 / 2.4)) - 0.055;
    return select(high, low, c <= vec3f(0.0031308));
}

@fragment
fn fs_compose(@builtin(position) at: vec4f) -> @location(0) vec4f {
    let uv = at.xy / view.size.xy;
    let drawn = textureLoad(color, vec2i(at.xy), 0);
    let open = textureSampleLevel(occlusion, smooth_sampler, uv, 0.0).r;
    // Full strength on indirect light, a third on direct light: contact shows in the sun as well.
    var c = drawn.rgb * mix(1.0, open, select(0.0, 0.35 + 0.65 * drawn.a, drawn.a > 0.004));
    if (view.outline.w > 0.0) {
        let own = flagged(uv);
        var around = own;
        for (var i = 0; i < 8; i++) {
            let angle = f32(i) * 0.7853982;
            around = max(around, flagged(uv + vec2f(cos(angle), sin(angle)) * view.outline.w / view.size.xy));
        }
        c = mix(c, view.outline.rgb, clamp(around - own, 0.0, 1.0));
    }
    return vec4f(srgb(c), 1.0);
}
