// Immediates are WGSL's push constants: a few bytes set with the draw call itself.
// They follow the rules of storage, so their arrays may be tight.

struct Draw {
    tint: vec3f,           // offset 0
    exposure: f32,         // offset 12
    material: u32,         // offset 16
    ramp: array<f32, 3>,   // offset 20, stride 4
}

var<immediate> draw: Draw;

@fragment
fn fragment_main() -> @location(0) vec4f {
    return vec4f(draw.tint * draw.exposure, draw.ramp[min(draw.material, 2u)]);
}
