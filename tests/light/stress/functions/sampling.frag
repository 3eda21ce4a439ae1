#version 450

// disc | {"u": [0, 1.1]} | undefined-operation | sqrt(1.0 - u)
float disc_bad(float u) { return sqrt(1.0 - u); }
float disc_ok(float u) { return sqrt(max(1.0 - u, 0.0)); }

// hemisphere | {"p": [-1, 1]} | undefined-operation | sqrt(1.0 - dot(p, p))
float hemisphere_bad(vec2 p) { return sqrt(1.0 - dot(p, p)); }
float hemisphere_ok(vec2 p) { return sqrt(max(1.0 - dot(p, p), 0.0)); }

// estimate | {"f": [0, 1], "density": [0, 1]} | division-by-zero | f / density
float estimate_bad(float f, float density) { return f / density; }
float estimate_ok(float f, float density) { return f / max(density, 1.0e-3); }

// gauss | {"u": [0, 1]} | undefined-operation | log(u)
float gauss_bad(float u) { return sqrt(-2.0 * log(u)); }
float gauss_ok(float u) { return sqrt(-2.0 * log(clamp(u, 1.0e-6, 0.999))); }

// ggx | {"c": [0, 1], "a": [0.001, 1]} | cancellation | (c * a2 - c) * c + 1.0
float ggx_bad(float c, float a) {
    float a2 = a * a;
    float f = (c * a2 - c) * c + 1.0;
    return a2 / (3.14159265 * f * f);
}
float ggx_ok(float c, float a) {
    float f = (1.0 - c) * (1.0 + c) + c * c * a * a;
    return a * a / (3.14159265 * f * f);
}

// polar | {"c": [-1.1, 1.1]} | undefined-operation | acos(c)
float polar_bad(float c) { return acos(c); }
float polar_ok(float c) { return acos(clamp(c, -1.0, 1.0)); }

// slerp | {"a": "unit", "b": "unit", "t": [0, 1]} | division-by-zero | / sin(w)
vec4 slerp_bad(vec4 a, vec4 b, float t) {
    float w = acos(clamp(dot(a, b), -1.0, 1.0));
    return (sin((1.0 - t) * w) * a + sin(t * w) * b) / sin(w);
}
vec4 slerp_ok(vec4 a, vec4 b, float t) {
    float c = dot(a, b);
    if (c < 0.0) { b = -b; c = -c; }
    if (c > 0.999) {
        vec4 r = mix(a, b, t);
        return r * inversesqrt(dot(r, r));
    }
    float w = acos(c);
    return (sin((1.0 - t) * w) * a + sin(t * w) * b) / sin(w);
}

// ease | {"t": [0, 1], "k": [-2, 2]} | pow-of-zero | pow(t, k)
float ease_bad(float t, float k) { return pow(t, k); }
float ease_ok(float t, float k) { return pow(max(t, 1.0e-3), k); }

// decay | {"x": [-200, 200]} | large-values | exp(-x)
float decay_bad(float x) { return exp(-x); }
float decay_ok(float x) { return exp(-max(x, 0.0)); }

// key | {"t": [0, 1], "a": [0, 1], "b": [0, 1]} | division-by-zero | (t - a) / (b - a)
float key_bad(float t, float a, float b) { return (t - a) / (b - a); }
float key_ok(float t, float a, float b) { return (t - a) / max(b - a, 1.0e-2); }

// turn | {"q": [-1, 1]} | zero-vector | normalize(q)
vec4 turn_bad(vec4 q) { return normalize(q); }
vec4 turn_ok(vec4 q) { return q * inversesqrt(max(dot(q, q), 1.0e-12)); }

// blend | {"a": "unit", "b": "unit"} | zero-vector | normalize(mix(a, b, 0.5))
vec3 blend_bad(vec3 a, vec3 b) { return normalize(mix(a, b, 0.5)); }
vec3 blend_ok(vec3 a, vec3 b) {
    vec3 m = mix(a, b, 0.5);
    return m * inversesqrt(max(dot(m, m), 1.0e-12));
}

// bounce | {"h": [-1, 1]} | undefined-operation | sqrt(19.62 * h)
float bounce_bad(float h) { return sqrt(19.62 * h); }
float bounce_ok(float h) { return sqrt(19.62 * max(h, 0.0)); }

void main() {}
