#version 450
// A push constant block without a qualifier follows std430, not std140: the array of
// float is tight. At least 128 bytes are there on every Vulkan device.

layout(push_constant) uniform DrawBlock {
    vec2 jitter;     // offset 0
    float ramp[2];   // offset 8, stride 4
    vec3 tint;       // offset 16
    float exposure;  // offset 28
    mat2 uvRotation; // offset 32, matrix stride 8
    uint material;   // offset 48
} draw;

layout(location = 0) in vec2 uv;
layout(location = 0) out vec4 color;

void main() {
    vec2 turned = draw.uvRotation * (uv + draw.jitter);
    float level = mix(draw.ramp[0], draw.ramp[1], fract(turned.x + turned.y));
    color = vec4(draw.tint * level * draw.exposure, float(draw.material & 255u) / 255.0);
}
