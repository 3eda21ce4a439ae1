//! What the GLSL front end makes of a text: names, types, sizes, places of errors.
//!
//! Offsets here are worked out from OpenGL 4.6 §7.6.2.2 by hand; `oracles.rs`
//! compares with compilers and drivers.

use landfall_layout::{
    AddressSpace, ArrayLen, Options, Rules, ShaderLayout, Source, Target, layout,
};

fn read(text: &str) -> ShaderLayout {
    layout(&Source::new("test.frag", text), &Options::default())
}

/// `path offset` of every leaf of the first block.
fn leaves(text: &str) -> Vec<(String, u64)> {
    let shader = read(text);
    assert!(!shader.has_errors(), "{:#?}", shader.diagnostics);
    let block = shader.blocks.first().expect("a block");
    block.leaves.iter().map(|l| (l.path.clone(), l.offset.expect("an offset"))).collect()
}

fn offsets(text: &str) -> Vec<u64> {
    leaves(text).into_iter().map(|leaf| leaf.1).collect()
}

/// `code line:column` of every finding.
fn findings(text: &str) -> Vec<String> {
    told(&read(text))
}

fn told(shader: &ShaderLayout) -> Vec<String> {
    shader
        .diagnostics
        .iter()
        .map(|d| {
            let at = shader.files.locate(d.labels.first().expect("a place").at);
            format!("{} {}:{}", d.code.name(), at.line, at.column)
        })
        .collect()
}

#[test]
fn members_are_placed_by_their_types_and_qualifiers() {
    for (text, expected) in [
        // A float fills the hole after a vec3.
        ("layout(std140) uniform B { vec3 a; float b; vec3 c; vec2 d; };", [0, 12, 16, 32]),
        // A structure is rounded up to 16 in std140 and not in std430.
        (
            "struct S { float a; }; layout(std140) uniform B { float x; S s; float y, z; };",
            [0, 16, 32, 36],
        ),
        (
            "struct S { float a; }; layout(std430) buffer B { float x; S s; float y, z; };",
            [0, 4, 8, 12],
        ),
        (
            "layout(std140) uniform B {
                layout(offset = 32) float a; float b; layout(align = 64) float c;
                layout(offset = 132, align = 16) float d; };",
            [32, 36, 64, 144],
        ),
        // `align` of a block is that of each member.
        ("layout(std140, align = 32) uniform B { float a, b; vec2 c; float d; };", [0, 32, 64, 96]),
    ] {
        assert_eq!(offsets(text), expected, "{text}");
    }
}

#[test]
fn dimensions_are_outermost_first_in_every_spelling() {
    for spelling in ["float f[2][3]", "float[3] f[2]", "float[2][3] f"] {
        let shader = read(&format!("layout(std140) uniform B {{ {spelling}; float tail; }};"));
        let leaf = &shader.blocks[0].leaves[0];
        assert_eq!(leaf.path, "f[][]", "{spelling}");
        assert_eq!(leaf.strides, [48, 16], "{spelling}");
        assert_eq!(shader.blocks[0].leaves[1].offset, Some(96), "{spelling}");
    }
}

#[test]
fn row_major_changes_stride_count_of_a_matrix_that_is_not_square() {
    let text = "layout(std140) uniform B { layout(row_major) mat2x4 a; mat2x4 b; float c; };";
    let shader = read(text);
    let sizes: Vec<_> = shader.blocks[0].leaves.iter().map(|l| (l.offset, l.size)).collect();
    // 4 rows of 2 take 4 × 16; 2 columns of 4 take 2 × 16.
    assert_eq!(sizes[..2], [(Some(0), Some(64)), (Some(64), Some(32))]);
    assert!(shader.blocks[0].leaves[0].row_major && !shader.blocks[0].leaves[1].row_major);
}

#[test]
fn majorness_comes_from_the_member_then_the_block_then_the_default() {
    let text = "
        layout(std140, row_major) uniform;
        uniform A { mat4 a; layout(column_major) mat4 b; };
        layout(column_major) uniform B { mat4 c; };
        struct S { mat4 m; };
        uniform C { S s[2]; layout(column_major) S t; };";
    let shader = read(text);
    let majors: Vec<_> =
        shader.blocks.iter().flat_map(|b| &b.leaves).map(|l| l.row_major).collect();
    assert_eq!(majors, [true, false, false, true, false]);
    assert!(shader.blocks.iter().all(|b| b.rules_declared));
}

