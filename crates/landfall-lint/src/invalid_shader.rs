//! `invalid-shader`: what no compiler takes in the functions of a shader whose blocks can be laid
//! out.

use super::definition::{Check, Lint, Subject};
use super::settings::Settings;
use landfall_layout::finding::{Finding, Level};
use landfall_layout::syntax::{BodyErrors, body_errors};
use landfall_layout::{Diagnostic, Options, Severity, Source, linked};

pub(super) const LINT: Lint = Lint {
    code: "invalid-shader",
    level: Level::Deny,
    what: "a shader that no compiler takes, though its blocks can be laid out: a syntax error in a \
           function, a name or member that is not declared, a reserved word as a name",
    why: "The layout of its blocks does not depend on the functions, so it would be computed and \
          locked, and the program would learn of the error when it creates the shader. The default \
          build reads names and syntax; with the feature `analysis`, WGSL is also given to naga, \
          which knows types and functions. In a file without an entry point only reserved words \
          are looked for: what it uses may be declared by those that include it.",
    example: "#version 450\n\
              layout(std140, binding = 0) uniform Light { float range; } light;\n\
              layout(location = 0) out vec4 color;\n\
              void main() { color = vec4(light.rnage); }\n",
    fix: "Correct the name, or what the message names.",
    check: Check::Shader(check),
};

fn check(subject: &Subject<'_>, _: &Settings) -> Vec<Finding> {
    let errors = function_errors(subject.source, subject.options);
    errors.into_iter().map(|error| finding(subject, error)).collect()
}

/// Returns what no compiler takes in the functions of a shader, whichever of them are used.
pub fn function_errors(source: &Source, options: &Options) -> Vec<Diagnostic> {
    let source = &*linked(source, &options.read);
    // What its functions use is not known.
    if source.lacks_imports() {
        return Vec::new();
    }
    let BodyErrors { mut errors, has_entry_point } = body_errors(source, &options.read);
    // naga would repeat the errors that were found, and judges whole shaders only.
    if has_entry_point && errors.is_empty() {
        errors.extend(by_compiler(source));
    }
    errors
}

/// What naga refuses; it is one compiler of WGSL, and Landfall has its own front end for GLSL.
#[cfg(feature = "analysis")]
fn by_compiler(source: &Source) -> Option<Diagnostic> {
    use landfall_layout::source::Language;
    match source.language {
        Language::Wgsl => landfall_layout::naga_front::wgsl_error(&source.text),
        Language::Glsl | Language::SpirV => None,
    }
}

#[cfg(not(feature = "analysis"))]
fn by_compiler(_: &Source) -> Option<Diagnostic> {
    None
}

fn finding(subject: &Subject<'_>, error: Diagnostic) -> Finding {
    let mut finding = error.located(&subject.shader.files);
    finding.labels[0].text.clear();
    let about = subject.shader.path.to_string();
    Finding { code: LINT.code.to_string(), severity: Severity::Warning, about, ..finding }
}
