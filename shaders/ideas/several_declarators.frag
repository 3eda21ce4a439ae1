#version 330 core
// One type, several members: each declarator may add an array of its own.

layout(std140) uniform DeclaratorBlock {
    vec3 position, color;           // offset 0, 16
    float intensity, ramp[2], bias; // offset 28, 32, 64
    vec2 a[2], b;                   // offset 80, 112
} light;

out vec4 result;

void main() {
    result = vec4(light.position + light.color * light.intensity * light.ramp[1], light.bias);
    result.xy += light.a[1] + light.b;
}
