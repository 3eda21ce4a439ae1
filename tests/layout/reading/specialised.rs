//! Blocks with arrays of specialised length: the defaults lay them out, and `-O` moves nothing. The
//! oracle is glslang, whose SPIR-V has the offsets that every pipeline keeps.

use super::{Client, leaves, of_glslang};
use ::landfall::{Options, ShaderLayout, Source, layout};

fn with(text: &str, given: &[(&str, &str)]) -> ShaderLayout {
    let mut options = Options::default();
    options.read.overrides =
        given.iter().map(|(name, value)| (name.to_string(), value.to_string())).collect();
    layout(&Source::new("a.frag", text), &options)
}

/// Declarations and the use of the block, by which glslang keeps it.
const TEXTS: &[(&str, &str)] = &[
    (
        "layout(constant_id = 3) const int COUNT = 6;\n\
         layout(std430, set = 0, binding = 0) buffer B { float a[COUNT]; vec2 b; } u;",
        "u.b.x",
    ),
    (
        "layout(constant_id = 3) const uint COUNT = 2u;\n\
         layout(std140, set = 0, binding = 0) uniform B { vec3 a[COUNT]; float b; mat2 c[COUNT]; \
         float d; } u;",
        "u.d",
    ),
    (
        "layout(constant_id = 3) const int COUNT = 3;\nstruct S { float w[COUNT]; float n; };\n\
         layout(std140, set = 0, binding = 0) uniform B { S s[2]; vec4 b; } u;",
        "u.b.x",
    ),
    (
        "layout(constant_id = 3) const int COUNT = 3;\n\
         layout(push_constant) uniform B { float a[COUNT]; float b; } u;",
        "u.b",
    ),
];

#[test]
fn a_value_for_a_specialisation_constant_moves_no_member() {
    for (declarations, used) in TEXTS {
        let text = format!(
            "#version 450\n{declarations}\nlayout(location = 0) out vec4 o;\n\
             void main() {{ o = vec4({used}); }}\n"
        );
        let theirs = of_glslang(&text, Client::Vulkan);
        for given in [None, Some("1"), Some("2"), Some("10")] {
            for key in ["COUNT", "3"] {
                let set: Vec<_> = given.iter().map(|value| (key, *value)).collect();
                let shader = with(&text, &set);
                assert_eq!(leaves(&shader), theirs, "{text} {given:?}");
                assert_eq!(shader.blocks[0].size, with(&text, &[]).blocks[0].size);
            }
        }
        let wrong = with(&text, &[("COUNT", "many")]);
        assert!(wrong.has_errors(), "a value that is no number stays an error");
    }
}

/// glslang 12 places what follows an array whose length is an expression of specialisation constants
/// behind one element; the expression has a value all the same.
#[test]
fn a_length_that_is_an_expression_has_the_value_of_the_defaults() {
    let declarations = "layout(constant_id = 3) const uint COUNT = 2u;\n\
         const uint MORE = COUNT * 2u + 1u;\n\
         layout(std140, set = 0, binding = 0) uniform B { vec3 a[MORE]; float b; } u;";
    let text = format!(
        "#version 450\n{declarations}\nlayout(location = 0) out vec4 o;\n\
         void main() {{ o = vec4(u.b); }}\n"
    );
    assert_eq!(of_glslang(&text, Client::Vulkan), ["B.a[] 0", "B.b 16"]);
    for given in [&[][..], &[("COUNT", "7")]] {
        // Five elements of 16 bytes.
        assert_eq!(leaves(&with(&text, given)), ["B.a[] 0", "B.b 80"]);
    }
}
