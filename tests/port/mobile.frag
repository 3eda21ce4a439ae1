#version 100
#extension GL_OES_standard_derivatives : enable
#ifdef GL_ES
#ifdef GL_FRAGMENT_PRECISION_HIGH
precision highp float;
#else
precision mediump float;
#endif
#define LIGHTS 2 // what a telephone can do
#else
#define LIGHTS 8
#endif

#if __VERSION__ >= 300 || defined(VULKAN)
#define SAMPLE texture
#else
#define SAMPLE(t, at) texture2D(t, at)
#endif

struct Light {
    lowp vec3 color;
    highp vec3 pos;
    float range;
};

uniform lowp sampler2D texture; // an old name for one
uniform Light lights[LIGHTS];
#ifdef GL_OES_standard_derivatives
uniform float edge;
#endif
uniform float sample;

varying vec3 v_pos;
varying vec3 v_normal;
varying mediump vec2 v_uv;

void main() {
    vec3 sum = vec3(sample * 0.1);
    for (int i = 0; i < LIGHTS; i++) {
        vec3 way = lights[i].pos - v_pos;
        float near = max(0.0, 1.0 - length(way) / lights[i].range);
        sum += lights[i].color * near * max(dot(normalize(v_normal), normalize(way)), 0.0);
    }
#ifdef GL_OES_standard_derivatives
    sum += edge * fwidth(v_uv.x);
#endif
    gl_FragColor = vec4(sum, 1.0) * SAMPLE(texture, v_uv) + texture2D(texture, v_uv.yx) * 0.25;
}
