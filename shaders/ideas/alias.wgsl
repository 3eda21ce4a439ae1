// An alias is another name for a type, never a type of its own: it has the layout of
// what it stands for.

alias Color = vec3f;
alias Real = f32;
alias Ramp = array<vec4<Real>, 4>;

struct Light {
    color: Color,     // offset 0
    intensity: Real,  // offset 12
}

alias Lights = array<Light, 8>;

struct LightBlock {
    ramp: Ramp,      // offset 0, stride 16
    lights: Lights,  // offset 64, stride 16
    count: u32,      // offset 192
}

@group(0) @binding(0) var<uniform> lights: LightBlock;

@fragment
fn fragment_main() -> @location(0) vec4f {
    var sum = Color();
    for (var i = 0u; i < min(lights.count, 8u); i++) {
        sum += lights.lights[i].color * lights.lights[i].intensity;
    }
    return vec4f(sum, 1.0) * lights.ramp[min(lights.count, 3u)];
}
