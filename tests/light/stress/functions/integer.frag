#version 450

// bucket | {"x": [-4, 4]} | index-out-of-bounds | w[int(mod(x, 1.0) * 8.0)]
float bucket_bad(float x) {
    float w[8] = float[8](0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0);
    return w[int(mod(x, 1.0) * 8.0)];
}
float bucket_ok(float x) {
    float w[8] = float[8](0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0);
    return w[clamp(int(mod(x, 1.0) * 8.0), 0, 7)];
}

// stratum | {"u": [0, 1]} | index-out-of-bounds | w[int(u * 8.0)]
float stratum_bad(float u) {
    float w[8] = float[8](0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0);
    return w[int(u * 8.0)];
}
float stratum_ok(float u) {
    float w[8] = float[8](0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0);
    return w[min(int(u * 8.0), 7)];
}

// lattice | {"i": [-16, 16]} | negative-remainder | w[i % 8]
float lattice_bad(int i) {
    float w[8] = float[8](0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0);
    return w[i % 8];
}
float lattice_ok(int i) {
    float w[8] = float[8](0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0);
    return w[i & 7];
}

// wrap | {"i": [-8, 8], "n": [1, 5]} | negative-remainder | i % n
int wrap_bad(int i, int n) { return i % n; }
int wrap_ok(int i, int n) { return (i + 40) % n; }

// share | {"i": [0, 9], "n": [0, 8]} | division-by-zero | i / n
int share_bad(int i, int n) { return i / n; }
int share_ok(int i, int n) { return i / max(n, 1); }

// mask | {"s": [0, 40]} | undefined-operation | 1 << s
int mask_bad(int s) { return 1 << s; }
int mask_ok(int s) { return 1 << (s & 31); }

// rotate | {"x": [0, 4096], "s": [0, 31]} | undefined-operation | x >> (32u - s)
uint rotate_bad(uint x, uint s) { return (x << s) | (x >> (32u - s)); }
uint rotate_ok(uint x, uint s) { return (x << s) | (x >> ((32u - s) & 31u)); }

// field | {"v": [0, 4096], "o": [0, 31], "n": [1, 32]} | undefined-operation | bitfieldExtract(v, o, n)
uint field_bad(uint v, int o, int n) { return bitfieldExtract(v, o, n); }
uint field_ok(uint v, int o, int n) { return bitfieldExtract(v, o, min(n, 32 - o)); }

// last | {"n": [0, 8]} | index-out-of-bounds | w[n - 1]
float last_bad(int n) {
    float w[8] = float[8](0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0);
    return w[n - 1];
}
float last_ok(int n) {
    float w[8] = float[8](0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0);
    return w[max(n - 1, 0)];
}

// cell | {"x": [0, 1]} | undefined-operation | int(x * 4.0e9)
int cell_bad(float x) { return int(x * 4.0e9); }
int cell_ok(float x) { return int(x * 2.0e9); }

// frame | {"t": [-2, 2]} | negative-remainder | w[int(t * 24.0) % 8]
float frame_bad(float t) {
    float w[8] = float[8](0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0);
    return w[int(t * 24.0) % 8];
}
float frame_ok(float t) {
    float w[8] = float[8](0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0);
    return w[int(t * 24.0) & 7];
}

void main() {}
