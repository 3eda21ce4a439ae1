#version 330 core
// A bool in a block is 4 bytes wide, zero or anything else. A single byte written
// by the host leaves the other three to chance.

layout(std140) uniform FlagBlock {
    bool castsShadow;    // offset 0
    bool twoSided;       // offset 4
    bvec2 mirrored;      // offset 8
    bvec3 channels;      // offset 16
    bool fogged;         // offset 28
    bool layerOn[3];     // offset 32, stride 16
    float strength;      // offset 80
} flags;

out vec4 color;

void main() {
    float on = flags.castsShadow || flags.twoSided || any(flags.mirrored) ? 1.0 : 0.5;
    if (flags.fogged && flags.layerOn[0] && flags.layerOn[2]) {
        on *= flags.strength;
    }
    color = vec4(mix(vec3(0.0), vec3(on), flags.channels), 1.0);
}
