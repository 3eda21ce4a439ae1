#version 450

layout(set = 0, binding = 0, std140) uniform Camera { mat4 view; vec3 eye; } camera;
layout(set = 0, binding = 1, std430) readonly buffer Lights { vec4 places[]; } scene;
layout(set = 1, binding = 0) uniform texture2D albedo;
layout(set = 1, binding = 1) uniform sampler linear;
layout(set = 1, binding = 2) uniform texture2D spare;
layout(push_constant) uniform Draw { mat4 model; vec4 tint; } draw;

layout(location = 0) in vec2 uv;
layout(location = 0) out vec4 color;

vec3 from_eye(vec3 at) {
    return at - camera.eye;
}

void main() {
    color = texture(sampler2D(albedo, linear), uv) * draw.tint * vec4(from_eye(scene.places[2].xyz), 1.0);
}
