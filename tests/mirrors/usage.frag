#version 450
struct PointLight {
    vec3 pos;
    float range;
    vec3 color;
};
layout(std140, binding = 2) uniform PointLightBlock {
    PointLight data[128];
    int actually_used_count;
};
layout(std140, set = 1, binding = 0) uniform Camera {
    mat4 view;
    layout(row_major) mat4 projection;
    mat3 normal;
    mat2x3 two[2];
    bool on;
    bvec3 which;
    float weights[3];
    float grid[2][2];
    mat3 bones[2];
};
layout(std430) buffer Particles {
    uint count;
    PointLight list[];
};
layout(std430) buffer Samples {
    vec4 head;
    float samples[];
};
void main() {}