#[test]
fn an_offset_that_goes_back_is_vulkans_alone() {
    let text =
        "layout(std140) uniform B { layout(offset = 32) vec4 a; layout(offset = 0) vec4 b; };";
    let run = |target| {
        let mut options = Options::default();
        options.read.target = target;
        let shader = layout(&Source::new("test.frag", text), &options);
        (told(&shader), shader.blocks.len())
    };
    assert_eq!(run(Some(Target::OpenGl)), (vec!["offset-goes-back 1:63".to_string()], 0));
    assert_eq!(run(Some(Target::Vulkan)), (vec![], 1));
    // The text does not say which it is for: laid out, with a word of warning.
    assert_eq!(run(None), (vec!["offset-goes-back 1:80".to_string()], 1));
    let vulkan = text.replace("std140", "std140, set = 0");
    assert_eq!(offsets(&vulkan), [32, 0]);
}

#[test]
fn offsets_that_overlap_or_are_not_aligned_are_refused() {
    let text = "layout(std140, set = 0) uniform B {
        layout(offset = 0) mat4 a;
        layout(offset = 16) vec4 b; };";
    assert_eq!(findings(text), ["overlapping-members 3:34"]);
    let text = "layout(std140) uniform B { layout(offset = 4) vec2 a; };";
    assert_eq!(findings(text), ["misaligned-offset 1:35"]);
}

#[test]
fn push_constants_are_std430_by_default() {
    let shader = read("layout(push_constant) uniform P { vec2 g; float a[2]; };");
    let block = &shader.blocks[0];
    assert_eq!((block.space, block.rules), (AddressSpace::PushConstant, Rules::Std430));
    assert_eq!(block.leaves[1].strides, [4]);
    assert!(block.rules_declared);
}

#[test]
fn without_rules_the_driver_decides_in_opengl_and_the_language_in_vulkan() {
    for (text, declared) in [
        ("uniform B { float a; };", false),
        ("layout(shared) uniform B { float a; };", false),
        ("layout(packed) uniform B { float a; };", false),
        ("layout(std140) uniform B { float a; };", true),
        ("layout(set = 0, binding = 1) uniform B { float a; };", true),
        ("layout(std140) uniform; uniform B { float a; };", true),
        ("layout(std140) uniform; layout(shared) uniform B { float a; };", false),
    ] {
        assert_eq!(read(text).blocks[0].rules_declared, declared, "{text}");
    }
}

#[test]
fn sizes_may_be_any_constant_expression() {
    for (size, value) in [
        ("4", 4),
        ("0x10", 16),
        ("010", 8),
        ("3u", 3),
        ("N", 6),
        ("N * 2 + 1", 13),
        ("N > 4 ? 8 : 2", 8),
        ("int(3.9)", 3),
        ("max(N, 7)", 7),
        ("(1 << 3) | 1", 9),
        ("V.y", 5),
        ("W.length()", 3),
        ("~0u >> 30", 3),
        ("DOUBLE(N)", 12),
        ("ivec2(2, 9)[1]", 9),
        ("ivec2(1, 2) == uvec2(1, 2) ? 5 : 6", 5),
        ("ivec2(1, 2) != ivec2(1, 3) ? 7 : 8", 7),
    ] {
        let text = format!(
            "const int N = 2 * 3;
            const ivec2 V = ivec2(1, N - 1);
            const float W[] = float[](1.0, 2.0, 3.0);
            #define DOUBLE(x) ((x) * 2)
            layout(std140) uniform B {{ vec4 a[{size}]; }};"
        );
        let shader = read(&text);
        assert!(!shader.has_errors(), "{size}: {:?}", shader.diagnostics);
        assert_eq!(shader.blocks[0].data_size, Some(16 * value), "{size}");
    }
}

#[test]
fn an_array_without_a_size_is_as_long_as_its_constant_indices_need() {
    let with = |uses: &str| {
        format!(
            "#version 330\n#define LAST N + 1\nconst int N = 6;\nout vec4 c;\n\
             layout(std140) uniform B {{ float a[]; vec4 tail; }} b;\n\
             void main() {{ int i = 2; c = b.tail; {uses} }}\n"
        )
    };
    let text = with("c *= b.a[3] * b.a[LAST]; c += b.a[0];");
    assert_eq!(leaves(&text), [("a[]".to_string(), 0), ("tail".to_string(), 128)]);
    for (uses, place) in
        [("", "5:35"), ("c *= b.a[i];", "5:35"), ("c *= b.a[1]; c *= b.a.length();", "5:35")]
    {
        assert_eq!(findings(&with(uses)), [format!("array-size {place}")], "{uses}");
    }
    let es = with("c *= b.a[3];").replace("330", "300 es");
    assert_eq!(findings(&es), ["array-size 5:35"], "ES has no such arrays");
}

