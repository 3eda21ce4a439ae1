// Many lights: an ambient one, a few suns, and storage buffers of point lights and
// spotlights, as long as the scene needs them. Their attenuation has no end.
// The screen is cut into tiles; each has a list of the point lights that reach it.
//
// The overrides leave out the types a scene has none of, with their loops and their code.

override HAS_DIRECTIONAL_LIGHTS: bool = true;
override HAS_POINT_LIGHTS: bool = true;
override HAS_SPOT_LIGHTS: bool = true;

const MAX_DIRECTIONAL_LIGHTS = 4;

struct Ambient {
    color: vec3f,   // offset 0
    intensity: f32, // offset 12
}

struct DirectionalLight {
    direction: vec3f, // offset 0, the way the light travels
    color: vec3f,     // offset 16
    intensity: f32,   // offset 28, size 32 in all
}

struct PointLight {
    position: vec3f, // offset 0
    range: f32,      // offset 12, not used: this light has no end
    color: vec3f,    // offset 16
    intensity: f32,  // offset 28

    constant: f32,   // offset 32
    linear: f32,     // offset 36
    quadratic: f32,  // offset 40, size 48 in all
}

struct SpotLight {
    position: vec3f,  // offset 0
    range: f32,       // offset 12
    color: vec3f,     // offset 16
    intensity: f32,   // offset 28
    direction: vec3f, // offset 32, the way the light travels
    cutOff: f32,      // offset 44, cosine of the inner cone's half angle

    constant: f32,    // offset 48
    linear: f32,      // offset 52
    quadratic: f32,   // offset 56
    outerCutOff: f32, // offset 60, cosine of the outer one's; size 64 in all
}

struct SceneBlock {
    viewPos: vec3f,        // offset 0
    directionalCount: u32, // offset 12
    ambient: Ambient,      // offset 16
    directionalLights: array<DirectionalLight, MAX_DIRECTIONAL_LIGHTS>, // offset 32
}

struct PointLightBlock {
    pointCount: u32,                // offset 0
    pointLights: array<PointLight>, // offset 16, stride 48
}

struct SpotLightBlock {
    spotCount: u32,               // offset 0
    spotLights: array<SpotLight>, // offset 16, stride 64
}

struct Tile {
    first: u32, // offset 0, in `indices`
    count: u32, // offset 4
}

struct TileBlock {
    tileSize: u32,      // offset 0, in pixels
    tilesAcross: u32,   // offset 4
    tiles: array<Tile>, // offset 8, stride 8: rows from the first pixel
}

struct IndexBlock {
    indices: array<u32>, // offset 0: numbers of point lights
}

struct TransformBlock {
    model: mat4x4f,      // offset 0
    view: mat4x4f,       // offset 64
    projection: mat4x4f, // offset 128
    normal: mat3x3f,     // offset 192: inverse transpose of model, WGSL has no inverse()
}

struct MaterialBlock {
    diffuse: vec3f,  // offset 0
    shininess: f32,  // offset 12
    specular: vec3f, // offset 16
}

@group(0) @binding(0) var<uniform> scene: SceneBlock;
@group(0) @binding(1) var<storage, read> points: PointLightBlock;
@group(0) @binding(2) var<storage, read> spots: SpotLightBlock;
@group(0) @binding(3) var<storage, read> grid: TileBlock;
@group(0) @binding(4) var<storage, read> lists: IndexBlock;
@group(1) @binding(0) var<uniform> transform: TransformBlock;
@group(2) @binding(0) var<uniform> material: MaterialBlock;

struct Surface {
    @builtin(position) clip: vec4f,
    @location(0) fragPos: vec3f,
    @location(1) normal: vec3f,
}

@vertex
fn vertex_main(@location(0) pos: vec3f, @location(1) normal: vec3f) -> Surface {
    let world = transform.model * vec4f(pos, 1.0);
    return Surface(transform.projection * (transform.view * world), world.xyz, transform.normal * normal);
}

// Unit vector along v; the zero vector stays zero.
fn unit(v: vec3f) -> vec3f {
    return v * inverseSqrt(max(dot(v, v), 1.0e-30));
}

// Set SQUARINGS where the shininess is known to be 2 to that power: so many squarings take a
// third of the time of any power. -1 is any shininess.
override SQUARINGS: i32 = -1;

// (1 - m)^n for m >= 0 and n >= 0, as exp(n log(1 - m)); 0 from m = 1 on. Where 1 - m has
// lost the digits of m, the logarithm is taken from m itself, by its series.
fn power(m: f32, n: f32) -> f32 {
    if SQUARINGS >= 0 {
        var x = max(1.0 - m, 0.0);
        for (var i = 0; i < SQUARINGS; i++) {
            x *= x;
        }
        return x;
    }
    let series = m * (1.0 + m * (1.0 / 2.0 + m * (1.0 / 3.0 + m * (1.0 / 4.0 + m * (1.0 / 5.0 + m / 6.0)))));
    let exponent = select(-log(max(1.0 - m, 1.0e-30)), series, m < 0.015625);
    return select(0.0, exp(-n * exponent), m < 1.0);
}

