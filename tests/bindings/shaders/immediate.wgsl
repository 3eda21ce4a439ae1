// Immediates of the two stages.

struct Draw {
    tint: vec3f,
    index: u32,
    scale: vec2f,
}

var<immediate> draw: Draw;

@vertex
fn place(@location(0) position: vec2f) -> @builtin(position) vec4f {
    return vec4f(position * draw.scale, 0.0, 1.0);
}

@fragment
fn tint() -> @location(0) vec4f {
    return vec4f(draw.tint, f32(draw.index));
}
