// As in GLSL, an f32 moves in behind a vec3f, and a vec3f starts at a multiple of 16.
// Unlike in std140, a struct is as large as its members need: FloatBehind is 32 bytes,
// Short is 4.

struct FloatBehind {
    color: vec3f,     // offset 0
    intensity: f32,   // offset 12
    direction: vec3f, // offset 16
    angle: f32,       // offset 28
}

struct FloatInFront {
    intensity: f32,   // offset 0
    color: vec3f,     // offset 16
    angle: f32,       // offset 28
    direction: vec3f, // offset 32
}

struct Short {
    exposure: f32, // offset 0
}

@group(0) @binding(0) var<uniform> tight: FloatBehind;
@group(0) @binding(1) var<uniform> loose: FloatInFront;
@group(0) @binding(2) var<uniform> short: Short;

@fragment
fn fragment_main() -> @location(0) vec4f {
    let a = tight.intensity * tight.angle * tight.direction.z;
    let b = loose.intensity * loose.angle * loose.direction.z;
    return vec4f(a * tight.color + b * loose.color, short.exposure);
}
