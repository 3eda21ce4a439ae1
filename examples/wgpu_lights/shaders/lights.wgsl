// 128 point lights in a uniform buffer, and what they give each of 64 points on a floor.

const MAX_LIGHTS: u32 = 128;

struct PointLight {
    position: vec3f,
    color: vec3f,
    intensity: f32,
    radius: f32,
}

struct Lights {
    lights: array<PointLight, MAX_LIGHTS>,
    count: u32,
}

// What the shader reads of one light.
struct Seen {
    position_and_intensity: vec4f,
    color_and_radius: vec4f,
}

@group(0) @binding(0) var<uniform> scene: Lights;
@group(0) @binding(1) var<storage, read_write> seen: array<Seen>;
@group(0) @binding(2) var<storage, read_write> lit: array<vec4f>;

// Copies each light, member by member, to where the processor can read it.
@compute @workgroup_size(64)
fn copy_lights(@builtin(global_invocation_id) id: vec3u) {
    if id.x < scene.count {
        let light = scene.lights[id.x];
        seen[id.x] = Seen(vec4f(light.position, light.intensity), vec4f(light.color, light.radius));
    }
}

// The light at a point of the floor y = 0, whose normal is up.
fn light_at(place: vec3f) -> vec3f {
    var sum = vec3f(0.0);
    for (var i = 0u; i < min(scene.count, MAX_LIGHTS); i++) {
        let light = scene.lights[i];
        let path = light.position - place;
        let d2 = max(dot(path, path), 1.0e-6);
        let end = max(1.0 - d2 / (light.radius * light.radius), 0.0);
        sum += light.color * light.intensity * max(path.y, 0.0) * inverseSqrt(d2) * end * end / d2;
    }
    return sum;
}

// Lights the points x = 0, 1, … of the floor.
@compute @workgroup_size(64)
fn light_floor(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&lit) {
        return;
    }
    lit[id.x] = vec4f(light_at(vec3f(f32(id.x), 0.0, 0.0)), 1.0);
}

struct Corner {
    @builtin(position) position: vec4f,
    @location(0) place: vec3f,
}

// A triangle over the whole window, which shows the floor from x = 0 to 64 and z = -8 to 8.
@vertex
fn corner(@builtin(vertex_index) index: u32) -> Corner {
    let at = vec2f(f32(index & 1u), f32(index >> 1u)) * 4.0 - 1.0;
    return Corner(vec4f(at, 0.0, 1.0), vec3f(32.0 + 32.0 * at.x, 0.0, 8.0 * at.y));
}

// The light there, compressed to what a screen shows: 100 is half of white.
@fragment
fn shade(corner: Corner) -> @location(0) vec4f {
    let light = light_at(corner.place);
    return vec4f(light / (100.0 + light), 1.0);
}
