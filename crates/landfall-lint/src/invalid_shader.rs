//! `invalid-shader`: what no compiler takes in the functions of a shader whose blocks can be laid
//! out.

use super::definition::{Check, Lint, Subject};
use landfall_layout::finding::{Finding, Level};
use landfall_layout::syntax::{BodyErrors, body_errors};
use landfall_layout::{Diagnostic, Options, Severity, Source, linked};
#[cfg(feature = "analysis")]
use landfall_layout::{Language, naga_front};

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
    check: Check::Functions,
};

/// The functions of a shader, read once for all lints of them.
#[derive(Default)]
pub(crate) struct Functions {
    /// What no compiler takes in them, whichever of them are used.
    pub errors: Vec<Diagnostic>,
    /// naga's module of a WGSL text, where naga was asked for errors and has none.
    #[cfg(feature = "analysis")]
    pub module: Option<naga_front::Module>,
}

impl Functions {
    pub fn read(source: &Source, options: &Options) -> Functions {
        let source = &*linked(source, &options.read);
        // What its functions use is not known.
        if source.lacks_imports() {
            return Functions::default();
        }
        by_compiler(source, body_errors(source, &options.read))
    }

    pub fn findings(&self, subject: &Subject<'_>) -> Vec<Finding> {
        self.errors.iter().map(|error| finding(subject, error)).collect()
    }
}

// naga is one compiler of WGSL; GLSL has Landfall's own front end. It would repeat the errors that
// were found, and judges whole shaders only.
#[cfg(feature = "analysis")]
fn by_compiler(source: &Source, read: BodyErrors) -> Functions {
    let mut functions = Functions { errors: read.errors, module: None };
    if source.language == Language::Wgsl && read.has_entry_point && functions.errors.is_empty() {
        match naga_front::checked_wgsl(&source.text) {
            Ok(module) => functions.module = module,
            Err(error) => functions.errors.push(error),
        }
    }
    functions
}

#[cfg(not(feature = "analysis"))]
fn by_compiler(_: &Source, read: BodyErrors) -> Functions {
    Functions { errors: read.errors }
}

/// Returns what no compiler takes in the functions of a shader, whichever of them are used.
pub fn function_errors(source: &Source, options: &Options) -> Vec<Diagnostic> {
    Functions::read(source, options).errors
}

fn finding(subject: &Subject<'_>, error: &Diagnostic) -> Finding {
    let mut finding = error.located(&subject.shader.files);
    finding.labels[0].text.clear();
    let about = subject.shader.path.to_string();
    Finding { code: LINT.code.to_string(), severity: Severity::Warning, about, ..finding }
}
