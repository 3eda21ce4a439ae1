#version 100
attribute vec3 position;
attribute vec3 normal;
attribute vec2 uv;
uniform mat4 mvp;
varying mediump vec2 v_uv;
varying vec3 v_normal;
varying vec3 v_pos;
void main() {
    v_uv = uv;
    v_normal = normal;
    v_pos = position;
    gl_Position = mvp * vec4(position, 1.0);
}
