#version 450
#extension GL_EXT_shader_explicit_arithmetic_types : require
#extension GL_EXT_shader_8bit_storage : require
#extension GL_EXT_shader_16bit_storage : require
// 8, 16 and 64 bit members in std430: each aligns to its own width, and a vector of
// them to two or four times that.

layout(local_size_x = 1) in;

layout(std430, set = 0, binding = 0) buffer PackedLights {
    uint8_t kind;         // offset 0
    uint16_t mask;        // offset 2
    float16_t intensity;  // offset 4
    f16vec3 color;        // offset 8
    int8_t bias;          // offset 14
    uint64_t id;          // offset 16
    i16vec2 tile;         // offset 24
    f16mat2 rotation;     // offset 28, matrix stride 4
    u64vec2 address;      // offset 48
    float16_t ramp[5];    // offset 64, stride 2
    float range;          // offset 76
} lights;

void main() {
    lights.range = float(lights.intensity) * float(lights.color.x) + float(lights.ramp[4])
                 + float(lights.rotation[1][0]) + float(lights.tile.y) + float(lights.bias);
    lights.id = lights.address.x + uint64_t(lights.mask) + uint64_t(lights.kind);
}
