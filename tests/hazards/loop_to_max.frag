#version 450
// A loop over all slots, and one that stops at the lights there are.

#define LIGHTS 128

struct PointLight {
    vec3 pos;
    vec3 color;
    float intensity;
    float constant;
    float linear;
    float quadratic;
};

layout(std140, set = 0, binding = 0) uniform PointLightBlock {
    PointLight data[LIGHTS];
    int actually_used_count;
};

layout(location = 0) out vec4 color;

float attenuation(PointLight light, float d) {
    return 1.0 / (light.constant + light.linear * d + light.quadratic * (d * d));
}

vec3 lit(int i, vec3 at) {
    PointLight light = data[i];
    return light.color * light.intensity * attenuation(light, length(light.pos - at));
}

vec3 all_slots(vec3 at) {
    vec3 sum = vec3(0.0);
    for (int i = 0; i < LIGHTS; i++) {
        sum += lit(i, at);
    }
    return sum;
}

vec3 counted(vec3 at) {
    vec3 sum = vec3(0.0);
    for (int i = 0; i < clamp(actually_used_count, 0, LIGHTS); i++) {
        sum += lit(i, at);
    }
    return sum;
}

void main() {
    color = vec4(all_slots(vec3(0.0)) + counted(vec3(0.0)), 1.0);
}
