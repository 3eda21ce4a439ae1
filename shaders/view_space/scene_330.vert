#version 330
// Vertex shader of the view-space scene: the camera is the origin.

layout (location=0) in vec3 position;
layout (location=1) in vec3 normal;
layout (location=2) in vec2 texCoord;

uniform mat4 projectionMatrix;
uniform mat4 viewMatrix;
uniform mat4 modelMatrix;

out vec3 outPosition;
out vec3 outNormal;
out vec2 outTextCoord;

void main()
{
    mat4 modelViewMatrix = viewMatrix * modelMatrix;
    vec4 seen = modelViewMatrix * vec4(position, 1.0);
    gl_Position = projectionMatrix * seen;
    outPosition = seen.xyz;

    // Through a mat3: the inverse transpose of the whole mat4 gives a normal a fourth
    // component, and normalizing that vec4 would bend what is interpolated from it.
    outNormal = normalize(transpose(inverse(mat3(modelViewMatrix))) * normal);
    outTextCoord = texCoord;
}
