#version 450
#extension GL_EXT_nonuniform_qualifier : require

layout(local_size_x = 64) in;

// Arrays without a number of elements: the program gives it.
layout(set = 0, binding = 0) uniform texture2D many[];
layout(set = 0, binding = 1) uniform sampler linear;
layout(set = 0, binding = 2, std430) buffer Tile { vec4 color; } tiles[];

void main() {
    uint i = gl_LocalInvocationIndex;
    tiles[nonuniformEXT(i)].color =
        textureLod(sampler2D(many[nonuniformEXT(i)], linear), vec2(0.5), 0.0);
}
