#version 450 core
// Numbers in comments, each wrong in one place. `good.frag` is this file with the digits put right.

// LightSource: 44 bytes
struct LightSource { // 44 bytes
    vec3 position;   // 位置 alignment:16 offset:0
    vec3 tint;       // 颜色 alignment:12 offset:16
    float strength;  // 强度 alignment:4 offset:24
    float falloff[2]; // 对齐: 4, 偏移量 32, 大小：8字节
    // total: 48 bytes
}; // total 48 bytes，总大小: 48 字节

layout(std140) uniform LightSourceBlock {
    LightSource sources[8]; // array stride = 48, takes 384 bytes
    mat3 spin;              /* @ 0x180, size 36 bytes, matrix stride 12 */
    int used;               // offset 0x1A4
} u_sources; // 448 bytes in all

layout(std140) uniform Table {
                    // base alignment  // aligned offset
    float first;    // 4               // 0
    vec3 second;    // 12              // 16  (not 4)
    mat4 third;     // 16              // 28  (column 0)
                    // 16              // 48  (column 1)
                    // 16              // 60  (column 2)
                    // 16              // 80  (column 3)
    float fourth[3]; // 4             // 96
    bool fifth;     // 4               // 108
} u_table;

layout(std430) buffer Ranges {
    vec4 plane;    // 0 - 16
    vec3 centre;   // 16 - 28
    vec2 extent;   // 28 - 36
} b_ranges;

layout(std430) buffer Column {
    vec4 plane;    // 0
    vec3 centre;   // 16
    float radius;  // 28
    vec2 extent;   // 32
    uvec3 cell;    // 40
} b_column;

layout(std430) buffer Bytes {
    vec4 plane;    // bytes of the plane: offsets 0-15
    vec3 centre;   // offsets 16-27
    uvec3 cell;    // offsets 28-39
    // stride 12
    vec3 path[];   // offset 40
} b_bytes;

layout(location = 0) out vec4 shade;

void main() {
    shade = vec4(u_sources.sources[0].tint, u_table.first);
}