#[test]
fn the_default_of_a_specialisation_constant_lays_blocks_out() {
    let text = "layout(constant_id = 7) const int N = 4; layout(set = 0) uniform B { vec4 a[N]; };";
    let source = Source::new("a.frag", text);
    let size = |key: &str| {
        let mut options = Options::default();
        if !key.is_empty() {
            options.read.overrides.push((key.into(), "9".into()));
        }
        let shader = layout(&source, &options);
        (shader.blocks[0].size, shader.overrides[0].value)
    };
    assert_eq!(size(""), (Some(64), Some(4)));
    // GL_KHR_vulkan_glsl: specialisation does not lay a block out anew.
    assert_eq!(size("N"), (Some(64), Some(4)));
    assert_eq!(size("7"), (Some(64), Some(4)));
}

#[test]
fn function_bodies_do_not_matter() {
    let text = "layout(std140) uniform B { vec4 a; };
        void main() { this is } { no GLSL at all: @ $ ' # /* { */ // {
        }
        layout(std140) uniform C { vec4 b; };";
    assert_eq!(read(text).blocks.len(), 2);
}

#[test]
fn braces_of_a_format_are_no_blocks() {
    let text = |format: &str| {
        format!(
            "#version 450\n#extension GL_EXT_debug_printf : require\nvoid main() {{\n\
             #if 0\n a quote \" alone }}\n#endif\n debugPrintfEXT(\"{format}\", 1.0);\n}}\n\
             layout(std140, binding = 0) uniform B {{ vec3 a; vec4 b; }};\n"
        )
    };
    for format in ["{ %f", "} %f", "%f"] {
        assert_eq!(offsets(&text(format)), [0, 16], "{format}");
    }
}

#[test]
fn directives_inside_bodies_count() {
    let text = "void main() {
        #ifdef NOTHING
        }
        #else
        #define N 3
        }
        #endif
        layout(std140) uniform B { vec4 a[N]; };";
    assert_eq!(read(text).blocks[0].size, Some(48));
}

#[test]
fn macros_with_unpaired_braces_are_followed_in_bodies() {
    let text = "
        #define BEGIN {
        #define END }
        void main() BEGIN if (true) { END }
        layout(std140) uniform B { vec4 a; };";
    assert_eq!(read(text).blocks.len(), 1);
}

#[test]
fn version_and_profile_choose_branches() {
    let text = |version: &str| {
        format!(
            "{version}
            #ifdef GL_ES
            #define N 1
            #elif __VERSION__ >= 330 && defined(GL_core_profile)
            #define N 2
            #elif defined VULKAN
            #define N 3
            #else
            #define N 4
            #endif
            layout(std140) uniform B {{ vec4 a[N]; }};"
        )
    };
    let opengl = |version: &str| {
        let mut options = Options::default();
        options.read.target = Some(Target::OpenGl);
        layout(&Source::new("a.frag", text(version)), &options).blocks[0].size
    };
    assert_eq!(opengl("#version 300 es"), Some(16));
    assert_eq!(opengl("#version 100"), Some(16));
    assert_eq!(opengl("#version 330 core"), Some(32));
    assert_eq!(opengl("#version 450"), Some(32));
    assert_eq!(opengl("#version 330 compatibility"), Some(64));
    assert_eq!(opengl("#version 120"), Some(64));
    // Who asks for `VULKAN` in a version Vulkan takes is answered as Vulkan would.
    let asks = |version| read(&text(&format!("{version}\n#undef GL_core_profile"))).blocks[0].size;
    assert_eq!(asks("#version 450"), Some(48));
    assert_eq!(asks("#version 330"), Some(64));
}

#[test]
fn macros_expand_as_the_language_says() {
    let text = "
        #define CAT(a, b) a ## b
        #define SIZE_4 4
        #define SIZE(n) CAT(SIZE_, n)
        #define MEMBER(type, name) type name;
        #define SELF SELF
        #define LIGHT(n) MEMBER(vec3, CAT(light, n)) MEMBER(float, CAT(power, n))
        layout(std140) uniform B { LIGHT(0) LIGHT(1) vec4 SELF[SIZE(4)]; };";
    let paths: Vec<_> = leaves(text).into_iter().map(|leaf| leaf.0).collect();
    assert_eq!(paths, ["light0", "power0", "light1", "power1", "SELF[]"]);
}

