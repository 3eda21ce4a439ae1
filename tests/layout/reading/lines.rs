//! Where lines end, and lines joined by a backslash.

use super::{Client, Severity, codes, leaves, of_driver, of_glslang, open, read, sorted};

/// A fragment shader of version 4.50 whose block U is those members, and which has a block V.
fn shader(members: &str, between: &str, used: &str) -> String {
    format!(
        "#version 450\nlayout(std140, binding = 0) uniform U {{ {members} }} u;\n{between}\n\
         layout(std140, binding = 1) uniform V {{ vec4 last; }} v;\n\
         layout(location = 0) out vec4 o;\nvoid main() {{ o = u.h + v.last{used}; }}\n"
    )
}

/// What is compared with both oracles: the name, the members of U, what stands before V, and an
/// expression that uses it: a driver lists no block that nothing uses.
const TEXTS: &[(&str, &str, &str, &str)] = &[
    ("a lone CR ends a line comment", "vec4 a; // x\r vec4 h;", "", ""),
    (
        "a lone CR ends a comment before a block",
        "vec4 h;",
        "// x\rlayout(std140, binding = 2) uniform W { vec4 w; } w;",
        " + w.w",
    ),
    (
        "a lone CR ends a directive",
        "vec4 a; vec4 h;",
        "#define N 4\rlayout(std140, binding = 2) uniform W { vec4 w[N]; } w;",
        " + w.w[0]",
    ),
    ("a CR begins the line of a directive", "vec4 h;", "#if 0\rvec4 gone;\r#endif\r", ""),
    (
        "a `#line` sets the next line",
        "vec4 a;\n#line 100\n#if __LINE__ == 100\nfloat b;\n#endif\nvec4 h;",
        "",
        "",
    ),
    (
        "a `#line` with macros and a string number",
        "vec4 a;\n#define L 5\n#line L 2\nfloat b[__LINE__ + __FILE__];\nvec4 h;",
        "",
        "",
    ),
    (
        "a `#line` that an earlier one is hidden by",
        "vec4 a;\n#line 9 4\n#line 2\nfloat b[__LINE__];\nvec4 h;",
        "",
        "",
    ),
    ("a splice inside a word", "ve\\\nc4 a; vec4 \\\nh;", "", ""),
    ("a splice with CR LF", "ve\\\r\nc4 a; float b; vec4 h;", "", ""),
    ("a splice with CR", "ve\\\rc4 a; float b; vec4 h;", "", ""),
    ("a splice inside a number", "vec4 a[1\\\n2]; vec4 h;", "", ""),
    ("a splice inside the end of a comment", "/* x *\\\n/ float a; vec4 h;", "", ""),
    ("a splice inside the start of a comment", "/\\\n* float a; */ vec4 h;", "", ""),
    ("a splice inside the start of a line comment", "vec4 b; /\\\n/ float a;\n vec4 h;", "", ""),
    ("a splice at the end of a line comment", "vec4 b; // x \\\n float a;\n vec4 h;", "", ""),
    ("two splices", "vec4 b; fl\\\n\\\noat a; vec4 h;", "", ""),
    (
        "a splice inside a directive's name",
        "vec4 h;",
        "#def\\\nine N 3\nlayout(std140, binding = 2) uniform W { vec4 w[N]; } w;",
        " + w.w[0]",
    ),
    (
        "a splice in a macro's body before `#`",
        "vec4 h;",
        "#define N \\\n 5 \\\n\nlayout(std140, binding = 2) uniform W { vec4 w[N]; } w;",
        " + w.w[0]",
    ),
    (
        "a comment before a directive",
        "vec4 h;",
        "#if 0\nlayout(std140, binding = 2) uniform W { vec4 w; } w;\n/* c */ #endif",
        "",
    ),
    (
        "a comment of two lines before a directive",
        "vec4 h;",
        "#if 0\nfloat a;\n/* c\n */ #else\nlayout(std140, binding = 2) uniform W { vec4 w; } w;\n#endif",
        " + w.w",
    ),
    ("a backslash with a blank after it", "float a; // x \\ \n vec4 h;", "", ""),
    (
        "a directive over a comment of two lines",
        "vec4 h;",
        "#define N /* \n */ 6\nlayout(std140, binding = 2) uniform W { vec4 w[N]; } w;",
        " + w.w[0]",
    ),
];

#[test]
fn lines_end_and_go_on_where_compilers_say() {
    let driver = open();
    for (name, members, between, used) in TEXTS {
        let text = shader(members, between, used);
        let ours = sorted(leaves(&read(&text, None)));
        assert_eq!(ours, sorted(of_glslang(&text, Client::Vulkan)), "glslang: {name}");
        assert_eq!(ours, sorted(of_driver(&driver, &text)), "driver: {name}");
    }
}

#[test]
fn places_count_lines_by_cr_and_spliced_lines_too() {
    let shader = read(
        "#version 450\r// x\rlayout(std140, binding = 0) uniform U {\r\n ve\\\nc4 a;\n vec4 b; };",
        None,
    );
    let lines: Vec<_> = shader.blocks[0]
        .members
        .iter()
        .map(|member| {
            let place = shader.files.locate(member.span);
            (place.line, place.column, shader.files.text(member.span))
        })
        .collect();
    assert_eq!(lines, [(5, 4, "a"), (6, 7, "b")]);
}

/// Mesa joins the lines in every version, glslang in those that have line continuations.
#[test]
fn a_comment_that_goes_on_in_an_old_version_is_reported() {
    let text = |version: &str| {
        format!(
            "#version {version}\nlayout(std140) uniform U {{ vec4 a; // x \\\n vec4 b;\n vec4 h; }} u;\n\
             out vec4 o;\nvoid main() {{ o = u.h; }}\n"
        )
    };
    let old = text("330");
    let joined = ["U.a 0", "U.h 16"];
    assert_eq!(of_driver(&open(), &old), joined);
    assert_eq!(
        of_glslang(&old.replace("out vec4", "layout(location = 0) out vec4"), Client::OpenGl).len(),
        3
    );
    let shader = read(&old, None);
    assert_eq!(leaves(&shader), joined);
    assert_eq!(codes(&shader), ["line-continuation"]);
    assert_eq!(shader.diagnostics[0].severity, Severity::Warning);
    assert_eq!(codes(&read(&text("420"), None)), [""; 0]);
    // Nothing is hidden by a rule of backslashes.
    let drawn = old.replace("vec4 b;", "// -----");
    assert_eq!(codes(&read(&drawn, None)), [""; 0]);
}

/// tint is held to the same texts in the campaign; here the line breaks of WGSL §3.2 one by one.
#[test]
fn every_line_break_of_wgsl_ends_a_comment() {
    for end in ["\n", "\r", "\r\n", "\u{b}", "\u{c}", "\u{85}", "\u{2028}", "\u{2029}"] {
        let text = format!(
            "struct U {{ a: vec4f, // x{end} b: f32, h: vec4f }}\n\
             @group(0) @binding(0) var<uniform> u: U;"
        );
        let source = ::landfall::Source::new("a.wgsl", text);
        let shader = ::landfall::layout(&source, &::landfall::Options::default());
        assert_eq!(
            leaves(&shader),
            ["U.a 0", "U.b 16", "U.h 32"]
                .map(|l| l.replace("U.", &format!("{}.", shader.blocks[0].name))),
            "{end:?}"
        );
    }
}
