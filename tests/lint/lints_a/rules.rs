//! `rules-undeclared`.

use landfall_layout::{Options, Source};
use landfall_lint::settings::Target;

use super::{edited, found, found_in, messages, only, place, with_targets};

const CODE: &str = "rules-undeclared";

fn frag(declaration: &str) -> String {
    format!("#version 330 core\n{declaration}\nout vec4 o;\nvoid main() {{ o = vec4(0.0); }}\n")
}

#[test]
fn a_block_without_rules_is_told_where_its_name_is() {
    let text = frag("uniform Light { vec3 color; } u_light;");
    let finding = only(found_in(CODE, "a.frag", &text));
    assert_eq!(
        finding.message,
        "block `Light` declares no layout rules: the driver chooses its offsets"
    );
    assert_eq!(place(&finding), "2:9");
    assert_eq!(finding.help.as_deref(), Some("write `layout(std140) uniform Light`"));
    let good = edited(&text, std::slice::from_ref(&finding));
    assert!(good.contains("\nlayout(std140) uniform Light {"), "{good}");
    assert_eq!(messages(&found_in(CODE, "a.frag", &good)), [""; 0]);
}

#[test]
fn the_edit_declares_the_rules_wherever_the_block_stands() {
    for (declaration, good) in [
        ("layout(binding = 0) uniform A { vec3 a; };", "layout(std140, binding = 0) uniform A"),
        ("layout ( row_major ) uniform A { mat3 a; } x;", "layout (std140,  row_major ) uniform A"),
        ("// a comment; uniform\nuniform A { vec3 a; };", "uniform\nlayout(std140) uniform A"),
        ("/* c */ uniform A { vec3 a; };", "/* c */ layout(std140) uniform A"),
        ("in vec3 x; uniform A { vec3 a; };", "in vec3 x; layout(std140) uniform A"),
        ("uniform\nA\n{ vec3 a; };", "layout(std140) uniform\nA"),
        (
            "layout(binding = 1) readonly buffer A { vec3 a; };",
            "layout(std430, binding = 1) readonly",
        ),
        ("coherent buffer A { vec3 a; };", "coherent layout(std430) buffer A"),
        ("#define X 1\nuniform A { vec3 a; };", "X 1\nlayout(std140) uniform A"),
    ] {
        let text = frag(declaration).replace("330 core", "430 core");
        let finding = only(found_in(CODE, "a.frag", &text));
        let mended = edited(&text, &[finding]);
        assert!(mended.contains(good), "{mended}");
        let shader =
            landfall_layout::layout(&Source::new("a.frag", mended.as_str()), &Options::default());
        assert!(shader.diagnostics.is_empty() && shader.blocks[0].rules_declared, "{mended}");
    }
}

#[test]
fn what_the_author_chose_is_not_edited() {
    for word in ["shared", "packed"] {
        let text = frag(&format!("layout({word}) uniform A {{ vec3 a; }} x;"));
        let finding = only(found_in(CODE, "a.frag", &text));
        assert!(finding.message.contains(&format!("`{word}`")), "{}", finding.message);
        assert!(finding.fix.is_empty());
    }
}

#[test]
fn declared_blocks_loose_uniforms_and_vulkan_are_let_be() {
    for good in [
        "layout(std140) uniform A { vec3 a; };",
        "layout(std140) uniform; uniform A { vec3 a; };",
        "uniform vec3 a; uniform mat4 b[3];",
        "uniform sampler2D t;",
    ] {
        assert_eq!(messages(&found_in(CODE, "a.frag", &frag(good))), [""; 0], "{good}");
    }
    let gathered = Options::default().with_gather(true);
    let source = Source::new("a.frag", frag("uniform vec3 a;"));
    let shader = landfall_layout::layout(&source, &gathered);
    let subject = landfall_lint::Subject { source: &source, options: &gathered, shader: &shader };
    let landfall_lint::Check::Shader(check) = landfall_lint::lint(CODE).unwrap().check else {
        panic!("it looks at one shader");
    };
    assert_eq!(shader.blocks.len(), 1);
    assert!(check(&subject, &Default::default()).is_empty());
    let vulkan =
        "#version 450\nlayout(set = 0, binding = 0) uniform A { vec3 a; } x;\nvoid main() { }";
    assert_eq!(messages(&found_in(CODE, "a.frag", vulkan)), [""; 0]);
}

#[test]
fn a_text_that_could_be_vulkans_is_asked_for_only_by_target() {
    let text = "#version 450\nlayout(binding = 0) uniform A { vec3 a; } x;\nvoid main() { }";
    assert_eq!(messages(&found_in(CODE, "a.frag", text)), [""; 0]);
    let told = found(CODE, &[("a.frag", text)], &with_targets(&[Target::Gl33]));
    assert_eq!(told.len(), 1);
    let only_gl = "#version 450\nlayout(binding = 0) uniform A { vec3 a; } x;\nuniform float t;\nvoid main() { }";
    assert_eq!(found_in(CODE, "a.frag", only_gl).len(), 1);
    let vulkan = found(CODE, &[("a.frag", only_gl)], &with_targets(&[Target::Vulkan]));
    assert_eq!(messages(&vulkan), [""; 0]);
}
