#version 330 core
// 128 point lights in a uniform block. Column i of the picture is light i: row 0 its position and
// intensity, row 1 its colour and radius, and row 2 what all lights give the floor at x = i.

#define MAX_LIGHTS 128

struct PointLight {
    vec3 position;
    vec3 color;
    float intensity;
    float radius;
};

layout(std140) uniform Lights {
    PointLight lights[MAX_LIGHTS];
    int count;
} scene;

out vec4 o_color;

// The light on the floor y = 0, whose normal is up.
vec3 floor_at(vec3 place) {
    vec3 sum = vec3(0.0);
    for (int i = 0; i < min(scene.count, MAX_LIGHTS); i++) {
        vec3 path = scene.lights[i].position - place;
        float radius = scene.lights[i].radius;
        float d2 = max(dot(path, path), 1.0e-6);
        float end = max(1.0 - d2 / (radius * radius), 0.0);
        sum += scene.lights[i].color * scene.lights[i].intensity * max(path.y, 0.0)
             * inversesqrt(d2) * end * end / d2;
    }
    return sum;
}

void main() {
    int column = int(gl_FragCoord.x);
    int row = int(gl_FragCoord.y);
    if (row == 0) {
        o_color = vec4(scene.lights[column].position, scene.lights[column].intensity);
    } else if (row == 1) {
        o_color = vec4(scene.lights[column].color, scene.lights[column].radius);
    } else {
        o_color = vec4(floor_at(vec3(float(column), 0.0, 0.0)), 1.0);
    }
}
