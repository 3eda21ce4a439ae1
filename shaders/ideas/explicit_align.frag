#version 450
// layout(align = N) raises the alignment of one member, or of every member when it
// stands on the block. It never lowers one.

layout(std140, set = 0, binding = 0) uniform TileBlock {
    float exposure;               // offset 0
    layout(align = 64) vec4 tile; // offset 64
    float gamma;                  // offset 80
    layout(align = 32) float bias; // offset 96
} tiles;

layout(std140, set = 0, binding = 1, align = 32) uniform SlotBlock {
    float first;  // offset 0
    float second; // offset 32
    vec3 third;   // offset 64
} slots;

layout(location = 0) out vec4 color;

void main() {
    color = tiles.tile * tiles.exposure + vec4(slots.third, tiles.gamma + tiles.bias);
    color.a += slots.first + slots.second;
}
