#version 450
// Ambient light counted once a light or once, and 1,024 contributions summed in
// order, in blocks, and compensated.

layout(location = 0) out vec4 color;

float ambient_each(float ambient, int lights) {
    float sum = 0.0;
    for (int i = 0; i < lights; i++) {
        sum += ambient;
    }
    return sum;
}

float ambient_once(float ambient, int lights) {
    return lights > 0 ? ambient : 0.0;
}

// One bright light, 1,023 dim ones.
float contribution(int i, float bright, float dim) {
    return i == 0 ? bright : dim;
}

float in_order(float bright, float dim) {
    float sum = 0.0;
    for (int i = 0; i < 1024; i++) {
        sum += contribution(i, bright, dim);
    }
    return sum;
}

float in_blocks(float bright, float dim) {
    float sum = 0.0;
    for (int block = 0; block < 32; block++) {
        float part = 0.0;
        for (int i = 0; i < 32; i++) {
            part += contribution(32 * block + i, bright, dim);
        }
        sum += part;
    }
    return sum;
}

// `precise` keeps a compiler from cancelling what is compensated.
float compensated(float bright, float dim) {
    precise float sum = 0.0;
    precise float lost = 0.0;
    for (int i = 0; i < 1024; i++) {
        precise float next = contribution(i, bright, dim) - lost;
        precise float total = sum + next;
        lost = (total - sum) - next;
        sum = total;
    }
    return sum;
}

void main() {
    color = vec4(ambient_each(0.1, 2), in_order(1.0, 0.5) + ambient_once(0.1, 2), in_blocks(1.0, 0.5), compensated(1.0, 0.5));
}
