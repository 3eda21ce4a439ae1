// No #version line means GLSL 1.10, or 1.00 on OpenGL ES: `varying`, texture2D and
// gl_FragColor, and uniforms that can only be loose.

#ifdef GL_ES
precision mediump float;
#endif

uniform vec3 lightPosition[4];
uniform vec3 lightColor[4];
uniform float lightReach[4];
uniform sampler2D albedo;

varying vec3 position;
varying vec3 normal;
varying vec2 uv;

void main() {
    vec3 n = normalize(normal);
    vec3 sum = vec3(0.1);
    for (int i = 0; i < 4; i++) {
        vec3 path = lightPosition[i] - position;
        float d = max(length(path), 1.0e-3);
        float reach = max(1.0 - d / max(lightReach[i], 1.0e-3), 0.0);
        sum += lightColor[i] * max(dot(n, path) / d, 0.0) * reach * reach;
    }
    gl_FragColor = vec4(sum, 1.0) * texture2D(albedo, uv);
}
