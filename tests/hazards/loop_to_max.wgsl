// In WGSL, as loop_to_max.frag.

const LIGHTS = 128;

struct PointLight {
    pos: vec3f,
    color: vec3f,
    intensity: f32,
    constant: f32,
    linear: f32,
    quadratic: f32,
}

struct PointLightBlock {
    data: array<PointLight, LIGHTS>,
    actually_used_count: i32,
}

@group(0) @binding(0) var<uniform> lights: PointLightBlock;

fn attenuation(light: PointLight, d: f32) -> f32 {
    return 1.0 / (light.constant + light.linear * d + light.quadratic * (d * d));
}

fn lit(i: i32, at: vec3f) -> vec3f {
    let light = lights.data[i];
    return light.color * light.intensity * attenuation(light, length(light.pos - at));
}

fn all_slots(at: vec3f) -> vec3f {
    var sum = vec3f();
    for (var i = 0; i < LIGHTS; i++) {
        sum += lit(i, at);
    }
    return sum;
}

fn counted(at: vec3f) -> vec3f {
    var sum = vec3f();
    for (var i = 0; i < clamp(lights.actually_used_count, 0, LIGHTS); i++) {
        sum += lit(i, at);
    }
    return sum;
}
