#version 330 core
// The compiler's own macros choose the array sizes. A tool that does not define them
// takes the other branch and sees other offsets.
// landfall: allow-file(target-changes-layout)

#if __VERSION__ >= 330
#define LIGHTS 8
#else
#define LIGHTS 4
#endif

#ifdef GL_ES
#define WEIGHTS 2
#else
#define WEIGHTS 3
#endif

#if defined(GL_core_profile) && !defined(VULKAN)
#define LAYERS 5
#else
#define LAYERS 1
#endif

layout(std140) uniform MacroBlock {
    vec4 lights[LIGHTS];    // offset 0, stride 16
    float weights[WEIGHTS]; // offset 128, stride 16
    vec4 layers[LAYERS];    // offset 176, stride 16
    float tail;             // offset 256
};

out vec4 color;

void main() {
    color = lights[LIGHTS - 1] * weights[WEIGHTS - 1] + layers[LAYERS - 1] * tail;
}
