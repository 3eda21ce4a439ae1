// Six lights on a plane: a sun, four lamps, a torch. Full screen, one fragment a pixel.

struct Sun { direction: vec3<f32>, ambient: vec3<f32>, diffuse: vec3<f32>, specular: vec3<f32> }
struct Lamp {
    position: vec3<f32>, constant: f32,
    ambient: vec3<f32>, linear: f32,
    diffuse: vec3<f32>, quadratic: f32,
    specular: vec3<f32>,
}
struct Torch {
    position: vec3<f32>, inner: f32,
    direction: vec3<f32>, outer: f32,
    ambient: vec3<f32>, constant: f32,
    diffuse: vec3<f32>, linear: f32,
    specular: vec3<f32>, quadratic: f32,
}
struct Scene {
    eye: vec3<f32>, shininess: f32,
    sun: Sun,
    torch: Torch,
    lamps: array<Lamp, 4>,
    count: u32,
}
@group(0) @binding(0) var<uniform> scene: Scene;

const albedo = vec3<f32>(0.8, 0.6, 0.4);
const gloss = vec3<f32>(0.5, 0.5, 0.5);

fn falloff(constant: f32, linear: f32, quadratic: f32, d: f32) -> f32 {
    return 1.0 / (constant + linear * d + quadratic * (d * d));
}

fn sun_light(light: Sun, normal: vec3<f32>, view: vec3<f32>) -> vec3<f32> {
    let to_light = normalize(-light.direction);
    let diffuse = max(dot(normal, to_light), 0.0);
    let shine = pow(max(dot(view, reflect(-to_light, normal)), 0.0), scene.shininess);
    return light.ambient * albedo + light.diffuse * diffuse * albedo + light.specular * shine * gloss;
}

fn lamp_light(light: Lamp, normal: vec3<f32>, at: vec3<f32>, view: vec3<f32>) -> vec3<f32> {
    let to_light = normalize(light.position - at);
    let diffuse = max(dot(normal, to_light), 0.0);
    let shine = pow(max(dot(view, reflect(-to_light, normal)), 0.0), scene.shininess);
    let fade = falloff(light.constant, light.linear, light.quadratic, length(light.position - at));
    let sum = light.ambient * albedo + light.diffuse * diffuse * albedo + light.specular * shine * gloss;
    return sum * fade;
}

fn torch_light(light: Torch, normal: vec3<f32>, at: vec3<f32>, view: vec3<f32>) -> vec3<f32> {
    let to_light = normalize(light.position - at);
    let diffuse = max(dot(normal, to_light), 0.0);
    let shine = pow(max(dot(view, reflect(-to_light, normal)), 0.0), scene.shininess);
    let fade = falloff(light.constant, light.linear, light.quadratic, length(light.position - at));
    let theta = dot(to_light, normalize(-light.direction));
    let cone = clamp((theta - light.outer) / (light.inner - light.outer), 0.0, 1.0);
    let sum = light.ambient * albedo + light.diffuse * diffuse * albedo + light.specular * shine * gloss;
    return sum * fade * cone;
}

@fragment
fn main(@builtin(position) pixel: vec4<f32>) -> @location(0) vec4<f32> {
    let at = vec3<f32>(pixel.xy / 128.0 - 1.0, sin(pixel.x * 0.05) * 0.1);
    let normal = normalize(vec3<f32>(-cos(pixel.x * 0.05) * 0.3, 0.1, 1.0));
    let view = normalize(scene.eye - at);
    var color = sun_light(scene.sun, normal, view);
    for (var i = 0u; i < scene.count; i++) {
        color += lamp_light(scene.lamps[i], normal, at, view);
    }
    color += torch_light(scene.torch, normal, at, view);
    return vec4<f32>(color, 1.0);
}
