#version 330 core
// Vertex shader of many lights: positions and normals in world space.

layout(location = 0) in vec3 aPos;
layout(location = 1) in vec3 aNormal;

uniform mat4 model;
uniform mat4 view;
uniform mat4 projection;

out vec3 FragPos;
out vec3 Normal;

void main() {
    vec4 world = model * vec4(aPos, 1.0);
    gl_Position = projection * (view * world);
    FragPos = world.xyz;
    Normal = transpose(inverse(mat3(model))) * aNormal;
}
