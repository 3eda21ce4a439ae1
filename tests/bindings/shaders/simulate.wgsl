// Compute shaders of one module: storage buffers and images of each access, overrides with and
// without numbers and defaults, workgroup sizes.

override BLOCK: u32 = 64;
@id(7) override speed: f32;
override steps = 4;
override is_bounded: bool = true;

const ROWS = 2 * 4;

struct Particle {
    position: vec3f,
    age: f32,
    velocity: vec3f,
}

struct Field {
    origin: vec3f,
    cells: array<vec2f>,
}

struct Tail {
    head: vec4f,
    data: array<f32>,
}

@group(0) @binding(0) var<storage, read_write> particles: array<Particle>;
@group(0) @binding(1) var<storage, read> field: Field;
@group(0) @binding(2) var<storage, read_write> counts: array<atomic<u32>, 3>;
@group(1) @binding(0) var trail: texture_storage_2d<rgba8unorm, write>;
@group(1) @binding(1) var heights: texture_storage_2d<r32float, read_write>;
@group(1) @binding(2) var<uniform> size: vec3f;
@group(1) @binding(3) var<storage> tail: Tail;

@compute @workgroup_size(BLOCK)
fn step_all(@builtin(global_invocation_id) id: vec3u) {
    for (var i = 0; i < steps; i++) {
        particles[id.x].position += particles[id.x].velocity * speed * field.origin;
    }
    if is_bounded {
        particles[id.x].age += field.cells[0].x;
    }
    atomicAdd(&counts[0], 1u);
}

@compute @workgroup_size(ROWS, 8)
fn draw(@builtin(global_invocation_id) id: vec3u) {
    let height = textureLoad(heights, id.xy).x + size.x + tail.data[0];
    textureStore(heights, id.xy, vec4f(height));
    textureStore(trail, id.xy, vec4f(height));
    touch();
}

fn touch() {
    atomicAdd(&counts[1], 1u);
}
