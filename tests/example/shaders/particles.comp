#version 450
layout(local_size_x = 64) in;

struct Particle {
    vec3 position;
    float age;
    vec3 velocity;
    uint flags;
};

layout(std430, set = 1, binding = 0) buffer Particles {
    uint alive;
    Particle particles[];
};

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < alive) {
        particles[i].age += 1.0;
    }
}
