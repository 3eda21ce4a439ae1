#version 430 core
// `float a[2][3]` is two arrays of three floats: the outer stride is 48, the inner 16.
// The dimensions may also stand on the type, and then they come first.

layout(std140) uniform GridBlock {
    float a[2][3];   // offset 0, stride 48
    float[2] b[4];   // offset 96, stride 32: four arrays of two
    vec4[2][2] c;    // offset 224, stride 32
    float tail;      // offset 288
};

flat in int cell;
out vec4 color;

void main() {
    color = c[cell & 1][cell >> 1 & 1] * (a[cell & 1][cell % 3] + b[cell & 3][cell & 1] + tail);
}
