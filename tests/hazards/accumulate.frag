#version 450
// Accumulators that nobody sets before the first light is added.

layout(std140, set = 0, binding = 0) uniform LightBlock {
    vec3 colors[4];
    int count;
};

layout(location = 0) out vec4 color;

vec3 open() {
    vec3 total;
    for (int i = 0; i < min(count, 4); i++) {
        total += colors[i];
    }
    return total;
}

vec3 set() {
    vec3 total = vec3(0.0);
    for (int i = 0; i < min(count, 4); i++) {
        total += colors[i];
    }
    return total;
}

void main() {
    color = vec4(open() + set(), 1.0);
}
