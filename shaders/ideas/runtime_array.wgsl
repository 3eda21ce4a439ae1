// A storage block may end in an array without a size. A bare array is a block too:
// without a struct, and without a name for it.

struct Light {
    position: vec3f, // offset 0
    range: f32,      // offset 12
    color: vec3f,    // offset 16
}

struct LightList {
    count: u32,           // offset 0
    lights: array<Light>, // offset 16, stride 32
}

@group(0) @binding(0) var<storage, read> list: LightList;
@group(0) @binding(1) var<storage, read_write> brightness: array<vec3f>; // stride 16

@compute @workgroup_size(64)
fn compute_main(@builtin(global_invocation_id) at: vec3u) {
    let count = min(list.count, min(arrayLength(&list.lights), arrayLength(&brightness)));
    if at.x < count {
        let light = list.lights[at.x];
        brightness[at.x] = light.color / max(dot(light.position, light.position), light.range * 1.0e-6 + 1.0e-6);
    }
}
