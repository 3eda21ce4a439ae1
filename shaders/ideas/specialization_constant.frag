#version 450
// Array sizes from specialisation constants: the defaults lay the block out, whatever
// the pipeline sets.
// landfall: allow-file(specialised-length)

layout(constant_id = 0) const int MAX_LIGHTS = 8;
layout(constant_id = 3) const int CASCADES = 4;

layout(std140, set = 0, binding = 0) uniform LightBlock {
    vec4 positions[MAX_LIGHTS]; // offset 0, stride 16
    mat4 cascades[CASCADES];    // offset 128, stride 64
    int count;                  // offset 384
};

layout(location = 0) in vec4 position;
layout(location = 0) out vec4 color;

void main() {
    vec4 sum = vec4(0.0);
    for (int i = 0; i < min(count, MAX_LIGHTS); i++) {
        sum += cascades[i % CASCADES] * (position - positions[i]);
    }
    color = sum;
}
