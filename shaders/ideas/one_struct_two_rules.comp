#version 450
// One struct, two layouts: the same members lie elsewhere in the std140 block than
// in the std430 one, so neither buffer can be copied into the other.

layout(local_size_x = 1) in;

struct Falloff {
    float constant;
    float ramp[2];
};

struct Light {
    vec3 position;
    Falloff falloff; // std140: 16, 48 bytes; std430: 12, 12 bytes
    float intensity; // std140: 64; std430: 24
};

layout(std140, set = 0, binding = 0) uniform UploadBlock {
    Light lights[4]; // stride 80
    uint count;      // offset 320
} upload;

layout(std430, set = 0, binding = 1) buffer StoreBlock {
    uint count;      // offset 0
    Light lights[];  // offset 16, stride 32
} store;

void main() {
    uint n = min(upload.count, 4u);
    for (uint i = 0u; i < n; i++) {
        store.lights[i].position = upload.lights[i].position;
        store.lights[i].falloff.constant = upload.lights[i].falloff.constant;
        store.lights[i].falloff.ramp[1] = upload.lights[i].falloff.ramp[1];
        store.lights[i].intensity = upload.lights[i].intensity;
    }
    store.count = n;
}
