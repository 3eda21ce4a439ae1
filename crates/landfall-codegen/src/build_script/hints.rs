//! Advice of the command, with the methods of [`Build`](super::Build) in place of its options.

/// The advice with each option as the method that does the same. Options that no method stands for
/// stay as they are.
pub(super) fn for_build(text: &str) -> String {
    let mut result = String::with_capacity(text.len());
    for (at, part) in text.split('`').enumerate() {
        if at > 0 {
            result.push('`');
        }
        // Every second part is code.
        match method(part).filter(|_| at % 2 == 1) {
            Some(method) => result.push_str(&method),
            None => result.push_str(part),
        }
    }
    result
}

/// The method for an option with its value.
fn method(code: &str) -> Option<String> {
    let (option, value) = code.split_once(' ').unwrap_or((code, ""));
    let pair = |method: &str, default: &str| match value.split_once('=') {
        Some((name, value)) => format!("Build::{method}({name:?}, {value:?})"),
        None if value.is_empty() => format!("Build::{method}"),
        None => format!("Build::{method}({value:?}, {default:?})"),
    };
    Some(match option {
        "-I" => format!("Build::include({value:?})"),
        "--define" => pair("define", "1"),
        "-O" => pair("specialise", "VALUE"),
        "--rename" => pair("rename", "NAME"),
        "--type" => pair("map_type", "PATH"),
        "--count" => {
            let (name, count) = value.split_once('=').unwrap_or((value, "N"));
            format!("Build::descriptor_count({name:?}, {count})")
        }
        "--program" => {
            let (name, files) = value.split_once('=').unwrap_or((value, "FILE"));
            let files: Vec<&str> = files.split(',').collect();
            format!("Build::program({name:?}, &{files:?})")
        }
        "--gather" => "Build::gather_loose_uniforms()".to_string(),
        "--target" => match value {
            "vulkan" => "Build::target(Target::Vulkan)".to_string(),
            "opengl" => "Build::target(Target::OpenGl)".to_string(),
            _ => return None,
        },
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_become_methods() {
        for (advice, expected) in [
            (
                "pass its directory with `-I DIR`",
                "pass its directory with `Build::include(\"DIR\")`",
            ),
            (
                "define the required macro with `--define NAME` or `--define NAME=VALUE`",
                "define the required macro with `Build::define(\"NAME\", \"1\")` or \
                 `Build::define(\"NAME\", \"VALUE\")`",
            ),
            (
                "`n` has no default: pass `-O n=VALUE`",
                "`n` has no default: pass `Build::specialise(\"n\", \"VALUE\")`",
            ),
            (
                "lay them out as one block with `--gather`",
                "lay them out as one block with `Build::gather_loose_uniforms()`",
            ),
            (
                "pass `--target vulkan` or `--target opengl`",
                "pass `Build::target(Target::Vulkan)` or `Build::target(Target::OpenGl)`",
            ),
            (
                "give it a name: `--rename a.frag:Light=NAME`",
                "give it a name: `Build::rename(\"a.frag:Light\", \"NAME\")`",
            ),
            (
                "give it a name: `--program NAME=a.vert,a.frag`",
                "give it a name: `Build::program(\"NAME\", &[\"a.vert\", \"a.frag\"])`",
            ),
            (
                "give it: `--count textures=N`",
                "give it: `Build::descriptor_count(\"textures\", N)`",
            ),
            (
                "macro `A` keeps its definition from `--define`",
                "macro `A` keeps its definition from `Build::define`",
            ),
            ("declare `vec3 -O a`", "declare `vec3 -O a`"),
        ] {
            assert_eq!(for_build(advice), expected);
        }
    }
}
