#version 330 core
// Vertex shader for the fragment shaders beside it: positions and normals in world space.

layout(location = 0) in vec3 a_pos;
layout(location = 1) in vec3 a_normal;
layout(location = 2) in vec2 a_uv;

uniform mat4 u_model;
uniform mat4 u_view;
uniform mat4 u_projection;

out vec3 v_frag_pos;
out vec3 v_normal;
out vec2 v_uv;

void main() {
    vec4 world = u_model * vec4(a_pos, 1.0);
    gl_Position = u_projection * (u_view * world);
    v_frag_pos = world.xyz;
    // Inverse transpose, so that a non-uniform scale keeps normals perpendicular.
    v_normal = mat3(transpose(inverse(u_model))) * a_normal;
    v_uv = a_uv;
}
