#version 330 core
// Without std140 the driver chooses the offsets: `shared` and the silent default keep
// every member, `packed` may even drop what the shader does not read. Ask the driver
// for the numbers, or write std140.
// landfall: allow-file(rules-undeclared)

layout(shared) uniform SharedBlock {
    float a;
    vec3 b;
    float c[3];
} s;

layout(packed) uniform PackedBlock {
    float a;
    vec3 unread;
    mat3 b;
} p;

uniform SilentBlock {
    vec2 a;
    float b;
} q;

out vec4 color;

void main() {
    color = vec4(s.b * s.a + p.b[2] * p.a, s.c[1] + q.a.x * q.b);
}
