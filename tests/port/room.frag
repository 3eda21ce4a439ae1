#version 330 core
// A room lit by lamps: the light.
#define LAMPS 3
const int LAYERS = 2;

/* What a wall is made of. */
struct Wall {
    sampler2D paint;      // its colour
    sampler2D gloss;
    float shine;
};

struct Layer {
    sampler2D mask;
    vec3 tint;
};

struct Reach { float constant; float linear; float quadratic; };

struct Lamp {
    vec3 pos;
    vec3 color; // linear
    Reach reach;
};

in vec3 v_pos, v_normal;
in vec2 v_uv;

// Where the eye is.
uniform vec3 eye;
uniform Wall wall;          // the wall looked at
uniform Layer layers[LAYERS];
uniform Lamp lamps[LAMPS];
uniform struct Fog { vec3 color; float density; } fog;
uniform bool foggy;
uniform sampler2D noise, dust[2];
uniform float exposure = 1.25, weights[2]; /* of the picture */
uniform int used;

layout(std140) uniform Ambient {
    vec3 color;
    float intensity;
} ambient;

layout(location = 0) out vec4 o_color;

vec3 gloss_of(Wall w, vec2 uv);

float attenuation(Reach reach, float d) {
    return 1.0 / (reach.constant + reach.linear * d + reach.quadratic * d * d);
}

vec3 light(Lamp lamp, Wall w, vec3 normal) {
    vec3 way = lamp.pos - v_pos;
    float d = length(way);
    float lambert = max(dot(normal, way / max(d, 1e-5)), 0.0);
    vec3 half_way = normalize(normalize(eye - v_pos) + way / max(d, 1e-5));
    vec3 shine = gloss_of(w, v_uv) * pow(max(dot(normal, half_way), 0.0), w.shine * 8.0);
    return (texture(w.paint, v_uv).rgb * lambert + shine) * lamp.color * attenuation(lamp.reach, d);
}

vec3 gloss_of(Wall w, vec2 uv) {
    return texture(w.gloss, uv).rgb; // a texture of its own
}

vec3 cover(Layer layer, vec3 under) {
    return mix(under, layer.tint, texture(layer.mask, v_uv).r);
}

void main() {
    vec3 normal = normalize(v_normal);
    vec3 sum = ambient.color * ambient.intensity;
    for (int i = 0; i < LAMPS; i++) {
        if (i < used)
            sum += light(lamps[i], wall, normal);
    }
    sum = cover(layers[0], sum);
    sum = cover(layers[LAYERS - 1], sum);
    sum *= texture(noise, v_uv * 3.0).r + weights[0] * texture(dust[0], v_uv).g
        + weights[1] * texture(dust[1], v_uv).b;
    if (foggy) sum = mix(sum, fog.color, fog.density);
    o_color = vec4(sum * exposure, 1.0);
}
