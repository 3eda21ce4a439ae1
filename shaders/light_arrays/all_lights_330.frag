#version 330 core
// 环境光 + 方向光数组 + 点光源数组：三个 std140 块，同一个片段着色器。
// (Ambient light, directional lights and point lights: three std140 blocks in one shader.)
//
// 缓冲区大小：AmbientBlock 16 字节，DirectionalLightBlock 4112 字节，PointLightBlock 6160 字节。

#define DIRECTIONAL_LIGHT_MAX_NUM 128
#define POINT_LIGHT_MAX_NUM 128

// 环境光
struct Ambient {
    vec3 color;      // offset 0，颜色
    float intensity; // offset 12，强度
};

// 方向光，每个元素 32 字节
struct DirectionalLight {
    vec3 dir;        // offset 0，光线前进的方向
    vec3 color;      // offset 16，颜色
    float intensity; // offset 28，强度
};

// 点光源，每个元素 48 字节
struct PointLight {
    vec3 pos;        // offset 0，世界坐标
    vec3 color;      // offset 16，颜色
    float intensity; // offset 28，强度

    float constant;  // offset 32，衰减的常数项
    float linear;    // offset 36，衰减的一次项
    float quadratic; // offset 40，衰减的二次项
};

layout(std140) uniform AmbientBlock {
    Ambient data; // offset 0
} u_ambient;

layout(std140) uniform DirectionalLightBlock {
    DirectionalLight data[DIRECTIONAL_LIGHT_MAX_NUM]; // offset 0
    int actually_used_count;                          // offset 4096，实际使用的数量
} u_directional_light_array;

layout(std140) uniform PointLightBlock {
    PointLight data[POINT_LIGHT_MAX_NUM]; // offset 0
    int actually_used_count;              // offset 6144，实际使用的数量
} u_point_light_array;

uniform sampler2D u_diffuse_texture;
uniform sampler2D u_specular_texture;
uniform vec3 u_view_pos;
uniform float u_specular_highlight_shininess;

in vec3 v_frag_pos;
in vec3 v_normal;
in vec2 v_uv;

out vec4 o_fragColor;

// 单位化；零向量仍然得到零向量，不会产生 NaN
vec3 unit(vec3 v) {
    return v * inversesqrt(max(dot(v, v), 1.0e-30));
}

// 一盏灯照到表面上的漫反射与高光之和；light_dir 指向光源
vec3 phong(vec3 light_dir, vec3 normal, vec3 view_dir, vec3 diffuse_texel, vec3 specular_texel) {
    float diffuse = max(dot(normal, light_dir), 0.0);
    float x = dot(view_dir, reflect(-light_dir, normal));
    // 底数限制在 (0, 1]：pow(0, 0) 没有定义
    float specular = x > 0.0 ? pow(min(x, 1.0), u_specular_highlight_shininess) : 0.0;
    return diffuse * diffuse_texel + specular * specular_texel;
}

// 距离衰减；三个系数都还没设置时分母为零，所以给一个下限
float attenuation(PointLight light, float d) {
    return 1.0 / max(light.constant + d * (light.linear + light.quadratic * d), 1.0e-6);
}

void main() {
    vec3 diffuse_texel = texture(u_diffuse_texture, v_uv).rgb;
    vec3 specular_texel = texture(u_specular_texture, v_uv).rgb;
    vec3 normal = unit(v_normal);
    vec3 view_dir = unit(u_view_pos - v_frag_pos);

    vec3 total = u_ambient.data.color * u_ambient.data.intensity * diffuse_texel;

    int directional_count = min(u_directional_light_array.actually_used_count, DIRECTIONAL_LIGHT_MAX_NUM);
    for (int i = 0; i < directional_count; i++) {
        DirectionalLight light = u_directional_light_array.data[i];
        total += light.color * light.intensity
               * phong(unit(-light.dir), normal, view_dir, diffuse_texel, specular_texel);
    }

    int point_count = min(u_point_light_array.actually_used_count, POINT_LIGHT_MAX_NUM);
    for (int i = 0; i < point_count; i++) {
        PointLight light = u_point_light_array.data[i];
        vec3 offset = light.pos - v_frag_pos;
        total += light.color * (light.intensity * attenuation(light, length(offset)))
               * phong(unit(offset), normal, view_dir, diffuse_texel, specular_texel);
    }

    o_fragColor = vec4(total, 1.0);
}
