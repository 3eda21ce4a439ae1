use super::*;
use crate::naga_front::code::joined;
use crate::naga_front::{glsl_module, wgsl_module};
use crate::source::Stage;

#[test]
fn text_that_naga_could_overflow_on_is_not_handed_to_it() {
    for text in ["(".repeat(10_000), "-".repeat(10_000), "array<".repeat(10_000)] {
        assert!(wgsl_module(&format!("const x = {text}")).is_none());
    }
    assert_eq!(nesting(&code("a < b; c < d; e < f;", Language::Wgsl)), 1);
    let mut nested = "struct S0 { float a; };".to_string();
    for i in 1..40 {
        nested += &format!("struct S{i} {{ S{0} a; S{0} b; }};", i - 1);
    }
    assert!(glsl_module(&nested, None).is_none());
    let function = format!("fn f() {{ var x = u.y; {} }}", "x = x + u.y;".repeat(3_900));
    let twice = function.repeat(2);
    assert_eq!(squared_words(&code(&twice, Language::Wgsl)), 2 * (5 + 4 * 3_900u64).pow(2));
    assert!(wgsl_module(&format!("var<private> u: vec2f; {function}")).is_some());
    let longer = function.replace("x + u.y;", "x + u.y + u.y + u.y;");
    let longer = format!("var<private> u: vec2f; {longer}");
    assert!(wgsl_module(&longer).is_none());
    let said = "has a function of 31205 words, or several of as much work, more than the 16000 \
                that naga is given";
    assert_eq!(excess(&longer, Language::Wgsl).as_deref(), Some(said));
    for line in ["\\\n", "\\\r\n"] {
        let continued = format!("{}void main() {{}}", line.repeat(400_000));
        assert!(glsl_module(&continued, Some(Stage::Fragment)).is_none());
    }
    let structures =
        code("struct A { float x; float y; }; struct B { A a; A b[2]; };", Language::Glsl);
    assert_eq!(nested_members(&structures), 15);
}

/// Signs of every kind that counts, more of each than any limit allows.
fn banners() -> Vec<String> {
    let signs = ["-", "*", "~", "!", "(", "{", "<", "=", "& ", "fn ", "; ", "struct S { S S "];
    signs.iter().map(|sign| sign.repeat(20_000)).collect()
}

#[test]
fn comments_count_nothing() {
    let wgsl = "struct A { x: vec4f }\n@group(0) @binding(0) var<uniform> a: A;\n\
                @fragment fn main() -> @location(0) vec4f { return a.x; }\n";
    let glsl = "#version 450\nlayout(std140, binding = 0) uniform A { vec4 x; };\n\
                layout(location = 0) out vec4 c;\nvoid main() { c = x; }\n";
    for row in banners() {
        for (open, close) in [("//", "\n"), ("/*", "*/"), ("/* /*", "*/ */"), ("/*\n", "\n*/")] {
            let text = format!("{open}{row}{close}{wgsl}{open}{row}{close}");
            assert_eq!(excess(&text, Language::Wgsl), None, "{open}{}", &row[..2]);
            assert!(wgsl_module(&text).is_some(), "{open}{}", &row[..2]);
        }
        let around = [
            ("//", "\n"),
            ("/*", "*/"),
            ("//\\\n", "\n"),
            ("#if 0\n", "\n#endif\n"),
            ("#if 0\n#if 1\n", "\n#endif\n#elif 0\n#endif\n"),
            ("#ifdef ABSENT\n#error ", "\n#endif\n"),
        ];
        for (open, close) in around {
            let text = format!("{glsl}{open}{row}{close}");
            assert_eq!(excess(&text, Language::Glsl), None, "{open}{}", &row[..2]);
            assert!(glsl_module(&text, Some(Stage::Fragment)).is_some(), "{open}{}", &row[..2]);
        }
    }
}

#[test]
fn code_beside_comments_counts() {
    let deep = "(".repeat(100);
    for text in ["/* /* */ DEEP", "// a \\\r\n b\nDEEP", "/\\\n* // */ DEEP", "#if 0\n#else\nDEEP"]
    {
        let text = text.replace("DEEP", &deep);
        let text = joined(&text, Language::Glsl);
        assert!(excess(&text, Language::Glsl).is_some(), "{text}");
    }
    for text in ["/* /* */ */ DEEP", "// a \\\nDEEP", "//\u{2028}DEEP", "# if 0\nDEEP"] {
        assert!(excess(&text.replace("DEEP", &deep), Language::Wgsl).is_some(), "{text}");
    }
    let defined = format!("#define DEEP \\\n {deep}\n");
    assert!(excess(&defined, Language::Glsl).is_some());
}
