//! Arrays whose lengths are specialised, or taken from their uses, before other members.

use super::{found, help, one, said};
use landfall_layout::finding::Finding;
use landfall_layout::{Options, Source, layout};
use landfall_lint::{Check, Settings, Subject, lint};

fn specialised(declarations: &str, given: &[(&str, &str)]) -> Vec<Finding> {
    let text = format!(
        "#version 450\nlayout(constant_id = 3) const int COUNT = 6;\n{declarations}\nvoid main() {{}}\n"
    );
    let source = Source::new("a.frag", text);
    let mut options = Options::default();
    options.read.overrides =
        given.iter().map(|(name, value)| (name.to_string(), value.to_string())).collect();
    let shader = layout(&source, &options);
    assert!(!shader.has_errors(), "{:?}", shader.diagnostics);
    let subject = Subject { source: &source, options: &options, shader: &shader };
    match lint("specialised-length").expect("a lint").check {
        Check::Shader(check) => check(&subject, &Settings::default()),
        _ => panic!("it looks at one shader"),
    }
}

fn block(members: &str) -> String {
    format!("layout(std430, set = 0, binding = 0) buffer B {{ {members} }} b;")
}

#[test]
fn members_behind_an_array_of_specialised_length_are_named_with_their_byte() {
    // std430: 6 * 4 = 24.
    let all = specialised(&block("uint a[COUNT]; float b;"), &[]);
    assert_eq!(all.len(), 1, "{all:?}");
    assert_eq!(
        said(&all[0]),
        "3:54 `b` stays at byte 24 behind `a`, whose length depends on the specialisation of `COUNT`"
    );
    assert_eq!(help(&all[0]), "move `a` to the end of the block");
    let all = specialised(&block("uint a[COUNT]; float b;"), &[("COUNT", "10")]);
    assert_eq!(
        all[0].notes[1],
        "with the 10 elements of `-O`, `a` takes 40 bytes and lies on `b`"
    );
    let all = specialised(&block("uint a[COUNT];"), &[("3", "10")]);
    assert_eq!(
        said(&all[0]),
        "3:54 `a` ends at byte 40 with the 10 elements of `-O`, but its block is laid out for those \
         up to byte 24"
    );
    for members in [
        // The next element is behind it as well.
        "struct S { float w[COUNT]; };\n",
        "struct S { float w[COUNT]; float n; };\n",
    ] {
        let all = specialised(&format!("{members}{}", block("S s[2];")), &[]);
        assert_eq!(all.len(), 1, "{members}: {all:?}");
    }
}

#[test]
fn arrays_of_specialised_length_that_move_nothing_are_not_reported() {
    for (declarations, given) in [
        (block("float b; uint a[COUNT];"), None),
        (block("float b; uint a[COUNT];"), Some("3")),
        (block("uint a[6]; float b;"), None),
        (block("uint a[COUNT]; layout(offset = 512) float b;"), Some("10")),
        (format!("struct S {{ float w[COUNT]; float n; }};\n{}", block("vec4 a;")), None),
        (block("vec4 a;").replace("set = 0", "set = COUNT - 6"), None),
    ] {
        let given: Vec<_> = given.iter().map(|value| ("COUNT", *value)).collect();
        assert_eq!(specialised(&declarations, &given), [], "{declarations}");
    }
}

/// The offsets are those of glslang 12 and of Mesa, which `by_use` reads.
#[test]
fn members_behind_an_array_without_a_length_are_elsewhere_in_glslangs_spirv() {
    let text = "#version 450\nlayout(local_size_x = 1) in;\n\
                layout(set = 0, binding = 0, std430) buffer C {\n    vec3 a[]; float b[]; vec4 c;\n} u;\n\
                void main() { u.c = vec4(u.a[2], u.b[4]); }\n";
    let finding = one("length-from-use", "a.comp", text);
    assert_eq!(
        said(&finding),
        "4:21 `b` is at byte 48, but glslang writes 16 into SPIR-V: `a` has no length of its own"
    );
    assert_eq!(help(&finding), "write `a[3]`");
    // One element is what glslang counts, and the last of a `buffer` has no length.
    for uses in ["u.c = vec4(u.a[0], u.b[0]);", ""] {
        let text = text.replace("u.c = vec4(u.a[2], u.b[4]);", uses);
        if uses.is_empty() {
            continue;
        }
        assert_eq!(found("length-from-use", "a.comp", &text), [], "{uses}");
    }
    let last = text.replace("vec4 c;", "vec4 c[];").replace("u.c =", "u.c[7] =");
    assert_eq!(found("length-from-use", "a.comp", &last).len(), 1, "{last}");
    let sized = text.replace("a[]", "a[3]").replace("b[]", "b[5]");
    assert_eq!(found("length-from-use", "a.comp", &sized), []);
}
