#version 450
// Many lights: an ambient one, a few suns, and storage buffers of point lights and
// spotlights, as long as the scene needs them. Their attenuation is windowed: it ends at a range, exactly.
// The screen is cut into tiles; each has a list of the point lights that reach it.
//
// Types a scene has none of are left out, with their loops and their code: by macros, or,
// with SPECIALIZED, by the constants of a pipeline.

#ifdef SPECIALIZED
layout(constant_id = 0) const bool HAS_DIRECTIONAL_LIGHTS = true;
layout(constant_id = 1) const bool HAS_POINT_LIGHTS = true;
layout(constant_id = 2) const bool HAS_SPOT_LIGHTS = true;
#else
#ifndef HAS_DIRECTIONAL_LIGHTS
#define HAS_DIRECTIONAL_LIGHTS 1
#endif
#ifndef HAS_POINT_LIGHTS
#define HAS_POINT_LIGHTS 1
#endif
#ifndef HAS_SPOT_LIGHTS
#define HAS_SPOT_LIGHTS 1
#endif
#endif

#define MAX_DIRECTIONAL_LIGHTS 4

layout(location = 0) in vec3 FragPos;
layout(location = 1) in vec3 Normal;

layout(location = 0) out vec4 FragColor;

struct Ambient {
    vec3 color;      // offset 0
    float intensity; // offset 12
};

struct DirectionalLight {
    vec3 direction;  // offset 0, the way the light travels
    vec3 color;      // offset 16
    float intensity; // offset 28, size 32 in all
};

struct PointLight {
    vec3 position;   // offset 0
    float range;     // offset 12, from here on there is no light
    vec3 color;      // offset 16
    float intensity; // offset 28

    float constant;  // offset 32
    float linear;    // offset 36
    float quadratic; // offset 40, size 48 in all
};

struct SpotLight {
    vec3 position;     // offset 0
    float range;       // offset 12
    vec3 color;        // offset 16
    float intensity;   // offset 28
    vec3 direction;    // offset 32, the way the light travels
    float cutOff;      // offset 44, cosine of the inner cone's half angle

    float constant;    // offset 48
    float linear;      // offset 52
    float quadratic;   // offset 56
    float outerCutOff; // offset 60, cosine of the outer one's; size 64 in all
};

layout(std140, set = 0, binding = 0) uniform SceneBlock {
    vec3 viewPos;          // offset 0
    uint directionalCount; // offset 12
    Ambient ambient;       // offset 16
    DirectionalLight directionalLights[MAX_DIRECTIONAL_LIGHTS]; // offset 32
};

layout(std430, set = 0, binding = 1) readonly buffer PointLightBlock {
    uint pointCount;          // offset 0
    PointLight pointLights[]; // offset 16, stride 48
};

layout(std430, set = 0, binding = 2) readonly buffer SpotLightBlock {
    uint spotCount;         // offset 0
    SpotLight spotLights[]; // offset 16, stride 64
};

struct Tile {
    uint first; // offset 0, in `indices`
    uint count; // offset 4
};

layout(std430, set = 0, binding = 3) readonly buffer TileBlock {
    uint tileSize;    // offset 0, in pixels
    uint tilesAcross; // offset 4
    Tile tiles[];     // offset 8, stride 8: rows from the first pixel
};

layout(std430, set = 0, binding = 4) readonly buffer IndexBlock {
    uint indices[]; // offset 0: numbers of point lights
};

layout(std140, set = 2, binding = 0) uniform MaterialBlock {
    vec3 diffuse;    // offset 0
    float shininess; // offset 12
    vec3 specular;   // offset 16
} material;

// Unit vector along v; the zero vector stays zero.
vec3 unit(vec3 v) {
    return v * inversesqrt(max(dot(v, v), 1.0e-30));
}

// Set SQUARINGS where the shininess is known to be 2 to that power: so many squarings take a
// third of the time of any power. -1 is any shininess.
#ifndef SQUARINGS
#define SQUARINGS -1
#endif

// (1 - m)^n for m >= 0 and n >= 0, as exp(n log(1 - m)); 0 from m = 1 on. Where 1 - m has
// lost the digits of m, the logarithm is taken from m itself, by its series.
float power(float m, float n) {
#if SQUARINGS >= 0
    float x = max(1.0 - m, 0.0);
    for (int i = 0; i < SQUARINGS; i++) {
        x *= x;
    }
    return x;
#else
    float series = m * (1.0 + m * (1.0 / 2.0 + m * (1.0 / 3.0 + m * (1.0 / 4.0 + m * (1.0 / 5.0 + m / 6.0)))));
    float exponent = m < 0.015625 ? series : -log(max(1.0 - m, 1.0e-30));
    return m < 1.0 ? exp(-n * exponent) : 0.0;
#endif
}

