#version 450
// The weakening over a distance of two places, and the cosine of a light that
// only grazes the surface.

layout(location = 0) out vec4 color;

float weakened(vec3 light, vec3 at) {
    vec3 path = light - at;
    return 1.0 / (1.0 + dot(path, path));
}

float facing(vec3 normal, vec3 toLight) {
    return max(dot(normalize(normal), normalize(toLight)), 0.0);
}

void main() {
    color = vec4(weakened(vec3(1.0), vec3(0.0)), facing(vec3(1.0), vec3(1.0)), 0.0, 1.0);
}
