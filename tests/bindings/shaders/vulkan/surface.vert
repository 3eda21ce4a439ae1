#version 450

// Inputs of each shape, a block of both stages and push constants.
layout(location = 0) in vec3 position;
layout(location = 1) in mat3 basis;
layout(location = 4) in uvec2 ids;
layout(location = 5) in float weights[2];
layout(location = 7) in ivec4 offset;

layout(set = 0, binding = 0) uniform Camera { mat4 view; vec3 eye; } camera;
layout(push_constant) uniform Draw { mat4 model; vec3 tint; } draw;

layout(location = 0) out vec2 uv;

void main() {
    uv = vec2(ids) * weights[0] + vec2(offset.xy);
    gl_Position = camera.view * draw.model * vec4(basis * position, weights[1]);
}
