#version 450
// A direction as the host uploaded it, and a light whose type is read off w.

layout(std140, set = 0, binding = 0) uniform SunBlock {
    vec3 direction;
};

layout(location = 0) out vec4 color;

float sun(vec3 normal) {
    return max(dot(normal, normalize(-direction)), 0.0);
}

// 1 for a directional light, 0 for one with a place.
float type_by_w(mat4 view, vec4 light) {
    vec4 seen = view * light;
    return seen.w == 0.0 ? 1.0 : 0.0;
}

float type_by_tag(mat4 view, vec4 light, int tag) {
    vec4 seen = view * light;
    return tag == 0 ? 1.0 : 0.0 * seen.w;
}

void main() {
    color = vec4(sun(vec3(1.0)), type_by_w(mat4(1.0), vec4(1.0)), type_by_tag(mat4(1.0), vec4(1.0), 1), 1.0);
}
