//! Warnings about a build that generates nothing, and macros that change nothing.

use super::Build;
use landfall_layout::ShaderLayout;
use landfall_layout::diagnostic::{Code, Diagnostic, Severity};

/// The warnings about a build without shaders, and about macros that none of them contains.
pub(super) fn warnings(build: &Build, layouts: &[ShaderLayout]) -> Vec<Diagnostic> {
    let warn = |message| Diagnostic::without_place(Code::UnusedOption, Severity::Warning, message);
    if build.shaders.is_empty() {
        let message = "there is no shader to generate anything from";
        return vec![warn(message.to_string()).with_help("name each with `Build::shader(PATH)`")];
    }
    // What could not be read may contain any name.
    if layouts.len() < build.shaders.len() {
        return Vec::new();
    }
    let mut found = Vec::new();
    for (name, _) in &build.options.read.defines {
        let has_name = |text: &str| {
            text.split(|c: char| c != '_' && !c.is_alphanumeric()).any(|word| word == name)
        };
        // Macros are files, too: `-D NAME`.
        let files = layouts.iter().flat_map(|shader| shader.files.iter());
        let mut files = files.filter(|file| !file.path.starts_with("-D "));
        if !files.any(|file| has_name(&file.text)) {
            let what = "has no effect: no shader contains this name";
            found.push(warn(format!("`Build::define({name:?}, …)` {what}")));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use landfall_layout::{Source, layout};

    #[test]
    fn a_build_without_shaders_and_macros_of_no_shader_are_said() {
        let said = |build: &Build, texts: &[&str]| -> Vec<String> {
            let shader = |text: &&str| layout(&Source::new("a.frag", *text), &build.options);
            let layouts: Vec<ShaderLayout> = texts.iter().map(shader).collect();
            warnings(build, &layouts).into_iter().map(|found| found.message).collect()
        };
        let none = Build::new().define("LIGHTS", "4");
        assert_eq!(said(&none, &[]), ["there is no shader to generate anything from"]);
        let text = "#version 330 core\n#if LIGHTS > 2\n#endif\nvoid main() {}\n";
        let one = none.shader("a.frag").define("LIGHT", "1");
        assert_eq!(
            said(&one, &[text]),
            ["`Build::define(\"LIGHT\", …)` has no effect: no shader contains this name"]
        );
        assert_eq!(said(&one, &[]), [""; 0], "one that cannot be read may contain it");
    }
}
