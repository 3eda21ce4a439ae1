#version 450
// Functions with a fault, and the same mended. The line above a pair: its name | the domain of both |
// the class of the fault | the text where it is.

// angle | {"a": "unit", "b": "unit"} | undefined-operation | acos(dot(a, b))
float angle_bad(vec3 a, vec3 b) { return acos(dot(a, b)); }
float angle_ok(vec3 a, vec3 b) { return acos(clamp(dot(a, b), -1.0, 1.0)); }

// chord | {"o": [-1000, 1000], "d": "unit", "r": [0.5, 2]} | branch-divergence | h < 0.0
float chord_bad(vec3 o, vec3 d, float r) {
    float b = dot(o, d);
    float h = b * b - dot(o, o) + r * r;
    return h < 0.0 ? -1.0 : -b - sqrt(h);
}
float chord_ok(vec3 o, vec3 d, float r) {
    float b = dot(o, d);
    float h = r * r - dot(o - d * b, o - d * b);
    return h < 0.0 ? -1.0 : -b - sqrt(h);
}

// tangent | {"n": "unit", "t": "unit"} | parallel-vectors | normalize(t - n * dot(n, t))
vec3 tangent_bad(vec3 n, vec3 t) { return normalize(t - n * dot(n, t)); }
vec3 tangent_ok(vec3 n, vec3 t) {
    float s = n.z >= 0.0 ? 1.0 : -1.0;
    float a = -1.0 / (s + n.z);
    return vec3(1.0 + s * n.x * n.x * a, s * n.x * n.y * a, -s * n.x);
}

// facet | {"a": [-10, 10], "b": [-10, 10], "c": [-10, 10]} | parallel-vectors | normalize(cross(b - a, c - a))
vec3 facet_bad(vec3 a, vec3 b, vec3 c) { return normalize(cross(b - a, c - a)); }
vec3 facet_ok(vec3 a, vec3 b, vec3 c) {
    vec3 n = cross(b - a, c - a);
    float q = dot(n, n);
    return q > 1.0e-12 ? n * inversesqrt(q) : vec3(0.0, 0.0, 1.0);
}

// sphere | {"o": [-10, 10], "d": "unit", "r": [0.5, 2]} | undefined-operation | sqrt(b * b - c)
float sphere_bad(vec3 o, vec3 d, float r) {
    float b = dot(o, d);
    float c = dot(o, o) - r * r;
    return -b - sqrt(b * b - c);
}
float sphere_ok(vec3 o, vec3 d, float r) {
    float b = dot(o, d);
    vec3 q = o - b * d;
    float h = r * r - dot(q, q);
    if (h < 0.0) { return -1.0; }
    return -b - sqrt(h);
}

// plane | {"p": [-5, 5], "o": [-5, 5], "d": "unit", "n": "unit"} | division-by-zero | dot(p - o, n) / dot(d, n)
float plane_bad(vec3 p, vec3 o, vec3 d, vec3 n) { return dot(p - o, n) / dot(d, n); }
float plane_ok(vec3 p, vec3 o, vec3 d, vec3 n) {
    float by = dot(d, n);
    if (abs(by) < 1.0e-4) { return -1.0; }
    return dot(p - o, n) / by;
}

// halfway | {"a": "unit", "b": "unit"} | opposite-vectors | normalize(a + b)
vec3 halfway_bad(vec3 a, vec3 b) { return normalize(a + b); }
vec3 halfway_ok(vec3 a, vec3 b) {
    vec3 h = a + b;
    float q = dot(h, h);
    return q > 1.0e-8 ? h * inversesqrt(q) : vec3(0.0);
}

// weight | {"u": [-4, 4], "v": [-4, 4]} | division-by-zero | 1.0 / (dot(u, u) * dot(v, v)
float weight_bad(vec2 u, vec2 v) { return 1.0 / (dot(u, u) * dot(v, v) - dot(u, v) * dot(u, v)); }
float weight_ok(vec2 u, vec2 v) {
    float area = u.x * v.y - u.y * v.x;
    return 1.0 / max(area * area, 1.0e-8);
}

// azimuth | {"p": [-1, 1]} | undefined-operation | atan(p.y, p.x)
float azimuth_bad(vec2 p) { return atan(p.y, p.x); }
float azimuth_ok(vec2 p) {
    if (p.x == 0.0 && p.y == 0.0) { return 0.0; }
    return atan(p.y, p.x);
}

// cone | {"radius": [0.5, 2], "away": [0.1, 10]} | undefined-operation | asin(radius / away)
float cone_bad(float radius, float away) { return asin(radius / away); }
float cone_ok(float radius, float away) { return asin(min(radius / away, 1.0)); }

// toward | {"a": [-5, 5], "b": [-5, 5]} | zero-vector | normalize(b - a)
vec3 toward_bad(vec3 a, vec3 b) { return normalize(b - a); }
vec3 toward_ok(vec3 a, vec3 b) {
    vec3 d = b - a;
    return d * inversesqrt(max(dot(d, d), 1.0e-12));
}

// bend | {"c": [0, 1], "eta": [0.5, 1.6]} | undefined-operation | sqrt(1.0 - eta * eta * (1.0 - c * c))
float bend_bad(float c, float eta) { return sqrt(1.0 - eta * eta * (1.0 - c * c)); }
float bend_ok(float c, float eta) {
    float k = 1.0 - eta * eta * (1.0 - c) * (1.0 + c);
    if (k < 0.0) { return 0.0; }
    return sqrt(k);
}

// inverse_square | {"a": [-10, 10], "b": [-10, 10], "p": [1, 100]} | division-by-zero | p / dot(d, d)
float inverse_square_bad(vec3 a, vec3 b, float p) {
    vec3 d = a - b;
    return p / dot(d, d);
}
float inverse_square_ok(vec3 a, vec3 b, float p) {
    vec3 d = a - b;
    return p / max(dot(d, d), 1.0e-4);
}

void main() {}
