//! Compiles a ported shader with the `glslangValidator` on the path, if there is one.

use std::io::ErrorKind;
use std::path::Path;
use std::process::Command;

use landfall_layout::Source;
use landfall_layout::source::Stage;
use landfall_port::Ported;

use crate::args::PortArgs;
use crate::child::{self, Ended, ProcessLimits};

/// The compiler, and the option of `port` that leaves it out.
pub const NAME: &str = "glslangValidator";

/// The most memory of the compiler, in bytes.
const MEMORY: u64 = 4 << 30;

/// Lets glslang read `#include`, which the programs that load such shaders expand themselves.
const INCLUDES: &str = "#extension GL_GOOGLE_include_directive : enable";

#[derive(Debug, PartialEq, Eq)]
pub enum Verdict {
    Accepted,
    /// There is none, or none for this stage.
    NotCompiled,
    /// The first error, and the line of the original shader it is at.
    Refused {
        message: String,
        line: Option<u32>,
    },
    /// It ran past its limit of time.
    Late,
    Failed(String),
}

/// Compiles a ported GLSL shader; nothing is written.
pub fn verdict(original: &Source, ported: &Ported, args: &PortArgs) -> Verdict {
    let Some(stage) = ported.source.stage.and_then(stage_name) else { return Verdict::NotCompiled };
    let (text, inserted) = with_includes(&ported.source.text);
    let mut command = Command::new(NAME);
    let null = if cfg!(windows) { "NUL" } else { "/dev/null" };
    // `-V` makes it check the rules of Vulkan; the SPIR-V that it makes is discarded.
    command.args(["--stdin", "-S", stage, "-V", "--target-env", "vulkan1.2", "-o", null]);
    // Includes are looked for beside the original, then in the directories of `-I`, as landfall
    // does.
    let folder = Path::new(&*original.path).parent().filter(|dir| !dir.as_os_str().is_empty());
    let folder = folder.unwrap_or(Path::new("."));
    for dir in std::iter::once(folder).chain(args.read.text.include_dirs.iter().map(|dir| &**dir)) {
        command.arg(format!("-I{}", dir.display()));
    }
    for (name, value) in &args.read.defines {
        command.arg(format!("-D{name}={value}"));
    }
    let limits = ProcessLimits { time: args.limit, memory: MEMORY };
    let output = match child::limited(&mut command, text.clone().into_bytes(), &limits) {
        Ok(Ended::Itself(output)) => output,
        Ok(Ended::Late) => return Verdict::Late,
        Ok(Ended::Interrupted) => return Verdict::Failed("interrupted".to_string()),
        // That it is not installed is no failure: the shader is just not checked.
        Err(error) if error.kind() == ErrorKind::NotFound => return Verdict::NotCompiled,
        Err(error) => return Verdict::Failed(error.to_string()),
    };
    let said = String::from_utf8_lossy(&output.stdout);
    let mut errors = said.lines().filter_map(|line| line.strip_prefix("ERROR: "));
    // 2 is an error in the text, 3 one of linking, as if the text were a whole program.
    match output.status.code() {
        Some(0) => Verdict::Accepted,
        // A file of functions to include has no `main`, which is no fault of it.
        Some(3) if said.contains("Missing entry point") => Verdict::Accepted,
        Some(2 | 3) => {
            let (message, line) = located(errors.next().unwrap_or("no reason given"));
            // With `#line` in the text, the numbers of the compiler are not those of the lines;
            // then no line is told.
            let has_lines = text.lines().any(|line| line.trim_start().starts_with("#line"));
            // The inserted line moves those after it by one.
            let line = line.filter(|_| !has_lines).map(|line| line - u32::from(line > inserted));
            let line = line.and_then(|line| ported.lines.get(line as usize - 1));
            Verdict::Refused { message, line: line.copied() }
        }
        _ => Verdict::Failed(output.status.to_string()),
    }
}

/// The name of a stage, if glslang compiles it for Vulkan 1.2.
fn stage_name(stage: Stage) -> Option<&'static str> {
    Some(match stage {
        Stage::Vertex => "vert",
        Stage::TessellationControl => "tesc",
        Stage::TessellationEvaluation => "tese",
        Stage::Geometry => "geom",
        Stage::Fragment => "frag",
        Stage::Compute => "comp",
        Stage::Task => "task",
        Stage::Mesh => "mesh",
        Stage::RayGeneration => "rgen",
        Stage::Intersection => "rint",
        Stage::AnyHit => "rahit",
        Stage::ClosestHit => "rchit",
        Stage::Miss => "rmiss",
        Stage::Callable => "rcall",
        _ => return None,
    })
}

/// The text with [`INCLUDES`] after `#version` if it needs it, and the number of the line before
/// that; `u32::MAX` if nothing was inserted.
fn with_includes(text: &str) -> (String, u32) {
    let directive = |line: &str, name: &str| {
        let rest = line.trim_start().strip_prefix('#').map(str::trim_start);
        rest.is_some_and(|rest| rest.starts_with(name))
    };
    let version = text.lines().position(|line| directive(line, "version"));
    let Some(version) = version.filter(|_| text.lines().any(|line| directive(line, "include")))
    else {
        return (text.to_string(), u32::MAX);
    };
    let mut lines: Vec<&str> = text.lines().collect();
    lines.insert(version + 1, INCLUDES);
    (lines.join("\n") + "\n", version as u32 + 1)
}

/// Splits `stdin:12: 'x' : undeclared identifier` into message and line.
fn located(error: &str) -> (String, Option<u32>) {
    let rest = error.strip_prefix("stdin:").or_else(|| error.strip_prefix("0:"));
    let split = rest.and_then(|rest| rest.split_once(": "));
    let numbered = split.and_then(|(line, text)| Some((text, line.parse::<u32>().ok()?)));
    let (message, line) = match numbered.filter(|(_, line)| *line > 0) {
        Some((message, line)) => (message, Some(line)),
        None => (error, None),
    };
    (message.trim().replace("  ", " "), line)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_is_split_from_its_line() {
        for (said, expected) in [
            ("stdin:12: 'x' : undeclared identifier ", ("'x' : undeclared identifier", Some(12))),
            (
                "./x.glsl:1: 'u' : undeclared identifier",
                ("./x.glsl:1: 'u' : undeclared identifier", None),
            ),
            ("0:3: '' : syntax error", ("'' : syntax error", Some(3))),
        ] {
            assert_eq!(located(said), (expected.0.to_string(), expected.1));
        }
    }
}