#[test]
fn an_error_in_a_macro_points_at_its_use_and_its_definition() {
    let text = "#define BAD nothing x;\nlayout(std140) uniform B {\n    BAD\n};";
    let shader = read(text);
    let places: Vec<_> = shader.diagnostics[0]
        .labels
        .iter()
        .map(|label| shader.files.locate(label.at))
        .map(|at| (at.line, at.column))
        .collect();
    assert_eq!(places, [(3, 5), (1, 13)]);
}

#[test]
fn loose_uniforms_have_no_offsets_until_gathered() {
    let text = "
        struct Material { sampler2D diffuse; vec3 tint; float shininess; };
        uniform Material material;
        uniform sampler2D shadow;
        uniform vec3 view, light[2];
        uniform float gain = 2.0;";
    let shader = read(text);
    let block = &shader.blocks[0];
    assert_eq!((&*block.name, block.space), ("DefaultBlock", AddressSpace::Default));
    let paths: Vec<_> = block.leaves.iter().map(|l| l.path.as_str()).collect();
    assert_eq!(paths, ["material.tint", "material.shininess", "view", "light[]", "gain"]);
    assert!(block.leaves.iter().all(|l| l.offset.is_none()) && block.size.is_none());
    assert_eq!(*block.opaque, ["shadow".into()]);

    let options = Options::default().with_gather(true);
    let gathered = layout(&Source::new("a.frag", text), &options);
    let block = &gathered.blocks[0];
    assert_eq!((block.space, block.rules_declared), (AddressSpace::Uniform, false));
    let offsets: Vec<_> = block.leaves.iter().filter_map(|l| l.offset).collect();
    assert_eq!(offsets, [0, 12, 16, 32, 64]);
}

#[test]
fn a_runtime_sized_tail_is_counted_with_one_element() {
    let shader = read("layout(std430) buffer B { int n; vec4 a[]; };");
    let block = &shader.blocks[0];
    assert_eq!((block.size, &block.leaves[1].dims[0]), (Some(32), &ArrayLen::Runtime));
}

#[test]
fn an_array_of_blocks_is_several_buffers() {
    let shader = read("layout(std140) uniform B { vec4 a; } b[3];");
    assert_eq!(shader.blocks[0].size, Some(16));
    assert_eq!(shader.blocks[0].count, [ArrayLen::Fixed(3)]);
}

#[test]
fn buffer_references_are_eight_bytes_and_blocks_of_their_own() {
    let text = "
        layout(buffer_reference) buffer Node;
        layout(buffer_reference, std430) buffer Node { int value; Node next; };
        layout(push_constant) uniform P { float a; Node root; };";
    let shader = read(text);
    assert_eq!(shader.blocks[0].space, AddressSpace::BufferReference);
    let offsets: Vec<_> = shader.blocks.iter().flat_map(|b| &b.leaves).map(|l| l.offset).collect();
    assert_eq!(offsets, [Some(0), Some(8), Some(0), Some(8)]);
}

#[test]
fn comments_belong_to_the_member_they_stand_at() {
    let text = "layout(std140) uniform B { // of the block
        // above a
        vec3 a; // beside a
        float b; /* beside b */
        /* above c */ vec2 c;
    };";
    let shader = read(text);
    let comments = |i: usize| -> Vec<&str> {
        shader.blocks[0].members[i].comment.iter().map(|c| shader.files.text(*c)).collect()
    };
    assert_eq!(comments(0), ["// above a", "// beside a"]);
    assert_eq!(comments(1), ["/* beside b */"]);
    assert_eq!(comments(2), ["/* above c */"]);
}

#[test]
fn every_error_is_told_with_its_place() {
    let text = "layout(std140) uniform A { float a[0]; float b[-1]; } in_a;
uniform int n;
layout(std140) uniform C { float a[n]; Foo b; } in_c;
struct S { float x; S next; };
layout(std140) uniform D { S s; } in_d;
layout(std140) uniform E { vec4 fine; };
layout(std140) uniform F { sampler2D t; };
layout(std140) uniform G { float a; float a; } in_g;";
    assert_eq!(
        findings(text),
        [
            "array-size 1:36",
            "array-size 1:48",
            "array-size 3:36",
            "unknown-type 3:40",
            "recursive-struct 4:21",
            "opaque-in-block 7:38",
            "duplicate-name 8:43",
        ]
    );
    let names: Vec<_> = read(text).blocks.iter().map(|b| b.name.to_string()).collect();
    assert_eq!(names, ["E", "DefaultBlock"]);
}

