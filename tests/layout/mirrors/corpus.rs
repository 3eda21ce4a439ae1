//! Shaders that ask for what random blocks do not have: names, comments, and
//! every kind of member at once.

/// Names that clash, are keywords, or are no Rust style.
pub const NAMES: &str = "#version 450
struct type { float fn; vec2 self; int gen; float async, _, __x, _1, x; vec3 lightPos; };
struct Option { type Type; float XYZ, xyz, Xyz; };
struct Vec3 { vec3 v; };
struct Bool { bool b; };
struct Leaf { bool b; float leaf[2]; };
struct F32Stride16 { float f; float f_[3]; };
struct Inner { float x; };
struct light_block { vec4 a; };
struct LightBlock { vec2 a; };
layout(std140) uniform self { Option option; float SIZE, binding, lookup[2], LEAVES, core, size; } of_self;
layout(std140) uniform core { Vec3 glam; Bool some[2]; Leaf none; F32Stride16 f; } bytemuck;
layout(std140) uniform Light_Block { light_block a; LightBlock b; int a_a; } std;
layout(std140, binding = 3) uniform HTTPServer2D { mat4 MVP; float a_b; vec4 aB; Inner inner; } s;
layout(std430) buffer Mismatch { uint TooShort; Leaf look_up[]; };
layout(std430) buffer mismatch { uint x; LightBlock y[][2]; } m;
";

/// Comments that rustdoc, rustc and clippy could take for something else.
pub const COMMENTS: &str = "#version 450
/// One lamp; see `Lamps` and [the docs](x).
//  \u{202e}turned
struct Lamp {
    vec3 pos;      // world space [m], <T> & *stars* _under_ `code[0]`
    // - a list
    //   that goes on
    // 1. and another
    //      indented as code
    float range;   //!< doxygen
    /* # heading
     * ```
     * let x = 1;
     * ``` */
    vec3 color;    /** linear */
    //////////////////////
    // ===== rule =====
    //
    // > quote | table
    // see https://example.com/a_b
    float last;    // \t tab\ttab    \\ backslash one ` tick
};
/*
 * All lamps.

 * Twice.
 */
layout(std140, set = 1, binding = 2) uniform Lamps { Lamp lamps[4]; /* in line */ int count; };
";

/// One structure under every rule, and stored by rows.
pub const RULES: &str = "#version 460
#extension GL_EXT_scalar_block_layout : require
struct Same { vec4 a; vec4 b; };
struct Light { vec3 pos; float w[2]; mat3 m; mat2 n; bool on; bvec3 which; };
layout(std140) uniform A { Same same; Light light; Light more[2]; } a;
layout(std430) buffer B { Same same; Light light; Light more[2]; } b;
layout(scalar) buffer C { Same same; Light light; Light more[2]; } c;
layout(std140, row_major) uniform D { Same same; Light light; mat2x3 m; } d;
layout(std140) uniform E { layout(row_major) Light light; mat2x3 m[2]; layout(row_major) mat4x2 n; } e;
";

/// Every scalar, odd packing, and tails.
pub const TYPES: &str = "#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_shader_explicit_arithmetic_types : require
#extension GL_EXT_buffer_reference : require
layout(buffer_reference, std430) buffer Node { Node next; float value; };
struct Small { uint8_t a; f16vec3 b; int16_t c; };
struct Odd { double d; float f; bool b; };
struct Nothing { float f; };
layout(std430) buffer Mixed { float16_t h; f16vec4 hs; u8vec3 bytes; i64vec2 longs; dmat3 d; dmat2x3 e; dvec4 v; Small s[3]; Node node; } of_mixed;
layout(scalar) buffer Scalars { Odd odd; float x; Odd odds[3]; uint8_t y; Odd grid[2][2]; dmat3 m; bvec2 bs; layout(row_major) dmat2x4 r; vec4 v4; mat4 m4; Small small[2]; i64vec3 i; } of_scalars;
layout(std430) buffer Tail { layout(offset = 32) vec3 tail[]; } of_tail;
layout(std430) buffer Tail2 { uint count; Small smalls[][2]; } of_tail2;
layout(scalar) buffer Tail3 { uint8_t count; uint8_t bytes[]; } of_tail3;
layout(std140) buffer Tail4 { mat3 tail[]; } of_tail4;
layout(scalar) buffer Tail5 { double d; Odd odd[]; } of_tail5;
layout(std430) buffer OnlyTail { float w[]; } of_onlytail;
layout(std430, push_constant) uniform Push { layout(offset = 16) vec4 b; layout(offset = 4) float a; } of_push;
layout(std140, binding = 4) uniform Many { float w[33]; Nothing n; vec2 pairs[5]; bool flags[3]; uvec2 u[2][3]; float v[2][3][4]; } many[2][3];
layout(std140) uniform Row { layout(row_major) mat4 a; layout(row_major) mat3 b[2]; layout(row_major) mat2x3 c; layout(row_major) dmat4 d; float e; } of_row;
";

pub const WGSL: &str = "
struct Light { pos: vec3<f32>, @size(16) intensity: f32, color: vec3f, @align(16) kind: u32, }
struct Inner { @align(32) a: f32, b: atomic<u32>, }
struct Größe { 高さ: f32, m: mat3x3<f32>, n: mat2x2f, o: mat4x3f, match: i32 }
struct Particles { count: atomic<u32>, head: array<atomic<i32>, 4>, list: array<Light> }
@group(0) @binding(0) var<uniform> light: Light;
@group(0) @binding(1) var<uniform> other: Light;
@group(1) @binding(0) var<storage, read_write> particles: Particles;
@group(1) @binding(1) var<storage> sizes: array<Größe, 3>;
@group(1) @binding(2) var<storage> inner: Inner;
@group(1) @binding(3) var<storage> plain: array<vec3f>;
@group(1) @binding(4) var<uniform> matrix: mat4x4f;
";
