// An @align inside a struct raises the struct's own alignment, wherever it is nested.

struct Aligned {
    // landfall: allow(naga-disagrees)
    @align(16) value: u32, // offset 0; the struct is 16 bytes, aligned to 16
}

struct Outer {
    first: u32,               // offset 0
    aligned: Aligned,         // offset 16
    last: u32,                // offset 32
    pair: array<Aligned, 2>,  // offset 48, stride 16
}

@group(0) @binding(0) var<storage, read_write> outer: Outer;

@compute @workgroup_size(1)
fn compute_main() {
    outer.last = outer.first + outer.aligned.value + outer.pair[1].value;
}
