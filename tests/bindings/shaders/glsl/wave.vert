#version 450

layout(location = 0) in vec3 position;
layout(location = 1) in vec2 texcoord;
layout(location = 2) in ivec2 cell;

layout(set = 0, binding = 0, std140) uniform Camera { mat4 view; vec3 eye; } camera;
layout(push_constant) uniform Draw { mat4 model; vec4 tint; } draw;

layout(location = 0) out vec2 uv;

void main() {
    uv = texcoord + vec2(cell);
    gl_Position = camera.view * draw.model * vec4(position, 1.0);
}
