#version 450
// layout(offset = N) leaves a gap on purpose, here for members that only other
// shaders read. Offsets must grow and keep the member's own alignment.

layout(std140, set = 0, binding = 0) uniform FrameBlock {
    layout(offset = 16) vec3 sunDirection;  // offset 16
    float sunIntensity;                     // offset 28
    layout(offset = 96) vec4 fog;           // offset 96
    layout(offset = 128) float exposure;    // offset 128
    float gamma;                            // offset 132
} frame;

layout(location = 0) in vec3 normal;
layout(location = 0) out vec4 color;

void main() {
    float lit = max(dot(normal, -frame.sunDirection), 0.0) * frame.sunIntensity;
    vec3 fogged = mix(vec3(lit), frame.fog.rgb, frame.fog.a) * frame.exposure;
    color = vec4(pow(max(fogged, 0.0), vec3(frame.gamma)), 1.0);
}
