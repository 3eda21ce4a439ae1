#version 330
// Vertex shader of the view-space scene: the camera is the origin. Seed form.

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

    // A vec4 is normalized, and its fourth component is the camera's distance: what is left
    // for x, y, z has another length at every vertex, and interpolation bends it (H15).
    outNormal = normalize(transpose(inverse(modelViewMatrix)) * vec4(normal, 0.0)).xyz;
    outTextCoord = texCoord;
}

// What is wrong here is wrong on purpose.
// landfall: allow-file(vec4-normalise)
