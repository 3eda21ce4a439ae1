// Array sizes from constant expressions.

const CASCADES = 4u;
const PER_CASCADE: u32 = 1u << 1u;
const SLOTS = max(CASCADES, 3u) * PER_CASCADE + 1u;

struct SizeBlock {
    a: array<vec4f, CASCADES>,                 // offset 0, stride 16
    b: array<vec4f, CASCADES * PER_CASCADE>,   // offset 64, stride 16
    c: array<vec4f, SLOTS>,                    // offset 192, stride 16
    d: array<vec4f, (SLOTS - 1u) / 4u>,        // offset 336, stride 16
    tail: f32,                                 // offset 368
}

@group(0) @binding(0) var<uniform> sizes: SizeBlock;

@fragment
fn fragment_main() -> @location(0) vec4f {
    return (sizes.a[3] + sizes.b[7] + sizes.c[8] + sizes.d[1]) * sizes.tail;
}
