#version 330 core
// std140 rounds the stride of every array up to 16: four floats take 64 bytes, and
// what follows an array starts behind its last padding, never inside it.

layout(std140) uniform FalloffBlock {
    float weights[4]; // offset 0, stride 16
    float scale;      // offset 64
    vec3 tints[2];    // offset 80, stride 16
    float bias;       // offset 112, not 108
    vec2 ramp[3];     // offset 128, stride 16
};

in float distance_to_light;
out vec4 color;

void main() {
    int i = int(clamp(distance_to_light, 0.0, 3.0));
    vec2 end = ramp[min(i, 2)];
    color = vec4(tints[i / 2] * (weights[i] * scale + bias) * mix(end.x, end.y, 0.5), 1.0);
}
