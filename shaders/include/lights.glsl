// Light structs and the functions that go with them, for #include from any
// OpenGL or Vulkan shader. Declares no block, no binding and no input.

#ifndef LANDFALL_LIGHTS_GLSL
#define LANDFALL_LIGHTS_GLSL

struct DirectionalLight {
    vec3 direction;  // offset 0, the way the light travels
    float intensity; // offset 12
    vec3 color;      // offset 16
};

struct PointLight {
    vec3 position;   // offset 0
    float intensity; // offset 12
    vec3 color;      // offset 16
    float radius;    // offset 28: no light at all from here on
};

// Unit vector along v; the zero vector stays zero.
vec3 unit(vec3 v) {
    return v * inversesqrt(max(dot(v, v), 1.0e-30));
}

// Falls with the square of the distance and reaches exactly 0 at `radius`, so that
// a light may be skipped beyond it without any error. Within a centimetre it stays finite.
float windowed_falloff(float d, float radius) {
    float inside = clamp(1.0 - pow(d / max(radius, 1.0e-6), 4.0), 0.0, 1.0);
    return inside * inside / max(d * d, 1.0e-4);
}

vec3 directional_diffuse(DirectionalLight light, vec3 normal) {
    return light.color * (light.intensity * max(dot(normal, unit(-light.direction)), 0.0));
}

vec3 point_diffuse(PointLight light, vec3 position, vec3 normal) {
    vec3 path = light.position - position;
    float facing = max(dot(normal, unit(path)), 0.0);
    return light.color * (light.intensity * facing * windowed_falloff(length(path), light.radius));
}

#endif
