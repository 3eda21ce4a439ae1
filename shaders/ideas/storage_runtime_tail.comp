#version 450
// A storage block may end in an array without a size: the buffer decides how many
// lights there are. std430 keeps arrays of float tight, and structs at their own alignment.

layout(local_size_x = 64) in;

struct Light {
    vec3 position;    // offset 0
    float radius;     // offset 12
    float ramp[3];    // offset 16, stride 4
    float intensity;  // offset 28; 32 bytes in all
};

layout(std430, set = 0, binding = 0) readonly buffer LightBuffer {
    uint count;        // offset 0
    float histogram[5]; // offset 4, stride 4
    Light lights[];    // offset 32, stride 32
};

layout(std430, set = 0, binding = 1) writeonly buffer ResultBuffer {
    float brightness[]; // offset 0, stride 4
};

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= min(count, uint(lights.length()))) {
        return;
    }
    Light light = lights[i];
    brightness[i] = light.intensity * light.ramp[i % 3u] * histogram[i % 5u]
                  / max(dot(light.position, light.position), light.radius * 1.0e-6 + 1.0e-6);
}
