//! `landfall` alone in a folder.

use snapbox::str;

use crate::support::command::Place;

const LIGHT: &str = "#version 450
layout(std140, binding = 0) uniform Light { vec3 pos; float power; } light;
layout(location = 0) out vec4 color;
void main() { color = vec4(light.pos, light.power); }
";

#[test]
fn a_folder_is_described_with_what_to_do_next() {
    let tree = Place::new("overview");
    tree.write("s/a.frag", LIGHT).write("s/b.frag", LIGHT);
    tree.write("s/c.wgsl", "@group(0) @binding(1) var<uniform> scale: vec4f;\n");
    tree.run(&[]).code(0).stderr_eq("").stdout_eq(str![[r#"
3 shaders: 2 GLSL, 1 WGSL
no layouts are locked
no findings

landfall lock         records the layouts, so that `check` tells when one changes
landfall layout PATH  prints the bytes of every block

"#]]);
    assert_eq!(tree.run(&["lock", "s/a.frag"]).code, 0);
    // The findings are those of `check`: one for each shader without a lock, now that there are locks.
    tree.run(&[]).code(0).stdout_eq(str![[r#"
3 shaders: 2 GLSL, 1 WGSL
the layouts of 1 are locked, those of 2 not
2 warnings

landfall check        lists the findings, each with what to do
landfall layout PATH  prints the bytes of every block

"#]]);
    assert!(tree.run(&["check"]).err.starts_with("checked 3 shaders: 2 warnings"));
    assert_eq!(tree.run(&["lock"]).code, 0);
    tree.run(&[]).code(0).stdout_eq(str![[r#"
3 shaders: 2 GLSL, 1 WGSL
all layouts are locked
no findings

landfall layout PATH  prints the bytes of every block
landfall --help       lists all commands

"#]]);
}

#[test]
fn the_configuration_chooses_what_is_described() {
    let tree = Place::new("overview-configured");
    tree.write("landfall.toml", "paths = [\"s\"]\nexclude = [\"old\"]\n");
    tree.write("s/a.frag", LIGHT).write("s/old/b.frag", LIGHT).write("t/c.frag", LIGHT);
    assert!(tree.run(&[]).out.starts_with("1 shader: 1 GLSL\n"));
    // What a baseline permits is no finding.
    assert_eq!(tree.run(&["lock"]).code, 0);
    tree.write("s/a.frag", LIGHT.replace("vec3 pos;", "vec4 pos;"));
    assert_eq!(tree.run(&["check", "--write-baseline"]).code, 0);
    let with = |baseline: &str| {
        let text = format!("{baseline}paths = [\"s\"]\nexclude = [\"old\"]\n");
        tree.write("landfall.toml", text);
        tree.run(&[]).out.lines().nth(2).map(String::from)
    };
    assert_eq!(with("").as_deref(), Some("1 error"));
    assert_eq!(with("baseline = \"landfall-baseline.json\"\n").as_deref(), Some("no findings"));
    tree.write("landfall.toml", "paths = 3\n");
    let ran = tree.run(&[]);
    assert!(ran.code == 2 && ran.err.starts_with("error[wrong-type]"), "{}", ran.err);
}

#[test]
fn without_shaders_there_is_help() {
    let tree = Place::new("overview-empty");
    tree.write("main.rs", "fn main() {}\n");
    let ran = tree.run(&[]);
    assert!(ran.code == 2 && ran.out.is_empty(), "{}", ran.out);
    assert!(ran.err.contains("Usage: landfall [OPTIONS] <COMMAND>"), "{}", ran.err);
}
