//! Positions of lights with reduced precision, found in the text because the IR has no precisions.

use landfall_ir::analysis::hazard::Hazard;
use landfall_ir::analysis::occurrence::{Certainty, Occurrence};
use landfall_ir::analysis::roles::{LightBinding, Role};
use landfall_layout::ShaderLayout;
use landfall_layout::source::{Language, Span};

/// Returns the positions of lights that the text declares `mediump` or `lowp`.
pub(super) fn hazards(shader: &ShaderLayout, lights: &[LightBinding<'_>]) -> Vec<Occurrence> {
    if shader.language != Language::Glsl || !is_embedded(shader) {
        return Vec::new();
    }
    let low = lowered_by_default(shader);
    let mut found: Vec<Occurrence> = Vec::new();
    for light in lights {
        let Some(part) = light.roles.part(Role::Position) else { continue };
        let declared = before(shader, part.span);
        // Whole words: `slowpath` contains `lowp`.
        let says = |word: &str| declared.split(|c: char| !c.is_alphanumeric()).any(|w| w == word);
        let lowered = says("mediump") || says("lowp") || (low && !says("highp"));
        // Lights of one structure share its declaration.
        if lowered && !found.iter().any(|known| known.span == part.span) {
            let (hazard, about) = (Hazard::MediumpPosition, light.full_path(part));
            found.push(Occurrence::new(hazard, Certainty::Possible, part.span, about));
        }
    }
    found
}

/// Returns whether precision qualifiers have an effect: in GLSL ES, or in a text for both GLSL and
/// GLSL ES.
fn is_embedded(shader: &ShaderLayout) -> bool {
    let Some(text) = shader.files.get(0).map(|file| &file.text) else { return false };
    let version = text.lines().find_map(|line| line.trim().strip_prefix("#version"));
    match version.map(str::trim) {
        Some(version) => version.ends_with("es") || version.starts_with("100"),
        None => text.contains("GL_ES") || text.contains("precision "),
    }
}

/// Returns whether the default precision of floats is below `highp` in every `#if` branch.
fn lowered_by_default(shader: &ShaderLayout) -> bool {
    let mut lowered = false;
    for file in shader.files.iter() {
        for line in file.text.lines() {
            let mut words = line.split_whitespace();
            if words.next() != Some("precision") {
                continue;
            }
            let precision = words.next();
            if words.next().is_none_or(|ty| ty.trim_end_matches(';') != "float") {
                continue;
            }
            match precision {
                Some("mediump" | "lowp") => lowered = true,
                // The branch with `highp` may be the one that is compiled.
                _ => return false,
            }
        }
    }
    lowered
}

/// Returns the part of a member's declaration before its name.
fn before(shader: &ShaderLayout, span: Span) -> &str {
    let text = shader.files.get(span.file).map_or("", |file| &file.text);
    let head = text.get(..span.start as usize).unwrap_or("");
    // From the end of the declaration before.
    head.rsplit([';', '{']).next().unwrap_or("")
}
