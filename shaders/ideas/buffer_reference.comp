#version 450
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
// A reference is an address of 8 bytes inside a block. The type it points to has a
// layout of its own, and may refer to itself.

layout(local_size_x = 1) in;

layout(buffer_reference) buffer LightList;

layout(buffer_reference, std430, buffer_reference_align = 16) buffer LightList {
    vec3 position;   // offset 0
    float intensity; // offset 12
    LightList next;  // offset 16
};

layout(push_constant) uniform HeadBlock {
    float exposure;  // offset 0
    LightList first; // offset 8
    uint count;      // offset 16
} head;

layout(std430, set = 0, binding = 0) writeonly buffer ResultBuffer {
    float result; // offset 0
};

void main() {
    float sum = 0.0;
    LightList light = head.first;
    for (uint i = 0u; i < head.count; i++) {
        sum += light.intensity / max(dot(light.position, light.position), 1.0e-6);
        light = light.next;
    }
    result = sum * head.exposure;
}

// Functions that follow references are not analysed.
// landfall: allow-file(not-analysed)
