#version 450
#extension GL_GOOGLE_include_directive : require
#include "light.glsl"

#ifndef MAX_LIGHTS
#define MAX_LIGHTS 4
#endif

layout(std140, set = 0, binding = 0) uniform Lights {
    PointLight lights[MAX_LIGHTS];
    int used; // lights in use, from the first
} scene;

layout(std140, set = 0, binding = 1) uniform Camera {
    mat4 view;
    mat3 normals;
    vec3 eye;
    bool fog;
    float fog_density[3];
} camera;

layout(location = 0) in vec3 world;
layout(location = 0) out vec4 color;

void main() {
    vec3 sum = vec3(0.0);
    for (int i = 0; i < min(scene.used, MAX_LIGHTS); i++) {
        vec3 to = scene.lights[i].position - world;
        float d = length(to);
        float window = clamp(1.0 - d / scene.lights[i].range, 0.0, 1.0);
        sum += scene.lights[i].color * scene.lights[i].intensity * window * window;
    }
    color = vec4(camera.normals * sum + camera.eye * camera.fog_density[0], 1.0);
}
