#version 330 core
// Without an instance name the members are global names. The program interface calls
// them `sunColor`, with an instance name it would be `SunBlock.sunColor`.

layout(std140) uniform SunBlock {
    vec3 sunDirection; // offset 0
    vec3 sunColor;     // offset 16
    float sunIntensity; // offset 28
};

in vec3 normal;
out vec4 color;

void main() {
    color = vec4(sunColor * sunIntensity * max(dot(normal, -sunDirection), 0.0), 1.0);
}
