#version 330 core
// Vertex shader for the four light casters: positions and normals in world space.

layout(location = 0) in vec3 aPos;
layout(location = 1) in vec3 aNormal;
layout(location = 2) in vec2 aTexCoords;

uniform mat4 model;
uniform mat4 view;
uniform mat4 projection;

out vec3 FragPos;
out vec3 Normal;
out vec2 TexCoords;

void main() {
    vec4 world = model * vec4(aPos, 1.0);
    gl_Position = projection * (view * world);
    FragPos = world.xyz;
    Normal = transpose(inverse(mat3(model))) * aNormal;
    TexCoords = aTexCoords;
}
