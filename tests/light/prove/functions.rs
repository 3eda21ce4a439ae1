//! Functions with a known singular set, from the literature of rendering, each with a mended twin.
//!
//! A line that breaks ends in a comment with the fault; the twin has no such line.

mod colours;
mod more;

/// The functions.
pub fn all() -> impl Iterator<Item = &'static Known> {
    SURFACES.iter().chain(more::MAPS).chain(colours::COLOURS)
}

/// A function with a known singular set.
pub struct Known {
    /// The name, for messages.
    pub name: &'static str,
    /// The domain of the inputs.
    pub domain: &'static str,
    /// The function `f`, with a comment after each line that breaks.
    pub code: &'static str,
    /// The twin, also called `f`.
    pub twin: &'static str,
}

const fn known(
    name: &'static str,
    domain: &'static str,
    code: &'static str,
    twin: &'static str,
) -> Known {
    Known { name, domain, code, twin }
}

/// The first part: rays, depths, lobes.
const SURFACES: &[Known] = &[
    known(
        "ray-box slabs divide by a direction along an axis",
        r#"{"d": "unit", "o": [-10, 10]}"#,
        "float f(vec3 o, vec3 d) {
    vec3 inv = 1.0 / d; // division by zero
    vec3 near = (vec3(-1.0) - o) * inv;
    vec3 far = (vec3(1.0) - o) * inv;
    vec3 low = min(near, far);
    return max(low.x, max(low.y, low.z));
}",
        "float f(vec3 o, vec3 d) {
    vec3 size = max(abs(d), vec3(1e-12));
    vec3 inv = mix(vec3(1.0), vec3(-1.0), lessThan(d, vec3(0.0))) / size;
    vec3 near = (vec3(-1.0) - o) * inv;
    vec3 far = (vec3(1.0) - o) * inv;
    vec3 low = min(near, far);
    return max(low.x, max(low.y, low.z));
}",
    ),
    known(
        "one component of a unit direction",
        r#"{"d": "unit"}"#,
        "float f(vec3 d) {
    return 1.0 / d.x; // division by zero
}",
        "float f(vec3 d) {
    return 1.0 / (abs(d.x) + 0.001);
}",
    ),
    known(
        "two vectors that vanish together",
        r#"{"a": [-0.1, 0.1], "b": [-0.1, 0.1]}"#,
        "float f(vec3 a, vec3 b) {
    return 1.0 / (dot(a, a) + dot(b, b)); // division by zero
}",
        "float f(vec3 a, vec3 b) {
    return 1.0 / (dot(a, a) + dot(b, b) + 0.0001);
}",
    ),
    known(
        "two numbers that meet at a corner of the domain",
        r#"{"a": [0.9, 1], "b": [0.8, 0.9]}"#,
        "float f(float a, float b) {
    return 1.0 / (a - b); // division by zero
}",
        "float f(float a, float b) {
    return 1.0 / (max(a - b, 0.0) + 0.125); // a compiler may reorder a - b + 0.125
}",
    ),
    known(
        "a coincidence inside the domain",
        r#"{"near": [0.1, 10], "far": [1, 100], "z": [0, 1]}"#,
        "float f(float near, float far, float z) {
    return (z - near) / (far - near); // division by zero
}",
        "float f(float near, float far, float z) {
    return (z - near) / (abs(far - near) + 0.01);
}",
    ),
    known(
        "a zero inside the domain",
        r#"{"x": [-3, 5]}"#,
        "float f(float x) {
    return 2.0 / (x - 1.5); // division by zero
}",
        "float f(float x) {
    float d = x - 1.5;
    return 2.0 * d / (d * d + 0.001);
}",
    ),
    known(
        "linear depth divides at the far plane of an infinite projection",
        r#"{"z": [0, 1]}"#,
        "float f(float z) {
    return 0.1 / (1.0 - z); // division by zero
}",
        "float f(float z) {
    return 0.1 / (1.0 - min(z, 0.9999));
}",
    ),
    known(
        "perspective divide",
        r#"{"p": [-10, 10]}"#,
        "vec3 f(vec4 p) {
    return p.xyz / p.w; // division by zero
}",
        "vec3 f(vec4 p) {
    return p.xyz / max(p.w, 0.01);
}",
    ),
    known(
        "ray and plane that are parallel",
        r#"{"n": "unit", "d": "unit", "h": [0, 10]}"#,
        "float f(vec3 n, vec3 d, float h) {
    return h / dot(n, d); // division by zero
}",
        "float f(vec3 n, vec3 d, float h) {
    float c = dot(n, d);
    return abs(c) < 0.0001 ? 0.0 : h / c;
}",
    ),
    known(
        "ray and sphere that miss",
        r#"{"o": [-10, 10], "d": "unit"}"#,
        "float f(vec3 o, vec3 d) {
    float b = dot(o, d);
    float c = dot(o, o) - 1.0;
    return -b - sqrt(b * b - c); // root of a negative number
}",
        "float f(vec3 o, vec3 d) {
    float b = dot(o, d);
    float c = dot(o, o) - 1.0;
    float k = b * b - c;
    if (k < 0.0) return -1.0;
    return sqrt(k);
}",
    ),
    known(
        "the first root of a quadratic",
        r#"{"a": [0.5, 2], "b": [1, 1000], "c": [0.0001, 0.1]}"#,
        "float f(float a, float b, float c) {
    return (-b + sqrt(b * b - 4.0 * a * c)) / (2.0 * a); // subtraction of nearly equal numbers
}",
        "float f(float a, float b, float c) {
    float q = -0.5 * (b + sqrt(max(b * b - 4.0 * a * c, 0.0)));
    return c / q;
}",
    ),
    known(
        "the difference of a number and a root near it",
        r#"{"x": [1, 10000]}"#,
        "float f(float x) {
    return x - sqrt(x * x - 1.0); // subtraction of nearly equal numbers
}",
        "float f(float x) {
    return 1.0 / (x + sqrt(max(x - 1.0, 0.0)) * sqrt(x + 1.0));
}",
    ),
    known(
        "one minus a cosine",
        r#"{"x": [0.00001, 1]}"#,
        "float f(float x) {
    return 1.0 - cos(x); // subtraction of nearly equal numbers
}",
        "float f(float x) {
    float s = sin(0.5 * x);
    return 2.0 * s * s;
}",
    ),
    known(
        "a half vector of opposite directions",
        r#"{"l": "unit", "v": "unit"}"#,
        "vec3 f(vec3 l, vec3 v) {
    return normalize(l + v); // normalised zero vector
}",
        "vec3 f(vec3 l, vec3 v) {
    vec3 h = l + v;
    return h / (length(h) + 0.001);
}",
    ),
    known(
        "a direction to where one stands",
        r#"{"p": [-10, 10], "q": [-10, 10]}"#,
        "vec3 f(vec3 p, vec3 q) {
    return normalize(p - q); // normalised zero vector
}",
        "vec3 f(vec3 p, vec3 q) {
    vec3 d = p - q;
    return d * inversesqrt(dot(d, d) + 0.0001);
}",
    ),
    known(
        "inverse square without a floor",
        r#"{"p": [-10, 10], "q": [-10, 10]}"#,
        "float f(vec3 p, vec3 q) {
    vec3 d = p - q;
    return 1.0 / dot(d, d); // division by zero
}",
        "float f(vec3 p, vec3 q) {
    vec3 d = p - q;
    return 1.0 / max(dot(d, d), 0.0001);
}",
    ),
    known(
        "GGX of a mirror",
        r#"{"noh": [0, 1], "a": [0, 1]}"#,
        "float f(float noh, float a) {
    float a2 = a * a;
    float d = noh * noh * (a2 - 1.0) + 1.0;
    return a2 / (3.14159265 * d * d); // division by zero
}",
        "float f(float noh, float a) {
    float a2 = max(a * a, 0.001);
    float d = (1.0 - noh) * (1.0 + noh) + noh * noh * a2;
    return a2 / (3.14159265 * d * d);
}",
    ),
    known(
        "Smith's shadowing at grazing angles",
        r#"{"nov": [0, 1], "nol": [0, 1], "a": [0, 1]}"#,
        "float f(float nov, float nol, float a) {
    float k = a * 0.5;
    float v = nov / (nov * (1.0 - k) + k); // division by zero
    float l = nol / (nol * (1.0 - k) + k); // division by zero
    return v * l;
}",
        "float f(float nov, float nol, float a) {
    float k = max(a, 0.002) * 0.5;
    float v = nov / (nov * (1.0 - k) + k);
    float l = nol / (nol * (1.0 - k) + k);
    return v * l;
}",
    ),
    known(
        "Cook and Torrance's denominator",
        r#"{"nov": [0, 1], "nol": [0, 1], "d": [0, 10]}"#,
        "float f(float nov, float nol, float d) {
    return d / (4.0 * nov * nol); // division by zero
}",
        "float f(float nov, float nol, float d) {
    return d / (4.0 * nov * nol + 0.0001);
}",
    ),
    known(
        "Schlick's power of a negative",
        r#"{"h": "unit", "v": "unit"}"#,
        "float f(vec3 h, vec3 v) {
    return 0.04 + 0.96 * pow(1.0 - dot(h, v), 5.0); // power of a negative number
}",
        "float f(vec3 h, vec3 v) {
    float m = clamp(1.0 - dot(h, v), 0.0, 1.0);
    return 0.04 + 0.96 * (m * m) * (m * m) * m;
}",
    ),
    known(
        "a highlight with an exponent of zero",
        r#"{"c": [0, 1], "s": [0, 128]}"#,
        "float f(float c, float s) {
    return pow(c, s); // zero to the power of zero or less
}",
        "float f(float c, float s) {
    return pow(max(c, 0.0001), s + 1.0);
}",
    ),
    known(
        "Henyey and Greenstein's phase of light straight on",
        r#"{"c": [-1, 1], "g": [-1, 1]}"#,
        "float f(float c, float g) {
    float d = 1.0 + g * g - 2.0 * g * c;
    return (1.0 - g * g) / pow(d, 1.5); // division by zero
}",
        "float f(float c, float g) {
    float d = max(1.0 + g * g - 2.0 * g * c, 0.0001);
    return (1.0 - g * g) / (d * sqrt(d));
}",
    ),
];
