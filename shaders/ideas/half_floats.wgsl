enable f16;

// f16 takes two bytes; vec3h aligns to 8 and takes 6, so an f16 fits behind it. Colours
// can be half as wide, positions should not be.

struct Light {
    position: vec3f, // offset 0
    range: f32,      // offset 12
    color: vec3h,    // offset 16
    intensity: f16,  // offset 22
    ramp: vec2h,     // offset 24
    cutoff: f16,     // offset 28
}

struct HalfBlock {
    lights: array<Light, 4>,   // offset 0, stride 32
    rotation: mat3x3<f16>,     // offset 128, matrix stride 8
    bias: f16,                 // offset 152
}

@group(0) @binding(0) var<storage, read> half: HalfBlock;

@fragment
fn fragment_main(@location(0) position: vec3f) -> @location(0) vec4f {
    var sum = vec3h();
    for (var i = 0u; i < 4u; i++) {
        let light = half.lights[i];
        let d = distance(light.position, position);
        if d < light.range {
            sum += half.rotation * light.color * (light.intensity * light.ramp.y + light.cutoff);
        }
    }
    return vec4f(vec3f(sum), f32(half.bias));
}
