#version 100
// Vertex shader of the scene for OpenGL ES 2.0.

attribute vec3 position;
attribute vec3 normal;
attribute vec2 texCoords;

uniform mat4 model;
uniform mat4 viewProjection;
uniform mat3 normalMatrix; // inverse transpose of model, computed once by the host

varying vec3 FragPos;
varying vec3 Normal;
varying vec2 TexCoords;

void main() {
    vec4 world = model * vec4(position, 1.0);
    gl_Position = viewProjection * world;
    FragPos = world.xyz;
    Normal = normalMatrix * normal;
    TexCoords = texCoords;
}
