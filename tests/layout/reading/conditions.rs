//! `true` and `false` in conditions: words like others, 0 where they are no macro (GLSL 4.60 §3.3).
//! The oracles are glslangValidator and Mesa's driver.

use super::{
    Client, Severity, codes, drawn, leaves, of_driver, of_glslang, open, read, severities, sorted,
};
use crate::support::glslang;
use ::landfall::{Options, Source, Target, layout};

/// A fragment shader with a block of one size where a condition holds, and of another where not.
fn shader(version: &str, before: &str, condition: &str) -> String {
    let precision = if version.ends_with("es") { "precision highp float;\n" } else { "" };
    format!(
        "#version {version}\n{precision}{before}#if {condition}\nlayout(std140) uniform U {{ float s; vec4 a; }};\n\
         #else\nlayout(std140) uniform U {{ vec4 a; }};\n#endif\nout vec4 o;\n\
         void main() {{ o = a; }}\n"
    )
}

/// The texts before a condition, and the condition.
const FORMS: &[(&str, &str)] = &[
    ("", "true"),
    ("", "false"),
    ("", "!true"),
    ("", "true == 1"),
    ("", "false == 0"),
    ("", "true == false"),
    ("", "defined(NOPE) == false"),
    ("", "defined(GL_core_profile) == true"),
    ("", "true && 1"),
    ("", "1 && true"),
    ("", "0 || true"),
    ("", "1 || true"),
    ("", "true + 1"),
    ("", "(true)"),
    ("", "-true"),
    ("", "~true"),
    ("", "true > 0"),
    ("#define ON true\n", "ON"),
    ("#define ON false\n", "!ON"),
    ("#define ON true\n", "ON && defined(ON)"),
    ("#define ON true\n", "ON == true"),
    ("#define ON true\n#define OFF false\n", "ON != OFF"),
    ("#define IS(x) x\n", "IS(true)"),
    // The other words of the language are names as well.
    ("", "float"),
    ("", "!vec3"),
    ("", "struct == 0"),
    ("", "uniform + 1"),
];

#[test]
fn true_and_false_are_0_in_conditions_of_desktop_glsl() {
    let driver = open();
    for (before, condition) in FORMS {
        for version in ["330", "450"] {
            let text = shader(version, before, condition);
            let ours = read(&text, Some(Target::OpenGl));
            assert_eq!(sorted(leaves(&ours)), sorted(of_driver(&driver, &text)), "{text}");
            let warnings = codes(&ours).iter().filter(|code| **code == "undefined-macro").count();
            // What stands behind a decided `||` has no part in it.
            assert_eq!(warnings > 0, *condition != "1 || true", "{text}");
        }
        let text = shader("450", before, condition).replace("std140", "std140, binding = 0");
        let text = text.replace("out vec4", "layout(location = 0) out vec4");
        assert_eq!(leaves(&read(&text, None)), of_glslang(&text, Client::Vulkan), "{text}");
    }
}

/// Where they are macros they are expanded; glslang and Mesa agree.
#[test]
fn macros_named_true_and_false_count() {
    let driver = open();
    for (before, condition) in [
        ("#define true 1\n", "true"),
        ("#define true 1\n#define ON true\n", "ON"),
        ("#define false 2\n", "false > 1"),
        ("#define true 1\n#undef true\n", "true"),
    ] {
        let text = shader("330", before, condition);
        let ours = read(&text, Some(Target::OpenGl));
        assert_eq!(sorted(leaves(&ours)), sorted(of_driver(&driver, &text)), "{text}");
    }
}

#[test]
fn a_macro_of_the_command_line_may_be_true() {
    let text = "#version 450\n#if SHADOWS\nlayout(std140, binding = 0) uniform U { float s; vec4 a; };\n\
                #else\nlayout(std140, binding = 0) uniform U { vec4 a; };\n#endif\n\
                layout(location = 0) out vec4 o;\nvoid main() { o = a; }\n";
    for value in ["true", "false", "1", "0", "(true)", "!true"] {
        let defines = vec![format!("SHADOWS={value}")];
        let options = glslang::Options { defines, ..glslang::Options::unlisted() };
        let listed = glslang::blocks(text, "frag", &options).unwrap_or_else(|log| panic!("{log}"));
        let mut options = Options::default();
        options.read.defines = vec![("SHADOWS".to_string(), value.to_string())];
        let ours = layout(&Source::new("a.frag", text), &options);
        assert_eq!(leaves(&ours), super::theirs(&listed), "{value}");
        assert_eq!(
            codes(&ours).contains(&"undefined-macro"),
            value.contains("true") || value == "false"
        );
    }
}

/// GLSL ES 3.20 §3.4: a name that is no macro is an error.
#[test]
fn true_and_false_are_errors_in_conditions_of_es() {
    for (before, condition) in FORMS {
        let text = shader("310 es", before, condition);
        let refused = !glslang::accepts(&text, "frag");
        assert_eq!(refused, !condition.starts_with("1 ||"), "{text}");
        let is_error = severities(&text, "undefined-macro").contains(&Severity::Error);
        assert_eq!(is_error, refused, "{text}");
    }
}

/// glslang and Mesa refuse them all.
#[test]
fn operators_that_conditions_lack_are_errors() {
    let driver = open();
    for condition in ["1 ? 1 : 0", "1 ^^ 0", "1, 0", "float(1)", "IS(1)", "A[0]", "A.x", "1.0"] {
        let text = shader("330", "", condition);
        assert!(!glslang::accepts(&text, "frag"), "{condition}");
        drawn(&driver, &text).expect_err(condition);
        let shader = read(&text, None);
        assert!(shader.has_errors() && codes(&shader).contains(&"condition"), "{condition}");
    }
}
