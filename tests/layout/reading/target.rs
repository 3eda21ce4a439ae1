//! Which API a text is read for, and what is said where it does not say.

use std::io::Write;
use std::process::{Command, Stdio};

use snapbox::str;

use super::{Client, Target, codes, compiled, leaves, of_driver, of_glslang, open, read};
use crate::support::command::golden;
use crate::support::glslang;
use landfall_layout::format::{EmitOptions, Format, document};
use landfall_layout::layout::targets::CODE;
use landfall_layout::source::ReadOptions;
use landfall_layout::{Options, Source, layout, lock};

/// For Vulkan `a` is at 0, for OpenGL at 16.
const BOTH: &str = "#version 330\n\
#extension GL_ARB_shading_language_420pack : enable\n\
#ifdef VULKAN\n\
layout(set = 0, binding = 0, std140) uniform U { vec4 a; } u;\n\
layout(location = 0) out vec4 o;\n\
#else\n\
layout(std140) uniform U { float scale; vec4 a; } u;\n\
out vec4 o;\n\
#endif\n\
void main() { o = u.a; }\n";

#[test]
fn a_text_for_both_is_read_as_its_version_says_and_the_difference_is_reported() {
    let (vulkan, opengl) = (vec!["U.a 0"], vec!["U.scale 0", "U.a 16"]);
    assert_eq!(of_driver(&open(), BOTH), opengl);
    let late = BOTH
        .replace("330", "450")
        .replace(" : enable", " : enable\n#extension GL_ARB_separate_shader_objects : enable");
    assert_eq!(of_glslang(&late, Client::Vulkan), vulkan);

    let shader = read(BOTH, None);
    assert_eq!(leaves(&shader), opengl);
    assert_eq!((shader.assumed_target, codes(&shader)), (Some(Target::OpenGl), vec![CODE]));
    let found = &shader.diagnostics[0];
    golden().eq(
        found.message.clone(),
        str!["block `U` is laid out differently for Vulkan: `scale` is removed"],
    );
    let shader = read(&late, None);
    assert_eq!(leaves(&shader), vulkan);
    assert_eq!((shader.assumed_target, codes(&shader)), (Some(Target::Vulkan), vec![CODE]));

    for (target, theirs) in [(Target::OpenGl, &opengl), (Target::Vulkan, &vulkan)] {
        let shader = read(BOTH, Some(target));
        assert_eq!(leaves(&shader), *theirs);
        assert_eq!((shader.assumed_target, codes(&shader)), (None, vec![]), "it was said");
    }
}

