#version 330 core
// A float moves into the fourth component of the vec3 before it.
// The other way round it cannot: a vec3 always starts at a multiple of 16.

layout(std140) uniform FloatBehind {
    vec3 color;      // offset 0
    float intensity; // offset 12
    vec3 direction;  // offset 16
    float angle;     // offset 28
} tight; // 32 bytes

layout(std140) uniform FloatInFront {
    float intensity; // offset 0
    vec3 color;      // offset 16
    float angle;     // offset 28
    vec3 direction;  // offset 32
} loose; // 48 bytes

out vec4 color;

void main() {
    float a = tight.intensity * tight.angle * tight.direction.z;
    float b = loose.intensity * loose.angle * loose.direction.z;
    color = vec4(a * tight.color + b * loose.color, 1.0);
}
