// One struct in both address spaces has one layout: WGSL has no second set of rules.
// What changes is what is allowed: in a uniform block array strides and nested structs
// must be multiples of 16, which the wrapper below arranges for.

struct Wide {
    @size(16) value: f32, // offset 0
}

struct Ramp {
    steps: array<Wide, 4>, // offset 0, stride 16
    scale: f32,            // offset 64
}

struct TightRamp {
    steps: array<f32, 4>,  // offset 0, stride 4
    scale: f32,            // offset 16
}

@group(0) @binding(0) var<uniform> uploaded: Ramp;
@group(0) @binding(1) var<storage, read_write> kept: Ramp;
@group(0) @binding(2) var<storage, read_write> tight: TightRamp;

@compute @workgroup_size(4)
fn compute_main(@builtin(local_invocation_index) i: u32) {
    kept.steps[i].value = uploaded.steps[i].value * uploaded.scale;
    tight.steps[i] = kept.steps[i].value + kept.scale;
    if i == 0u {
        tight.scale = kept.scale;
    }
}