#[test]
fn a_missing_semicolon_costs_one_finding() {
    let text = "uniform vec3 a\nuniform vec3 b;\nlayout(std140) uniform B { vec3 x; };";
    assert_eq!(findings(text), ["syntax 2:1"]);
    assert_eq!(read(text).blocks.len(), 2);
}

#[test]
fn line_endings_and_byte_order_marks_do_not_matter() {
    let text = "\u{feff}#version 330\r\nlayout(std140) uniform B {\r\n    vec3 a; // é\r\n    Foo b;\r\n};\r\n";
    assert_eq!(findings(text), ["unknown-type 4:5", "byte-order-mark 1:1"]);
}

#[test]
fn text_made_to_exhaust_memory_is_refused() {
    let mut laughs = "#define A0 1+1\n".to_string();
    let mut structs = "struct S0 { float a; };\n".to_string();
    for i in 1..64 {
        laughs += &format!("#define A{i} A{0} + A{0}\n", i - 1);
        structs += &format!("struct S{i} {{ S{0} a; S{0} b; }};\n", i - 1);
    }
    laughs += "layout(std140) uniform B { float a[A63]; };";
    structs += "layout(std140) uniform B { S63 s; };";
    assert_eq!(read(&laughs).diagnostics[0].code, "macro-bomb");
    assert_eq!(read(&structs).diagnostics[0].code, "too-many-members");

    let parens = format!(
        "layout(std140) uniform B {{ float a[{}1{}]; }};",
        "(".repeat(10_000),
        ")".repeat(10_000)
    );
    assert_eq!(read(&parens).diagnostics[0].code, "array-size");
    let dims = format!("layout(std140) uniform B {{ float a{}; }};", "[1]".repeat(10_000));
    assert_eq!(read(&dims).diagnostics[0].code, "nested-too-deep");
    assert_eq!(read(&"{".repeat(1_000_000)).diagnostics.len(), 1);
    assert_eq!(read(&"}".repeat(1_000_000)).diagnostics.len(), 1);
}

#[test]
fn blocks_end_at_2_to_the_32() {
    assert_eq!(
        read("layout(std140) uniform B { vec4 a[268435456]; };").blocks[0].size,
        Some(1 << 32)
    );
    for too_large in
        ["vec4 a[268435457]", "float a[1000000000][8]", "float a[4294967295][4294967295][9]"]
    {
        let text = format!("layout(std140) uniform B {{ {too_large}; }};");
        assert_eq!(read(&text).diagnostics[0].code, "block-too-large", "{too_large}");
    }
}

#[test]
fn includes_are_found_and_faults_are_told_at_the_directive() {
    let dir = std::env::temp_dir().join(format!("landfall-includes-{}", std::process::id()));
    std::fs::create_dir_all(dir.join("lib")).expect("a directory for the test");
    let write = |name: &str, text: &str| std::fs::write(dir.join(name), text).expect("a test file");
    write("lib/light.glsl", "struct Light { vec3 pos; float power; };\n#include \"more.glsl\"\n");
    write("lib/more.glsl", "const int LIGHTS = 3;\n");
    write("loop.glsl", "\n#include \"loop.glsl\"\n");
    write(
        "guarded.glsl",
        "#ifndef G\n#define G\n#include \"guarded.glsl\"\nstruct T { vec4 t; };\n#endif\n",
    );
    write(
        "a.frag",
        "#version 450\n#include <light.glsl>\n#include \"guarded.glsl\"\nlayout(std140) uniform B { Light l[LIGHTS]; T t; };\n",
    );
    write(
        "b.frag",
        "#version 450\n  #include \"nowhere.glsl\"\nlayout(std140) uniform B { vec4 a; };\n",
    );
    write("c.frag", "#version 450\n#include \"loop.glsl\"\n");
    let mut options = Options::default();
    options.read.include_dirs.push(dir.join("lib"));
    let run = |name: &str| layout(&Source::read(dir.join(name)).expect("a shader"), &options);

    let a = run("a.frag");
    assert!(a.diagnostics.is_empty(), "{:?}", a.diagnostics);
    assert_eq!(a.blocks[0].size, Some(3 * 16 + 16));
    assert_eq!(told(&run("b.frag")), ["missing-include 2:4"]);
    let c = run("c.frag");
    assert_eq!(told(&c), ["cyclic-include 2:2"]);
    let place = c.files.locate(c.diagnostics[0].labels[0].at);
    assert!(place.path.ends_with("loop.glsl"), "{}", place.path);
    std::fs::remove_dir_all(&dir).expect("the test's own directory");
}
