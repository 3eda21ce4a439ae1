#version 450
// Qualifiers of access on blocks and members. None of them moves a byte.

layout(local_size_x = 64) in;

layout(std430, set = 0, binding = 0) coherent restrict buffer TileBuffer {
    readonly uint width;       // offset 0
    uint visible;              // offset 4
    volatile uint generation;  // offset 8
    writeonly vec4 bounds;     // offset 16
    readonly vec2 depths[];    // offset 32, stride 8
} tiles;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < tiles.width && tiles.depths[i].x < tiles.depths[i].y) {
        atomicAdd(tiles.visible, 1u);
    }
    if (i == 0u) {
        tiles.bounds = vec4(float(tiles.generation));
    }
}
