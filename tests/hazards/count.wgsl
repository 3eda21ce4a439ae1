// A count that is larger than the array.

const LIGHTS = 4;

struct LightBlock {
    colors: array<vec3f, LIGHTS>,
    count: i32,
}

@group(0) @binding(0) var<uniform> lights: LightBlock;

fn unclamped(strength: f32) -> vec3f {
    var sum = vec3f();
    for (var i = 0; i < lights.count; i++) {
        sum += strength * lights.colors[i];
    }
    return sum;
}

fn counted(strength: f32) -> vec3f {
    var sum = vec3f();
    for (var i = 0; i < clamp(lights.count, 0, LIGHTS); i++) {
        sum += strength * lights.colors[i];
    }
    return sum;
}
