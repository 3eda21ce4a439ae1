#version 140
#extension GL_ARB_explicit_attrib_location : require
layout(row_major) uniform;
layout(shared) uniform Camera {
    mat4 view;
    vec3 eye;
};
uniform Sun { vec3 dir; vec3 color; } sun;
uniform mat3 turn;
uniform samplerBuffer list;
#if __VERSION__ < 330
uniform float old; // only here
#else
uniform float recent;
#endif
in vec3 normal;
flat in int which;
layout(location = 0) out vec4 color;
void main() {
    vec3 n = turn * normal;
    color = vec4(sun.color * max(dot(n, sun.dir), old), 1.0) * texelFetch(list, which);
    color += view[0] * eye.x;
}
