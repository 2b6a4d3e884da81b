// The ground: lines every metre, stronger every five, fading out, and the shadow of what stands outside
// the room. Needs frame.wgsl and light.wgsl before it.
struct Varying {
    @builtin(position) clip: vec4f,
    @location(0) world: vec3f,
}

@vertex
fn vs(@builtin(vertex_index) i: u32) -> Varying {
    let corner = vec2f(f32(i & 1u), f32(i >> 1u)) * 2.0 - 1.0;
    let at = frame.grid.zw + corner * frame.grid.y;
    let world = vec3f(at.x, frame.grid.x, at.y);
    return Varying(frame.clip_from_world * vec4f(world, 1.0), world);
}

// Share of the pixel that the lines of a grid cover, `period` apart and `width` pixels wide.
fn lines(at: vec2f, period: f32, width: f32) -> f32 {
    let q = at / period;
    let pixel = max(fwidth(q), vec2f(1e-6));
    let off = abs(fract(q - 0.5) - 0.5);
    let cover = clamp(width * 0.5 + 0.5 - off / pixel, vec2f(0.0), vec2f(1.0));
    let dense = clamp(1.5 - 3.0 * pixel, vec2f(0.0), vec2f(1.0));
    return max(cover.x * dense.x, cover.y * dense.y);
}

@fragment
fn fs(v: Varying) -> @location(0) vec4f {
    let away = length(v.world.xz - frame.grid.zw) / frame.grid.y;
    let fade = pow(clamp(1.0 - away, 0.0, 1.0), 1.5);
    let steep = clamp(abs(to_eye(v.world).y) * 6.0, 0.0, 1.0);
    let strength = max(lines(v.world.xz, 1.0, 1.0) * 0.20, lines(v.world.xz, 5.0, 1.4) * 0.34);
    let dark = (1.0 - lit_share(v.world, vec3f(0.0, 1.0, 0.0), frame.to_key.y)) * 0.35 * fade;
    let line = strength * fade * steep;
    let alpha = line + dark * (1.0 - line);
    return vec4f(vec3f(0.75) * line / max(alpha, 1e-4), alpha);
}
