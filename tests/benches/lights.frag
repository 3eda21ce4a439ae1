#version 330 core
// The block the bench of mirrors fills.
struct PointLight {
    vec3 pos;
    vec3 color;
    float intensity;
    float constant;
    float linear;
    float quadratic;
};

layout(std140) uniform PointLightBlock {
    PointLight data[128];
    int actually_used_count;
} u_point_light_array;

void main() {}
