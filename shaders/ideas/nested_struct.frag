#version 330 core
// In std140 a struct starts at a multiple of 16 and takes a multiple of 16, even
// when all it holds is one float. What follows it starts behind that padding.

struct Attenuation {
    float constant; // offset 0
};

struct Lamp {
    float intensity; // offset 0
    Attenuation att; // offset 16
    float cutoff;    // offset 32; 48 bytes in all
};

layout(std140) uniform LampBlock {
    float exposure;        // offset 0
    Attenuation ambient;   // offset 16
    float gamma;           // offset 32
    Lamp lamps[2];         // offset 48, stride 48
    float last;            // offset 144
};

out vec4 color;

void main() {
    float sum = ambient.constant;
    for (int i = 0; i < 2; i++) {
        sum += lamps[i].intensity * lamps[i].cutoff / max(lamps[i].att.constant, 1.0e-6);
    }
    color = vec4(vec3(pow(max(sum * exposure + last, 0.0), gamma)), 1.0);
}
