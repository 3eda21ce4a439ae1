// An override may size an array in workgroup memory, which no buffer holds. In a
// uniform or storage block the sizes have to be constants, so the block has one layout.

override TILE: u32 = 64u;
override EXPOSURE: f32 = 1.0;

struct TileBlock {
    lights: array<vec4f, 16>,  // offset 0, stride 16
    count: u32,                // offset 256
}

@group(0) @binding(0) var<uniform> tiles: TileBlock;
@group(0) @binding(1) var<storage, read_write> result: array<f32>;

var<workgroup> shadow: array<f32, TILE>;

@compute @workgroup_size(TILE)
fn compute_main(@builtin(local_invocation_index) local: u32, @builtin(global_invocation_id) at: vec3u) {
    let light = tiles.lights[local % 16u];
    shadow[local] = select(0.0, light.w, local < tiles.count);
    workgroupBarrier();
    if at.x < arrayLength(&result) {
        result[at.x] = EXPOSURE * (shadow[local] + shadow[TILE - 1u - local]);
    }
}
