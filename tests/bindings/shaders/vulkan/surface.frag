#version 450

// Every kind of resource; one that is declared but not used, and one that only a function uses that
// nothing calls.
layout(constant_id = 3) const int COUNT = 4;

struct Light {
    vec3 position;
    float radius;
};

layout(set = 0, binding = 0) uniform Camera { mat4 view; vec3 eye; } camera;
layout(set = 0, binding = 1) readonly buffer Lights { Light lights[]; };
layout(set = 2, binding = 0) uniform sampler2D albedo[2];
layout(set = 2, binding = 1, rgba8) uniform writeonly image2D trail;
layout(set = 2, binding = 2) uniform texture2D normals;
layout(set = 2, binding = 3) uniform sampler linear;
layout(set = 2, binding = 4) uniform samplerBuffer table;
layout(set = 2, binding = 6) uniform sampler2DShadow shadows;
layout(set = 2, binding = 7) uniform texture2D spare;
layout(set = 1, binding = 0) buffer Uncalled { float never; };
layout(push_constant) uniform Draw { mat4 model; vec3 tint; } draw;

layout(location = 0) in vec2 uv;
layout(location = 0) out vec4 color;

float uncalled() {
    return never;
}

vec3 lit(vec3 at) {
    vec3 sum = vec3(0.0);
    // Hides the texture.
    for (int spare = 0; spare < COUNT; spare++) {
        sum += lights[spare].position - at;
    }
    return sum * texelFetch(table, 0).rgb;
}

void main() {
    vec3 normal = texture(sampler2D(normals, linear), uv).xyz;
    color = vec4(lit(camera.eye) * draw.tint, dot(normal, normal));
    color *= texture(albedo[0], uv) * texture(shadows, vec3(uv, 0.5));
    imageStore(trail, ivec2(0), color);
}
