// Lines and markers of constant size on the screen. Needs frame.wgsl before it.
struct Mark {
    @location(0) from_: vec3f,
    @location(1) size: f32,
    @location(2) to: vec3f,
    @location(3) color: vec4f,
}

struct Varying {
    @builtin(position) clip: vec4f,
    @location(0) color: vec4f,
    @location(1) across: vec2f,  // pixels from the middle
    @location(2) reach: f32,     // half the size in pixels
}

// Cuts a segment at the near plane, so that an end behind the camera does not turn up in front.
fn clipped(a: vec4f, b: vec4f) -> vec4f {
    if (a.z >= 0.0 || b.z <= a.z) { return a; }
    return mix(a, b, (0.0001 - a.z) / (b.z - a.z));
}

fn linear(c: vec4f) -> vec4f {
    return vec4f(pow(c.rgb, vec3f(2.2)), c.a);
}

@vertex
fn vs_line(@builtin(vertex_index) i: u32, m: Mark) -> Varying {
    let a0 = frame.clip_from_world * vec4f(m.from_, 1.0);
    let b0 = frame.clip_from_world * vec4f(m.to, 1.0);
    let a = clipped(a0, b0);
    let b = clipped(b0, a0);
    let half_size = 0.5 * frame.viewport.xy;
    let along = (b.xy / max(b.w, 1e-6) - a.xy / max(a.w, 1e-6)) * half_size;
    let long = length(along);
    let dir = select(vec2f(1.0, 0.0), along / max(long, 1e-6), long > 1e-6);
    let side = f32(i & 1u) * 2.0 - 1.0;
    let end = select(a, b, i >= 2u);
    let reach = 0.5 * m.size + 0.5;
    let offset = vec2f(-dir.y, dir.x) * side * reach / half_size * end.w;
    return Varying(vec4f(end.xy + offset, end.zw), linear(m.color), vec2f(side * reach, 0.0), 0.5 * m.size);
}

@vertex
fn vs_point(@builtin(vertex_index) i: u32, m: Mark) -> Varying {
    let at = frame.clip_from_world * vec4f(m.from_, 1.0);
    let corner = vec2f(f32(i & 1u), f32(i >> 1u)) * 2.0 - 1.0;
    let reach = 0.5 * m.size + 0.5;
    let offset = corner * reach / (0.5 * frame.viewport.xy) * at.w;
    return Varying(vec4f(at.xy + offset, at.zw), linear(m.color), corner * reach, 0.5 * m.size);
}

@fragment
fn fs(v: Varying) -> @location(0) vec4f {
    let cover = clamp(v.reach + 0.5 - length(v.across), 0.0, 1.0);
    return vec4f(v.color.rgb, v.color.a * cover);
}