// Phong's highlight. The eye is mirrored, not the light: that is the same for all lights
// of a fragment. 1 - cos is half the squared chord, which stays exact where the cosine is
// nearly 1. A light behind the surface has no highlight.
fn highlight(toLight: vec3f, normal: vec3f, viewDir: vec3f, shininess: f32) -> f32 {
    let chord = toLight - reflect(-viewDir, normal);
    let m = select(1.0, 0.5 * dot(chord, chord), dot(normal, toLight) > 0.0);
    return power(m, shininess);
}

// 1 / (constant + linear d + quadratic d^2), kept finite when nothing has been set yet.
fn attenuation(constant: f32, linear: f32, quadratic: f32, d: f32) -> f32 {
    return 1.0 / max(constant + d * (linear + quadratic * d), 1.0e-4);
}

// 1 inside the inner cone, 0 outside the outer one; 1 - cos is taken from the chord.
fn cone(toLight: vec3f, direction: vec3f, cutOff: f32, outerCutOff: f32) -> f32 {
    let chord = toLight - unit(-direction);
    let outer = 1.0 - outerCutOff;
    let inner = 1.0 - cutOff;
    return clamp((outer - 0.5 * dot(chord, chord)) / max(outer - inner, 1.0e-9), 0.0, 1.0);
}

// What is reflected of light of strength 1 from `toLight`.
fn phong(toLight: vec3f, normal: vec3f, viewDir: vec3f) -> vec3f {
    return material.diffuse * max(dot(normal, toLight), 0.0)
         + material.specular * highlight(toLight, normal, viewDir, material.shininess);
}

fn directional_light(light: DirectionalLight, normal: vec3f, viewDir: vec3f) -> vec3f {
    return light.color * light.intensity * phong(unit(-light.direction), normal, viewDir);
}

fn point_light(light: PointLight, fragPos: vec3f, normal: vec3f, viewDir: vec3f) -> vec3f {
    let path = light.position - fragPos;
    let d2 = dot(path, path);
    let inverse = inverseSqrt(max(d2, 1.0e-30)); // one root for the direction and the distance
    let weakening = attenuation(light.constant, light.linear, light.quadratic, d2 * inverse);
    return light.color * (light.intensity * weakening) * phong(path * inverse, normal, viewDir);
}

fn spot_light(light: SpotLight, fragPos: vec3f, normal: vec3f, viewDir: vec3f) -> vec3f {
    let path = light.position - fragPos;
    let d2 = dot(path, path);
    let inverse = inverseSqrt(max(d2, 1.0e-30));
    let inside = cone(path * inverse, light.direction, light.cutOff, light.outerCutOff);
    if inside <= 0.0 {
        return vec3f();
    }
    let weakening = attenuation(light.constant, light.linear, light.quadratic, d2 * inverse);
    return light.color * (light.intensity * inside * weakening) * phong(path * inverse, normal, viewDir);
}

@fragment
fn fragment_main(in: Surface) -> @location(0) vec4f {
    let normal = unit(in.normal);
    let viewDir = unit(scene.viewPos - in.fragPos);

    var sum = scene.ambient.color * scene.ambient.intensity * material.diffuse;
    if HAS_DIRECTIONAL_LIGHTS {
        let count = min(scene.directionalCount, u32(MAX_DIRECTIONAL_LIGHTS));
        for (var i = 0u; i < count; i++) {
            sum += directional_light(scene.directionalLights[i], normal, viewDir);
        }
    }
    if HAS_POINT_LIGHTS {
        let at = vec2u(in.clip.xy) / max(grid.tileSize, 1u);
        let here = min(at.y * grid.tilesAcross + at.x, arrayLength(&grid.tiles) - 1u);
        let tile = grid.tiles[here];
        let end = min(tile.first + tile.count, arrayLength(&lists.indices));
        for (var i = tile.first; i < end; i++) {
            let light = lists.indices[i];
            if light < arrayLength(&points.pointLights) {
                sum += point_light(points.pointLights[light], in.fragPos, normal, viewDir);
            }
        }
    }
    if HAS_SPOT_LIGHTS {
        let count = min(spots.spotCount, arrayLength(&spots.spotLights));
        for (var i = 0u; i < count; i++) {
            sum += spot_light(spots.spotLights[i], in.fragPos, normal, viewDir);
        }
    }
    return vec4f(sum, 1.0);
}
