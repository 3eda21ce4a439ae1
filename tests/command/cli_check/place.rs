//! Shaders of these tests, and `landfall check` in the folder of a test.

use serde_json::Value;

use crate::support::command::Place;

/// A shader that no lint finds fault with.
pub const CLEAN: &str = "#version 450
layout(std140, binding = 0) uniform Light {
    vec4 position;
    vec4 color;
} light;
layout(location = 0) out vec4 color;
void main() {
    color = light.position + light.color;
}
";

/// The same with a comment that allows what is not there.
pub fn idle() -> String {
    CLEAN.replace("    vec4 color;", "    vec4 color; // landfall: allow(stale-comment)")
}

impl Place {
    /// `check` with only the lints of these tests, its findings as JSON.
    pub fn check(&self, arguments: &[&str]) -> (i32, Vec<Value>, String) {
        let mut all =
            vec!["check", "-A", "all", "-W", "unused-allow", "-W", "stale-comment", "-f", "json"];
        all.extend(arguments);
        let ran = self.run(&all);
        let report = ran.json();
        (ran.code, report["findings"].as_array().unwrap().clone(), ran.err)
    }

    /// Codes with paths and lines of what is found.
    pub fn found(&self, arguments: &[&str]) -> Vec<String> {
        self.check(arguments).1.iter().map(told).collect()
    }
}

/// `unused-allow a.frag:4`.
pub fn told(finding: &Value) -> String {
    let place = &finding["place"];
    let text = |value: &Value| value.as_str().unwrap().to_string();
    format!("{} {}:{}", text(&finding["code"]), text(&place["path"]), place["line"])
}
