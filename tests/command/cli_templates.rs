//! Templates are refused where they are named, and passed over where a search finds them; missing
//! includes with one fix are one finding.

use crate::support::command::Place;

const SHADER: &str = "#version 450\nlayout(std140, binding = 0) uniform U { vec3 a; };\n\
    layout(location = 0) out vec4 c;\nvoid main() { c = vec4(a, 1.0); }\n";

#[test]
fn a_template_is_refused_where_it_is_named() {
    let place = Place::new("templates-named");
    for (name, text, found) in [
        ("tera.frag", "#version 450\nuniform U { float a[{{ count }}]; };\n", "`{{ count }}`"),
        ("jinja.wgsl", "{% if fog %}\nconst A = 1;\n{% endif %}\n", "`{% if fog %}`"),
        (
            "bars.frag",
            "#version 450\n{{#each lights}}\nuniform vec4 l;\n{{/each}}\n",
            "`{{#each lights}}`",
        ),
        ("js.glsl", "const int N = ${n};\n", "`${n}`"),
    ] {
        place.write(name, text);
        for command in
            [&["layout", name][..], &["check", name], &["emit", "-l", "c", name], &["lock", name]]
        {
            let ran = place.run(command);
            let said = format!("{}{}", ran.out, ran.err);
            assert_eq!(ran.code, 2, "{command:?} {said}");
            assert_eq!(said.matches("error[").count(), 1, "{command:?} {said}");
            assert!(said.contains("is a template: line ") && said.contains(found), "{said}");
        }
    }
}

#[test]
fn a_search_names_templates_once_a_directory() {
    let place = Place::new("templates-searched");
    place.write("a.frag", SHADER);
    for name in ["t/a.frag", "t/b.frag", "t/c.wgsl", "u/d.wgsl"] {
        place.write(name, "struct A { a: array<f32, {{ n }}> }\n");
    }
    let commands = |folder| {
        [
            vec!["layout", folder],
            vec!["check", folder],
            vec!["emit", "-l", "c", folder],
            vec!["lock", folder],
            vec!["verify", "--backend", "cpu", folder],
            vec!["lights", folder],
            vec!["diff", folder, folder],
        ]
    };
    for command in commands(".") {
        let ran = place.run(&command);
        let said = format!("{}{}", ran.out, ran.err);
        assert_eq!(ran.code, 0, "{command:?} {said}");
        assert_eq!(said.matches("warning[other-language]").count(), 2, "{command:?} {said}");
        assert!(said.contains("3 files of `t` are templates"), "{command:?} {said}");
        assert!(said.contains("`u/d.wgsl` is a template"), "{command:?} {said}");
    }
    // Of templates alone there is nothing to do.
    for command in commands("t") {
        let ran = place.run(&command);
        assert_eq!(ran.code, 2, "{command:?} {}{}", ran.out, ran.err);
    }
}

#[test]
fn other_languages_are_refused_unless_the_language_is_given() {
    let place = Place::new("templates-languages");
    place.write("d/a.gdshader", "shader_type spatial;\n").write("d/b.metal", "x");
    let ran = place.run(&["layout", "d"]);
    assert!(ran.code == 2 && ran.err.contains("only Godot's own language, Metal"), "{}", ran.err);
    assert!(ran.err.contains("pass `--language`"), "{}", ran.err);
    assert_eq!(place.run(&["layout", "d/a.gdshader"]).code, 2);
    place.write("e.gdshader", SHADER);
    assert_eq!(place.run(&["layout", "e.gdshader"]).code, 2);
    assert_eq!(place.run(&["layout", "e.gdshader", "--language", "glsl"]).code, 0);
}

#[test]
fn missing_includes_with_one_fix_are_one_finding() {
    let place = Place::new("missing-includes");
    for number in 0..40 {
        let includes: String = (0..10)
            .map(|of| format!("#include \"/lib/part{}.glsl\"\n", (number + of) % 13))
            .collect();
        place.write(
            &format!("pack/world/{number:02}.fsh"),
            format!("#version 330\n{includes}void main() {{}}\n"),
        );
    }
    let ran = place.run(&["check", "pack"]);
    let said = format!("{}{}", ran.out, ran.err);
    assert_eq!(ran.code, 2, "{said}");
    assert_eq!(said.matches("error[missing-include]").count(), 1, "{said}");
    assert!(said.contains("399 more includes in 40 files are not found either"), "{said}");
    let ran = place.run(&["layout", "pack"]);
    assert!(ran.err.matches("error[missing-include]").count() <= 3, "{}", ran.err);
    assert!(ran.err.contains("397 more includes in 40 files are not found either"), "{}", ran.err);
    // Where a folder beside one above has them, it is the fix of all.
    for part in 0..13 {
        place.write(&format!("pack/shaders/lib/part{part}.glsl"), "float part();\n");
    }
    let ran = place.run(&["check", "pack"]);
    let said = format!("{}{}", ran.out, ran.err);
    assert_eq!(said.matches("error[missing-include]").count(), 1, "{said}");
    assert!(said.contains("pass `-I pack/shaders`"), "{said}");
    assert_eq!(place.run(&["check", "pack", "-I", "pack/shaders"]).code, 0);
}