#[test]
fn what_was_assumed_stands_in_every_format_and_in_the_lock() {
    let shader = read(BOTH, None);
    for (format, expected) in [
        (
            Format::Table,
            str![[r#"
a.frag (fragment)
  read for OpenGL, as the shader names no API; its blocks differ for Vulkan

uniform U u · std140 · 32 bytes
  offset  size  align  type   name
       0     4      4  float  scale
       4    12                -- hole
      16    16     16  vec4   a
  32 bytes: 20 used, 12 padding (37.5 %)

"#]],
        ),
        (
            Format::Listing,
            str![[r#"
// a.frag
// read for OpenGL, as the shader names no API; its blocks differ for Vulkan

/*            align(16) size(32) */ layout(std140) uniform U {
/* offset( 0) align( 4) size( 4) */     float scale;
/* offset( 4)           size(12) */     // -- hole
/* offset(16) align(16) size(16) */     vec4 a;
/*                               */ } u;
// 32 bytes: 20 used, 12 padding (37.5 %)

"#]],
        ),
        (
            Format::Markdown,
            str![[r#"
# `a.frag`

Note: read for OpenGL, as the shader names no API; its blocks differ for Vulkan.

## `uniform U u`

std140

| offset | size | stride | type | path |
|--:|--:|--:|---|---|
| 0 | 4 |  | `float` | `scale` |
| 16 | 16 |  | `vec4` | `a` |

32 bytes: 20 used, 12 padding (37.5 %)

"#]],
        ),
    ] {
        golden().eq(document(&shader, &EmitOptions::new(format)), expected);
    }
    let json = document(&shader, &EmitOptions::new(Format::Json));
    let read = |text: &str| serde_json::from_str::<serde_json::Value>(text).expect("JSON");
    assert_eq!(read(&json)["shaders"][0]["assumed_target"], "opengl");
    let lock = lock::write(&shader);
    assert_eq!(read(&lock)["assumed_target"], "opengl");
    let again = lock::read("a.frag.json", &lock).unwrap();
    assert_eq!((again.assumed_target, again.text()), (Some(Target::OpenGl), lock));
    let json = lock::read("a.json", &json).unwrap();
    assert_eq!(json.assumed_target, Some(Target::OpenGl));
    let rust = landfall_codegen::rust::rust(&[&shader], &Default::default()).text;
    golden().eq(
        assumed(&rust),
        str!["// (read for OpenGL, as the shader names no API; its blocks differ for Vulkan)"],
    );
    let c = landfall_codegen::c::c(&[&shader], &Default::default()).text;
    golden().eq(
        assumed(&c),
        str![" *   (read for OpenGL, as the shader names no API; its blocks differ for Vulkan)"],
    );
}

/// The line of generated code that names the API that was assumed.
fn assumed(code: &str) -> &str {
    code.lines().find(|line| line.contains("read for")).unwrap_or(code)
}

/// What only Vulkan's GLSL has decides where it is compiled, not where it is mentioned.
#[test]
fn a_word_of_vulkan_decides_outside_conditions_and_in_those_that_hold() {
    let shader = |head: &str| {
        read(
            &format!(
                "{head}\n#ifdef VULKAN\nlayout(std140) uniform U {{ vec4 a; }};\n#else\n\
                 layout(std140) uniform U {{ float b; vec4 a; }};\n#endif\n"
            ),
            None,
        )
    };
    let is_vulkan = |head: &str| {
        let shader = shader(head);
        let target = if leaves(&shader).contains(&"U.a 0".to_string()) {
            Target::Vulkan
        } else {
            Target::OpenGl
        };
        (target, shader.assumed_target.is_some())
    };
    let (sure, assumed) = (|target| (target, false), |target| (target, true));
    let push = "layout(push_constant) uniform P { vec4 p; };";
    for (head, expected) in [
        ("#version 450", assumed(Target::Vulkan)),
        ("#version 310 es", assumed(Target::Vulkan)),
        ("#version 430", assumed(Target::OpenGl)),
        ("", assumed(Target::OpenGl)),
        // Vulkan takes none of these.
        ("#version 450 compatibility", sure(Target::OpenGl)),
        ("#version 120", sure(Target::OpenGl)),
        ("#version 300 es", sure(Target::OpenGl)),
        ("#version 100", sure(Target::OpenGl)),
        (&format!("#version 330\n{push}"), sure(Target::Vulkan)),
        (&format!("#version 330\n// {push}"), assumed(Target::OpenGl)),
        (&format!("#version 330\n#if 0\n{push}\n#endif"), assumed(Target::OpenGl)),
        (&format!("#version 330\n#ifdef VULKAN\n{push}\n#endif"), assumed(Target::OpenGl)),
        (
            &format!("#version 330\n#ifndef GUARD\n#define GUARD\n{push}\n#endif"),
            sure(Target::Vulkan),
        ),
        ("#version 330\nuniform subpassInput s;", sure(Target::Vulkan)),
        ("#version 330\nuniform texture2D t;", sure(Target::Vulkan)),
        ("#version 330\nvec4 f() { return texture2D (s, v); }", assumed(Target::OpenGl)),
        ("#version 330\nint set = 1;", assumed(Target::OpenGl)),
        ("#version 330\nint f() { return gl_VertexIndex; }", sure(Target::Vulkan)),
        ("#version 330\n#define S set\nlayout(S = 1) uniform V { vec4 v; };", sure(Target::Vulkan)),
    ] {
        assert_eq!(is_vulkan(head), expected, "{head}");
    }
}

/// The text after glslang's preprocessor, without comments and macros.
fn preprocessed(text: &str) -> String {
    let mut command = Command::new("glslangValidator");
    command.args(["-E", "--stdin", "-S", "frag"]).stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut child = command.spawn().expect("glslangValidator (Debian: glslang-tools) runs");
    child.stdin.take().expect("it is piped").write_all(text.as_bytes()).expect("it reads");
    let output = child.wait_with_output().expect("it ends");
    assert!(output.status.success(), "{text}");
    String::from_utf8(output.stdout).expect("the text is ASCII")
}

/// A block without rules is std140 for Vulkan and the driver's for OpenGL.
#[test]
fn the_qualifier_set_makes_a_text_vulkans_however_it_is_written() {
    let of = |text: &str, read: ReadOptions| {
        let shader = layout(&Source::new("a.frag", text), &Options::default().with_read(read));
        assert!(!shader.has_errors(), "{text}: {:?}", shader.diagnostics);
        let declared = shader.block("U").expect("it is there").rules_declared;
        if declared { Target::Vulkan } else { Target::OpenGl }
    };
    for (head, set, target) in [
        ("", "set = 0, ", Target::Vulkan),
        ("", "set=0, ", Target::Vulkan),
        ("// a / b, set = 1\n", "set /* = */ // =\n = 0, ", Target::Vulkan),
        ("/* set = 1 */ /**/ //\n", "set\n=\n0, ", Target::Vulkan),
        ("#define AT(n) set = n\n", "AT(0), ", Target::Vulkan),
        ("#define AT(key, n) key = n\n", "AT(set, 0), ", Target::Vulkan),
        ("#define GROUP set\n", "GROUP = 0, ", Target::Vulkan),
        ("#define IS =\n", "set IS 0, ", Target::Vulkan),
        ("# define NOTHING\n", "set NOTHING = 0, ", Target::Vulkan),
        ("", "s\\\net = 0, ", Target::Vulkan),
        ("// layout(set = 0)\n", "", Target::OpenGl),
        ("/* layout(\nset = 0) */\n", "/* set = 0 */", Target::OpenGl),
        ("int set = 1 / 1;\n", "", Target::OpenGl),
        ("bool f(int set, int reset) { return set == reset; }\n", "", Target::OpenGl),
    ] {
        let text = format!(
            "#version 450\n{head}layout({set}binding = 0) uniform U {{ vec4 a; }};\nvoid main() {{}}\n"
        );
        let expanded: String = preprocessed(&text).split_whitespace().collect();
        assert_eq!(expanded.contains("layout(set=0,"), target == Target::Vulkan, "{expanded}");
        assert_eq!(of(&text, ReadOptions::default()), target, "{text}");
    }

    let group = "layout(set = 0, binding = 0)";
    let text = "#version 450\nGROUP uniform U { vec4 a; };\n";
    let mut given = ReadOptions::default();
    given.defines = vec![("GROUP".to_string(), group.to_string())];
    assert_eq!(of(text, given.clone()), Target::Vulkan);
    given.defines = vec![("GROUP".to_string(), "layout(binding = 0)".to_string())];
    assert_eq!(of(text, given), Target::OpenGl);

    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("qualifier_set");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("group.glsl"), format!("#define GROUP {group}\n")).unwrap();
    let mut read = ReadOptions::default();
    read.include_dirs = vec![folder];
    let text = format!("#version 450\n# include \"group.glsl\"\n{}", &text[13..]);
    assert_eq!(of(&text, read), Target::Vulkan);
}

#[test]
fn a_text_whose_blocks_are_the_same_for_both_has_nothing_said() {
    let text = "#version 450\nlayout(std140, binding = 0) uniform U { vec4 a; };\n\
                void main() {\n#ifdef VULKAN\n#endif\n}\n";
    let shader = read(text, None);
    assert_eq!((shader.assumed_target, codes(&shader)), (None, vec![]));
    let loose = "#version 450\n#ifdef VULKAN\nlayout(push_constant) uniform P { vec4 a; };\n#else\n\
                 uniform vec4 a;\n#endif\n";
    let shader = read(loose, None);
    // Other blocks, none of which is laid out otherwise.
    assert_eq!((shader.assumed_target, codes(&shader)), (Some(Target::Vulkan), vec![]));
}

/// A text that one API's branch refuses is the other's.
#[test]
fn a_branch_that_is_an_error_is_no_other_reading() {
    let text = "#version 330\n#ifdef VULKAN\n#error not for Vulkan\n\
                layout(std140) uniform U { vec4 a; };\n#else\nlayout(std140) uniform U { float b; };\n#endif\n";
    let shader = read(text, None);
    assert_eq!((leaves(&shader), shader.assumed_target), (vec!["U.b 0".to_string()], None));
}

/// Vulkan's GLSL has no uniforms outside blocks but opaque ones; glslang takes them with `-R`.
#[test]
fn uniforms_outside_blocks_are_those_of_opengl_unless_vulkans_compiler_does_not_see_them() {
    let shader = |head: &str| {
        format!(
            "#version 450\n{head}\n#ifdef VULKAN\n\
             layout(set = 0, binding = 0, std140) uniform U {{ vec4 a; }} u;\n#else\n\
             layout(std140) uniform U {{ float scale; vec4 a; }} u;\n#endif\nvoid main() {{}}\n"
        )
    };
    for (head, target) in [
        ("uniform float loose;", Target::OpenGl),
        ("struct S { float x; };\nuniform S loose;", Target::OpenGl),
        ("layout(location = 3) uniform mat4 loose[2];", Target::OpenGl),
        ("#ifndef GUARD\nuniform float loose;\n#endif", Target::OpenGl),
        ("#ifndef VULKAN\nuniform float loose;\n#endif", Target::Vulkan),
        ("layout(binding = 1) uniform sampler2D loose;", Target::Vulkan),
        ("// uniform float loose;", Target::Vulkan),
    ] {
        let text = shader(head);
        let taken = compiled(&text, Client::Vulkan).is_ok();
        assert_eq!(taken, target == Target::Vulkan, "{head}");
        assert!(glslang::accepts(&text, "frag"), "{head}");
        let shader = read(&text, None);
        let notes = [
            (Target::OpenGl, "read for OpenGL: uniforms outside blocks"),
            (Target::Vulkan, "read for Vulkan: the shader tests `VULKAN`"),
        ];
        let (_, start) = notes.iter().find(|(of, _)| *of == target).unwrap();
        assert_eq!((shader.assumed_target, codes(&shader)), (Some(target), vec![CODE]), "{head}");
        let note = &shader.diagnostics[0].notes[0];
        assert!(note.starts_with(start), "{head}: {note}");
    }
}

/// What looks like a word of Vulkan's GLSL where it is none.
#[test]
fn names_of_ones_own_do_not_make_a_text_vulkans() {
    let both = "#ifdef VULKAN\nlayout(set = 0, binding = 0, std140) uniform U { vec4 a; } u;\n#else\n\
                layout(std140) uniform U { float scale; vec4 a; } u;\n#endif\n\
                out vec4 o;\nvoid main() { o = u.a; }\n";
    let of_opengl = vec!["U.scale 0", "U.a 16"];
    for own in [
        "float rayPayloadGain = 1.0;",
        "float subpassInputGain = 1.0;",
        "float f(float constant_id) { return constant_id; }",
        "struct Push { float a; };\nPush push_constant;",
        "float buffer_reference;",
        "struct texture2D { float a; };\nfloat f(texture2D t) { return t.a; }",
    ] {
        let text = format!("#version 330\n{own}\n{both}");
        assert_eq!(of_driver(&open(), &text), of_opengl, "{own}");
        let shader = read(&text, None);
        let assumed = (shader.assumed_target, codes(&shader));
        assert_eq!(leaves(&shader), of_opengl, "{own}");
        assert_eq!(assumed, (Some(Target::OpenGl), vec![CODE]), "{own}");
    }
    // OpenGL has specialisation constants, too (GL_ARB_gl_spirv).
    let text = format!(
        "#version 450\nlayout(constant_id = 0) const int N = 2;\n{}",
        both.replace("out vec4", "layout(location = 0) out vec4")
    );
    assert_eq!(of_glslang(&text, Client::Vulkan), ["U.a 0"]);
    let shader = read(&text, None);
    assert_eq!(leaves(&shader), ["U.a 0"]);
    assert_eq!((shader.assumed_target, codes(&shader)), (Some(Target::Vulkan), vec![CODE]));
}

#[test]
fn blocks_that_only_the_other_api_has_are_named_if_there_are_no_others() {
    let text = "#version 450\n#ifndef VULKAN\nlayout(std140) uniform U { vec4 a; } u;\n#endif\n\
                void main() {}\n";
    let shader = read(text, None);
    assert_eq!(leaves(&shader), [""; 0]);
    assert_eq!((shader.assumed_target, codes(&shader)), (Some(Target::Vulkan), vec![CODE]));
    let found = &shader.diagnostics[0];
    golden().eq(found.message.clone(), str!["block `U` exists only for OpenGL"]);
}

/// OpenGL ES leaves the size that a driver reports to the implementation (OpenGL ES 3.2 §7.6,
/// `UNIFORM_BLOCK_DATA_SIZE`): said where std140 rounds a size up, in formats that people read.
#[test]
fn the_size_of_a_block_of_opengl_es_is_that_of_desktop_drivers() {
    let note = "ize as desktop drivers report; OpenGL ES leaves it to the implementation";
    let forms = [Format::Table, Format::Listing, Format::Markdown, Format::Json, Format::Csv];
    let block = "layout(std140) uniform U { vec4 a; float b; } u;";
    let whole = "layout(std140) uniform U { vec4 a; vec4 b; } u;";
    let buffer = "layout(std430, binding = 0) buffer B { vec4 a; float b; } u;";
    let test = "#ifdef VULKAN\n#endif";
    for (text, target, expected) in [
        (format!("#version 300 es\n{block}"), None, true),
        (format!("#version 310 es\n{block}"), None, true),
        (format!("#version 320 es\n{test}\n{block}"), Some(Target::OpenGl), true),
        // Read for Vulkan, which has no such query.
        (format!("#version 320 es\n{test}\n{block}"), None, false),
        (format!("#version 310 es\n{block}"), Some(Target::Vulkan), false),
        (format!("#version 330\n{block}"), None, false),
        // Nothing is rounded.
        (format!("#version 300 es\n{whole}"), None, false),
        (format!("#version 310 es\n{buffer}"), None, false),
    ] {
        let shader = read(&text, target);
        for (form, format) in forms.into_iter().enumerate() {
            let said = document(&shader, &EmitOptions::new(format)).contains(note);
            assert_eq!(said, expected && form < 3, "{format:?}, {target:?}: {text}");
        }
    }
}
