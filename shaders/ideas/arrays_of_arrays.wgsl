// The outer array is written outside: two arrays of three. An array of vec3f keeps the
// fourth word of each element unused, and what follows does not move in there.

struct GridBlock {
    a: array<array<f32, 3>, 2>,    // offset 0, stride 12
    b: array<array<vec2f, 2>, 4>,  // offset 24, stride 16
    c: array<vec3f, 2>,            // offset 96, stride 16
    tail: f32,                     // offset 128
}

@group(0) @binding(0) var<storage, read> grid: GridBlock;

@fragment
fn fragment_main(@location(0) @interpolate(flat) cell: u32) -> @location(0) vec4f {
    let a = grid.a[cell & 1u][cell % 3u];
    let b = grid.b[cell & 3u][cell & 1u];
    return vec4f(b * a, grid.c[cell & 1u].xy) * grid.tail;
}
