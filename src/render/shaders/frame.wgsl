// What every pass of one picture shares; mirrors gpu/frame.rs.
struct Frame {
    clip_from_world: mat4x4f,
    world_from_clip: mat4x4f,
    shadow_from_world: mat4x4f,
    eye: vec4f,        // xyz; for orthographic views far behind the picture
    backward: vec4f,   // xyz unit vector against the view; w: 1 orthographic
    to_key: vec4f,     // xyz unit vector to the key light; w: width of a shadow texel in metres
    key: vec4f,        // rgb; w: taps per side of the shadow filter
    sky: vec4f,        // rgb; w: light at the camera
    ground: vec4f,     // rgb; w: rim
    viewport: vec4f,   // width, height, 1 / width, 1 / height
    cut: vec4f,        // xyz: triangles that show their outer side to this point are left out; w: 1 if any
    grid: vec4f,       // height, fade radius, centre x, centre z
}
@group(0) @binding(0) var<uniform> frame: Frame;

fn to_eye(p: vec3f) -> vec3f {
    return normalize(select(frame.eye.xyz - p, frame.backward.xyz, frame.backward.w > 0.5));
}
