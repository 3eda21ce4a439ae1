#ifndef SUMS
#define SUMS
    #  include "values.glsl"
layout(set = 0, binding = 2, std430) buffer Sums { uint count; vec3 total; } sums;
	layout(set = 0, binding = 3, rgba8) uniform writeonly image2D trail;

float scaled(float value, uint count) {
    return SCALE * value \
        * float(count); // "quoted" \ é
}
#endif
