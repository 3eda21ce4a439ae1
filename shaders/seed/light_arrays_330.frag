#version 330 core
// An ambient light, up to 128 directional and up to 128 point lights, in std140 blocks.
//
// Seed form: the formulas as an engine book prints them, with what is wrong with them. The
// ids H1, H2, ... are those of tests/hazards/; light_arrays/all_lights_330.frag is the form to use.

#ifndef DIRECTIONAL_LIGHT_MAX_NUM
#define DIRECTIONAL_LIGHT_MAX_NUM 128
#endif
#ifndef POINT_LIGHT_MAX_NUM
#define POINT_LIGHT_MAX_NUM 128
#endif

// Never clamped to the array (H23). Defined as POINT_LIGHT_MAX_NUM, the loop runs over the
// slots nobody has set, and every fragment is NaN (H3b).
#ifndef DIRECTIONAL_LIGHT_COUNT
#define DIRECTIONAL_LIGHT_COUNT u_directional_light_array.actually_used_count
#endif
#ifndef POINT_LIGHT_COUNT
#define POINT_LIGHT_COUNT u_point_light_array.actually_used_count
#endif

struct Ambient {
    vec3 color;      // offset 0
    float intensity; // offset 12
};

struct DirectionalLight {
    vec3 dir;        // offset 0, the way the light travels
    vec3 color;      // offset 16
    float intensity; // offset 28
};

struct PointLight {
    vec3 pos;        // offset 0
    vec3 color;      // offset 16
    float intensity; // offset 28

    float constant;  // offset 32
    float linear;    // offset 36
    float quadratic; // offset 40
};

layout(std140) uniform AmbientBlock {
    Ambient data; // offset 0
} u_ambient;

layout(std140) uniform DirectionalLightBlock {
    DirectionalLight data[DIRECTIONAL_LIGHT_MAX_NUM]; // offset 0
    int actually_used_count;                          // offset 4096
} u_directional_light_array;

layout(std140) uniform PointLightBlock {
    PointLight data[POINT_LIGHT_MAX_NUM]; // offset 0
    int actually_used_count;              // offset 6144
} u_point_light_array;

uniform sampler2D u_diffuse_texture;
uniform sampler2D u_specular_texture;
uniform vec3 u_view_pos;
uniform float u_specular_highlight_shininess;

in vec3 v_frag_pos;
in vec3 v_normal;
in vec2 v_uv;

out vec4 o_fragColor;

// Divides by zero where nothing has been set (H3), overflows in d * d (H4).
float attenuation(float constant, float linear, float quadratic, float d) {
    return 1.0 / (constant + linear * d + quadratic * (d * d));
}

// Shines from behind the surface too (H13); a normal longer or shorter than 1 dims the
// highlight or makes it many times too bright (H14).
float highlight(vec3 light_dir, vec3 normal, vec3 view_dir, float shininess) {
    vec3 reflect_dir = reflect(-light_dir, normal);
    return pow(max(dot(view_dir, reflect_dir), 0.0), shininess);
}

// No highlight.
vec3 directional_light(DirectionalLight light, vec3 normal, vec3 view_dir,
                       vec3 diffuse_texel, vec3 specular_texel) {
    vec3 light_dir = normalize(-light.dir);
    float diffuse = max(dot(normalize(normal), light_dir), 0.0);
    return light.color * diffuse * light.intensity * diffuse_texel;
}

// The highlight knows no intensity, takes the colour of the diffuse texture, and mirrors
// at the normal as interpolated. No direction where the light is on the fragment (H1).
vec3 point_light(PointLight light, vec3 frag_pos, vec3 normal, vec3 view_dir,
                 vec3 diffuse_texel, vec3 specular_texel) {
    vec3 light_dir = normalize(light.pos - frag_pos);
    float diffuse = max(dot(normalize(normal), light_dir), 0.0);
    vec3 diffuse_color = light.color * diffuse * light.intensity * diffuse_texel;

    float specular = highlight(light_dir, normal, view_dir, u_specular_highlight_shininess);
    vec3 specular_color = light.color * specular * specular_texel.r * diffuse_texel;

    float d = length(light.pos - frag_pos);
    float weakening = attenuation(light.constant, light.linear, light.quadratic, d);
    return diffuse_color * weakening + specular_color * weakening;
}

void main() {
    vec3 diffuse_texel = texture(u_diffuse_texture, v_uv).rgb;
    vec3 specular_texel = texture(u_specular_texture, v_uv).rgb;
    vec3 view_dir = normalize(u_view_pos - v_frag_pos);

    vec3 ambient_color = u_ambient.data.color * u_ambient.data.intensity * diffuse_texel;

    // Nothing is in it yet, and nobody puts anything there (H12).
    vec3 total;

    for (int i = 0; i < DIRECTIONAL_LIGHT_COUNT; i++) {
        total += directional_light(u_directional_light_array.data[i], v_normal, view_dir,
                                   diffuse_texel, specular_texel);
    }
    for (int i = 0; i < POINT_LIGHT_COUNT; i++) {
        total += point_light(u_point_light_array.data[i], v_frag_pos, v_normal, view_dir,
                             diffuse_texel, specular_texel);
    }

    o_fragColor = vec4(ambient_color + total, 1.0);
}

// What is wrong here is wrong on purpose.
// landfall: allow-file(unnormalised-normal)
// landfall: allow-file(uninitialised-accumulator)
