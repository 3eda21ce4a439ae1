#version 450
// The normal half way between two vertices, normalized as a vec4 at each, and as it
// should be.

layout(location = 0) out vec4 color;

vec3 bent(mat4 modelView, vec3 a, vec3 b) {
    mat4 turn = transpose(inverse(modelView));
    vec3 left = normalize(turn * vec4(a, 0.0)).xyz;
    vec3 right = normalize(turn * vec4(b, 0.0)).xyz;
    return normalize(0.5 * left + 0.5 * right);
}

vec3 straight(mat4 modelView, vec3 a, vec3 b) {
    mat3 turn = transpose(inverse(mat3(modelView)));
    vec3 left = normalize(turn * a);
    vec3 right = normalize(turn * b);
    return normalize(0.5 * left + 0.5 * right);
}

void main() {
    color = vec4(bent(mat4(1.0), vec3(1.0), vec3(0.5)) + straight(mat4(1.0), vec3(1.0), vec3(0.5)), 1.0);
}
