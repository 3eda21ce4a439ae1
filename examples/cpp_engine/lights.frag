#version 330 core
// The blocks an engine keeps for its lights.

#define MOST_LIGHTS 128

struct PointLight {
    vec3 pos;        // world space
    vec3 color;
    float intensity;
    float constant;  // attenuation: 1 / (constant + linear d + quadratic d²)
    float linear;
    float quadratic;
};

struct DirectionalLight {
    vec3 dir;
    vec3 color;
    float intensity;
};

layout(std140) uniform AmbientBlock {
    vec3 color;
    float intensity;
} u_ambient;

layout(std140) uniform DirectionalLightBlock {
    DirectionalLight data[MOST_LIGHTS];
    int actually_used_count; // lights in use
} u_directional_lights;

layout(std140) uniform PointLightBlock {
    PointLight data[MOST_LIGHTS];
    int actually_used_count; // lights in use
} u_point_lights;

in vec3 v_frag_pos;
in vec3 v_normal;
out vec4 o_color;

void main() {
    vec3 normal = normalize(v_normal);
    vec3 sum = u_ambient.color * u_ambient.intensity;
    for (int i = 0; i < u_directional_lights.actually_used_count; i++) {
        DirectionalLight light = u_directional_lights.data[i];
        sum += light.color * light.intensity * max(dot(normal, normalize(-light.dir)), 0.0);
    }
    for (int i = 0; i < u_point_lights.actually_used_count; i++) {
        PointLight light = u_point_lights.data[i];
        vec3 way = light.pos - v_frag_pos;
        float d = length(way);
        float fade = light.constant + light.linear * d + light.quadratic * d * d;
        sum += light.color * light.intensity * max(dot(normal, way / max(d, 1e-6)), 0.0) / fade;
    }
    o_color = vec4(sum, 1.0);
}
