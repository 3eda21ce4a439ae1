#ifndef VALUES
#define VALUES
#define SCALE 2.0
layout(set = 0, binding = 0, std430) readonly buffer Values { float values[]; } all;
#endif // VALUES