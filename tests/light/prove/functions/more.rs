//! The second part: maps, colours, rotations, integers.

use super::{Known, known};

pub const MAPS: &[Known] = &[
    known(
        "variance of a shadow map by its moments",
        r#"{"m": [0, 1], "m2": [0, 1]}"#,
        "float f(float m, float m2) {
    return sqrt(m2 - m * m); // root of a negative number
}",
        "float f(float m, float m2) {
    return sqrt(max(m2 - m * m, 0.00001));
}",
    ),
    known(
        "Chebyshev's bound without a least variance",
        r#"{"m": [0, 1], "m2": [0, 1], "t": [0, 1]}"#,
        "float f(float m, float m2, float t) {
    float variance = m2 - m * m;
    float d = t - m;
    return variance / (variance + d * d); // division by zero
}",
        "float f(float m, float m2, float t) {
    float variance = max(m2 - m * m, 0.00002);
    float d = t - m;
    return variance / (variance + d * d);
}",
    ),
    known(
        "octahedral encoding of nothing",
        r#"{"n": [-1, 1]}"#,
        "vec2 f(vec3 n) {
    return n.xy / (abs(n.x) + abs(n.y) + abs(n.z)); // division by zero
}",
        "vec2 f(vec3 n) {
    return n.xy / max(abs(n.x) + abs(n.y) + abs(n.z), 0.001);
}",
    ),
    known(
        "the third component of a normal map",
        r#"{"n": [-1, 1]}"#,
        "float f(vec2 n) {
    return sqrt(1.0 - dot(n, n)); // root of a negative number
}",
        "float f(vec2 n) {
    return sqrt(max(1.0 - dot(n, n), 0.0));
}",
    ),
    known(
        "sRGB of a negative colour",
        r#"{"c": [-0.1, 1]}"#,
        "vec3 f(vec3 c) {
    return 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055; // power of a negative number
}",
        "vec3 f(vec3 c) {
    return 1.055 * pow(max(c, vec3(0.0031308)), vec3(1.0 / 2.4));
}",
    ),
    known(
        "refraction past the critical angle",
        r#"{"c": [0, 1], "eta": [0.5, 2]}"#,
        "float f(float c, float eta) {
    float k = 1.0 - eta * eta * (1.0 - c * c);
    return eta * c + sqrt(k); // root of a negative number
}",
        "float f(float c, float eta) {
    float k = 1.0 - eta * eta * (1.0 - c * c);
    if (k < 0.0) return 0.0;
    return eta * c + sqrt(k);
}",
    ),
    known(
        "slerp between equal rotations",
        r#"{"a": [0, 3], "t": [0, 1]}"#,
        "float f(float a, float t) {
    return sin(a * t) / sin(a); // division by zero
}",
        "float f(float a, float t) {
    float s = sin(a);
    return s < 0.01 ? t : sin(a * t) / s;
}",
    ),
    known(
        "the angle between unit vectors",
        r#"{"a": "unit", "b": "unit"}"#,
        "float f(vec3 a, vec3 b) {
    return acos(dot(a, b)); // inverse of a trigonometric function out of range
}",
        "float f(vec3 a, vec3 b) {
    return acos(clamp(dot(a, b), -1.0, 1.0));
}",
    ),
    known(
        "barycentric coordinates of a degenerate triangle",
        r#"{"a": [-1, 1], "b": [-1, 1]}"#,
        "float f(vec2 a, vec2 b) {
    return 1.0 / (a.x * b.y - a.y * b.x); // division by zero
}",
        "float f(vec2 a, vec2 b) {
    float area = a.x * b.y - a.y * b.x;
    return area / (area * area + 0.0001);
}",
    ),
    known(
        "an orthonormal basis at the south pole",
        r#"{"n": "unit"}"#,
        "float f(vec3 n) {
    float a = 1.0 / (1.0 + n.z); // division by zero
    return 1.0 - n.x * n.x * a;
}",
        "float f(vec3 n) {
    float s = n.z < 0.0 ? -1.0 : 1.0;
    float a = -1.0 / (s + n.z);
    return 1.0 + s * n.x * n.x * a;
}",
    ),
    known(
        "a tangent along the up vector",
        r#"{"n": "unit"}"#,
        "vec3 f(vec3 n) {
    return normalize(cross(n, vec3(0.0, 1.0, 0.0))); // normalised zero vector
}",
        "vec3 f(vec3 n) {
    vec3 t = vec3(n.z, 0.0, -n.x);
    return t / max(length(t), 0.001);
}",
    ),
    known(
        "longitude at a pole",
        r#"{"d": "unit"}"#,
        "float f(vec3 d) {
    return atan(d.z, d.x); // angle of the point (0, 0)
}",
        "float f(vec3 d) {
    return atan(d.z / (abs(d.x) + 0.001));
}",
    ),
    known(
        "the logarithm of a luminance",
        r#"{"c": "color"}"#,
        "float f(vec3 c) {
    return log(dot(c, vec3(0.2126, 0.7152, 0.0722))); // logarithm of zero or less
}",
        "float f(vec3 c) {
    return log(dot(c, vec3(0.2126, 0.7152, 0.0722)) + 0.0001);
}",
    ),
    known(
        "a spot light whose cones coincide",
        r#"{"c": "cos", "inner": [0.5, 1], "outer": [0.5, 1]}"#,
        "float f(float c, float inner, float outer) {
    return smoothstep(outer, inner, c); // smoothstep with its first edge not below its second
}",
        "float f(float c, float inner, float outer) {
    float low = min(inner, outer) - 0.001;
    return smoothstep(low, low + 0.002 + abs(inner - outer), c);
}",
    ),
    known(
        "a table past its end",
        r#"{"i": [0, 8]}"#,
        "float f(int i) {
    float w[8] = float[8](1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0);
    return w[i]; // index out of bounds
}",
        "float f(int i) {
    float w[8] = float[8](1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0);
    return w[min(i, 7)];
}",
    ),
    known(
        "an integer modulus by a count",
        r#"{"i": [0, 100], "n": [0, 16]}"#,
        "int f(int i, int n) {
    return i % n; // integer division by zero
}",
        "int f(int i, int n) {
    return i % max(n, 1);
}",
    ),
    known(
        "an integer modulus of a negative cell",
        r#"{"i": [-100, 100]}"#,
        "int f(int i) {
    return i % 16; // remainder of a negative integer
}",
        "int f(int i) {
    return i & 15;
}",
    ),
    known(
        "a cell of a grid of large numbers",
        r#"{"x": [0, 10000000000]}"#,
        "int f(float x) {
    return int(x * 0.5); // conversion of a number out of range
}",
        "int f(float x) {
    return int(min(x * 0.5, 1000000.0));
}",
    ),
    known(
        "a half of a bright light",
        r#"{"x": [0, 1000000]}"#,
        "uint f(float x) {
    return packHalf2x16(vec2(x, 1.0)); // conversion of a number out of range
}",
        "uint f(float x) {
    return packHalf2x16(vec2(min(x, 65000.0), 1.0));
}",
    ),
    known(
        "exponential fog of far things",
        r#"{"d": [0, 1000]}"#,
        "float f(float d) {
    return exp(d * 0.5); // overflow
}",
        "float f(float d) {
    return exp(-d * 0.5);
}",
    ),
    known(
        "a reciprocal root of a length",
        r#"{"v": [-1, 1]}"#,
        "vec3 f(vec3 v) {
    return v * inversesqrt(dot(v, v)); // root of a negative number
}",
        "vec3 f(vec3 v) {
    return v * inversesqrt(dot(v, v) + 0.0001);
}",
    ),
];
