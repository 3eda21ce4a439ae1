// All nine shapes. matCxR has C columns of R rows. A column takes 8 bytes with two
// rows, 16 with three or four: other sizes than std140's where R is 2.

struct MatrixBlock {
    m22: mat2x2f, // offset 0, size 16
    m23: mat2x3f, // offset 16, size 32
    m24: mat2x4f, // offset 48, size 32
    m32: mat3x2f, // offset 80, size 24
    m33: mat3x3f, // offset 112, size 48
    m34: mat3x4f, // offset 160, size 48
    m42: mat4x2f, // offset 208, size 32
    m43: mat4x3f, // offset 240, size 64
    m44: mat4x4f, // offset 304, size 64
    tail: f32,    // offset 368
}

@group(0) @binding(0) var<uniform> c: MatrixBlock;

@fragment
fn fragment_main() -> @location(0) vec4f {
    let two = c.m22[1] + c.m32[2] + c.m42[3];
    let three = c.m23[1] + c.m33[2] + c.m43[3];
    let four = c.m24[1] + c.m34[2] + c.m44[3];
    return vec4f(two, 0.0, 0.0) + vec4f(three, 0.0) + four * c.tail;
}
