#version 450
#extension GL_EXT_scalar_block_layout : require
// Scalar rules: everything is aligned like its scalars, so a vec3 takes 12 bytes and
// may start at any multiple of 4. This is how C lays out the same struct.

layout(local_size_x = 64) in;

struct Light {
    vec3 position;   // offset 0
    vec3 color;      // offset 12
    float intensity; // offset 24; 28 bytes in all
};

layout(scalar, set = 0, binding = 0) readonly buffer LightBuffer {
    uint count;      // offset 0
    vec3 ambient;    // offset 4
    mat3 rotation;   // offset 16, matrix stride 12
    Light lights[];  // offset 52, stride 28
};

layout(scalar, set = 0, binding = 1) writeonly buffer ResultBuffer {
    vec3 result[]; // offset 0, stride 12
};

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < count) {
        result[i] = ambient + lights[i].color * lights[i].intensity * (rotation * lights[i].position).z;
    }
}