// Phong's highlight. The eye is mirrored, not the light: that is the same for all lights
// of a fragment. 1 - cos is half the squared chord, which stays exact where the cosine is
// nearly 1. A light behind the surface has no highlight.
float highlight(vec3 toLight, vec3 normal, vec3 viewDir, float shininess) {
    vec3 chord = toLight - reflect(-viewDir, normal);
    float m = dot(normal, toLight) > 0.0 ? 0.5 * dot(chord, chord) : 1.0;
    return power(m, shininess);
}

// 1 / (constant + linear d + quadratic d^2), kept finite when nothing has been set yet.
float attenuation(float constant, float linear, float quadratic, float d) {
    return 1.0 / max(constant + d * (linear + quadratic * d), 1.0e-4);
}

// 1 inside the inner cone, 0 outside the outer one; 1 - cos is taken from the chord.
float cone(vec3 toLight, vec3 direction, float cutOff, float outerCutOff) {
    vec3 chord = toLight - unit(-direction);
    float outer = 1.0 - outerCutOff;
    float inner = 1.0 - cutOff;
    return clamp((outer - 0.5 * dot(chord, chord)) / max(outer - inner, 1.0e-9), 0.0, 1.0);
}

// (1 - (d / range)^4)^2: 1 near the light, and exactly 0 from the range on, so that a light
// may be left out of every tile it does not reach.
float window(float d2, float range) {
    float s = d2 / max(range * range, 1.0e-30);
    float rest = max(1.0 - s * s, 0.0);
    return rest * rest;
}

// What is reflected of light of strength 1 from `toLight`.
vec3 phong(vec3 toLight, vec3 normal, vec3 viewDir) {
    return material.diffuse * max(dot(normal, toLight), 0.0)
         + material.specular * highlight(toLight, normal, viewDir, material.shininess);
}

vec3 directional_light(DirectionalLight light, vec3 normal, vec3 viewDir) {
    return light.color * light.intensity * phong(unit(-light.direction), normal, viewDir);
}

vec3 point_light(PointLight light, vec3 fragPos, vec3 normal, vec3 viewDir) {
    vec3 path = light.position - fragPos;
    float d2 = dot(path, path);
    if (d2 >= light.range * light.range) {
        return vec3(0.0);
    }
    float inverse = inversesqrt(max(d2, 1.0e-30)); // one root for the direction and the distance
    float weakening = attenuation(light.constant, light.linear, light.quadratic, d2 * inverse)
                    * window(d2, light.range);
    return light.color * (light.intensity * weakening) * phong(path * inverse, normal, viewDir);
}

vec3 spot_light(SpotLight light, vec3 fragPos, vec3 normal, vec3 viewDir) {
    vec3 path = light.position - fragPos;
    float d2 = dot(path, path);
    float inverse = inversesqrt(max(d2, 1.0e-30));
    float inside = cone(path * inverse, light.direction, light.cutOff, light.outerCutOff);
    if (inside <= 0.0 || d2 >= light.range * light.range) {
        return vec3(0.0);
    }
    float weakening = attenuation(light.constant, light.linear, light.quadratic, d2 * inverse)
                    * window(d2, light.range);
    return light.color * (light.intensity * inside * weakening) * phong(path * inverse, normal, viewDir);
}

void main() {
    vec3 normal = unit(Normal);
    vec3 viewDir = unit(viewPos - FragPos);

    vec3 sum = ambient.color * ambient.intensity * material.diffuse;
    if (bool(HAS_DIRECTIONAL_LIGHTS)) {
        uint directionals = min(directionalCount, uint(MAX_DIRECTIONAL_LIGHTS));
        for (uint i = 0u; i < directionals; i++) {
            sum += directional_light(directionalLights[i], normal, viewDir);
        }
    }
    if (bool(HAS_POINT_LIGHTS)) {
        uvec2 at = uvec2(gl_FragCoord.xy) / max(tileSize, 1u);
        uint here = min(at.y * tilesAcross + at.x, uint(tiles.length()) - 1u);
        Tile tile = tiles[here];
        uint end = min(tile.first + tile.count, uint(indices.length()));
        for (uint i = tile.first; i < end; i++) {
            uint light = indices[i];
            if (light < uint(pointLights.length())) {
                sum += point_light(pointLights[light], FragPos, normal, viewDir);
            }
        }
    }
    if (bool(HAS_SPOT_LIGHTS)) {
        uint spots = min(spotCount, uint(spotLights.length()));
        for (uint i = 0u; i < spots; i++) {
            sum += spot_light(spotLights[i], FragPos, normal, viewDir);
        }
    }
    FragColor = vec4(sum, 1.0);
}
