//! The OpenGL version of a text, by its `#version` line, and the vertex shader for a lone fragment
//! shader.

use super::context::ContextKind;
use landfall_layout::source::Language;
use landfall_layout::syntax;

/// The version of a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct GlVersion {
    pub(super) number: u32,
    pub(super) es: bool,
    pub(super) compatibility: bool,
}

/// Returns the version of the first `#version` line; GLSL 1.10 if there is none (GLSL 4.60 §3.3).
pub(super) fn version(text: &str) -> GlVersion {
    let mut found = GlVersion { number: 110, es: false, compatibility: false };
    let tokens = syntax::tokens(text, Language::Glsl);
    let Some(at) = tokens.windows(3).position(|three| three[..2] == ["#", "version"]) else {
        return found;
    };
    found.number = tokens[at + 2].parse().unwrap_or(found.number);
    let profile = tokens.get(at + 3).copied().unwrap_or_default();
    // `#version 100` names no profile, and is GLSL ES 1.00.
    found.es = profile == "es" || found.number == 100;
    found.compatibility = profile == "compatibility";
    found
}

impl ContextKind {
    /// Returns the kind of context for a text, by its `#version` line.
    pub fn of_text(text: &str) -> ContextKind {
        let version = version(text);
        if version.es {
            ContextKind::Es
        } else if version.compatibility || version.number < 140 {
            ContextKind::Compat
        } else {
            ContextKind::Core
        }
    }
}

/// The input of [`passing_vertex`], at location 0.
pub(super) const CORNER: &str = "landfall_corner";

/// Returns a vertex shader that passes its input on as the position; it links with a fragment
/// shader of that version that reads no inputs.
pub(super) fn passing_vertex(version: GlVersion) -> String {
    let GlVersion { number, es, .. } = version;
    // Versions of ES cannot be mixed; those of desktop GLSL can, but core profiles begin at 1.40.
    let (line, input) = match (es, number) {
        (true, 100) => ("#version 100".to_string(), "attribute"),
        (true, _) => (format!("#version {number} es"), "in"),
        (false, ..140) => ("#version 110".to_string(), "attribute"),
        (false, _) => ("#version 140".to_string(), "in"),
    };
    format!(
        "{line}\n{input} vec2 {CORNER};\nvoid main() {{ gl_Position = vec4({CORNER}, 0.0, 1.0); }}\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_version_line_names_the_context() {
        for (text, kind) in [
            ("void main() {}", ContextKind::Compat),
            ("#version 110\n", ContextKind::Compat),
            ("// a comment first\n  #  version 330 core\n", ContextKind::Core),
            ("#version 330 compatibility\n", ContextKind::Compat),
            ("#version 450\n#version 100\n", ContextKind::Core),
            ("#version 100\n", ContextKind::Es),
            ("#version 310 es\n", ContextKind::Es),
        ] {
            assert_eq!(ContextKind::of_text(text), kind, "{text}");
        }
    }
}
