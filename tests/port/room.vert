#version 330 core
// A room lit by lamps: the vertices.

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 uv;

uniform mat4 mvp; // model, view and projection in one
uniform mat3 turn;
uniform vec2 tiling = vec2(2.0, 1.5);

out vec3 v_pos;
out vec3 v_normal;
out vec2 v_uv;
out float v_fog; // the fragment shader does not ask for it

void main() {
    v_pos = position;
    v_normal = turn * normal;
    v_uv = uv * tiling;
    v_fog = 0.5;
    gl_Position = mvp * vec4(position, 1.0);
}
