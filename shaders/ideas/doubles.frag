#version 400 core
// Doubles are 8 bytes, dvec2 aligns to 16, dvec3 and dvec4 to 32. Positions of a
// large world need them; a light's distance to the camera no longer does.

layout(std140) uniform WorldBlock {
    dvec3 cameraOrigin; // offset 0
    double metre;       // offset 24
    float exposure;     // offset 32
    dvec2 tile;         // offset 48
    dmat3 toCell;       // offset 64, matrix stride 32
    dvec3 lights[2];    // offset 160, stride 32
    float gamma;        // offset 224
} world;

out vec4 color;

void main() {
    dvec3 relative = world.toCell * (world.lights[0] - world.cameraOrigin) * world.metre
                   + world.lights[1] * world.tile.x;
    float d = length(vec3(relative));
    color = vec4(vec3(pow(world.exposure / max(d, 1.0e-6), world.gamma)), 1.0);
}
