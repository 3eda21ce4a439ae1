#version 450

// exposure | {"c": [0, 1]} | undefined-operation | log2(dot(c, vec3(0.2126, 0.7152, 0.0722)))
float exposure_bad(vec3 c) { return log2(dot(c, vec3(0.2126, 0.7152, 0.0722))); }
float exposure_ok(vec3 c) { return log2(max(dot(c, vec3(0.2126, 0.7152, 0.0722)), 1.0e-4)); }

// encode | {"c": [-0.1, 1]} | pow-of-negative | pow(c, 0.4545)
float encode_bad(float c) { return pow(c, 0.4545); }
float encode_ok(float c) { return pow(max(c, 0.0), 0.4545); }

// hue | {"c": [0, 1]} | division-by-zero | (c.g - c.b) / (most - least)
float hue_bad(vec3 c) {
    float most = max(c.r, max(c.g, c.b));
    float least = min(c.r, min(c.g, c.b));
    return (c.g - c.b) / (most - least);
}
float hue_ok(vec3 c) {
    float most = max(c.r, max(c.g, c.b));
    float least = min(c.r, min(c.g, c.b));
    return (c.g - c.b) / max(most - least, 1.0e-4);
}

// contrast | {"x": [0, 1], "k": [0, 2]} | pow-of-zero | pow(x, k)
float contrast_bad(float x, float k) { return pow(x, k); }
float contrast_ok(float x, float k) { return pow(max(x, 1.0e-4), k); }

// glow | {"x": [0, 200]} | large-values | exp(x)
float glow_bad(float x) { return exp(x); }
float glow_ok(float x) { return exp(min(x, 80.0)); }

// threshold | {"lo": [0, 1], "hi": [0, 1], "x": [0, 1]} | undefined-operation | smoothstep(lo, hi, x)
float threshold_bad(float lo, float hi, float x) { return smoothstep(lo, hi, x); }
float threshold_ok(float lo, float hi, float x) {
    float t = clamp((x - lo) / max(hi - lo, 1.0e-2), 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

// chroma | {"c": [0, 1]} | division-by-zero | c / (c.r + c.g + c.b)
vec3 chroma_bad(vec3 c) { return c / (c.r + c.g + c.b); }
vec3 chroma_ok(vec3 c) { return c / max(c.r + c.g + c.b, 1.0e-4); }

// limit | {"x": [0, 1], "lo": [0, 1], "hi": [0, 1]} | undefined-operation | clamp(x, lo, hi)
float limit_bad(float x, float lo, float hi) { return clamp(x, lo, hi); }
float limit_ok(float x, float lo, float hi) { return clamp(x, min(lo, hi), max(lo, hi)); }

// variance | {"m": [0, 1], "q": [0, 1], "z": [0, 1]} | division-by-zero | v / (v + d * d)
float variance_bad(float m, float q, float z) {
    float v = q - m * m;
    float d = z - m;
    return v / (v + d * d);
}
float variance_ok(float m, float q, float z) {
    float v = max(q - m * m, 1.0e-2);
    float d = z - m;
    return v / (v + d * d);
}

void main() {}
