//! The third part: colours, rotations, fog, lobes, words.

use super::{Known, known};

pub const COLOURS: &[Known] = &[
    known(
        "the logarithm of a quaternion that does not rotate",
        r#"{"q": "unit"}"#,
        "vec3 f(vec4 q) {
    return q.xyz * (acos(clamp(q.w, -1.0, 1.0)) / length(q.xyz)); // division by zero
}",
        "vec3 f(vec4 q) {
    float s = length(q.xyz);
    float angle = s < 0.001 ? 1.0 : atan(s, q.w) / s;
    return q.xyz * angle;
}",
    ),
    known(
        "the weights of slerp from the cosine of its angle",
        r#"{"c": [-1, 1], "t": [0, 1]}"#,
        "float f(float c, float t) {
    float angle = acos(c);
    return sin(angle * t) / sqrt(1.0 - c * c); // division by zero
}",
        "float f(float c, float t) {
    float d = clamp(c, -0.99, 0.99);
    return sin(acos(d) * t) / sqrt(1.0 - d * d);
}",
    ),
    known(
        "linear light of a negative sRGB value",
        r#"{"c": [-0.1, 1]}"#,
        "float f(float c) {
    return pow((c + 0.055) / 1.055, 2.4); // power of a negative number
}",
        "float f(float c) {
    return c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4);
}",
    ),
    known(
        "Fresnel's ratio at grazing angles",
        r#"{"c": [0, 1], "ct": [0, 1], "n": [1, 3]}"#,
        "float f(float c, float ct, float n) {
    return (n * c - ct) / (n * c + ct); // division by zero
}",
        "float f(float c, float ct, float n) {
    return (n * c - ct) / max(n * c + ct, 0.0001);
}",
    ),
    known(
        "the refractive index of a perfect mirror",
        r#"{"f0": [0, 1]}"#,
        "float f(float f0) {
    return (1.0 + sqrt(f0)) / (1.0 - sqrt(f0)); // division by zero
}",
        "float f(float f0) {
    float r = sqrt(min(f0, 0.98));
    return (1.0 + r) / (1.0 - r);
}",
    ),
    known(
        "Beckmann's distribution of a mirror",
        r#"{"c": [0.1, 1], "m": [0, 1]}"#,
        "float f(float c, float m) {
    float k = c * c * m * m;
    return exp((c * c - 1.0) / k); // division by zero
}",
        "float f(float c, float m) {
    float k = c * c * max(m * m, 0.01);
    return exp((c * c - 1.0) / k);
}",
    ),
    known(
        "anisotropic GGX of a brushed mirror",
        r#"{"h": "unit", "ax": [0, 1], "ay": [0, 1]}"#,
        "float f(vec3 h, float ax, float ay) {
    float x = h.x / ax; // division by zero
    float y = h.y / ay; // division by zero
    return x * x + y * y + h.z * h.z;
}",
        "float f(vec3 h, float ax, float ay) {
    float x = h.x / max(ax, 0.01);
    float y = h.y / max(ay, 0.01);
    return x * x + y * y + h.z * h.z;
}",
    ),
    known(
        "Oren and Nayar's quotient at grazing angles",
        r#"{"nol": [0, 1], "nov": [0, 1], "s": [0, 1]}"#,
        "float f(float nol, float nov, float s) {
    return s / max(nol, nov); // division by zero
}",
        "float f(float nol, float nov, float s) {
    return s / max(max(nol, nov), 0.001);
}",
    ),
    known(
        "the normal of a triangle without area",
        r#"{"a": [-1, 1], "b": [-1, 1]}"#,
        "vec3 f(vec3 a, vec3 b) {
    return normalize(cross(a, b)); // normalised zero vector
}",
        "vec3 f(vec3 a, vec3 b) {
    vec3 n = cross(a, b);
    return n / (length(n) + 0.0001);
}",
    ),
    known(
        "a tangent along the normal",
        r#"{"n": "unit", "t": "unit"}"#,
        "vec3 f(vec3 n, vec3 t) {
    return normalize(t - n * dot(n, t)); // normalised zero vector
}",
        "vec3 f(vec3 n, vec3 t) {
    vec3 d = t - n * dot(n, t);
    return d / (length(d) + 0.001);
}",
    ),
    known(
        "the ramp of a spot light whose cones coincide",
        r#"{"c": "cos", "inner": [0.5, 1], "outer": [0.5, 1]}"#,
        "float f(float c, float inner, float outer) {
    return clamp((c - outer) / (inner - outer), 0.0, 1.0); // division by zero
}",
        "float f(float c, float inner, float outer) {
    float width = max(abs(inner - outer), 0.00001);
    return clamp((c - outer) / width, 0.0, 1.0);
}",
    ),
    known(
        "height fog along the horizon",
        r#"{"h": [-1, 1], "d": [0, 10]}"#,
        "float f(float h, float d) {
    return (1.0 - exp(-h * d)) / h; // division by zero
}",
        "float f(float h, float d) {
    float x = h * d;
    if (abs(x) < 0.1) return d * (1.0 - x * (0.5 - x * (1.0 / 6.0 - x / 24.0)));
    return (1.0 - exp(-x)) / h;
}",
    ),
    known(
        "logarithmic depth behind the camera",
        r#"{"z": [-1, 100]}"#,
        "float f(float z) {
    return log2(z + 1.0); // logarithm of zero or less
}",
        "float f(float z) {
    return log2(max(z, 0.0) + 1.0);
}",
    ),
    known(
        "a tone curve by the ratio of luminances",
        r#"{"c": "color"}"#,
        "vec3 f(vec3 c) {
    float l = dot(c, vec3(0.2126, 0.7152, 0.0722));
    return c * ((l / (1.0 + l)) / l); // division by zero
}",
        "vec3 f(vec3 c) {
    float l = dot(c, vec3(0.2126, 0.7152, 0.0722));
    return c / (1.0 + max(l, 0.0));
}",
    ),
    known(
        "the saturation of black",
        r#"{"c": "color"}"#,
        "float f(vec3 c) {
    float most = max(c.r, max(c.g, c.b));
    float least = min(c.r, min(c.g, c.b));
    return (most - least) / most; // division by zero
}",
        "float f(vec3 c) {
    float most = max(c.r, max(c.g, c.b));
    float least = min(c.r, min(c.g, c.b));
    return (most - least) / max(most, 0.0001);
}",
    ),
    known(
        "the hue of grey",
        r#"{"c": "color"}"#,
        "float f(vec3 c) {
    return atan(1.7320508 * (c.g - c.b), 2.0 * c.r - c.g - c.b); // angle of the point (0, 0)
}",
        "float f(vec3 c) {
    float y = 1.7320508 * (c.g - c.b);
    return atan(y / (abs(2.0 * c.r - c.g - c.b) + 0.001));
}",
    ),
    known(
        "the latitude of a direction that is not normalised",
        r#"{"d": [-1.5, 1.5]}"#,
        "float f(vec3 d) {
    return asin(d.y); // inverse of a trigonometric function out of range
}",
        "float f(vec3 d) {
    return asin(clamp(d.y, -1.0, 1.0));
}",
    ),
    known(
        "the angle of a sphere from inside",
        r#"{"r": [0, 2], "d": [1, 10]}"#,
        "float f(float r, float d) {
    return asin(r / d); // inverse of a trigonometric function out of range
}",
        "float f(float r, float d) {
    return asin(min(r / d, 1.0));
}",
    ),
    known(
        "the colour of a transparent texel",
        r#"{"c": [0, 1]}"#,
        "vec3 f(vec4 c) {
    return c.rgb / c.a; // division by zero
}",
        "vec3 f(vec4 c) {
    return c.a > 0.0001 ? c.rgb / c.a : vec3(0.0);
}",
    ),
    known(
        "a clamp between a near plane beyond the far one",
        r#"{"x": [0, 1], "near": [0, 1], "far": [0, 1]}"#,
        "float f(float x, float near, float far) {
    return clamp(x, near, far); // clamp with its lower bound above its upper one
}",
        "float f(float x, float near, float far) {
    return clamp(x, min(near, far), max(near, far));
}",
    ),
    known(
        "a mask of all bits",
        r#"{"n": [0, 32]}"#,
        "int f(int n) {
    return (1 << n) - 1; // shift by the width or more
}",
        "int f(int n) {
    return n > 31 ? -1 : (1 << min(n, 31)) - 1;
}",
    ),
    known(
        "the root of one more and the root",
        r#"{"x": [1, 1000000]}"#,
        "float f(float x) {
    return sqrt(x + 1.0) - sqrt(x); // subtraction of nearly equal numbers
}",
        "float f(float x) {
    return 1.0 / (sqrt(x + 1.0) + sqrt(x));
}",
    ),
    known(
        "the tangent of half an angle",
        r#"{"x": [0.00001, 1]}"#,
        "float f(float x) {
    return (1.0 - cos(x)) / sin(x); // subtraction of nearly equal numbers
}",
        "float f(float x) {
    return sin(0.5 * x) / cos(0.5 * x);
}",
    ),
    known(
        "a step into an unsigned cell",
        r#"{"x": [-10, 10]}"#,
        "uint f(float x) {
    return uint(x); // conversion of a number out of range
}",
        "uint f(float x) {
    return uint(max(x, 0.0));
}",
    ),
];
