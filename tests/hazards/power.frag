#version 450
// A power whose base is not kept from 0 and below.

layout(location = 0) out vec4 color;

float bare(float x, float n) {
    return pow(x, n);
}

float kept(float x, float n) {
    return x > 0.0 ? pow(min(x, 1.0), n) : 0.0;
}

void main() {
    color = vec4(bare(1.0, 1.0), kept(1.0, 1.0), 0.0, 1.0);
}
