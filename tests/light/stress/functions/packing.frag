#version 450

// byte | {"x": [-1, 2]} | undefined-operation | uint(x * 255.0)
uint byte_bad(float x) { return uint(x * 255.0); }
uint byte_ok(float x) { return uint(clamp(x, 0.0, 1.0) * 255.0); }

// octahedron | {"n": [-1, 1]} | division-by-zero | n.xy / (abs(n.x) + abs(n.y) + abs(n.z))
vec2 octahedron_bad(vec3 n) { return n.xy / (abs(n.x) + abs(n.y) + abs(n.z)); }
vec2 octahedron_ok(vec3 n) { return n.xy / max(abs(n.x) + abs(n.y) + abs(n.z), 1.0e-4); }

// pair | {"x": [0, 100000]} | undefined-operation | packHalf2x16(vec2(x, 0.0))
uint pair_bad(float x) { return packHalf2x16(vec2(x, 0.0)); }
uint pair_ok(float x) { return packHalf2x16(vec2(min(x, 65504.0), 0.0)); }

// third | {"p": [-1, 1]} | undefined-operation | sqrt(1.0 - p.x * p.x - p.y * p.y)
float third_bad(vec2 p) { return sqrt(1.0 - p.x * p.x - p.y * p.y); }
float third_ok(vec2 p) {
    float q = 1.0 - p.x * p.x - p.y * p.y;
    if (q < 0.0) { return 0.0; }
    return sqrt(q);
}

// exponent | {"c": [0, 1]} | undefined-operation | log2(max(c.r, max(c.g, c.b)))
float exponent_bad(vec3 c) { return ceil(log2(max(c.r, max(c.g, c.b)))); }
float exponent_ok(vec3 c) { return ceil(log2(max(max(c.r, max(c.g, c.b)), 1.0e-6))); }

// linear_depth | {"d": [0, 1], "n": [0.01, 0.01], "f": [10000, 10000]} | cancellation | f - d * (f - n)
float linear_depth_bad(float d, float n, float f) { return n * f / (f - d * (f - n)); }
float linear_depth_ok(float d, float n, float f) { return n * f / (f * (1.0 - d) + n * d); }

// infinite_depth | {"d": [0, 1], "n": [0.1, 1]} | division-by-zero | n / d
float infinite_depth_bad(float d, float n) { return n / d; }
float infinite_depth_ok(float d, float n) { return n / max(d, 1.0e-4); }

// slice | {"z": [1, 2], "n": [1, 2], "f": [1, 2]} | division-by-zero | log(z / n) / log(f / n)
float slice_bad(float z, float n, float f) { return log(z / n) / log(f / n); }
float slice_ok(float z, float n, float f) { return log(z / n) / max(log(f / n), 1.0e-2); }

// project | {"p": [-1, 1]} | division-by-zero | p.xyz / p.w
vec3 project_bad(vec4 p) { return p.xyz / p.w; }
vec3 project_ok(vec4 p) { return p.xyz / max(abs(p.w), 1.0e-2); }

void main() {}
