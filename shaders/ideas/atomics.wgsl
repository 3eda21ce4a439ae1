// An atomic has the size and alignment of what it wraps.

struct Histogram {
    generation: u32,                 // offset 0
    visible: atomic<u32>,            // offset 4
    bounds: vec2f,                   // offset 8
    bins: array<atomic<u32>, 8>,     // offset 16, stride 4
    closest: atomic<i32>,            // offset 48
    lights: array<vec4f>,            // offset 64, stride 16
}

@group(0) @binding(0) var<storage, read_write> histogram: Histogram;

@compute @workgroup_size(64)
fn compute_main(@builtin(global_invocation_id) at: vec3u) {
    if at.x >= arrayLength(&histogram.lights) {
        return;
    }
    let brightness = clamp(histogram.lights[at.x].w, 0.0, 1.0);
    atomicAdd(&histogram.bins[u32(brightness * 7.0)], 1u);
    atomicAdd(&histogram.visible, u32(brightness > histogram.bounds.x));
    atomicMin(&histogram.closest, i32(histogram.lights[at.x].z) + i32(histogram.generation));
}
