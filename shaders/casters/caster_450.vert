#version 450
// Vertex shader for the four light casters: positions and normals in world space.
// Vulkan GLSL: the three matrices form one block of 192 bytes.

layout(location = 0) in vec3 aPos;
layout(location = 1) in vec3 aNormal;
layout(location = 2) in vec2 aTexCoords;

layout(std140, set = 1, binding = 0) uniform TransformBlock {
    mat4 model;      // offset 0
    mat4 view;       // offset 64
    mat4 projection; // offset 128
};

layout(location = 0) out vec3 FragPos;
layout(location = 1) out vec3 Normal;
layout(location = 2) out vec2 TexCoords;

void main() {
    vec4 world = model * vec4(aPos, 1.0);
    gl_Position = projection * (view * world);
    FragPos = world.xyz;
    Normal = transpose(inverse(mat3(model))) * aNormal;
    TexCoords = aTexCoords;
}
