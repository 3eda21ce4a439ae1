// @align raises where a member starts, @size how much room it takes. With both, a
// struct can reproduce any layout the host already has.

struct Frame {
    @size(16) exposure: f32,   // offset 0, then 12 bytes of room
    sun: vec3f,                // offset 16
    @align(64) tile: vec4f,    // offset 64
    @size(48) horizon: vec3f,  // offset 80
    @align(32) fog: f32,       // offset 128
}

@group(0) @binding(0) var<uniform> frame: Frame;

@fragment
fn fragment_main(@location(0) normal: vec3f) -> @location(0) vec4f {
    let lit = max(dot(normal, -frame.sun), 0.0) * frame.exposure;
    return mix(vec4f(frame.horizon * lit, 1.0), frame.tile, frame.fog);
}
