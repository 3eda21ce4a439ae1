//! What a function is given: what it reads, and nothing that is only declared beside it.

use landfall_layout::Source;

use super::{request, run};

const SHADER: &str = "#version 450
struct Light { vec3 position; float power; };
layout(std140, binding = 0) uniform Scene {
    vec4 unread; Light key; Light fill; float shininess; int count; mat4 view;
} scene;
layout(std140, binding = 1) uniform Other { float unread; } other;
layout(location = 0) out vec4 color;
float powered(Light light) { return light.power; }
float shiny(float x) { return x * scene.shininess; }
float direct(float x) { return shiny(x) + scene.key.power; }
float passed(float x) { return x * powered(scene.fill); }
float copied(float x) { Light own = scene.key; return x * own.position.y; }
float counted(float x) { float s = x; for (int i = 0; i < scene.count && i < 4; i++) { s += x; } return s; }
float column(int i) { return scene.view[i & 3].x; }
void main() {
    color = vec4(direct(1.0), passed(1.0), copied(other.unread), counted(1.0) + column(1) + scene.unread.x);
}
";

#[test]
fn only_what_a_function_reads_is_an_input() {
    let mut findings = 0;
    for (function, expected) in [
        ("shiny", &["x", "scene.shininess"][..]),
        ("direct", &["x", "scene.key.position", "scene.key.power", "scene.shininess"]),
        ("passed", &["x", "scene.fill.position", "scene.fill.power"]),
        ("copied", &["x", "scene.key.position", "scene.key.power"]),
        ("counted", &["x", "scene.count"]),
        ("column", &["i", "scene.view"]),
    ] {
        let source = Source::new("inputs.frag", SHADER);
        let mut request = request(function);
        request.samples = 600;
        let report = run(&source, &request);
        let paths: Vec<&str> = report.inputs.iter().map(|(input, _)| input.path.as_str()).collect();
        assert_eq!(paths, expected, "{function}");
        // What is not read is zero in what repeats a finding, and so not in the command.
        findings += report.findings.len();
        for found in &report.findings {
            let command = found.case.arguments.join(" ");
            assert!(!command.contains("unread"), "{function}: {command}");
        }
    }
    assert!(findings > 0, "products overflow");
}
