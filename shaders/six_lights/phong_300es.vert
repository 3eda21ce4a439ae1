#version 300 es
// Vertex shader of the six-light scene for OpenGL ES 3.0.

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 texCoords;

uniform mat4 model;
uniform mat4 view;
uniform mat4 projection;
uniform mat3 normalMatrix; // inverse transpose of model, computed once by the host

out highp vec3 FragPos;
out mediump vec3 Normal;
out mediump vec2 TexCoords;

void main() {
    vec4 world = model * vec4(position, 1.0);
    gl_Position = projection * (view * world);
    FragPos = world.xyz;
    Normal = normalMatrix * normal;
    TexCoords = texCoords;
}
