// Arrays of resources and kinds that the driver of the tests lacks: compiled, not run.
enable wgpu_binding_array;
enable wgpu_ray_query;

struct Light {
    color: vec3f,
}

@group(0) @binding(0) var textures: binding_array<texture_2d<f32>, 4>;
@group(0) @binding(1) var samplers: binding_array<sampler, 2>;
@group(0) @binding(2) var<storage> lights: binding_array<Light, 3>;
@group(0) @binding(3) var camera: texture_external;
@group(0) @binding(4) var scene: acceleration_structure;
@group(0) @binding(5) var masks: binding_array<texture_storage_2d<r32uint, read>, 2>;

@group(0) @binding(6) var many: binding_array<texture_2d<f32>>;

@fragment
fn shade() -> @location(0) vec4f {
    var query: ray_query;
    rayQueryInitialize(&query, scene, RayDesc(0, 0xff, 0.0, 1.0, vec3f(0.0), vec3f(1.0)));
    let mask = textureLoad(masks[0], vec2i(0));
    return textureSample(many[7], samplers[1], vec2f(0.5)) + textureSample(textures[1], samplers[0], vec2f(0.0)) + vec4f(lights[0].color, 1.0)
        + textureLoad(camera, vec2i(0)) + vec4f(mask);
}
