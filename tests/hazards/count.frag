#version 450
// A count that is larger than the array.

#define LIGHTS 4

layout(std140, set = 0, binding = 0) uniform LightBlock {
    vec3 colors[LIGHTS];
    int count;
};

layout(location = 0) out vec4 color;

vec3 unclamped(float strength) {
    vec3 sum = vec3(0.0);
    for (int i = 0; i < count; i++) {
        sum += strength * colors[i];
    }
    return sum;
}

vec3 counted(float strength) {
    vec3 sum = vec3(0.0);
    for (int i = 0; i < clamp(count, 0, LIGHTS); i++) {
        sum += strength * colors[i];
    }
    return sum;
}

void main() {
    color = vec4(unclamped(1.0) + counted(1.0), 1.0);
}
