#version 330 core
// A sampler may sit in a struct of loose uniforms. It has a location but no bytes:
// gathering the rest into a block means leaving it out.

struct Surface {
    sampler2D albedo;
    vec3 tint;
    samplerCube reflections;
    float roughness;
};

struct Layer {
    Surface surface;
    float weight;
};

uniform Layer layers[2];
uniform float exposure = 1.0;

in vec2 uv;
in vec3 reflected;
out vec4 color;

vec3 shade(Layer layer) {
    vec3 albedo = texture(layer.surface.albedo, uv).rgb * layer.surface.tint;
    vec3 mirror = textureLod(layer.surface.reflections, reflected, layer.surface.roughness * 8.0).rgb;
    return mix(mirror, albedo, clamp(layer.surface.roughness, 0.0, 1.0)) * layer.weight;
}

void main() {
    color = vec4((shade(layers[0]) + shade(layers[1])) * exposure, 1.0);
}
