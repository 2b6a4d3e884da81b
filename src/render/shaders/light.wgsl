// Light on a surface; the processor's renderer computes the same in cpu/shade.rs.
@group(0) @binding(1) var shadow_map: texture_depth_2d;
@group(0) @binding(2) var shadow_sampler: sampler_comparison;

// 1 lit, 0 in shadow: a square of bilinear depth comparisons about the receiver, which is lifted off its
// surface by a little more than the filter is wide, so that it does not shade itself.
fn lit_share(p: vec3f, n: vec3f, n_dot_l: f32) -> f32 {
    let side = i32(frame.key.w);
    let reach = 0.5 * f32(side);
    let lift = frame.to_key.w * (0.6 + reach * sqrt(max(1.0 - n_dot_l * n_dot_l, 0.0)));
    let q = frame.shadow_from_world * vec4f(p + n * lift, 1.0);
    let uv = vec2f(0.5 + 0.5 * q.x, 0.5 - 0.5 * q.y);
    if (any(uv < vec2f(0.0)) || any(uv > vec2f(1.0)) || q.z > 1.0) {
        return 1.0;
    }
    let texel = 1.0 / f32(textureDimensions(shadow_map).x);
    // Most points are wholly lit or wholly in shadow: the corners of the square tell.
    let corner = 0.5 * f32(side - 1) * texel;
    var sum = 0.0;
    for (var i = 0; i < 4; i++) {
        let at = (vec2f(f32(i & 1), f32(i >> 1)) * 2.0 - 1.0) * corner;
        sum += textureSampleCompareLevel(shadow_map, shadow_sampler, uv + at, q.z);
    }
    if (sum == 0.0 || sum == 4.0 || side == 2) {
        return sum * 0.25;
    }
    sum = 0.0;
    for (var j = 0; j < side; j++) {
        for (var i = 0; i < side; i++) {
            let at = vec2f(f32(i), f32(j)) * texel - corner;
            sum += textureSampleCompareLevel(shadow_map, shadow_sampler, uv + at, q.z);
        }
    }
    return sum / f32(side * side);
}

fn hemisphere(n: vec3f) -> vec3f {
    return mix(frame.ground.rgb, frame.sky.rgb, 0.5 + 0.5 * n.y);
}

struct Surface {
    base: vec3f,
    emissive: vec3f,
    metallic: f32,
    roughness: f32,
    rim: f32,
}

// Linear RGB, and in the last component how much of it ambient occlusion may take away.
fn lit(s: Surface, p: vec3f, n: vec3f) -> vec4f {
    let v = to_eye(p);
    let l = frame.to_key.xyz;
    let n_dot_l = dot(n, l);
    let n_dot_v = max(dot(n, v), 1e-3);
    var key = 0.0;
    if (n_dot_l > 0.0) {
        key = n_dot_l * lit_share(p, n, n_dot_l);
    }
    let diffuse = s.base * (1.0 - s.metallic);
    let f0 = mix(vec3f(0.04), s.base, s.metallic);
    let ambient = diffuse * (hemisphere(n) + frame.sky.w * n_dot_v);
    // Trowbridge-Reitz lobe of the key light; the hemisphere stands in for a mirrored room.
    let h = normalize(v + l);
    let a = max(s.roughness * s.roughness, 0.03);
    let n_dot_h = max(dot(n, h), 0.0);
    let d = n_dot_h * n_dot_h * (a * a - 1.0) + 1.0;
    let lobe = a * a / (4.0 * d * d * max(n_dot_v, 0.2));
    let gloss = 1.0 - s.roughness;
    let grazing = 1.0 - n_dot_v;
    let grazing3 = grazing * grazing * grazing;
    let fresnel = f0 + (max(vec3f(gloss), f0) - f0) * (grazing3 * grazing * grazing);
    let mirrored = hemisphere(reflect(-v, n)) * fresnel * (0.35 + 0.65 * gloss);
    let edge = grazing3 * (0.4 + 0.6 * max(n.y, 0.0));
    let direct = (diffuse + f0 * min(lobe, 4.0)) * key * frame.key.rgb + s.emissive;
    let indirect = ambient + mirrored + s.rim * frame.ground.w * edge;
    let color = direct + indirect;
    let share = dot(indirect, vec3f(0.3333)) / max(dot(color, vec3f(0.3333)), 1e-4);
    return vec4f(shoulder(color), clamp(share, 0.0, 1.0));
}

// Bends what is brighter than 0.75 towards 1, so that white walls keep their edges and colours their hue.
fn shoulder(color: vec3f) -> vec3f {
    let start = 0.75;
    let peak = max(color.r, max(color.g, color.b));
    if (peak <= start) {
        return color;
    }
    let over = peak - start;
    let bent = start + (1.0 - start) * over / (over + (1.0 - start));
    return color * (bent / peak);
}
